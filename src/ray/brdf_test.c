/* SPDX-License-Identifier: MIT */
#include "ray/brdf.h"

#include "base/base.h"
#include "ray/tone.h"

#include <setjmp.h>

#include <cmocka.h>

static struct ray_surface surface_of(double metallic, double roughness, double base) {
    double f0 = ray_ior_reflectance(1.5);
    return (struct ray_surface){.normal = {0, 0, 1},
                                .geometric = {0, 0, 1},
                                .base_color = {base, base * 0.5, base * 0.25},
                                .metallic = metallic,
                                .roughness = roughness,
                                .occlusion = 1,
                                .f0 = {f0, f0, f0},
                                .f90 = 1};
}

/* What of light from all around goes to the viewer, by a grid over the hemisphere that is finer towards the mirror direction. */
static dvec3 albedo_by_grid(const struct ray_surface *s, dvec3 v) {
    enum { STEPS = 400 };
    dvec3 sum = {0, 0, 0};
    for (int i = 0; i < STEPS; i++)
        for (int k = 0; k < STEPS; k++) { /* equal areas of the disk below the hemisphere: the cosine is in the area */
            double r2 = (i + 0.5) / STEPS, angle = 2 * DPI * (k + 0.5) / STEPS, z = sqrt(1 - r2);
            dvec3 l = {sqrt(r2) * cos(angle), sqrt(r2) * sin(angle), z};
            sum = dvec3_add_scaled(sum, ray_brdf_cos(s, v, l), 1 / z);
        }
    return dvec3_scale(sum, DPI / ((double)STEPS * STEPS));
}

/* Means of sampled directions are the integral, whatever the lobe; and no metal sends more than it gets. */
static void test_samples_integrate_the_brdf(void **state) {
    UNUSED(state);
    static const struct {
        double metallic, roughness, cosine;
    } cases[] = {{0, 1, 1}, {0, 0.5, 0.7}, {0, 0.3, 0.2}, {1, 1, 0.6}, {1, 0.5, 0.9}, {1, 0.4, 0.1}, {0.5, 0.6, 0.5}};
    for (uint32_t i = 0; i < COUNT_OF(cases); i++) {
        enum { SIDE = 256 };
        struct ray_surface s = surface_of(cases[i].metallic, cases[i].roughness, 0.9);
        double z = cases[i].cosine;
        dvec3 v = {sqrt(1 - z * z) * 0.6, sqrt(1 - z * z) * 0.8, z}, wanted = albedo_by_grid(&s, v), sum = {0, 0, 0};
        struct random_state random = {i + 1};
        for (int a = 0; a < SIDE; a++)
            for (int b = 0; b < SIDE; b++) {
                double u[3] = {(double)random_float(&random), (a + (double)random_float(&random)) / SIDE,
                               (b + (double)random_float(&random)) / SIDE};
                double density;
                dvec3 l, weight = ray_brdf_sample(&s, v, u, &l, &density);
                assert_true(fabs(dvec3_length(l) - 1) < 1e-9);
                sum = dvec3_add_scaled(sum, weight, 1.0 / (SIDE * SIDE));
            }
        /* glTF's dielectrics take the diffuse part by another Fresnel term than they reflect: seen from the side they may send more than they get. */
        if (!(wanted.x <= (s.metallic == 1 ? 1 : 1.2) && wanted.x > 0.1))
            fail_msg("case %u: of all light %g is reflected", i, wanted.x);
        if (fabs(sum.x / wanted.x - 1) > 0.01 || fabs(sum.z / wanted.z - 1) > 0.015)
            fail_msg("case %u: the samples' mean is %g, %g, the integral %g, %g", i, sum.x, sum.z, wanted.x, wanted.z);
    }
}

/* Zero behind the triangle, one where both normals agree, a smooth rise between. */
static void test_leaning_normals_fade(void **state) {
    UNUSED(state);
    const dvec3 geometric = {0, 0, 1}, normal = {0.8, 0, 0.6};
    double last = 0, steepest = 0;
    for (int i = 0; i <= 1000; i++) {
        const double angle = DPI * i / 1000;
        const dvec3 l = {cos(angle), 0, sin(angle)};
        assert_true(fabs(ray_facing(geometric, geometric, l) - (l.z > 1e-4 ? 1 : 0)) < 1e-6);
        const double part = ray_facing(geometric, normal, l);
        if (dvec3_dot(normal, l) <= 0) break;
        assert_true(part >= last && part <= 1);
        steepest = fmax(steepest, part - last);
        last = part;
    }
    assert_true(last == 1 && steepest < 0.02);
    assert_true(ray_facing(geometric, normal, dvec3_make(1, 0, 0)) == 0 && ray_facing(geometric, normal, dvec3_make(0.8, 0, -0.6)) == 0);
    assert_true(fabs(ray_facing(geometric, normal, dvec3_make(0.96, 0, 0.28)) - 0.784) < 1e-9); /* 0.28 of 0.4 */
}

