/* SPDX-License-Identifier: MIT */
/* Contact shadows against rays of the same length, with other methods, and along every path. */
#include "base/jobs.h"
#include "ray/ray_scene.h"
#include "tests/render_harness.h"

#include <math.h>

enum { WIDTH = 160, HEIGHT = 120 };
#define LENGTH 0.3f
static const fnl_vec3 sun_direction = {0.5f, -0.8f, 0.3f};

static void add_box(fnl_scene *scene, fnl_vec3 middle, fnl_vec3 half, fnl_material_id material) {
    static const uint32_t indices[] = {0, 1, 3, 0, 3, 2};
    float positions[6 * 4 * 3];
    uint32_t all[6 * 6];
    for (uint32_t face = 0; face < 6; face++)
        for (uint32_t corner = 0; corner < 4; corner++) {
            const uint32_t axis = face / 2;
            const float sign = face % 2 ? -1 : 1, across[3] = {sign, corner & 1 ? 1 : -1, corner & 2 ? sign : -sign};
            float *p = positions + (face * 4 + corner) * 3;
            for (uint32_t k = 0; k < 3; k++) p[(axis + k) % 3] = across[k] * (&half.x)[(axis + k) % 3] + (&middle.x)[(axis + k) % 3];
        }
    for (uint32_t i = 0; i < 36; i++) all[i] = i / 6 * 4 + indices[i % 6];
    const fnl_mesh_params mesh = {.vertex_count = 24, .index_count = 36, .positions = positions, .indices = all, .material = material};
    const fnl_mat4 here = {{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}};
    fnl_mesh_id mesh_id;
    fnl_instance_id instance;
    assert_int_equal(fnl_scene_add_mesh(scene, &mesh, &mesh_id), FNL_OK);
    assert_int_equal(fnl_scene_add_instance(scene, mesh_id, &here, &instance), FNL_OK);
}

/* A floor with boxes on it, under the sun or a lamp, and no other light. */
static struct stage open_boxes(bool lamp, float contact_scale) {
    fnl_scene *scene;
    assert_int_equal(fnl_scene_create(gpu_host(harness_device()), &scene), FNL_OK);
    fnl_material_params matt = fnl_material_params_default();
    matt.metallic = 0;
    fnl_material_id material;
    assert_int_equal(fnl_scene_add_material(scene, &matt, &material), FNL_OK);
    add_box(scene, (fnl_vec3){0, -0.5f, 0}, (fnl_vec3){4, 0.5f, 4}, material);
    for (uint32_t i = 0; i < 9; i++)
        add_box(scene, (fnl_vec3){(float)(i % 3) - 1, 0.1f, (float)(i / 3) - 1}, (fnl_vec3){0.12f, 0.1f + 0.05f * (float)(i % 2), 0.2f}, material);
    fnl_light_params light = fnl_light_params_default();
    fnl_light_id id;
    light.kind = lamp ? FNL_LIGHT_POINT : FNL_LIGHT_DIRECTIONAL;
    light.position = (fnl_vec3){-1.5f, 2, -1};
    light.direction = sun_direction;
    light.intensity = lamp ? 20 : 5;
    light.contact_scale = contact_scale;
    assert_int_equal(fnl_scene_add_light(scene, &light, &id), FNL_OK);
    assert_int_equal(fnl_scene_set_ambient(scene, (fnl_vec3){0, 0, 0}, (fnl_vec3){0, 0, 0}), FNL_OK);
    struct stage stage = stage_open_scene(scene);
    stage.frame.width = WIDTH;
    stage.frame.height = HEIGHT;
    stage.frame.outputs = FNL_OUTPUT_RADIANCE | FNL_OUTPUT_POSITION | FNL_OUTPUT_NORMAL;
    stage.frame.camera = fnl_camera_default();
    stage.frame.camera.position = (fnl_vec3){0.4f, 2.2f, 2.6f};
    stage.frame.camera.target = (fnl_vec3){0, 0, 0};
    stage.frame.shading = FNL_SHADING_FORWARD_PREPASS;
    stage.frame.lists = FNL_LISTS_CLUSTERED;
    return stage;
}

static const float *at(const fnl_image *image, uint32_t i) { return (const float *)image->pixels + 4 * (size_t)i; }

/* The part of a pixel's light that is left. */
static float left_of(const struct shot *with, const struct shot *without, uint32_t i) { return at(&with->radiance, i)[1] / at(&without->radiance, i)[1]; }

