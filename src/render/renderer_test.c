/* SPDX-License-Identifier: MIT */
/** What the renderer promises apart from the picture: cost, memory, edits, misuse, failures, several renderers. */
#include "tests/guard.h"
#include "tests/render_test.h"
#include "tests/vulkan_spy.h"

/* A small scene with everything: opaque, cutout and blended surfaces, points of all list kinds, two moving spheres. */
struct stage_set {
    fnl_scene *scene;
    fnl_mesh_id mesh;
    fnl_instance_id instances[4];
    fnl_light_id lights[6];
};

static fnl_mesh_id add_ball(fnl_scene *scene, const fnl_material_params *material) {
    enum { RINGS = 6, COLUMNS = 12, VERTICES = (RINGS + 1) * (COLUMNS + 1) };
    float positions[VERTICES * 3];
    uint32_t indices[RINGS * COLUMNS * 6], at = 0;
    for (uint32_t v = 0; v < VERTICES; v++) {
        float theta = PI * (float)(v / (COLUMNS + 1)) / RINGS, phi = 2 * PI * (float)(v % (COLUMNS + 1)) / COLUMNS;
        positions[v * 3] = sinf(theta) * sinf(phi);
        positions[v * 3 + 1] = cosf(theta);
        positions[v * 3 + 2] = sinf(theta) * cosf(phi);
        if (v / (COLUMNS + 1) == RINGS || v % (COLUMNS + 1) == COLUMNS) continue;
        uint32_t quad[6] = {v, v + COLUMNS + 1, v + COLUMNS + 2, v, v + COLUMNS + 2, v + 1};
        memcpy(indices + at, quad, sizeof quad);
        at += 6;
    }
    fnl_mesh_params params = {.vertex_count = VERTICES,
                              .index_count = at,
                              .positions = positions,
                              .normals = positions,
                              .indices = indices,
                              .material = test_material(scene, material)};
    fnl_mesh_id mesh;
    assert_int_equal(fnl_scene_add_mesh(scene, &params, &mesh), FNL_OK);
    return mesh;
}

static fnl_mat4 placed(float x, float y, float z, float size) {
    return mat4_from_trs((vec3){x, y, z}, quat_identity(), (vec3){size, size, size});
}

static struct stage_set stage_set_open(void) {
    struct stage_set s = {.scene = test_scene()};
    fnl_material_params material = fnl_material_params_default();
    material.roughness = 0.5f;
    material.metallic = 0.3f;
    s.mesh = add_ball(s.scene, &material);
    material.alpha_mode = FNL_ALPHA_BLEND;
    material.base_color[3] = 0.5f;
    fnl_mesh_id glass = add_ball(s.scene, &material);
    material.alpha_mode = FNL_ALPHA_MASK;
    material.double_sided = true;
    fnl_mesh_id leaf = add_ball(s.scene, &material);
    const fnl_mesh_id meshes[4] = {s.mesh, s.mesh, glass, leaf};
    for (int i = 0; i < 4; i++) {
        fnl_mat4 matrix = placed((float)(i % 2) - 0.5f, (float)(i / 2) - 0.5f, (float)i * 0.2f, 0.45f);
        assert_int_equal(fnl_scene_add_instance(s.scene, meshes[i], &matrix, &s.instances[i]), FNL_OK);
    }
    for (int i = 0; i < 6; i++) {
        fnl_light_params light =
            test_point((vec3){(float)(i % 3) * 0.8f - 0.8f, (float)(i / 3) - 0.5f, 1.6f}, 1 + (float)i * 0.2f, 2.5f);
        if (i == 4) light.kind = FNL_LIGHT_SPOT;
        if (i == 5) light.kind = FNL_LIGHT_DIRECTIONAL;
        assert_int_equal(fnl_scene_add_light(s.scene, &light, &s.lights[i]), FNL_OK);
    }
    assert_int_equal(fnl_scene_set_ambient(s.scene, (vec3){0.1f, 0.1f, 0.2f}, (vec3){0.1f, 0.05f, 0}), FNL_OK);
    return s;
}

static fnl_device *quiet_device; /* without validation, which takes time and memory of its own */

static int begin(void **state) {
    if (test_group_begin(state) != 0) return -1;
    fnl_device_params params = fnl_device_params_default();
    params.host = test_host(&test_device_memory);
    params.cache_folder = "";
    return fnl_device_create(&params, &quiet_device) == FNL_OK ? 0 : -1;
}

static int end(void **state) {
    fnl_device_destroy(&quiet_device);
    return test_group_end(state);
}

/* Frames in the steady state, during which nobody reads the scene's lights or its nodes: recording does not walk over them. Draws and
   dispatches of the last one. */
static uint32_t shoot_guarded(fnl_scene *scene, const fnl_frame *frame, fnl_frame_stats *last) {
    enum { WARM = 2 };
    fnl_renderer *renderer;
    spy_begin(test_device);
    assert_int_equal(fnl_renderer_create(test_device, scene, &renderer), FNL_OK);
    for (int i = 0; i < WARM; i++) test_render_frame(renderer, frame);
    struct guard guards[] = {guard_begin(scene->lights.data, scene->lights.count * sizeof *scene->lights.data),
                             guard_begin(scene->light_slots.data, scene->light_slots.count * sizeof *scene->light_slots.data),
                             guard_begin(scene->nodes.data, scene->nodes.count * sizeof *scene->nodes.data)};
    test_render_frame(renderer, frame);
    spy_clear();
    test_render_frame(renderer, frame);
    for (uint32_t i = 0; i < COUNT_OF(guards); i++) guard_end(&guards[i]);
    assert_int_equal(fnl_renderer_query_stats(renderer, last), FNL_OK);
    fnl_renderer_destroy(&renderer);
    spy_end();
    return spy.work_count;
}

