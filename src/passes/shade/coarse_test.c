/* SPDX-License-Identifier: MIT */
/** Coarse shading: which blocks are lit once, by each criterion, and what is counted. */
#include "tests/coarse_cases.h"
#include "tests/frame_plain.h"

/* ---- the G-buffer and the criterion z ---- */

/*
 * On a plane the depths of a block differ from the first by at most (size - 1) (|dz/dx| + |dz/dy|), or by the larger of the two where they
 * have different signs; so the factor at which blocks begin to be lit once measures the stored gradient.
 */
static void test_gradient_is_the_slope_of_a_plane_CP_1(void **state) {
    UNUSED(state);
    static const float slopes[][2] = {{0.4f, 0}, {0, 0.7f}, {0.3f, -0.5f}, {0.3f, 0.5f}, {-0.9f, 0.2f}, {0.05f, -0.08f}};
    for (uint32_t i = 0; i < COUNT_OF(slopes); i++) {
        float a = slopes[i][0], b = slopes[i][1];
        fnl_scene *scene = coarse_scene();
        coarse_add_plane(scene, coarse_plain(scene), -3, 3, 0, a, b);
        struct stage stage = stage_open_scene(scene);
        fnl_frame frame = coarse_front_frame(&stage);
        for (uint32_t size = 2; size <= 4; size += 2) {
            /* The view depth grows by -a to the right and by b down, a pixel's width each. */
            float away = -a * b >= 0 ? fabsf(a) + fabsf(b) : fmaxf(fabsf(a), fabsf(b));
            float factor = (float)(size - 1) * away / ((float)size * sqrtf(2) * (fabsf(a) + fabsf(b)));
            frame.coarse.size = size;
            frame.coarse.depth_factor = factor * 0.995f;
            fnl_frame_stats below = coarse_stats(&stage, &frame);
            frame.coarse.depth_factor = factor * 1.005f;
            fnl_frame_stats above = coarse_stats(&stage, &frame);
            assert_int_equal(counter(&below, "coarse.blocks"), 64 * 64 / (size * size));
            assert_int_equal(counter(&below, "coarse.shared"), 0);
            assert_int_equal(counter(&below, "coarse.by-depth"), counter(&below, "coarse.blocks"));
            assert_int_equal(counter(&above, "coarse.shared"), counter(&above, "coarse.blocks"));
        }
        stage_close(&stage);
    }
}

static void test_size_1_is_deferred_CP_2(void **state) {
    UNUSED(state);
    static const char *const sources[] = {"builtin:hall?lights=200&decals=40", "builtin:glass", "builtin:sky?lights=30"};
    for (uint32_t i = 0; i < COUNT_OF(sources); i++) {
        struct stage stage = stage_open(sources[i], 0);
        fnl_frame frame = coarse_hall_frame(&stage, 101, 67);
        frame.coarse.size = 1;
        struct shot a = stage_shoot(&stage, &frame), b = coarse_deferred(&stage, frame);
        assert_int_equal(count_differing(&a.radiance, &b.radiance), 0);
        assert_int_equal(counter(&a.stats, "coarse.shaded"), counter(&a.stats, "coarse.pixels"));
        shot_free(&a);
        shot_free(&b);
        stage_close(&stage);
    }
}