/* How many of the pixels that rays of the length find hidden or open are found so. */
static void compare_with_rays(bool lamp, bool orthographic) {
    struct stage stage = open_boxes(lamp, 1);
    if (orthographic) { /* from afar: the near plane is many metres away */
        stage.frame.camera.position = (fnl_vec3){4, 22, 26};
        stage.frame.camera.orthographic = true;
        stage.frame.camera.vertical_extent = 3;
        stage.frame.camera.near_distance = 20;
        stage.frame.camera.far_distance = 60;
    }
    struct shot without = stage_shoot(&stage, &stage.frame);
    stage.frame.shadow.contact_length = LENGTH;
    struct shot with = stage_shoot(&stage, &stage.frame);
    struct ray_scene *rays;
    struct ray_walk walk = {0};
    struct jobs *jobs;
    assert_int_equal(jobs_create(gpu_host(harness_device()), &jobs), FNL_OK);
    assert_int_equal(ray_scene_create(stage.scene, FNL_ENERGY_GLTF, jobs, &rays), FNL_OK);
    uint32_t hidden = 0, found = 0, open = 0, kept = 0;
    for (uint32_t i = 0; i < WIDTH * HEIGHT; i++) {
        const float *p = at(&with.position, i), *n = at(&with.normal, i);
        if (!(at(&without.radiance, i)[1] > 0)) continue; /* sky, or turned away */
        const dvec3 normal = dvec3_make((double)n[0], (double)n[1], (double)n[2]), position = dvec3_make((double)p[0], (double)p[1], (double)p[2]),
                    ray = lamp ? dvec3_sub(dvec3_make(-1.5, 2, -1), position) : dvec3_scale(dvec3_make(0.5, -0.8, 0.3), -1), to_light = dvec3_normalize(ray);
        const dvec3 origin = dvec3_add_scaled(position, normal, 1e-3);
        const bool is_hidden = ray_visibility(rays, RAY_LAMP, origin, to_light, 0.6 * (double)LENGTH, &walk) < 0.5,
                   is_open = ray_visibility(rays, RAY_LAMP, origin, to_light, 1.05 * (double)LENGTH, &walk) > 0.5;
        const float left = left_of(&with, &without, i);
        assert_true(left >= 0 && left < 1.001f);
        hidden += is_hidden, found += is_hidden && left < 0.5f;
        open += is_open, kept += is_open && left > 0.5f;
    }
    print_message("%s%s: %u of %u hidden pixels found, %u of %u open ones kept\n", lamp ? "lamp" : "sun", orthographic ? ", orthographic" : "", found, hidden, kept, open);
    assert_true(hidden > 300 && open > 5000);
    assert_true(found > hidden * 0.85);
    assert_true(kept > open * 0.97);
    array_free(gpu_host(harness_device()), &walk.crossed);
    ray_scene_destroy(&rays);
    jobs_destroy(&jobs);
    shot_free(&without);
    shot_free(&with);
    stage_close(&stage);
}

static void test_marches_find_what_rays_of_their_length_find(void **state) {
    UNUSED(state);
    for (int i = 0; i < 4; i++) compare_with_rays(i & 1, i & 2);
}

/* What is in the shadow of either is dark, and the rest as with one of them. */
static void test_contact_shadows_multiply_with_others(void **state) {
    UNUSED(state);
    static const fnl_shadows methods[] = {FNL_SHADOWS_RAYS, FNL_SHADOWS_MAPS, FNL_SHADOWS_HYBRID, FNL_SHADOWS_SAMPLED};
    struct stage stage = open_boxes(true, 1);
    stage.frame.shadow.ray_backend = FNL_RAY_BACKEND_BVH;
    stage.frame.shadow.filter = FNL_SHADOW_FILTER_HARD;
    struct shot open = stage_shoot(&stage, &stage.frame);
    stage.frame.shadow.contact_length = LENGTH;
    struct shot contact = stage_shoot(&stage, &stage.frame);
    for (uint32_t m = 0; m < COUNT_OF(methods); m++) {
        stage.frame.shadows = methods[m];
        stage.frame.shadow.contact_length = 0;
        struct shot alone = stage_shoot(&stage, &stage.frame);
        stage.frame.shadow.contact_length = LENGTH;
        struct shot both = stage_shoot(&stage, &stage.frame);
        uint32_t off = 0, darker = 0;
        for (uint32_t i = 0; i < WIDTH * HEIGHT; i++) {
            const float light = at(&open.radiance, i)[1];
            if (!(light > 0)) continue;
            const float wanted = at(&alone.radiance, i)[1] / light * at(&contact.radiance, i)[1], got = at(&both.radiance, i)[1];
            off += fabsf(got - wanted) > 1e-3f * light;
            darker += got < at(&alone.radiance, i)[1] * 0.5f;
        }
        if (off > (methods[m] == FNL_SHADOWS_MAPS || methods[m] == FNL_SHADOWS_HYBRID ? 40u : 0u))
            fail_msg("%s: %u pixels are not the product", fnl_value_name(FNL_ENUM_SHADOWS, methods[m]), off);
        print_message("%s: %u pixels darker\n", fnl_value_name(FNL_ENUM_SHADOWS, methods[m]), darker);
        shot_free(&alone);
        shot_free(&both);
    }
    shot_free(&open);
    shot_free(&contact);
    stage_close(&stage);
}

