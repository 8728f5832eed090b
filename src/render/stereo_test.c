/* SPDX-License-Identifier: MIT */
/** The eyes of one viewer: what they share, and that each sees what it would see alone. */
#include "render/eyes.h"
#include "render/stereo.h"

#include "fanal/stereo.h"
#include "render/view.h"
#include "tests/render_test.h"
#include "tests/vulkan_spy.h"

enum { WIDTH = 53, HEIGHT = 37 };

/* ---- the common frustum, without a device ---- */

static uint32_t seed;
static float rnd(float low, float high) {
    seed = seed * 1664525u + 1013904223u;
    return low + (high - low) * (float)(seed >> 8) / 16777216.0f;
}

enum rig { SYMMETRIC, ASYMMETRIC, CANTED, CAVE, RIGS };

static quat turned_by(quat a, quat b) { return quat_normalize(quat_mul(a, b)); }

static fnl_rigid_pose random_head(void) {
    const quat q = quat_normalize((quat){rnd(-1, 1), rnd(-1, 1), rnd(-1, 1), rnd(0.1f, 1)});
    return (fnl_rigid_pose){{rnd(-9, 9), rnd(-9, 9), rnd(-9, 9)}, q};
}

/* A wall of a CAVE, seen from two places before it: off-axis, both eyes look at right angles to it. */
static void make_rig(enum rig rig, fnl_eye eyes[2]) {
    const float ipd = rnd(0, 0.08f), outer = rnd(0.7f, 1.6f), inner = rig == ASYMMETRIC ? rnd(0.3f, 0.7f) : outer, up = rnd(0.4f, 1.5f),
                down = rig == SYMMETRIC ? up : rnd(0.4f, 1.5f);
    for (int i = 0; i < 2; i++) {
        const float side = i ? 1.0f : -1.0f;
        eyes[i] = (fnl_eye){.pose = {{side * ipd / 2, 0, 0}, {0, 0, 0, 1}}, .left = i ? -inner : -outer, .right = i ? outer : inner, .down = -down, .up = up};
    }
    if (rig == CANTED) {
        const float half = rnd(0, 0.15f);
        for (int i = 0; i < 2; i++) eyes[i].pose.rotation = (fnl_vec4){0, (i ? -1.0f : 1.0f) * sinf(half), 0, cosf(half)};
        eyes[0].pose.position.y = rnd(-0.005f, 0.005f);
        eyes[1].pose.position.z = rnd(-0.005f, 0.005f);
    }
    if (rig == CAVE) {
        const vec3 head = {rnd(-1, 1), rnd(-1, 1), rnd(0.4f, 2)}, across = vec3_scale(vec3_normalize((vec3){rnd(-1, 1), rnd(-0.2f, 0.2f), rnd(-0.5f, 0.5f)}), ipd / 2);
        for (int i = 0; i < 2; i++) {
            const vec3 at = vec3_add_scaled(head, across, i ? 1.0f : -1.0f);
            eyes[i] = (fnl_eye){.pose = {at, {0, 0, 0, 1}}, .left = (-1.5f - at.x) / at.z, .right = (1.5f - at.x) / at.z, .down = (-1.2f - at.y) / at.z, .up = (1.2f - at.y) / at.z};
        }
    }
}

static struct gpu_view view_of(const fnl_eye *eye, const fnl_rigid_pose *head) {
    fnl_camera camera;
    assert_int_equal(fnl_eye_query_camera(NULL, eye, head, 640, 360, 0.05f, &camera), FNL_OK);
    return view_from_camera(&camera, 640, 360);
}

static vec3 point_in(const struct gpu_view *view) {
    const float x = rnd(-1, 1), y = rnd(-1, 1), edge = rnd(0, 1), depth = view->near_distance * powf(10, rnd(0, 5));
    const float nx = edge < 0.3f ? copysignf(1, x) : x, ny = edge > 0.2f && edge < 0.5f ? copysignf(1, y) : y; /* many at the borders */
    const vec3 seen = {(nx * view->ndc_scale.x + view->ndc_offset.x) * depth, (ny * view->ndc_scale.y + view->ndc_offset.y) * depth, -depth};
    return mat4_point(&view->view_to_world, seen);
}

/* As culling has it: rounding aside. */
static bool holds(const struct gpu_view *view, vec3 p) {
    const float slack = 2e-6f * (1 + vec3_length(p) + vec3_length(view->eye));
    for (int i = 0; i < 5; i++)
        if (!(view->planes[i].x * p.x + view->planes[i].y * p.y + view->planes[i].z * p.z + view->planes[i].w >= -slack)) return false;
    return true;
}

/* Quilez' rule for parallel eyes: the inner planes of both, each moved to the other eye. */
static bool quilez_holds(const fnl_eye eyes[2], const fnl_rigid_pose *head, vec3 p) {
    const mat4 of_head = mat4_from_trs(head->position, head->rotation, vec3_make(1, 1, 1));
    mat4 to_head;
    mat4_inverse(&of_head, &to_head);
    const vec3 q = mat4_point(&to_head, p);
    const float slack = 1e-4f + 3e-6f * vec3_length(q);
    return q.x - eyes[1].pose.position.x <= eyes[0].right * -q.z + slack && q.x - eyes[0].pose.position.x >= eyes[1].left * -q.z - slack;
}

