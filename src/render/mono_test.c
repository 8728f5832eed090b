/* SPDX-License-Identifier: MIT */
/** What is far away, drawn once for both eyes: what is near is as without it, and what is far is where each eye would see it. */
#include "passes/stereo/mono_shared.h"
#include "render/stereo.h"
#include "tests/render_test.h"

enum { WIDTH = 93, HEIGHT = 57 };

static const float ipd = 0.0635f;

/* Two eyes at the stage's camera; `canted`: they look 8 degrees outwards. */
static void place_eyes(const struct stage *stage, bool canted, fnl_camera out[2]) {
    const fnl_camera *camera = &stage->frame.camera;
    const vec3 back = vec3_normalize(vec3_sub(camera->position, camera->target)), right = vec3_normalize(vec3_cross(camera->up, back));
    for (int i = 0; i < 2; i++) {
        const float side = i ? 1.0f : -1.0f, turn = canted ? side * 8 * PI / 180 : 0;
        out[i] = *camera;
        out[i].position = vec3_add_scaled(camera->position, right, side * ipd / 2);
        out[i].target = vec3_add(out[i].position, vec3_add(vec3_scale(back, -cosf(turn)), vec3_scale(right, sinf(turn))));
    }
}

static fnl_frame frame_of(const struct stage *stage, const fnl_camera eyes[2], float distance) {
    fnl_frame frame = stage->frame;
    frame.views = eyes;
    frame.view_count = frame.stereo.eyes = 2;
    frame.stereo.mono_distance = distance;
    frame.outputs = FNL_OUTPUT_COLOR | FNL_OUTPUT_RADIANCE;
    return frame;
}

static struct stage open_stage(fnl_scene *scene) {
    struct stage stage = stage_open_scene(scene);
    stage.frame.width = WIDTH;
    stage.frame.height = HEIGHT;
    return stage;
}

/* ---- near ---- */

enum { METRES = 9 };

/* 1: the surface lies before the plane; 2: behind; 0: sky. */
static int side_of(const struct stage *stage, const float *position, float metres) {
    const fnl_camera *camera = &stage->frame.camera;
    const vec3 ahead = vec3_normalize(vec3_sub(camera->target, camera->position)), p = {position[0], position[1], position[2]};
    const float depth = vec3_dot(vec3_sub(p, camera->position), ahead);
    return !(position[3] > 0) ? 0 : depth < metres * 0.9999f ? 1 : 2;
}

struct sums {
    uint64_t near, far, differing, holes;
    uint64_t far_off; /* far, by more than a quarter */
};

/* `full`: each eye by itself. The background is magenta, and nothing else is. */
static struct sums compare(const struct stage *stage, float metres, const fnl_image *hybrid, const fnl_image *full, const fnl_image *positions) {
    struct sums sums = {0};
    for (size_t i = 0; i < (size_t)full->width * full->height; i++) {
        const float *a = (const float *)hybrid->pixels + 4 * i, *b = (const float *)full->pixels + 4 * i;
        const int side = side_of(stage, (const float *)positions->pixels + 4 * i, metres);
        sums.near += side == 1;
        sums.far += side == 2;
        sums.differing += side < 2 && memcmp(a, b, 12) != 0;
        sums.holes += side == 2 && a[0] > 500 && a[1] < 1;
        sums.far_off += side == 2 && fabsf(a[1] - b[1]) > 0.25f * fmaxf(a[1], b[1]);
    }
    return sums;
}

