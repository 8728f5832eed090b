/* SPDX-License-Identifier: MIT */
#include "tests/shadow_paths.h"
#include "frame_plain.h"

static const char *const source = "builtin:interior?lights=40&sun=5"; /* all shapes of lights, and a sun */

const fnl_shading shadow_path_kinds[SHADOW_PATH_KINDS] = {FNL_SHADING_FORWARD, FNL_SHADING_DEFERRED, FNL_SHADING_LIGHT_PREPASS, FNL_SHADING_VISIBILITY};

void expect_lists_alike(fnl_shadows shadows) {
    const fnl_frame usual = frame_plain();
    expect_lists_alike_with(shadows, &usual.shadow);
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

static void expect_alike(fnl_shadows shadows, const fnl_shadow_options *settings, uint32_t msaa, const fnl_shading *paths, uint32_t count) {
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
    for (uint32_t i = 0; i < count; i++) {
        const fnl_shading shading = paths[i];
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
        /* Paths shade a pixel with samples at different points of it, on both sides of a shadow's edge. Forward shading takes a point of each triangle. */
        if (psnr[1] < psnr[0] - (msaa > 1 ? 9 : 4) || psnr[1] < 24)
            fail_msg("%s, %u samples: %.1f dB with shadows, %.1f without", fnl_value_name(FNL_ENUM_SHADING, shading), msaa, psnr[1], psnr[0]);
    }
    shot_free(&forward[0]);
    shot_free(&forward[1]);
    stage_close(&s);
}

void expect_paths_alike(fnl_shadows shadows, uint32_t msaa) {
    const fnl_frame usual = frame_plain();
    static const fnl_shading several[] = {FNL_SHADING_DEFERRED, FNL_SHADING_VISIBILITY};
    fnl_shading all[FNL_SHADING_AUTO];
    for (uint32_t i = 0; i < FNL_SHADING_AUTO; i++) all[i] = (fnl_shading)i;
    const bool one = msaa == 1;
    expect_alike(shadows, &usual.shadow, msaa, one ? all : several, one ? COUNT_OF(all) : COUNT_OF(several));
}

void expect_path_kinds_alike(fnl_shadows shadows, const fnl_shadow_options *settings) {
    expect_alike(shadows, settings, 1, shadow_path_kinds, SHADOW_PATH_KINDS);
}