static void test_common_frustum_holds_what_eyes_see_VR_5(void **state) {
    UNUSED(state);
    seed = 5;
    uint32_t lost_by_quilez[RIGS] = {0};
    for (uint32_t n = 0; n < 1000; n++) {
        const enum rig rig = (enum rig)(n % RIGS);
        fnl_eye eyes[2];
        make_rig(rig, eyes);
        const fnl_rigid_pose head = random_head();
        const struct gpu_view views[2] = {view_of(&eyes[0], &head), view_of(&eyes[1], &head)};
        struct gpu_view both;
        assert_true(eyes_combine(views, 2, 0, &both));
        for (uint32_t i = 0; i < 1000; i++) { /* a million in all */
            const vec3 p = point_in(&views[i & 1]);
            if (!holds(&both, p)) fail_msg("rig %d, %u: eye %u sees %g %g %g", rig, n, i & 1, (double)p.x, (double)p.y, (double)p.z);
            lost_by_quilez[rig] += rig < CANTED && !quilez_holds(eyes, &head, p);
        }
    }
    assert_int_equal(lost_by_quilez[SYMMETRIC], 0);
    assert_true(lost_by_quilez[ASYMMETRIC] > 10000);
}

static void test_common_frustum_is_tight(void **state) {
    UNUSED(state);
    seed = 6;
    for (uint32_t n = 0; n < 200; n++) {
        fnl_eye eyes[2];
        make_rig(n & 1 ? SYMMETRIC : ASYMMETRIC, eyes);
        const fnl_rigid_pose head = {{0, 0, 0}, {0, 0, 0, 1}};
        const struct gpu_view views[2] = {view_of(&eyes[0], &head), view_of(&eyes[1], &head)};
        struct gpu_view both;
        assert_true(eyes_combine(views, 2, 0, &both));
        assert_float_equal(both.ndc_offset.x + both.ndc_scale.x, eyes[1].right, 1e-3f);
        assert_float_equal(both.ndc_offset.x - both.ndc_scale.x, eyes[0].left, 1e-3f);
        assert_float_equal(both.ndc_offset.y + both.ndc_scale.y, eyes[0].up, 1e-3f);
        const float behind = (eyes[1].pose.position.x - eyes[0].pose.position.x) / (eyes[1].right - eyes[0].left);
        assert_float_equal(both.eye.z, behind, 1e-4f);
        assert_float_equal(both.near_distance, behind + 0.05f, 1e-3f);
    }
}

static void test_late_poses_within_the_margin_VR_6(void **state) {
    UNUSED(state);
    seed = 7;
    const float degrees = PI / 180, margin = 5 * degrees;
    uint32_t lost = 0;
    for (uint32_t n = 0; n < 400; n++) {
        fnl_eye eyes[2];
        make_rig((enum rig)(n % CAVE), eyes);
        fnl_rigid_pose head = random_head();
        const struct gpu_view views[2] = {view_of(&eyes[0], &head), view_of(&eyes[1], &head)};
        struct gpu_view both;
        if (!eyes_combine(views, 2, margin, &both)) continue; /* eyes see almost to the side already */
        const vec3 axis = vec3_normalize((vec3){rnd(-1, 1), rnd(-1, 1), rnd(-1, 1)});
        for (uint32_t twice = 0; twice < 2; twice++) {
            const float half = (twice ? 2 : 0.999f) * margin / 2;
            const fnl_rigid_pose later = {head.position, turned_by(head.rotation, (quat){axis.x * sinf(half), axis.y * sinf(half), axis.z * sinf(half), cosf(half)})};
            const struct gpu_view turned[2] = {view_of(&eyes[0], &later), view_of(&eyes[1], &later)};
            for (uint32_t i = 0; i < 500; i++) {
                const vec3 p = point_in(&turned[i & 1]);
                const bool held = holds(&both, p);
                if (!twice && !held) fail_msg("rig %u of %u: %g %g %g is lost", n % CAVE, n, (double)p.x, (double)p.y, (double)p.z);
                lost += twice && !held;
            }
        }
    }
    assert_true(lost > 1000);
}

static void test_eyes_that_look_apart_have_none(void **state) {
    UNUSED(state);
    const fnl_rigid_pose head = {{0, 0, 0}, {0, 0, 0, 1}};
    fnl_eye eye = {.pose = {{0, 0, 0}, {0, 0, 0, 1}}, .left = -1, .right = 1, .down = -1, .up = 1};
    struct gpu_view views[2], both;
    views[0] = view_of(&eye, &head);
    const float half = 50 * PI / 180; /* by 100 degrees */
    eye.pose.rotation = (fnl_vec4){0, sinf(half), 0, cosf(half)};
    views[1] = view_of(&eye, &head);
    assert_false(eyes_combine(views, 2, 0, &both));
    views[1] = views[0];
    views[1].orthographic = 1;
    assert_false(eyes_combine(views, 2, 0, &both));
}

/* ---- frames ---- */

/* Two eyes at the stage's camera; `canted`: their pictures point 8 degrees outwards, with edges that differ. */
static void place_eyes(const struct stage *stage, float ipd, bool canted, fnl_camera out[2]) {
    const fnl_camera *camera = &stage->frame.camera;
    const vec3 back = vec3_normalize(vec3_sub(camera->position, camera->target)), right = vec3_normalize(vec3_cross(camera->up, back));
    const float y = tanf(camera->vertical_fov / 2), x = y * (float)stage->frame.width / (float)stage->frame.height;
    for (int i = 0; i < 2; i++) {
        const float side = i ? 1.0f : -1.0f, turn = canted ? side * 8 * PI / 180 : 0;
        out[i] = *camera;
        out[i].position = vec3_add_scaled(camera->position, right, side * ipd / 2);
        out[i].target = vec3_add(out[i].position, vec3_add(vec3_scale(back, -cosf(turn)), vec3_scale(right, sinf(turn))));
        if (canted) out[i].shift = (fnl_vec2){side * 0.2f * x, 0.1f};
    }
}

