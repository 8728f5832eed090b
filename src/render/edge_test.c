/* SPDX-License-Identifier: MIT */
/* Scenes at the edge of what a renderer may be given. */
#include "tests/render_harness.h"

static fnl_mesh_id add_quad(fnl_scene *scene, fnl_alpha_mode alpha_mode, float half_width, float half_height, vec3 normal) {
    fnl_material_params material = fnl_material_params_default();
    material.base_color[3] = alpha_mode == FNL_ALPHA_BLEND ? 0.5f : 1;
    material.alpha_mode = alpha_mode;
    material.metallic = 0;
    material.double_sided = true;
    fnl_material_id material_id;
    assert_int_equal(fnl_scene_add_material(scene, &material, &material_id), FNL_OK);
    const float positions[] = {-half_width, -half_height, 0, half_width,  -half_height, 0,
                               half_width,  half_height,  0, -half_width, half_height,  0};
    const vec3 normals[] = {normal, normal, normal, normal};
    const uint32_t indices[] = {0, 1, 2, 0, 2, 3};
    fnl_mesh_id mesh;
    assert_int_equal(fnl_scene_add_mesh(scene,
                                        &(fnl_mesh_params){.vertex_count = 4,
                                                           .index_count = 6,
                                                           .positions = positions,
                                                           .normals = &normals->x,
                                                           .indices = indices,
                                                           .material = material_id},
                                        &mesh),
                     FNL_OK);
    return mesh;
}

static void place(fnl_scene *scene, fnl_mesh_id mesh, mat4 transform) {
    fnl_instance_id instance;
    assert_int_equal(fnl_scene_add_instance(scene, mesh, &transform, &instance), FNL_OK);
}

static void add_light(fnl_scene *scene, vec3 position, float range) {
    fnl_light_params light = fnl_light_params_default();
    light.position = position;
    light.intensity = 100;
    light.range = range;
    fnl_light_id id;
    assert_int_equal(fnl_scene_add_light(scene, &light, &id), FNL_OK);
}

static struct stage open_scene(fnl_scene *scene, vec3 eye) {
    struct stage s = stage_open_scene(scene);
    s.frame.width = s.frame.height = 96;
    s.frame.camera = fnl_camera_default();
    s.frame.camera.position = eye;
    s.frame.camera.target = vec3_add(eye, (vec3){0, 0, -1});
    return s;
}

static void assert_lists_agree(struct stage *s) {
    for (int shading = 0; shading < FNL_SHADING_DEFERRED + 1; shading++) {
        s->frame.shading = (fnl_shading)shading;
        s->frame.lists = FNL_LISTS_ALL;
        struct shot all = stage_shoot(s, &s->frame);
        assert_int_equal(count_broken(&all.radiance), 0);
        for (int lists = 1; lists < FNL_LISTS_COUNT; lists++) {
            s->frame.lists = (fnl_light_lists)lists;
            if (!fnl_shading_supports(s->frame.shading, s->frame.lists, s->frame.msaa)) continue;
            struct shot shot = stage_shoot(s, &s->frame);
            assert_int_equal(count_differing(&all.radiance, &shot.radiance), 0);
            shot_free(&shot);
        }
        shot_free(&all);
    }
}

/* A tile that shows a near pole and sky has a farthest depth, yet glass before the sky stands beyond it. */
static void test_glass_before_sky_in_a_tile_with_a_pole(void **state) {
    UNUSED(state);
    fnl_scene *scene;
    assert_int_equal(fnl_scene_create(NULL, &scene), FNL_OK);
    place(scene, add_quad(scene, FNL_ALPHA_OPAQUE, 0.1f, 10, (vec3){0, 0, 1}), mat4_translation((vec3){0, 0, -5}));
    place(scene, add_quad(scene, FNL_ALPHA_BLEND, 8, 8, (vec3){0, 0, 1}), mat4_translation((vec3){0, 0, -20}));
    add_light(scene, (vec3){0, 0, -18}, 6);
    struct stage s = open_scene(scene, (vec3){0, 0, 0});
    assert_lists_agree(&s);
    s.frame.shading = FNL_SHADING_DEFERRED;
    s.frame.lists = FNL_LISTS_TILED;
    struct shot lit = stage_shoot(&s, &s.frame);
    assert_true(((const float *)lit.radiance.pixels)[(48 * 96 + 53) * 4] > 0.01f); /* the glass beside the pole */
    shot_free(&lit);
    stage_close(&s);
}

/* glTF allows a scale of 0: the normal vanishes, the picture must not. */
static void test_flattened_instance_stays_finite(void **state) {
    UNUSED(state);
    fnl_scene *scene;
    assert_int_equal(fnl_scene_create(NULL, &scene), FNL_OK);
    mat4 flat = mat4_mul(mat4_translation((vec3){0, 0, -3}), mat4_scaling((vec3){1, 1, 0}));
    place(scene, add_quad(scene, FNL_ALPHA_OPAQUE, 1, 1, (vec3){1, 0, 0}), flat); /* its cofactor normal is 0 */
    add_light(scene, (vec3){0, 1, -2}, 10);
    assert_int_equal(fnl_scene_set_ambient(scene, (vec3){100, 100, 100}, (vec3){100, 100, 100}), FNL_OK);
    struct stage s = open_scene(scene, (vec3){0, 0, 0});
    assert_lists_agree(&s);
    for (int shading = 0; shading < FNL_SHADING_DEFERRED + 1; shading++) {
        s.frame.shading = (fnl_shading)shading;
        struct shot shot = stage_shoot(&s, &s.frame);
        const float *values = shot.radiance.pixels;
        for (uint32_t i = 0; i < 96 * 96 * 4; i++)
            assert_true(values[i] < 1e4f); /* a NaN would come out as the greatest float */
        shot_free(&shot);
    }
    stage_close(&s);
}

/* A thousand kilometres from the origin floats have steps of 6 cm. */
static void test_lists_agree_far_from_the_origin(void **state) {
    UNUSED(state);
    const float far = 1e6f;
    fnl_scene *scene;
    assert_int_equal(fnl_scene_create(NULL, &scene), FNL_OK);
    place(scene, add_quad(scene, FNL_ALPHA_OPAQUE, 10, 10, (vec3){0, 0, 1}), mat4_translation((vec3){far, 0, far - 10}));
    struct random_state random = {7};
    for (int i = 0; i < 400; i++)
        add_light(scene, (vec3){far + random_range(&random, -8, 8), random_range(&random, -8, 8), far - 9.5f}, 1.5f);
    struct stage s = open_scene(scene, (vec3){far, 0, far});
    s.frame.width = s.frame.height = 256;
    assert_lists_agree(&s);
    stage_close(&s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_glass_before_sky_in_a_tile_with_a_pole, harness_check),
        cmocka_unit_test_teardown(test_flattened_instance_stays_finite, harness_check),
        cmocka_unit_test_teardown(test_lists_agree_far_from_the_origin, harness_check),
    };
    return cmocka_run_group_tests(tests, harness_begin, harness_end);
}
