/* SPDX-License-Identifier: MIT */
/**
 * The second half of render_harness.h, for tests that make their scenes by hand and look at single pixels: memory that counts
 * and can be made to fail, small scenes, pictures. Both use the one device of the program.
 */
#ifndef FNL_TESTS_RENDER_TEST_H
#define FNL_TESTS_RENDER_TEST_H

#include "fanal/renderer.h"
#include "scene/scene.h"
#include "tests/render_harness.h"
#include "tests/test_memory.h"

fnl_host test_host(struct test_memory *memory);
/** With validation, two threads and no cache folder. Fails the test if there is no device. */
fnl_device *test_device_create(struct test_memory *memory);
/** Also checks that validation was silent. */
void test_device_destroy(fnl_device **device);

/** harness_device(), and the memory of its host. */
extern fnl_device *test_device;
extern struct test_memory test_device_memory;
/** As harness_begin and harness_end, but with two threads, and errors that the tests provoke are not printed. */
int test_group_begin(void **state);
int test_group_end(void **state);

/* ---- scenes ---- */

fnl_scene *test_scene(void);
/** Loads or fails the test; `shared` true: a sample, or the stand-in that replaces it (tests/stand_in.h). */
fnl_scene *test_load(const char *name, bool shared);
fnl_material_id test_material(fnl_scene *scene, const fnl_material_params *params);
/** A unit square in the xy plane from -1 to 1 that faces +Z, uv 0..1 from the top left; material index or SCENE_NONE. */
uint32_t test_quad_mesh(fnl_scene *scene, uint32_t material);
/** A sphere of radius 1, `rings` x 2 `rings` quads, smooth normals. */
uint32_t test_sphere_mesh(fnl_scene *scene, uint32_t material, uint32_t rings);
uint32_t test_place(fnl_scene *scene, uint32_t mesh, vec3 position, vec3 scale);
struct scene_material test_unlit(float r, float g, float b);
fnl_light_params test_point(vec3 position, float intensity, float range);

/** Orthographic, from z = 5 down to the square -1..1; and a perspective one. */
fnl_camera test_front_camera(void);
/** 64x64, the front camera, forward, all lights, no exposure, no tone mapping, no timers, one recording thread. */
fnl_frame test_frame(uint32_t outputs);

/* ---- shaders ---- */

/** How many instructions of a shader have an opcode from `first` to `last` (SPIR-V specification, 3.3). */
uint32_t test_count_operations(const struct gpu_shader *shader, uint32_t first, uint32_t last);

/* ---- pictures ---- */

/** Reads an output of the renderer's last frame. */
fnl_image test_read(fnl_renderer *renderer, fnl_output output);
/** A renderer of its own renders one frame. */
fnl_image test_render(fnl_scene *scene, const fnl_frame *frame, fnl_output output);
/** A renderer that shares nothing with others of its scene: what it shows, it was told itself. */
fnl_renderer *test_renderer(fnl_scene *scene);
void test_render_frame(fnl_renderer *renderer, const fnl_frame *frame);
void free_picture(fnl_image *image);
const float *test_pixel(const fnl_image *image, uint32_t x, uint32_t y);
const uint8_t *test_pixel8(const fnl_image *image, uint32_t x, uint32_t y);
/** Fails unless the pixel is the colour within `tolerance`. */
void assert_pixel(const fnl_image *image, uint32_t x, uint32_t y, double r, double g, double b, double tolerance);
/** Largest difference of two pictures; RGBA8 in units of 1/255. */
double test_difference(const fnl_image *a, const fnl_image *b);
bool test_equal(const fnl_image *a, const fnl_image *b);

#endif
