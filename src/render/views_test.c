/* SPDX-License-Identifier: MIT */
/** Frames with several views against as many frames with one: pictures to the bit, numbers, histories, and the work that is done once. */
#include "render/shading.h"
#include "tests/frame_views.h"
#include "tests/render_test.h"
#include "tests/vulkan_spy.h"

enum { WIDTH = 53, HEIGHT = 37, MOST = VIEWS_MOST };

static struct stage open_glass(void) {
    struct stage stage = stage_open("builtin:glass", 60);
    stage.frame.width = WIDTH;
    stage.frame.height = HEIGHT;
    return stage;
}

static void test_views_equal_frames(void **state) {
    UNUSED(state);
    static const fnl_shading shadings[] = {FNL_SHADING_FORWARD_PREPASS, FNL_SHADING_DEFERRED, FNL_SHADING_VISIBILITY};
    static const fnl_light_lists lists[] = {FNL_LISTS_ALL, FNL_LISTS_TILED, FNL_LISTS_CLUSTERED};
    struct stage stage = open_glass();
    fnl_camera cameras[MOST];
    views_place(&stage, cameras);
    for (uint32_t s = 0; s < COUNT_OF(shadings); s++)
        for (uint32_t l = 0; l < COUNT_OF(lists); l++)
            for (uint32_t msaa = 1; msaa <= 4; msaa *= 4) {
                char what[96];
                snprintf(what, sizeof what, "%s, %s, %u samples", fnl_value_name(FNL_ENUM_SHADING, shadings[s]),
                         fnl_value_name(FNL_ENUM_LISTS, lists[l]), msaa);
                fnl_frame frame = stage.frame;
                frame.shading = shadings[s];
                frame.lists = lists[l];
                frame.msaa = msaa;
                frame.count_lights = l == 1;
                frame.exposure = l == 2 ? FNL_EXPOSURE_AUTO : FNL_EXPOSURE_EV; /* each view is metered by itself */
                views_check(&stage, &frame, cameras, s == l ? MOST : 3, what);
            }
    stage_close(&stage);
}

/* What builders and paths keep belongs to one view, or to all of them. A list that deferred shading does not take is tried with another path. */
static void test_all_lists(void **state) {
    UNUSED(state);
    struct stage stage = open_glass();
    fnl_camera cameras[MOST];
    views_place(&stage, cameras);
    stage.frame.width = 29;
    stage.frame.height = 17;
    for (fnl_light_lists lists = 0; lists < FNL_LISTS_AUTO; lists++) {
        fnl_frame frame = stage.frame;
        frame.lists = lists;
        frame.multiview = lists & 1 ? FNL_MULTIVIEW_ON : FNL_MULTIVIEW_OFF;
        frame.count_lights = lists % 3 == 0;
        if (!fnl_shading_supports(frame.shading, lists, 1)) frame.shading = FNL_SHADING_FORWARD_PREPASS;
        views_check(&stage, &frame, cameras, 2, fnl_value_name(FNL_ENUM_LISTS, lists));
    }
    stage_close(&stage);
}

/* Those of test_views_equal_frames are left out. */
static void test_all_paths(void **state) {
    UNUSED(state);
    struct stage stage = open_glass();
    fnl_camera cameras[MOST];
    views_place(&stage, cameras);
    for (fnl_shading shading = 0; shading < FNL_SHADING_AUTO; shading++) {
        fnl_frame frame = stage.frame;
        frame.width = 29;
        frame.height = 17;
        frame.shading = shading;
        frame.lists = FNL_LISTS_TILED;
        frame.msaa = shading & 1 && fnl_shading_supports(shading, frame.lists, 4) ? 4 : 1;
        frame.exposure = FNL_EXPOSURE_AUTO;
        bool known = shading == FNL_SHADING_FORWARD_PREPASS || shading == FNL_SHADING_DEFERRED || shading == FNL_SHADING_VISIBILITY;
        if (!known && shading_is(shading, SHADING_VIEWS))
            views_check(&stage, &frame, cameras, 2, fnl_value_name(FNL_ENUM_SHADING, shading));
    }
    stage_close(&stage);
}