static void test_plane_is_lit_once_per_block_CP_3(void **state) {
    UNUSED(state);
    fnl_scene *scene = coarse_scene();
    coarse_add_plane(scene, coarse_plain(scene), -3, 3, 0, 0.2f, -0.1f);
    coarse_add_light(scene, FNL_LIGHT_POINT, vec3_make(0.4f, 0.3f, 2), 20);
    struct stage stage = stage_open_scene(scene);
    fnl_frame frame = coarse_front_frame(&stage);
    struct shot full = coarse_deferred(&stage, frame);
    for (uint32_t size = 2; size <= 4; size += 2)
        for (uint32_t criterion = 0; criterion < FNL_COARSE_CRITERION_COUNT; criterion++) {
            frame.coarse.size = size;
            frame.coarse.criterion = (fnl_coarse_criterion)criterion;
            struct shot shot = stage_shoot(&stage, &frame);
            double error = coarse_worst_ratio(&shot.radiance, &full.radiance, 1);
            uint32_t blocks = 64 * 64 / (size * size);
            assert_int_equal(counter(&shot.stats, "coarse.blocks"), blocks);
            if (criterion != FNL_COARSE_CRITERION_ID) {
                assert_int_equal(counter(&shot.stats, "coarse.shared"), blocks);
                assert_int_equal(counter(&shot.stats, "coarse.shaded"), blocks);
            } else { /* but for the edge between the two triangles */
                assert_in_range(blocks - counter(&shot.stats, "coarse.shared"), 1, 3 * 64 / size);
            }
            /* Light changes by less than 4 % from a pixel to the next diagonally, and the farthest is size - 1 away. */
            print_message("size %u, %s: off by %.3g\n", size, fnl_value_name(FNL_ENUM_COARSE_CRITERION, frame.coarse.criterion), error);
            assert_true(error > 1e-3 && error < 0.04 * (size - 1));
            shot_free(&shot);
        }
    shot_free(&full);
    stage_close(&stage);
}

static void test_curved_surface_is_lit_by_pixels_at_0_degrees_CP_4(void **state) {
    UNUSED(state);
    fnl_scene *scene = coarse_scene();
    coarse_add_sphere(scene, coarse_plain(scene), 1.6f);
    coarse_add_light(scene, FNL_LIGHT_POINT, vec3_make(0.4f, 0.3f, 4), 20);
    struct stage stage = stage_open_scene(scene);
    fnl_frame frame = coarse_front_frame(&stage);
    struct shot full = coarse_deferred(&stage, frame);
    for (uint32_t criterion = 0; criterion < FNL_COARSE_CRITERION_COUNT; criterion++)
        for (uint32_t size = 2; size <= 4; size += 2) {
            frame.coarse = frame_plain().coarse;
            frame.coarse.size = size;
            frame.coarse.criterion = (fnl_coarse_criterion)criterion;
            frame.coarse.normal_degrees = 8;
            fnl_frame_stats loose = coarse_stats(&stage, &frame);
            assert_true(counter(&loose, "coarse.shared") > 0);
            frame.coarse.normal_degrees = 0;
            struct shot shot = stage_shoot(&stage, &frame);
            assert_int_equal(counter(&shot.stats, "coarse.shared"), 0);
            assert_int_equal(count_differing(&shot.radiance, &full.radiance), 0);
            shot_free(&shot);
        }
    shot_free(&full);
    stage_close(&stage);
}

/* The kinds of all blocks of a picture that straddle column `x`, and that do not. */
static void check_column(struct stage *stage, fnl_frame frame, uint32_t x, uint32_t kind) {
    for (uint32_t size = 2; size <= 4; size += 2) {
        frame.coarse.size = size;
        struct shot view = coarse_view(stage, frame, FNL_DEBUG_COARSE_REASON);
        for (uint32_t v = 0; v < 64; v++)
            for (uint32_t u = 0; u < 64; u++) assert_int_equal(coarse_kind_at(&view.color, u, v), u / size == x / size ? kind : 1);
        shot_free(&view);
    }
}

static void test_depth_edge_between_parallel_planes_CP_5(void **state) {
    UNUSED(state);
    fnl_scene *scene = coarse_scene();
    fnl_material_id material = coarse_plain(scene);
    coarse_add_plane(scene, material, -3, 1 / 32.0f, 0, 0, 0); /* to the middle of an odd column's left edge: 32 | 33 */
    coarse_add_plane(scene, material, 1 / 32.0f, 3, -0.5f, 0, 0);
    struct stage stage = stage_open_scene(scene);
    fnl_frame frame = coarse_front_frame(&stage);
    for (uint32_t criterion = 0; criterion < FNL_COARSE_CRITERION_COUNT; criterion += 2) {
        frame.coarse.criterion = (fnl_coarse_criterion)criterion;
        check_column(&stage, frame, 33, 2);
    }
    stage_close(&stage);
}

