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
    const mat4 turned = mat4_mul(mat4_from_trs(vec3_make(5, 0, 0), quat_axis_angle(vec3_make(0, 1, 0), PI / 2), vec3_make(1, 1, 1)), up);
    scene->nodes.data[parent].local_exact = affine_from_mat4(&turned, scene->origin);
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

/* How far points reach from the middle of a picture of this camera, as parts of half its width and height; each must be in front of the near plane. */
static void expect_framed(const fnl_camera *camera, float aspect, const vec3 *points, uint32_t count) {
    const mat4 view = mat4_look_at(camera->position, camera->target, camera->up);
    const double tan_y = tan((double)camera->vertical_fov / 2);
    double low[2] = {2, 2}, high[2] = {-2, -2};
    for (uint32_t i = 0; i < count; i++) {
        const vec3 p = mat4_point(&view, points[i]);
        assert_true(-p.z > camera->near_distance);
        const double at[2] = {(double)p.x / ((double)-p.z * tan_y * (double)aspect), (double)p.y / ((double)-p.z * tan_y)};
        for (int axis = 0; axis < 2; axis++) low[axis] = fmin(low[axis], at[axis]), high[axis] = fmax(high[axis], at[axis]);
    }
    /* One axis is filled, and on it both edges are equally far away; nothing reaches farther on the other. */
    const bool by_width = high[0] - low[0] > high[1] - low[1];
    const double fill = (high[!by_width] - low[!by_width]) / 2, least = fmin(low[0], low[1]), most = fmax(high[0], high[1]);
    if (fill < 0.795 || fill > 0.805 || least < -0.81 || most > 0.81)
        fail_msg("aspect %g, %u points, from %g %g %g: it fills %g x %g of the picture, from %g to %g", (double)aspect, count, (double)points[0].x, (double)points[2].y, (double)points[2].z, (high[0] - low[0]) / 2, (high[1] - low[1]) / 2, least, most);
}

/* What is in no triangle, of no size, or a light does not count; nor does how large things are, or how far from the origin. */
static void test_framing_camera_fills_the_picture(void **state) {
    UNUSED(state);
    static const float scales[] = {4e-5f, 1, 1e4f, 4e9f}, aspects[] = {0.3f, 1, 16 / 9.0f, 3};
    static const vec3 sides[] = {{1, 1, 1}, {0.1f, 7, 0.1f}, {0.1f, 0.2f, 9}, {8, 0.5f, 0.3f}, {5, 0, 5}};
    for (uint32_t s = 0; s < COUNT_OF(scales); s++)
        for (uint32_t a = 0; a < COUNT_OF(aspects); a++)
            for (uint32_t k = 0; k < COUNT_OF(sides); k++) {
                fnl_scene *scene = make_scene();
                const float x = sides[k].x * scales[s], y = sides[k].y * scales[s], z = sides[k].z * scales[s], far = 1000 * scales[s];
                const vec3 points[] = {{x, 0, 0}, {-x, 0, 0}, {0, y, z}, {0, 0, -z}, {far, far, far}};
                static const uint32_t indices[] = {0, 1, 2, 0, 3, 1, 4, 4, 4, 0, 4, 4}, at[] = {0, 0, 0};
                fnl_mesh_params shape = {.vertex_count = 5, .index_count = 12, .positions = &points[0].x, .indices = indices};
                const fnl_mesh_params dot = {.vertex_count = 1, .index_count = 3, .positions = &points[0].x, .indices = at};
                const fnl_mat4 moved = mat4_translation(vec3_make(2 * scales[s], -scales[s], 0)), gone = mat4_translation(vec3_make(0, far, 0));
                fnl_light_params light = fnl_light_params_default();
                light.position = vec3_make(0, far, far);
                fnl_light_id id;
                fnl_mesh_id mesh, small;
                fnl_instance_id instance;
                fnl_camera camera;
                assert_int_equal(fnl_scene_add_mesh(scene, &shape, &mesh), FNL_OK);
                assert_int_equal(fnl_scene_add_mesh(scene, &dot, &small), FNL_OK);
                assert_int_equal(fnl_scene_add_instance(scene, mesh, &moved, &instance), FNL_OK);
                assert_int_equal(fnl_scene_add_instance(scene, small, &gone, &instance), FNL_OK);
                assert_int_equal(fnl_scene_add_light(scene, &light, &id), FNL_OK);
                assert_int_equal(fnl_scene_query_framing_camera(scene, aspects[a], &camera), FNL_OK);
                vec3 shown[4];
                for (uint32_t i = 0; i < 4; i++) shown[i] = mat4_point(&moved, points[i]);
                expect_framed(&camera, aspects[a], shown, 4);
                fnl_scene_destroy(&scene);
            }
}

