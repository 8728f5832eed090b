/* SPDX-License-Identifier: MIT */
/** Decals in a step of the scope of the order mobile. */
#include "tests/mobile_cases.h"

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
    assert_true(counter(&step.stats, "mobile.merged") && counter(&step.stats, "mobile.tonemapped-inside"));
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
                 fnl_value_name(FNL_ENUM_MOBILE_LAYOUT, layout), (unsigned long long)changed, (unsigned long long)stray, most);
    shot_free(&lists);
    shot_free(&step);
    shot_free(&again);
    shot_free(&separate);
}

/* Its squares are several pixels wide: of coarser levels only their mean is left. */
static fnl_image_id chequered(fnl_scene *scene) {
    uint8_t texels[16 * 16 * 4];
    for (uint32_t i = 0; i < 16 * 16; i++) memset(texels + 4 * i, ((i >> 1) ^ (i >> 5)) & 1 ? 255 : 60, 4);
    for (uint32_t i = 0; i < 16 * 16; i++) texels[4 * i + 3] = 255;
    const fnl_image image = {16, 16, FNL_PIXEL_FORMAT_RGBA8, texels};
    fnl_image_id id;
    assert_int_equal(fnl_scene_add_image(scene, &image, true, &id), FNL_OK);
    return id;
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
                 {"picture", FNL_DECAL_COLOR, FNL_DECAL_BLEND_ALPHA, -20, true},
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
        if (strcmp(cases[i].what, "picture") == 0) params.color_image = chequered(stage.scene);
        vec3 at = on_wall;
        at.z = cases[i].z;
        add_decal(&stage, at, (vec3){16, 10, 2}, params);
        check_decal(&stage, &off, layout, cases[i].what, cases[i].changes);
        shot_free(&off);
        stage_close(&stage);
    }
}

/* ---- what is not touched ---- */

/* The targets of a frame: `bytes` of each, one after the other. free() it. */
static uint8_t *tap(struct stage *stage, const fnl_frame *frame, bool separate) {
    const uint64_t size = 8ull * 4 * frame->width * frame->height;
    struct gpu_buffer buffer;
    assert_int_equal(gpu_buffer_create(harness_device(), "mobile tap", size, GPU_MEMORY_READBACK, &buffer), FNL_OK);
    harness_hooks(stage->renderer)->mobile_tap = &buffer;
    fnl_frame tapped = *frame;
    tapped.mobile.separate = separate;
    struct shot shot = stage_shoot(stage, &tapped);
    harness_hooks(stage->renderer)->mobile_tap = NULL;
    uint8_t *copy = malloc(size);
    assert_non_null(copy);
    memcpy(copy, buffer.mapped, size);
    shot_free(&shot);
    assert_int_equal(gpu_wait_idle(harness_device()), FNL_OK);
    gpu_buffer_destroy(harness_device(), &buffer);
    return copy;
}

/* What a decal of some channels may write, as masks of the bytes of a target's pixel; light, which gains glow, is another matter. */
struct touched {
    uint32_t masks[8];
};

static struct touched touched_by(fnl_mobile_layout layout, uint32_t channels) {
    static const char *const color_targets[] = {"mobile color", "mobile diffuse", "mobile specular"};
    const bool metallic = layout == FNL_MOBILE_METALLIC_128 || layout == FNL_MOBILE_METALLIC_256;
    const bool color = channels & FNL_DECAL_COLOR, metal = channels & FNL_DECAL_METALLIC,
               rough = channels & FNL_DECAL_ROUGHNESS;
    struct touched t = {{0}};
    fnl_mobile_target targets[8];
    uint32_t count = fnl_mobile_layout_targets(layout, targets, 8);
    for (uint32_t i = 0; i < count; i++) {
        const char *name = targets[i].name;
        for (uint32_t k = 0; k < COUNT_OF(color_targets); k++)
            if (strcmp(name, color_targets[k]) == 0 && (color || (metal && !metallic))) t.masks[i] = 0xffffffu;
        if (layout >= FNL_MOBILE_METALLIC_256 && t.masks[i]) t.masks[i] = 0xffffffffu; /* packed floats */
        if (layout == FNL_MOBILE_METALLIC_128 && strcmp(name, "mobile color") == 0 && metal) t.masks[i] |= 0xff000000u;
        if (strcmp(name, "mobile normal") == 0 && layout < FNL_MOBILE_METALLIC_256 && rough) t.masks[i] = 0xff000000u;
        if (strcmp(name, "mobile roughness") == 0) t.masks[i] = (rough ? 0xffffu : 0) | (metal ? 0xffff0000u : 0);
        if (strcmp(name, "mobile light b, roughness") == 0 && rough) t.masks[i] = 0xffff0000u;
        /* Light holds ambient light and that of the lights, which everything changes. */
        if (strncmp(name, "mobile light", 12) == 0)
            t.masks[i] |= strcmp(name, "mobile light b, roughness") == 0 || strcmp(name, "mobile light b, normal x") == 0
                              ? 0xffffu
                              : 0xffffffffu;
    }
    return t;
}

