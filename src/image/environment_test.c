/* SPDX-License-Identifier: MIT */
#include "image/environment.h"

#include <math.h>
#include <setjmp.h>

#include <cmocka.h>

/* ---- RGBM ---- */

static void test_rgbm_round_trip_MB_9(void **state) {
    UNUSED(state);
    struct random_state random = {3};
    double worst = 0;
    for (int i = 0; i < 200000; i++) {
        float scale = powf(2, random_range(&random, -7, 5.17f)), color[3], back[3];
        for (int c = 0; c < 3; c++) color[c] = scale * random_float(&random);
        uint8_t rgbm[4];
        rgbm_encode(color, rgbm);
        rgbm_decode(rgbm, back);
        float most = fmaxf(color[0], fmaxf(color[1], color[2]));
        for (int c = 0; c < 3; c++) {
            /* Roots are off by half a step of 255 of the largest one, which M may exceed by a step of its own. */
            double step = sqrt((double)most) / 255 * 0.55 + (double)RGBM_RANGE / 255 / 255 * 0.55;
            double off = fabs(sqrt((double)back[c]) - sqrt((double)color[c]));
            worst = fmax(worst, off / step);
        }
    }
    print_message("worst error of a root, of what is allowed: %.3f\n", worst);
    assert_true(worst <= 1);
    const float special[][3] = {{0, 0, 0}, {-1, NAN, 0}, {RGBM_MOST, 0, 0}, {1e30f, 1, INFINITY}};
    for (int i = 0; i < 4; i++) {
        uint8_t rgbm[4];
        float back[3];
        rgbm_encode(special[i], rgbm);
        rgbm_decode(rgbm, back);
        for (int c = 0; c < 3; c++) assert_true(back[c] >= 0 && back[c] <= RGBM_MOST * 1.0001f);
        if (i < 2) assert_true(back[0] == 0 && back[1] == 0 && back[2] == 0);
        if (i >= 2) assert_true(fabsf(back[0] - RGBM_MOST) < 0.01f);
    }
}

/* Bytes of a block of 4 x 4 as four levels between its least and its most, as block compression keeps a channel at best. */
static void compress_block(uint8_t *bytes, uint32_t stride, uint32_t count) {
    uint8_t low = 255, high = 0;
    for (uint32_t i = 0; i < count; i++) {
        low = MIN(low, bytes[i * stride]);
        high = MAX(high, bytes[i * stride]);
    }
    for (uint32_t i = 0; i < count && high > low; i++) {
        float level = roundf(3 * (float)(bytes[i * stride] - low) / (float)(high - low));
        bytes[i * stride] = (uint8_t)roundf((float)low + level / 3 * (float)(high - low));
    }
}

/* Bright spots on a dark wall: when M is compressed with the colours, its few levels show as blocks. */
static void test_rgbm_keeps_m_apart_MB_9(void **state) {
    UNUSED(state);
    struct random_state random = {8};
    double apart = 0, together = 0;
    for (int block = 0; block < 500; block++) {
        uint8_t kept[16][4], squeezed[16][4];
        float colors[16][3], back[3];
        for (int i = 0; i < 16; i++) {
            float light = 0.2f + 20 * powf((float)(i % 4) / 3, 3) * random_float(&random);
            for (int c = 0; c < 3; c++) colors[i][c] = light * (0.6f + 0.1f * (float)c);
            rgbm_encode(colors[i], kept[i]);
            memcpy(squeezed[i], kept[i], 4);
        }
        for (uint32_t c = 0; c < 4; c++) compress_block(&squeezed[0][c], 4, 16);
        for (uint32_t c = 0; c < 3; c++) compress_block(&kept[0][c], 4, 16); /* M is left */
        for (int i = 0; i < 16; i++)
            for (int c = 0; c < 3; c++) {
                rgbm_decode(kept[i], back);
                apart += fabs(log2((double)back[c] / (double)colors[i][c]));
                rgbm_decode(squeezed[i], back);
                together += fabs(log2((double)back[c] / (double)colors[i][c]));
            }
    }
    print_message("mean error in stops: M apart %.4f, compressed with the colours %.4f\n", apart / 24000, together / 24000);
    assert_true(together > 5 * apart);
}

/* ---- filtered cube maps ---- */

static float light_from(vec3 d) {
    return fmaxf(d.y, 0) + 4 * powf(fmaxf(vec3_dot(d, vec3_normalize((vec3){1, 1, 0.3f})), 0), 40);
}

static void fill(struct environment *e) {
    for (uint32_t face = 0; face < 6; face++)
        for (uint32_t y = 0; y < e->size; y++)
            for (uint32_t x = 0; x < e->size; x++) {
                vec3 d = environment_direction(e, 0, face, x, y);
                float *texel = environment_texel(e, 0, d);
                assert_ptr_equal(texel, e->texels + 3 * (((size_t)face * e->size + y) * e->size + x));
                texel[0] = light_from(d);
                texel[1] = d.x > 0 ? 1 : 0;
                texel[2] = 0.5f;
            }
}

