/* SPDX-License-Identifier: MIT */
/* What single lights say of their shadows: whether they cast any. With rays, maps and the tracer. */
#include "tests/render_harness.h"
#include "tests/shadow_cases.h"

enum { SIZE = 40 };

/* ---- a light of each kind over a floor that a half-plane covers from above ---- */

static fnl_light_params lamp_of(fnl_light_kind kind) {
    fnl_light_params lamp = fnl_light_params_default();
    lamp.kind = kind;
    lamp.position = (vec3){0, kind == FNL_LIGHT_BOX ? 1.5f : 3, 0};
    lamp.direction = kind == FNL_LIGHT_CAPSULE ? (vec3){1, 0, 0} : (vec3){0, -1, 0};
    lamp.up = (vec3){0, 0, 1};
    lamp.intensity = 20;
    if (kind != FNL_LIGHT_DIRECTIONAL && kind != FNL_LIGHT_BOX) lamp.range = 20;
    lamp.outer_cone_angle = lamp.inner_cone_angle = 1.2f;
    lamp.wedge_angles[0] = lamp.wedge_angles[1] = 1.1f;
    lamp.box_size = (vec3){8, 8, 4}; /* from below the floor */
    lamp.inner_fraction = 1;
    return lamp;
}

/* The half-plane covers x > 0, a metre above the floor. */
static fnl_scene *half_covered(const fnl_light_params *lamp, fnl_light_id *out) {
    fnl_scene *scene = world_create(NULL);
    const fnl_material_params white = matt(1);
    add_square(scene, &white, (vec3){10, 1, 10}, (vec3){0, 0, 0});
    add_square(scene, &white, (vec3){10, 1, 10}, (vec3){10, 1, 0});
    assert_int_equal(fnl_scene_add_light(scene, lamp, out), FNL_OK);
    return scene;
}

static struct stage open_half_covered(const fnl_light_params *lamp, fnl_light_id *out) {
    struct stage s = stage_open_scene(half_covered(lamp, out));
    s.frame.width = s.frame.height = SIZE;
    s.frame.camera = look_down((vec3){0, 0, 0}, 3, 0.5f, SIZE).camera; /* from below the half-plane */
    s.frame.outputs = FNL_OUTPUT_RADIANCE;
    return s;
}

static fnl_trace trace_of(const struct stage *s, uint32_t samples) {
    fnl_trace_params p = look_down((vec3){0, 0, 0}, 3, 0.5f, SIZE);
    p.visibility = true;
    p.samples = samples;
    return trace_scene(s->scene, &p);
}

/* ---- lights that cast none ---- */

static void test_lights_that_cast_no_shadow(void **state) {
    UNUSED(state);
    for (fnl_light_kind kind = 0; kind < FNL_LIGHT_KIND_COUNT; kind++) {
        const char *name = fnl_value_name(FNL_ENUM_LIGHT_KIND, kind);
        fnl_light_params lamp = lamp_of(kind);
        fnl_light_id id;
        struct stage s = open_half_covered(&lamp, &id);
        struct shot open = stage_shoot(&s, &s.frame);
        for (int casts = 1; casts >= 0; casts--) { /* the light changes its mind between frames */
            lamp.casts_shadows = casts;
            assert_int_equal(fnl_scene_set_light(s.scene, id, &lamp), FNL_OK);
            for (fnl_shadows shadows = FNL_SHADOWS_RAYS; shadows <= FNL_SHADOWS_MAPS; shadows++) {
                s.frame.shadows = shadows;
                struct shot shot = stage_shoot(&s, &s.frame);
                const uint64_t differing = count_differing(&open.radiance, &shot.radiance);
                if (casts ? differing < SIZE * SIZE / 3 : differing > 0)
                    fail_msg("%s, shadows %s %s: %u pixels differ", name, casts ? "cast" : "not cast", fnl_value_name(FNL_ENUM_SHADOWS, shadows),
                             (uint32_t)differing);
                if (shadows == FNL_SHADOWS_MAPS && kind != FNL_LIGHT_DIRECTIONAL && kind != FNL_LIGHT_CAPSULE)
                    assert_int_equal(counter(&shot.stats, "shadows.wanted") > 0, casts);
                shot_free(&shot);
            }
            fnl_trace trace = trace_of(&s, 1);
            const double mean = mean_of(&trace.visibility, 0);
            if (casts ? mean > 0.7 : mean < 1) fail_msg("%s: the tracer lets %g through", name, mean);
            fnl_trace_free(NULL, &trace);
        }
        shot_free(&open);
        stage_close(&s);
    }
}

/* Without a light that casts a shadow of which maps know nothing, the trees of rays hold no triangles. */
static void test_rays_are_made_for_lights_that_cast(void **state) {
    UNUSED(state);
    for (int casts = 0; casts < 2; casts++) {
        fnl_light_params lamp = lamp_of(FNL_LIGHT_DIRECTIONAL);
        fnl_light_id id;
        struct stage s = open_half_covered(&lamp, &id);
        lamp = lamp_of(FNL_LIGHT_CAPSULE);
        lamp.casts_shadows = casts;
        assert_int_equal(fnl_scene_add_light(s.scene, &lamp, &id), FNL_OK);
        s.frame.shadows = FNL_SHADOWS_MAPS;
        assert_int_equal(fnl_renderer_render(s.renderer, &s.frame), FNL_OK);
        assert_int_equal(s.renderer->device_scene->ray_meshes.handle != VK_NULL_HANDLE, casts);
        stage_close(&s);
    }
}

/* In all shading paths: where no light casts a shadow, there is none. */
static void test_paths_know_lights_that_cast_none(void **state) {
    UNUSED(state);
    struct stage s = stage_open("builtin:interior?lights=40", 0);
    s.frame.width = 64, s.frame.height = 36, s.frame.ev = 1;
    for (uint32_t i = 0; i < s.scene->lights.count; i++) s.scene->lights.data[i].params.casts_shadows = false;
    for (fnl_shading shading = FNL_SHADING_FORWARD; shading < FNL_SHADING_AUTO; shading++) {
        s.frame.shading = shading;
        s.frame.shadows = FNL_SHADOWS_OFF;
        struct shot open = stage_shoot(&s, &s.frame);
        for (fnl_shadows shadows = FNL_SHADOWS_RAYS; shadows <= FNL_SHADOWS_MAPS; shadows++) {
            s.frame.shadows = shadows;
            struct shot shot = stage_shoot(&s, &s.frame);
            if (greatest_difference(&open.color, &shot.color) > 1)
                fail_msg("%s, %s", fnl_value_name(FNL_ENUM_SHADING, shading), fnl_value_name(FNL_ENUM_SHADOWS, shadows));
            shot_free(&shot);
        }
        shot_free(&open);
    }
    stage_close(&s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_lights_that_cast_no_shadow, harness_check),
        cmocka_unit_test_teardown(test_rays_are_made_for_lights_that_cast, harness_check),
        cmocka_unit_test_teardown(test_paths_know_lights_that_cast_none, harness_check),
    };
    return cmocka_run_group_tests_name("shadow_lights", tests, harness_begin, harness_end);
}