static void test_near_is_exact_and_nothing_is_missing_VR_10(void **state) {
    UNUSED(state);
    static const struct {
        fnl_shading shading;
        fnl_light_lists lists;
        bool canted, prepass, hidden;
        fnl_stereo_path path;
    } rows[] = {{FNL_SHADING_DEFERRED, FNL_LISTS_TILED, false, false, false, FNL_STEREO_PATH_AUTO},
                {FNL_SHADING_DEFERRED, FNL_LISTS_CLUSTERED, true, true, true, FNL_STEREO_PATH_INSTANCES},
                {FNL_SHADING_VISIBILITY, FNL_LISTS_TILED, true, false, false, FNL_STEREO_PATH_OBJECTS},
                {FNL_SHADING_FORWARD_PREPASS, FNL_LISTS_CLUSTERED, false, false, true, FNL_STEREO_PATH_MULTIVIEW}};
    struct stage stage = stage_open("builtin:hall?lights=30", 0);
    stage.frame.width = WIDTH;
    stage.frame.height = HEIGHT;
    assert_int_equal(fnl_scene_set_background(stage.scene, (fnl_vec3){1000, 0, 1000}), FNL_OK);
    for (uint32_t i = 0; i < COUNT_OF(rows); i++) {
        fnl_camera eyes[2];
        fnl_hidden_area areas[2];
        fnl_vec2 corners[FNL_HIDDEN_ROUND_CORNERS(8)];
        const fnl_eye eye = {.pose = {{0, 0, 0}, {0, 0, 0, 1}}, .left = -2, .right = 2, .down = -2, .up = 2};
        place_eyes(&stage, rows[i].canted, eyes);
        fnl_frame frame = frame_of(&stage, eyes, METRES);
        frame.shading = rows[i].shading;
        frame.lists = rows[i].lists;
        frame.gbuffer.prepass = rows[i].prepass;
        frame.stereo.path = rows[i].path;
        assert_int_equal(fnl_hidden_area_round(NULL, &eye, (fnl_vec2){0, 0}, 0.55f, 8, corners, &areas[0]), FNL_OK);
        areas[1] = areas[0];
        if (rows[i].hidden) frame.hidden_areas = areas;
        frame.count_lights = i == 0;
        if (i == 0) frame.shadows = FNL_SHADOWS_MAPS;
        test_render_frame(stage.renderer, &frame);
        const fnl_frame_stats stats = harness_stats(stage.renderer);
        fnl_image hybrid = test_read(stage.renderer, FNL_OUTPUT_RADIANCE);
        frame.stereo.mono_distance = 0;
        frame.outputs |= FNL_OUTPUT_POSITION;
        test_render_frame(stage.renderer, &frame);
        const fnl_frame_stats whole = harness_stats(stage.renderer);
        fnl_image full = test_read(stage.renderer, FNL_OUTPUT_RADIANCE), positions = test_read(stage.renderer, FNL_OUTPUT_POSITION);
        const struct sums sums = compare(&stage, METRES, &hybrid, &full, &positions);
        if (sums.differing || sums.holes)
            fail_msg("row %u: %llu of %llu near pixels differ, %llu of %llu far ones are holes", i, (unsigned long long)sums.differing, (unsigned long long)sums.near,
                     (unsigned long long)sums.holes, (unsigned long long)sums.far);
        assert_true(sums.near > 500 && sums.far > 500);
        assert_int_equal(stats.view_count, 3);
        assert_int_equal(whole.view_count, 2);
        /* Eyes draw nothing wholly behind the plane, even if they diverge. */
        const uint64_t drawn = stats.views[0].items_visible, before = whole.views[0].items_visible;
        if (!(drawn > 0 && drawn < before)) fail_msg("row %u: the eye drew %llu items, %llu without mono view", i, (unsigned long long)drawn, (unsigned long long)before);
        if (frame.count_lights) { /* the work: near pixels of each eye, and far ones once */
            const uint64_t near = counter(&stats.views[0], "stereo.pixels") + counter(&stats.views[1], "stereo.pixels"), far = counter(&stats.views[2], "stereo.pixels");
            assert_in_range(near, sums.near - 20, sums.near + 20);
            if (!(far < sums.far * 7 / 10 && far > sums.far * 4 / 10)) fail_msg("%llu far pixels, of both eyes %llu, near %llu", (unsigned long long)far, (unsigned long long)sums.far, (unsigned long long)near);
            assert_true(counter(&stats.views[2], "stereo.pixels-spared") > sums.near / 4);
            uint64_t lit = 0;
            for (uint32_t v = 0; v < 3; v++) lit += stats.views[v].evaluations;
            assert_true(lit * 10 < (whole.views[0].evaluations + whole.views[1].evaluations) * 9);
            assert_false(has_counter(&whole.views[0], "stereo.pixels"));
        }
        free_picture(&hybrid);
        free_picture(&full);
        free_picture(&positions);
    }
    stage_close(&stage);
}