/* A box a thousand times as large as its triangle, which a skin and a morph target move. */
static void test_framing_camera_follows_poses(void **state) {
    UNUSED(state);
    fnl_scene *scene = make_scene();
    fnl_mesh_params shape = triangle();
    fnl_mesh_id mesh;
    fnl_instance_id instance;
    const fnl_mat4 identity = mat4_identity();
    assert_int_equal(fnl_scene_add_mesh(scene, &shape, &mesh), FNL_OK);
    assert_int_equal(fnl_scene_add_instance(scene, mesh, &identity, &instance), FNL_OK);
    struct scene_primitive *p = &scene->primitives.data[0];
    static const vec3 up[] = {{0, 1000, 0}, {0, 1000, 0}, {0, 1000, 0}};
    static const struct scene_morph_target target = {.positions = up};
    float weight = 0.002f;
    p->morph_targets = &target;
    p->morph_target_count = 1;
    scene->meshes.data[0].morph_weights = &weight;
    box_add_point(&p->bounds, vec3_make(0, 1000, 0));
    fnl_camera camera;
    assert_int_equal(fnl_scene_query_framing_camera(scene, 1.5f, &camera), FNL_OK);
    const vec3 shown[] = {{0, 2, 0}, {1, 2, 0}, {0, 3, 0}};
    expect_framed(&camera, 1.5f, shown, 3);
    fnl_scene_destroy(&scene);
}

static void test_framing_camera_of_nothing(void **state) {
    UNUSED(state);
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

/* A scene that reaches as far as floats do. */
static void test_framing_camera_of_the_largest_places_is_finite(void **state) {
    UNUSED(state);
    fnl_host host = test_host(&test_lines);
    fnl_scene *scene;
    const float positions[] = {0, 0, FLT_MAX, -FLT_MAX, 0, 0, 0, 1, 0};
    const fnl_mesh_params p = {.vertex_count = 3, .positions = positions};
    const mat4 place = mat4_identity();
    fnl_mesh_id mesh;
    fnl_instance_id instance;
    fnl_camera camera;
    assert_int_equal(fnl_scene_create(&host, &scene), FNL_OK);
    assert_int_equal(fnl_scene_add_mesh(scene, &p, &mesh), FNL_OK);
    assert_int_equal(fnl_scene_add_instance(scene, mesh, &place, &instance), FNL_OK);
    assert_int_equal(fnl_scene_query_framing_camera(scene, 1.5f, &camera), FNL_OK);
    assert_true(vec3_finite(camera.position) && vec3_finite(camera.target) && isfinite(camera.far_distance) && camera.near_distance > 0);
    fnl_scene_destroy(&scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_framing_camera_of_the_largest_places_is_finite),
        cmocka_unit_test(test_misuse_is_named),
        cmocka_unit_test(test_ids_of_removed_things_are_recognised),
        cmocka_unit_test(test_moves_can_be_followed),
        cmocka_unit_test(test_children_follow_their_parents),
        cmocka_unit_test(test_framing_camera_fills_the_picture),
        cmocka_unit_test(test_framing_camera_follows_poses),
        cmocka_unit_test(test_framing_camera_of_nothing),
        cmocka_unit_test(test_framing_camera_of_the_largest_scene),
        cmocka_unit_test(test_added_things_are_counted),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