static fnl_frame frame_of(const struct stage *stage, const fnl_camera eyes[2]) {
    fnl_frame frame = stage->frame;
    frame.views = eyes;
    frame.view_count = 2;
    frame.stereo.eyes = 2;
    return frame;
}

static struct stage open_stage(const char *source, uint32_t scattered) {
    struct stage stage = stage_open(source, scattered);
    stage.frame.width = WIDTH;
    stage.frame.height = HEIGHT;
    return stage;
}

/* Each eye alone, by another renderer, against the display. */
static void check_alone(struct stage *stage, fnl_renderer *other, const fnl_frame *frame, const char *what) {
    const fnl_output outputs[] = {FNL_OUTPUT_RADIANCE, FNL_OUTPUT_COLOR};
    fnl_frame alone = *frame;
    alone.stereo = frame_plain().stereo;
    alone.multiview = FNL_MULTIVIEW_OFF;
    test_render_frame(stage->renderer, frame);
    test_render_frame(other, &alone);
    for (uint32_t o = 0; o < COUNT_OF(outputs); o++) {
        if (!(frame->outputs & outputs[o]) || (outputs[o] == FNL_OUTPUT_COLOR && frame->exposure == FNL_EXPOSURE_AUTO)) continue;
        fnl_image a = test_read(stage->renderer, outputs[o]), b = test_read(other, outputs[o]);
        const uint64_t differing = count_differing(&a, &b);
        if (differing) fail_msg("%s: %llu pixels of both eyes differ from each alone", what, (unsigned long long)differing);
        free_picture(&a);
        free_picture(&b);
    }
}

static void test_eyes_equal_each_alone_VR_1(void **state) {
    UNUSED(state);
    static const struct {
        fnl_shading shading;
        fnl_light_lists lists;
        uint32_t msaa;
        fnl_stereo_lists of;
        fnl_stereo_path path;
    } rows[] = {{FNL_SHADING_DEFERRED, FNL_LISTS_TILED, 1, FNL_STEREO_LISTS_EYE, FNL_STEREO_PATH_AUTO},
                {FNL_SHADING_DEFERRED, FNL_LISTS_CLUSTERED, 1, FNL_STEREO_LISTS_HEAD, FNL_STEREO_PATH_INSTANCES},
                {FNL_SHADING_DEFERRED, FNL_LISTS_CLUSTERED_CPU, 1, FNL_STEREO_LISTS_HEAD, FNL_STEREO_PATH_OBJECTS},
                {FNL_SHADING_FORWARD_PREPASS, FNL_LISTS_CLUSTERED, 4, FNL_STEREO_LISTS_HEAD, FNL_STEREO_PATH_MULTIVIEW},
                {FNL_SHADING_FORWARD, FNL_LISTS_BVH, 1, FNL_STEREO_LISTS_HEAD, FNL_STEREO_PATH_AUTO},
                {FNL_SHADING_VISIBILITY, FNL_LISTS_ZBIN, 1, FNL_STEREO_LISTS_HEAD, FNL_STEREO_PATH_INSTANCES},
                {FNL_SHADING_DEFERRED, FNL_LISTS_RASTER, 4, FNL_STEREO_LISTS_HEAD, FNL_STEREO_PATH_AUTO},
                {FNL_SHADING_VISIBILITY, FNL_LISTS_WORLD, 4, FNL_STEREO_LISTS_EYE, FNL_STEREO_PATH_EYES}};
    struct stage stage = open_stage("builtin:glass", 60);
    fnl_renderer *other = test_renderer(stage.scene);
    fnl_camera eyes[2];
    for (uint32_t i = 0; i < COUNT_OF(rows); i++) {
        char what[96];
        place_eyes(&stage, 0.064f, i & 1, eyes);
        fnl_frame frame = frame_of(&stage, eyes);
        frame.shading = rows[i].shading;
        frame.lists = rows[i].lists;
        frame.msaa = rows[i].msaa;
        frame.stereo.lists = rows[i].of;
        frame.stereo.path = rows[i].path;
        snprintf(what, sizeof what, "row %u", i);
        check_alone(&stage, other, &frame, what);
    }
    fnl_renderer_destroy(&other);
    stage_close(&stage);
}

/* What the plan says of the passes that draw both eyes. */
static bool plan_says(const struct stage *stage, const char *what) {
    static char text[1 << 18];
    assert_true(fnl_renderer_print(stage->renderer, FNL_PRINT_PLAN, text, sizeof text) < sizeof text);
    return strstr(text, what) != NULL;
}

static const struct way {
    fnl_stereo_path path;
    const char *plan;
} ways[] = {{FNL_STEREO_PATH_OBJECTS, ", 2 layers at once:"}, {FNL_STEREO_PATH_INSTANCES, ", 2 layers at once:"}, {FNL_STEREO_PATH_MULTIVIEW, ", views 0x3 at once:"}};