/* Culling by triangles writes behind the scene's indices, which all views share, and occlusion keeps what it knows of each view. */
static void test_views_with_the_rest_of_a_frame(void **state) {
    UNUSED(state);
    struct stage stage = open_glass();
    fnl_camera cameras[MOST];
    views_place(&stage, cameras);
    fnl_frame frame = stage.frame;
    frame.lists = FNL_LISTS_TILED;
    frame.culling = FNL_CULLING_TRIANGLES;
    frame.occlusion = true;
    frame.outputs |= FNL_OUTPUT_POSITION;
    frame.transparency = FNL_TRANSPARENCY_LINKED;
    for (int i = 0; i < 2; i++) views_check(&stage, &frame, cameras, 3, "triangles and occlusion");
    frame.transparency = FNL_TRANSPARENCY_WEIGHTED;
    frame.aa = FNL_ANTIALIASING_SMAA;
    frame.decals = FNL_DECALS_GBUFFER;
    views_check(&stage, &frame, cameras, 2, "weighted and smaa");
    frame = stage.frame;
    for (fnl_debug_view view = FNL_DEBUG_LIGHTS; view <= FNL_DEBUG_OVERDRAW; view = (fnl_debug_view)(view + 1)) {
        frame.debug = view;
        views_check(&stage, &frame, cameras, 2, fnl_value_name(FNL_ENUM_DEBUG_VIEW, view));
    }
    stage_close(&stage);
    stage = stage_open("builtin:hall?lights=40&decals=12", 0);
    views_place(&stage, cameras);
    frame = stage.frame;
    frame.width = WIDTH;
    frame.height = HEIGHT;
    for (fnl_decals way = FNL_DECALS_LISTS; way <= FNL_DECALS_GBUFFER; way = (fnl_decals)(way + 1)) {
        frame.decals = way;
        views_check(&stage, &frame, cameras, 3, "decals");
    }
    stage_close(&stage);
}

/* What each view collects over frames is what a renderer of its own would, also after a frame with another number of views. */
static void test_views_keep_histories_of_their_own(void **state) {
    UNUSED(state);
    enum { VIEWS = 3, FRAMES = 4 };
    struct stage stage = open_glass();
    fnl_camera cameras[MOST];
    views_place(&stage, cameras);
    cameras[2] = cameras[4]; /* all in perspective: a view may then take another's place unnoticed */
    fnl_renderer *singles[VIEWS];
    for (int i = 0; i < VIEWS; i++) singles[i] = test_renderer(stage.scene);
    fnl_frame frame = stage.frame, single = stage.frame;
    frame.aa = single.aa = FNL_ANTIALIASING_TAA;
    frame.outputs = single.outputs = FNL_OUTPUT_COLOR | FNL_OUTPUT_RADIANCE | FNL_OUTPUT_MOTION;
    frame.views = cameras;
    for (int round = 0; round < 2; round++) {
        if (round == 1) { /* views 1 and 2 miss a frame, and view 0 has another history */
            frame.view_count = 0;
            struct shot shot = stage_shoot(&stage, &frame);
            shot_free(&shot);
        }
        frame.view_count = VIEWS;
        for (int n = 0; n < FRAMES; n++) {
            for (int i = 0; i < VIEWS; i++) cameras[i].position.x += 0.03f * (float)(i + 1);
            test_render_frame(stage.renderer, &frame);
            fnl_image all = test_read(stage.renderer, FNL_OUTPUT_RADIANCE), motion = test_read(stage.renderer, FNL_OUTPUT_MOTION);
            for (uint32_t i = 0; i < VIEWS; i++) {
                single.camera = cameras[i];
                single.reset_history = n == 0;
                test_render_frame(singles[i], &single);
                fnl_image one = test_read(singles[i], FNL_OUTPUT_RADIANCE), moved = test_read(singles[i], FNL_OUTPUT_MOTION);
                views_check_picture(&all, i, &one, "taa");
                views_check_picture(&motion, i, &moved, "motion");
                free_picture(&one);
                free_picture(&moved);
            }
            free_picture(&all);
            free_picture(&motion);
        }
    }
    for (int i = 0; i < VIEWS; i++) fnl_renderer_destroy(&singles[i]);
    stage_close(&stage);
}

/* ---- work ---- */

enum { EDITS = 10 };

struct work {
    uint32_t shared, own[MOST]; /* passes without a scope, and those of each view */
    uint64_t copied;            /* bytes between buffers */
};

/* With edits the frame has light to send. */
static struct work count_work(struct stage *stage, const fnl_frame *frame, const fnl_light_id *edits) {
    static float brightness = 1;
    struct work work = {0};
    brightness += 0.01f;
    fnl_light_params light = test_point((vec3){0, 1, 0}, brightness, 3);
    for (uint32_t i = 0; i < EDITS && edits; i++) assert_int_equal(fnl_scene_set_light(stage->scene, edits[i], &light), FNL_OK);
    spy_clear();
    test_render_frame(stage->renderer, frame);
    fnl_frame_stats stats;
    assert_int_equal(fnl_renderer_query_stats(stage->renderer, &stats), FNL_OK);
    work.copied = spy.copied_bytes;
    for (uint32_t i = 0; i < stats.pass_count; i++) {
        unsigned view;
        int length = 0;
        const char *name = stats.passes[i].name;
        if (sscanf(name, "view %u/%n", &view, &length) == 1 && length > 0) {
            assert_true(view < MOST);
            work.own[view]++;
        } else {
            work.shared++;
        }
        for (uint32_t k = 0; k < i; k++) assert_string_not_equal(stats.passes[k].name, name);
    }
    return work;
}