/* ---- cost ---- */

/* Clusters and trees of the CPU are its work by definition; auto is one of the others, or one of these. */
static bool measures_recording(uint32_t lists) {
    return lists != FNL_LISTS_CLUSTERED_CPU && lists != FNL_LISTS_TREE && lists != FNL_LISTS_AUTO &&
           fnl_shading_supports(FNL_SHADING_DEFERRED, (fnl_light_lists)lists, 1);
}

/* Nor are there more commands: a dispatch of so many lights may be split, no more. */
static void test_recording_does_not_grow_with_lights(void **state) {
    UNUSED(state);
    static const uint32_t counts[2] = {16, 65536};
    struct stage_set sets[2];
    for (int i = 0; i < 2; i++) {
        sets[i] = stage_set_open();
        assert_int_equal(fnl_scene_scatter_lights(sets[i].scene, counts[i], 1), FNL_OK);
    }
    for (uint32_t lists = 0; lists < FNL_LISTS_COUNT; lists++) {
        if (!measures_recording(lists)) continue;
        uint32_t commands[2];
        for (int i = 0; i < 2; i++) {
            fnl_frame frame = test_frame(FNL_OUTPUT_COLOR);
            fnl_frame_stats stats;
            frame.width = frame.height = 8;
            frame.shading = FNL_SHADING_DEFERRED;
            frame.lists = (fnl_light_lists)lists;
            frame.record_threads = 1;
            commands[i] = shoot_guarded(sets[i].scene, &frame, &stats);
            assert_int_equal(stats.lights_total, counts[i] + 6);
        }
        print_message("%s: %u commands with 16 lights, %u with 65536\n", fnl_value_name(FNL_ENUM_LISTS, (fnl_light_lists)lists), commands[0],
                      commands[1]);
        assert_true(commands[0] > 0 && commands[1] < 2 * commands[0]);
    }
    for (int i = 0; i < 2; i++) fnl_scene_destroy(&sets[i].scene);
}

static void test_recording_does_not_grow_with_instances(void **state) {
    UNUSED(state);
    uint32_t commands[3];
    for (int i = 0; i < 3; i++) {
        struct stage_set s = stage_set_open();
        uint32_t visible = 4;
        if (i == 1) /* instances of their own */
            for (uint32_t k = 0; k < 50000; k++) {
                fnl_mat4 matrix = placed((float)(k % 200) * 3 + 5, (float)(k / 200), 0, 0.5f);
                fnl_instance_id id;
                assert_int_equal(fnl_scene_add_instance(s.scene, s.mesh, &matrix, &id), FNL_OK);
            }
        if (i == 2) { /* a million of one node, five of them in view */
            mat4 *matrices = arena_allocate(&s.scene->arena, 1000000 * sizeof *matrices);
            for (uint32_t k = 0; k < 1000000; k++)
                matrices[k] = k % 200000 == 7 ? placed((float)(k / 200000) * 0.4f - 0.8f, 0, 1, 0.1f)
                                              : placed((float)(k % 1000) * 3 + 5, (float)(k / 1000), 0, 0.5f);
            struct scene_node *node = &s.scene->nodes.data[s.instances[0].index];
            node->instances = matrices;
            node->instance_count = 1000000;
            node->world = mat4_identity();
            node->local_exact = node->world_exact = affine_identity();
            visible += 4; /* the node's own sphere is gone */
        }
        fnl_frame frame = test_frame(FNL_OUTPUT_COLOR);
        frame.shading = FNL_SHADING_DEFERRED;
        frame.record_threads = 1;
        fnl_frame_stats stats;
        commands[i] = shoot_guarded(s.scene, &frame, &stats);
        assert_int_equal(stats.items_visible, visible);
        if (i == 2) assert_int_equal(stats.items, 1000003);
        fnl_scene_destroy(&s.scene);
    }
    print_message("%u commands for 4 instances, %u for 50004, %u for 1000003\n", commands[0], commands[1], commands[2]);
    assert_true(commands[0] > 0 && commands[1] < 2 * commands[0] && commands[2] < 2 * commands[0]);
}

