/* SPDX-License-Identifier: MIT */
/** What tests of several samples a pixel share: squares whose edges are known, and how near pictures are. */
#ifndef FNL_TESTS_MSAA_CASES_H
#define FNL_TESTS_MSAA_CASES_H

#include "tests/render_harness.h"

static inline bool msaa_has(uint32_t samples) {
    fnl_device_info info;
    assert_int_equal(fnl_device_query_info(harness_device(), &info), FNL_OK);
    return (info.msaa_counts & samples) != 0;
}

/** In decibels, of 8-bit pictures without their alpha; 99 when equal. */
static inline double msaa_psnr(const fnl_image *a, const fnl_image *b) {
    const uint8_t *p = a->pixels, *q = b->pixels;
    double sum = 0, count = 0;
    for (size_t i = 0; i < (size_t)a->width * a->height * 4; i++) {
        if (i % 4 == 3) continue;
        sum += (p[i] - q[i]) * (p[i] - q[i]);
        count++;
    }
    return sum > 0 ? 10 * log10(255.0 * 255.0 * count / sum) : 99;
}

static inline fnl_scene *msaa_scene(void) {
    fnl_scene *scene;
    assert_int_equal(fnl_scene_create(gpu_host(harness_device()), &scene), FNL_OK);
    return scene;
}

static inline fnl_material_id msaa_material(fnl_scene *scene, float r, float g, float b, float roughness) {
    fnl_material_params params = fnl_material_params_default();
    fnl_material_id id;
    params.base_color[0] = r;
    params.base_color[1] = g;
    params.base_color[2] = b;
    params.metallic = 0;
    params.roughness = roughness;
    assert_int_equal(fnl_scene_add_material(scene, &params, &id), FNL_OK);
    return id;
}

/** A square from -1 to 1 that faces +Z, turned, scaled and moved. */
static inline void msaa_square(fnl_scene *scene, fnl_material_id material, float angle, float size, vec3 at) {
    static const float positions[] = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0};
    static const uint32_t indices[] = {0, 1, 2, 0, 2, 3};
    fnl_mesh_params mesh = {
        .vertex_count = 4, .index_count = 6, .positions = positions, .indices = indices, .material = material};
    fnl_mesh_id mesh_id;
    fnl_instance_id instance;
    assert_int_equal(fnl_scene_add_mesh(scene, &mesh, &mesh_id), FNL_OK);
    fnl_mat4 matrix = mat4_from_trs(at, quat_axis_angle(vec3_make(0, 0, 1), angle), vec3_make(size, size, 1));
    assert_int_equal(fnl_scene_add_instance(scene, mesh_id, &matrix, &instance), FNL_OK);
}

#endif