/* One plane, two materials that differ in one number: nothing but that number's tolerance tells them apart. */
static void test_materials_apart_CP_5(void **state) {
    UNUSED(state);
    static const struct {
        const char *name;
        size_t number; /* of fnl_material_params */
        float values[2], tolerance, albedo_tolerance;
        uint32_t kind;
    } cases[] = {
        {"roughness", offsetof(fnl_material_params, roughness), {0.7f, 0.5f}, 0.1f, 1, 4},
        {"roughness", offsetof(fnl_material_params, roughness), {0.7f, 0.5f}, 0.25f, 1, 1},
        {"metalness", offsetof(fnl_material_params, metallic), {0, 0.2f}, 0.1f, 1, 4},
        {"metalness", offsetof(fnl_material_params, metallic), {0, 0.2f}, 0.25f, 1, 1},
        {"F0", offsetof(fnl_material_params, ior), {1.5f, 2}, 0.1f, 1, 4}, /* roots 0.2 and 0.33 */
        {"F0", offsetof(fnl_material_params, ior), {1.5f, 2}, 0.25f, 1, 1},
        {"F90", offsetof(fnl_material_params, specular), {1, 0.4f}, 0.5f, 1, 4},
        {"F90", offsetof(fnl_material_params, specular), {1, 0.4f}, 0.7f, 1, 1},
        {"green", offsetof(fnl_material_params, base_color[1]), {0.6f, 0.4f}, 0.1f, 0.1f, 4},
        {"green", offsetof(fnl_material_params, base_color[1]), {0.6f, 0.4f}, 0.1f, 0.3f, 1},
        {"green", offsetof(fnl_material_params, base_color[1]), {0.6f, 0.4f}, 0.1f, 1, 1},
    };
    for (uint32_t i = 0; i < COUNT_OF(cases); i++) {
        fnl_scene *scene = coarse_scene();
        for (int k = 0; k < 2; k++) {
            fnl_material_params params = fnl_material_params_default();
            fnl_material_id id;
            params.metallic = 0;
            params.roughness = 0.7f;
            memcpy((char *)&params + cases[i].number, &cases[i].values[k], sizeof(float));
            assert_int_equal(fnl_scene_add_material(scene, &params, &id), FNL_OK);
            coarse_add_plane(scene, id, k ? 1 / 32.0f : -3, k ? 3 : 1 / 32.0f, 0, 0, 0);
        }
        struct stage stage = stage_open_scene(scene);
        fnl_frame frame = coarse_front_frame(&stage);
        frame.coarse.tolerance = cases[i].tolerance;
        frame.coarse.albedo_tolerance = cases[i].albedo_tolerance;
        print_message("%s, tolerances %g and %g\n", cases[i].name, (double)cases[i].tolerance, (double)cases[i].albedo_tolerance);
        check_column(&stage, frame, 33, cases[i].kind);
        stage_close(&stage);
    }
}

static void test_crease_CP_6(void **state) {
    UNUSED(state);
    fnl_scene *scene = coarse_scene();
    fnl_material_id material = coarse_plain(scene);
    coarse_add_plane(scene, material, -3, 1 / 32.0f, -0.3f / 32, 0.3f, 0); /* both meet at depth 0 */
    coarse_add_plane(scene, material, 1 / 32.0f, 3, 0.3f / 32, -0.3f, 0);
    struct stage stage = stage_open_scene(scene);
    fnl_frame frame = coarse_front_frame(&stage);
    for (uint32_t criterion = 0; criterion < FNL_COARSE_CRITERION_COUNT; criterion += 2) {
        frame.coarse.criterion = (fnl_coarse_criterion)criterion;
        check_column(&stage, frame, 33, 3);
        frame.coarse.normal_degrees = 40; /* the planes make an angle of 33 degrees */
        frame.coarse.criterion = FNL_COARSE_CRITERION_Z;
        check_column(&stage, frame, 33, 1);
        frame.coarse.normal_degrees = 2;
    }
    stage_close(&stage);
}

/* ---- sizes and counts ---- */

