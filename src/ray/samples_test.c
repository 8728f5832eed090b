/* SPDX-License-Identifier: MIT */
/* Numbers that are well spread, and directions that are chosen with the density that is said. */
#include "ray/brdf.h"
#include "ray/environment.h"
#include "ray/samples.h"

#include <setjmp.h>

#include <cmocka.h>

/* The first 2^k samples of a pixel have one number in each 2^k-th of the range, and by two numbers one in each rectangle of that size. */
static void test_samples_fill_the_range_evenly(void **state) {
    UNUSED(state);
    for (uint32_t pixel = 0; pixel < 20; pixel++)
        for (uint32_t bits = 1; bits <= 10; bits += 3) {
            const uint32_t count = 1u << bits;
            static uint8_t seen[3][1024], squares[11][1024];
            memset(seen, 0, sizeof seen);
            memset(squares, 0, sizeof squares);
            for (uint32_t i = 0; i < count; i++) {
                struct ray_samples s = ray_samples_make(5, pixel, 3 * pixel, i);
                double out[3];
                ray_samples_next(&s);
                ray_samples_draw(&s, 2, out);
                ray_samples_draw(&s, 3, out);
                for (int k = 0; k < 3; k++) {
                    assert_true(out[k] >= 0 && out[k] < 1);
                    seen[k][(uint32_t)(out[k] * count)]++;
                }
                for (uint32_t a = 0; a <= bits; a++) squares[a][(uint32_t)(out[0] * (1u << a)) << (bits - a) | (uint32_t)(out[1] * (1u << (bits - a)))]++;
            }
            for (uint32_t i = 0; i < count; i++) {
                for (int k = 0; k < 3; k++) assert_int_equal(seen[k][i], 1);
                for (uint32_t a = 0; a <= bits; a++) assert_int_equal(squares[a][i], 1);
            }
        }
}

/* Draws of other pixels, of other places and of one after another have nothing to do with each other. */
static void test_draws_do_not_depend_on_each_other(void **state) {
    UNUSED(state);
    enum { PIXELS = 4096, SAMPLES = 16, NUMBERS = 6 };
    double moments[NUMBERS][NUMBERS] = {{0}}, last[NUMBERS] = {0}, across = 0;
    for (uint32_t pixel = 0; pixel < PIXELS; pixel++)
        for (uint32_t i = 0; i < SAMPLES; i++) {
            struct ray_samples s = ray_samples_make(1, pixel % 64, pixel / 64, i);
            double out[NUMBERS];
            ray_samples_draw(&s, 2, out);
            ray_samples_draw(&s, 2, out + 2);
            ray_samples_next(&s);
            ray_samples_draw(&s, 2, out + 4);
            for (int a = 0; a < NUMBERS; a++)
                for (int b = 0; b < NUMBERS; b++) moments[a][b] += 12 * (out[a] - 0.5) * (out[b] - 0.5) / (PIXELS * SAMPLES);
            if (i == 0) across += 12 * (out[0] - 0.5) * (last[0] - 0.5) / PIXELS;
            if (i == 0) memcpy(last, out, sizeof last);
        }
    for (int a = 0; a < NUMBERS; a++)
        for (int b = 0; b < NUMBERS; b++)
            if (!(fabs(moments[a][b] - (a == b)) < 0.02)) fail_msg("numbers %d and %d correlate by %g", a, b, moments[a][b]);
    assert_true(fabs(across) < 0.06);
}

/* ---- the environment's bright parts ---- */

enum { WIDTH = 32, HEIGHT = 16 };

static struct scene_environment lamps_around(float *texels) {
    struct random_state random = {4};
    for (int i = 0; i < 3 * WIDTH * HEIGHT; i++) texels[i] = 0.2f * random_float(&random);
    texels[3 * (5 * WIDTH + 31)] = 90;
    texels[3 * (0 * WIDTH + 7) + 1] = 300; /* at the pole */
    texels[3 * (15 * WIDTH + 20) + 2] = 900;
    struct scene_environment e = {.panorama = {WIDTH, HEIGHT, texels}, .rotation = 0.7f, .intensity = 3, .own = {.rotation = quat_axis_angle(vec3_make(1, 0, 0), 0.4f), .intensity = 2}};
    return e;
}