/* Every way to draw for two eyes against each eye alone: cutouts, in what shades before lists and after them, and skins. */
static void test_ways_to_draw_equal_each_alone_VR_1(void **state) {
    UNUSED(state);
    static const struct {
        const char *source;
        fnl_shading shading;
        bool prepass;
        uint32_t msaa;
    } rows[] = {{"builtin:grass?lights=20", FNL_SHADING_DEFERRED, true, 1},
                {"builtin:grass?lights=20", FNL_SHADING_VISIBILITY, false, 1},
                {"builtin:grass?lights=20", FNL_SHADING_FORWARD_PREPASS, false, 4},
                {"CesiumMan.glb", FNL_SHADING_DEFERRED, false, 1}};
    fnl_camera eyes[2];
    for (uint32_t i = 0; i < COUNT_OF(rows); i++) {
        struct stage stage = open_stage(rows[i].source, i == 3 ? 30 : 0);
        fnl_renderer *other = test_renderer(stage.scene);
        place_eyes(&stage, 0.064f, true, eyes);
        fnl_frame frame = frame_of(&stage, eyes), alone;
        frame.lists = FNL_LISTS_TILED;
        frame.shading = rows[i].shading;
        frame.gbuffer.prepass = rows[i].prepass;
        frame.msaa = rows[i].msaa;
        frame.outputs = FNL_OUTPUT_RADIANCE;
        if (i == 3) frame.gbuffer.normals = FNL_NORMALS_VIEW; /* fragment shaders take the eye's camera */
        if (i == 3) assert_int_equal(fnl_scene_set_time(stage.scene, 0, 0.7), FNL_OK);
        alone = frame;
        alone.stereo = frame_plain().stereo;
        alone.multiview = FNL_MULTIVIEW_OFF;
        test_render_frame(other, &alone);
        fnl_image expected = test_read(other, FNL_OUTPUT_RADIANCE);
        for (uint32_t w = 0; w < COUNT_OF(ways); w++) {
            frame.stereo.path = ways[w].path;
            test_render_frame(stage.renderer, &frame);
            assert_true(plan_says(&stage, ways[w].plan));
            fnl_image image = test_read(stage.renderer, FNL_OUTPUT_RADIANCE);
            const uint64_t differing = count_differing(&image, &expected);
            if (differing) fail_msg("row %u: %llu pixels of the path %s differ", i, (unsigned long long)differing, fnl_value_name(FNL_ENUM_STEREO_PATH, ways[w].path));
            free_picture(&image);
        }
        /* Clusters are culled for one view: eyes are drawn one by one. */
        frame.culling = FNL_CULLING_CLUSTERS;
        frame.stereo.path = FNL_STEREO_PATH_INSTANCES;
        if (i == 0) test_render_frame(stage.renderer, &frame);
        if (i == 0) assert_false(plan_says(&stage, " at once:"));
        free_picture(&expected);
        fnl_renderer_destroy(&other);
        stage_close(&stage);
    }
}

static void test_histories_and_shadows_VR_1(void **state) {
    UNUSED(state);
    struct stage stage = open_stage("builtin:hall?lights=30", 0);
    fnl_renderer *other = test_renderer(stage.scene);
    fnl_camera eyes[2];
    place_eyes(&stage, 0.064f, false, eyes);
    fnl_frame frame = frame_of(&stage, eyes);
    frame.shadows = FNL_SHADOWS_MAPS;
    frame.lists = FNL_LISTS_CLUSTERED;
    frame.stereo.lists = FNL_STEREO_LISTS_HEAD;
    for (uint32_t n = 0; n < 4; n++) {
        frame.aa = n == 1 || n == 2 ? FNL_ANTIALIASING_TAA : FNL_ANTIALIASING_NONE;
        frame.culling = n == 2 ? FNL_CULLING_CLUSTERS : n == 3 ? FNL_CULLING_TRIANGLES : FNL_CULLING_INSTANCES; /* each eye has its own triangles */
        for (uint32_t i = 0; i < 2; i++) eyes[i].position.x += 0.02f;
        check_alone(&stage, other, &frame, "shadow maps");
    }
    fnl_renderer_destroy(&other);
    stage_close(&stage);
}

/* ---- work that is done once ---- */

static uint32_t count_passes(const struct stage *stage, const char *name) {
    static char text[1 << 18];
    assert_true(fnl_renderer_print(stage->renderer, FNL_PRINT_PLAN, text, sizeof text) < sizeof text);
    uint32_t count = 0;
    for (char *line = strtok(text, "\n"); line; line = strtok(NULL, "\n")) count += strstr(line, "  pass ") == line && strstr(line, name);
    return count;
}

/*
 * Pages of shadow maps lie at other places in the atlas with both eyes than with one, and what is drawn into them is rounded by where that is. Nothing else
 * differs: the renderer that has shown both eyes has the pages of each where they were, and shows the same bits.
 */
static void check_same_pages(struct stage *stage, const fnl_frame *both) {
    fnl_image a = test_read(stage->renderer, FNL_OUTPUT_RADIANCE);
    const fnl_frame_stats shared = harness_stats(stage->renderer);
    assert_int_equal(counter(&shared.views[0], "shadows.coarsened"), 0);
    fnl_frame alone = *both;
    alone.stereo = frame_plain().stereo;
    alone.view_count = 1;
    for (uint32_t i = 0; i < 2; i++) {
        fnl_image eye = a;
        eye.height /= 2;
        eye.pixels = (char *)a.pixels + i * (size_t)eye.width * eye.height * fnl_pixel_size(a.format);
        alone.views = &both->views[i];
        test_render_frame(stage->renderer, &alone);
        const fnl_frame_stats stats = harness_stats(stage->renderer);
        fnl_image b = test_read(stage->renderer, FNL_OUTPUT_RADIANCE);
        assert_int_equal(counter(&stats, "shadows.drawn"), 0);
        assert_true(counter(&stats, "shadows.wanted") < counter(&shared.views[0], "shadows.wanted"));
        assert_int_equal(count_differing(&eye, &b), 0);
        free_picture(&b);
    }
    free_picture(&a);
}

