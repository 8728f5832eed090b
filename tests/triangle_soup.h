/* SPDX-License-Identifier: MIT */
/** Meshes of random triangles, and a frame that looks at them. */
#ifndef FNL_TESTS_TRIANGLE_SOUP_H
#define FNL_TESTS_TRIANGLE_SOUP_H

#include "tests/render_test.h"

struct soup {
    uint32_t meshes, triangles; /* of a mesh */
    float largest;              /* metres; the first tenth is so large, others by and by smaller */
    bool flat;                  /* a triangle has one colour, which tells it from others */
    bool plain;                 /* a mesh has one colour, that of its material */
    bool lines;                 /* every tenth mesh is lines, every tenth points */
};

/* Triangles that reach behind the viewer, lie on edge, cross each other and are small. */
static inline fnl_scene *soup_scene(const struct soup *soup) {
    fnl_scene *scene = test_scene();
    struct random_state random = {3};
    uint32_t material = 0, count = soup->triangles * 3;
    for (uint32_t i = 0; i < soup->meshes; i++) {
        if (i == 0 || soup->plain) {
            struct scene_material unlit = test_unlit(1, soup->plain ? 0.1f + (float)(i % 7) * 0.1f : 1,
                                                     soup->plain ? 0.9f - (float)(i % 5) * 0.1f : 1);
            unlit.double_sided = true;
            material = scene_add_material(scene, &unlit);
        }
        vec3 *positions = ARENA_ARRAY(&scene->arena, vec3, count);
        vec4 *colors = ARENA_ARRAY(&scene->arena, vec4, count);
        uint32_t *indices = ARENA_ARRAY(&scene->arena, uint32_t, count);
        float size = i * 10 < soup->meshes ? soup->largest : i * 2 < soup->meshes ? fminf(soup->largest, 2) : 0.1f;
        for (uint32_t v = 0; v < count; v++) {
            positions[v] = (vec3){random_range(&random, -size, size), random_range(&random, -size, size),
                                  random_range(&random, -size, size)};
            colors[v] = soup->flat && v % 3 ? colors[v - 1]
                                            : (vec4){random_float(&random), random_float(&random), random_float(&random), 1};
            indices[v] = count - 1 - v;
        }
        struct scene_primitive primitive = {.material = material,
                                            .topology = soup->lines && i % 10 == 8   ? SCENE_TOPOLOGY_LINES
                                                        : soup->lines && i % 10 == 9 ? SCENE_TOPOLOGY_POINTS
                                                                                     : SCENE_TOPOLOGY_TRIANGLES,
                                            .vertex_count = count,
                                            .index_count = count,
                                            .indices = indices,
                                            .positions = positions,
                                            .colors = soup->plain ? NULL : colors};
        assert_int_equal(mesh_complete(&scene->arena, &primitive), FNL_OK);
        uint32_t mesh = scene_add_mesh(scene, "", &primitive, 1);
        vec3 mirror = {i % 3 == 0 ? -1.0f : 1.0f, 1, 1};
        test_place(scene, mesh,
                   (vec3){random_range(&random, -3, 3), random_range(&random, -2, 2), random_range(&random, -3, 2)}, mirror);
    }
    return scene;
}

static const struct soup colorful = {60, 2, 30, .lines = true};

/** View 0 is in perspective, 1 off its axis, 2 orthographic. */
static inline fnl_frame soup_frame(uint32_t outputs, int view) {
    fnl_frame frame = test_frame(outputs);
    frame.width = 131;
    frame.height = 77;
    frame.camera = fnl_camera_default();
    frame.camera.position = (vec3){0.3f, 0.4f, 5};
    frame.camera.target = (vec3){0, 0, 0};
    if (view == 1) frame.camera.shift = (vec2){0.4f, -0.3f};
    if (view == 2) {
        frame.camera.orthographic = true;
        frame.camera.vertical_extent = 6;
        frame.camera.far_distance = 60;
    }
    return frame;
}

#endif
