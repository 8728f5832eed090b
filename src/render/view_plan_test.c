/* SPDX-License-Identifier: MIT */
/** Which views go together. Needs no device. */
#include "render/view_plan.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static fnl_camera cameras[FNL_VIEWS_MAX];

/* Cameras in a row, so far apart, that look along -Z; and a scene of 20 m. */
static struct view_plan_input input_of(fnl_frame *frame, uint32_t count, float apart) {
    for (uint32_t i = 0; i < FNL_VIEWS_MAX; i++) {
        cameras[i] = fnl_camera_default();
        cameras[i].position = (fnl_vec3){apart * (float)i, 0, 5};
        cameras[i].target = (fnl_vec3){apart * (float)i, 0, 0};
    }
    *frame = fnl_frame_default();
    frame->width = 64;
    frame->height = 48;
    frame->shading = FNL_SHADING_DEFERRED;
    frame->lists = FNL_LISTS_CLUSTERED;
    frame->occlusion = FNL_OCCLUSION_OFF;
    frame->msaa = 1;
    frame->views = count ? cameras : NULL;
    frame->view_count = count;
    return (struct view_plan_input){.frame = frame, .multiview = true, .vertex_layers = true, .bounds = {{-10, 0, 0}, {10, 0, 0}}};
}

/* The groups as text: "0-2x3 …": views 0 to 2, drawn three at once; d: a display, f: with a view of what is far away. */
static void expect(const struct view_plan_input *input, const char *wanted) {
    struct view_plan plan;
    char text[1024];
    size_t used = 0;
    memset(&plan, 0xff, sizeof plan);
    view_plan_make(input, &plan);
    for (uint32_t i = 0; i < plan.group_count; i++) {
        const struct view_group *g = &plan.groups[i];
        used += (size_t)snprintf(text + used, sizeof text - used, "%s%u-%ux%u%s%s", i ? " " : "", g->first, g->first + g->count - 1, g->together, g->is_display ? "d" : "", g->has_far ? "f" : "");
    }
    if (strcmp(text, wanted) != 0) fail_msg("the plan is '%s', not '%s'", text, wanted);
    assert_int_equal(plan.camera_count, frame_view_count(input->frame) + frame_far_count(input->frame));
}

static void test_views_that_see_the_same_are_drawn_at_once(void **state) {
    UNUSED(state);
    fnl_frame frame;
    struct view_plan_input in = input_of(&frame, 0, 0.1f);
    expect(&in, "0-0x1");
    in = input_of(&frame, 8, 0.1f); /* 20 / 32 = 0.625 m apart at most */
    expect(&in, "0-5x6 6-7x2");
    in = input_of(&frame, 5, 0.3f);
    expect(&in, "0-2x3 3-4x2");
    in = input_of(&frame, 3, 0.7f);
    expect(&in, "0-0x1 1-1x1 2-2x1");
    frame.multiview = FNL_MULTIVIEW_ON;
    expect(&in, "0-2x3");
    frame.multiview = FNL_MULTIVIEW_OFF;
    expect(&in, "0-0x1 1-1x1 2-2x1");
    in = input_of(&frame, 3, 0.1f);
    cameras[1].target.x += 1; /* 11 degrees */
    expect(&in, "0-0x1 1-1x1 2-2x1");
    in = input_of(&frame, 3, 0.1f);
    cameras[2].target.x += 0.8f; /* 9 degrees */
    expect(&in, "0-2x3");
    static const size_t members[] = {offsetof(fnl_camera, vertical_fov), offsetof(fnl_camera, vertical_extent), offsetof(fnl_camera, pixel_aspect)};
    for (uint32_t i = 0; i < COUNT_OF(members); i++) {
        in = input_of(&frame, 2, 0.1f);
        *(float *)((char *)&cameras[1] + members[i]) *= 1.01f;
        expect(&in, "0-0x1 1-1x1");
    }
    in = input_of(&frame, 2, 0.1f);
    cameras[1].orthographic = true;
    expect(&in, "0-0x1 1-1x1");
    in = input_of(&frame, 2, 0.1f);
    in.bounds = (struct box){{1, 1, 1}, {0, 0, 0}}; /* an empty scene */
    expect(&in, "0-0x1 1-1x1");
}

static void test_what_keeps_views_apart(void **state) {
    UNUSED(state);
    for (int eyes = 0; eyes < 2; eyes++) {
        fnl_frame frame;
        const char *const apart = eyes ? "0-1x1d" : "0-0x1 1-1x1", *const together = eyes ? "0-1x2d" : "0-1x2";
        struct view_plan_input in;
#define NEXT in = input_of(&frame, 2, 0.06f), frame.stereo.eyes = eyes ? 2 : 0
        NEXT;
        expect(&in, together);
        NEXT, in.multiview = false;
        expect(&in, apart);
        NEXT, frame.culling = FNL_CULLING_TRIANGLES;
        expect(&in, apart);
        NEXT, frame.occlusion = FNL_OCCLUSION_ON; /* eyes draw the union */
        expect(&in, eyes ? together : apart);
        NEXT, in.has_decals = true, frame.decals = FNL_DECALS_GBUFFER;
        expect(&in, apart);
        NEXT, in.has_decals = true, frame.decals = FNL_DECALS_OFF;
        expect(&in, together);
        NEXT, frame.shading = FNL_SHADING_FORWARD; /* draws after its lists */
        expect(&in, apart);
        NEXT, frame.shading = FNL_SHADING_FORWARD_PREPASS; /* only its prepass could be shared */
        expect(&in, apart);
        NEXT, frame.shading = FNL_SHADING_FORWARD_PREPASS, frame.multiview = FNL_MULTIVIEW_ON, frame.stereo.path = FNL_STEREO_PATH_MULTIVIEW;
        expect(&in, together);
#undef NEXT
    }
}