/* What a surface of this roughness mirrors, seen along its normal: half vectors by GGX over the cube, in steps of angles. */
static double mirrored(vec3 axis, double roughness) {
    enum { RINGS = 400, TURNS = 200 };
    vec3 side = fabsf(axis.y) < 0.9f ? (vec3){0, 1, 0} : (vec3){1, 0, 0};
    vec3 t = vec3_normalize(vec3_cross(side, axis)), b = vec3_cross(axis, t);
    double sum = 0, weight = 0, alpha2 = pow(roughness, 4);
    for (int r = 0; r < RINGS; r++) {
        double theta = (r + 0.5) * (double)PI / 2 / RINGS,
               half = cos(theta / 2); /* of the light; the half vector is at theta / 2 */
        double d = alpha2 / pow(half * half * (alpha2 - 1) + 1, 2), w = d * cos(theta) * sin(theta);
        for (int k = 0; k < TURNS; k++) {
            double phi = 2 * (double)PI * k / TURNS;
            vec3 l = vec3_add(
                vec3_add(vec3_scale(t, (float)(sin(theta) * cos(phi))), vec3_scale(b, (float)(sin(theta) * sin(phi)))),
                vec3_scale(axis, (float)cos(theta)));
            sum += w * (double)light_from(l);
            weight += w;
        }
    }
    return sum / weight;
}

static void test_mips_by_roughness_MB_10(void **state) {
    UNUSED(state);
    fnl_host host = host_resolve(NULL);
    assert_true(environment_mip(8, 0) == 0 &&
                environment_mip(8, 1) == 7); /* eight times roughness would ask for a ninth mip */
    assert_true(environment_mip(8, 0.875f) < 7 && environment_mip(8, -1) == 0 && environment_mip(8, 2) == 7);
    struct environment exact, sampled;
    assert_int_equal(environment_init(&host, 32, &exact), FNL_OK);
    assert_int_equal(environment_init(&host, 32, &sampled), FNL_OK);
    assert_int_equal(exact.mips, 6);
    fill(&exact);
    fill(&sampled);
    environment_prefilter(&exact, 0);
    environment_prefilter(&sampled, 1024);
    double before = 1e30;
    for (uint32_t mip = 0; mip < exact.mips; mip++) {
        uint32_t side = exact.size >> mip;
        double worst = 0, low = 1e30, high = 0;
        for (uint32_t face = 0; face < 6; face++)
            for (uint32_t y = 0; y < side; y++)
                for (uint32_t x = 0; x < side; x++) {
                    vec3 d = environment_direction(&exact, mip, face, x, y);
                    const float *a = environment_texel(&exact, mip, d), *b = environment_texel(&sampled, mip, d);
                    worst = fmax(worst, fabs((double)(a[0] - b[0])));
                    low = fmin(low, (double)a[0]);
                    high = fmax(high, (double)a[0]);
                    assert_true(fabsf(a[2] - 0.5f) < 1e-5f && fabsf(b[2] - 0.5f) < 1e-5f); /* even light stays */
                }
        print_message("mip %u: from %.3f to %.3f, samples off by %.4f\n", mip, low, high, worst);
        assert_true(worst < 0.03);
        if (mip > 0) { /* mip i of n is for roughness i / (n - 1), 1 at the end */
            vec3 d = environment_direction(&exact, mip, 2, side / 2, side / 2);
            double expected = mirrored(d, mip / (exact.mips - 1.0)), found = (double)environment_texel(&exact, mip, d)[0];
            print_message("mip %u: %.4f where the lobe of its roughness finds %.4f\n", mip, found, expected);
            assert_true(fabs(found - expected) < 0.02 * expected);
        }
        assert_true(high - low < before); /* rougher, smoother */
        before = high - low;
    }
    environment_finish(&host, &exact);
    environment_finish(&host, &sampled);
}

/* ---- lobes ---- */

static void test_lobes_MB_8(void **state) {
    UNUSED(state);
    for (int i = 1; i <= 10; i++) {
        double roughness = 0.1 * i, projected = 0;
        enum { STEPS = 400000 };
        for (int k = 0; k < STEPS; k++) { /* the distribution's projection covers the surface once */
            double cosine = (k + 0.5) / STEPS;
            projected += ggx_distribution(roughness, cosine) * cosine * 2 * (double)PI / STEPS;
        }
        assert_true(fabs(projected - 1) < 0.01);
        /* Walter et al. 2007, eq. 33, with alpha = roughness^2: along the normal, and at half an octant. */
        double alpha2 = pow(roughness, 4), tangent2 = pow(tan((double)PI / 8), 2), cosine4 = pow(cos((double)PI / 8), 4);
        assert_true(fabs(ggx_distribution(roughness, 1) * (double)PI * alpha2 - 1) < 1e-9);
        double tilted = alpha2 / ((double)PI * cosine4 * pow(alpha2 + tangent2, 2));
        assert_true(fabs(ggx_distribution(roughness, cos((double)PI / 8)) / tilted - 1) < 1e-9);
        for (int k = 0; k <= 10; k++) {
            double n_v = 0.1 * k, f0 = 0.04;
            double fresnel = schlick_roughness(f0, roughness, n_v);
            assert_true(fresnel >= f0 - 1e-12 && fresnel <= fmax(1 - roughness, f0) + 1e-12);
        }
        assert_true(schlick_roughness(0.04, roughness, 1) == 0.04); /* from the front: F0 */
        assert_true(fabs(schlick_roughness(0.04, roughness, 0) - fmax(1 - roughness, 0.04)) <
                    1e-12); /* along it: 1 - roughness */
        assert_true(fabs(schlick_roughness(0.04, roughness, 0.5) - (0.04 + (fmax(1 - roughness, 0.04) - 0.04) / 32)) <
                    1e-12);
        assert_true(schlick_roughness(1, roughness, 0.3) == 1);
    }
    assert_true(schlick_roughness(0.04, 1, 0) == 0.04); /* the roughest: F0 from everywhere */
    assert_true(ggx_distribution(0.5, -0.1) == 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_rgbm_round_trip_MB_9),
        cmocka_unit_test(test_rgbm_keeps_m_apart_MB_9),
        cmocka_unit_test(test_mips_by_roughness_MB_10),
        cmocka_unit_test(test_lobes_MB_8),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
