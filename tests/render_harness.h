/* SPDX-License-Identifier: MIT */
/**
 * Whole frames for tests. One device with validation and synchronisation validation serves all tests of a program (its
 * pipelines are made once); a stage is a scene with a renderer and the frame to start from; a shot is what came out.
 *
 *     const struct CMUnitTest tests[] = {cmocka_unit_test_teardown(test_thing, harness_check)};
 *     return cmocka_run_group_tests(tests, harness_begin, harness_end);
 *
 *     struct stage s = stage_open("builtin:hall?lights=256", 0);
 *     struct shot a = stage_shoot(&s, &s.frame);
 *     …
 *     shot_free(&a);
 *     stage_close(&s);
 *
 * Everything here fails the running test when something goes wrong. tests/render_test.h has what scenes made by hand need.
 */
#ifndef FNL_TESTS_RENDER_HARNESS_H
#define FNL_TESTS_RENDER_HARNESS_H

#include "render/renderer_internal.h"
#include "tests/frame_plain.h"

#include <setjmp.h>

#include <cmocka.h>

/** Set-up and tear-down of the group: the device. Four threads, no cache folder. Warnings and errors are printed. */
int harness_begin(void **state);
/** Checks that validation was silent and, unless the device is shared, that no host memory is left. */
int harness_end(void **state);
/** The groups of this program share the device. */
void harness_share_device(void);
/** Destroys it. False, and says why, if validation spoke or host memory is left. */
bool harness_finish(void);
/** Tear-down of a test: closes the stages that a failure left open; fails it if validation has spoken since the last. */
int harness_check(void **state);
fnl_device *harness_device(void);

/** What a renderer does for tests; lives as long as it. */
struct renderer_tests *harness_hooks(fnl_renderer *renderer);

struct stage {
    fnl_scene *scene;
    fnl_renderer *renderer;
    fnl_frame frame; /* 113x65, the scene's first camera, EV100 5, colour and radiance, no timers */
};

/**
 * `source`: "builtin:…", or a sample (tests/stand_in.h); a stand-in replaces a missing sample. `scattered` lights are added with
 * fnl_scene_scatter_lights.
 */
struct stage stage_open(const char *source, uint32_t scattered);
/** Takes a scene over. */
struct stage stage_open_scene(fnl_scene *scene);
void stage_close(struct stage *stage);
/**
 * Lists have room for so many entries in the next frame, whatever it needs, and what the frames before needed is forgotten: lists that need
 * more overflow in that frame. Pools grow after it as always.
 */
void harness_set_pool(struct stage *stage, uint32_t entries);

/** The numbers of the last frame. Counters and views outlast the next query, unlike the library's: until the end of the test. */
fnl_frame_stats harness_stats(fnl_renderer *renderer);
/** A number of a technique. Fails the test, and names the key, where there is no such counter, or the frame does not have it. */
uint64_t counter(const fnl_frame_stats *stats, const char *key);
/** Whether the frame has the number. Fails where there is no such counter. */
bool has_counter(const fnl_frame_stats *stats, const char *key);
/** The same of a renderer's last frame. */
uint64_t counter_of(fnl_renderer *renderer, const char *key);

struct shot {
    fnl_image color, radiance, surface, normal, position; /* those that the frame asked for */
    fnl_frame_stats stats;                                /* harness_stats(), without the passes */
};

struct shot stage_shoot(struct stage *stage, const fnl_frame *frame);
void shot_free(struct shot *shot);

/**
 * Whether a test that does not care for the pair tries it: deferred shading with all its lists, forward shading with those of objects, and
 * of the other pairs that go together, which use lists alike, every `step`-th.
 */
bool harness_tries(fnl_shading shading, fnl_light_lists lists, uint32_t step);

/** Number of pixels whose bytes differ; UINT64_MAX when size or format do. */
uint64_t count_differing(const fnl_image *a, const fnl_image *b);
/** Greatest difference of a channel of two RGBA8 pictures, 0 .. 255. */
int greatest_difference(const fnl_image *a, const fnl_image *b);
/** Number of pixels of two RGBA8 pictures that differ in some channel by more than `allowed` (of 255). */
uint64_t count_beyond(const fnl_image *a, const fnl_image *b, int allowed);
/** Number of pixels of an RGBA32F picture that hold an infinity, a NaN or a negative value. */
uint64_t count_broken(const fnl_image *image);

#endif
