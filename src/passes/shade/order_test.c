/* SPDX-License-Identifier: MIT */
/** The shading orders against one another: forward, prepass, deferred, glass after deferred, multisampling. */
#include "tests/shade_reference.h"
#include "tests/render_test.h"

static void scatter(fnl_scene *scene, uint32_t count, uint64_t seed) {
    struct random_state random = {seed};
    for (uint32_t i = 0; i < count; i++) {
        fnl_light_params light =
            test_point((vec3){random_range(&random, -4, 4), random_range(&random, -1, 3), random_range(&random, -4, 4)},
                       random_range(&random, 1, 6), random_range(&random, 1, 5));
        if (i % 4 == 3) {
            light.kind = FNL_LIGHT_SPOT;
            light.direction = (vec3){random_range(&random, -1, 1), -1, random_range(&random, -1, 1)};
        }
        for (int c = 0; c < 3; c++) light.color[c] = random_range(&random, 0.3f, 1);
        fnl_light_id id;
        assert_int_equal(fnl_scene_add_light(scene, &light, &id), FNL_OK);
    }
}

/* Spheres of many materials on a floor, some overlapping others in the picture. */
static fnl_scene *room(void) {
    fnl_scene *scene = test_scene();
    struct random_state random = {5};
    for (uint32_t i = 0; i < 14; i++) {
        struct scene_material material = scene_material_default();
        material.base_color = (vec4){random_float(&random), random_float(&random), random_float(&random), 1};
        material.metallic = i % 3 == 0 ? 1.0f : i % 3 == 1 ? 0.0f : 0.5f;
        material.roughness = random_range(&random, 0.15f, 1);
        material.specular = i == 5 ? 0.3f : 1;
        if (i == 7) material.emissive = (vec3){0.5f, 2, 0.1f};
        uint32_t m = scene_add_material(scene, &material);
        mat4 floor_matrix = mat4_from_trs((vec3){0, -1, 0}, quat_axis_angle((vec3){1, 0, 0}, -PI / 2), (vec3){6, 6, 1});
        if (i == 0)
            scene_add_node(scene, "", SCENE_NONE, &floor_matrix, test_quad_mesh(scene, m));
        else
            test_place(scene, test_sphere_mesh(scene, m, 10),
                       (vec3){random_range(&random, -3.5f, 3.5f), random_range(&random, -0.8f, 1),
                              random_range(&random, -3.5f, 3.5f)},
                       (vec3){0.6f, 0.6f, 0.6f});
    }
    scatter(scene, 40, 11);
    assert_int_equal(fnl_scene_set_ambient(scene, (vec3){0.1f, 0.15f, 0.3f}, (vec3){0.05f, 0.04f, 0.02f}), FNL_OK);
    assert_int_equal(fnl_scene_set_background(scene, (vec3){0.02f, 0.03f, 0.05f}), FNL_OK);
    return scene;
}

static void room_frame(fnl_frame *frame, int view) {
    frame->width = 101; /* odd, and no multiple of a group's size */
    frame->height = 67;
    frame->camera = fnl_camera_default();
    frame->camera.position = (vec3){1, 2, 7};
    frame->camera.target = (vec3){0, -0.3f, 0};
    frame->tonemap = FNL_TONEMAP_KHRONOS_NEUTRAL;
    if (view == 1) frame->camera.shift = (vec2){0.3f, -0.4f};
    if (view == 2) {
        frame->camera.orthographic = true;
        frame->camera.vertical_extent = 6;
        frame->camera.far_distance = 30;
    }
}