static void test_eyes_are_displays(void **state) {
    UNUSED(state);
    fnl_frame frame;
    struct view_plan_input in = input_of(&frame, 6, 0.06f);
    frame.stereo.eyes = 2;
    expect(&in, "0-1x2d 2-3x2d 4-5x2d");
    frame.stereo.eyes = 3;
    expect(&in, "0-2x3d 3-5x3d");
    frame.stereo.path = FNL_STEREO_PATH_EYES;
    expect(&in, "0-2x1d 3-5x1d");
    static const struct {
        fnl_stereo_path asked;
        bool multiview, layers;
        fnl_stereo_path path;
    } rows[] = {{FNL_STEREO_PATH_AUTO, true, true, FNL_STEREO_PATH_MULTIVIEW},        {FNL_STEREO_PATH_AUTO, false, true, FNL_STEREO_PATH_EYES},
                {FNL_STEREO_PATH_OBJECTS, true, true, FNL_STEREO_PATH_OBJECTS},       {FNL_STEREO_PATH_OBJECTS, true, false, FNL_STEREO_PATH_MULTIVIEW},
                {FNL_STEREO_PATH_INSTANCES, false, true, FNL_STEREO_PATH_INSTANCES},  {FNL_STEREO_PATH_INSTANCES, false, false, FNL_STEREO_PATH_EYES},
                {FNL_STEREO_PATH_MULTIVIEW, false, true, FNL_STEREO_PATH_EYES},       {FNL_STEREO_PATH_EYES, true, true, FNL_STEREO_PATH_EYES}};
    for (uint32_t i = 0; i < COUNT_OF(rows); i++) {
        struct view_plan plan;
        in = input_of(&frame, 2, 0.06f);
        frame.stereo.eyes = 2;
        frame.stereo.path = rows[i].asked;
        in.multiview = rows[i].multiview;
        in.vertex_layers = rows[i].layers;
        view_plan_make(&in, &plan);
        assert_int_equal(plan.path, rows[i].path);
        assert_int_equal(plan.groups[0].path, rows[i].path);
        assert_int_equal(plan.groups[0].together, rows[i].path == FNL_STEREO_PATH_EYES ? 1 : 2);
    }
}

static void test_what_is_far_has_a_view_for_each_display(void **state) {
    UNUSED(state);
    fnl_frame frame;
    struct view_plan_input in = input_of(&frame, 4, 0.06f);
    frame.stereo.eyes = 2;
    frame.stereo.mono_distance = 10;
    expect(&in, "0-1x2df 2-3x2df");
    struct view_plan plan, again;
    view_plan_make(&in, &plan);
    view_plan_make(&in, &again);
    assert_memory_equal(&plan.groups[1].far_camera, &again.groups[1].far_camera, sizeof(fnl_camera));
    for (uint32_t i = 0; i < 2; i++) {
        const struct view_group *g = &plan.groups[i];
        assert_int_equal(g->far_index, 4 + i);
        assert_float_equal(g->far_camera.position.x, 0.06f * (2 * (float)i + 0.5f), 1e-5f);
        assert_true(g->far_camera.near_distance < 10 && g->far_camera.near_distance > 8);
        assert_true(g->far_width >= 64 && g->far_height >= 48);
    }
    cameras[0].target = (fnl_vec3){0, 0, 10}; /* the eyes of the first look apart: it has none, and its place stays */
    expect(&in, "0-1x2d 2-3x2df");
    view_plan_make(&in, &plan);
    assert_int_equal(plan.groups[1].far_index, 5);
    assert_int_equal(plan.camera_count, 6);
    frame.stereo.mono_distance = 0;
    expect(&in, "0-1x2d 2-3x2d");
}

static void test_frames_declared_for_their_pipelines(void **state) {
    UNUSED(state);
    fnl_frame frame;
    struct view_plan_input in = input_of(&frame, 0, 0);
    frame.stereo.eyes = 2;
    frame.stereo.mono_distance = 10;
    in.asked_together = 2;
    struct view_plan plan;
    view_plan_make(&in, &plan);
    expect(&in, "0-0x2");
    assert_int_equal(plan.groups[0].path, FNL_STEREO_PATH_MULTIVIEW);
    assert_int_equal(plan.camera_count, 1);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_views_that_see_the_same_are_drawn_at_once),
        cmocka_unit_test(test_what_keeps_views_apart),
        cmocka_unit_test(test_eyes_are_displays),
        cmocka_unit_test(test_what_is_far_has_a_view_for_each_display),
        cmocka_unit_test(test_frames_declared_for_their_pipelines),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
