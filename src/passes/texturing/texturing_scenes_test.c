/* SPDX-License-Identifier: MIT */
/**
 * Whole scenes by deferred texturing against forward shading. Textures are filtered without anisotropy, as drivers place its samples in
 * their own ways. Normals are rounded to 32 bits: highlights show that here and there, so one pixel of 500 may be off by more than 2/255, and
 * the whole by 58 dB. Derived gradients are approximate: each scene says what it reaches.
 */
#include "tests/render_harness.h"

struct scene_case {
    const char *source;
    uint32_t scattered;
    float ev;
    double time; /* of the first animation; below 0: at rest */
    double derived_psnr, virtual_psnr;
};

static double compare(const struct scene_case *c, const char *what, const struct shot *forward, const struct shot *shot,
                      uint64_t *beyond) {
    assert_int_equal(count_broken(&shot->radiance), 0);
    fnl_image_difference difference;
    assert_int_equal(fnl_image_compare(NULL, &forward->color, &shot->color, &difference), FNL_OK);
    *beyond = count_beyond(&forward->color, &shot->color, 2);
    print_message("%s, %s: %.1f dB, %llu pixels beyond 2/255, %d/255 at most\n", c->source, what, difference.psnr,
                  (unsigned long long)*beyond, greatest_difference(&forward->color, &shot->color));
    return difference.psnr;
}

static void test_scene(void **state) {
    const struct scene_case *c = *state;
    struct stage stage = stage_open(c->source, c->scattered);
    assert_int_equal(fnl_scene_set_anisotropy(stage.scene, 1), FNL_OK);
    if (c->time >= 0) assert_int_equal(fnl_scene_set_time(stage.scene, 0, c->time), FNL_OK);
    stage.frame.width = 161; /* the decibels below are of this size */
    stage.frame.height = 91;
    stage.frame.ev = c->ev;
    stage.frame.lists = FNL_LISTS_CLUSTERED;
    stage.frame.count_lights = true;
    fnl_frame frame = stage.frame;
    frame.shading = FNL_SHADING_FORWARD_PREPASS;
    struct shot forward = stage_shoot(&stage, &frame);
    frame.shading = FNL_SHADING_TEXTURING;
    struct shot stored = stage_shoot(&stage, &frame);
    uint64_t beyond;
    double psnr = compare(c, "stored", &forward, &stored, &beyond);
    assert_true(beyond * 500 <= frame.width * frame.height);
    assert_true(psnr >= 58);
    frame.gbuffer.prepass = true;
    struct shot prepass = stage_shoot(&stage, &frame);
    assert_int_equal(count_differing(&stored.radiance, &prepass.radiance), 0);
    frame.gbuffer.prepass = false;
    frame.texturing.gradients = FNL_GRADIENTS_DERIVED;
    struct shot derived = stage_shoot(&stage, &frame);
    assert_true(compare(c, "derived", &forward, &derived, &beyond) >= c->derived_psnr);
    frame.texturing.gradients = FNL_GRADIENTS_STORED;
    frame.shading = FNL_SHADING_VIRTUAL_TEXTURING;
    struct shot paged = stage_shoot(&stage, &frame), again = stage_shoot(&stage, &frame);
    assert_true(compare(c, "virtual", &forward, &paged, &beyond) >= c->virtual_psnr);
    assert_int_equal(count_differing(&paged.radiance, &again.radiance), 0);
    assert_int_equal(counter(&paged.stats, "atlas.missing"), 0);
    print_message("  %u of %u pages, %u items forward\n", (uint32_t)counter(&paged.stats, "atlas.resident"),
                  (uint32_t)counter(&paged.stats, "atlas.pages"), (uint32_t)counter(&paged.stats, "gbuffer.items-forward"));
    shot_free(&paged);
    shot_free(&again);
    assert_true(counter(&derived.stats, "gbuffer.bytes") < counter(&stored.stats, "gbuffer.bytes"));
    shot_free(&forward);
    shot_free(&stored);
    shot_free(&prepass);
    shot_free(&derived);
    stage_close(&stage);
}

int main(void) {
    static struct scene_case cases[] = {{"FlightHelmet/FlightHelmet.gltf", 40, 5, -1, 44, 30},
                                        {"DamagedHelmet.glb", 40, 5, -1, 36, 30},
                                        {"Fox.glb", 40, 5, 0.4, 46, 30},
                                        {"builtin:hall?lights=64", 0, 5, -1, 50, 30},
                                        {"builtin:city?lights=64&instances=1000", 0, 1, -1, 34, 30},
                                        {"builtin:grass?lights=24", 0, 5, -1, 54, 30},
                                        {"builtin:glass?lights=24", 0, 5, -1, 54, 30}};
    struct CMUnitTest tests[COUNT_OF(cases)];
    char names[COUNT_OF(cases)][96];
    for (uint32_t i = 0; i < COUNT_OF(cases); i++) {
        snprintf(names[i], sizeof names[i], "ES-76, ES-70: %s as in forward shading", cases[i].source);
        tests[i] = (struct CMUnitTest){names[i], test_scene, NULL, harness_check, &cases[i]};
    }
    return cmocka_run_group_tests(tests, harness_begin, harness_end);
}
