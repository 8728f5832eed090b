/* SPDX-License-Identifier: MIT */
/* The public calls of fanal/scene.h, their misuse, and what a renderer follows. */
#include "tests/gltf_test_file.h"

#include <float.h>
#include <setjmp.h>

#include <cmocka.h>

static struct test_log test_lines;

static fnl_scene *make_scene(void) {
    fnl_scene *scene = NULL;
    fnl_host host = test_host(&test_lines);
    assert_int_equal(fnl_scene_create(&host, &scene), FNL_OK);
    return scene;
}

static fnl_mesh_params triangle(void) {
    static const float positions[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    static const uint32_t indices[3] = {0, 1, 2};
    return (fnl_mesh_params){.vertex_count = 3, .index_count = 3, .positions = positions, .indices = indices};
}

/** The call must fail as misuse and log what is wrong. */
static void expect_misuse(fnl_result result, const char *words) {
    assert_int_equal(result, FNL_ERROR_INVALID);
    if (!strstr(test_lines.text, words)) fail_msg("no '%s' in:\n%s", words, test_lines.text);
    test_lines.length = 0;
    test_lines.text[0] = 0;
}

static void test_misuse_is_named(void **state) {
    UNUSED(state);
    fnl_scene *scene = make_scene();
    fnl_host host = test_host(&test_lines);
    const fnl_mat4 identity = mat4_identity();
    fnl_image_id image;
    fnl_material_id material;
    fnl_mesh_id mesh;
    fnl_instance_id instance;
    fnl_light_id light;
    fnl_image picture = {.width = 1, .height = 1, .format = FNL_PIXEL_FORMAT_RGBA16, .pixels = &picture};
    expect_misuse(fnl_scene_add_image(scene, &picture, true, &image), "fnl_scene_add_image: image.format is 1, must be FNL_PIXEL_FORMAT_RGBA8");
    expect_misuse(fnl_scene_add_image(scene, NULL, true, &image), "image is NULL");
    picture = (fnl_image){.width = 0, .height = 1, .format = FNL_PIXEL_FORMAT_RGBA8, .pixels = &picture};
    expect_misuse(fnl_scene_add_image(scene, &picture, true, &image), "image.width is 0, must be 1 .. 32768");

    fnl_material_params look = fnl_material_params_default();
    look.metallic = NAN;
    expect_misuse(fnl_scene_add_material(scene, &look, &material), "fnl_scene_add_material: metallic is NaN, must be 0 .. 1");
    look = fnl_material_params_default();
    look.ior = 0.5f;
    expect_misuse(fnl_scene_add_material(scene, &look, &material), "ior is 0.5, must be 0, or at least 1");
    look = fnl_material_params_default();
    look.normal_image = (fnl_image_id){0, 1};
    expect_misuse(fnl_scene_add_material(scene, &look, &material), "normal_image (index 0, generation 1) must be the id of an image");

    fnl_mesh_params shape = triangle();
    shape.positions = NULL;
    expect_misuse(fnl_scene_add_mesh(scene, &shape, &mesh), "positions is NULL");
    shape = triangle();
    shape.indices = (const uint32_t[]){0, 1, 3};
    expect_misuse(fnl_scene_add_mesh(scene, &shape, &mesh), "indices[2] is 3, must be below vertex_count, 3");
    shape = triangle();
    shape.index_count = 2;
    expect_misuse(fnl_scene_add_mesh(scene, &shape, &mesh), "index_count is 2, must be a multiple of 3");
    shape = triangle();
    shape.positions = (const float[]){0, 0, 0, 1, 0, 0, 0, INFINITY, 0};
    expect_misuse(fnl_scene_add_mesh(scene, &shape, &mesh), "positions[7] is infinity, must be finite");
    shape = triangle();
    shape.material = (fnl_material_id){5, 1};
    expect_misuse(fnl_scene_add_mesh(scene, &shape, &mesh), "material (index 5, generation 1)");
    expect_misuse(fnl_scene_add_instance(scene, (fnl_mesh_id){0, 1}, &identity, &instance),
                  "mesh (index 0, generation 1) must be the id of a mesh");

    fnl_light_params lamp = fnl_light_params_default();
    lamp.range = 0;
    expect_misuse(fnl_scene_add_light(scene, &lamp, &light), "range is 0, must be above 0 metres");
    lamp = fnl_light_params_default();
    lamp.kind = FNL_LIGHT_SPOT;
    lamp.inner_cone_angle = 1;
    expect_misuse(fnl_scene_add_light(scene, &lamp, &light), "inner_cone_angle is 1, must be 0 .. 0.785398");
    expect_misuse(fnl_scene_set_ambient(scene, vec3_make(-1, 0, 0), vec3_make(0, 0, 0)), "sky.x is -1, must be at least 0 cd/m^2");
    expect_misuse(fnl_scene_set_background(scene, vec3_make(NAN, 0, 0)), "radiance.x is NaN");
    fnl_camera camera = fnl_camera_default();
    camera.target = camera.position;
    expect_misuse(fnl_scene_add_camera(scene, "c", &camera), "target is the position");
    uint32_t index;
    expect_misuse(fnl_scene_find(scene, FNL_ENTITY_CAMERA, "c", &index), "there is no 'c' among the 0 cameras");
    expect_misuse(fnl_scene_query_camera(scene, 0, &camera), "index is 0, but there are no cameras");
    expect_misuse(fnl_scene_query_framing_camera(scene, 0, &camera), "aspect is 0, must be above 0 and finite");
    expect_misuse(fnl_scene_query_image(scene, 0, &(fnl_image_info){0}), "index is 0, but there are no images");
    fnl_scene *loaded;
    expect_misuse(fnl_scene_load(&host, NULL, NULL, &loaded), "source is NULL");
    expect_misuse(fnl_scene_load(&host, "x.glb", NULL, NULL), "out is NULL");
    assert_int_equal(fnl_scene_add_light(NULL, &lamp, &light), FNL_ERROR_INVALID);
    assert_null(fnl_scene_message(NULL, 0));
    assert_null(loaded);
    fnl_scene_destroy(&scene);
    fnl_scene_destroy(NULL);
}

static void test_ids_of_removed_things_are_recognised(void **state) {
    UNUSED(state);
    fnl_scene *scene = make_scene();
    fnl_mesh_params shape = triangle();
    fnl_mesh_id mesh;
    fnl_instance_id first, second;
    const fnl_mat4 identity = mat4_identity();
    assert_int_equal(fnl_scene_add_mesh(scene, &shape, &mesh), FNL_OK);
    assert_int_equal(fnl_scene_add_instance(scene, mesh, &identity, &first), FNL_OK);
    assert_int_equal(fnl_scene_remove_instance(scene, first), FNL_OK);
    expect_misuse(fnl_scene_remove_instance(scene, first), "must be");
    assert_int_equal(fnl_scene_add_instance(scene, mesh, &identity, &second), FNL_OK);
    assert_int_equal(second.index, first.index); /* the hole is used again, under a new generation */
    expect_misuse(fnl_scene_set_instance_transform(scene, first, &identity), "must be");
    assert_int_equal(fnl_scene_set_instance_transform(scene, second, &identity), FNL_OK);
    expect_misuse(fnl_scene_remove_instance(scene, (fnl_instance_id){0, 0}), "must be");

    fnl_light_params lamp = fnl_light_params_default();
    fnl_light_id lights[3], other;
    for (uint32_t i = 0; i < 3; i++) {
        lamp.intensity = (float)i;
        assert_int_equal(fnl_scene_add_light(scene, &lamp, &lights[i]), FNL_OK);
    }
    assert_int_equal(fnl_scene_remove_light(scene, lights[0]), FNL_OK);
    expect_misuse(fnl_scene_set_light(scene, lights[0], &lamp), "must be the id of a light");
    fnl_scene_info info;
    assert_int_equal(fnl_scene_query_info(scene, &info), FNL_OK);
    assert_int_equal(info.light_count, 2);
    for (uint32_t i = 0; i < 2; i++) { /* queries count past the hole */
        assert_int_equal(fnl_scene_query_light(scene, i, &lamp), FNL_OK);
        assert_true(lamp.intensity == (float)i + 1);
    }
    expect_misuse(fnl_scene_query_light(scene, 2, &lamp), "index is 2, must be 0 .. 1: there are 2 lights");
    assert_int_equal(fnl_scene_add_light(scene, &lamp, &other), FNL_OK);
    assert_true(other.index == lights[0].index && other.generation != lights[0].generation);
    fnl_scene_destroy(&scene);
}

/** Whoever has seen a version at or after moved_since finds every later move in the list. */
static void test_moves_can_be_followed(void **state) {
    UNUSED(state);
    enum { COUNT = 5000 };
    fnl_scene *scene = make_scene();
    fnl_mesh_params shape = triangle();
    fnl_mesh_id mesh;
    static fnl_instance_id instances[COUNT];
    fnl_mat4 transform = mat4_identity();
    assert_int_equal(fnl_scene_add_mesh(scene, &shape, &mesh), FNL_OK);
    for (uint32_t i = 0; i < COUNT; i++)
        assert_int_equal(fnl_scene_add_instance(scene, mesh, &transform, &instances[i]), FNL_OK);
    struct random_state random = {1};
    static float seen[COUNT];
    uint64_t version = scene->transform_version;
    uint32_t full_reads = 0;
    for (uint32_t frame = 0; frame < 400; frame++) {
        for (uint32_t i = 0; i < 50; i++) {
            transform.m[12] = random_float(&random) + 1;
            uint32_t which = (uint32_t)(random_bits(&random) % COUNT);
            assert_int_equal(fnl_scene_set_instance_transform(scene, instances[which], &transform), FNL_OK);
        }
        if (version < scene->moved_since) {
            full_reads++;
            for (uint32_t i = 0; i < COUNT; i++) seen[i] = scene->nodes.data[i].world.m[12];
        } else {
            for (uint32_t i = 0; i < scene->moved.count; i++) {
                uint32_t node = scene->moved.data[i];
                if (scene->nodes.data[node].moved_version > version) seen[node] = scene->nodes.data[node].world.m[12];
            }
        }
        version = scene->transform_version;
        for (uint32_t i = 0; i < COUNT; i++) assert_true(seen[i] == scene->nodes.data[i].world.m[12]);
        assert_true(scene->moved.count <= 1024 + COUNT / 16);
    }
    assert_true(full_reads > 0 && full_reads < 40);
    fnl_scene_destroy(&scene);
}

static void test_children_follow_their_parents(void **state) {
    UNUSED(state);
    fnl_scene *scene = make_scene();
    mat4 up = mat4_translation(vec3_make(0, 1, 0));
    uint32_t parent = scene_add_node(scene, "", SCENE_NONE, &up, SCENE_NONE),
             child = scene_add_node(scene, "", parent, &up, SCENE_NONE);
    uint32_t other = scene_add_node(scene, "", SCENE_NONE, &up, SCENE_NONE);
    fnl_light_params lamp = fnl_light_params_default();
    uint32_t light = scene_add_light(scene, &lamp, child);
    assert_true(scene->nodes.data[child].world.m[13] == 2 && scene->lights.data[light].params.position.y == 2);
    scene_update_transforms(scene);
    uint64_t version = scene->transform_version, light_version = scene->light_version;
    scene->nodes.data[parent].local =
        mat4_mul(mat4_from_trs(vec3_make(5, 0, 0), quat_axis_angle(vec3_make(0, 1, 0), PI / 2), vec3_make(1, 1, 1)), up);
    scene_update_transforms(scene);
    assert_int_equal(scene->transform_version, version + 1);
    assert_int_equal(scene->moved.count, 2);
    assert_true(scene->nodes.data[other].moved_version <= version && scene->light_version > light_version);
    assert_true(vec3_distance(scene->lights.data[light].params.position, vec3_make(5, 2, 0)) < 1e-5f);
    assert_true(vec3_distance(scene->lights.data[light].params.direction, vec3_make(-1, 0, 0)) < 1e-5f);
    scene_update_transforms(scene);
    assert_int_equal(scene->transform_version, version + 1);
    fnl_scene_destroy(&scene);
}

/** All corners of the bounds project into the picture, and some comes near its edge. */
/* Squares of such lengths overflow. */
static void test_framing_camera_of_the_largest_scene(void **state) {
    UNUSED(state);
    static const float sides[] = {1e20f, -1e30f, FLT_MAX};
    for (uint32_t i = 0; i < COUNT_OF(sides); i++) {
        fnl_scene *scene;
        fnl_camera camera;
        fnl_light_params light = fnl_light_params_default();
        fnl_light_id id;
        assert_int_equal(fnl_scene_create(NULL, &scene), FNL_OK);
        assert_int_equal(fnl_scene_add_light(scene, &light, &id), FNL_OK);
        light.position = vec3_make(0, sides[i], sides[i]);
        assert_int_equal(fnl_scene_add_light(scene, &light, &id), FNL_OK);
        assert_int_equal(fnl_scene_query_framing_camera(scene, 1.5f, &camera), FNL_OK);
        assert_true(vec3_finite(camera.position) && vec3_finite(camera.target) && isfinite(camera.far_distance));
        assert_true(camera.near_distance > 0 && camera.near_distance < camera.far_distance);
        fnl_scene_destroy(&scene);
    }
}

static void test_framing_camera_shows_everything(void **state) {
    UNUSED(state);
    static const float scales[] = {1e-3f, 1, 1e4f}, aspects[] = {0.3f, 1, 3};
    for (uint32_t s = 0; s < COUNT_OF(scales); s++)
        for (uint32_t a = 0; a < COUNT_OF(aspects); a++) {
            fnl_scene *scene = make_scene();
            fnl_mesh_params shape = triangle();
            fnl_mesh_id mesh;
            fnl_instance_id instance;
            fnl_mat4 transform = mat4_from_trs(vec3_make(scales[s] * 3, 0, 0), quat_axis_angle(vec3_make(1, 0, 0), 1),
                                               vec3_make(scales[s], scales[s] * 7, 1));
            assert_int_equal(fnl_scene_add_mesh(scene, &shape, &mesh), FNL_OK);
            assert_int_equal(fnl_scene_add_instance(scene, mesh, &transform, &instance), FNL_OK);
            fnl_camera camera;
            assert_int_equal(fnl_scene_query_framing_camera(scene, aspects[a], &camera), FNL_OK);
            mat4 view = mat4_look_at(camera.position, camera.target, camera.up);
            struct box bounds = scene_bounds(scene);
            float tan_y = tanf(camera.vertical_fov / 2), widest = 0;
            for (int corner = 0; corner < 8; corner++) {
                vec3 p = mat4_point(&view, vec3_make(corner & 1 ? bounds.high.x : bounds.low.x,
                                                     corner & 2 ? bounds.high.y : bounds.low.y,
                                                     corner & 4 ? bounds.high.z : bounds.low.z));
                assert_true(-p.z > camera.near_distance);
                widest = fmaxf(widest, fmaxf(fabsf(p.x) / (-p.z * tan_y * aspects[a]), fabsf(p.y) / (-p.z * tan_y)));
            }
            assert_true(widest < 1 && widest > 0.9f);
            fnl_scene_destroy(&scene);
        }
    fnl_scene *empty = make_scene();
    fnl_camera camera;
    assert_int_equal(fnl_scene_query_framing_camera(empty, 1, &camera), FNL_OK);
    assert_true(camera.near_distance > 0 && vec3_finite(camera.position));
    fnl_scene_destroy(&empty);
}

static void test_added_things_are_counted(void **state) {
    UNUSED(state);
    fnl_scene *scene = make_scene();
    uint8_t pixels[8] = {1, 2, 3, 4, 5, 6, 7, 8};
    fnl_image picture = {.width = 2, .height = 1, .format = FNL_PIXEL_FORMAT_RGBA8, .pixels = pixels};
    fnl_image_id image;
    fnl_material_id material;
    fnl_mesh_id mesh;
    fnl_instance_id instance;
    uint64_t version = scene->structure_version;
    assert_int_equal(fnl_scene_add_image(scene, &picture, true, &image), FNL_OK);
    pixels[0] = 99; /* a copy was made */
    assert_int_equal(scene->images.data[0].pixels[0], 1);
    fnl_material_params look = fnl_material_params_default();
    look.base_color_image = image;
    assert_int_equal(fnl_scene_add_material(scene, &look, &material), FNL_OK);
    fnl_mesh_params shape = triangle();
    shape.material = material;
    assert_int_equal(fnl_scene_add_mesh(scene, &shape, &mesh), FNL_OK);
    fnl_mat4 transform = mat4_translation(vec3_make(0, 0, 4));
    for (int i = 0; i < 3; i++) assert_int_equal(fnl_scene_add_instance(scene, mesh, &transform, &instance), FNL_OK);
    fnl_scene_info info;
    assert_int_equal(fnl_scene_query_info(scene, &info), FNL_OK);
    assert_true(info.triangle_count == 3 && info.unique_triangle_count == 1 && info.instance_count == 3 &&
                info.node_count == 3);
    assert_true(info.bounds_low.z == 4 && info.bounds_high.x == 1 && scene->structure_version > version);
    assert_int_equal(scene->materials.data[0].textures[SCENE_TEXTURE_BASE_COLOR].image, 0);
    assert_non_null(scene->primitives.data[0].normals); /* generated */
    assert_true(scene->primitives.data[0].normals[0].z == 1);
    fnl_scene_destroy(&scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_misuse_is_named),
        cmocka_unit_test(test_ids_of_removed_things_are_recognised),
        cmocka_unit_test(test_moves_can_be_followed),
        cmocka_unit_test(test_children_follow_their_parents),
        cmocka_unit_test(test_framing_camera_shows_everything),
        cmocka_unit_test(test_framing_camera_of_the_largest_scene),
        cmocka_unit_test(test_added_things_are_counted),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