static void test_odd_sizes_CP_7(void **state) {
    UNUSED(state);
    static const uint32_t sizes[][2] = {{1, 1}, {3, 5}, {37, 23}, {65, 33}};
    fnl_scene *scene = coarse_scene();
    coarse_add_sphere(scene, coarse_plain(scene), 0.9f); /* sky round it */
    coarse_add_light(scene, FNL_LIGHT_POINT, vec3_make(0.4f, 0.3f, 4), 20);
    assert_int_equal(fnl_scene_set_background(scene, vec3_make(0.1f, 0.2f, 0.3f)), FNL_OK);
    struct stage stage = stage_open_scene(scene);
    for (uint32_t i = 0; i < COUNT_OF(sizes); i++)
        for (uint32_t size = 2; size <= 4; size += 2)
            for (uint32_t criterion = 0; criterion < FNL_COARSE_CRITERION_COUNT; criterion++) {
                fnl_frame frame = coarse_front_frame(&stage);
                frame.width = sizes[i][0];
                frame.height = sizes[i][1];
                frame.coarse.size = size;
                frame.coarse.criterion = (fnl_coarse_criterion)criterion;
                coarse_check_counts(&stage, &frame);
                frame.coarse.normal_degrees = 0;
                frame.coarse.depth_factor = 0; /* not even the smallest picture has a block of one pixel's width */
                struct shot fine = stage_shoot(&stage, &frame), full = coarse_deferred(&stage, frame);
                if (i > 0) assert_int_equal(count_differing(&fine.radiance, &full.radiance), 0);
                assert_int_equal(count_broken(&fine.radiance), 0);
                shot_free(&fine);
                shot_free(&full);
            }
    stage_close(&stage);
}

static void test_cameras_CP_7(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:spheres?lights=20", 0);
    for (uint32_t kind = 0; kind < 4; kind++) {
        fnl_frame frame = coarse_hall_frame(&stage, 75, 53);
        fnl_camera *camera = &frame.camera;
        frame.coarse.size = kind % 2 ? 4 : 2;
        frame.gbuffer.prepass = kind == 3;
        if (kind == 0) {
            camera->orthographic = true;
            camera->vertical_extent = 8;
            camera->far_distance = 40;
        } else if (kind == 1) {
            camera->shift = (fnl_vec2){0.7f, -0.4f};
        } else if (kind == 2) { /* nothing but sky */
            camera->target = vec3_add(camera->position, vec3_make(0, 10, 10));
        }
        coarse_check_counts(&stage, &frame);
        struct shot shot = stage_shoot(&stage, &frame), full = coarse_deferred(&stage, frame);
        assert_int_equal(count_broken(&shot.radiance), 0);
        double near = coarse_psnr(&shot.color, &full.color);
        print_message("camera %u: %u of %u blocks lit once, %.1f dB\n", kind,
                      (uint32_t)counter(&shot.stats, "coarse.shared"), (uint32_t)counter(&shot.stats, "coarse.blocks"),
                      near);
        assert_true(near > 30);
        shot_free(&shot);
        shot_free(&full);
    }
    stage_close(&stage);
}

static void test_counts_CP_9(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:hall?lights=32", 0);
    for (uint32_t size = 2; size <= 4; size += 2) {
        fnl_frame frame = coarse_hall_frame(&stage, 96, 64); /* walls all round, and whole blocks */
        frame.coarse.size = size;
        frame.count_lights = true;
        frame.lists = FNL_LISTS_ALL;
        fnl_frame_stats s = coarse_stats(&stage, &frame);
        uint32_t blocks = 96 * 64 / (size * size), list = counter(&s, "coarse.blocks") - counter(&s, "coarse.shared");
        assert_int_equal(counter(&s, "coarse.blocks"), blocks);
        assert_true(list > 0 && counter(&s, "coarse.shared") > 0);
        assert_int_equal(counter(&s, "coarse.shaded"), blocks + list * (size * size - 1));
        assert_int_equal(s.evaluations, (uint64_t)counter(&s, "coarse.shaded") * 32); /* lights are visited as often */
        frame.count_lights = false;
        frame.width = 95;
        frame.height = 61;
        coarse_check_counts(&stage, &frame);
    }
    stage_close(&stage);
}

/* ---- the other criteria ---- */

