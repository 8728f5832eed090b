/* SPDX-License-Identifier: MIT */
/** Deferred attribute interpolation: references, derivatives, pools, lists and shared samples. The cache: dais_cache_test.c; whole scenes:
 * dais_scenes_test.c. */
#include "passes/dais/dais_shared.h"
#include "tests/render_test.h"
#include "tests/vulkan_spy.h"

#include "tests/dais_cases.h"

/* ---- DI-1 ---- */

/* Each triangle has a colour of its own: means of samples tell which triangles were seen at them. A visibility buffer holds just their ids. */
static void test_references(void **state) {
    UNUSED(state);
    fnl_scene *scene = soup_scene(&confetti);
    fnl_renderer *renderer = test_renderer(scene);
    for (uint32_t i = 0; i < 4; i++) {
        fnl_frame frame = wide_frame(0);
        frame.msaa = sample_counts(i);
        if (!has_samples(frame.msaa)) continue;
        fnl_image dais = shoot(renderer, &frame);
        /* With several samples drivers interpolate in ways of their own. */
        frame.shading = frame.msaa == 1 ? FNL_SHADING_FORWARD : FNL_SHADING_VISIBILITY;
        fnl_image forward = shoot(renderer, &frame);
        struct closeness c = compare(&forward, &dais, 2e-3);
        print_message("%u samples: %u of %u pixels beyond 2e-3, %.2g at most\n", frame.msaa, c.beyond, c.shown, c.worst);
        assert_true(c.shown > 2000);
        assert_int_equal(c.beyond, 0);
        free_picture(&dais);
        free_picture(&forward);
    }
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

/* ---- DI-2, DI-12, DI-13 ---- */

static void test_interpolation(void **state) {
    UNUSED(state);
    fnl_scene *scene = soup_scene(&colorful);
    fnl_renderer *renderer = test_renderer(scene);
    for (int view = 0; view < 3; view++) {
        fnl_frame frame = wide_frame(view);
        fnl_image dais = shoot(renderer, &frame);
        frame.shading = FNL_SHADING_FORWARD;
        fnl_image forward = shoot(renderer, &frame);
        struct closeness c = compare(&forward, &dais, 1e-3);
        print_message("view %d: %u of %u pixels beyond 1e-3, %.2g at most\n", view, c.beyond, c.shown, c.worst);
        assert_true(c.shown > 3000);
        /* Triangles on edge, a fraction of a pixel wide: the rasteriser's positions are rounded to 1/256 of a pixel. */
        assert_true(c.beyond * 200 < c.shown);
        free_picture(&dais);
        free_picture(&forward);
    }
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

/* Positions and depths from 1/w, interpolated normals, against what the surface outputs say. */
static void test_positions(void **state) {
    UNUSED(state);
    fnl_scene *scene = soup_scene(&crossing);
    struct scene_material white = test_unlit(1, 1, 1);
    test_place(scene, test_sphere_mesh(scene, scene_add_material(scene, &white), 12), (vec3){0, 0, 2.5f}, (vec3){1, 1, 1});
    fnl_renderer *renderer = test_renderer(scene);
    for (int view = 0; view < 3; view++) {
        fnl_frame frame = wide_frame(view);
        frame.outputs |= FNL_OUTPUT_POSITION | FNL_OUTPUT_NORMAL;
        fnl_image shown[3];
        static const uint32_t probes[3] = {DAIS_SHOW_POSITION, DAIS_SHOW_NORMAL, DAIS_SHOW_DEPTH};
        for (int k = 0; k < 3; k++) {
            harness_hooks(renderer)->dais_probe = probes[k];
            shown[k] = shoot(renderer, &frame);
        }
        harness_hooks(renderer)->dais_probe = 0;
        fnl_image position = test_read(renderer, FNL_OUTPUT_POSITION), normal = test_read(renderer, FNL_OUTPUT_NORMAL);
        uint32_t surfaces = 0, far_off = 0, bent = 0, deep = 0;
        for (uint32_t y = 0; y < frame.height; y++)
            for (uint32_t x = 0; x < frame.width; x++) {
                const float *p = test_pixel(&position, x, y), *n = test_pixel(&normal, x, y);
                if (p[3] == 0) continue;
                surfaces++;
                const float *q = test_pixel(&shown[0], x, y), *m = test_pixel(&shown[1], x, y);
                float away = vec3_distance((vec3){p[0], p[1], p[2]}, (vec3){q[0], q[1], q[2]});
                vec3 unit = vec3_normalize((vec3){m[0], m[1], m[2]});
                far_off += !(away <= 1e-3f * n[3]);
                bent += !(fabsf(vec3_dot(unit, (vec3){n[0], n[1], n[2]})) >= 0.999f);
                deep += !(test_pixel(&shown[2], x, y)[2] <= 1e-3f);
            }
        print_message("view %d: of %u pixels %u positions off, %u normals, %u depths\n", view, surfaces, far_off, bent, deep);
        assert_true(surfaces > 3000);
        assert_true(far_off * 200 < surfaces && bent * 200 < surfaces && deep * 200 < surfaces);
        for (int k = 0; k < 3; k++) free_picture(&shown[k]);
        free_picture(&position);
        free_picture(&normal);
    }
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

static fnl_image_id chequered(fnl_scene *scene) {
    enum { SIDE = 128 };
    static uint8_t texels[SIDE * SIDE * 4];
    for (uint32_t i = 0; i < SIDE * SIDE; i++)
        for (uint32_t c = 0; c < 4; c++)
            texels[i * 4 + c] = c == 3 ? 255 : (uint8_t)(((i % SIDE / (c * 2 + 1)) ^ (i / SIDE / (c + 1))) & 1 ? 240 : 20);
    fnl_image image = {SIDE, SIDE, FNL_PIXEL_FORMAT_RGBA8, texels};
    fnl_image_id id;
    assert_int_equal(fnl_scene_add_image(scene, &image, true, &id), FNL_OK);
    return id;
}

static uint32_t trilinear(fnl_scene *scene) {
    return scene_add_sampler(scene, &(struct scene_sampler){.mag = SCENE_FILTER_LINEAR,
                                                            .min = SCENE_FILTER_LINEAR,
                                                            .mip = SCENE_FILTER_LINEAR,
                                                            .mipmapped = true,
                                                            .wrap_u = SCENE_WRAP_REPEAT,
                                                            .wrap_v = SCENE_WRAP_MIRROR});
}

/* Textures are filtered with the levels that forward shading takes. */
static void test_gradients(void **state) {
    UNUSED(state);
    fnl_scene *scene = test_scene();
    assert_int_equal(fnl_scene_set_anisotropy(scene, 1), FNL_OK);
    struct scene_material material = test_unlit(1, 1, 1);
    material.textures[SCENE_TEXTURE_BASE_COLOR] = scene_texture_none();
    material.textures[SCENE_TEXTURE_BASE_COLOR].image = chequered(scene).index;
    material.textures[SCENE_TEXTURE_BASE_COLOR].sampler = trilinear(scene);
    mat4 matrix = mat4_from_trs((vec3){0, -1, 0}, quat_axis_angle((vec3){1, 0, 0}, -PI / 2), (vec3){20, 20, 1});
    scene_add_node(scene, "", SCENE_NONE, &matrix, test_quad_mesh(scene, scene_add_material(scene, &material)));
    test_place(scene, test_sphere_mesh(scene, scene_add_material(scene, &material), 6), (vec3){0.5f, 0.3f, 1},
               (vec3){1, 1, 1});
    fnl_renderer *renderer = test_renderer(scene);
    fnl_frame frame = wide_frame(0);
    frame.outputs = FNL_OUTPUT_COLOR;
    fnl_image colors[2];
    for (int k = 0; k < 2; k++) {
        frame.shading = k ? FNL_SHADING_DAIS : FNL_SHADING_FORWARD;
        test_render_frame(renderer, &frame);
        colors[k] = test_read(renderer, FNL_OUTPUT_COLOR);
    }
    fnl_image_difference difference;
    assert_int_equal(fnl_image_compare(NULL, &colors[0], &colors[1], &difference), FNL_OK);
    print_message("%.1f dB\n", difference.psnr);
    assert_true(difference.psnr > 48);
    for (int k = 0; k < 2; k++) free_picture(&colors[k]);
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

/* Where a pixel's surface lies on the square from -1 to 1 that `to_square` leads to; false: beside it. */
static bool square_point(const mat4 *to_square, const fnl_image *position, uint32_t x, uint32_t y, vec3 *out) {
    const float *p = test_pixel(position, x, y);
    *out = mat4_point(to_square, (vec3){p[0], p[1], p[2]});
    return p[3] != 0 && fabsf(out->z) < 1e-3f && fabsf(out->x) < 0.97f && fabsf(out->y) < 0.97f;
}

/* The level of detail from derived gradients, on squares whose texture is pressed together along x or along y, against differences of positions. */
static void test_levels(void **state) {
    UNUSED(state);
    fnl_scene *scene = test_scene();
    struct scene_material material = test_unlit(1, 1, 1);
    material.textures[SCENE_TEXTURE_BASE_COLOR] = scene_texture_none();
    material.textures[SCENE_TEXTURE_BASE_COLOR].image = chequered(scene).index;
    material.textures[SCENE_TEXTURE_BASE_COLOR].sampler = trilinear(scene);
    uint32_t quad = test_quad_mesh(scene, scene_add_material(scene, &material));
    mat4 places[2], inverse[2];
    for (int k = 0; k < 2; k++) {
        places[k] = mat4_from_trs((vec3){k ? 0.3f : -1.5f, 0, 0}, quat_axis_angle((vec3){0.3f, 1, 0}, k ? 0.5f : -0.5f),
                                  (vec3){k ? 1.8f : 0.5f, k ? 0.3f : 1.6f, 1});
        assert_true(mat4_inverse(&places[k], &inverse[k]));
        scene_add_node(scene, "", SCENE_NONE, &places[k], quad);
    }
    fnl_renderer *renderer = test_renderer(scene);
    fnl_frame frame = wide_frame(0);
    frame.outputs |= FNL_OUTPUT_POSITION;
    harness_hooks(renderer)->dais_probe = DAIS_SHOW_UV;
    fnl_image shown = shoot(renderer, &frame), position = test_read(renderer, FNL_OUTPUT_POSITION);
    for (int k = 0; k < 2; k++) {
        uint32_t compared = 0, along_x = 0;
        double worst = 0;
        for (uint32_t y = 0; y + 1 < frame.height; y++)
            for (uint32_t x = 0; x + 1 < frame.width; x++) {
                vec3 at, right, down;
                if (!square_point(&inverse[k], &position, x, y, &at) || !square_point(&inverse[k], &position, x + 1, y, &right) ||
                    !square_point(&inverse[k], &position, x, y + 1, &down))
                    continue;
                double dx = hypot(right.x - at.x, right.y - at.y) / 2, dy = hypot(down.x - at.x, down.y - at.y) / 2;
                compared++;
                along_x += dx > dy;
                worst = fmax(worst, fabs(log2(fmax(dx, dy) * 1024) - (double)test_pixel(&shown, x, y)[2]));
            }
        print_message("%u pixels, %u with more texels along x: levels off by at most %.3f\n", compared, along_x, worst);
        assert_true(compared > 300 && (k ? along_x * 10 < compared : along_x * 10 > compared * 9) && worst < 0.06);
    }
    free_picture(&shown);
    free_picture(&position);
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

/* ---- DI-6: pools that are too small ---- */

/* Which fragments find room is a race, so a frame that overflows is shaded forward as a whole, each time to the same bits. */
static void test_overflow(void **state) {
    UNUSED(state);
    fnl_scene *scene = soup_scene(&paper);
    for (uint32_t i = 0; i < 6; i++) {
        fnl_frame frame = wide_frame(0);
        frame.count_lights = true;
        frame.msaa = i & 1 ? 4 : 1;
        frame.dais.mode = i < 2 ? FNL_DAIS_TARGET : FNL_DAIS_LIST;
        if (i >= 4 && frame.msaa == 1) continue; /* no elements */
        fnl_renderer *renderer = test_renderer(scene);
        fnl_image whole = shoot(renderer, &frame);
        fnl_frame_stats stats = harness_stats(renderer);
        assert_int_equal(counter(&stats, "dais.overflow"), 0);
        assert_true(counter(&stats, "dais.shaded") > 4000);
        /* Too small by far, or by so little that all but a few fragments find room. */
        uint32_t *pool = i < 4 ? &renderer->shading.dais_capacity : &renderer->shading.dais_node_capacity;
        const uint32_t enough = i < 4 ? counter(&stats, "dais.triangles") * 16 : counter(&stats, "dais.list-elements") + 1;
        const uint32_t sizes[] = {i < 4 ? 700 : 100, enough / 2, enough - enough / 50};
        fnl_frame other = frame;
        other.shading = FNL_SHADING_FORWARD_PREPASS;
        fnl_image forward = shoot(renderer, &other);
        assert_int_equal(test_equal(&whole, &forward), false); /* else equal pictures would tell nothing */
        for (uint32_t run = 0; run < 2 * COUNT_OF(sizes); run++) {
            for (uint32_t k = 0; k < GPU_FRAMES_IN_FLIGHT; k++) test_render_frame(renderer, &other); /* no counts let the pool grow */
            *pool = sizes[run / 2];
            fnl_image cut = shoot(renderer, &frame);
            stats = harness_stats(renderer);
            if (run % 2)
                print_message("%u samples, %s, room for %u of %u: %u fragments had none\n", frame.msaa,
                              fnl_value_name(FNL_ENUM_DAIS_MODE, frame.dais.mode), sizes[run / 2], enough,
                              (uint32_t)counter(&stats, "dais.overflow"));
            assert_true(counter(&stats, "dais.overflow") > 0);
            assert_int_equal(counter(&stats, "dais.shaded"), 0);
            assert_true(test_equal(&cut, &forward));
            free_picture(&cut);
        }
        free_picture(&forward);
        *pool = sizes[0];
        uint32_t turns = 0;
        do {
            fnl_image grown = shoot(renderer, &frame);
            stats = harness_stats(renderer);
            assert_int_equal(counter(&stats, "dais.shaded") > 0, counter(&stats, "dais.overflow") == 0);
            if (counter(&stats, "dais.overflow") == 0) assert_true(test_equal(&whole, &grown));
            free_picture(&grown);
        } while (counter(&stats, "dais.overflow") && ++turns < 12);
        assert_int_equal(counter(&stats, "dais.overflow"), 0);
        free_picture(&whole);
        fnl_renderer_destroy(&renderer);
    }
    fnl_scene_destroy(&scene);
}

/* The forward pass for what found no room draws nothing where all did. */
static void test_gate(void **state) {
    UNUSED(state);
    fnl_scene *scene = soup_scene(&paper);
    struct gpu_buffer draws;
    assert_int_equal(gpu_buffer_create(test_device, "draws", 4096, GPU_MEMORY_READBACK, &draws), FNL_OK);
    spy_begin(test_device);
    for (int clusters = 0; clusters < 2; clusters++)
        for (int cramped = 0; cramped < 2; cramped++) {
            const char *name = clusters ? "dais gate clusters" : "dais gate";
            fnl_renderer *renderer = test_renderer(scene);
            if (cramped) renderer->shading.dais_capacity = 700;
            fnl_frame frame = wide_frame(0);
            frame.culling = clusters ? FNL_CULLING_CLUSTERS : FNL_CULLING_INSTANCES;
            memset(draws.mapped, 0xff, 4096);
            spy_capture(renderer->graph, name, name, &draws);
            test_render_frame(renderer, &frame);
            spy_capture(NULL, NULL, NULL, NULL);
            assert_int_equal(counter_of(renderer, "dais.overflow") > 0, cramped); /* and waits */
            const struct gpu_draw *draw = draws.mapped;
            uint32_t drawn = clusters ? *(const uint32_t *)draws.mapped : draw->instance_count;
            if (!cramped) assert_int_equal(drawn, 0);
            if (cramped && !clusters) assert_true(drawn > 0 && drawn < 1000);
            fnl_renderer_destroy(&renderer);
        }
    assert_int_equal(gpu_wait_idle(test_device), FNL_OK);
    spy_end();
    gpu_buffer_destroy(test_device, &draws);
    fnl_scene_destroy(&scene);
}

/* ---- DI-7: layouts ---- */

/* Spheres whose materials ask for different parts: nothing, either set of coordinates, tangents, both. `spheres`: a bit for each of eight. */
static fnl_scene *layouts_scene(uint32_t kinds, uint32_t spheres) {
    fnl_scene *scene = test_scene();
    assert_int_equal(fnl_scene_set_anisotropy(scene, 1), FNL_OK);
    uint32_t image = chequered(scene).index, sampler = trilinear(scene);
    for (uint32_t k = 0; k < 8; k++) {
        if (!(spheres >> k & 1)) continue;
        struct scene_material material = test_unlit(0.8f, 0.7f, 0.6f);
        material.unlit = false;
        material.metallic = 0;
        material.roughness = 0.7f;
        material.emissive = (vec3){0.1f, 0.1f, 0.1f};
        if (k & 1 & kinds) {
            material.textures[SCENE_TEXTURE_BASE_COLOR] = scene_texture_none();
            material.textures[SCENE_TEXTURE_BASE_COLOR].image = image;
            material.textures[SCENE_TEXTURE_BASE_COLOR].sampler = sampler;
            material.textures[SCENE_TEXTURE_BASE_COLOR].uv_set = k & 4 ? 1 : 0;
        }
        if (k & 2 & kinds) {
            material.textures[SCENE_TEXTURE_NORMAL] = scene_texture_none();
            material.textures[SCENE_TEXTURE_NORMAL].image = image;
            material.textures[SCENE_TEXTURE_NORMAL].sampler = sampler;
            material.normal_scale = 0.3f;
        }
        uint32_t mesh = test_sphere_mesh(scene, scene_add_material(scene, &material), 10);
        test_place(scene, mesh, (vec3){(float)(k % 4) * 1.6f - 2.4f, k < 4 ? 0.9f : -0.9f, 0}, (vec3){0.8f, 0.8f, 0.8f});
    }
    fnl_light_params light = test_point((vec3){0, 1, 4}, 60, 20);
    fnl_light_id id;
    assert_int_equal(fnl_scene_add_light(scene, &light, &id), FNL_OK);
    return scene;
}

static void test_layouts(void **state) {
    UNUSED(state);
    uint64_t bytes[2];
    uint32_t triangles[2];
    for (uint32_t k = 0; k < 2; k++) {
        fnl_scene *scene = layouts_scene(k ? 7 : 0, 0xff);
        fnl_renderer *renderer = test_renderer(scene);
        fnl_frame frame = wide_frame(0);
        fnl_image dais = shoot(renderer, &frame);
        fnl_frame_stats stats = harness_stats(renderer);
        bytes[k] = counter(&stats, "dais.bytes");
        triangles[k] = counter(&stats, "dais.triangles");
        frame.shading = FNL_SHADING_FORWARD;
        fnl_image forward = shoot(renderer, &frame);
        frame.shading = FNL_SHADING_VISIBILITY;
        fnl_image visibility = shoot(renderer, &frame);
        struct closeness c = compare(&forward, &dais, 0.02), d = compare(&visibility, &dais, 0.002);
        print_message("%u triangles, %llu bytes: %u of %u pixels beyond 0.02, %.2g at most\n", triangles[k],
                      (unsigned long long)bytes[k], c.beyond, c.shown, c.worst);
        print_message("  %u beyond 0.002 of a visibility buffer's, %.2g at most\n", d.beyond, d.worst);
        /* Normals are chequered: they tell levels of textures that a driver takes for four pixels from those of each pixel. */
        assert_true(c.shown > 2000 && c.beyond * 25 < c.shown && d.beyond * 500 < d.shown);
        free_picture(&visibility);
        free_picture(&dais);
        free_picture(&forward);
        fnl_renderer_destroy(&renderer);
        fnl_scene_destroy(&scene);
    }
    /* The same triangles; plain ones have records of 16 words, others of 22 and more. */
    assert_true(bytes[1] > bytes[0] + triangles[0] * 6);
}

/* A record holds what the triangle's material asks for, and nothing else. */
static void test_record_sizes(void **state) {
    UNUSED(state);
    for (uint32_t k = 0; k < 8; k++) {
        fnl_scene *scene = layouts_scene(7, 1u << k);
        fnl_renderer *renderer = test_renderer(scene);
        fnl_frame frame = wide_frame(0);
        test_render_frame(renderer, &frame);
        fnl_frame_stats stats = harness_stats(renderer);
        bool base = k & 1, normal = k & 2, second = k & 4;
        uint32_t words = 16 + (normal || (base && !second) ? 6 : 0) + (base && second ? 6 : 0) + (normal ? 12 : 0);
        assert_true(counter(&stats, "dais.triangles") > 50);
        assert_int_equal(counter(&stats, "dais.bytes"),
                         4ull * frame.width * frame.height + 16ull * frame.dais.cache_buckets +
                             4ull * counter(&stats, "dais.triangles") * (words + 1)); /* and its number */
        fnl_renderer_destroy(&renderer);
        fnl_scene_destroy(&scene);
    }
}

/* ---- DI-9: many triangles, ids that need no counter ---- */

static void test_dense(void **state) {
    UNUSED(state);
    fnl_scene *scene = test_scene();
    struct scene_material white = test_unlit(0.7f, 0.6f, 0.5f);
    uint32_t mesh = test_sphere_mesh(scene, scene_add_material(scene, &white), 96);
    for (uint32_t i = 0; i < 24; i++)
        test_place(scene, mesh, (vec3){(float)(i % 6) - 2.5f, (float)(i / 6) - 1.5f, 0}, (vec3){0.6f, 0.6f, 0.6f});
    fnl_renderer *renderer = test_renderer(scene);
    fnl_frame frame = wide_frame(0);
    frame.count_lights = true;
    fnl_image dais = shoot(renderer, &frame);
    fnl_frame_stats stats = harness_stats(renderer);
    frame.shading = FNL_SHADING_FORWARD;
    fnl_image forward = shoot(renderer, &frame);
    struct closeness c = compare(&forward, &dais, 1e-3);
    print_message("%u triangles seen of %llu, %u shaded; %u of %u pixels off\n", (uint32_t)counter(&stats, "dais.unique"),
                  (unsigned long long)stats.triangles_visible, (uint32_t)counter(&stats, "dais.shaded"), c.beyond, c.shown);
    assert_true(counter(&stats, "dais.unique") * 2 >
                counter(&stats, "dais.shaded")); /* hardly a triangle shows at two pixels */
    assert_int_equal(c.beyond, 0);
    free_picture(&dais);
    free_picture(&forward);
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

/* ---- DI-10: lists ---- */

static void test_lists(void **state) {
    UNUSED(state);
    fnl_scene *scene = soup_scene(&confetti);
    fnl_renderer *renderer = test_renderer(scene);
    for (uint32_t i = 0; i < 8; i++) {
        fnl_frame frame = wide_frame(0);
        frame.msaa = sample_counts(i & 3);
        if (!has_samples(frame.msaa)) continue;
        frame.dais.mode = FNL_DAIS_TARGET;
        fnl_image target = shoot(renderer, &frame);
        frame.dais.mode = FNL_DAIS_LIST;
        harness_hooks(renderer)->dais_plain = i >= 4; /* an element for each sample */
        fnl_image list = shoot(renderer, &frame);
        fnl_frame_stats stats = harness_stats(renderer);
        if (counter(&stats, "dais.overflow")) {
            free_picture(&list);
            list = shoot(renderer, &frame);
        }
        harness_hooks(renderer)->dais_plain = false;
        print_message("%u samples: %u elements\n", frame.msaa, (uint32_t)counter(&stats, "dais.list-elements"));
        assert_true(frame.msaa == 1 || counter(&stats, "dais.list-elements") > 1000);
        assert_true(test_equal(&target, &list));
        free_picture(&target);
        free_picture(&list);
    }
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

/* What covers pixels wholly takes no elements, what covers them partly one each; lists are smaller then. */
static void test_full_cover(void **state) {
    UNUSED(state);
    fnl_device_info info;
    assert_int_equal(fnl_device_query_info(test_device, &info), FNL_OK);
    if (!info.post_depth_coverage) skip();
    fnl_scene *scene = test_scene();
    struct scene_material white = test_unlit(1, 1, 1);
    vec3 *positions = ARENA_ARRAY(&scene->arena, vec3, 3);
    uint32_t *indices = ARENA_ARRAY(&scene->arena, uint32_t, 3);
    for (uint32_t i = 0; i < 3; i++) {
        positions[i] = (vec3){i == 1 ? 4.0f : -3.5f, i == 2 ? 2.4f : -1.8f, 0}; /* all in view: what is clipped may be drawn in parts */
        indices[i] = i;
    }
    struct scene_primitive primitive = {.material = scene_add_material(scene, &white),
                                        .vertex_count = 3,
                                        .index_count = 3,
                                        .indices = indices,
                                        .positions = positions};
    assert_int_equal(mesh_complete(&scene->arena, &primitive), FNL_OK);
    test_place(scene, scene_add_mesh(scene, "", &primitive, 1), (vec3){0, 0, 0}, (vec3){1, 1, 1});
    fnl_renderer *renderer = test_renderer(scene);
    fnl_frame frame = wide_frame(0);
    frame.msaa = 4;
    fnl_image target = shoot(renderer, &frame);
    uint64_t target_bytes = counter_of(renderer, "dais.bytes");
    frame.dais.mode = FNL_DAIS_LIST;
    fnl_image list = shoot(renderer, &frame);
    fnl_frame_stats stats = harness_stats(renderer);
    assert_true(test_equal(&target, &list));
    assert_int_equal(counter(&stats, "dais.triangles"), 1);
    uint32_t wholly = 0, partly = 0;
    for (uint32_t y = 0; y < frame.height; y++)
        for (uint32_t x = 0; x < frame.width; x++) {
            float level = test_pixel(&target, x, y)[0];
            wholly += level > 0.999f;
            partly += level > 0.001f && level <= 0.999f;
        }
    print_message("%u elements; %u pixels are covered wholly, %u partly\n", (uint32_t)counter(&stats, "dais.list-elements"),
                  wholly, partly);
    assert_true(wholly > 3000);
    assert_int_equal(counter(&stats, "dais.list-elements"), partly);
    assert_int_equal(target_bytes - counter(&stats, "dais.bytes"),
                     3ull * 4 * frame.width * frame.height - partly * DAIS_NODE * 4ull);
    free_picture(&target);
    free_picture(&list);
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

/* ---- DI-11: shared samples ---- */

static void test_multirate(void **state) {
    UNUSED(state);
    fnl_scene *scene = layouts_scene(7, 0xff);
    scene->ambient_sky = (vec3){0.5f, 0.7f, 1};
    scene->ambient_ground = (vec3){0.3f, 0.2f, 0.1f};
    fnl_renderer *renderer = test_renderer(scene);
    for (uint32_t i = 0; i < 6; i++) {
        fnl_frame frame = wide_frame(0);
        frame.outputs |= FNL_OUTPUT_COLOR;
        frame.exposure = FNL_EXPOSURE_NONE;
        frame.count_lights = true;
        frame.msaa = i % 2 ? 4 : 1;
        frame.dais.mode = i % 4 < 2 ? FNL_DAIS_TARGET : FNL_DAIS_LIST;
        fnl_image all = shoot(renderer, &frame), all_color = test_read(renderer, FNL_OUTPUT_COLOR);
        uint32_t shaded = counter_of(renderer, "dais.shaded");
        frame.dais.multirate = true;
        harness_hooks(renderer)->dais_plain = i >= 4; /* nobody shares */
        fnl_image part = shoot(renderer, &frame), part_color = test_read(renderer, FNL_OUTPUT_COLOR);
        harness_hooks(renderer)->dais_plain = false;
        uint32_t samples = counter_of(renderer, "dais.shading-samples");
        fnl_image_difference difference;
        assert_int_equal(fnl_image_compare(NULL, &all_color, &part_color, &difference), FNL_OK);
        uint32_t holes = 0, surfaces = 0, other = 0; /* what comes from shading samples is rounded: it shows that they are used */
        for (uint32_t y = 0; y < frame.height; y++)
            for (uint32_t x = 0; x < frame.width; x++) {
                const float *a = test_pixel(&all, x, y), *b = test_pixel(&part, x, y);
                holes += b[0] < 0.5f * a[0];
                surfaces += a[0] != scene->background.x;
                other += memcmp(a, b, 12) != 0;
            }
        print_message("%u samples, %s: %u shading samples for %u; %.1f dB, %u holes\n", frame.msaa,
                      fnl_value_name(FNL_ENUM_DAIS_MODE, frame.dais.mode), samples, shaded, difference.psnr, holes);
        fnl_device_info info;
        assert_int_equal(fnl_device_query_info(test_device, &info), FNL_OK);
        if (i < 4 && info.quad_operations) assert_true(samples * 10 < shaded * 9);
        if (i >= 4) assert_true(samples >= shaded);
        assert_int_equal(holes, 0);
        assert_true(surfaces > 2000 && other * 10 > surfaces * 9);
        assert_true(difference.psnr > 40);
        free_picture(&all);
        free_picture(&part);
        free_picture(&all_color);
        free_picture(&part_color);
    }
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

/* Two surfaces in one plane ask for more shading samples than there is room for: nobody shares, instead of whoever came first. */
static void test_multirate_overflow(void **state) {
    UNUSED(state);
    fnl_scene *scene = test_scene();
    scene->ambient_sky = (vec3){0.5f, 0.7f, 1};
    scene->ambient_ground = (vec3){0.3f, 0.2f, 0.1f};
    struct scene_material material = test_unlit(0.8f, 0.7f, 0.6f);
    material.unlit = false;
    material.metallic = 0;
    uint32_t quad = test_quad_mesh(scene, scene_add_material(scene, &material));
    for (uint32_t i = 0; i < 2; i++) test_place(scene, quad, (vec3){0, 0, 0}, (vec3){20, 20, 1});
    fnl_renderer *renderer = test_renderer(scene);
    fnl_frame frame = wide_frame(0);
    const uint32_t pixels = frame.width * frame.height;
    fnl_image alone = shoot(renderer, &frame);
    frame.dais.multirate = true;
    harness_hooks(renderer)->dais_plain = true; /* a sample for each pixel of each surface */
    fnl_image crowded = shoot(renderer, &frame);
    fnl_frame_stats stats = harness_stats(renderer);
    print_message("%u shading samples of %u pixels\n", (uint32_t)counter(&stats, "dais.shading-samples"), pixels);
    assert_int_equal(counter(&stats, "dais.shading-samples"), 2 * pixels); /* of which five eighths find room */
    assert_int_equal(counter(&stats, "dais.overflow"), 0);
    assert_true(test_equal(&alone, &crowded));
    free_picture(&alone);
    free_picture(&crowded);
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

/* ---- DI-14, DI-15 ---- */

/* Bytes of what shading reads, with eight samples a pixel, against the G-buffer of deferred shading. */
static void test_bytes(void **state) {
    UNUSED(state);
    fnl_gbuffer_info info;
    assert_int_equal(fnl_gbuffer_query_info(FNL_GBUFFER_DEFAULT, &info), FNL_OK);
    fnl_scene *scene = soup_scene(&confetti);
    fnl_renderer *renderer = test_renderer(scene);
    fnl_frame frame = wide_frame(0);
    frame.msaa = 4;
    test_render_frame(renderer, &frame);
    fnl_frame_stats dais = harness_stats(renderer);
    uint64_t samples = (uint64_t)frame.width * frame.height * frame.msaa, cache = (uint64_t)frame.dais.cache_buckets * 16;
    /* What is counted is what formats and records say: 4 bytes a sample, the cache, and for each triangle its record and its number. */
    uint64_t records = counter(&dais, "dais.bytes") - samples * 4 - cache;
    assert_true(records >= counter(&dais, "dais.triangles") * 4ull * (16 + 1) &&
                records <= counter(&dais, "dais.triangles") * 4ull * (DAIS_RECORD_MAX + 1));
    frame.shading = FNL_SHADING_DEFERRED;
    test_render_frame(renderer, &frame);
    assert_int_equal(counter_of(renderer, "gbuffer.bytes"), samples * info.bits / 8);
    double each = (double)records / counter(&dais, "dais.triangles");
    static const uint32_t sizes[][2] = {{1920, 1080}, {3840, 2160}};
    for (uint32_t i = 0; i < 2; i++) {
        uint64_t many = 8ull * sizes[i][0] * sizes[i][1], deferred = many * info.bits / 8;
        double triangles = 262267, bytes = (double)(many * 4 + cache) + triangles * each;
        print_message("%ux%u, 8 samples: %.1f MiB, deferred %.1f MiB, ratio %.2f; even at %.1f million triangles\n",
                      sizes[i][0], sizes[i][1], bytes / (1 << 20), (double)deferred / (1 << 20), bytes / (double)deferred,
                      (double)(deferred - many * 4 - cache) / each * 1e-6);
        assert_true(bytes < 0.6 * (double)deferred);
    }
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

/* As spheres get finer, bytes pass those of deferred shading, where a record's bytes are what references save on its samples. */
static void test_crossover(void **state) {
    UNUSED(state);
    uint32_t ahead = 0, behind = 0;
    for (uint32_t i = 0; i < 3; i++) {
        static const uint32_t rings[] = {3, 10, 96};
        fnl_scene *scene = test_scene();
        struct scene_material white = test_unlit(0.7f, 0.6f, 0.5f);
        uint32_t mesh = test_sphere_mesh(scene, scene_add_material(scene, &white), rings[i]);
        for (uint32_t k = 0; k < 15; k++)
            test_place(scene, mesh, (vec3){(float)(k % 5) - 2, (float)(k / 5) - 1, 0}, (vec3){0.9f, 0.9f, 0.9f});
        fnl_renderer *renderer = test_renderer(scene);
        fnl_frame frame = wide_frame(0);
        frame.msaa = 4;
        test_render_frame(renderer, &frame);
        fnl_frame_stats dais = harness_stats(renderer);
        frame.shading = FNL_SHADING_DEFERRED;
        test_render_frame(renderer, &frame);
        double samples = 4.0 * frame.width * frame.height, deferred = (double)counter_of(renderer, "gbuffer.bytes"),
               bytes = (double)(counter(&dais, "dais.bytes") - frame.dais.cache_buckets * 16ull),
               each = samples / counter(&dais, "dais.triangles");
        double even = (64 + 4) / (deferred / samples - 4); /* a record without textures, and its number */
        print_message("%.2f samples to each of %u triangles: %.2f of the bytes of deferred; even at %.2f\n", each,
                      (uint32_t)counter(&dais, "dais.triangles"), bytes / deferred, even);
        assert_true(bytes == samples * 4 + counter(&dais, "dais.triangles") * 68.0 && (bytes < deferred) == (each > even));
        ahead += bytes < deferred;
        behind += bytes > deferred;
        fnl_renderer_destroy(&renderer);
        fnl_scene_destroy(&scene);
    }
    assert_true(ahead > 0 && behind > 0);
}

static void test_timers(void **state) {
    UNUSED(state);
    fnl_scene *scene = soup_scene(&confetti);
    fnl_renderer *renderer = test_renderer(scene);
    fnl_frame frame = wide_frame(0);
    frame.msaa = 4;
    frame.timers = true;
    frame.dais.multirate = true;
    test_render_frame(renderer, &frame);
    fnl_frame_stats stats = harness_stats(renderer);
    static const char *const passes[] = {"depth prepass", "dais visibility", "dais derivatives", "dais shared samples",
                                         "dais shade"};
    for (uint32_t k = 0; k < COUNT_OF(passes); k++) {
        uint32_t found = 0;
        for (uint32_t i = 0; i < stats.pass_count; i++)
            found += strcmp(stats.passes[i].name, passes[k]) == 0 && stats.passes[i].milliseconds > 0;
        assert_int_equal(found, 1);
    }
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

/* ---- views ---- */

/* What the colours say of a pixel's triangles adds up to how many were shaded. */
static void test_views(void **state) {
    UNUSED(state);
    fnl_scene *scene = soup_scene(&confetti);
    fnl_renderer *renderer = test_renderer(scene);
    fnl_frame frame = wide_frame(0);
    frame.outputs |= FNL_OUTPUT_COLOR;
    frame.msaa = 4;
    frame.count_lights = true;
    static const fnl_debug_view views[3] = {FNL_DEBUG_DAIS_ADDRESSES, FNL_DEBUG_DAIS_TRIANGLES, FNL_DEBUG_DAIS_FAILURES};
    fnl_image shown[3];
    for (int k = 0; k < 3; k++) {
        frame.debug = views[k];
        test_render_frame(renderer, &frame);
        shown[k] = test_read(renderer, FNL_OUTPUT_COLOR);
    }
    fnl_frame_stats stats = harness_stats(renderer);
    uint32_t triangles = 0, red = 0;
    for (uint32_t y = 0; y < frame.height; y++)
        for (uint32_t x = 0; x < frame.width; x++) {
            const uint8_t *address = test_pixel8(&shown[0], x, y), *count = test_pixel8(&shown[1], x, y);
            assert_int_equal(address[0] + address[1] + address[2] > 0, count[0] > 0);
            /* Black 0, grey 1, green 2, yellow 3, red 4. */
            uint32_t n = count[0] == 0 ? 0 : count[0] == count[1] ? 1 : count[1] > count[0] ? 2 : count[1] > 100 ? 3 : 4;
            triangles += n;
            red += test_pixel8(&shown[2], x, y)[0] > 100;
        }
    print_message("%u triangles of pixels shown, %u shaded; %u red\n", triangles, (uint32_t)counter(&stats, "dais.shaded"),
                  red);
    assert_int_equal(triangles, counter(&stats, "dais.shaded"));
    assert_true(counter(&stats, "dais.cache-failures") > 0 || red == 0);
    for (int k = 0; k < 3; k++) free_picture(&shown[k]);
    frame.shading = FNL_SHADING_FORWARD;
    assert_int_equal(fnl_renderer_render(renderer, &frame), FNL_ERROR_UNSUPPORTED);
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

/* ---- the rest of the contract ---- */

static void test_options(void **state) {
    UNUSED(state);
    fnl_scene *scene = soup_scene(&confetti);
    fnl_renderer *renderer = test_renderer(scene);
    static const uint32_t buckets[] = {0, 3, (1u << 22) + 1, 1u << 23};
    for (uint32_t i = 0; i < COUNT_OF(buckets); i++) {
        fnl_frame frame = wide_frame(0);
        frame.dais.cache_buckets = buckets[i];
        assert_int_equal(fnl_renderer_render(renderer, &frame), FNL_ERROR_INVALID);
    }
    fnl_frame frame = wide_frame(0);
    frame.dais.mode = FNL_DAIS_MODE_COUNT;
    assert_int_equal(fnl_renderer_render(renderer, &frame), FNL_ERROR_INVALID);
    assert_null(fnl_value_name(FNL_ENUM_DAIS_MODE, FNL_DAIS_MODE_COUNT));
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

/* Nothing in view; one pixel; poison in what is not written. */
static void test_little(void **state) {
    UNUSED(state);
    fnl_scene *scene = test_scene();
    fnl_renderer *renderer = test_renderer(scene);
    harness_hooks(renderer)->poison = true;
    for (uint32_t i = 0; i < 4; i++) {
        fnl_frame frame = wide_frame(0);
        frame.width = i & 1 ? 1 : 33;
        frame.height = i & 1 ? 1 : 7;
        frame.msaa = i & 1 ? 4 : 1;
        frame.dais.mode = (fnl_dais_mode)(i >> 1);
        frame.dais.multirate = i == 2;
        fnl_image radiance = shoot(renderer, &frame);
        for (int k = 0; k < 3; k++) assert_true(test_pixel(&radiance, 0, 0)[k] == (&scene->background.x)[k]);
        assert_int_equal(counter_of(renderer, "dais.triangles"), 0);
        free_picture(&radiance);
    }
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        {"DI-1: each sample refers to the triangle that is seen at it", test_references, NULL, NULL, NULL},
        {"DI-2: attributes are the rasteriser's, across the near plane too", test_interpolation, NULL, NULL, NULL},
        {"DI-2, DI-12: positions, normals and depths from derivatives", test_positions, NULL, NULL, NULL},
        {"DI-13: textures are filtered as in forward shading", test_gradients, NULL, NULL, NULL},
        {"DI-13: levels of detail are those of the surface", test_levels, NULL, NULL, NULL},
        {"DI-6: a frame without room is shaded forward, each time alike", test_overflow, NULL, NULL, NULL},
        {"DI-6: nothing is drawn again where there is room", test_gate, NULL, spy_tear_down, NULL},
        {"DI-7: materials choose what a record holds", test_layouts, NULL, NULL, NULL},
        {"DI-7: records hold what materials ask for", test_record_sizes, NULL, NULL, NULL},
        {"DI-9: as many triangles as pixels, ids without a counter", test_dense, NULL, NULL, NULL},
        {"DI-10: lists refer to the same triangles", test_lists, NULL, NULL, NULL},
        {"DI-10: pixels covered by one triangle take no elements", test_full_cover, NULL, NULL, NULL},
        {"DI-11: ambient light at a lower rate", test_multirate, NULL, NULL, NULL},
        {"DI-11: shading samples without room are not used", test_multirate_overflow, NULL, NULL, NULL},
        {"DI-14: bytes beside deferred shading", test_bytes, NULL, NULL, NULL},
        {"DI-14, DI-15: where triangles are too small for it", test_crossover, NULL, NULL, NULL},
        {"DI-15: every pass has its time", test_timers, NULL, NULL, NULL},
        {"views of addresses, triangles and failures", test_views, NULL, NULL, NULL},
        {"options out of range", test_options, NULL, NULL, NULL},
        {"nothing in view", test_little, NULL, NULL, NULL}};
    return cmocka_run_group_tests(tests, test_group_begin, test_group_end);
}