/* Ways to find shadows, in a room that three lamps shine into from outside. The mono view has them, too: what is far is as bright as in full stereo. */
static void test_all_shadows_VR_10(void **state) {
    UNUSED(state);
    const float metres = 5;
    static const struct {
        fnl_shadows shadows;
        float page_rays, radius;
    } rows[] = {{FNL_SHADOWS_OFF, 0, 0}, {FNL_SHADOWS_RAYS, 0, 0.2f}, {FNL_SHADOWS_SAMPLED, 0, 0}, {FNL_SHADOWS_HYBRID, 1e-3f, 0}, {FNL_SHADOWS_HYBRID, 1e6f, 0}, {FNL_SHADOWS_CUBEMAP, 0, 0}};
    struct stage stage = stage_open("builtin:room", 0);
    stage.frame.width = WIDTH;
    stage.frame.height = HEIGHT;
    fnl_camera eyes[2];
    fnl_image unshadowed = {0};
    place_eyes(&stage, false, eyes);
    for (uint32_t i = 0; i < COUNT_OF(rows); i++) {
        fnl_frame frame = frame_of(&stage, eyes, metres);
        frame.shading = FNL_SHADING_DEFERRED;
        frame.lists = FNL_LISTS_CLUSTERED;
        frame.shadows = rows[i].shadows;
        frame.shadow.page_rays = rows[i].page_rays;
        frame.shadow.light_radius = rows[i].radius;
        if (rows[i].radius > 0) frame.shadow.samples = 4;
        test_render_frame(stage.renderer, &frame);
        fnl_image hybrid = test_read(stage.renderer, FNL_OUTPUT_RADIANCE);
        frame.stereo.mono_distance = 0;
        frame.outputs |= FNL_OUTPUT_POSITION;
        test_render_frame(stage.renderer, &frame);
        fnl_image full = test_read(stage.renderer, FNL_OUTPUT_RADIANCE), positions = test_read(stage.renderer, FNL_OUTPUT_POSITION);
        const struct sums sums = compare(&stage, metres, &hybrid, &full, &positions);
        assert_true(sums.near > 500 && sums.far > 500);
        if (i == 0) unshadowed = hybrid;
        const struct sums darkened = compare(&stage, metres, &hybrid, &unshadowed, &positions);
        if (sums.far_off > sums.far / 10) fail_msg("row %u: %llu of %llu far pixels are off", i, (unsigned long long)sums.far_off, (unsigned long long)sums.far);
        if (i > 0) assert_true(darkened.far_off > sums.far / 8);
        if (sums.differing) fail_msg("row %u: %llu of %llu near pixels differ", i, (unsigned long long)sums.differing, (unsigned long long)sums.near);
        if (i > 0) free_picture(&hybrid);
        free_picture(&full);
        free_picture(&positions);
    }
    free_picture(&unshadowed);
    stage_close(&stage);
}

/* ---- the plane behind everything ---- */

static void test_plane_at_infinity_is_full_stereo_VR_10(void **state) {
    UNUSED(state);
    static const fnl_shading shadings[] = {FNL_SHADING_DEFERRED, FNL_SHADING_VISIBILITY, FNL_SHADING_FORWARD_PREPASS};
    struct stage stage = stage_open("builtin:glass", 20);
    stage.frame.width = WIDTH;
    stage.frame.height = HEIGHT;
    fnl_camera eyes[2];
    place_eyes(&stage, true, eyes);
    for (uint32_t i = 0; i < COUNT_OF(shadings); i++) {
        fnl_frame frame = frame_of(&stage, eyes, 1e6f);
        frame.shading = shadings[i];
        frame.lists = i ? FNL_LISTS_CLUSTERED : FNL_LISTS_TILED;
        test_render_frame(stage.renderer, &frame);
        fnl_image hybrid = test_read(stage.renderer, FNL_OUTPUT_RADIANCE);
        frame.stereo.mono_distance = 0;
        test_render_frame(stage.renderer, &frame);
        fnl_image full = test_read(stage.renderer, FNL_OUTPUT_RADIANCE);
        assert_int_equal(count_differing(&hybrid, &full), 0);
        free_picture(&hybrid);
        free_picture(&full);
    }
    stage_close(&stage);
}

/* ---- far ---- */

