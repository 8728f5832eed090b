/* SPDX-License-Identifier: MIT */
/* MSFT_lod: which level of nodes and materials a camera sees. */
#include "tests/levels_file.h"

#include <setjmp.h>

#include <cmocka.h>

static struct test_log file_log;

static fnl_scene *load(const char *json) {
    fnl_scene *scene = NULL;
    if (test_load(&file_log, json, levels_square, sizeof levels_square, &scene) != FNL_OK) fail_msg("not loaded: %s", file_log.text);
    return scene;
}

static fnl_scene *load_clean(const char *json) {
    fnl_scene *scene = load(json);
    if (file_log.count) fail_msg("%s", file_log.text);
    return scene;
}

/* One bit for each of the first nodes that shows a mesh. */
static uint32_t drawn(fnl_scene *scene, float distance) {
    const fnl_camera camera = levels_camera(distance);
    uint32_t bits = 0;
    scene_choose_levels(scene, &camera);
    for (uint32_t i = 0; i < scene->nodes.count; i++) bits |= (uint32_t)scene_node_draws(&scene->nodes.data[i]) << i;
    return bits;
}

/* The distance at which the square's sphere takes a part of the height. */
static float distance_of(float coverage) { return sqrtf(2 / (coverage * coverage) + 2); }

static void test_levels_by_size_MA_12(void **state) {
    UNUSED(state);
    fnl_scene *scene = load_clean(LEVELS_FILE("", "", "{\"mesh\":0," LEVELS_IDS("1,2") "," LEVELS_COVERAGE("0.5,0.2,0.01") "},{\"mesh\":1},{\"mesh\":2}"));
    assert_string_equal(scene->extensions.data[0].treatment, "full");
    fnl_scene_info info;
    assert_int_equal(fnl_scene_query_info(scene, &info), FNL_OK);
    assert_int_equal(info.triangle_count, 2); /* of the finest level alone */
    static const struct {
        float coverage;
        uint32_t drawn;
    } steps[] = {{1, 1}, {0.51f, 1}, {0.49f, 2}, {0.21f, 2}, {0.19f, 4}, {0.011f, 4}, {0.009f, 0}, {0.3f, 2}, {0.9f, 1}};
    for (uint32_t i = 0; i < COUNT_OF(steps); i++) {
        const float distance = distance_of(steps[i].coverage);
        const fnl_camera camera = levels_camera(distance);
        assert_float_equal(scene_levels_coverage(scene, &scene->levels.data[0], &camera), steps[i].coverage, 1e-3f);
        assert_int_equal(drawn(scene, distance), steps[i].drawn);
    }
    assert_int_equal(drawn(scene, 0.1f), 1); /* inside of the sphere */
    fnl_camera parallel = levels_camera(5);
    parallel.orthographic = true;
    parallel.vertical_extent = 4 * sqrtf(2);
    assert_float_equal(scene_levels_coverage(scene, &scene->levels.data[0], &parallel), 0.5f, 1e-4f);
    /* Nothing is edited while the level stays. */
    assert_int_equal(drawn(scene, distance_of(0.3f)), 2);
    const uint64_t version = scene->structure_version;
    assert_int_equal(drawn(scene, distance_of(0.31f)), 2);
    assert_true(scene->structure_version == version);
    fnl_scene_destroy(&scene);
}