/* Sums over directions that are even over the sphere. */
static void test_the_environment_is_chosen_by_its_density(void **state) {
    UNUSED(state);
    enum { STEPS = 1200 };
    static float texels[3 * WIDTH * HEIGHT];
    const fnl_host host = host_resolve(NULL);
    const struct scene_environment scene = lamps_around(texels);
    struct ray_environment e;
    assert_int_equal(ray_environment_create(&host, &scene, NULL, &e), FNL_OK);
    double all = 0, light = 0, chosen = 0;
    for (int i = 0; i < STEPS; i++)
        for (int k = 0; k < 2 * STEPS; k++) {
            const double y = 1 - 2 * (i + 0.5) / STEPS, sine = sqrt(1 - y * y), angle = 2 * DPI * (k + 0.5) / (2 * STEPS), share = 4 * DPI / (2.0 * STEPS * STEPS);
            const dvec3 d = {sine * cos(angle), y, sine * sin(angle)};
            all += ray_environment_density(&e, d) * share;
            if (ray_environment_density(&e, d) > 0) light += dvec3_luminance(ray_environment_from(&e, d)) * share;
        }
    if (!(fabs(all - 1) < 0.005)) fail_msg("the density's integral is %g", all);
    enum { COUNT = 4096 };
    for (uint32_t i = 0; i < COUNT; i++) {
        struct ray_samples s = ray_samples_make(1, 0, 0, i);
        double random[2];
        dvec3 d;
        ray_samples_draw(&s, 2, random);
        const double density = ray_environment_sample(&e, random, &d), said = ray_environment_density(&e, d);
        assert_true(density > 0 && fabs(dvec3_length(d) - 1) < 1e-6);
        if (!(fabs(said / density - 1) < 1e-6)) fail_msg("chosen with %g, said to be %g", density, said);
        chosen += dvec3_luminance(ray_environment_from(&e, d)) / density / COUNT;
    }
    if (!(fabs(chosen / light - 1) < 0.01)) fail_msg("light of chosen directions is %g, must be %g", chosen, light);
    ray_environment_destroy(&host, &e);
    for (int i = 0; i < 3 * WIDTH * HEIGHT; i++) texels[i] = 0.3f; /* nothing is brighter than the mean */
    assert_int_equal(ray_environment_create(&host, &scene, NULL, &e), FNL_OK);
    assert_true(!e.rows && ray_environment_sample(&e, (double[]){0.5, 0.5}, &(dvec3){0, 0, 0}) == 0 && ray_environment_density(&e, (dvec3){0, 1, 0}) == 0);
    ray_environment_destroy(&host, &e);
}

/* The density that ray_brdf_light() says is the one with which directions are chosen: all of them together are 1, or less where lobes reach below the horizon. */
static void test_the_density_of_a_surface_is_its_own(void **state) {
    UNUSED(state);
    static struct ray_albedos albedos;
    ray_albedos_fill(&albedos);
    for (int kind = 0; kind < 5; kind++) {
        enum { STEPS = 700, COUNT = 1 << 14 };
        struct ray_surface s = {.normal = {0, 0, 1}, .geometric = {0, 0, 1}, .base_color = {0.8, 0.8, 0.8}, .metallic = kind == 1, .roughness = kind == 0 ? 0.6 : 0.4, .f0 = {0.04, 0.04, 0.04}, .f90 = 1};
        const dvec3 v = dvec3_normalize(dvec3_make(0.5, 0.3, 0.8));
        if (kind > 1) s.layered = true, s.layers = (struct ray_layers){.clearcoat = kind == 2, .clearcoat_roughness = 0.5, .clearcoat_normal = {0, 0, 1}, .tangent = {1, 0, 0}, .ior = 1.5};
        if (kind == 3) s.layers.sheen_color = (dvec3){0.5, 0.5, 0.5}, s.layers.sheen_roughness = 0.6;
        if (kind == 4) s.layers.diffuse_transmission = 0.6, s.layers.diffuse_transmission_color = (dvec3){0.5, 1, 1};
        ray_layers_prepare(&albedos, &s, v);
        double all = 0, light = 0, chosen = 0;
        for (int i = 0; i < STEPS; i++)
            for (int k = 0; k < STEPS; k++) {
                const double z = 1 - 2 * (i + 0.5) / STEPS, sine = sqrt(1 - z * z), angle = 2 * DPI * (k + 0.5) / STEPS, share = 4 * DPI / ((double)STEPS * STEPS);
                double density;
                light += ray_brdf_light(&s, v, dvec3_make(sine * cos(angle), sine * sin(angle), z), &density).y * share;
                all += density * share;
            }
        uint32_t below = 0;
        for (uint32_t i = 0; i < COUNT; i++) {
            struct ray_samples samples = ray_samples_make(1, 0, 0, i);
            double random[3], density, said;
            dvec3 l;
            ray_samples_draw(&samples, 3, random);
            const dvec3 weight = ray_brdf_sample(&s, v, random, &l, &density);
            const dvec3 f = ray_brdf_light(&s, v, l, &said);
            assert_true(fabs(density - said) <= 1e-9 * density && fabs(weight.y * density - f.y) <= 1e-9 * f.y);
            below += !(density > 0);
            chosen += weight.y / COUNT;
        }
        if (!(fabs(all + (double)below / COUNT - 1) < 0.01)) fail_msg("kind %d: the density's integral is %g, and %u of %d are lost", kind, all, below, COUNT);
        if (!(fabs(chosen / light - 1) < 0.01)) fail_msg("kind %d: chosen directions bring %g, all together %g", kind, chosen, light);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_samples_fill_the_range_evenly),
        cmocka_unit_test(test_draws_do_not_depend_on_each_other),
        cmocka_unit_test(test_the_environment_is_chosen_by_its_density),
        cmocka_unit_test(test_the_density_of_a_surface_is_its_own),
    };
    return cmocka_run_group_tests_name("samples", tests, NULL, NULL);
}