/* The same with layers; and however they are stacked, what they take from below is what they send. */
static void test_layers_are_sampled_and_keep_energy_MA_2(void **state) {
    UNUSED(state);
    static struct ray_albedos albedos;
    ray_albedos_fill(&albedos);
    for (int i = 0; i < 6; i++) {
        enum { COUNT = 1 << 16 };
        struct ray_surface s = surface_of(i == 4 ? 1 : 0, 0.5, 1);
        const double z = i % 2 ? 0.4 : 0.8;
        s.layered = true;
        s.layers = (struct ray_layers){.clearcoat_normal = {0, 0, 1}, .tangent = {0.6, 0.8, 0}};
        if (i == 0 || i == 5) s.layers.clearcoat = 1, s.layers.clearcoat_roughness = 0.4;
        if (i == 1 || i == 5) s.layers.sheen_color = dvec3_make(1, 0.5, 0.2), s.layers.sheen_roughness = 0.5;
        if (i == 2) s.layers.film = 1, s.layers.film_ior = 1.4, s.layers.film_thickness = 300;
        if (i >= 3) s.layers.anisotropy = 0.7;
        const dvec3 v = {sqrt(1 - z * z) * 0.6, sqrt(1 - z * z) * 0.8, z};
        ray_layers_prepare(&albedos, &s, v);
        const dvec3 wanted = albedo_by_grid(&s, v);
        dvec3 sum = {0, 0, 0};
        struct random_state random = {(uint64_t)i + 1};
        for (int k = 0; k < COUNT; k++) {
            const double u[3] = {(double)random_float(&random), (double)random_float(&random), (double)random_float(&random)};
            dvec3 l;
            double density;
            sum = dvec3_add_scaled(sum, ray_brdf_sample(&s, v, u, &l, &density), 1.0 / COUNT);
        }
        if (fabs(sum.x / wanted.x - 1) > 0.02 || fabs(sum.z / wanted.z - 1) > 0.03 || !(wanted.x < 1.05))
            fail_msg("case %d: the samples' mean is %g, %g, the integral %g, %g", i, sum.x, sum.z, wanted.x, wanted.z);
    }
}

/* Of a film: nothing is left of one without thickness. */
static void test_thin_films_vanish_MA_1(void **state) {
    UNUSED(state);
    static struct ray_albedos albedos;
    for (int metal = 0; metal < 2; metal++) {
        struct ray_surface s = surface_of(metal, 0.5, 0.8);
        const dvec3 v = {0, 0, 1};
        s.layered = true;
        s.layers = (struct ray_layers){.clearcoat_normal = {0, 0, 1}, .film = 1, .film_ior = 1.6, .film_thickness = 0};
        ray_layers_prepare(&albedos, &s, v);
        assert_true(fabs(s.layers.film_dielectric.x - s.f0.x) < 0.01 && fabs(s.layers.film_metal.x - s.base_color.x) < 0.01);
        s.layers.film_thickness = 400;
        ray_layers_prepare(&albedos, &s, v);
        const dvec3 f = s.layers.film_dielectric;
        assert_true(fmax(fmax(f.x, f.y), f.z) - fmin(fmin(f.x, f.y), f.z) > 0.02 && dvec3_max(f) < 1); /* it has a colour */
    }
}

/* In an even sky the fit of ambient light is close to the integral of what a dielectric reflects. */
static void test_ambient_is_close_to_the_integral(void **state) {
    UNUSED(state);
    static const double cosines[] = {0.2, 0.5, 0.9}, roughnesses[] = {0.4, 0.6, 0.9};
    const dvec3 sky = {1, 1, 1};
    double worst = 0;
    for (uint32_t i = 0; i < COUNT_OF(cosines); i++)
        for (uint32_t k = 0; k < COUNT_OF(roughnesses); k++) {
            struct ray_surface s = surface_of(0, roughnesses[k], 0);
            dvec3 v = {sqrt(1 - cosines[i] * cosines[i]), 0, cosines[i]};
            worst = fmax(worst, fabs(ray_ambient(&s, v, sky, sky).x - albedo_by_grid(&s, v).x));
        }
    if (worst > 0.03) fail_msg("the fit is off by %g", worst);
}

/* White matt: every sample carries all light. */
static void test_matt_samples_are_exact(void **state) {
    UNUSED(state);
    struct ray_surface s = surface_of(0, 1, 1);
    s.f0 = (dvec3){0, 0, 0};
    s.f90 = 0;
    s.base_color = (dvec3){1, 1, 1};
    struct random_state random = {7};
    for (int i = 0; i < 1000; i++) {
        const double u[3] = {(double)random_float(&random), (double)random_float(&random), (double)random_float(&random)};
        double density;
        dvec3 l, weight = ray_brdf_sample(&s, dvec3_normalize(dvec3_make(0.3, -0.5, 0.4)), u, &l, &density);
        assert_true(fabs(weight.x - 1) < 1e-12 && l.z > 0);
    }
}