/* One list for both, unless eyes look so far apart that its grid has more cells than theirs have together. The pictures are the same. */
static void check_lists_by_angle(struct stage *stage, fnl_frame frame) {
    fnl_camera eyes[2] = {frame.views[0], frame.views[1]};
    const vec3 ahead = vec3_sub(eyes[0].target, eyes[0].position), right = vec3_normalize(vec3_cross(ahead, eyes[0].up));
    frame.views = eyes;
    for (int apart = 0; apart < 2; apart++) {
        for (int i = 0; i < 2 && apart; i++) eyes[i].target = vec3_add_scaled(eyes[i].target, right, (i ? 0.6f : -0.6f) * vec3_length(ahead));
        frame.stereo.lists = FNL_STEREO_LISTS_AUTO;
        test_render_frame(stage->renderer, &frame);
        assert_int_equal(count_passes(stage, "clustered fill'"), apart ? 2 : 1);
        fnl_image a = test_read(stage->renderer, FNL_OUTPUT_RADIANCE);
        frame.stereo.lists = apart ? FNL_STEREO_LISTS_HEAD : FNL_STEREO_LISTS_EYE;
        test_render_frame(stage->renderer, &frame);
        assert_int_equal(count_passes(stage, "clustered fill'"), apart ? 1 : 2);
        fnl_image b = test_read(stage->renderer, FNL_OUTPUT_RADIANCE);
        assert_int_equal(count_differing(&a, &b), 0);
        free_picture(&a);
        free_picture(&b);
    }
}

static void test_shared_work_VR_1_VR_2(void **state) {
    UNUSED(state);
    struct stage stage = open_stage("builtin:hall?lights=30", 0);
    fnl_camera eyes[2];
    place_eyes(&stage, 0.064f, false, eyes);
    fnl_frame one = stage.frame, both = frame_of(&stage, eyes);
    one.camera = eyes[0];
    both.shadows = one.shadows = FNL_SHADOWS_MAPS;
    both.lists = one.lists = FNL_LISTS_CLUSTERED;
    both.exposure = one.exposure = FNL_EXPOSURE_AUTO;
    test_render_frame(stage.renderer, &one);
    const fnl_frame_stats alone = harness_stats(stage.renderer);
    const uint64_t pages = counter(&alone, "shadows.wanted"), draws = alone.draws;
    test_render_frame(stage.renderer, &both);
    fnl_frame_stats stats = harness_stats(stage.renderer);
    assert_int_equal(count_passes(&stage, "cull mark'"), 1);
    assert_int_equal(count_passes(&stage, "clustered fill'"), 1);
    assert_int_equal(count_passes(&stage, "exposure'"), 1);
    assert_true(count_passes(&stage, "shadow requests'") == 2);
    /* Draw calls of both eyes: 2 of one eye drawn after the other, once at once. */
    assert_int_equal(stats.views[0].draws, draws);
    assert_int_equal(stats.views[1].draws, 0);
    assert_true(counter(&stats.views[0], "shadows.wanted") > 0);
    /* Of so small a picture; docs/techniques/stereo.md has larger ones. */
    assert_true((double)counter(&stats.views[0], "shadows.wanted") <= 1.25 * (double)pages);
    assert_false(has_counter(&stats.views[1], "shadows.wanted"));
    check_same_pages(&stage, &both);
    both.stereo.eyes = 0;
    both.multiview = FNL_MULTIVIEW_OFF;
    test_render_frame(stage.renderer, &both);
    assert_true(count_passes(&stage, "cull mark'") == 2);
    assert_true(count_passes(&stage, "clustered fill'") == 2);
    both.stereo.eyes = 2;
    both.multiview = FNL_MULTIVIEW_AUTO;
    check_lists_by_angle(&stage, both);
    stage_close(&stage);
}

static uint32_t binds; /* of pipelines of the G-buffer */

static const struct gpu_pipeline *count_bind(gpu_device *device, const struct gpu_pipeline *bound) {
    UNUSED(device);
    const struct gpu_graphics_params *params = spy_graphics_params(bound);
    binds += params && params->fragment && strncmp(params->fragment->name, "gbuffer", 7) == 0;
    return bound;
}

