/* SPDX-License-Identifier: MIT */
/** Light has no unit of its own: a scene whose light is multiplied by a power of two gives the same radiance times that power, by every path and effect. */
#include "render/orders/order.h"
#include "tests/render_test.h"

enum { WIDTH = 40, HEIGHT = 24, POWER = 20 };

/* All that gives light. */
static void scale_lights(fnl_scene *scene, float factor) {
    fnl_entity_info entity;
    fnl_light_params light;
    for (uint32_t i = 0; i < fnl_scene_count(scene, FNL_ENTITY_LIGHT); i++) {
        assert_int_equal(fnl_scene_query_entity(scene, FNL_ENTITY_LIGHT, i, &entity), FNL_OK);
        assert_int_equal(fnl_scene_query_light(scene, i, &light), FNL_OK);
        light.intensity *= factor;
        assert_int_equal(fnl_scene_set_light(scene, entity.id.light, &light), FNL_OK);
    }
}

static void add_glow(fnl_scene *scene, float factor) {
    fnl_material_params glow;
    fnl_entity_info entity;
    assert_int_equal(fnl_scene_query_entity(scene, FNL_ENTITY_MATERIAL, 0, &entity), FNL_OK);
    assert_int_equal(fnl_scene_query_material(scene, 0, &glow), FNL_OK);
    glow.emissive[0] = factor, glow.emissive[2] = 0.5f * factor;
    assert_int_equal(fnl_scene_set_material(scene, entity.id.material, &glow), FNL_OK);
    assert_int_equal(fnl_scene_set_ambient(scene, (fnl_vec3){0.1f * factor, 0.2f * factor, 0.3f * factor}, (fnl_vec3){0.1f * factor, 0.1f * factor, 0.1f * factor}), FNL_OK);
    assert_int_equal(fnl_scene_set_background(scene, (fnl_vec3){0.05f * factor, 0.04f * factor, 0.03f * factor}), FNL_OK);
}

/* What shows what is behind it: all of its second material. */
static void make_glass(fnl_scene *scene) {
    fnl_material_params glass;
    fnl_entity_info entity;
    assert_int_equal(fnl_scene_query_entity(scene, FNL_ENTITY_MATERIAL, 1, &entity), FNL_OK);
    assert_int_equal(fnl_scene_query_material(scene, 1, &glass), FNL_OK);
    glass.alpha_mode = FNL_ALPHA_OPAQUE;
    glass.metallic = 0;
    glass.transmission.strength = 1;
    assert_int_equal(fnl_scene_set_material(scene, entity.id.material, &glass), FNL_OK);
}

static struct stage open_scaled(int power, bool surrounded) {
    struct stage s = stage_open("builtin:glass?lights=8", 0);
    const float factor = ldexpf(1, power);
    scale_lights(s.scene, factor);
    add_glow(s.scene, factor);
    make_glass(s.scene);
    if (surrounded) {
        fnl_environment_params environment = fnl_environment_params_default();
        environment.source = "builtin:overcast";
        environment.intensity = 0.5f * factor; /* a million at most */
        assert_int_equal(fnl_scene_set_environment(s.scene, &environment), FNL_OK);
    }
    s.frame.width = WIDTH, s.frame.height = HEIGHT;
    s.frame.outputs = FNL_OUTPUT_RADIANCE;
    s.frame.exposure = FNL_EXPOSURE_EV;
    s.frame.lists = FNL_LISTS_CLUSTERED;
    return s;
}

/* `two` is the picture of 2^`power` times the light. Halves and packed formats round otherwise near their limits. */
static void compare(const char *name, const fnl_image *one, const fnl_image *two, int power) {
    const float *a = one->pixels, *b = two->pixels;
    double most = 0, sum = 0;
    for (size_t i = 0; i < (size_t)WIDTH * HEIGHT * 4; i++) {
        if (i % 4 == 3) continue;
        sum += (double)a[i];
        most = fmax(most, fabs(ldexp((double)b[i], -power) - (double)a[i]) / fmax((double)a[i], 0.01));
    }
    assert_true(sum > 1);
    if (!(most <= 0.002)) fail_msg("%s: 2^%d times the light changes a pixel by %.4f of itself", name, power, most);
}