/* Light and viewer may change places (Helmholtz). */
static void test_brdf_is_reciprocal(void **state) {
    UNUSED(state);
    struct random_state random = {3};
    for (int i = 0; i < 200; i++) {
        struct ray_surface s = surface_of((double)random_float(&random), (double)random_float(&random), 0.8);
        dvec3 a = dvec3_normalize(dvec3_make((double)random_range(&random, -1, 1), (double)random_range(&random, -1, 1),
                                             (double)random_range(&random, 0.1f, 1)));
        dvec3 b = dvec3_normalize(dvec3_make((double)random_range(&random, -1, 1), (double)random_range(&random, -1, 1),
                                             (double)random_range(&random, 0.1f, 1)));
        dvec3 there = dvec3_scale(ray_brdf_cos(&s, a, b), 1 / b.z), back = dvec3_scale(ray_brdf_cos(&s, b, a), 1 / a.z);
        assert_true(fabs(there.x - back.x) <= 1e-9 * fabs(there.x) && fabs(there.z - back.z) <= 1e-9 * fabs(there.z));
        b.z = -b.z;
        assert_true(dvec3_max(ray_brdf_cos(&s, a, b)) == 0);
    }
}

static void test_meter_reads_grey(void **state) {
    UNUSED(state);
    enum { SIDE = 40, COUNT = SIDE * SIDE };
    static float pixels[COUNT * 4];
    static uint8_t surfaces[COUNT];
    const double key = -log2(1.2 * 0.18), spare = -log2(1.2 * 3), light = -log2(1.2 * 0.5); /* of a luminance of 1 */
    memset(surfaces, 1, sizeof surfaces);
    for (int i = 0; i < COUNT * 4; i++) pixels[i] = 64;
    assert_true(fabs(ray_meter(pixels, surfaces, SIDE, SIDE) - (6 + key)) < 0.1);
    for (int i = 0; i < COUNT * 2; i++) pixels[i] = 0; /* black says nothing about brightness */
    assert_true(fabs(ray_meter(pixels, surfaces, SIDE, SIDE) - (6 + key)) < 0.1);
    /* A background 32 times as bright counts 1/32 of what surfaces count, and is not kept from being white; without surfaces it is all that there is. */
    for (int i = 0; i < COUNT * 4; i++) pixels[i] = i < COUNT * 2 ? 64 : 2048;
    memset(surfaces + COUNT / 2, 0, COUNT / 2);
    assert_true(fabs(ray_meter(pixels, surfaces, SIDE, SIDE) - (6 + key)) < 0.2);
    memset(surfaces, 0, sizeof surfaces);
    const double all = ray_meter(pixels, surfaces, SIDE, SIDE);
    assert_true(all > 8.4 + key && all < 8.6 + key);
    /* Four steps from left to right: their mean. */
    memset(surfaces, 1, sizeof surfaces);
    for (int i = 0; i < COUNT * 4; i++) pixels[i] = exp2f(4 * ((float)(i / 4 % SIDE) + 0.5f) / SIDE);
    assert_true(fabs(ray_meter(pixels, surfaces, SIDE, SIDE) - (2 + key)) < 0.1);
    /* A seventh of the picture is 16 times as bright, or a fiftieth 256 times: highlights are kept. */
    for (int i = 0; i < COUNT * 4; i++) pixels[i] = i / 4 % 7 == 0 ? 16 : 1;
    assert_true(fabs(ray_meter(pixels, surfaces, SIDE, SIDE) - (4 + light)) < 0.2);
    for (int i = 0; i < COUNT * 4; i++) pixels[i] = i / 4 % 49 == 0 ? 256 : 1;
    assert_true(fabs(ray_meter(pixels, surfaces, SIDE, SIDE) - (8 + spare)) < 0.2);
    /* What stands in the middle counts more than what surrounds it. */
    for (int i = 0; i < COUNT; i++) {
        const bool inside = abs(i % SIDE - SIDE / 2) < SIDE / 4 && abs(i / SIDE - SIDE / 2) < SIDE / 4;
        for (int c = 0; c < 4; c++) pixels[4 * i + c] = inside ? 1 : 4;
    }
    assert_true(ray_meter(pixels, surfaces, SIDE, SIDE) < 1.3 + key); /* a quarter of the picture: evenly it would be 1.5 */
    for (int i = 0; i < COUNT * 4; i++) pixels[i] = 0;
    assert_true(ray_meter(pixels, surfaces, SIDE, SIDE) == 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_leaning_normals_fade),
        cmocka_unit_test(test_layers_are_sampled_and_keep_energy_MA_2), cmocka_unit_test(test_thin_films_vanish_MA_1),
        cmocka_unit_test(test_samples_integrate_the_brdf), cmocka_unit_test(test_ambient_is_close_to_the_integral),
        cmocka_unit_test(test_matt_samples_are_exact),     cmocka_unit_test(test_brdf_is_reciprocal),
        cmocka_unit_test(test_meter_reads_grey),
    };
    return cmocka_run_group_tests_name("brdf", tests, NULL, NULL);
}