/* A decal of one channel leaves every bit of the others at every pixel, merged and separate; and changes its own. */
static void test_untouched_channels_keep_their_bits_MB_12(void **state) {
    UNUSED(state);
    static const struct {
        const char *what;
        uint32_t channels;
    } cases[] = {{"colour", FNL_DECAL_COLOR},
                 {"roughness", FNL_DECAL_ROUGHNESS},
                 {"metalness", FNL_DECAL_METALLIC},
                 {"glow", FNL_DECAL_EMISSION}};
    for (int layout = 0; layout < FNL_MOBILE_LAYOUT_COUNT; layout++)
        for (uint32_t i = 0; i < COUNT_OF(cases); i++) {
            struct stage stage = stage_open("builtin:spheres?lights=5", 0); /* normals and materials of all kinds */
            fnl_frame frame = mobile_frame(&stage);
            frame.width = 67;
            frame.height = 39;
            frame.mobile.layout = (fnl_mobile_layout)layout;
            frame.mobile.gamma = (fnl_mobile_gamma)(i % FNL_MOBILE_GAMMA_COUNT);
            frame.decals = FNL_DECALS_GBUFFER;
            uint8_t *before = tap(&stage, &frame, false);
            fnl_decal_params params = fnl_decal_params_default();
            params.channels = cases[i].channels;
            memcpy(params.color, (float[]){0.9f, 0.2f, 0.4f, 0.8f}, sizeof params.color);
            memcpy(params.emissive, (float[]){0.5f, 1, 2}, sizeof params.emissive);
            params.metallic = 0.7f;
            params.roughness = 0.15f;
            add_decal(&stage, (vec3){0, 1, 0}, (vec3){30, 30, 30}, params);
            struct touched touched = touched_by((fnl_mobile_layout)layout, cases[i].channels);
            fnl_mobile_target targets[8];
            uint32_t count = fnl_mobile_layout_targets((fnl_mobile_layout)layout, targets, 8);
            const size_t pixels = (size_t)frame.width * frame.height;
            for (int separate = 0; separate < 2; separate++) {
                uint8_t *after = tap(&stage, &frame, separate);
                for (uint32_t t = 0; t < count; t++) {
                    const uint32_t *a = (const uint32_t *)before + t * pixels, *b = (const uint32_t *)after + t * pixels;
                    uint64_t changed = 0, stray = 0;
                    for (size_t p = 0; p < pixels; p++) {
                        changed += a[p] != b[p];
                        stray += ((a[p] ^ b[p]) & ~touched.masks[t]) != 0;
                    }
                    bool same = cases[i].channels == FNL_DECAL_COLOR && strcmp(targets[t].name, "mobile specular") == 0;
                    if (stray || (touched.masks[t] && !same && changed < 50)) /* dielectrics of all colours reflect alike */
                        fail_msg("%s in %s, %s: %llu pixels of '%s' change, %llu of them in other channels", cases[i].what,
                                 fnl_value_name(FNL_ENUM_MOBILE_LAYOUT, (fnl_mobile_layout)layout), separate ? "separate" : "merged",
                                 (unsigned long long)changed, targets[t].name, (unsigned long long)stray);
                }
                free(after);
            }
            free(before);
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

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_decals_rewrite_the_targets_MB_12, harness_check),
        cmocka_unit_test_teardown(test_untouched_channels_keep_their_bits_MB_12, harness_check),
        cmocka_unit_test_teardown(test_many_decals_over_one_another_MB_12, harness_check),
    };
    return cmocka_run_group_tests(tests, harness_begin, harness_end);
}