static void test_steady_state_allocates_nothing(void **state) {
    UNUSED(state);
    enum { WARM = 3 * GPU_FRAMES_IN_FLIGHT, FRAMES = 2 }; /* pools grow after the first */
    struct stage_set s = stage_set_open();
    fnl_renderer *renderer;
    assert_int_equal(fnl_renderer_create(quiet_device, s.scene, &renderer), FNL_OK);
    for (uint32_t shading = 0; shading < FNL_SHADING_COUNT; shading++)
        for (uint32_t lists = 0; lists < FNL_LISTS_COUNT; lists++) {
            fnl_frame frame = test_frame(FNL_OUTPUT_COLOR | FNL_OUTPUT_RADIANCE | FNL_OUTPUT_NORMAL);
            frame.width = frame.height = 24;
            frame.shading = (fnl_shading)shading;
            frame.lists = (fnl_light_lists)lists;
            if (!harness_tries(frame.shading, frame.lists, 13)) continue;
            frame.exposure = FNL_EXPOSURE_AUTO;
            frame.timers = frame.count_lights = true;
            frame.record_threads = lists % 2 ? 0 : 1;
            frame.pin_choice = true;
            if (lists == 1 && frame.shading <= FNL_SHADING_DEFERRED) frame.msaa = 4;
            long long before = 0;
            for (int i = -WARM; i < FRAMES; i++) {
                if (i == 0) before = test_device_memory.allocations;
                fnl_frame_stats stats;
                test_render_frame(renderer, &frame);
                assert_int_equal(fnl_renderer_query_stats(renderer, &stats), FNL_OK);
                assert_true(stats.pass_count > 5);
            }
            if (test_device_memory.allocations != before)
                fail_msg("%s, %s: %lld allocations in two frames", fnl_value_name(FNL_ENUM_SHADING, frame.shading),
                         fnl_value_name(FNL_ENUM_LISTS, frame.lists), test_device_memory.allocations - before);
        }
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&s.scene);
}

/* ---- edits ---- */

static fnl_frame edit_frame(uint32_t step) {
    fnl_frame frame = test_frame(FNL_OUTPUT_RADIANCE | FNL_OUTPUT_POSITION);
    frame.shading = (fnl_shading)(step % (FNL_SHADING_DEFERRED + 1));
    frame.lists = (fnl_light_lists)(step % FNL_LISTS_COUNT);
    if (!fnl_shading_supports(frame.shading, frame.lists, frame.msaa)) frame.lists = FNL_LISTS_CLUSTERED;
    return frame;
}

static void edit(struct stage_set *s, uint32_t step) {
    fnl_mat4 matrix;
    fnl_light_params light = test_point((vec3){0.2f, 0.4f, 1.5f}, 4, 3);
    fnl_light_id added;
    switch (step) {
    case 0:
        assert_int_equal(fnl_scene_set_light(s->scene, s->lights[0], &light), FNL_OK);
        break;
    case 1:
        assert_int_equal(fnl_scene_remove_light(s->scene, s->lights[1]), FNL_OK);
        break;
    case 2:
        light.position.x = -0.7f;
        assert_int_equal(fnl_scene_add_light(s->scene, &light, &added), FNL_OK);
        break;
    case 3: /* the array on the device must grow */
        for (int i = 0; i < 50; i++) {
            light.position = (vec3){(float)(i % 10) * 0.2f - 1, (float)(i / 10) * 0.4f - 1, 1.3f};
            light.intensity = 0.1f;
            assert_int_equal(fnl_scene_add_light(s->scene, &light, &added), FNL_OK);
        }
        break;
    case 4:
        matrix = placed(0.1f, 0.2f, 0.5f, 0.3f);
        assert_int_equal(fnl_scene_set_instance_transform(s->scene, s->instances[0], &matrix), FNL_OK);
        break;
    case 5: /* twice, and another */
        for (int i = 0; i < 3; i++) {
            matrix = placed(-0.3f + 0.1f * (float)i, -0.2f, 0.7f, 0.25f);
            assert_int_equal(fnl_scene_set_instance_transform(s->scene, s->instances[i == 1], &matrix), FNL_OK);
        }
        break;
    case 6: /* mirrored: what was the front's winding is now the back's */
        matrix = placed(0.4f, 0.4f, 0.7f, 0.35f);
        for (int i = 0; i < 3; i++) matrix.m[i] = -matrix.m[i];
        assert_int_equal(fnl_scene_set_instance_transform(s->scene, s->instances[1], &matrix), FNL_OK);
        break;
    case 7:
        assert_int_equal(fnl_scene_remove_instance(s->scene, s->instances[3]), FNL_OK);
        break;
    case 8:
        matrix = placed(-0.6f, 0.6f, 0.2f, 0.3f);
        assert_int_equal(fnl_scene_add_instance(s->scene, s->mesh, &matrix, &s->instances[3]), FNL_OK);
        break;
    case 9:
        assert_int_equal(fnl_scene_set_ambient(s->scene, (vec3){0, 0.5f, 0}, (vec3){0.5f, 0, 0}), FNL_OK);
        break;
    case 10:
        assert_int_equal(fnl_scene_set_background(s->scene, (vec3){1, 2, 3}), FNL_OK);
        break;
    case 11: {
        fnl_material_params material = fnl_material_params_default();
        material.emissive[0] = 3;
        fnl_mesh_id mesh = add_ball(s->scene, &material);
        matrix = placed(0.7f, -0.7f, 1, 0.2f);
        assert_int_equal(fnl_scene_add_instance(s->scene, mesh, &matrix, &s->instances[0]), FNL_OK);
        break;
    }
    default: /* move back to a plain winding, and everything at once */
        edit(s, 5);
        edit(s, 3);
        break;
    }
}

