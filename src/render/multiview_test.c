/* SPDX-License-Identifier: MIT */
/** Views that are drawn at once (fnl_frame.multiview): pictures to the bit of those drawn one by one, and the work that is saved. */
#include "tests/frame_views.h"
#include "tests/render_test.h"
#include "tests/vulkan_spy.h"

enum { WIDTH = 53, HEIGHT = 37 };

static const struct path {
    fnl_shading shading;
    bool prepass;
    uint32_t passes; /* that draw the opaque set for several views at once */
} paths[] = {{FNL_SHADING_DEFERRED, false, 1},
             {FNL_SHADING_DEFERRED, true, 2},
             {FNL_SHADING_FORWARD_PREPASS, false, 1},
             {FNL_SHADING_VISIBILITY, false, 1}};

static struct stage open_stage(const char *source, uint32_t scattered) {
    struct stage stage = stage_open(source, scattered);
    stage.frame.width = WIDTH;
    stage.frame.height = HEIGHT;
    stage.frame.lists = FNL_LISTS_TILED;
    stage.frame.multiview = FNL_MULTIVIEW_ON;
    return stage;
}

static fnl_frame frame_of(const struct stage *stage, const struct path *path, uint32_t msaa) {
    fnl_frame frame = stage->frame;
    frame.shading = path->shading;
    frame.gbuffer.prepass = path->prepass;
    frame.msaa = msaa;
    return frame;
}

/* Two eyes, 64 mm apart, at the stage's camera. */
static void place_eyes(const struct stage *stage, fnl_camera eyes[2]) {
    fnl_camera camera = stage->frame.camera;
    vec3 forward = vec3_normalize(vec3_sub(camera.target, camera.position));
    vec3 right = vec3_scale(vec3_normalize(vec3_cross(forward, camera.up)), 0.032f);
    eyes[0] = eyes[1] = camera;
    eyes[0].position = vec3_sub(camera.position, right);
    eyes[0].target = vec3_sub(camera.target, right);
    eyes[1].position = vec3_add(camera.position, right);
    eyes[1].target = vec3_add(camera.target, right);
}

/* Of the last frame: the passes that drew views `first` to `last` at once. */
static uint32_t count_together(const struct stage *stage, uint32_t first, uint32_t last) {
    static char text[1 << 18];
    char scope[32], mask[32];
    snprintf(scope, sizeof scope, "'views %u-%u/", first, last);
    snprintf(mask, sizeof mask, ", views %#x at once", (1u << (last - first + 1)) - 1);
    assert_true(fnl_renderer_print(stage->renderer, FNL_PRINT_PLAN, text, sizeof text) < sizeof text);
    uint32_t count = 0;
    for (char *line = strtok(text, "\n"); line; line = strtok(NULL, "\n"))
        count += strstr(line, "  pass ") == line && strstr(line, scope) && strstr(line, mask);
    return count;
}

static void render_views(struct stage *stage, const fnl_frame *frame, const fnl_camera *cameras, uint32_t count) {
    fnl_frame many = *frame;
    many.views = cameras;
    many.view_count = count;
    test_render_frame(stage->renderer, &many);
}

/* ---- pictures ---- */

enum { ALL_PATHS = 15, DEFERRED = 1, DEFERRED_PREPASS = 2, FORWARD = 4, VISIBILITY = 8 }; /* bits of paths */

static void check_paths(struct stage *stage, uint32_t which, const fnl_camera *cameras, uint32_t count, uint32_t msaa,
                        const char *what) {
    for (uint32_t p = 0; p < COUNT_OF(paths); p++) {
        if (!(which >> p & 1)) continue;
        char text[96];
        fnl_frame frame = frame_of(stage, &paths[p], msaa);
        snprintf(text, sizeof text, "%s, path %u, %u views, %u samples", what, p, count, msaa);
        views_check(stage, &frame, cameras, count, text);
        render_views(stage, &frame, cameras, count);
        assert_int_equal(count_together(stage, 0, count - 1), paths[p].passes);
    }
}