static uint32_t glowing(fnl_scene *scene, float red, float green, float alpha) {
    fnl_material_params material = fnl_material_params_default();
    material.emissive[0] = red;
    material.emissive[1] = green;
    for (int i = 0; i < 3; i++) material.base_color[i] = 0;
    material.base_color[3] = alpha;
    if (alpha < 1) material.alpha_mode = FNL_ALPHA_BLEND;
    return test_quad_mesh(scene, test_material(scene, &material).index);
}

/* Mean column of green light in a view. */
static double mean_column(fnl_renderer *renderer, fnl_frame frame, uint32_t view) {
    double sum = 0, weights = 0;
    for (uint32_t n = 0; n < 4; n++) {
        frame.jitter = fnl_jitter(n);
        test_render_frame(renderer, &frame);
        fnl_image image = test_read(renderer, FNL_OUTPUT_RADIANCE);
        const float *p = (const float *)image.pixels + (size_t)view * frame.width * frame.height * 4;
        for (uint32_t i = 0; i < frame.width * frame.height; i++) {
            sum += (i % frame.width + 0.5 + (double)frame.jitter.x) * (double)p[4 * i + 1];
            weights += (double)p[4 * i + 1];
        }
        free_picture(&image);
    }
    assert_true(weights > 0);
    return sum / weights;
}

/* 540 pixels of focal length, as 90 degrees over 1080: 1.7 pixels at most at 10 m, and less where the depth is known. */
static void test_far_error_is_small_VR_10(void **state) {
    UNUSED(state);
    static const float distances[] = {10.5f, 14, 60};
    for (uint32_t d = 0; d < COUNT_OF(distances); d++) {
        const float z = distances[d], tangent = (float)WIDTH / 2 / 540;
        const fnl_rigid_pose head = {{0, 0, 0}, {0, 0, 0, 1}};
        fnl_scene *scene = test_scene();
        test_place(scene, glowing(scene, 0, 4, 1), (vec3){0, 0, -z}, (vec3){0.02f * z, 0.02f * z, 1});
        struct stage stage = open_stage(scene);
        fnl_camera eyes[2];
        fnl_frame frame = frame_of(&stage, eyes, 0);
        for (int i = 0; i < 2; i++) {
            const fnl_eye eye = {.pose = {{(i ? ipd : -ipd) / 2, 0, 0}, {0, 0, 0, 1}}, .left = -tangent, .right = tangent, .down = -tangent, .up = tangent};
            assert_int_equal(fnl_eye_query_camera(NULL, &eye, &head, frame.width, frame.height, 0.05f, &eyes[i]), FNL_OK);
        }
        for (uint32_t view = 0; view < 2; view++) {
            frame.stereo.mono_distance = 0;
            const double full = mean_column(stage.renderer, frame, view);
            frame.stereo.mono_distance = 10;
            const double hybrid = mean_column(stage.renderer, frame, view), most = 1.7;
            assert_true(fabs(full - hybrid) <= most);
            if (fabs(full - hybrid) > 0.55) /* edges lie in whole pixels of either view */
                fail_msg("%g m, eye %u: column %g, not %g", (double)z, view, hybrid, full);
        }
        stage_close(&stage);
    }
}

/* A wall at z = -4 that glows in waves, along X in red and along Y in green, 34 pixels long where the plane meets it. */
static void add_waves(fnl_scene *scene) {
    enum { ACROSS = 131, UP = 41 };
    static float positions[ACROSS * UP * 3], colors[ACROSS * UP * 4];
    static uint32_t indices[(ACROSS - 1) * (UP - 1) * 6];
    uint32_t count = 0;
    for (uint32_t i = 0; i < ACROSS * UP; i++) {
        const float x = 6.5f + 0.05f * (float)(i % ACROSS), y = -1 + 0.05f * (float)(i / ACROSS);
        memcpy(positions + 3 * i, (float[]){x, y, -4}, 12);
        memcpy(colors + 4 * i, (float[]){0.5f + 0.25f * sinf(2 * PI * (x / 1.5f + y / 0.9f)), 0.5f + 0.25f * sinf(2 * PI * y / 0.6f), 0, 1}, 16);
        if (i % ACROSS == ACROSS - 1 || i / ACROSS == UP - 1) continue;
        memcpy(indices + count, (uint32_t[]){i, i + 1, i + ACROSS + 1, i, i + ACROSS + 1, i + ACROSS}, 24);
        count += 6;
    }
    fnl_material_params material = fnl_material_params_default();
    material.unlit = true;
    const fnl_mesh_params params = {.vertex_count = ACROSS * UP, .index_count = count, .positions = positions, .colors = colors, .indices = indices, .material = test_material(scene, &material)};
    fnl_mesh_id mesh;
    assert_int_equal(fnl_scene_add_mesh(scene, &params, &mesh), FNL_OK);
    test_place(scene, mesh.index, (vec3){0, 0, 0}, (vec3){1, 1, 1});
}