/* Rebuilds positions from stored depth like shaders/view.glsl and compares them with the interpolated ones. */
static double position_error(fnl_renderer *renderer, const fnl_frame *frame) {
    fnl_image normal = test_read(renderer, FNL_OUTPUT_NORMAL), position = test_read(renderer, FNL_OUTPUT_POSITION);
    struct gpu_view v = view_from_camera(&frame->camera, frame->width, frame->height);
    double worst = 0;
    for (uint32_t y = 0; y < frame->height; y++)
        for (uint32_t x = 0; x < frame->width; x++) {
            const float *p = test_pixel(&position, x, y);
            if (p[3] == 0) continue;
            float z = test_pixel(&normal, x, y)[3], spread = frame->camera.orthographic ? 1 : z;
            float ndc_x = ((float)x + 0.5f) / (float)frame->width * 2 - 1,
                  ndc_y = 1 - ((float)y + 0.5f) / (float)frame->height * 2;
            vec3 view = {(ndc_x * v.ndc_scale.x + v.ndc_offset.x) * spread,
                         (ndc_y * v.ndc_scale.y + v.ndc_offset.y) * spread, -z};
            vec3 world = mat4_point(&v.view_to_world, view);
            worst = fmax(worst, vec3_distance(world, (vec3){p[0], p[1], p[2]}) / (double)z);
        }
    free_picture(&normal);
    free_picture(&position);
    return worst;
}