/* Draws 2:2:1:1, states 2:1:1:1, and how often the vertex shader runs. */
static void test_ways_to_draw_are_counted_VR_2(void **state) {
    UNUSED(state);
    enum { WAYS = 4 };
    static const fnl_stereo_path paths[WAYS] = {FNL_STEREO_PATH_EYES, FNL_STEREO_PATH_OBJECTS, FNL_STEREO_PATH_INSTANCES, FNL_STEREO_PATH_MULTIVIEW};
    static const uint64_t draw_ratio[WAYS] = {2, 2, 1, 1}, state_ratio[WAYS] = {2, 1, 1, 1};
    struct stage stage = open_stage("builtin:hall?lights=30", 0); /* nothing is blended in it */
    fnl_camera eyes[2];
    place_eyes(&stage, 0.064f, false, eyes);
    fnl_frame frame = frame_of(&stage, eyes);
    frame.lists = FNL_LISTS_TILED;
    frame.record_threads = 1;
    frame.count_lights = true;
    uint64_t one_draws = 0, one_states = 0, vertices[WAYS] = {0};
    spy_begin(harness_device());
    for (uint32_t w = 0; w < WAYS; w++) {
        uint64_t draws = 0, states = 0;
        uint32_t recorded = 0;
        spy_clear();
        spy.replace = count_bind;
        binds = 0;
        frame.stereo.path = paths[w];
        test_render_frame(stage.renderer, &frame);
        const fnl_frame_stats stats = harness_stats(stage.renderer);
        for (uint32_t v = 0; v < 2; v++) {
            if (v > 0 && w > 0) {
                assert_false(has_counter(&stats.views[v], "stereo.states") || has_counter(&stats.views[v], "stereo.vertices"));
                assert_int_equal(stats.views[v].draws, 0);
                continue;
            }
            draws += stats.views[v].draws;
            states += counter(&stats.views[v], "stereo.states");
            vertices[w] += counter(&stats.views[v], "stereo.vertices");
        }
        for (uint32_t i = 0; i < spy.work_count; i++) recorded += spy.work[i].indirect && spy_graphics_params(spy.work[i].pipeline);
        assert_int_equal(recorded, draws);
        assert_int_equal(binds, states);
        if (w == 0) one_draws = draws / 2;
        if (w == 0) one_states = states / 2;
        assert_true(one_draws > 1 && one_states > 1);
        assert_int_equal(draws, draw_ratio[w] * one_draws);
        assert_int_equal(states, state_ratio[w] * one_states);
    }
    spy_end();
    print_message("vertices of A, B, E, G: %llu %llu %llu %llu\n", (unsigned long long)vertices[0], (unsigned long long)vertices[1], (unsigned long long)vertices[2],
                  (unsigned long long)vertices[3]);
    /* Eyes have one frustum, so that they draw the same. A device may share what multiview runs. */
    assert_true(vertices[0] > 1000);
    assert_int_equal(vertices[1], vertices[0]);
    assert_int_equal(vertices[2], vertices[0]);
    assert_true(vertices[3] >= vertices[0] / 2 && vertices[3] <= vertices[0]);
    frame.count_lights = false;
    test_render_frame(stage.renderer, &frame);
    const fnl_frame_stats plain = harness_stats(stage.renderer);
    assert_false(has_counter(&plain.views[0], "stereo.vertices"));
    stage_close(&stage);
}

/* Marks of the union in the last frame, after their prefix sum: how many items both eyes draw at once. */
static uint32_t count_union(struct stage *stage, const fnl_frame *frame, uint32_t items) {
    struct gpu_buffer sums;
    assert_int_equal(gpu_buffer_create(harness_device(), "sums", (items + 1) * 4ull, GPU_MEMORY_READBACK, &sums), FNL_OK);
    spy_capture(stage->renderer->graph, "views 0-1/cull fill", "views 0-1/cull visible sums", &sums);
    test_render_frame(stage->renderer, frame);
    assert_int_equal(gpu_wait_idle(harness_device()), FNL_OK);
    spy_capture(NULL, NULL, NULL, NULL);
    const uint32_t count = ((const uint32_t *)sums.mapped)[items];
    gpu_buffer_destroy(harness_device(), &sums);
    return count;
}

/* A wall before a row of small things. Each eye sees past it on its own side: what it hides from one alone is drawn all the same, and what from both is not. */
static void test_eyes_draw_what_either_sees_VR_1_VR_2(void **state) {
    UNUSED(state);
    enum { THINGS = 33, ITEMS = THINGS + 1 };
    fnl_scene *scene = test_scene();
    const fnl_material_params material = fnl_material_params_default();
    const uint32_t mesh = test_quad_mesh(scene, test_material(scene, &material).index);
    test_place(scene, mesh, (vec3){0, 0, -2}, (vec3){0.5f, 2, 1});
    for (int i = 0; i < THINGS; i++) test_place(scene, mesh, (vec3){0.1f * (float)(i - THINGS / 2), 0, -6}, (vec3){0.02f, 0.3f, 1});
    spy_begin(harness_device()); /* sees only images made from here on */
    struct stage stage = stage_open_scene(scene);
    stage.frame.width = 160;
    stage.frame.height = 90;
    stage.frame.camera.position = (vec3){0, 0, 0};
    stage.frame.camera.target = (vec3){0, 0, -1};
    stage.frame.outputs = FNL_OUTPUT_RADIANCE;
    stage.frame.shading = FNL_SHADING_DEFERRED;
    fnl_renderer *other = test_renderer(stage.scene);
    fnl_camera eyes[2];
    place_eyes(&stage, 0.3f, false, eyes);
    fnl_frame frame = frame_of(&stage, eyes);
    frame.record_threads = 1; /* the spy looks on */
    test_render_frame(stage.renderer, &frame);
    const uint32_t draws = harness_stats(stage.renderer).views[0].draws;
    frame.occlusion = FNL_OCCLUSION_ON;
    for (uint32_t n = 0; n < 3; n++) { /* the second has depth of the first to begin with */
        if (n == 1) frame.stereo.path = FNL_STEREO_PATH_INSTANCES;
        if (n == 2) frame.stereo.path = FNL_STEREO_PATH_OBJECTS;
        if (n == 2) frame.shading = FNL_SHADING_VISIBILITY;
        fnl_frame plain = frame;
        plain.occlusion = FNL_OCCLUSION_OFF;
        const uint32_t together = count_union(&stage, &frame, ITEMS);
        const fnl_frame_stats stats = harness_stats(stage.renderer);
        assert_true(stats.occlusion);
        const uint64_t hidden[2] = {stats.views[0].items_occluded, stats.views[1].items_occluded};
        assert_true(hidden[0] > 10 && hidden[1] > 10);
        assert_true(together > stats.views[0].items_visible && together > stats.views[1].items_visible && together < ITEMS - 5);
        assert_int_equal(count_passes(&stage, "cull union'"), 1);
        if (n < 2) assert_int_equal(stats.views[0].draws, draws);
        assert_int_equal(stats.views[1].draws, 0);
        fnl_image a = test_read(stage.renderer, FNL_OUTPUT_RADIANCE);
        plain.stereo = frame_plain().stereo;
        plain.multiview = FNL_MULTIVIEW_OFF;
        test_render_frame(other, &plain);
        fnl_image b = test_read(other, FNL_OUTPUT_RADIANCE);
        assert_int_equal(count_differing(&a, &b), 0);
        free_picture(&a);
        free_picture(&b);
    }
    fnl_renderer_destroy(&other);
    stage_close(&stage);
    spy_end();
}