/*
 * The wall runs away from the eyes, through the plane. Its near part is what full stereo shows; its far part is as far from that as colours interpolated between pixels
 * are, up to the seam: no crack, no step, and nothing moved by a part of a pixel.
 */
static void test_spanning_objects_have_no_seam_VR_10(void **state) {
    UNUSED(state);
    const float most = 0.008f; /* it is 0.0066; half a pixel aside is 0.023 */
    fnl_scene *scene = test_scene();
    add_waves(scene);
    struct stage stage = open_stage(scene);
    stage.frame.camera = fnl_camera_default();
    stage.frame.camera.position = (fnl_vec3){0, 0, 0};
    stage.frame.camera.target = (fnl_vec3){0.92f, 0, -0.4f}; /* it is 10 m away a bit left of the middle */
    stage.frame.camera.up = (fnl_vec3){0.035f, 1, 0.08f}; /* the seam meets pixels and waves in all ways */
    stage.frame.camera.vertical_fov = 0.1f; /* 570 pixels */
    fnl_camera eyes[2];
    place_eyes(&stage, false, eyes);
    fnl_frame frame = frame_of(&stage, eyes, 10);
    frame.count_lights = true;
    test_render_frame(stage.renderer, &frame);
    const fnl_frame_stats stats = harness_stats(stage.renderer);
    fnl_image hybrid = test_read(stage.renderer, FNL_OUTPUT_RADIANCE);
    for (uint32_t v = 0; v < 3; v++) assert_true(counter(&stats.views[v], "stereo.pixels") > WIDTH * HEIGHT / 10);
    frame.stereo.mono_distance = 0;
    test_render_frame(stage.renderer, &frame);
    fnl_image full = test_read(stage.renderer, FNL_OUTPUT_RADIANCE);
    uint32_t differing = 0;
    for (size_t i = 0; i < 2ull * WIDTH * HEIGHT; i++) {
        const float *a = (const float *)hybrid.pixels + 4 * i, *b = (const float *)full.pixels + 4 * i;
        const float off = fmaxf(fabsf(a[0] - b[0]), fabsf(a[1] - b[1]));
        if (!(off <= most)) fail_msg("pixel %zu, row %zu, column %zu: %g %g, not %g %g", i, i / WIDTH, i % WIDTH, (double)a[0], (double)a[1], (double)b[0], (double)b[1]);
        differing += memcmp(a, b, 12) != 0;
    }
    assert_true(differing > WIDTH * HEIGHT / 2); /* the far part of both comes from the mono view */
    free_picture(&hybrid);
    free_picture(&full);
    stage_close(&stage);
}