static void test_edits_show_in_the_next_frame(void **state) {
    UNUSED(state);
    struct stage_set s = stage_set_open();
    fnl_renderer *renderer = test_renderer(s.scene);
    fnl_frame frame = edit_frame(0);
    test_render_frame(renderer, &frame);
    for (uint32_t step = 0; step < 13; step++) {
        frame = edit_frame(step);
        test_render_frame(renderer, &frame);
        fnl_image before = test_read(renderer, FNL_OUTPUT_RADIANCE);
        edit(&s, step);
        test_render_frame(renderer, &frame);
        fnl_image after = test_read(renderer, FNL_OUTPUT_RADIANCE),
                  fresh = test_render(s.scene, &frame, FNL_OUTPUT_RADIANCE);
        if (test_equal(&before, &after)) fail_msg("edit %u does not show", step);
        if (!test_equal(&after, &fresh)) fail_msg("after edit %u the picture is not that of a new renderer", step);
        test_render_frame(renderer, &frame); /* and it stays */
        fnl_image later = test_read(renderer, FNL_OUTPUT_RADIANCE);
        assert_true(test_equal(&after, &later));
        free_picture(&before);
        free_picture(&after);
        free_picture(&fresh);
        free_picture(&later);
    }
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&s.scene);
}

static void test_time(void **state) {
    UNUSED(state);
    fnl_scene *scene = test_load("Fox.glb", true);
    fnl_light_params sun = fnl_light_params_default();
    sun.kind = FNL_LIGHT_DIRECTIONAL;
    fnl_light_id id;
    assert_int_equal(fnl_scene_add_light(scene, &sun, &id), FNL_OK);
    fnl_frame frame = test_frame(FNL_OUTPUT_RADIANCE);
    assert_int_equal(fnl_scene_query_framing_camera(scene, 1, &frame.camera), FNL_OK);
    fnl_renderer *renderer = test_renderer(scene);
    fnl_image last = {0};
    for (int i = 0; i < 4; i++) {
        assert_int_equal(fnl_scene_set_time(scene, 2, i % 2 * 0.4), FNL_OK);
        test_render_frame(renderer, &frame);
        fnl_image now = test_read(renderer, FNL_OUTPUT_RADIANCE), fresh = test_render(scene, &frame, FNL_OUTPUT_RADIANCE);
        assert_true(test_equal(&now, &fresh));
        if (last.pixels) assert_false(test_equal(&now, &last));
        if (last.pixels) free_picture(&last);
        free_picture(&fresh);
        last = now;
    }
    free_picture(&last);
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

/* Where the time goes: parts of the calling thread without gaps, and passes one after the other. */
static void test_times_of_a_frame(void **state) {
    UNUSED(state);
    static const char *const names[] = {"update the scene", "wait for the GPU", "prepare", "declare passes", "compile the graph", "place resources",
                                        "record", "submit", "clean up"};
    struct stage_set s = stage_set_open();
    fnl_renderer *renderer;
    fnl_frame_stats stats;
    assert_int_equal(fnl_renderer_create(quiet_device, s.scene, &renderer), FNL_OK);
    fnl_frame frame = test_frame(FNL_OUTPUT_COLOR);
    frame.timers = true;
    for (int i = 0; i < 3; i++) {
        test_render_frame(renderer, &frame);
        assert_int_equal(fnl_renderer_query_stats(renderer, &stats), FNL_OK);
        assert_int_equal(stats.cpu_section_count, COUNT_OF(names));
        double end = 0, own = 0, passes = 0;
        for (uint32_t k = 0; k < stats.cpu_section_count; k++) {
            const fnl_cpu_section *section = &stats.cpu_sections[k];
            assert_string_equal(section->name, names[k]);
            assert_true(fabs(section->begin_milliseconds - end) < 1e-6 && section->milliseconds >= 0);
            end += section->milliseconds;
            if (k >= 2) own += section->milliseconds;
        }
        assert_true(fabs(own - stats.cpu_milliseconds) < 1e-3);
        assert_true(stats.cpu_sections[3].milliseconds > 0 && stats.cpu_sections[4].milliseconds > 0 && stats.cpu_sections[6].milliseconds > 0);
        assert_true(stats.pass_count > 3 && stats.passes[0].begin_milliseconds == 0);
        for (uint32_t k = 0; k < stats.pass_count; k++) {
            assert_int_equal(stats.passes[k].queue, FNL_QUEUE_GRAPHICS);
            passes += stats.passes[k].milliseconds;
            if (k > 0) assert_true(stats.passes[k].begin_milliseconds + 1e-6 >= stats.passes[k - 1].begin_milliseconds + stats.passes[k - 1].milliseconds);
        }
        assert_true(fabs(passes - stats.gpu_milliseconds) < 1e-6);
        assert_int_equal(stats.candidate_count, 0);
        assert_null(stats.candidates);
    }
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&s.scene);
}

static void test_resize(void **state) {
    UNUSED(state);
    static const uint32_t sizes[][2] = {{64, 64}, {100, 30}, {1, 1}, {17, 200}, {64, 64}};
    struct stage_set s = stage_set_open();
    fnl_renderer *renderer = test_renderer(s.scene);
    for (uint32_t i = 0; i < COUNT_OF(sizes); i++) {
        fnl_frame frame = test_frame(FNL_OUTPUT_RADIANCE | FNL_OUTPUT_COLOR);
        frame.width = sizes[i][0];
        frame.height = sizes[i][1];
        frame.shading = (fnl_shading)(i % (FNL_SHADING_DEFERRED + 1));
        frame.lists = FNL_LISTS_TILED;
        frame.count_lights = true;
        for (int k = 0; k < 2; k++) test_render_frame(renderer, &frame);
        fnl_image now = test_read(renderer, FNL_OUTPUT_RADIANCE), fresh = test_render(s.scene, &frame, FNL_OUTPUT_RADIANCE);
        assert_int_equal(now.width, sizes[i][0]);
        assert_int_equal(now.height, sizes[i][1]);
        assert_true(test_equal(&now, &fresh));
        fnl_frame_stats stats;
        assert_int_equal(fnl_renderer_query_stats(renderer, &stats), FNL_OK);
        assert_true(stats.max_per_pixel <= stats.lights_total * 3);
        free_picture(&now);
        free_picture(&fresh);
    }
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&s.scene);
}

