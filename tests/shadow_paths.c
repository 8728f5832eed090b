/* SPDX-License-Identifier: MIT */
#include "tests/shadow_paths.h"

static const char *const source = "builtin:interior?lights=40&sun=5"; /* all shapes of lights, and a sun */

void expect_lists_alike(fnl_shadows shadows) {
    const fnl_frame usual = fnl_frame_default();
    expect_lists_alike_with(shadows, &usual.shadow);
}

void expect_paths_alike(fnl_shadows shadows, uint32_t msaa) {
    const fnl_frame usual = fnl_frame_default();
    expect_paths_alike_with(shadows, &usual.shadow, msaa);
}

void expect_lists_alike_with(fnl_shadows shadows, const fnl_shadow_options *settings) {
    static const fnl_light_lists lists[] = {FNL_LISTS_TILED, FNL_LISTS_FINE, FNL_LISTS_ZBIN, FNL_LISTS_BVH};
    struct stage s = stage_open(source, 0);
    s.frame.shadows = shadows;
    s.frame.shadow = *settings;
    s.frame.lists = FNL_LISTS_ALL;
    struct shot all = stage_shoot(&s, &s.frame);
    for (uint32_t i = 0; i < COUNT_OF(lists); i++) {
        s.frame.lists = lists[i];
        struct shot shot = stage_shoot(&s, &s.frame);
        if (count_differing(&all.radiance, &shot.radiance)) fail_msg("%s", fnl_value_name(FNL_ENUM_LISTS, lists[i]));
        shot_free(&shot);
    }
    shot_free(&all);
    stage_close(&s);
}

void expect_paths_alike_with(fnl_shadows shadows, const fnl_shadow_options *settings, uint32_t msaa) {
    struct stage s = stage_open(source, 0);
    s.frame.width = 64, s.frame.height = 36, s.frame.ev = 1;
    s.frame.msaa = msaa;
    s.frame.shadow = *settings;
    struct shot forward[2];
    for (int k = 0; k < 2; k++) {
        s.frame.shading = FNL_SHADING_FORWARD;
        s.frame.shadows = k ? shadows : FNL_SHADOWS_OFF;
        forward[k] = stage_shoot(&s, &s.frame);
    }
    assert_true(count_beyond(&forward[0].color, &forward[1].color, 8) > 500);
    for (fnl_shading shading = FNL_SHADING_FORWARD + 1; shading < FNL_SHADING_AUTO; shading++) {
        if (msaa > 1 && shading != FNL_SHADING_DEFERRED && shading != FNL_SHADING_VISIBILITY) continue;
        double psnr[2];
        for (int k = 0; k < 2; k++) {
            s.frame.shading = shading;
            s.frame.shadows = k ? shadows : FNL_SHADOWS_OFF;
            struct shot shot = stage_shoot(&s, &s.frame);
            fnl_image_difference difference;
            assert_int_equal(fnl_image_compare(NULL, &forward[k].color, &shot.color, &difference), FNL_OK);
            psnr[k] = fmin(difference.psnr, 60);
            shot_free(&shot);
        }
        /* Paths shade a pixel with samples at different points of it, on both sides of a shadow's edge. */
        if (psnr[1] < psnr[0] - (msaa > 1 ? 6 : 4) || psnr[1] < 24)
            fail_msg("%s, %u samples: %.1f dB with shadows, %.1f without", fnl_value_name(FNL_ENUM_SHADING, shading), msaa, psnr[1], psnr[0]);
    }
    shot_free(&forward[0]);
    shot_free(&forward[1]);
    stage_close(&s);
}