/* Before a wall that looks the same from everywhere, all else is as each eye sees it: blended surfaces on both sides of the plane, and behind the wall. */
static void test_transparents_come_last_VR_10(void **state) {
    UNUSED(state);
    fnl_scene *scene = test_scene();
    test_place(scene, glowing(scene, 3, 1, 1), (vec3){0, 0, -20}, (vec3){60, 60, 1});
    test_place(scene, glowing(scene, 0, 4, 1), (vec3){-1, 0.4f, -6}, (vec3){0.7f, 0.7f, 1});
    test_place(scene, glowing(scene, 0, 2, 0.5f), (vec3){-1.5f, 0, -15}, (vec3){2, 2, 1});
    test_place(scene, glowing(scene, 5, 0, 0.25f), (vec3){0.5f, 0, -4}, (vec3){0.8f, 0.8f, 1});
    test_place(scene, glowing(scene, 0, 900, 0.5f), (vec3){0, 0, -25}, (vec3){9, 9, 1});
    struct stage stage = open_stage(scene);
    stage.frame.camera = fnl_camera_default();
    stage.frame.camera.position = (fnl_vec3){0, 0, 0};
    stage.frame.camera.target = (fnl_vec3){0, 0, -1};
    fnl_camera eyes[2];
    place_eyes(&stage, false, eyes);
    for (uint32_t i = 0; i < FNL_TRANSPARENCY_COUNT; i++) {
        fnl_frame frame = frame_of(&stage, eyes, 10);
        frame.transparency = (fnl_transparency)i;
        test_render_frame(stage.renderer, &frame);
        fnl_image hybrid = test_read(stage.renderer, FNL_OUTPUT_RADIANCE);
        frame.stereo.mono_distance = 0;
        test_render_frame(stage.renderer, &frame);
        fnl_image full = test_read(stage.renderer, FNL_OUTPUT_RADIANCE);
        for (size_t p = 0; p < (size_t)full.width * full.height * 4; p++) {
            const float a = ((const float *)hybrid.pixels)[p], b = ((const float *)full.pixels)[p];
            if (!(fabsf(a - b) <= 1e-4f * fmaxf(b, 1))) fail_msg("transparency %u, pixel %zu: %g, not %g", i, p / 4, (double)a, (double)b);
        }
        free_picture(&hybrid);
        free_picture(&full);
    }
    stage_close(&stage);
}

static void test_what_it_does_not_go_with(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:onetile", 0);
    fnl_camera eyes[2];
    place_eyes(&stage, false, eyes);
    stage.frame.width = stage.frame.height = 16;
    for (uint32_t i = 0; i < 14; i++) {
        fnl_frame frame = frame_of(&stage, eyes, 10);
        if (i == 0) frame.stereo.eyes = 0;
        if (i == 1) frame.msaa = 4;
        if (i == 2) frame.occlusion = FNL_OCCLUSION_ON;
        if (i == 3) frame.aa = FNL_ANTIALIASING_TAA;
        if (i == 4) frame.debug = FNL_DEBUG_ALBEDO;
        if (i == 5) frame.pixel.asked = true;
        if (i == 6) frame.outputs |= FNL_OUTPUT_NORMAL;
        if (i == 7) frame.shading = FNL_SHADING_FORWARD;
        if (i == 8) frame.shading = FNL_SHADING_MOBILE;
        if (i == 9) frame.visibility.grid = true, frame.shading = FNL_SHADING_VISIBILITY;
        if (i == 10) frame.stereo.mono_distance = -1;
        if (i == 11) frame.stereo.mono_distance = INFINITY;
        if (i == 13) frame.culling = FNL_CULLING_TRIANGLES;
        const fnl_result wanted = i == 12 ? FNL_OK : i == 10 || i == 11 ? FNL_ERROR_INVALID : FNL_ERROR_UNSUPPORTED;
        if (fnl_renderer_render(stage.renderer, &frame) != wanted) fail_msg("case %u", i);
    }
    fnl_camera many[FNL_VIEWS_MAX]; /* each display has a mono view of its own: with 42 views 21, one fewer than there is room for */
    for (uint32_t i = 0; i < FNL_VIEWS_MAX; i++) many[i] = eyes[i % 2];
    fnl_frame frame = frame_of(&stage, eyes, 10);
    frame.width = frame.height = 4;
    frame.views = many;
    for (uint32_t i = 0; i < 2; i++) {
        frame.view_count = i ? 44 : 42;
        assert_int_equal(fnl_renderer_render(stage.renderer, &frame), i ? FNL_ERROR_UNSUPPORTED : FNL_OK);
    }
    stage_close(&stage);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_near_is_exact_and_nothing_is_missing_VR_10, harness_check),
        cmocka_unit_test_teardown(test_all_shadows_VR_10, harness_check),
        cmocka_unit_test_teardown(test_plane_at_infinity_is_full_stereo_VR_10, harness_check),
        cmocka_unit_test_teardown(test_far_error_is_small_VR_10, harness_check),
        cmocka_unit_test_teardown(test_spanning_objects_have_no_seam_VR_10, harness_check),
        cmocka_unit_test_teardown(test_transparents_come_last_VR_10, harness_check),
        cmocka_unit_test_teardown(test_what_it_does_not_go_with, harness_check),
    };
    return cmocka_run_group_tests_name("mono", tests, test_group_begin, test_group_end);
}