/* ---- misuse ---- */

static void test_misuse(void **state) {
    UNUSED(state);
    struct stage_set s = stage_set_open();
    fnl_renderer *renderer = test_renderer(s.scene), *none = NULL;
    fnl_image image;
    fnl_frame_stats stats;
    assert_int_equal(fnl_renderer_create(NULL, s.scene, &none), FNL_ERROR_INVALID);
    assert_int_equal(fnl_renderer_create(test_device, NULL, &none), FNL_ERROR_INVALID);
    assert_int_equal(fnl_renderer_create(test_device, s.scene, NULL), FNL_ERROR_INVALID);
    assert_null(none);
    assert_int_equal(fnl_renderer_render(NULL, NULL), FNL_ERROR_INVALID);
    assert_int_equal(fnl_renderer_read(renderer, FNL_OUTPUT_COLOR, &image), FNL_ERROR_INVALID); /* no frame yet */
    assert_int_equal(fnl_renderer_query_stats(renderer, &stats), FNL_ERROR_INVALID);
    bool is_done = false;
    assert_true(fnl_renderer_query_done(renderer, &is_done) == FNL_OK && is_done);
    fnl_renderer_destroy(NULL);
    fnl_renderer_destroy(&none);
    assert_int_equal(fnl_renderer_print(NULL, FNL_PRINT_PLAN, NULL, 0), 0);
    assert_null(fnl_value_name(FNL_ENUM_SHADING, (fnl_shading)77));
    assert_null(fnl_value_name(FNL_ENUM_LISTS, FNL_LISTS_COUNT));
    assert_null(fnl_value_name(FNL_ENUM_TONEMAP, (fnl_tonemap)-1));
    assert_null(fnl_value_name(FNL_ENUM_DEBUG_VIEW, FNL_DEBUG_COUNT));

    fnl_frame good = test_frame(FNL_OUTPUT_RADIANCE);
    test_render_frame(renderer, &good);
    fnl_image first = test_read(renderer, FNL_OUTPUT_RADIANCE);
    is_done = false;
    assert_true(fnl_renderer_query_done(renderer, &is_done) == FNL_OK && is_done);
    fnl_frame bad[24];
    uint32_t count = 0;
#define BAD(change) (bad[count] = good, bad[count].change, count++)
    BAD(width = 0);
    BAD(height = 0);
    BAD(width = 16385);
    BAD(msaa = 3);
    BAD(msaa = 16);
    BAD(visibility.sort = FNL_VISIBILITY_SORT_COUNT);
    BAD(shading = FNL_SHADING_COUNT);
    BAD(shading = (fnl_shading)-1);
    BAD(lists = FNL_LISTS_COUNT);
    BAD(tonemap = FNL_TONEMAP_COUNT);
    BAD(exposure = (fnl_exposure)3);
    BAD(debug = FNL_DEBUG_COUNT);
    BAD(outputs = 128);
    BAD(camera.position.x = NAN);
    BAD(camera.target = good.camera.position);
    BAD(camera.near_distance = -1);
    BAD(camera.near_distance = 0);
    bad[count - 1].camera.orthographic = false;
    BAD(camera.far_distance = 0.1f);
    BAD(camera.vertical_extent = -1);
    BAD(camera.shift.x = INFINITY);
    BAD(camera.up.y = NAN);
    BAD(exposure = FNL_EXPOSURE_EV);
    bad[count - 1].ev = NAN;
    BAD(camera.orthographic = false);
    bad[count - 1].camera.vertical_fov = PI;
#undef BAD
    for (uint32_t i = 0; i < count; i++) {
        test_device_memory.errors = 0;
        fnl_result result = fnl_renderer_render(renderer, &bad[i]);
        if (result != FNL_ERROR_INVALID || test_device_memory.errors == 0)
            fail_msg("bad frame %u gives '%s' and %d lines", i, fnl_result_name(result), test_device_memory.errors);
        fnl_image still = test_read(renderer, FNL_OUTPUT_RADIANCE); /* the last good frame is still there */
        assert_true(test_equal(&first, &still));
        free_picture(&still);
    }
    assert_int_equal(fnl_renderer_read(renderer, FNL_OUTPUT_COLOR, &image), FNL_ERROR_INVALID); /* was not asked for */
    assert_null(image.pixels);
    assert_int_equal(fnl_renderer_read(renderer, (fnl_output)3, &image), FNL_ERROR_INVALID);
    assert_int_equal(fnl_renderer_read(renderer, (fnl_output)0, &image), FNL_ERROR_INVALID);
    assert_int_equal(fnl_renderer_read(renderer, FNL_OUTPUT_RADIANCE, NULL), FNL_ERROR_INVALID);
    assert_int_equal(fnl_renderer_query_stats(renderer, NULL), FNL_ERROR_INVALID);
    test_render_frame(renderer, &good);
    fnl_image again = test_read(renderer, FNL_OUTPUT_RADIANCE);
    assert_true(test_equal(&first, &again));
    free_picture(&first);
    free_picture(&again);

    /* No picture at all, an up vector along the view, a view from inside of things, nothing to see: not misuse. */
    good.outputs = 0;
    test_render_frame(renderer, &good);
    good.outputs = FNL_OUTPUT_RADIANCE;
    good.camera.up = (vec3){0, 0, 1};
    test_render_frame(renderer, &good);
    first = test_read(renderer, FNL_OUTPUT_RADIANCE);
    for (uint32_t i = 0; i < 64 * 64 * 4; i++) assert_true(isfinite(((float *)first.pixels)[i]));
    free_picture(&first);
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&s.scene);
}

