/* SPDX-License-Identifier: MIT */
/** Scenes, frames and comparisons that the tests of deferred attribute interpolation share. Comes after render/render_test.h. */
#ifndef FNL_PASSES_DAIS_DAIS_CASES_H
#define FNL_PASSES_DAIS_DAIS_CASES_H

/* ---- scenes ---- */

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

static const struct soup colorful = {60, 2, 30, .lines = true}, crossing = {60, 2, 30, .lines = false}, confetti = {60, 60, 0.5f, .flat = true},
                         paper = {60, 60, 0.5f, .plain = true};

static inline fnl_frame wide_frame(int view) {
    fnl_frame frame = test_frame(FNL_OUTPUT_RADIANCE);
    frame.width = 131;
    frame.height = 77;
    frame.shading = FNL_SHADING_DAIS;
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

struct closeness {
    uint32_t beyond, shown;
    double worst;
};

/* Pixels of `a` that show something and differ in `b` by more than `allowed`. */
static inline struct closeness compare(const fnl_image *a, const fnl_image *b, double allowed) {
    struct closeness c = {0};
    for (uint32_t y = 0; y < a->height; y++)
        for (uint32_t x = 0; x < a->width; x++) {
            const float *p = test_pixel(a, x, y), *q = test_pixel(b, x, y);
            double error = 0;
            for (int k = 0; k < 3; k++) error = fmax(error, fabs((double)p[k] - (double)q[k]));
            c.shown += p[0] > 0 || p[1] > 0 || p[2] > 0;
            c.beyond += !(error <= allowed);
            c.worst = fmax(c.worst, error);
        }
    return c;
}

static inline fnl_image shoot(fnl_renderer *renderer, const fnl_frame *frame) {
    test_render_frame(renderer, frame);
    return test_read(renderer, FNL_OUTPUT_RADIANCE);
}

static inline fnl_frame_stats stats_of(fnl_renderer *renderer) {
    fnl_frame_stats stats;
    assert_int_equal(fnl_renderer_query_stats(renderer, &stats), FNL_OK);
    return stats;
}

static inline uint32_t sample_counts(uint32_t i) {
    static const uint32_t counts[] = {1, 4, 8, 2};
    return counts[i];
}

static inline bool has_samples(uint32_t samples) {
    fnl_device_info info;
    assert_int_equal(fnl_device_query_info(test_device, &info), FNL_OK);
    return info.msaa_counts & samples;
}

#endif
