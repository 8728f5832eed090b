/* SPDX-License-Identifier: MIT */
/**
 * Whole scenes by the visibility buffer against forward shading. Textures are filtered without anisotropy, as drivers place its samples in
 * their own ways. Attributes are equal to a few units in the last place, no more: a sharp highlight or a texel's border makes that show here and
 * there, so one pixel of 500 may be off by more than 2/255, and the whole by 58 dB.
 */
#include "tests/render_harness.h"

struct scene_case {
    const char *source;
    uint32_t scattered;
    float ev;
    double time; /* of the first animation; below 0: at rest */
};

static void test_scene(void **state) {
    const struct scene_case *c = *state;
    struct stage stage = stage_open(c->source, c->scattered);
    assert_int_equal(fnl_scene_set_anisotropy(stage.scene, 1), FNL_OK);
    if (c->time >= 0) assert_int_equal(fnl_scene_set_time(stage.scene, 0, c->time), FNL_OK);
    stage.frame.ev = c->ev;
    stage.frame.lists = FNL_LISTS_CLUSTERED;
    stage.frame.count_lights = true;
    fnl_frame frame = stage.frame;
    frame.shading = FNL_SHADING_FORWARD_PREPASS;
    struct shot forward = stage_shoot(&stage, &frame);
    frame.shading = FNL_SHADING_VISIBILITY;
    struct shot visibility = stage_shoot(&stage, &frame);
    assert_int_equal(count_broken(&visibility.radiance), 0);
    fnl_image_difference difference;
    assert_int_equal(fnl_image_compare(NULL, &forward.color, &visibility.color, &difference), FNL_OK);
    uint64_t beyond = count_beyond(&forward.color, &visibility.color, 2);
    print_message("%s: %.1f dB, %llu pixels beyond 2/255, %d/255 at most\n", c->source, difference.psnr,
                  (unsigned long long)beyond, greatest_difference(&forward.color, &visibility.color));
    assert_true(beyond * 500 <= frame.width * frame.height);
    assert_true(difference.psnr >= 58);
    shot_free(&forward);
    shot_free(&visibility);
    stage_close(&stage);
}

int main(void) {
    static struct scene_case cases[] = {{"FlightHelmet/FlightHelmet.gltf", 40, 5, -1},
                                        {"DamagedHelmet.glb", 40, 5, -1},
                                        {"Fox.glb", 40, 5, 0.4},
                                        {"CesiumMan.glb", 40, 5, 0.7},
                                        {"builtin:hall?lights=64", 0, 5, -1},
                                        {"builtin:interior?lights=40", 0, 5, -1},
                                        {"builtin:city?lights=64&instances=100000", 0, 1, -1},
                                        {"builtin:grass?lights=24", 0, 5, -1},
                                        {"builtin:glass?lights=24", 0, 5, -1}};
    struct CMUnitTest tests[COUNT_OF(cases)];
    char names[COUNT_OF(cases)][96];
    for (uint32_t i = 0; i < COUNT_OF(cases); i++) {
        snprintf(names[i], sizeof names[i], "ES-73: %s as in forward shading", cases[i].source);
        tests[i] = (struct CMUnitTest){names[i], test_scene, NULL, harness_check, &cases[i]};
    }
    return cmocka_run_group_tests(tests, harness_begin, harness_end);
}