/* An eye that looks into the dark is not metered alone. */
static void test_one_exposure(void **state) {
    UNUSED(state);
    struct stage stage = open_stage("builtin:hall?lights=30", 0);
    fnl_camera eyes[2];
    place_eyes(&stage, 0.064f, true, eyes);
    fnl_frame frame = frame_of(&stage, eyes);
    frame.exposure = FNL_EXPOSURE_AUTO;
    test_render_frame(stage.renderer, &frame);
    fnl_frame_stats stats = harness_stats(stage.renderer);
    assert_true(stats.views[0].ev == stats.views[1].ev);
    frame.stereo.eyes = 0;
    test_render_frame(stage.renderer, &frame);
    const fnl_frame_stats apart = harness_stats(stage.renderer);
    assert_true(apart.views[0].ev != apart.views[1].ev);
    assert_true(stats.views[0].ev > fminf(apart.views[0].ev, apart.views[1].ev) && stats.views[0].ev < fmaxf(apart.views[0].ev, apart.views[1].ev));
    stage_close(&stage);
}

/* ---- geometry of two eyes ---- */

/* Mean column of the pixels that show something, over `frames` places in the pixel. */
static double mean_column(fnl_renderer *renderer, fnl_frame frame, uint32_t view, uint32_t frames) {
    double sum = 0;
    uint64_t count = 0;
    for (uint32_t n = 0; n < frames; n++) {
        frame.jitter = fnl_jitter(n);
        test_render_frame(renderer, &frame);
        fnl_image image = test_read(renderer, FNL_OUTPUT_POSITION);
        const float *p = (const float *)image.pixels + (size_t)view * frame.width * frame.height * 4;
        for (uint32_t i = 0; i < frame.width * frame.height; i++) {
            if (!(p[4 * i + 3] > 0)) continue;
            sum += i % frame.width + 0.5 + (double)frame.jitter.x;
            count++;
        }
        free_picture(&image);
    }
    assert_true(count > 100 * (uint64_t)frames);
    return sum / (double)count;
}

static void test_disparity_of_a_known_box_VR_4(void **state) {
    UNUSED(state);
    fnl_scene *scene = test_scene();
    const fnl_material_params material = fnl_material_params_default();
    test_place(scene, test_quad_mesh(scene, test_material(scene, &material).index), (vec3){0, 0, -2}, (vec3){0.5f, 0.5f, 0.5f});
    struct stage stage = stage_open_scene(scene);
    const fnl_rigid_pose head = {{0, 0, 0}, {0, 0, 0, 1}};
    fnl_camera eyes[2];
    fnl_frame frame = stage.frame;
    frame.width = 96;
    frame.height = 54;
    frame.outputs = FNL_OUTPUT_POSITION;
    frame.views = eyes;
    frame.view_count = frame.stereo.eyes = 2;
    const float ipd = 0.0635f, tangent = 0.8f;
    for (int apart = 0; apart < 2; apart++) {
        for (int i = 0; i < 2; i++) {
            const fnl_eye eye = {.pose = {{apart ? (i ? ipd : -ipd) / 2 : 0, 0, 0}, {0, 0, 0, 1}}, .left = -tangent, .right = tangent, .down = -0.45f, .up = 0.45f};
            assert_int_equal(fnl_eye_query_camera(NULL, &eye, &head, frame.width, frame.height, 0.05f, &eyes[i]), FNL_OK);
        }
        const double left = mean_column(stage.renderer, frame, 0, 16), right = mean_column(stage.renderer, frame, 1, 16);
        const double focal = frame.width / (2.0 * (double)tangent), expected = apart ? focal * (double)ipd / 2 : 0;
        if (fabs(left - right - expected) > (apart ? 0.1 : 0)) fail_msg("disparity %g, expected %g", left - right, expected);
    }
    stage_close(&stage);
}

static void test_eyes_at_one_place_are_equal_VR_4(void **state) {
    UNUSED(state);
    struct stage stage = open_stage("builtin:glass", 40);
    fnl_camera eyes[2];
    place_eyes(&stage, 0, false, eyes);
    fnl_frame frame = frame_of(&stage, eyes);
    test_render_frame(stage.renderer, &frame);
    fnl_image all = test_read(stage.renderer, FNL_OUTPUT_RADIANCE);
    const size_t bytes = (size_t)WIDTH * HEIGHT * 16;
    assert_memory_equal(all.pixels, (const char *)all.pixels + bytes, bytes);
    free_picture(&all);
    stage_close(&stage);
}