static void test_deferred_equals_forward(void **state) {
    UNUSED(state);
    fnl_scene *scene = room();
    fnl_renderer *renderer = test_renderer(scene);
    for (int view = 0; view < 3; view++) {
        fnl_image colors[4], radiances[4];
        for (int i = 0; i < 4; i++) {
            fnl_frame frame = test_frame(FNL_OUTPUT_COLOR | FNL_OUTPUT_RADIANCE | FNL_OUTPUT_NORMAL | FNL_OUTPUT_POSITION);
            room_frame(&frame, view);
            frame.shading = i < 3 ? (fnl_shading)i : FNL_SHADING_DEFERRED;
            frame.gbuffer.prepass = i == 3;
            test_render_frame(renderer, &frame);
            colors[i] = test_read(renderer, FNL_OUTPUT_COLOR);
            radiances[i] = test_read(renderer, FNL_OUTPUT_RADIANCE);
            char plan[32768];
            assert_true(fnl_renderer_print(renderer, FNL_PRINT_PLAN, plan, sizeof plan) < sizeof plan);
            assert_int_equal(strstr(plan, "depth prepass") != NULL, i == 1 || i == 3);
            if (i == 0) {
                double error = position_error(renderer, &frame);
                print_message("view %d: rebuilt positions are off by %.2g of their depth\n", view, error);
                assert_true(error < 1e-3);
            }
        }
        print_message("view %d: deferred differs from forward by %g/255\n", view, test_difference(&colors[0], &colors[2]));
        assert_true(test_equal(&radiances[0], &radiances[1])); /* a prepass changes nothing at all */
        assert_true(test_equal(&radiances[2], &radiances[3]));
        assert_true(test_difference(&colors[0], &colors[2]) <= 2);
        for (int i = 0; i < 4; i++) {
            free_picture(&colors[i]);
            free_picture(&radiances[i]);
        }
    }
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

/* ---- glass ---- */

/* Two panes in front of a wall, and lights that reach all three, or stand between them and reach what is behind alone. */
static void test_glass(void **state) {
    UNUSED(state);
    fnl_scene *scene = test_scene();
    struct scene_material wall = scene_material_default(), panes[2];
    wall.metallic = 0;
    wall.roughness = 0.5f;
    wall.base_color = (vec4){0.7f, 0.6f, 0.5f, 1};
    panes[0] = panes[1] = wall;
    panes[0].alpha_mode = panes[1].alpha_mode = FNL_ALPHA_BLEND;
    panes[0].base_color = (vec4){0.9f, 0.1f, 0.1f, 0.4f};
    panes[1].base_color = (vec4){0.1f, 0.9f, 0.1f, 0.7f};
    const struct scene_material *materials[3] = {&wall, &panes[0], &panes[1]};
    static const float heights[3] = {0, 1, 2};
    static const int order[3] = {2, 0, 1}; /* the nearest is added first */
    for (int i = 0; i < 3; i++) {
        int k = order[i];
        test_place(scene, test_quad_mesh(scene, scene_add_material(scene, materials[k])), (vec3){0, 0, heights[k]},
                   (vec3){1, 1, 1});
    }
    fnl_light_params lights[12];
    for (uint32_t i = 0; i < COUNT_OF(lights);
         i++) { /* some between the panes, which light only what they are in front of */
        lights[i] = test_point((vec3){(float)(i % 4) * 0.5f - 0.75f, (float)(i / 4) * 0.6f - 0.6f, 0.4f + 0.25f * (float)i},
                               0.5f + 0.1f * (float)i, 2.5f);
        fnl_light_id id;
        assert_int_equal(fnl_scene_add_light(scene, &lights[i], &id), FNL_OK);
    }
    fnl_renderer *renderer = test_renderer(scene);
    for (uint32_t shading = 0; shading < FNL_SHADING_DEFERRED + 1; shading++) {
        fnl_image first = {0};
        for (uint32_t lists = 0; lists < FNL_LISTS_COUNT; lists++) {
            fnl_frame frame = test_frame(FNL_OUTPUT_RADIANCE);
            frame.shading = (fnl_shading)shading;
            frame.lists = (fnl_light_lists)lists;
            if (!fnl_shading_supports(frame.shading, frame.lists, frame.msaa)) continue;
            test_render_frame(renderer, &frame);
            fnl_image radiance = test_read(renderer, FNL_OUTPUT_RADIANCE);
            double worst = 0;
            for (uint32_t y = 1; y < 64; y += 4)
                for (uint32_t x = 1; x < 64; x += 4) {
                    double expected[3] = {0}, to_view[3] = {0, 0, 1};
                    for (int k = 0; k < 3; k++) {
                        struct reference_surface s = reference_surface_default();
                        s.position[0] = (x + 0.5) / 32 - 1;
                        s.position[1] = 1 - (y + 0.5) / 32;
                        s.position[2] = heights[k];
                        s.base_color[0] = materials[k]->base_color.x;
                        s.base_color[1] = materials[k]->base_color.y;
                        s.base_color[2] = materials[k]->base_color.z;
                        s.metallic = 0;
                        s.roughness = 0.5;
                        double layer[3], alpha = materials[k]->base_color.w;
                        reference_shade(&s, to_view, lights, COUNT_OF(lights), (fnl_vec3){0, 0, 0}, (fnl_vec3){0, 0, 0},
                                        layer);
                        for (int c = 0; c < 3; c++) expected[c] += alpha * (layer[c] - expected[c]);
                    }
                    for (int c = 0; c < 3; c++) worst = fmax(worst, fabs(test_pixel(&radiance, x, y)[c] / expected[c] - 1));
                }
            /* Deferred: the colour of the wall comes from 8 bits, off by half a per cent. */
            if (worst >= (shading == FNL_SHADING_DEFERRED ? 1e-2 : 1e-3))
                fail_msg("%s, %s: off by %g", fnl_value_name(FNL_ENUM_SHADING, frame.shading), fnl_value_name(FNL_ENUM_LISTS, frame.lists), worst);
            if (first.pixels) assert_true(test_equal(&first, &radiance));
            if (first.pixels)
                free_picture(&radiance);
            else
                first = radiance;
        }
        free_picture(&first);
    }
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

static void test_built_in_glass(void **state) {
    UNUSED(state);
    fnl_scene *scene = test_load("builtin:glass", false);
    fnl_renderer *renderer = test_renderer(scene);
    fnl_image forward = {0};
    for (uint32_t shading = 0; shading < FNL_SHADING_DEFERRED + 1; shading++) {
        fnl_image all = {0};
        for (uint32_t lists = 0; lists < FNL_LISTS_COUNT; lists++) {
            fnl_frame frame = test_frame(FNL_OUTPUT_COLOR | FNL_OUTPUT_RADIANCE);
            frame.width = 96;
            frame.height = 54;
            frame.shading = (fnl_shading)shading;
            frame.lists = (fnl_light_lists)lists;
            if (!fnl_shading_supports(frame.shading, frame.lists, frame.msaa)) continue;
            frame.exposure = FNL_EXPOSURE_AUTO;
            frame.tonemap = FNL_TONEMAP_KHRONOS_NEUTRAL;
            assert_int_equal(fnl_scene_query_camera(scene, 0, &frame.camera), FNL_OK);
            test_render_frame(renderer, &frame);
            fnl_image radiance = test_read(renderer, FNL_OUTPUT_RADIANCE), color = test_read(renderer, FNL_OUTPUT_COLOR);
            if (lists == 0)
                all = radiance;
            else {
                assert_true(test_equal(&all, &radiance));
                free_picture(&radiance);
            }
            if (forward.pixels) {
                assert_true(test_difference(&forward, &color) <= 2);
                free_picture(&color);
            } else {
                forward = color;
            }
        }
        free_picture(&all);
    }
    free_picture(&forward);
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

/* ---- the second pass does not know triangles ---- */

static uint32_t grid_mesh(fnl_scene *scene, uint32_t material, uint32_t side) {
    uint32_t vertex_count = (side + 1) * (side + 1), at = 0;
    vec3 *positions = ARENA_ARRAY(&scene->arena, vec3, vertex_count);
    uint32_t *indices = ARENA_ARRAY(&scene->arena, uint32_t, side * side * 6);
    for (uint32_t v = 0; v < vertex_count; v++)
        positions[v] =
            (vec3){(float)(v % (side + 1)) / (float)side * 2 - 1, (float)(v / (side + 1)) / (float)side * 2 - 1, 0};
    for (uint32_t y = 0; y < side; y++)
        for (uint32_t x = 0; x < side; x++) {
            uint32_t v = y * (side + 1) + x, quad[6] = {v, v + 1, v + side + 2, v, v + side + 2, v + side + 1};
            memcpy(indices + at, quad, sizeof quad);
            at += 6;
        }
    struct scene_primitive p = {
        .material = material, .vertex_count = vertex_count, .index_count = at, .indices = indices, .positions = positions};
    assert_int_equal(mesh_complete(&scene->arena, &p), FNL_OK);
    return scene_add_mesh(scene, "", &p, 1);
}

static void test_deferred_cost(void **state) {
    UNUSED(state);
    uint64_t evaluations[2], triangles[2];
    for (uint32_t i = 0; i < 2; i++) {
        fnl_scene *scene = test_scene();
        struct scene_material material = scene_material_default();
        uint32_t mesh =
            grid_mesh(scene, scene_add_material(scene, &material), i == 0 ? 10 : 32); /* ten times the triangles */
        test_place(scene, mesh, (vec3){0, 0, 0}, (vec3){1, 1, 1});
        test_place(scene, mesh, (vec3){0, 0, 0.5f}, (vec3){0.5f, 0.5f, 1});
        for (int k = 0; k < 9; k++) {
            fnl_light_params light = test_point((vec3){(float)(k % 3) - 1, (float)(k / 3) - 1, 1}, 1, 1.2f);
            fnl_light_id id;
            assert_int_equal(fnl_scene_add_light(scene, &light, &id), FNL_OK);
        }
        fnl_frame frame = test_frame(FNL_OUTPUT_RADIANCE);
        frame.shading = FNL_SHADING_DEFERRED;
        frame.lists = FNL_LISTS_TILED;
        frame.count_lights = true;
        fnl_renderer *renderer = test_renderer(scene);
        test_render_frame(renderer, &frame);
        fnl_frame_stats stats;
        assert_int_equal(fnl_renderer_query_stats(renderer, &stats), FNL_OK);
        evaluations[i] = stats.evaluations;
        triangles[i] = stats.triangles_visible;
        fnl_renderer_destroy(&renderer);
        fnl_scene_destroy(&scene);
    }
    print_message("%llu triangles: %llu evaluations; %llu triangles: %llu\n", (unsigned long long)triangles[0],
                  (unsigned long long)evaluations[0], (unsigned long long)triangles[1], (unsigned long long)evaluations[1]);
    assert_int_equal(triangles[0], 400);
    assert_int_equal(triangles[1], 4096);
    assert_true(evaluations[0] > 4096 && evaluations[0] < 4096 * 9);
    assert_int_equal(evaluations[0], evaluations[1]);
}

/* ---- multisampling ---- */

static void test_msaa_edges(void **state) {
    UNUSED(state);
    fnl_device_info info;
    assert_int_equal(fnl_device_query_info(test_device, &info), FNL_OK);
    if (info.max_msaa < 4) skip();
    fnl_scene *scene = test_scene();
    struct scene_material front = test_unlit(1, 0.5f, 0.25f), back = test_unlit(0, 0.1f, 0.2f);
    mat4 turned = mat4_from_trs((vec3){0.05f, 0.02f, 0.5f}, quat_axis_angle((vec3){0, 0, 1}, 0.3f), (vec3){0.5f, 0.6f, 1});
    scene_add_node(scene, "", SCENE_NONE, &turned, test_quad_mesh(scene, scene_add_material(scene, &front)));
    test_place(scene, test_quad_mesh(scene, scene_add_material(scene, &back)), (vec3){0, 0, 0}, (vec3){0.9f, 0.9f, 1});
    fnl_renderer *renderer = test_renderer(scene);
    enum { FINE = 16 };
    fnl_frame frame = test_frame(FNL_OUTPUT_RADIANCE);
    frame.width = frame.height = 64 * FINE;
    test_render_frame(renderer, &frame);
    fnl_image fine = test_read(renderer, FNL_OUTPUT_RADIANCE);
    frame.width = frame.height = 64;
    fnl_image pictures[2];
    for (uint32_t shading = 0; shading < 2; shading++) {
        frame.msaa = 4;
        frame.shading = (fnl_shading)shading;
        test_render_frame(renderer, &frame);
        pictures[shading] = test_read(renderer, FNL_OUTPUT_RADIANCE);
    }
    assert_true(test_equal(&pictures[0], &pictures[1]));
    frame.msaa = 1;
    test_render_frame(renderer, &frame);
    fnl_image plain = test_read(renderer, FNL_OUTPUT_RADIANCE);
    double worst = 0, sum = 0, plain_sum = 0;
    uint32_t edges = 0;
    for (uint32_t y = 0; y < 64; y++)
        for (uint32_t x = 0; x < 64; x++) {
            double coverage = 0;
            for (uint32_t k = 0; k < FINE * FINE; k++)
                coverage += test_pixel(&fine, x * FINE + k % FINE, y * FINE + k / FINE)[0];
            coverage /= FINE * FINE;
            double error = fabs(test_pixel(&pictures[0], x, y)[0] - coverage);
            if (coverage == 0 || coverage == 1) {
                assert_true(error == 0);
                continue;
            }
            edges++;
            worst = fmax(worst, error);
            sum += error;
            plain_sum += fabs(test_pixel(&plain, x, y)[0] - coverage);
        }
    print_message("%u edge pixels: mean error %.3f with 4 samples, %.3f with one; worst %.3f\n", edges, sum / edges,
                  plain_sum / edges, worst);
    assert_true(edges > 100 && worst < 0.45 && sum / edges < 0.12 && sum < plain_sum / 2);
    frame.shading = FNL_SHADING_MOBILE;
    frame.msaa = 4;
    assert_false(fnl_shading_supports(frame.shading, FNL_LISTS_AUTO, frame.msaa));
    assert_int_equal(fnl_renderer_render(renderer, &frame), FNL_ERROR_UNSUPPORTED);
    free_picture(&fine);
    free_picture(&plain);
    free_picture(&pictures[0]);
    free_picture(&pictures[1]);
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        {"ES-9, ES-3, ES-4e: deferred equals forward, and prepasses change nothing", test_deferred_equals_forward, NULL,
         NULL, NULL},
        {"ES-19: glass has the lights of the wall behind it, in the right order", test_glass, NULL, NULL, NULL},
        {"ES-19: glass of the built-in scene", test_built_in_glass, NULL, NULL, NULL},
        {"MP-19: ten times the triangles leave the cost of deferred shading", test_deferred_cost, NULL, NULL, NULL},
        cmocka_unit_test(test_msaa_edges),
    };
    return cmocka_run_group_tests_name("shading orders", tests, test_group_begin, test_group_end);
}