static void test_views_drawn_at_once_equal_frames(void **state) {
    UNUSED(state);
    struct stage stage = open_stage("builtin:glass", 60);
    fnl_camera cameras[VIEWS_MOST];
    views_place(&stage, cameras);
    check_paths(&stage, ALL_PATHS, cameras, 2, 1, "glass");
    check_paths(&stage, DEFERRED_PREPASS | VISIBILITY, cameras, 3, 4, "glass");
    check_paths(&stage, DEFERRED, cameras, 6, 1, "glass");
    stage.frame.count_lights = true; /* per view */
    fnl_frame frame = frame_of(&stage, &paths[1], 1);
    views_check(&stage, &frame, cameras, 2, "counters");
    stage_close(&stage);
}

/* What a layout cannot hold is drawn forward for each view, where its depth equals what was drawn for all. */
static void test_layouts_of_the_gbuffer(void **state) {
    UNUSED(state);
    struct stage stage = open_stage("builtin:glass", 60);
    fnl_camera cameras[VIEWS_MOST];
    views_place(&stage, cameras);
    fnl_frame frame = frame_of(&stage, &paths[1], 1);
    frame.gbuffer.layout = FNL_GBUFFER_KILLZONE2; /* dielectrics only */
    views_check(&stage, &frame, cameras, 2, "killzone2");
    frame.msaa = 4;
    views_check(&stage, &frame, cameras, 2, "killzone2, 4 samples");
    frame = frame_of(&stage, &paths[0], 1);
    frame.gbuffer.chroma = true;
    frame.gbuffer.normals = FNL_NORMALS_FLOAT; /* in a target of its own */
    views_check(&stage, &frame, cameras, 2, "chroma");
    stage_close(&stage);
}

static void test_holes_and_skins(void **state) {
    UNUSED(state);
    fnl_camera cameras[VIEWS_MOST];
    struct stage stage = open_stage("builtin:grass?lights=20", 0);
    views_place(&stage, cameras);
    check_paths(&stage, DEFERRED_PREPASS | VISIBILITY, cameras, 2, 1, "alpha-masked");
    check_paths(&stage, FORWARD, cameras, 2, 4, "alpha-masked");
    stage_close(&stage);
    stage = open_stage("CesiumMan.glb", 30);
    views_place(&stage, cameras);
    for (uint32_t i = 0; i < 2; i++) {
        assert_int_equal(fnl_scene_set_time(stage.scene, 0, 0.4 + i), FNL_OK);
        check_paths(&stage, i ? FORWARD : DEFERRED | VISIBILITY, cameras, 2, 1, "skinned");
    }
    stage_close(&stage);
}

/* Two that look away from each other, and one that looks at nothing: each draws what the others see, outside of its picture. */
static void test_views_that_share_nothing(void **state) {
    UNUSED(state);
    struct stage stage = open_stage("builtin:hall?lights=40", 0);
    fnl_camera cameras[3];
    for (int i = 0; i < 3; i++) cameras[i] = stage.frame.camera;
    vec3 forward = vec3_sub(cameras[0].target, cameras[0].position);
    cameras[1].target = vec3_sub(cameras[1].position, forward);
    cameras[2].target = vec3_add(cameras[2].position, (vec3){0.1f, 900, 0});
    cameras[2].position.y += 800; /* above everything, and it looks up */
    check_paths(&stage, DEFERRED | VISIBILITY, cameras, 3, 1, "hall");
    const fnl_camera empty_first[2] = {cameras[2], cameras[1]}; /* the first is not what counts */
    check_paths(&stage, DEFERRED_PREPASS | FORWARD, empty_first, 2, 1, "hall");
    fnl_frame_stats stats;
    assert_int_equal(fnl_renderer_query_stats(stage.renderer, &stats), FNL_OK);
    assert_int_equal(stats.views[0].items_visible, 0);
    assert_true(stats.views[1].items_visible > 0);
    stage_close(&stage);
}