static void test_empty_scene(void **state) {
    UNUSED(state);
    for (uint32_t shading = 0; shading < FNL_SHADING_COUNT; shading++)
        for (uint32_t lists = 0; lists < FNL_LISTS_COUNT; lists++) {
            fnl_frame frame = test_frame(FNL_OUTPUT_RADIANCE);
            frame.shading = (fnl_shading)shading;
            frame.lists = (fnl_light_lists)lists;
            if (!harness_tries(frame.shading, frame.lists, 13)) continue;
            fnl_scene *scene = test_scene();
            assert_int_equal(fnl_scene_set_background(scene, (vec3){0.5f, 1, 2}), FNL_OK);
            fnl_image radiance = test_render(scene, &frame, FNL_OUTPUT_RADIANCE);
            assert_pixel(&radiance, 5, 5, 0.5, 1, 2, 0);
            free_picture(&radiance);
            fnl_scene_destroy(&scene);
        }
}

/* ---- failures ---- */

/* Memory runs out at the n-th allocation of a renderer's life, for all n: a clean error, and the renderer still works. */
static void test_allocation_failures(void **state) {
    UNUSED(state);
    struct test_memory memory = {0};
    fnl_device *device = test_device_create(&memory);
    struct stage_set s = stage_set_open();
    fnl_frame frame = test_frame(FNL_OUTPUT_RADIANCE);
    frame.shading = FNL_SHADING_DEFERRED;
    frame.lists = FNL_LISTS_CLUSTERED_CPU;
    frame.count_lights = true;
    fnl_image expected = test_render(s.scene, &frame, FNL_OUTPUT_RADIANCE);
    uint32_t failures = 0, recovered = 0;
    fnl_result result = FNL_ERROR_MEMORY;
    for (uint32_t n = 1; result != FNL_OK; n += n < 150 ? 1 : 7) {
        assert_true(n < 5000);
        fnl_renderer *renderer = NULL;
        memory.errors = 0;
        memory.fail_at = memory.allocations + n;
        result = fnl_renderer_create(device, s.scene, &renderer);
        assert_true((renderer != NULL) == (result == FNL_OK));
        if (result == FNL_OK) result = fnl_renderer_render(renderer, &frame);
        memory.fail_at = 0;
        if (result != FNL_OK) {
            failures++;
            assert_int_equal(result, FNL_ERROR_MEMORY);
            assert_true(memory.errors > 0);
        }
        if (renderer) {
            fnl_image image;
            if (result != FNL_OK)
                assert_int_equal(fnl_renderer_read(renderer, FNL_OUTPUT_RADIANCE, &image), FNL_ERROR_INVALID);
            assert_int_equal(fnl_renderer_render(renderer, &frame), FNL_OK);
            assert_int_equal(fnl_renderer_read(renderer, FNL_OUTPUT_RADIANCE, &image), FNL_OK);
            if (!test_equal(&image, &expected)) fail_msg("after failure %u of allocations the picture is another", n);
            fnl_host host = test_host(&memory);
            fnl_image_free(&host, &image);
            fnl_renderer_destroy(&renderer);
            recovered++;
        }
    }
    print_message("%u allocations failed; %u renderers went on\n", failures, recovered);
    assert_true(failures > 20 && recovered > 10);
    free_picture(&expected);
    fnl_scene_destroy(&s.scene);
    test_device_destroy(&device);
    assert_int_equal(memory.live_bytes, 0);
    assert_int_equal(memory.wrong_sizes, 0);
}

