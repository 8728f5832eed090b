/* SPDX-License-Identifier: MIT */
/* Decals of a scene without a device: the calls and what they refuse, the glTF extension, the scatter. */
#include "tests/gltf_test_file.h"

#include <setjmp.h>

#include <cmocka.h>

static struct test_log file_log;

static fnl_scene *new_scene(void) {
    fnl_scene *scene;
    fnl_host host = test_host(&file_log);
    assert_int_equal(fnl_scene_create(&host, &scene), FNL_OK);
    return scene;
}

static fnl_instance_id add_triangle(fnl_scene *scene) {
    static const float positions[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    fnl_mesh_id mesh;
    fnl_instance_id instance;
    mat4 identity = mat4_identity();
    assert_int_equal(fnl_scene_add_mesh(scene, &(fnl_mesh_params){.vertex_count = 3, .positions = positions}, &mesh),
                     FNL_OK);
    assert_int_equal(fnl_scene_add_instance(scene, mesh, &identity, &instance), FNL_OK);
    return instance;
}

static void test_calls(void **state) {
    UNUSED(state);
    fnl_scene *scene = new_scene();
    fnl_instance_id instance = add_triangle(scene);
    fnl_decal_params p = fnl_decal_params_default(), seen;
    fnl_decal_id a, b, c;
    assert_int_equal(fnl_scene_add_decal(scene, &p, &a), FNL_OK);
    p.kind = FNL_DECAL_MESH;
    assert_int_equal(fnl_scene_add_decal(scene, &p, &b), FNL_ERROR_INVALID); /* on nothing */
    p.instance = instance;
    assert_int_equal(fnl_scene_add_decal(scene, &p, &b), FNL_OK);
    p.kind = FNL_DECAL_REDRAW;
    assert_int_equal(fnl_scene_set_decal(scene, b, &p), FNL_ERROR_INVALID); /* the kind stays */
    assert_int_equal(fnl_scene_remove_decal(scene, a), FNL_OK);
    assert_int_equal(fnl_scene_remove_decal(scene, a), FNL_ERROR_INVALID);
    p = fnl_decal_params_default();
    p.sort_key = 7;
    assert_int_equal(fnl_scene_add_decal(scene, &p, &c), FNL_OK);
    assert_int_equal(c.index, a.index); /* holes are reused */
    assert_int_not_equal(c.generation, a.generation);
    fnl_scene_info info;
    assert_int_equal(fnl_scene_query_info(scene, &info), FNL_OK);
    assert_int_equal(info.decal_count, 2);
    assert_int_equal(info.decal_kind_counts[FNL_DECAL_BOX], 1);
    assert_int_equal(info.decal_kind_counts[FNL_DECAL_MESH], 1);
    assert_int_equal(fnl_scene_query_decal(scene, 0, &seen), FNL_OK);
    assert_int_equal(seen.sort_key, 7);
    assert_int_equal(fnl_scene_query_decal(scene, 2, &seen), FNL_ERROR_INVALID);
    assert_int_equal(fnl_scene_set_instance_receivers(scene, instance, 256), FNL_ERROR_INVALID);
    assert_int_equal(fnl_scene_set_instance_receivers(scene, instance, 6), FNL_OK);
    assert_int_equal((uint8_t)~scene->nodes.data[instance.index].refuses, 6);
    assert_int_equal(fnl_scene_set_instance_light_mask(scene, instance, 256), FNL_ERROR_INVALID);
    assert_int_equal(fnl_scene_set_instance_light_mask(scene, instance, 9), FNL_OK);
    assert_int_equal((uint8_t)~scene->nodes.data[instance.index].unlit, 9);
    assert_int_equal(fnl_scene_set_instance_view_mask(scene, instance, 256), FNL_ERROR_INVALID);
    assert_int_equal(fnl_scene_set_instance_view_mask(scene, instance, 17), FNL_OK);
    assert_int_equal((uint8_t)~scene->nodes.data[instance.index].unseen, 17);
    assert_int_equal((uint8_t)~scene->nodes.data[instance.index].refuses, 6);
    assert_int_equal(fnl_scene_remove_instance(scene, instance), FNL_OK);
    assert_false(decal_shows(scene, &scene->decals.data[b.index]));
    fnl_scene_destroy(&scene);
}

static void test_what_is_refused(void **state) {
    UNUSED(state);
    fnl_scene *scene = new_scene();
    for (int i = 0; i < 12; i++) {
        fnl_decal_params p = fnl_decal_params_default();
        fnl_decal_id id;
        switch (i) {
        case 0:
            p.transform = mat4_scaling(vec3_make(1, 0, 1));
            break; /* flat */
        case 1:
            p.transform.m[12] = NAN;
            break;
        case 2:
            p.color[1] = 1.5f;
            break;
        case 3:
            p.roughness = -1;
            break;
        case 4:
            p.emissive[2] = INFINITY;
            break;
        case 5:
            p.fade_start = 1.2f, p.fade_end = 1;
            break;
        case 6:
            p.receivers = 256;
            break;
        case 7:
            p.slices = 0;
            break;
        case 8:
            p.channels = 32;
            break;
        case 9:
            p.blend = FNL_DECAL_BLEND_COUNT;
            break;
        case 10:
            p.color_image = (fnl_image_id){0, 1};
            break; /* there is none */
        default:
            p.kind = (fnl_decal_kind)9;
            break;
        }
        assert_int_equal(fnl_scene_add_decal(scene, &p, &id), FNL_ERROR_INVALID);
        assert_int_equal(id.generation, 0);
    }
    assert_int_equal(file_log.count, 12);
    fnl_scene_destroy(&scene);
}

#define FILE_WITH(nodes) "{\"asset\":{\"version\":\"2.0\"},\"extensionsUsed\":[\"FNL_decal\"],\"nodes\":[" nodes "]}"
#define NODE(text) "{\"extensions\":{\"FNL_decal\":" text "}}"

static void test_extension(void **state) {
    UNUSED(state);
    fnl_scene *scene;
    assert_int_equal(
        test_load(
            &file_log,
            FILE_WITH(
                "{\"translation\":[1,2,3],\"scale\":[2,4,0.5],\"extensions\":{\"FNL_decal\":{\"decal\":{"
                "\"baseColorFactor\":[1,0,0,0.5],\"blend\":\"overlay\",\"channels\":[\"color\",\"normal\"],\"sortKey\":-3,"
                "\"fadeStart\":0.5,\"fadeEnd\":0.75,\"receivers\":2,\"cut\":0.25,\"flatten\":true}}}}," NODE(
                    "{\"decal\":{\"kind\":\"volume\",\"slices\":6},\"receiverMask\":5}")),
            NULL, 0, &scene),
        FNL_OK);
    assert_int_equal(file_log.count, 0);
    assert_int_equal(scene->decals.count, 2);
    const fnl_decal_params *p = &scene->decals.data[0].params;
    assert_int_equal(p->kind, FNL_DECAL_BOX);
    assert_int_equal(p->blend, FNL_DECAL_BLEND_OVERLAY);
    assert_int_equal(p->channels, FNL_DECAL_COLOR | FNL_DECAL_NORMAL);
    assert_int_equal(p->sort_key, -3);
    assert_int_equal(p->receivers, 2);
    assert_true(p->distance_field && p->flatten && p->cut == 0.25f && p->color[3] == 0.5f && p->fade_end == 0.75f);
    mat4 transform = decal_transform(scene, &scene->decals.data[0]);
    assert_true(transform.m[0] == 2 && transform.m[5] == 4 && transform.m[10] == 0.5f && transform.m[14] == 3);
    assert_int_equal(scene->decals.data[1].params.slices, 6);
    assert_int_equal((uint8_t)~scene->nodes.data[1].refuses, 5);
    /* The queried parameters say which node it moves with, and setting them leaves it there. */
    fnl_decal_params queried;
    fnl_entity_info info;
    assert_int_equal(fnl_scene_query_decal(scene, 0, &queried), FNL_OK);
    assert_true(queried.instance.generation && queried.instance.index == 0);
    assert_int_equal(fnl_scene_query_entity(scene, FNL_ENTITY_DECAL, 0, &info), FNL_OK);
    assert_int_equal(fnl_scene_set_decal(scene, info.id.decal, &queried), FNL_OK);
    const mat4 kept = decal_transform(scene, &scene->decals.data[0]);
    assert_memory_equal(&transform, &kept, sizeof kept);
    fnl_scene_destroy(&scene);
}

static void test_broken_extensions_are_named(void **state) {
    UNUSED(state);
    static const struct {
        const char *json, *message;
        uint32_t decals;
    } cases[] = {
        {FILE_WITH(NODE("{\"decal\":{\"kind\":\"egg\"}}")),
         "test.glb: /nodes/0/extensions/FNL_decal/decal/kind: 'egg' is none of box, volume, mesh, redraw, baked", 1},
        {FILE_WITH(NODE("{\"decal\":{\"channels\":[\"colour\"]}}")),
         "test.glb: /nodes/0/extensions/FNL_decal/decal/channels/0: 'colour' is none of color, normal", 1},
        {FILE_WITH(NODE("{\"decal\":{\"kind\":\"mesh\"}}")), "test.glb: /nodes/0/extensions/FNL_decal/decal", 0},
        {FILE_WITH(NODE("{\"decal\":{\"kind\":\"mesh\",\"target\":0}}")),
         "test.glb: /nodes/0/extensions/FNL_decal/decal/target: node 0 has no mesh", 0},
        {FILE_WITH("{\"scale\":[1,1,0],\"extensions\":{\"FNL_decal\":{\"decal\":{}}}}"),
         "test.glb: /nodes/0/extensions/FNL_decal/decal: its node has no size", 0},
        {FILE_WITH(NODE("{\"decal\":{\"fadeStart\":1,\"fadeEnd\":0.5}}")),
         "test.glb: /nodes/0/extensions/FNL_decal/decal/fadeEnd: is less than fadeStart", 1},
        {FILE_WITH(NODE("{\"decal\":{\"baseColorTexture\":{\"index\":3}}}")),
         "test.glb: /nodes/0/extensions/FNL_decal/decal/baseColorTexture/index", 1},
        {FILE_WITH(NODE("{\"decal\":{\"slices\":0}}")), "test.glb: /nodes/0/extensions/FNL_decal/decal/slices", 1},
        {FILE_WITH(NODE("{\"receiverMask\":999}")), "test.glb: /nodes/0/extensions/FNL_decal/receiverMask", 0},
    };
    for (uint32_t i = 0; i < COUNT_OF(cases); i++) {
        fnl_scene *scene;
        assert_int_equal(test_load(&file_log, cases[i].json, NULL, 0, &scene), FNL_OK);
        if (!strstr(file_log.text, cases[i].message)) fail_msg("no '%s' in:\n%s", cases[i].message, file_log.text);
        assert_int_equal(scene->decals.count, cases[i].decals);
        fnl_scene_destroy(&scene);
    }
}

static void test_scatter(void **state) {
    UNUSED(state);
    fnl_scene *scenes[2];
    for (int i = 0; i < 2; i++) {
        scenes[i] = new_scene();
        add_triangle(scenes[i]);
        scene_update_transforms(scenes[i]);
        assert_int_equal(fnl_scene_scatter_decals(scenes[i], 200, 5), FNL_OK);
    }
    assert_int_equal(scenes[0]->decals.count, 200);
    for (uint32_t i = 0; i < 200; i++) {
        const fnl_decal_params *a = &scenes[0]->decals.data[i].params, *b = &scenes[1]->decals.data[i].params;
        assert_memory_equal(&a->transform, &b->transform, sizeof a->transform);
        vec3 at = {a->transform.m[12], a->transform.m[13], a->transform.m[14]};
        assert_true(fabsf(at.z) < 1e-5f && at.x >= -1e-5f && at.y >= -1e-5f && at.x + at.y <= 1.0001f); /* on the triangle */
    }
    for (int i = 0; i < 2; i++) fnl_scene_destroy(&scenes[i]);
    fnl_scene *empty = new_scene();
    assert_int_equal(fnl_scene_scatter_decals(empty, 10, 1), FNL_OK);
    assert_int_equal(empty->decals.count, 0);
    fnl_scene_destroy(&empty);
}

/* The separating axes against a plain search over points of random triangles. */
static void test_touched_triangles_ES_28(void **state) {
    UNUSED(state);
    struct random_state random = {3};
    uint32_t touched = 0, apart = 0;
    for (int i = 0; i < 4000; i++) {
        vec3 corners[3];
        for (int k = 0; k < 3; k++)
            corners[k] = vec3_make(random_range(&random, -1.5f, 1.5f), random_range(&random, -1.5f, 1.5f),
                                   random_range(&random, -1.5f, 1.5f));
        bool found = false;
        for (int a = 0; a <= 40 && !found; a++)
            for (int b = 0; a + b <= 40 && !found; b++) {
                float u = (float)a / 40, v = (float)b / 40, w = 1 - u - v;
                vec3 p = vec3_add_scaled(vec3_add_scaled(vec3_scale(corners[0], u), corners[1], v), corners[2], w);
                found = fabsf(p.x) <= 0.5f && fabsf(p.y) <= 0.5f && fabsf(p.z) <= 0.5f;
            }
        bool said = decal_touches(corners);
        if (found) assert_true(said);
        touched += said;
        apart += !said;
    }
    assert_true(touched > 500 && apart > 500);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_calls),     cmocka_unit_test(test_what_is_refused),
        cmocka_unit_test(test_extension), cmocka_unit_test(test_broken_extensions_are_named),
        cmocka_unit_test(test_scatter),   cmocka_unit_test(test_touched_triangles_ES_28),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
