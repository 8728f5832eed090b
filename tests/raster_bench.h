/* SPDX-License-Identifier: MIT */
/** Lists by conservative rasterisation for tests: built from lights and a view that the test makes up, and read back with all that is behind. */
#ifndef FNL_TESTS_RASTER_BENCH_H
#define FNL_TESTS_RASTER_BENCH_H

#include "passes/lights/raster.h"
#include "tests/list_bench.h"

struct raster_request {
    struct gpu_view view;
    const struct list_light *lights;
    uint32_t light_count;
    struct raster_params raster;
    const struct gpu_raster_mesh *meshes; /* or NULL */
    const vec3 *points;
    uint32_t point_count;
};

struct raster_copy {
    struct list_copy list; /* linked lists walked into arrays */
    uint32_t *words;       /* the pool as it is */
    uint32_t word_count, *heads;
    struct gpu_raster_light *rectangles;
    struct gpu_raster_slot *slots;
    uint32_t *slot_sums, *visible;
    uint64_t byte_count;
    uint32_t kind;
};

/** Tiles of 32 pixels, everything else by default. */
struct raster_request raster_request_of(const struct gpu_view *view, const struct list_light *lights, uint32_t light_count);
struct raster_copy raster_build(const struct raster_request *request);
void raster_copy_free(struct raster_copy *copy);

#endif