/* A plane of two triangles: but for the blocks on the edge between them, z and id find the same. */
static void test_triangles_of_a_plane_CP_13(void **state) {
    UNUSED(state);
    fnl_scene *scene = coarse_scene();
    coarse_add_plane(scene, coarse_plain(scene), -3, 3, 0, 0, 0); /* they meet along the diagonal of the view */
    struct stage stage = stage_open_scene(scene);
    for (uint32_t size = 2; size <= 4; size += 2) {
        fnl_frame frame = coarse_front_frame(&stage);
        frame.coarse.size = size;
        frame.coarse.criterion = FNL_COARSE_CRITERION_ID;
        fnl_frame_stats s = coarse_stats(&stage, &frame);
        assert_int_equal(counter(&s, "coarse.by-depth"), 64 / size);
        assert_int_equal(counter(&s, "coarse.shared"), counter(&s, "coarse.blocks") - counter(&s, "coarse.by-depth"));
    }
    stage_close(&stage);
}

static void test_ids_CP_13(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:hall?lights=8", 0);
    fnl_frame frame = coarse_hall_frame(&stage, 160, 90);
    struct shot z = coarse_view(&stage, frame, FNL_DEBUG_COARSE_REASON);
    frame.coarse.criterion = FNL_COARSE_CRITERION_ID;
    struct shot id = coarse_view(&stage, frame, FNL_DEBUG_COARSE_REASON);
    uint32_t z_alone = 0, id_alone = 0, both = 0;
    for (uint32_t y = 0; y < 90; y += 2)
        for (uint32_t x = 0; x < 160; x += 2) {
            uint32_t a = coarse_kind_at(&z.color, x, y), b = coarse_kind_at(&id.color, x, y);
            both += a == 1 && b == 1;
            z_alone += a == 1 && b != 1;
            id_alone += a != 1 && b == 1;
            if (a == 1 && b != 1) assert_int_equal(b, 2); /* smooth across the edge of a triangle, and nothing else */
        }
    print_message("blocks lit once: both %u, z alone %u, id alone %u\n", both, z_alone, id_alone);
    assert_true(both > 100 && z_alone > 0 && id_alone <= both / 200);
    coarse_check_counts(&stage, &frame);
    shot_free(&z);
    shot_free(&id);
    stage_close(&stage);
}

static void test_minmax_CP_14(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:hall?lights=8", 0);
    for (uint32_t size = 2; size <= 4; size += 2) {
        fnl_frame frame = coarse_hall_frame(&stage, 161, 91);
        frame.coarse.size = size;
        struct shot z = coarse_view(&stage, frame, FNL_DEBUG_COARSE_REASON);
        frame.coarse.criterion = FNL_COARSE_CRITERION_MINMAX;
        struct shot samplers = coarse_view(&stage, frame, FNL_DEBUG_COARSE_REASON);
        harness_hooks(stage.renderer)->no_minmax = true;
        struct shot loads = coarse_view(&stage, frame, FNL_DEBUG_COARSE_REASON);
        harness_hooks(stage.renderer)->no_minmax = false;
        uint32_t both = 0, z_alone = 0, beyond = 0;
        for (uint32_t y = 0; y < 91; y += size)
            for (uint32_t x = 0; x < 161; x += size) {
                uint32_t a = coarse_kind_at(&z.color, x, y), b = coarse_kind_at(&samplers.color, x, y);
                both += a == 1 && b == 1;
                z_alone += a == 1 && b != 1;
                beyond += a != 1 && b == 1;
            }
        print_message("size %u, blocks lit once: both %u, z alone %u, minmax alone %u; the device's samplers: %s\n", size,
                      both, z_alone, beyond, gpu_info(harness_device())->minmax_samplers ? "yes" : "no");
        assert_true(both > 20);
        assert_int_equal(beyond, 0);
        assert_int_equal(count_differing(&samplers.color, &loads.color), 0);
        coarse_check_counts(&stage, &frame);
        shot_free(&z);
        shot_free(&samplers);
        shot_free(&loads);
    }
    stage_close(&stage);
}

/* ---- views, culling ---- */

