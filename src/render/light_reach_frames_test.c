/* SPDX-License-Identifier: MIT */
/** Lights without a range in whole frames: they light everything, in every list and with every kind of shadow, and in the tracer. */
#include "scene/light_kinds.h"
#include "tests/list_pairs.h"
#include "tests/render_test.h"

enum { WIDTH = 64, HEIGHT = 36 };

static const fnl_light_kind kinds[] = {FNL_LIGHT_POINT, FNL_LIGHT_SPOT, FNL_LIGHT_CAPSULE, FNL_LIGHT_WEDGE, FNL_LIGHT_RECTANGLE};

/* Lights of all kinds high above the hall's floor and far outside of it, where no threshold in lux would let them reach. */
static fnl_light_params lamp(uint32_t i, uint32_t count, float candela) {
    fnl_light_params light = fnl_light_params_default();
    light.kind = kinds[i % COUNT_OF(kinds)];
    light.position = vec3_make(-12 + 24 * (float)i / (float)count, 6 + (float)(i % 3), (float)(i % 7) - 3);
    if (i % 8 == 7) light.position = vec3_scale(light.position, 20);
    light.direction = vec3_sub(vec3_make(0, 0, 0), light.position);
    light.intensity = candela;
    light.range = INFINITY;
    return light;
}

/* `like`: each light's range is its reach in that scene. */
static struct stage open_lit(uint32_t count, float candela, float range, const fnl_scene *like) {
    struct stage s = stage_open("builtin:hall?lights=0", 0);
    for (uint32_t i = 0; i < count; i++) {
        fnl_light_id id;
        fnl_light_params light = lamp(i, count, candela);
        light.range = like ? light_effective_range(&like->lights.data[i]) : range;
        assert_int_equal(fnl_scene_add_light(s.scene, &light, &id), FNL_OK);
    }
    s.frame.width = WIDTH, s.frame.height = HEIGHT;
    s.frame.ev = 5 + log2f(candela / 100);
    return s;
}

/* 1/255 is what the eye could see; radiance is compared, which shows less. */
static void expect_alike(const fnl_image *a, const fnl_image *b) {
    const float *x = a->pixels, *y = b->pixels;
    double sum = 0, most = 0;
    for (size_t i = 0; i < (size_t)WIDTH * HEIGHT * 4; i++) {
        if (i % 4 == 3) continue;
        sum += (double)x[i];
        most = fmax(most, fabs((double)x[i] - (double)y[i]) / fmax((double)x[i], 1e-6));
    }
    assert_true(sum > 0);
    if (!(most <= 1e-3)) fail_msg("a pixel differs by %g of itself", most);
}

static fnl_trace trace_of(const struct stage *s) {
    fnl_trace_params p = trace_plain();
    fnl_trace trace;
    p.width = WIDTH, p.height = HEIGHT, p.camera = s->frame.camera;
    assert_int_equal(fnl_scene_trace(s->scene, &p, &trace), FNL_OK);
    return trace;
}

/* Dim ones too: a lamp of a millionth candela lights as far as any other. */
static void test_they_light_as_those_with_an_endless_range(void **state) {
    UNUSED(state);
    fnl_device_info info;
    assert_int_equal(fnl_device_query_info(harness_device(), &info), FNL_OK);
    for (uint32_t dim = 0; dim < 2; dim++) {
        const float candela = dim ? 1e-6f : 100;
        struct stage open = open_lit(16, candela, INFINITY, NULL), bounded = open_lit(16, candela, 1e9f, NULL);
        for (uint32_t shadows = 0; shadows < FNL_SHADOWS_COUNT; shadows++) {
            open.frame.shadows = bounded.frame.shadows = (fnl_shadows)shadows;
            open.frame.shading = bounded.frame.shading = shadows % 2 ? FNL_SHADING_DEFERRED : FNL_SHADING_FORWARD_PREPASS;
            if (shadows == FNL_SHADOWS_SAMPLED && !info.ray_query) continue;
            struct shot a = stage_shoot(&open, &open.frame), b = stage_shoot(&bounded, &bounded.frame);
            expect_alike(&a.radiance, &b.radiance);
            shot_free(&a);
            shot_free(&b);
        }
        fnl_trace a = trace_of(&open), b = trace_of(&bounded);
        expect_alike(&a.radiance, &b.radiance);
        fnl_trace_free(&open.scene->host, &a);
        fnl_trace_free(&bounded.scene->host, &b);
        stage_close(&open);
        stage_close(&bounded);
    }
}

static void test_all_lists_hold_them(void **state) {
    UNUSED(state);
    for (uint32_t many = 0; many < 2; many++) {
        struct stage s = open_lit(many ? FNL_UNLIMITED_LIGHTS_MAX + 16 : 16, 100, INFINITY, NULL);
        pairs_check_orders(&s, s.frame);
        stage_close(&s);
    }
}

/* More than FNL_UNLIMITED_LIGHTS_MAX: cut, in frames and in the tracer, as if each had its reach as its range. */
static void test_many_are_cut_alike_everywhere(void **state) {
    UNUSED(state);
    enum { COUNT = FNL_UNLIMITED_LIGHTS_MAX + 16 };
    struct stage cut = open_lit(COUNT, 100, INFINITY, NULL);
    struct shot a = stage_shoot(&cut, &cut.frame);
    for (uint32_t i = 0; i < COUNT; i++) assert_true(light_effective_range(&cut.scene->lights.data[i]) < 64 * 20); /* unlimited ones have more in this hall */
    struct stage bounded = open_lit(COUNT, 100, 0, cut.scene);
    struct shot b = stage_shoot(&bounded, &bounded.frame);
    assert_int_equal(count_differing(&a.radiance, &b.radiance), 0);
    fnl_trace traced = trace_of(&cut), expected = trace_of(&bounded);
    assert_int_equal(count_differing(&traced.radiance, &expected.radiance), 0);
    fnl_trace_free(&cut.scene->host, &traced);
    fnl_trace_free(&cut.scene->host, &expected);
    shot_free(&a);
    shot_free(&b);
    stage_close(&cut);
    stage_close(&bounded);
}

/* What comes later counts in the next frame: a lamp that makes one too many, and one that goes again. */
static void test_frames_follow_edits(void **state) {
    UNUSED(state);
    struct stage s = open_lit(FNL_UNLIMITED_LIGHTS_MAX, 100, INFINITY, NULL);
    struct shot before = stage_shoot(&s, &s.frame);
    fnl_light_params light = lamp(0, 1, 100);
    fnl_light_id id;
    assert_int_equal(fnl_scene_add_light(s.scene, &light, &id), FNL_OK);
    struct shot cut = stage_shoot(&s, &s.frame);
    assert_true(count_differing(&before.radiance, &cut.radiance) > 0);
    assert_int_equal(fnl_scene_remove_light(s.scene, id), FNL_OK);
    struct shot after = stage_shoot(&s, &s.frame);
    assert_int_equal(count_differing(&before.radiance, &after.radiance), 0);
    shot_free(&before);
    shot_free(&cut);
    shot_free(&after);
    stage_close(&s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_they_light_as_those_with_an_endless_range, harness_check),
        cmocka_unit_test_teardown(test_all_lists_hold_them, harness_check),
        cmocka_unit_test_teardown(test_many_are_cut_alike_everywhere, harness_check),
        cmocka_unit_test_teardown(test_frames_follow_edits, harness_check),
    };
    return cmocka_run_group_tests_name("light_reach_frames", tests, test_group_begin, test_group_end);
}