/* A node that is scaled unevenly has the size of its longest axis, whichever it is and whatever turns it. */
static void test_levels_of_uneven_scales_MA_12(void **state) {
    UNUSED(state);
    static const char *const nodes[] = {
        "\"scale\":[3,0.5,0.5]}", "\"scale\":[0.5,3,0.5]}", "\"scale\":[0.5,0.25,3]}", "\"scale\":[-3,1,1]}", "\"scale\":[1,-3,2]}",
        "\"scale\":[1.5,1,0.5]},{\"scale\":[2,1,1],\"children\":[0]}", "\"rotation\":[0,0.6,0,0.8],\"scale\":[0.5,1,3]}"};
    for (uint32_t i = 0; i < COUNT_OF(nodes); i++) {
        char json[4096], *at;
        static const char mark[] = "\"scale\":0}";
        const char *whole = LEVELS_FILE("", "", "{\"mesh\":0," LEVELS_IDS("1,2") "," LEVELS_COVERAGE("0.5,0.2,0.01") ",\"scale\":0},{\"mesh\":1},{\"mesh\":2}");
        assert_non_null(at = strstr(whole, mark));
        const char *more = strchr(nodes[i], '}') + 1; /* a node above it */
        snprintf(json, sizeof json, "%.*s%.*s,{\"mesh\":1},{\"mesh\":2}%s]}", (int)(at - whole), whole, (int)(more - nodes[i]), nodes[i], more);
        if (*more) memcpy(strstr(json, "\"scenes\":[{\"nodes\":[0]}]"), "\"scenes\":[{\"nodes\":[3]}]", 24);
        fnl_scene *scene = load_clean(json);
        static const struct {
            float coverage;
            uint32_t drawn;
        } steps[] = {{0.51f, 1}, {0.49f, 2}, {0.21f, 2}, {0.19f, 4}, {0.0105f, 4}, {0.0095f, 0}};
        for (uint32_t k = 0; k < COUNT_OF(steps); k++)
            if (drawn(scene, 3 * distance_of(steps[k].coverage)) != steps[k].drawn) fail_msg("%s, coverage %g: other levels", nodes[i], (double)steps[k].coverage);
        fnl_camera parallel = levels_camera(5);
        parallel.orthographic = true;
        parallel.vertical_extent = 12 * sqrtf(2);
        assert_float_equal(scene_levels_coverage(scene, &scene->levels.data[0], &parallel), 0.5f, 1e-4f);
        fnl_scene_destroy(&scene);
    }
}

/* Away from the origin, on any side of it, the sphere stays where its node is. */
static void test_levels_stand_anywhere_MA_12(void **state) {
    UNUSED(state);
    static const float places[][3] = {{50, 0, 0}, {0, 50, 0}, {0, 0, 50}, {-50, 0, 0}, {0, -50, 0}, {0, 0, -50}, {40, -30, 20}};
    for (uint32_t i = 0; i < COUNT_OF(places); i++) {
        char json[4096];
        const vec3 place = {places[i][0], places[i][1], places[i][2]};
        snprintf(json, sizeof json, LEVELS_FILE("", "", "{\"mesh\":0," LEVELS_IDS("1,2") "," LEVELS_COVERAGE("0.5,0.2,0.01") ",\"translation\":[%g,%g,%g]},{\"mesh\":1},{\"mesh\":2}"), (double)place.x, (double)place.y,
                 (double)place.z);
        fnl_scene *scene = load_clean(json);
        fnl_camera camera = levels_camera(distance_of(0.3f));
        camera.position = vec3_add(camera.position, place);
        camera.target = vec3_add(camera.target, place);
        scene_choose_levels(scene, &camera);
        assert_float_equal(scene_levels_coverage(scene, &scene->levels.data[0], &camera), 0.3f, 1e-3f);
        assert_true(!scene_node_draws(&scene->nodes.data[0]) && scene_node_draws(&scene->nodes.data[1]) && !scene_node_draws(&scene->nodes.data[2]));
        fnl_scene_destroy(&scene);
    }
}

/* Larger and moved by the nodes above; trees below levels come and go; what is hidden stays hidden. */
static void test_levels_in_trees_MA_12(void **state) {
    UNUSED(state);
    fnl_scene *scene = load_clean(LEVELS_FILE("", "", "{\"children\":[1],\"scale\":[2,2,2]},{\"mesh\":0,\"children\":[2]," LEVELS_IDS("3") "},{\"mesh\":1},"
                                              "{\"children\":[4]},{\"mesh\":2}"));
    assert_int_equal(scene->nodes.data[3].parent, 0);
    assert_int_equal(drawn(scene, distance_of(0.6f / 2)), 2 | 4); /* twice as large; the default: 0.5 */
    assert_int_equal(drawn(scene, distance_of(0.4f / 2)), 16);
    assert_int_equal(drawn(scene, 1e6f), 16); /* the last level never ends by default */
    scene_show_node(scene, 0, false);
    assert_int_equal(drawn(scene, distance_of(0.6f / 2)), 0);
    scene_show_node(scene, 0, true);
    assert_int_equal(drawn(scene, distance_of(0.6f / 2)), 2 | 4);
    /* As a part of another scene the same. */
    fnl_scene *into = NULL;
    fnl_host host = test_host(&file_log);
    assert_int_equal(fnl_scene_create(&host, &into), FNL_OK);
    const mat4 identity = mat4_identity();
    scene_add_node(into, "before", SCENE_NONE, &identity, SCENE_NONE);
    assert_int_equal(scene_merge(into, SCENE_NONE, scene, NULL), FNL_OK);
    fnl_scene_destroy(&scene);
    assert_int_equal(drawn(into, distance_of(0.4f / 2)), 16 << 2);
    assert_int_equal(drawn(into, distance_of(0.6f / 2)), (2 | 4) << 2);
    fnl_scene_destroy(&into);
}

