/* SPDX-License-Identifier: MIT */
/** Scenes, frames and counts that the tests of coarse shading share. */
#ifndef FNL_TESTS_COARSE_CASES_H
#define FNL_TESTS_COARSE_CASES_H

#include "tests/render_harness.h"

fnl_scene *coarse_scene(void);
fnl_material_id coarse_material(fnl_scene *scene, float roughness, fnl_image_id image);
fnl_material_id coarse_plain(fnl_scene *scene);
/** The part x0 .. x1 of the plane z = at + a x + b y, -3 <= y <= 3; uv are x and y. */
void coarse_add_plane(fnl_scene *scene, fnl_material_id material, float x0, float x1, float at, float a, float b);
void coarse_add_sphere(fnl_scene *scene, fnl_material_id material, float radius);
void coarse_add_light(fnl_scene *scene, fnl_light_kind kind, vec3 position, float intensity);
fnl_frame coarse_front_frame(const struct stage *stage);
fnl_frame coarse_hall_frame(const struct stage *stage, uint32_t width, uint32_t height);
fnl_frame_stats coarse_stats(struct stage *stage, const fnl_frame *frame);
struct shot coarse_deferred(struct stage *stage, fnl_frame frame);
double coarse_psnr(const fnl_image *a, const fnl_image *b);
/** Largest relative difference of two radiances, at pixels whose coordinates are multiples of `step`. */
double coarse_worst_ratio(const fnl_image *a, const fnl_image *b, uint32_t step);
/** From the view coarse-reason: 0 nothing, 1 lit once, 2 depth, 3 normal, 4 material. */
uint32_t coarse_kind_at(const fnl_image *view, uint32_t x, uint32_t y);
struct shot coarse_view(struct stage *stage, fnl_frame frame, fnl_debug_view view);
/** What is lit, from the view: blocks once, other pixels each. */
void coarse_check_counts(struct stage *stage, const fnl_frame *frame);

#endif