/* Items of one group in several displays: draws begin behind those of other groups. */
static void test_instances_behind_others_VR_3(void **state) {
    UNUSED(state);
    fnl_scene *scene = test_scene();
    fnl_material_params material = fnl_material_params_default();
    for (uint32_t m = 0; m < 3; m++) {
        material.base_color[m] = 0.2f;
        const uint32_t mesh = test_quad_mesh(scene, test_material(scene, &material).index);
        for (uint32_t i = 0; i < 5; i++) test_place(scene, mesh, (vec3){(float)i - 2, (float)m - 1, -3 - (float)i}, (vec3){0.3f, 0.3f, 0.3f});
    }
    struct stage stage = stage_open_scene(scene);
    stage.frame.width = WIDTH;
    stage.frame.height = HEIGHT;
    stage.frame.camera.position = (vec3){0, 0, 2};
    stage.frame.camera.target = (vec3){0, 0, -1};
    stage.frame.outputs = FNL_OUTPUT_RADIANCE | FNL_OUTPUT_OBJECT;
    fnl_renderer *other = test_renderer(stage.scene);
    fnl_camera eyes[4];
    place_eyes(&stage, 0.3f, false, eyes);
    place_eyes(&stage, 0.1f, true, eyes + 2);
    fnl_frame frame = frame_of(&stage, eyes), alone;
    frame.view_count = 4;
    alone = frame;
    alone.stereo.eyes = 0;
    alone.multiview = FNL_MULTIVIEW_OFF;
    test_render_frame(other, &alone);
    fnl_image b = test_read(other, FNL_OUTPUT_RADIANCE);
    for (uint32_t w = 0; w < COUNT_OF(ways); w++) {
        frame.stereo.path = ways[w].path;
        test_render_frame(stage.renderer, &frame);
        fnl_image image = test_read(stage.renderer, FNL_OUTPUT_RADIANCE);
        assert_int_equal(count_differing(&image, &b), 0);
        free_picture(&image);
    }
    fnl_image a = test_read(stage.renderer, FNL_OUTPUT_OBJECT);
    uint32_t seen = 0;
    for (uint32_t i = 0; i < a.width * a.height; i++) {
        const uint32_t object = (uint32_t)((const float *)a.pixels)[4 * i];
        if (object) seen |= 1u << object;
    }
    assert_true(__builtin_popcount(seen) > 10);
    free_picture(&a);
    /* Exposure is measured once for each display, under its name. */
    static char plan[1 << 18];
    uint32_t of_displays[3] = {0};
    frame.exposure = FNL_EXPOSURE_AUTO;
    frame.outputs = FNL_OUTPUT_COLOR;
    test_render_frame(stage.renderer, &frame);
    assert_true(fnl_renderer_print(stage.renderer, FNL_PRINT_PLAN, plan, sizeof plan) < sizeof plan);
    for (const char *at = plan; (at = strstr(at, "'display ")); at += 9) {
        of_displays[MIN((uint32_t)(at[9] - '0'), 2u)]++;
        assert_memory_not_equal(at + 11, "view ", 5);
    }
    assert_true(of_displays[0] > 0 && of_displays[0] == of_displays[1] && of_displays[2] == 0);
    free_picture(&b);
    fnl_renderer_destroy(&other);
    stage_close(&stage);
}

static void test_eyes_are_checked(void **state) {
    UNUSED(state);
    struct stage stage = open_stage("builtin:onetile", 0);
    fnl_camera eyes[2];
    place_eyes(&stage, 0.064f, false, eyes);
    fnl_frame frame = frame_of(&stage, eyes);
    for (uint32_t eye_count = 1; eye_count < 5; eye_count++) {
        frame.stereo.eyes = eye_count;
        assert_int_equal(fnl_renderer_render(stage.renderer, &frame), eye_count == 2 ? FNL_OK : FNL_ERROR_INVALID);
    }
    frame.stereo.eyes = 2;
    frame.view_count = 1;
    assert_int_equal(fnl_renderer_render(stage.renderer, &frame), FNL_ERROR_INVALID);
    frame.view_count = 2;
    frame.stereo.margin = 21;
    assert_int_equal(fnl_renderer_render(stage.renderer, &frame), FNL_ERROR_INVALID);
    frame.stereo.margin = 0;
    frame.multiview = FNL_MULTIVIEW_OFF; /* stereo.path says it */
    assert_int_equal(fnl_renderer_render(stage.renderer, &frame), FNL_ERROR_INVALID);
    frame.multiview = FNL_MULTIVIEW_AUTO;
    frame.stereo.path = FNL_STEREO_PATH_COUNT;
    assert_int_equal(fnl_renderer_render(stage.renderer, &frame), FNL_ERROR_INVALID);
    stage_close(&stage);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_common_frustum_holds_what_eyes_see_VR_5),
        cmocka_unit_test(test_common_frustum_is_tight),
        cmocka_unit_test(test_late_poses_within_the_margin_VR_6),
        cmocka_unit_test(test_eyes_that_look_apart_have_none),
        cmocka_unit_test_teardown(test_eyes_equal_each_alone_VR_1, harness_check),
        cmocka_unit_test_teardown(test_ways_to_draw_equal_each_alone_VR_1, harness_check),
        cmocka_unit_test_teardown(test_histories_and_shadows_VR_1, harness_check),
        cmocka_unit_test_teardown(test_shared_work_VR_1_VR_2, harness_check),
        cmocka_unit_test_teardown(test_ways_to_draw_are_counted_VR_2, spy_tear_down),
        cmocka_unit_test_teardown(test_eyes_draw_what_either_sees_VR_1_VR_2, harness_check),
        cmocka_unit_test_teardown(test_one_exposure, harness_check),
        cmocka_unit_test_teardown(test_disparity_of_a_known_box_VR_4, harness_check),
        cmocka_unit_test_teardown(test_eyes_at_one_place_are_equal_VR_4, harness_check),
        cmocka_unit_test_teardown(test_instances_behind_others_VR_3, harness_check),
        cmocka_unit_test_teardown(test_eyes_are_checked, harness_check),
    };
    return cmocka_run_group_tests_name("stereo", tests, test_group_begin, test_group_end);
}