/* A light's scale: 0 is none, and 2 with half the length is the length. */
static void test_scale_of_a_light(void **state) {
    UNUSED(state);
    static const float scales[] = {1, 0, 2}, lengths[] = {LENGTH, LENGTH, LENGTH / 2};
    struct shot shots[4];
    for (uint32_t i = 0; i < 4; i++) {
        struct stage stage = open_boxes(true, i < 3 ? scales[i] : 1);
        stage.frame.shadow.contact_length = i < 3 ? lengths[i] : 0;
        shots[i] = stage_shoot(&stage, &stage.frame);
        stage_close(&stage);
    }
    assert_int_equal(count_differing(&shots[1].radiance, &shots[3].radiance), 0);
    assert_true(count_differing(&shots[0].radiance, &shots[3].radiance) > 300);
    assert_true(count_differing(&shots[0].radiance, &shots[2].radiance) < 40);
    for (uint32_t i = 0; i < 4; i++) shot_free(&shots[i]);
}

/* Every path, with one sample and with four, with blended and transmissive surfaces, finds the shadows that forward shading finds. */
static void test_every_path_has_them(void **state) {
    UNUSED(state);
    for (uint32_t msaa = 1; msaa <= 4; msaa += 3) {
        struct stage stage = open_boxes(true, 1);
        stage.frame.msaa = msaa;
        stage.frame.shading = FNL_SHADING_FORWARD;
        struct shot open = stage_shoot(&stage, &stage.frame);
        stage.frame.shadow.contact_length = LENGTH;
        struct shot forward = stage_shoot(&stage, &stage.frame);
        for (fnl_shading shading = 1; shading < FNL_SHADING_AUTO; shading++) {
            stage.frame.shading = shading;
            if (!fnl_shading_supports(shading, stage.frame.lists, msaa)) continue;
            struct shot other = stage_shoot(&stage, &stage.frame);
            uint32_t dark = 0, found = 0;
            for (uint32_t i = 0; i < WIDTH * HEIGHT; i++) {
                const float light = at(&open.radiance, i)[1];
                if (!(at(&forward.radiance, i)[1] < 0.1f * light)) continue;
                dark++;
                found += at(&other.radiance, i)[1] < 0.4f * light;
            }
            assert_true(dark > 300);
            const bool coarse = shading == FNL_SHADING_INFERRED || shading == FNL_SHADING_LOW_RES || shading == FNL_SHADING_COARSE; /* light at fewer points */
            if (found < dark * (coarse ? 0.5 : 0.85)) fail_msg("%s with %u samples: %u of %u dark pixels", fnl_value_name(FNL_ENUM_SHADING, shading), msaa, found, dark);
            shot_free(&other);
        }
        shot_free(&open);
        shot_free(&forward);
        stage_close(&stage);
    }
    struct stage glass = stage_open("builtin:glass?lights=20", 0);
    glass.frame.lists = FNL_LISTS_CLUSTERED;
    glass.frame.width = 240;
    glass.frame.height = 135;
    for (fnl_shading shading = 0; shading < FNL_SHADING_AUTO; shading++) { /* validation watches */
        if (!fnl_shading_supports(shading, glass.frame.lists, 1)) continue;
        glass.frame.shading = shading;
        glass.frame.shadow.contact_length = 0;
        struct shot without = stage_shoot(&glass, &glass.frame);
        glass.frame.shadow.contact_length = 3;
        struct shot with = stage_shoot(&glass, &glass.frame);
        const uint64_t changed = count_differing(&without.radiance, &with.radiance);
        if (changed < 25) fail_msg("%s: contact shadows change %u pixels of glass", fnl_value_name(FNL_ENUM_SHADING, shading), (uint32_t)changed);
        assert_int_equal(count_broken(&with.radiance), 0);
        shot_free(&without);
        shot_free(&with);
    }
    stage_close(&glass);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_marches_find_what_rays_of_their_length_find, harness_check),
        cmocka_unit_test_teardown(test_contact_shadows_multiply_with_others, harness_check),
        cmocka_unit_test_teardown(test_scale_of_a_light, harness_check),
        cmocka_unit_test_teardown(test_every_path_has_them, harness_check),
    };
    return cmocka_run_group_tests(tests, harness_begin, harness_end);
}
