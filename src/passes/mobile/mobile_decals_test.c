/* SPDX-License-Identifier: MIT */
/** Decals in a step of the scope of the order mobile. */
#include "passes/mobile/mobile_cases.h"

/* ---- decals ---- */

/* A box on the wall, or before it. */
static void add_decal(struct stage *stage, vec3 at, vec3 size, fnl_decal_params params) {
    fnl_decal_id id;
    params.transform = mat4_from_trs(at, quat_axis_angle((vec3){0, 0, 1}, at.x), size);
    assert_int_equal(fnl_scene_add_decal(stage->scene, &params, &id), FNL_OK);
}

static const vec3 on_wall = {0, 6, -20};

/*
 * The step after geometry rewrites what the targets hold. Each channel, each blend mode: as where surfaces look decals up while they are
 * drawn, to what the targets' bits round; nothing beside the box; nothing where the surface is behind it; and as in separate passes.
 */
static void check_decal(struct stage *stage, const struct shot *off, fnl_mobile_layout layout, const char *what,
                        bool changes) {
    fnl_frame frame = mobile_frame(stage);
    frame.ev = 3;
    frame.mobile.layout = layout;
    frame.decals = FNL_DECALS_LISTS;
    struct shot lists = stage_shoot(stage, &frame);
    frame.decals = FNL_DECALS_GBUFFER;
    struct shot step = stage_shoot(stage, &frame), again = stage_shoot(stage, &frame);
    assert_true(step.stats.mobile_merged && step.stats.mobile_tonemapped);
    assert_true(step.stats.image_bytes_read == 0);
    frame.mobile.separate = true;
    struct shot separate = stage_shoot(stage, &frame);
    assert_same(&step.color, &again.color, what);
    assert_same(&step.color, &separate.color, what);
    const uint8_t *p = step.color.pixels, *q = off->color.pixels, *l = lists.color.pixels;
    uint64_t changed = 0, stray = 0;
    for (size_t i = 0; i < (size_t)frame.width * frame.height * 4; i += 4) {
        changed += memcmp(p + i, q + i, 4) != 0;
        for (int c = 0; c < 3; c++) stray += l[i + c] == q[i + c] && abs(p[i + c] - q[i + c]) > 2;
    }
    int most = greatest_difference(&step.color, &lists.color);
    if (changes != (changed > 200) || (!changes && changed) || stray || most > 4)
        fail_msg("%s, %s: %llu pixels change, %llu of them only here; %d/255 from lists", what,
                 fnl_mobile_layout_name(layout), (unsigned long long)changed, (unsigned long long)stray, most);
    shot_free(&lists);
    shot_free(&step);
    shot_free(&again);
    shot_free(&separate);
}

static void test_decals_rewrite_the_targets_MB_12(void **state) {
    UNUSED(state);
    static const struct {
        const char *what;
        uint32_t channels;
        fnl_decal_blend blend;
        float z;
        bool changes;
    } cases[] = {{"colour", FNL_DECAL_COLOR, FNL_DECAL_BLEND_ALPHA, -20, true},
                 {"multiply", FNL_DECAL_COLOR, FNL_DECAL_BLEND_MULTIPLY, -20, true},
                 {"add", FNL_DECAL_COLOR, FNL_DECAL_BLEND_ADD, -20, true},
                 {"overlay", FNL_DECAL_COLOR, FNL_DECAL_BLEND_OVERLAY, -20, true},
                 {"roughness", FNL_DECAL_ROUGHNESS, FNL_DECAL_BLEND_ALPHA, -20, true},
                 {"metalness", FNL_DECAL_METALLIC, FNL_DECAL_BLEND_ALPHA, -20, true},
                 {"glow", FNL_DECAL_EMISSION, FNL_DECAL_BLEND_ALPHA, -20, true},
                 {"flat normals", FNL_DECAL_NORMAL, FNL_DECAL_BLEND_ALPHA, -20, false}, /* no map: none is changed */
                 {"before the wall", FNL_DECAL_ALL, FNL_DECAL_BLEND_ALPHA, -17, false}};
    for (uint32_t i = 0; i < COUNT_OF(cases); i++) {
        struct stage stage = stage_open("builtin:wall?lights=12", 0);
        fnl_mobile_layout layout = (fnl_mobile_layout)(i % FNL_MOBILE_LAYOUT_COUNT);
        fnl_frame frame = mobile_frame(&stage);
        frame.ev = 3;
        frame.mobile.layout = layout;
        struct shot off = stage_shoot(&stage, &frame);
        fnl_decal_params params = fnl_decal_params_default();
        params.channels = cases[i].channels;
        params.blend = cases[i].blend;
        memcpy(params.color, (float[]){0.9f, 0.2f, 0.4f, 0.8f}, sizeof params.color);
        memcpy(params.emissive, (float[]){0.5f, 1, 2}, sizeof params.emissive);
        params.metallic = 1;
        params.roughness = 0.15f;
        vec3 at = on_wall;
        at.z = cases[i].z;
        add_decal(&stage, at, (vec3){16, 10, 2}, params);
        check_decal(&stage, &off, layout, cases[i].what, cases[i].changes);
        shot_free(&off);
        stage_close(&stage);
    }
}

static void test_many_decals_over_one_another_MB_12(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:wall?lights=12", 0);
    fnl_frame frame = mobile_frame(&stage);
    frame.ev = 3;
    struct shot off = stage_shoot(&stage, &frame);
    struct random_state random = {4};
    for (int i = 0; i < 120; i++) {
        fnl_decal_params params = fnl_decal_params_default();
        params.blend = (fnl_decal_blend)(i % FNL_DECAL_BLEND_COUNT);
        for (int c = 0; c < 4; c++) params.color[c] = random_float(&random);
        vec3 at = {random_range(&random, -9, 9), random_range(&random, 1, 11), -20};
        add_decal(&stage, at, (vec3){random_range(&random, 4, 14), random_range(&random, 4, 14), 1}, params);
    }
    for (int layout = 0; layout < FNL_MOBILE_LAYOUT_COUNT; layout++) {
        frame.mobile.layout = (fnl_mobile_layout)layout;
        check_decal(&stage, &off, (fnl_mobile_layout)layout, "120 decals", true);
    }
    /* One that is not for everything: surfaces look decals up as they are drawn, for the targets do not know what receives them. */
    fnl_decal_params params = fnl_decal_params_default();
    params.receivers = 2;
    add_decal(&stage, on_wall, (vec3){4, 4, 2}, params);
    frame.decals = FNL_DECALS_GBUFFER;
    struct shot step = stage_shoot(&stage, &frame);
    frame.decals = FNL_DECALS_LISTS;
    struct shot lists = stage_shoot(&stage, &frame);
    assert_same(&step.color, &lists.color, "masks");
    shot_free(&step);
    shot_free(&lists);
    shot_free(&off);
    stage_close(&stage);
}

int main(int count, char **arguments) {
    if (count > 1) cmocka_set_test_filter(arguments[1]);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_decals_rewrite_the_targets_MB_12, harness_check),
        cmocka_unit_test_teardown(test_many_decals_over_one_another_MB_12, harness_check),
    };
    return cmocka_run_group_tests(tests, harness_begin, harness_end);
}