/* The same in a later frame, with edits of all kinds to send and a larger picture: nothing of them may be lost. */
static void test_late_allocation_failures(void **state) {
    UNUSED(state);
    struct test_memory memory = {0};
    fnl_device *device = test_device_create(&memory);
    struct stage_set s = stage_set_open();
    fnl_renderer *renderer;
    assert_int_equal(fnl_renderer_create(device, s.scene, &renderer), FNL_OK);
    uint32_t failures = 0;
    bool failed = true;
    for (uint32_t n = 1; failed; n++) {
        fnl_frame frame = test_frame(FNL_OUTPUT_RADIANCE | FNL_OUTPUT_COLOR);
        frame.lists = n % 2 ? FNL_LISTS_CLUSTERED_CPU : FNL_LISTS_TILED;
        frame.shading = FNL_SHADING_DEFERRED;
        frame.count_lights = true;
        assert_int_equal(fnl_renderer_render(renderer, &frame), FNL_OK);
        edit(&s, 0);
        edit(&s, 4 + n % 2 * 7);
        fnl_light_params light = test_point((vec3){(float)n * 0.01f, 0.1f, 1.5f}, 2, 3);
        assert_int_equal(fnl_scene_set_light(s.scene, s.lights[2], &light), FNL_OK);
        frame.width = 20 + n;
        frame.height = 70 + n;
        memory.errors = 0;
        memory.fail_at = memory.allocations + n;
        fnl_result result = fnl_renderer_render(renderer, &frame);
        memory.fail_at = 0;
        failed = result != FNL_OK;
        assert_true(!failed || memory.errors > 0);
        failures += failed;
        fnl_image image;
        fnl_frame_stats stats;
        if (failed) {
            assert_int_equal(result, FNL_ERROR_MEMORY);
            assert_int_equal(fnl_renderer_read(renderer, FNL_OUTPUT_RADIANCE, &image), FNL_ERROR_INVALID);
            assert_int_equal(fnl_renderer_query_stats(renderer, &stats), FNL_ERROR_INVALID);
            assert_int_equal(fnl_renderer_render(renderer, &frame), FNL_OK);
        }
        assert_int_equal(fnl_renderer_query_stats(renderer, &stats), FNL_OK);
        assert_int_equal(fnl_renderer_read(renderer, FNL_OUTPUT_RADIANCE, &image), FNL_OK);
        fnl_image expected = test_render(s.scene, &frame, FNL_OUTPUT_RADIANCE);
        if (!test_equal(&image, &expected)) fail_msg("after failure %u the picture is another", n);
        fnl_host host = test_host(&memory);
        fnl_image_free(&host, &image);
        free_picture(&expected);
        assert_true(n < 300);
    }
    print_message("%u allocations failed\n", failures);
    assert_true(failures > 0);
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&s.scene);
    test_device_destroy(&device);
    assert_int_equal(memory.live_bytes, 0);
}

/* ---- several renderers and devices ---- */

static void test_two_renderers(void **state) {
    UNUSED(state);
    struct stage_set a = stage_set_open(), b = stage_set_open();
    for (int i = 0; i < 3; i++) assert_int_equal(fnl_scene_remove_light(b.scene, b.lights[i]), FNL_OK);
    assert_int_equal(fnl_scene_remove_instance(b.scene, b.instances[0]), FNL_OK);
    fnl_frame frames[2] = {test_frame(FNL_OUTPUT_RADIANCE), test_frame(FNL_OUTPUT_RADIANCE)};
    frames[0].lists = FNL_LISTS_CLUSTERED;
    frames[1].lists = FNL_LISTS_TILED;
    frames[1].width = 40;
    frames[0].exposure = frames[1].exposure = FNL_EXPOSURE_AUTO;
    frames[0].timers = frames[1].timers = true;
    frames[0].outputs = frames[1].outputs = FNL_OUTPUT_RADIANCE | FNL_OUTPUT_COLOR;
    fnl_scene *scenes[2] = {a.scene, b.scene};
    fnl_renderer *renderers[2];
    fnl_image expected[2];
    fnl_frame_stats alone[2];
    for (int i = 0; i < 2; i++) {
        renderers[i] = test_renderer(scenes[i]);
        for (int k = 0; k < 2; k++) test_render_frame(renderers[i], &frames[i]);
        /* From here on the slot of the last frame alone holds what is true. */
        assert_int_equal(fnl_scene_remove_instance(scenes[i], (i ? b : a).instances[3]), FNL_OK);
        test_render_frame(renderers[i], &frames[i]);
        expected[i] = test_read(renderers[i], FNL_OUTPUT_RADIANCE);
        assert_int_equal(fnl_renderer_query_stats(renderers[i], &alone[i]), FNL_OK);
    }
    assert_true(alone[0].items_visible != alone[1].items_visible && alone[0].ev != alone[1].ev);
    static const int orders[][4] = {{0, 1, 0, 1}, {1, 0, 0, 1},   {0, 0, 1, 1},   {0, 1, 1, 1},
                                    {1, 1, 1, 0}, {0, 1, -1, -1}, {1, 0, -1, -1}, {1, 0, 0, 0}};
    for (uint32_t k = 0; k < COUNT_OF(orders); k++) {
        for (int i = 0; i < 4 && orders[k][i] >= 0; i++) test_render_frame(renderers[orders[k][i]], &frames[orders[k][i]]);
        for (int i = 0; i < 2; i++) { /* also that which rendered some frames ago */
            fnl_image image = test_read(renderers[i], FNL_OUTPUT_RADIANCE);
            assert_true(test_equal(&image, &expected[i]));
            free_picture(&image);
            fnl_frame_stats stats;
            assert_int_equal(fnl_renderer_query_stats(renderers[i], &stats), FNL_OK);
            if (stats.items_visible != alone[i].items_visible || stats.list_entries != alone[i].list_entries ||
                stats.lights_in_view != alone[i].lights_in_view || stats.ev != alone[i].ev)
                fail_msg("order %u: renderer %d reports numbers of another frame", k, i);
            if (stats.pass_count != 0 &&
                stats.pass_count != alone[i].pass_count) /* 0: another renderer has taken the timers since */
                fail_msg("order %u: renderer %d names %u passes, not %u", k, i, stats.pass_count, alone[i].pass_count);
        }
    }
    /* Two renderers of one scene follow its edits each (share_test.c has those that share it). */
    fnl_renderer *second = test_renderer(a.scene);
    for (uint32_t step = 0; step < 5; step++) {
        edit(&a, step);
        test_render_frame(renderers[0], &frames[0]);
        if (step % 2) continue; /* misses every other edit */
        test_render_frame(second, &frames[0]);
        fnl_image x = test_read(renderers[0], FNL_OUTPUT_RADIANCE), y = test_read(second, FNL_OUTPUT_RADIANCE);
        assert_true(test_equal(&x, &y));
        free_picture(&x);
        free_picture(&y);
    }
    fnl_renderer_destroy(&second);
    for (int i = 0; i < 2; i++) {
        free_picture(&expected[i]);
        fnl_renderer_destroy(&renderers[i]);
        fnl_scene_destroy(&scenes[i]);
    }
}