static void test_levels_of_materials_MA_12(void **state) {
    UNUSED(state);
    fnl_scene *scene = load_clean(LEVELS_FILE(LEVELS_COVERAGE("0.4,0.1") ",", "\"MSFT_lod\":{\"ids\":[4]},", "{\"mesh\":3,\"children\":[1]},{\"mesh\":0,\"translation\":[9,9,0]}"));
    assert_int_equal(scene->nodes.count, 3);
    assert_int_equal(drawn(scene, distance_of(0.5f)), 1 | 2); /* what is below is not of the level */
    assert_int_equal(drawn(scene, distance_of(0.3f)), 4 | 2);
    const struct scene_mesh *mesh = &scene->meshes.data[scene->nodes.data[2].mesh];
    assert_int_equal(scene->primitives.data[mesh->first_primitive].material, 4);
    assert_ptr_equal(scene->primitives.data[mesh->first_primitive].positions, scene->primitives.data[3].positions);
    assert_int_equal(drawn(scene, distance_of(0.05f)), 2);
    fnl_scene_destroy(&scene);
}

static void test_broken_levels_MA_12(void **state) {
    UNUSED(state);
    static const struct {
        const char *json, *words;
    } cases[] = {
        {LEVELS_FILE("", "", "{\"mesh\":0," LEVELS_IDS("9,0,1,1") "},{\"mesh\":1}"), "/nodes/0/extensions/MSFT_lod/ids/0: "},
        {LEVELS_FILE("", "", "{\"mesh\":0," LEVELS_IDS("9,0,1,1") "},{\"mesh\":1}"), "/nodes/0/extensions/MSFT_lod/ids/1: 0 is a level already"},
        {LEVELS_FILE("", "", "{\"mesh\":0," LEVELS_IDS("9,0,1,1") "},{\"mesh\":1}"), "/nodes/0/extensions/MSFT_lod/ids/3: 1 is a level already"},
        {LEVELS_FILE("", "", "{\"children\":[1]},{\"mesh\":0," LEVELS_IDS("0") "}"), "node 0 is above the node that it is a level of"},
        {LEVELS_FILE("", "", "{\"mesh\":0,\"children\":[2]," LEVELS_IDS("1") "},{\"mesh\":1},{" LEVELS_IDS("1") "}"), "node 1 is a level of another node already"},
        {LEVELS_FILE("", "", "{\"mesh\":0," LEVELS_IDS("1") "," LEVELS_COVERAGE("0.2,0.5") "},{\"mesh\":1}"),
         "/nodes/0/extras/MSFT_screencoverage/1: is not a number from 0 to the one before"},
        {LEVELS_FILE("", "", "{\"mesh\":0," LEVELS_IDS("1") "," LEVELS_COVERAGE("\\\"x\\\"") "},{\"mesh\":1}"), "/nodes/0/extras/MSFT_screencoverage/0: "},
        {LEVELS_FILE("", "", "{\"mesh\":0," LEVELS_IDS("1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1") "},{\"mesh\":1}"), "1 is a level already"},
    };
    for (uint32_t i = 0; i < COUNT_OF(cases); i++) {
        char json[4096];
        char *to = json;
        for (const char *from = cases[i].json; *from; from++)
            if (*from != '\\') *to++ = *from;
        *to = 0;
        fnl_scene *scene = load(json);
        if (!strstr(file_log.text, cases[i].words)) fail_msg("%u: no '%s' in:\n%s", i, cases[i].words, file_log.text);
        for (float distance = 0.1f; distance < 1e5f; distance *= 3) assert_true(drawn(scene, distance) < 8);
        fnl_scene_destroy(&scene);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_levels_by_size_MA_12),
        cmocka_unit_test(test_levels_of_uneven_scales_MA_12),
        cmocka_unit_test(test_levels_stand_anywhere_MA_12),
        cmocka_unit_test(test_levels_in_trees_MA_12),
        cmocka_unit_test(test_levels_of_materials_MA_12),
        cmocka_unit_test(test_broken_levels_MA_12),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