/* Each view has its history of TAA, and motion is drawn over the depth of its layer. */
static void test_histories(void **state) {
    UNUSED(state);
    struct stage stage = open_stage("builtin:glass", 60);
    fnl_camera eyes[2];
    place_eyes(&stage, eyes);
    fnl_renderer *other = test_renderer(stage.scene);
    fnl_frame frame = stage.frame;
    frame.aa = FNL_ANTIALIASING_TAA;
    frame.outputs = FNL_OUTPUT_RADIANCE | FNL_OUTPUT_MOTION;
    frame.views = eyes;
    frame.view_count = 2;
    for (int n = 0; n < 4; n++) {
        for (int i = 0; i < 2; i++) eyes[i].position.x += 0.03f;
        frame.multiview = FNL_MULTIVIEW_ON;
        test_render_frame(stage.renderer, &frame);
        frame.multiview = FNL_MULTIVIEW_OFF;
        test_render_frame(other, &frame);
        const fnl_output outputs[] = {FNL_OUTPUT_RADIANCE, FNL_OUTPUT_MOTION};
        for (uint32_t o = 0; o < COUNT_OF(outputs); o++) {
            fnl_image at_once = test_read(stage.renderer, outputs[o]), one_by_one = test_read(other, outputs[o]);
            assert_int_equal(count_differing(&at_once, &one_by_one), 0);
            free_picture(&at_once);
            free_picture(&one_by_one);
        }
    }
    fnl_renderer_destroy(&other);
    stage_close(&stage);
}

/* ---- work ---- */

static uint32_t count_draws(struct stage *stage, const fnl_frame *frame, const fnl_camera *cameras, uint32_t count, uint64_t *stats_draws) {
    fnl_frame_stats stats;
    spy_clear();
    render_views(stage, frame, cameras, count);
    assert_int_equal(fnl_renderer_query_stats(stage->renderer, &stats), FNL_OK);
    *stats_draws = 0;
    for (uint32_t i = 0; i < stats.view_count; i++) *stats_draws += stats.views[i].draws;
    uint32_t draws = 0;
    for (uint32_t i = 0; i < spy.work_count; i++) draws += spy_graphics_params(spy.work[i].pipeline) && spy.work[i].indirect;
    return draws;
}

static void test_draws_are_recorded_once(void **state) {
    UNUSED(state);
    struct stage stage = open_stage("builtin:hall?lights=40", 0); /* nothing is blended in it */
    fnl_camera cameras[VIEWS_MOST];
    views_place(&stage, cameras);
    spy_begin(harness_device());
    for (uint32_t p = 0; p < COUNT_OF(paths); p++)
        for (uint32_t count = 2; count <= (p ? 2u : 6u); count += 4) {
            fnl_frame frame = frame_of(&stage, &paths[p], 1);
            frame.record_threads = 1;
            uint64_t stats_together, stats_apart;
            uint32_t together = count_draws(&stage, &frame, cameras, count, &stats_together);
            for (uint32_t i = 0; i < spy.work_count; i++) {
                const struct gpu_graphics_params *params = spy_graphics_params(spy.work[i].pipeline);
                bool at_once = strncmp(spy.work[i].label, "views ", 6) == 0;
                if (params) assert_int_equal(params->view_mask, at_once ? (1u << count) - 1 : 0);
            }
            frame.multiview = FNL_MULTIVIEW_OFF;
            uint32_t apart = count_draws(&stage, &frame, cameras, count, &stats_apart);
            assert_true(apart > 0 && apart % count == 0);
            /* Forward draws its second pass for each view. */
            uint32_t one = apart / count, shading = paths[p].shading == FNL_SHADING_FORWARD_PREPASS ? one / 2 : 0;
            assert_int_equal(together, one - shading + count * shading);
            assert_int_equal(stats_together, together);
            assert_int_equal(stats_apart, apart);
        }
    spy_end();
    stage_close(&stage);
}

/* ---- which views ---- */