struct variant {
    const char *name;
    void (*change)(fnl_frame *frame);
    bool surrounded, probes;
    uint32_t frames;
};

static void shoot_variant(const struct variant *v, fnl_shading shading, int power, fnl_image *out) {
    struct stage s = open_scaled(power, v->surrounded);
    if (v->probes) {
        fnl_probe_params probe = fnl_probe_params_default();
        fnl_probe_id id;
        probe.reflection = true;
        probe.face_size = 16;
        probe.half_size = (fnl_vec3){20, 20, 20};
        probe.capture = (fnl_vec3){0, 2, 0};
        assert_int_equal(fnl_scene_add_probe(s.scene, &probe, &id), FNL_OK);
    }
    s.frame.shading = shading;
    if (!fnl_shading_supports(shading, s.frame.lists, 1)) s.frame.lists = FNL_LISTS_ALL;
    s.frame.ev = 5 + (float)power; /* `mobile` and temporal antialiasing go by what the exposure makes white */
    if (v->change) v->change(&s.frame);
    for (uint32_t i = 1; i < v->frames; i++) assert_int_equal(fnl_renderer_render(s.renderer, &s.frame), FNL_OK);
    struct shot shot = stage_shoot(&s, &s.frame);
    assert_true(counter(&shot.stats, "transmission.fragments") > 0);
    *out = shot.radiance;
    shot.radiance = (fnl_image){0};
    shot_free(&shot);
    stage_close(&s);
}

static void try_variant(const struct variant *v, fnl_shading shading) {
    char name[80];
    snprintf(name, sizeof name, "%s, %s", fnl_value_name(FNL_ENUM_SHADING, shading), v->name);
    fnl_image one, scaled;
    shoot_variant(v, shading, 0, &one);
    for (int power = -POWER; power <= POWER; power += 2 * POWER) {
        shoot_variant(v, shading, power, &scaled);
        compare(name, &one, &scaled, power);
        free_picture(&scaled);
    }
    free_picture(&one);
}

static void test_paths_know_no_unit_of_light(void **state) {
    UNUSED(state);
    static const struct variant plain = {.name = "glass"};
    for (uint32_t s = 0; s < FNL_SHADING_AUTO; s++) try_variant(&plain, (fnl_shading)s);
}

static void change_weighted(fnl_frame *frame) { frame->transparency = FNL_TRANSPARENCY_WEIGHTED; }
static void change_linked(fnl_frame *frame) { frame->transparency = FNL_TRANSPARENCY_LINKED; }
static void change_taa(fnl_frame *frame) { frame->aa = FNL_ANTIALIASING_TAA; }
static void change_sampled(fnl_frame *frame) { frame->shadows = FNL_SHADOWS_SAMPLED; }
static void change_msaa(fnl_frame *frame) { frame->msaa = 4; }

static void test_effects_know_no_unit_of_light(void **state) {
    UNUSED(state);
    const struct variant variants[] = {
        {"weighted transparency", change_weighted, false, false, 1}, {"linked transparency", change_linked, false, false, 1},
        {"an environment", NULL, true, false, 1},                    {"probes", NULL, true, true, 1},
        {"probes in ambient light", NULL, false, true, 1},           {"samples", change_msaa, false, false, 1},
        {"temporal antialiasing", change_taa, false, false, 3},      {"denoised shadows", change_sampled, false, false, 2},
    };
    fnl_device_info info;
    assert_int_equal(fnl_device_query_info(harness_device(), &info), FNL_OK);
    for (uint32_t i = 0; i < COUNT_OF(variants); i++) {
        if (variants[i].change == change_msaa && !(info.msaa_counts & 4)) continue;
        if (variants[i].change == change_sampled && !info.ray_query) continue;
        try_variant(&variants[i], FNL_SHADING_DEFERRED);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_paths_know_no_unit_of_light, harness_check),
        cmocka_unit_test_teardown(test_effects_know_no_unit_of_light, harness_check),
    };
    return cmocka_run_group_tests_name("light_scale", tests, test_group_begin, test_group_end);
}