static void test_two_devices(void **state) {
    UNUSED(state);
    struct test_memory memory = {0};
    fnl_device *device = test_device_create(&memory);
    struct stage_set s = stage_set_open();
    fnl_frame frame = test_frame(FNL_OUTPUT_RADIANCE);
    fnl_renderer *first = test_renderer(s.scene), *second;
    assert_int_equal(fnl_renderer_create(device, s.scene, &second), FNL_OK);
    test_render_frame(first, &frame);
    assert_int_equal(fnl_renderer_render(second, &frame), FNL_OK);
    fnl_image a = test_read(first, FNL_OUTPUT_RADIANCE), b;
    assert_int_equal(fnl_renderer_read(second, FNL_OUTPUT_RADIANCE, &b), FNL_OK);
    assert_true(test_equal(&a, &b));
    free_picture(&a);
    fnl_host host = test_host(&memory);
    fnl_image_free(&host, &b);
    /* Renderers go before their device and their scene; the scene may outlive the device. */
    fnl_renderer_destroy(&second);
    assert_null(second);
    test_device_destroy(&device);
    assert_int_equal(memory.live_bytes, 0);
    test_render_frame(first, &frame);
    fnl_renderer_destroy(&first);
    fnl_scene_destroy(&s.scene);
}

static void test_device_memory_comes_back(void **state) {
    UNUSED(state);
    struct stage_set s = stage_set_open();
    fnl_frame frame = test_frame(FNL_OUTPUT_RADIANCE | FNL_OUTPUT_COLOR | FNL_OUTPUT_POSITION);
    uint64_t start = 0;
    for (int i = 0; i < 4; i++) { /* the first round warms what the device keeps: frame memory, staging */
        fnl_renderer *renderer = test_renderer(s.scene);
        for (uint32_t lists = 0; lists < FNL_LISTS_COUNT; lists++) {
            frame.shading = FNL_SHADING_DEFERRED;
            frame.lists = (fnl_light_lists)lists;
            if (!fnl_shading_supports(frame.shading, frame.lists, frame.msaa)) continue;
            test_render_frame(renderer, &frame);
        }
        fnl_frame_stats stats;
        assert_int_equal(fnl_renderer_query_stats(renderer, &stats), FNL_OK);
        assert_true(stats.device_bytes > 64 * 64 * 36 && stats.device_peak_bytes >= stats.device_bytes);
        uint64_t sum = 0;
        for (uint32_t k = 0; k < stats.memory_kind_count; k++) sum += stats.memory_kinds[k].bytes;
        assert_true(sum == stats.device_bytes);
        fnl_renderer_destroy(&renderer);
        uint64_t left = gpu_memory_stats(test_device).used_bytes;
        assert_true(left < stats.device_bytes);
        if (i == 0)
            start = left;
        else
            assert_int_equal(left, start);
    }
    fnl_scene_destroy(&s.scene);
}

/* One and several recording threads, and two runs, give the same bytes. */
static void test_threads_and_runs(void **state) {
    UNUSED(state);
    struct stage_set s = stage_set_open();
    for (uint32_t shading = 0; shading < FNL_SHADING_DEFERRED + 1; shading++) {
        fnl_image first = {0};
        for (uint32_t threads = 0; threads < 4; threads++) {
            fnl_frame frame = test_frame(FNL_OUTPUT_COLOR | FNL_OUTPUT_RADIANCE);
            frame.shading = (fnl_shading)shading;
            frame.lists = FNL_LISTS_TILED;
            frame.record_threads = threads;
            fnl_image image = test_render(s.scene, &frame, FNL_OUTPUT_COLOR);
            if (first.pixels) assert_true(test_equal(&first, &image));
            if (first.pixels)
                free_picture(&image);
            else
                first = image;
        }
        free_picture(&first);
    }
    fnl_scene_destroy(&s.scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_recording_does_not_grow_with_lights),
        cmocka_unit_test(test_recording_does_not_grow_with_instances),
        cmocka_unit_test(test_steady_state_allocates_nothing),
        cmocka_unit_test(test_edits_show_in_the_next_frame),
        cmocka_unit_test(test_time),
        cmocka_unit_test(test_times_of_a_frame),
        cmocka_unit_test(test_resize),
        cmocka_unit_test(test_misuse),
        cmocka_unit_test(test_empty_scene),
        cmocka_unit_test(test_allocation_failures),
        cmocka_unit_test(test_late_allocation_failures),
        cmocka_unit_test(test_two_renderers),
        cmocka_unit_test(test_two_devices),
        cmocka_unit_test(test_device_memory_comes_back),
        cmocka_unit_test(test_threads_and_runs),
    };
    return cmocka_run_group_tests_name("renderer", tests, begin, end);
}