static void test_auto_takes_views_that_see_the_same(void **state) {
    UNUSED(state);
    struct stage stage = open_stage("builtin:hall?lights=40", 0);
    stage.frame.multiview = FNL_MULTIVIEW_AUTO;
    fnl_camera eyes[2], cameras[8];
    place_eyes(&stage, eyes);
    render_views(&stage, &stage.frame, eyes, 2);
    assert_int_equal(count_together(&stage, 0, 1), 1);
    fnl_frame forward = frame_of(&stage, &paths[2], 1); /* only its prepass could be shared */
    render_views(&stage, &forward, eyes, 2);
    assert_int_equal(count_together(&stage, 0, 1), 0);
    vec3 back = vec3_sub(eyes[0].position, eyes[0].target);
    for (uint32_t i = 0; i < 4; i++) { /* two, one that looks elsewhere, and two */
        cameras[i] = eyes[i & 1];
        cameras[i + 3] = eyes[i & 1];
    }
    cameras[2] = eyes[0];
    cameras[2].target = vec3_add(eyes[0].position, back);
    cameras[3] = eyes[0];
    cameras[4] = eyes[1];
    render_views(&stage, &stage.frame, cameras, 5);
    assert_int_equal(count_together(&stage, 0, 1), 1);
    assert_int_equal(count_together(&stage, 3, 4), 1);
    assert_int_equal(count_together(&stage, 2, 4), 0);
    cameras[1] = cameras[2]; /* alone by alone, but for the last two, now the other way round */
    cameras[2] = eyes[1];
    cameras[3] = cameras[1];
    render_views(&stage, &stage.frame, cameras, 4);
    for (uint32_t first = 0; first < 3; first++) assert_int_equal(count_together(&stage, first, first + 1), 0);
    fnl_camera far = eyes[1]; /* the same way, from the other end */
    far.position = vec3_add(far.position, (vec3){12, 0, 0});
    far.target = vec3_add(far.target, (vec3){12, 0, 0});
    cameras[0] = eyes[0];
    cameras[1] = far;
    render_views(&stage, &stage.frame, cameras, 2);
    assert_int_equal(count_together(&stage, 0, 1), 0);
    cameras[1] = eyes[1];
    cameras[1].vertical_fov *= 2;
    render_views(&stage, &stage.frame, cameras, 2);
    assert_int_equal(count_together(&stage, 0, 1), 0);
    /* More than go at once. */
    stage.frame.multiview = FNL_MULTIVIEW_ON;
    for (uint32_t i = 0; i < 8; i++) cameras[i] = eyes[i & 1];
    render_views(&stage, &stage.frame, cameras, 8);
    assert_int_equal(count_together(&stage, 0, 5), 1);
    assert_int_equal(count_together(&stage, 6, 7), 1);
    render_views(&stage, &stage.frame, cameras, 7);
    assert_int_equal(count_together(&stage, 0, 5), 1);
    assert_int_equal(count_together(&stage, 6, 6), 0);
    stage_close(&stage);
}

/* Their pictures are those of views_test.c. */
static void test_what_is_drawn_one_by_one(void **state) {
    UNUSED(state);
    struct stage stage = open_stage("builtin:hall?lights=20&decals=6", 0);
    fnl_camera eyes[2];
    place_eyes(&stage, eyes);
    fnl_frame frames[8];
    uint32_t count = 0;
    frames[count++] = stage.frame; /* decals */
    stage.frame.decals = FNL_DECALS_OFF;
    frames[count] = stage.frame;
    frames[count++].culling = FNL_CULLING_CLUSTERS;
    frames[count] = stage.frame;
    frames[count++].occlusion = true;
    fnl_frame visibility = stage.frame;
    visibility.shading = FNL_SHADING_VISIBILITY;
    frames[count] = visibility;
    frames[count++].count_lights = true;
    frames[count] = visibility;
    frames[count++].visibility.barycentrics = true;
    frames[count] = visibility;
    frames[count++].visibility.grid = true;
    frames[count] = stage.frame;
    frames[count++].multiview = FNL_MULTIVIEW_OFF;
    for (uint32_t i = 0; i < count; i++) {
        render_views(&stage, &frames[i], eyes, 2);
        assert_int_equal(count_together(&stage, 0, 1), 0);
    }
    render_views(&stage, &stage.frame, eyes, 2);
    assert_int_equal(count_together(&stage, 0, 1), 1);
    stage_close(&stage);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_views_drawn_at_once_equal_frames, harness_check),
        cmocka_unit_test_teardown(test_layouts_of_the_gbuffer, harness_check),
        cmocka_unit_test_teardown(test_holes_and_skins, harness_check),
        cmocka_unit_test_teardown(test_views_that_share_nothing, harness_check),
        cmocka_unit_test_teardown(test_histories, harness_check),
        cmocka_unit_test_teardown(test_draws_are_recorded_once, spy_tear_down),
        cmocka_unit_test_teardown(test_auto_takes_views_that_see_the_same, harness_check),
        cmocka_unit_test_teardown(test_what_is_drawn_one_by_one, harness_check),
    };
    return cmocka_run_group_tests_name("multiview", tests, test_group_begin, test_group_end);
}
