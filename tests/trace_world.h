/* SPDX-License-Identifier: MIT */
/** Small scenes for tests of the tracer. Everything fails the running test when something goes wrong. */
#ifndef FNL_TESTS_TRACE_WORLD_H
#define FNL_TESTS_TRACE_WORLD_H

#include "base/base.h"
#include "base/maths.h"
#include "fanal/trace.h"
#include "tests/frame_plain.h"

#include <setjmp.h>

#include <cmocka.h>

static inline fnl_scene *world_create(const fnl_host *host) {
    fnl_scene *scene = NULL;
    assert_int_equal(fnl_scene_create(host, &scene), FNL_OK);
    return scene;
}

/** White and matt, without any reflection; `albedo` of each channel. */
static inline fnl_material_params matt(float albedo) {
    fnl_material_params m = fnl_material_params_default();
    for (int i = 0; i < 3; i++) m.base_color[i] = albedo;
    m.metallic = m.specular = 0;
    return m;
}

static inline fnl_material_id add_material(fnl_scene *scene, const fnl_material_params *params) {
    fnl_material_id id;
    assert_int_equal(fnl_scene_add_material(scene, params, &id), FNL_OK);
    return id;
}

/** The square -1..1 in x and z at y = 0, whose front is seen from above, with texture coordinates 0..1. */
static inline fnl_mesh_id add_square_mesh(fnl_scene *scene, fnl_material_id material) {
    static const float positions[12] = {-1, 0, -1, -1, 0, 1, 1, 0, 1, 1, 0, -1}, uv[8] = {0, 0, 0, 1, 1, 1, 1, 0};
    static const uint32_t indices[6] = {0, 1, 2, 0, 2, 3};
    fnl_mesh_params params = {
        .vertex_count = 4, .index_count = 6, .positions = positions, .uv = uv, .indices = indices, .material = material};
    fnl_mesh_id id;
    assert_int_equal(fnl_scene_add_mesh(scene, &params, &id), FNL_OK);
    return id;
}

static inline fnl_instance_id add_instance(fnl_scene *scene, fnl_mesh_id mesh, mat4 transform) {
    fnl_instance_id id;
    assert_int_equal(fnl_scene_add_instance(scene, mesh, &transform, &id), FNL_OK);
    return id;
}

/** The same square with a material, scaled, then moved. */
static inline fnl_instance_id add_square(fnl_scene *scene, const fnl_material_params *material, vec3 scale, vec3 at) {
    return add_instance(scene, add_square_mesh(scene, add_material(scene, material)),
                        mat4_mul(mat4_translation(at), mat4_scaling(scale)));
}

static inline fnl_light_id add_point_light(fnl_scene *scene, vec3 at, float candela) {
    fnl_light_params light = fnl_light_params_default();
    fnl_light_id id;
    light.position = at;
    light.intensity = candela;
    light.range = 1000;
    assert_int_equal(fnl_scene_add_light(scene, &light, &id), FNL_OK);
    return id;
}

/** A picture that looks down on the square of `extent` metres around a point, from `height` above it. */
static inline fnl_trace_params look_down(vec3 at, float extent, float height, uint32_t size) {
    fnl_trace_params p = trace_plain();
    p.width = p.height = size;
    p.camera.orthographic = true;
    p.camera.vertical_extent = extent;
    p.camera.position = vec3_make(at.x, at.y + height, at.z);
    p.camera.target = at;
    p.camera.up = vec3_make(0, 0, -1);
    p.camera.near_distance = 1e-3f;
    p.exposure = FNL_EXPOSURE_NONE;
    return p;
}

static inline fnl_trace trace_scene(const fnl_scene *scene, const fnl_trace_params *params) {
    fnl_trace trace;
    assert_int_equal(fnl_scene_trace(scene, params, &trace), FNL_OK);
    return trace;
}

static inline const float *pixel_at(const fnl_image *image, uint32_t x, uint32_t y) {
    return (const float *)image->pixels + ((size_t)y * image->width + x) * 4;
}

/** Mean of a channel over the picture. */
static inline double mean_of(const fnl_image *image, int channel) {
    double sum = 0;
    for (size_t i = 0; i < (size_t)image->width * image->height; i++)
        sum += (double)((const float *)image->pixels)[i * 4 + (size_t)channel];
    return sum / ((double)image->width * image->height);
}

#endif