static void test_what_views_share_is_done_once(void **state) {
    UNUSED(state);
    struct stage stage = open_glass();
    fnl_camera cameras[MOST];
    views_place(&stage, cameras);
    fnl_light_id lights[EDITS];
    const fnl_light_params light = test_point((vec3){0, 1, 0}, 1, 3);
    for (int i = 0; i < EDITS; i++) assert_int_equal(fnl_scene_add_light(stage.scene, &light, &lights[i]), FNL_OK);
    spy_begin(harness_device());
    fnl_frame frame = stage.frame;
    frame.lists = FNL_LISTS_TILED;
    frame.timers = true;
    frame.record_threads = 1;
    test_render_frame(stage.renderer, &frame);
    struct work still = count_work(&stage, &frame, NULL), edited = count_work(&stage, &frame, lights);
    assert_int_equal(edited.shared, still.shared + 1);
    assert_true(edited.copied > still.copied);
    frame.views = cameras;
    for (uint32_t count = 2; count <= MOST; count += 2) {
        frame.view_count = count;
        struct work views_still = count_work(&stage, &frame, NULL), views = count_work(&stage, &frame, lights);
        assert_int_equal(views_still.shared, 0);
        assert_int_equal(views.shared, 1);
        for (uint32_t i = 0; i < MOST; i++) assert_int_equal(views.own[i], i < count ? still.shared : 0);
        assert_int_equal(views.copied - views_still.copied, edited.copied - still.copied);
        assert_int_equal(views_still.copied, count * still.copied); /* counts for the CPU */
    }
    spy_end();
    stage_close(&stage);
}

/* ---- what is refused ---- */

static void expect(struct stage *stage, const fnl_frame *frame, fnl_result result) {
    assert_int_equal(fnl_renderer_render(stage->renderer, frame), result);
}

static void test_what_takes_one_view(void **state) {
    UNUSED(state);
    struct stage stage = open_glass();
    fnl_camera cameras[MOST];
    views_place(&stage, cameras);
    fnl_frame frame = stage.frame;
    frame.views = cameras;
    frame.view_count = 2;
    for (int s = 0; s < FNL_SHADING_COUNT; s++) {
        frame.shading = (fnl_shading)s; /* all others are rendered by test_all_paths */
        assert_int_equal(shading_is(frame.shading, SHADING_VIEWS), s != FNL_SHADING_VIRTUAL_TEXTURING && s != FNL_SHADING_AUTO);
    }
    frame.shading = FNL_SHADING_VIRTUAL_TEXTURING;
    expect(&stage, &frame, FNL_ERROR_UNSUPPORTED);
    frame.shading = FNL_SHADING_DEFERRED;
    frame.lists = FNL_LISTS_TILED;
    frame.light_lod = 1;
    expect(&stage, &frame, FNL_ERROR_UNSUPPORTED);
    frame.light_lod = 0;
    frame.view_count = FNL_VIEWS_MAX + 1;
    expect(&stage, &frame, FNL_ERROR_INVALID);
    frame.view_count = 1;
    frame.views = NULL;
    expect(&stage, &frame, FNL_ERROR_INVALID);
    frame.views = cameras;
    frame.view_count = 3;
    cameras[2].vertical_extent = -1;
    expect(&stage, &frame, FNL_ERROR_INVALID);
    frame.view_count = 2; /* the third is not looked at, nor is the camera of a frame with one view */
    frame.camera.vertical_fov = -1;
    frame.shading = FNL_SHADING_AUTO;
    frame.lists = FNL_LISTS_AUTO;
    struct shot both = stage_shoot(&stage, &frame);
    assert_int_equal(both.stats.shading, FNL_SHADING_DEFERRED);
    assert_int_equal(both.stats.lists, FNL_LISTS_CLUSTERED);
    frame.view_count = 1;
    frame.shading = FNL_SHADING_FORWARD; /* one view is a frame as any other */
    frame.lists = FNL_LISTS_ZBIN;
    struct shot one = stage_shoot(&stage, &frame);
    assert_int_equal(one.stats.view_count, 0);
    assert_int_equal(one.color.height, HEIGHT);
    shot_free(&both);
    shot_free(&one);
    stage_close(&stage);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_views_equal_frames, harness_check),
        cmocka_unit_test_teardown(test_all_lists, harness_check),
        cmocka_unit_test_teardown(test_all_paths, harness_check),
        cmocka_unit_test_teardown(test_views_with_the_rest_of_a_frame, harness_check),
        cmocka_unit_test_teardown(test_views_keep_histories_of_their_own, harness_check),
        cmocka_unit_test_teardown(test_what_views_share_is_done_once, spy_tear_down),
        cmocka_unit_test_teardown(test_what_takes_one_view, harness_check),
    };
    return cmocka_run_group_tests_name("views", tests, test_group_begin, test_group_end);
}
