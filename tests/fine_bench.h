/* SPDX-License-Identifier: MIT */
/** What the tests of fine-pruned tiles share: lists built on the device and read back, and the lights' volumes in double precision. */
#ifndef FNL_TESTS_FINE_BENCH_H
#define FNL_TESTS_FINE_BENCH_H

#include "passes/lights/fine.h"
#include "tests/list_bench.h"

enum { FINE_LIGHTS_MAX = 6000, FINE_WIDTH = 109, FINE_HEIGHT = 61 };

/** The lights at hand: those of fine_random_lights, or what a test puts there. */
extern fnl_light_params params[FINE_LIGHTS_MAX];
extern struct list_light lights[FINE_LIGHTS_MAX];
/** light_input.kinds of what is built: lights, unless a test says more. */
extern uint32_t fine_kinds;

enum { COPY_CELLS, COPY_IDS, COPY_EXTRA, COPY_BOXES, COPY_VISIBLE, COPY_TOTALS, COPY_COUNT };

struct fine_copy {
    void *data[COPY_COUNT];
    uint64_t sizes[COPY_COUNT];
    struct light_totals totals;
    uint32_t tile_size, tiles_x, tiles_y, cell_count, mask_size;
};

/** Called by fine_build() before a graph runs, unless NULL. */
extern void (*fine_spoil)(const struct graph *graph);

/** `front`: depth of blended surfaces, or NULL. */
struct fine_copy fine_build(const struct gpu_view *view, uint32_t light_count, const float *depth, const float *front,
                            const struct fine_params *given);
void fine_copy_free(struct fine_copy *copy);
struct gpu_cell fine_cell_at(const struct fine_copy *c, uint32_t cell);
const uint32_t *fine_ids_at(const struct fine_copy *c, uint32_t cell);
struct list_copy fine_list_of(const struct fine_copy *c);
bool fine_holds(const struct fine_copy *c, uint32_t cell, uint32_t light);
/** Whether a pixel visits entry `entry` of its cell, as shaders/lights/fine.glsl finds it. */
bool fine_visits(const struct fine_copy *c, uint32_t cell, uint32_t x, uint32_t y, uint32_t entry);
void fine_check_form(const struct fine_copy *c, uint32_t light_count);
bool fine_is_equal(const struct fine_copy *a, const struct fine_copy *b, const struct gpu_view *view);
/**
 * The lists of opaque surfaces: a tile holds each light that reaches one of its pixels, and none that comes near to none; a pixel's mask
 * the same. Returns the pairs of pixel and light that are lit.
 */
uint64_t fine_check_sets(const struct gpu_view *view, const float *depth, uint32_t light_count, const struct fine_copy *c);
/** Lights of all five shapes before and around the viewer. */
void fine_random_lights(const struct gpu_view *view, struct random_state *random, uint32_t count);
/** A point light as number `index` of them, at pixel (x, y) and a depth in view space. */
void fine_place(const struct gpu_view *view, uint32_t index, double x, double y, double view_depth, float range, bool spot);

#endif
