/* SPDX-License-Identifier: MIT */
/** Each pass of a frame is told apart by what it is for, whatever the path. */
#include "fanal/values.h"
#include "graph/graph_internal.h"
#include "render/traits.h"
#include "tests/render_harness.h"

/* By what names begin with, after their scopes; the first that fits. */
static const struct {
    const char *begin;
    fnl_pass_role role;
} known[] = {
    {"cull", FNL_PASS_GEOMETRY},         {"sort ", FNL_PASS_GEOMETRY},
    {"gbuffer", FNL_PASS_GEOMETRY},      {"depth prepass", FNL_PASS_GEOMETRY}, {"light surfaces", FNL_PASS_GEOMETRY},
    {"inferred surfaces", FNL_PASS_GEOMETRY}, {"visibility shade", FNL_PASS_SHADING}, {"visibility", FNL_PASS_GEOMETRY},
    {"dais sha", FNL_PASS_SHADING},      {"texturing sh", FNL_PASS_SHADING},  {"forward", FNL_PASS_SHADING},
    {"deferred", FNL_PASS_SHADING},      {"coarse shade", FNL_PASS_SHADING},  {"light materials", FNL_PASS_SHADING},
    {"mobile", FNL_PASS_SHADING},        {"clustered", FNL_PASS_LISTS},       {"tiled", FNL_PASS_LISTS},
    {"shadow requests", FNL_PASS_SHADOWS}, {"shadow fill", FNL_PASS_SHADOWS}, {"shadow split", FNL_PASS_SHADOWS},
    {"tonemap", FNL_PASS_REST},          {"sky", FNL_PASS_SHADING},           {"exposure", FNL_PASS_REST},
    {"read ", FNL_PASS_READ},            {"to host", FNL_PASS_READ},          {"counts", FNL_PASS_READ}};

static void check_pass(const struct graph_pass *pass, const char *what, uint32_t seen[FNL_PASS_ROLE_COUNT]) {
    const char *scopes = strrchr(pass->name, '/'), *name = scopes ? scopes + 1 : pass->name;
    const fnl_pass_role role = graph_pass_role(pass->role);
    seen[role]++;
    if (strstr(pass->name, "shadows/")) { /* its lists, too */
        assert_int_equal(role, FNL_PASS_SHADOWS);
        return;
    }
    if (strstr(pass->name, "fallback/")) return; /* of what asks for it */
    for (uint32_t i = 0; i < COUNT_OF(known); i++) {
        if (strncmp(name, known[i].begin, strlen(known[i].begin)) != 0) continue;
        if (role != known[i].role)
            fail_msg("%s: '%s' is of %s, not of %s", what, pass->name, fnl_value_name(FNL_ENUM_PASS_ROLE, (uint32_t)role), fnl_value_name(FNL_ENUM_PASS_ROLE, (uint32_t)known[i].role));
        return;
    }
}

static void test_paths(void **state) {
    struct stage stage = stage_open(*state, 0);
    for (int shading = 0; shading < FNL_SHADING_AUTO; shading++)
        for (uint32_t eyes = 0; eyes <= 2; eyes += 2) {
            fnl_frame frame = stage.frame;
            uint32_t seen[FNL_PASS_ROLE_COUNT] = {0};
            const fnl_camera cameras[] = {frame.camera, frame.camera};
            frame.width = frame.height = 32;
            frame.shading = (fnl_shading)shading;
            frame.shadows = FNL_SHADOWS_HYBRID;
            frame.shadow.page_rays = 100;
            frame.lists = fnl_shading_supports(frame.shading, FNL_LISTS_TILED, 1) ? FNL_LISTS_TILED : FNL_LISTS_CLUSTERED;
            frame.views = eyes ? cameras : NULL;
            frame.view_count = frame.stereo.eyes = eyes;
            if (!fnl_shading_supports(frame.shading, frame.lists, 1) || (eyes && !shading_is(frame.shading, SHADING_VIEWS))) continue;
            struct shot shot = stage_shoot(&stage, &frame);
            const struct graph *graph = stage.renderer->graph;
            for (uint32_t i = 0; i < graph->plan.step_count; i++) check_pass(graph->plan.steps[i].pass, fnl_value_name(FNL_ENUM_SHADING, (uint32_t)shading), seen);
            for (uint32_t role = 0; role < FNL_PASS_ROLE_COUNT; role++)
                if (seen[role] == 0) fail_msg("%s, %u eyes: no pass is of %s", fnl_value_name(FNL_ENUM_SHADING, (uint32_t)shading), eyes, fnl_value_name(FNL_ENUM_PASS_ROLE, role));
            shot_free(&shot);
        }
    stage_close(&stage);
}

/* Shadows ask for clusters of blended surfaces, the frame for its own, glass for those of all depths: they are the same. */
static void test_clusters_are_made_once(void **state) {
    UNUSED(state);
    struct stage s = stage_open("builtin:glass?lights=9", 0);
    fnl_entity_info entity;
    fnl_material_params glass;
    assert_int_equal(fnl_scene_query_entity(s.scene, FNL_ENTITY_MATERIAL, 0, &entity), FNL_OK);
    assert_int_equal(fnl_scene_query_material(s.scene, 0, &glass), FNL_OK);
    s.frame.shading = FNL_SHADING_DEFERRED;
    s.frame.lists = FNL_LISTS_CLUSTERED;
    for (int i = 0; i < 4; i++) {
        glass.transmission.strength = i & 1 ? 1 : 0;
        assert_int_equal(fnl_scene_set_material(s.scene, entity.id.material, &glass), FNL_OK);
        s.frame.shadows = i & 2 ? FNL_SHADOWS_MAPS : FNL_SHADOWS_OFF;
        struct shot shot = stage_shoot(&s, &s.frame);
        const struct graph *graph = s.renderer->graph;
        uint32_t made = 0, glasses = 0;
        for (uint32_t k = 0; k < graph->plan.step_count; k++) {
            made += strstr(graph->plan.steps[k].pass->name, "clustered fill") != NULL;
            glasses += strstr(graph->plan.steps[k].pass->name, "transmission") != NULL;
        }
        assert_int_equal(made, 1);
        assert_int_equal(glasses > 0, i & 1);
        shot_free(&shot);
    }
    stage_close(&s);
}

int main(void) {
    const struct CMUnitTest tests[] = {{"passes of all paths", test_paths, NULL, harness_check, "builtin:glass?lights=9"},
                                       cmocka_unit_test_teardown(test_clusters_are_made_once, harness_check)};
    return cmocka_run_group_tests_name("pass_roles", tests, harness_begin, harness_end);
}