static void test_views_CP_16(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:hall?lights=8", 0);
    fnl_frame frame = coarse_hall_frame(&stage, 80, 44);
    struct shot green = coarse_view(&stage, frame, FNL_DEBUG_COARSE),
                reason = coarse_view(&stage, frame, FNL_DEBUG_COARSE_REASON);
    uint32_t shared = 0, colors[5] = {0};
    for (uint32_t y = 0; y < 44; y++)
        for (uint32_t x = 0; x < 80; x++) {
            uint32_t kind = coarse_kind_at(&reason.color, x, y);
            colors[kind]++;
            assert_int_equal(coarse_kind_at(&green.color, x, y), kind == 1 ? 1 : 0);
            shared += kind == 1;
        }
    assert_int_equal(shared, 4 * counter(&green.stats, "coarse.shared"));
    for (uint32_t k = 1; k < 5; k++) assert_true(colors[k] > 0);
    frame.shading = FNL_SHADING_DEFERRED;
    frame.debug = FNL_DEBUG_COARSE;
    assert_int_equal(fnl_renderer_render(stage.renderer, &frame), FNL_ERROR_UNSUPPORTED);
    shot_free(&green);
    shot_free(&reason);
    stage_close(&stage);
}

/* What is not seen and not drawn changes nothing, triangle numbers included. */
static void test_culling_changes_nothing_CP_8_ES_79(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:hall?lights=32", 0);
    fnl_frame frame = coarse_hall_frame(&stage, 161, 91);
    for (uint32_t criterion = 0; criterion < FNL_COARSE_CRITERION_COUNT; criterion++)
        for (uint32_t size = 2; size <= 4; size += 2) {
            frame.coarse.criterion = (fnl_coarse_criterion)criterion;
            frame.coarse.size = size;
            frame.culling = FNL_CULLING_INSTANCES;
            frame.occlusion = false;
            struct shot whole = stage_shoot(&stage, &frame);
            frame.culling = FNL_CULLING_TRIANGLES;
            for (int occlusion = 0; occlusion < 2; occlusion++) {
                frame.occlusion = occlusion;
                struct shot first = stage_shoot(&stage, &frame); /* the second knows what hid what */
                struct shot shot = stage_shoot(&stage, &frame);
                assert_int_equal(count_differing(&first.radiance, &whole.radiance), 0);
                assert_int_equal(count_differing(&shot.radiance, &whole.radiance), 0);
                assert_int_equal(counter(&shot.stats, "coarse.shared"), counter(&whole.stats, "coarse.shared"));
                assert_int_equal(counter(&shot.stats, "coarse.shaded"), counter(&whole.stats, "coarse.shaded"));
                assert_true(shot.stats.triangles_back > 0 &&
                            (!occlusion || shot.stats.triangles_occluded > 0 || shot.stats.items_occluded > 0));
                shot_free(&first);
                shot_free(&shot);
            }
            shot_free(&whole);
        }
    stage_close(&stage);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_gradient_is_the_slope_of_a_plane_CP_1, harness_check),
        cmocka_unit_test_teardown(test_size_1_is_deferred_CP_2, harness_check),
        cmocka_unit_test_teardown(test_plane_is_lit_once_per_block_CP_3, harness_check),
        cmocka_unit_test_teardown(test_curved_surface_is_lit_by_pixels_at_0_degrees_CP_4, harness_check),
        cmocka_unit_test_teardown(test_depth_edge_between_parallel_planes_CP_5, harness_check),
        cmocka_unit_test_teardown(test_materials_apart_CP_5, harness_check),
        cmocka_unit_test_teardown(test_crease_CP_6, harness_check),
        cmocka_unit_test_teardown(test_odd_sizes_CP_7, harness_check),
        cmocka_unit_test_teardown(test_cameras_CP_7, harness_check),
        cmocka_unit_test_teardown(test_counts_CP_9, harness_check),
        cmocka_unit_test_teardown(test_triangles_of_a_plane_CP_13, harness_check),
        cmocka_unit_test_teardown(test_ids_CP_13, harness_check),
        cmocka_unit_test_teardown(test_minmax_CP_14, harness_check),
        cmocka_unit_test_teardown(test_views_CP_16, harness_check),
        cmocka_unit_test_teardown(test_culling_changes_nothing_CP_8_ES_79, harness_check),
    };
    return cmocka_run_group_tests(tests, harness_begin, harness_end);
}
