/* SPDX-License-Identifier: MIT */
/* Photometric files: what they say in each direction, which of them are refused and how, and EXT_lights_ies. */
#include "tests/gltf_test_file.h"
#include "tests/test_memory.h"

#include <setjmp.h>

#include <cmocka.h>

static struct test_log file_log;

struct loaded {
    fnl_scene *scene;
    fnl_light_profile_id id;
    float candela;
    fnl_result result;
};

static struct loaded load(const char *text) {
    struct loaded l = {0};
    fnl_host host = test_host(&file_log);
    assert_int_equal(fnl_scene_create(&host, &l.scene), FNL_OK);
    l.result = fnl_scene_add_light_profile(l.scene, "lamp.ies", text, strlen(text), &l.id, &l.candela);
    return l;
}

/* Candela at a vertical and a horizontal angle of type C, degrees. */
static double at(const struct loaded *l, double vertical, double horizontal) {
    const double v = vertical / 57.295779513082321, h = horizontal / 57.295779513082321;
    const struct light_profile *p = &l->scene->profiles.data[l->id.index];
    return light_profile_at(p, sin(v) * cos(h), sin(v) * sin(h), cos(v)) * (double)p->candela;
}

#define expect_candela(l, vertical, horizontal, candela) assert_float_equal((float)at(l, vertical, horizontal), candela, 2e-3f)

#define HEAD(counts) "IESNA:LM-63-2002\n[TEST] none\n[MANUFAC] nobody\nTILT=NONE\n1 -1 2 " counts " 1 2 0 0 0\n1 1 0\n"

/* Round: 0 to 90 degrees, nothing above. */
static void test_round_profile_MA_11(void **state) {
    UNUSED(state);
    struct loaded l = load(HEAD("4 1") "0 30 60 90\n0\n100 80 20 0\n");
    assert_int_equal(l.result, FNL_OK);
    assert_int_equal(file_log.count, 0);
    assert_true(l.candela == 200);
    for (int h = 0; h < 360; h += 37) {
        expect_candela(&l, 0, h, 200);
        expect_candela(&l, 15, h, 180);
        expect_candela(&l, 60, h, 40);
        expect_candela(&l, 75, h, 20);
        expect_candela(&l, 120, h, 0);
        expect_candela(&l, 180, h, 0);
    }
    const struct light_profile *p = &l.scene->profiles.data[0];
    assert_true(p->columns == 1 && p->rows == 6); /* no larger than the angles ask for */
    fnl_scene_destroy(&l.scene);
    l = load(HEAD("2 1") "0 60\n0\n100 50\n"); /* ends at once: within half a degree */
    expect_candela(&l, 60, 0, 100);
    expect_candela(&l, 60.5, 0, 0);
    fnl_scene_destroy(&l.scene);
    l = load(HEAD("2 1") "0 41.3\n0\n100 50\n"); /* on no grid */
    expect_candela(&l, 41, 0, 2 * (100 - 50 * 41 / 41.3));
    expect_candela(&l, 41.6, 0, 0);
    fnl_scene_destroy(&l.scene);
}

/* Where the vertical angles end the light does: the last value stands at the last angle, and nothing beyond it. At 180 degrees there is no beyond. */
static void test_the_last_vertical_angle_MA_11(void **state) {
    UNUSED(state);
    static const struct {
        const char *verticals; /* with values 10, 20 … from the first to the last */
        uint32_t count;
        double first, last;
    } cases[] = {{"0 90", 2, 0, 90},         {"0 45 90", 3, 0, 90},    {"0 10 20 50 90", 5, 0, 90}, {"0 120", 2, 0, 120},
                 {"0 30 60 90 179", 5, 0, 179}, {"0 0.5", 2, 0, 0.5}, {"0 90 180", 3, 0, 180},     {"90 135 180", 3, 90, 180},
                 {"90 120 150", 3, 90, 150}};
    for (uint32_t i = 0; i < COUNT_OF(cases); i++)
        for (uint32_t columns = 1; columns <= 2; columns++) {
            char text[400], values[100];
            size_t used = 0;
            for (uint32_t k = 1; k <= cases[i].count; k++) used += (size_t)snprintf(values + used, sizeof values - used, "%u ", 10 * k);
            snprintf(text, sizeof text, "IESNA:LM-63-2002\nTILT=NONE\n1 -1 1 %u %u 1 2 0 0 0\n1 1 0\n%s\n%s\n%s%s\n", cases[i].count, columns,
                     cases[i].verticals, columns == 2 ? "0 180" : "0", values, columns == 2 ? values : "");
            struct loaded l = load(text);
            if (l.result != FNL_OK) fail_msg("%s", file_log.text);
            const float brightest = 10 * (float)cases[i].count;
            assert_true(l.candela == brightest);
            for (int h = 0; h < 360; h += 60) {
                expect_candela(&l, cases[i].first, h, 10);
                expect_candela(&l, cases[i].last, h, brightest);
                for (double v = cases[i].last + 0.5; v <= 180; v += 0.5) expect_candela(&l, v, h, 0);
                for (double v = cases[i].first - 0.5; v >= 0; v -= 0.5) expect_candela(&l, v, h, 0);
            }
            fnl_scene_destroy(&l.scene);
        }
}

/* The four symmetries of type C and the one of 1995, each with a value of its own every 45 degrees round, and what lies between. */
static void test_horizontal_symmetries_MA_11(void **state) {
    UNUSED(state);
    static const struct {
        const char *horizontals, *values; /* at the horizon; the other two verticals are 10 */
        double around[8];                 /* 0, 45, 90 … 315 */
    } cases[] = {
        {"3\n0 45 90\n", "10 100 10  10 200 10  10 300 10", {100, 200, 300, 200, 100, 200, 300, 200}},
        {"5\n0 45 90 135 180\n", "10 1 10 10 2 10 10 3 10 10 4 10 10 5 10", {1, 2, 3, 4, 5, 4, 3, 2}},
        {"9\n0 45 90 135 180 225 270 315 360\n", "10 1 10 10 2 10 10 3 10 10 4 10 10 5 10 10 6 10 10 7 10 10 8 10 10 1 10", {1, 2, 3, 4, 5, 6, 7, 8}},
        {"8\n0 45 90 135 180 225 270 315\n", "10 1 10 10 2 10 10 3 10 10 4 10 10 5 10 10 6 10 10 7 10 10 8 10", {1, 2, 3, 4, 5, 6, 7, 8}},
        {"5\n90 135 180 225 270\n", "10 1 10 10 2 10 10 3 10 10 4 10 10 5 10", {3, 2, 1, 2, 3, 4, 5, 4}},
    };
    for (uint32_t i = 0; i < COUNT_OF(cases); i++) {
        char text[600];
        snprintf(text, sizeof text, "IESNA:LM-63-1995\nTILT=NONE\n1 0 1 3 %.1s 1 1 0 0 0\n1 1 0\n0 90 180\n%s%s\n", cases[i].horizontals,
                 cases[i].horizontals + 2, cases[i].values);
        struct loaded l = load(text);
        if (l.result != FNL_OK) fail_msg("%s", file_log.text);
        for (int k = 0; k < 8; k++) {
            expect_candela(&l, 90, k * 45, (float)cases[i].around[k]);
            expect_candela(&l, 90, k * 45 + 22.5, (float)(cases[i].around[k] + cases[i].around[(k + 1) % 8]) / 2);
            expect_candela(&l, 135, k * 45, (float)(cases[i].around[k] + 10) / 2);
        }
        fnl_scene_destroy(&l.scene);
    }
}

/* The directions of a light that points along -Z with its up along +Y, by the text of EXT_lights_ies: 0, 0 is -Z, the X/Y plane the horizontal one,
   and angles of type C turn from +X to +Y. Types A and B turn clockwise seen from above: from -Z to +X. */
static double along_axis(const struct loaded *l, fnl_vec3 d) {
    fnl_light_params light = fnl_light_params_default();
    light.profile = l->id;
    fnl_light_id id;
    assert_int_equal(fnl_scene_add_light(l->scene, &light, &id), FNL_OK);
    const fnl_light_params *params = &l->scene->lights.data[id.index].params;
    const vec3 side = vec3_cross(params->direction, params->up);
    return light_profile_at(scene_light_profile(l->scene, params), (double)vec3_dot(d, side), (double)vec3_dot(d, params->up),
                            (double)vec3_dot(d, params->direction)) * (double)l->candela;
}

static void test_profile_directions_MA_11(void **state) {
    UNUSED(state);
    struct loaded l = load(HEAD("3 5") "0 90 180\n0 90 180 270 360\n1 2 6 1 3 6 1 4 6 1 5 6 1 2 6\n");
    static const struct {
        fnl_vec3 to;
        double candela;
    } axes[] = {{{0, 0, -1}, 2}, {{0, 0, 1}, 12}, {{1, 0, 0}, 4}, {{0, 1, 0}, 6}, {{-1, 0, 0}, 8}, {{0, -1, 0}, 10}};
    for (uint32_t i = 0; i < COUNT_OF(axes); i++) assert_float_equal(along_axis(&l, axes[i].to), axes[i].candela, 1e-4);
    fnl_scene_destroy(&l.scene);
    /* Verticals -90, 0, 90; horizontals -90, 0, 90: the columns are left, middle, right. */
    for (int type = 2; type <= 3; type++) {
        char text[400];
        snprintf(text, sizeof text, "IESNA:LM-63-2019\nTILT=NONE\n1 -1 1 3 3 %d 2 0 0 0\n1 1 0\n-90 0 90\n-90 0 90\n1 2 3 4 5 6 7 8 9\n", type);
        l = load(text);
        assert_int_equal(l.result, FNL_OK);
        assert_float_equal(along_axis(&l, (fnl_vec3){0, 0, -1}), 5, 0.05);
        assert_float_equal(along_axis(&l, (fnl_vec3){0.99619470f, 0, -0.08715574f}), 5 + 85.0 / 30, 0.02);
        assert_float_equal(along_axis(&l, (fnl_vec3){-0.99619470f, 0, -0.08715574f}), 5 - 85.0 / 30, 0.02);
        assert_float_equal(along_axis(&l, (fnl_vec3){0, 0.99619470f, -0.08715574f}), 5 + 85.0 / 90, 0.02);
        assert_float_equal(along_axis(&l, (fnl_vec3){0, -0.99619470f, -0.08715574f}), 5 - 85.0 / 90, 0.02);
        assert_float_equal(along_axis(&l, (fnl_vec3){0, 0, 1}), 0, 1e-6);
        /* Half to the right and half up. A: longitude 45, latitude 35.26. B: 35.26 to the side, 54.74 - 9.74 = 45 up. */
        const double high = 35.264389682754654 / 90, expected = type == 3 ? 5 + 0.5 * 3 + high : 5 + high * 3 + 0.5;
        assert_float_equal(along_axis(&l, (fnl_vec3){0.57735027f, 0.57735027f, -0.57735027f}), expected, 0.02);
        fnl_scene_destroy(&l.scene);
    }
}

/* Versions, factors, lines of lamps, and what files have that the standard does not. */
static void test_odd_files_MA_11(void **state) {
    UNUSED(state);
#define BODY "1 0 10 2 1 1 1 0 0 0\n0.5 0.25 0\n0 180\n0\n8 4\n"
    static const struct {
        const char *text;
        float candela;
    } cases[] = {
        {"IESNA:LM-63-1995\nTILT=NONE\n" BODY, 10}, /* value, multiplier, ballast factor, ballast-lamp factor */
        {"IESNA91\nTILT=NONE\n" BODY, 10},
        {"A LUMINAIRE OF 1986\nTILT=NONE\n" BODY, 10},
        {"IESNA:LM-63-2002\nTILT=NONE\n" BODY, 40}, /* the last factor means something else since */
        {"IES:LM-63-2019\r\n[X] y\r\nTILT=NONE\r\n1,0,10,2,1,1,1,0,0,0\r\n0.5,1.00001,0\r\n0, 180\r\n0\r\n8\t4", 40},
        {"IESNA:LM-63-1995\nTILT=INCLUDE\n1\n3\n0 45 90\n1 0.9 0.8\n" BODY, 10},
        {"IESNA:LM-63-1995\n tilt = other.tlt\n" BODY "and more\n", 10},
        {"IESNA:LM-63-2002\nTILT=NONE\n1 0 10 2 1 1 1 0 0 0\n0 0 0\n0 180\n0\n8 -4\n", 80}, /* no factor is 0; no light is negative */
    };
    for (uint32_t i = 0; i < COUNT_OF(cases); i++) {
        struct loaded l = load(cases[i].text);
        if (l.result != FNL_OK) fail_msg("%u: %s", i, file_log.text);
        assert_float_equal(l.candela, cases[i].candela, 1e-4f);
        fnl_scene_destroy(&l.scene);
    }
}

static void test_broken_files_MA_11(void **state) {
    UNUSED(state);
#define START "IESNA:LM-63-2002\nTILT=NONE\n"
    static const char *const cases[][2] = {
        {"", "lamp.ies: line 1: has no line TILT="},
        {"\x89PNG\r\n\x1a\n", "has no line TILT="},
        {START, "line 3: ends before the number of lamps"},
        {START "1 0 x 2 1 1 1 0 0 0\n", "line 3: the multiplier is no number"},
        {START "1 0 nan 2 1 1 1 0 0 0\n", "line 3: the multiplier is no number"},
        {START "1 0 0 2 1 1 1 0 0 0\n", "line 3: the multiplier is not above 0"},
        {START "1 0 1 1 1 1 1 0 0 0\n", "the number of vertical angles is 1, must be a whole number from 2"},
        {START "1 0 1 4000000000 4000000000 1 1 0 0 0\n", "the number of vertical angles is 4e+09"},
        {START "1 0 1 20 20 1 1 0 0 0\n1 1 0\n", "more candela values than the file has room for"},
        {START "1 0 1 2 1 4 1 0 0 0\n", "the photometric type is 4, must be a whole number from 1 to 3"},
        {START "1 0 1 2.5 1 1 1 0 0 0\n", "the number of vertical angles is 2.5"},
        {START "1 0 1 2 1 1 1 0 0 0\n1 1 0\n90 0\n0\n1 1\n", "line 5: vertical angles do not ascend"},
        {START "1 0 1 2 1 1 1 0 0 0\n1 1 0\n0 190\n0\n1 1\n", "vertical angles of type C lie from 0 to 180"},
        {START "1 0 1 2 2 1 1 0 0 0\n1 1 0\n0 90\n0 120\n1 1 1 1\n", "end at 90, 180 or 360"},
        {START "1 0 1 2 2 1 1 0 0 0\n1 1 0\n0 90\n45 90\n1 1 1 1\n", "begin at 0, or lie from 90 to 270"},
        {START "1 0 1 2 1 2 1 0 0 0\n1 1 0\n0 120\n0\n1 1\n", "of type A and B lie from -90 to 90"},
        {START "1 0 1 2 1 1 1 0 0 0\n1 1 0\n0 90\n0\n1\n", "line 8: ends before a candela value"},
        {START "1 0 1 2 1 1 1 0 0 0\n1 1 0\n0 90\n0\n0 0\n", "there is no light in any direction"},
        {"IESNA:LM-63-1995\nTILT=INCLUDE\n1\n99999999\n", "the number of tilt angles is 1e+08"},
    };
    for (uint32_t i = 0; i < COUNT_OF(cases); i++) {
        struct loaded l = load(cases[i][0]);
        assert_int_equal(l.result, FNL_ERROR_FORMAT);
        if (!strstr(file_log.text, cases[i][1]) || file_log.count != 1) fail_msg("%u: no '%s' in: %s", i, cases[i][1], file_log.text);
        assert_true(l.scene->profiles.count == 0 && l.id.generation == 0);
        fnl_scene_destroy(&l.scene);
    }
}

static void test_lights_take_profiles_MA_11(void **state) {
    UNUSED(state);
    struct loaded l = load(HEAD("2 1") "0 180\n0\n100 50\n");
    fnl_light_params light = fnl_light_params_default();
    fnl_light_id id;
    light.profile = (fnl_light_profile_id){7, 1};
    assert_int_equal(fnl_scene_add_light(l.scene, &light, &id), FNL_ERROR_INVALID);
    light.profile = l.id;
    light.kind = FNL_LIGHT_CAPSULE;
    assert_int_equal(fnl_scene_add_light(l.scene, &light, &id), FNL_ERROR_INVALID);
    assert_non_null(strstr(file_log.text, "profile is set, but only points and spots can have one"));
    light.kind = FNL_LIGHT_POINT;
    light.direction = (fnl_vec3){0, 0, 0};
    assert_int_equal(fnl_scene_add_light(l.scene, &light, &id), FNL_ERROR_INVALID);
    light.direction = (fnl_vec3){0, -2, 0};
    assert_int_equal(fnl_scene_add_light(l.scene, &light, &id), FNL_OK);
    assert_int_equal(fnl_scene_query_light(l.scene, 0, &light), FNL_OK);
    assert_true(light.direction.y == -1 && light.profile.index == l.id.index && light.profile.generation == l.id.generation);
    fnl_scene_destroy(&l.scene);
}

/* ---- EXT_lights_ies ---- */

static const char lamp[] = "IESNA:LM-63-2002\nTILT=NONE\n1 0 10 2 1 1 1 0 0 0\n1 1 0\n0 180\n0\n8 4\n";
/* A profile in the buffer, one in the URI (5 candela all round), and one that is broken. */
static const char with_lamps[] =
    "{\"asset\":{\"version\":\"2.0\"},\"extensionsUsed\":[\"EXT_lights_ies\"],\"extensionsRequired\":[\"EXT_lights_ies\"],"
    "\"buffers\":[{\"byteLength\":%zu}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":%zu}],\"extensions\":{\"EXT_lights_ies\":{\"lights\":["
    "{\"bufferView\":0,\"mimeType\":\"application/x-ies-lm-63\"},"
    "{\"uri\":\"data:application/x-ies-lm-63;base64,SUVTTkE6TE0tNjMtMjAwMgpUSUxUPU5PTkUKMSAwIDEgMiAxIDEgMSAwIDAgMAoxIDEgMAowIDE4MAowCjUgNQo=\"},"
    "{\"uri\":\"data:text/plain;base64,bm90aGluZw==\"}]}},\"scenes\":[{\"nodes\":[0,1,2]}],\"nodes\":["
    "{\"name\":\"hall\",\"rotation\":[-0.70710678,0,0,0.70710678],\"translation\":[1,2,3],\"scale\":[2,2,2],\"extensions\":{\"EXT_lights_ies\":{\"light\":0,"
    "\"multiplier\":0.5,\"color\":[1,0.5,0.25]}}},"
    "{\"extensions\":{\"EXT_lights_ies\":{\"light\":1}}},{\"extensions\":{\"EXT_lights_ies\":{\"light\":2}}}]}";

static void test_lights_of_files_MA_11(void **state) {
    UNUSED(state);
    char json[3000];
    fnl_scene *scene = NULL, *into = NULL;
    snprintf(json, sizeof json, with_lamps, sizeof lamp - 1, sizeof lamp - 1);
    const fnl_result result = test_load(&file_log, json, lamp, sizeof lamp - 1, &scene);
    if (result != FNL_OK) fail_msg("%s", file_log.text);
    if (file_log.count != 1 || !strstr(file_log.text, "/extensions/EXT_lights_ies/lights/2/uri: is no light profile: ")) fail_msg("%s", file_log.text);
    assert_string_equal(scene->extensions.data[0].treatment, "full");
    assert_int_equal(scene->lights.count, 2);
    const fnl_light_params *light = &scene->lights.data[0].params;
    assert_true(light->kind == FNL_LIGHT_POINT && light->intensity == 40 && light->color[1] == 0.5f && light->position.y == 2);
    assert_true(fabsf(light->direction.y + 1) < 1e-6f && fabsf(light->up.z + 1) < 1e-6f); /* the node's -Z and +Y */
    assert_string_equal(scene->lights.data[0].name, "hall");
    assert_true(scene->lights.data[1].params.intensity == 5);
    assert_true(scene_light_profile(scene, light)->candela == 80);
    /* As a part of a scene that has a profile already. */
    struct loaded l = load(HEAD("2 1") "0 180\n0\n100 50\n");
    into = l.scene;
    fnl_loaded part;
    const uint32_t floats = into->profile_floats.end, messages = into->messages.count, lights = fnl_scene_count(into, FNL_ENTITY_LIGHT);
    assert_int_equal(scene_merge(into, SCENE_NONE, scene, &part), FNL_OK);
    fnl_scene_destroy(&scene);
    assert_int_equal(into->profiles.count, 3);
    light = &into->lights.data[0].params;
    assert_true(scene_light_profile(into, light)->candela == 80 && scene_light_profile(into, light)->offset > into->profiles.data[0].offset);
    /* A light outside of the file keeps its profile, until it goes too. */
    fnl_light_params other = *light;
    fnl_light_id id;
    assert_int_equal(fnl_scene_add_light(into, &other, &id), FNL_OK);
    assert_int_equal(fnl_scene_remove_instance(into, part.root), FNL_OK);
    assert_int_equal(fnl_scene_count(into, FNL_ENTITY_LIGHT), lights + 1);
    assert_true(scene_light_profile(into, &other)->candela == 80 && into->profile_floats.end > floats);
    assert_int_equal(fnl_scene_remove_light(into, id), FNL_OK);
    assert_true(into->profile_floats.end == floats && into->hole_counts[SCENE_PROFILES] == 2);
    assert_int_equal(fnl_scene_remove_light_profile(into, other.profile), FNL_ERROR_INVALID);
    assert_int_equal(into->messages.count, messages);
    assert_int_equal(into->parts.count, 0);
    fnl_scene_destroy(&into);
}

static void count_error(void *user, fnl_log_level level, const char *line) {
    struct test_memory *memory = user;
    if (level != FNL_LOG_ERROR) return;
    atomic_fetch_add(&memory->errors, 1);
    snprintf(memory->last_error, sizeof memory->last_error, "%s", line);
}

/* Only the allocation at `fail_at` fails: those after it would be told, and hide that it was not. */
static void *fail_once(void *user, void *old, size_t old_size, size_t new_size) {
    struct test_memory *memory = user;
    const long long fail_at = atomic_load(&memory->fail_at);
    if (new_size && fail_at && atomic_load(&memory->allocations) + 1 == fail_at) {
        atomic_fetch_add(&memory->allocations, 1);
        return NULL;
    }
    atomic_store(&memory->fail_at, 0);
    void *block = test_memory_reallocate(user, old, old_size, new_size);
    atomic_store(&memory->fail_at, fail_at);
    return block;
}

/* Adds a profile to a scene, or loads a file with profiles, whose reader keeps the lines of a profile to itself. */
static fnl_result make(const fnl_host *host, bool file, fnl_scene *scene) {
    fnl_light_profile_id id;
    if (!file) return fnl_scene_add_light_profile(scene, "a name that takes some room.ies", lamp, sizeof lamp - 1, &id, NULL);
    char json[3000];
    size_t size;
    fnl_scene *loaded = NULL;
    snprintf(json, sizeof json, with_lamps, sizeof lamp - 1, sizeof lamp - 1);
    unsigned char *glb = test_glb(json, lamp, sizeof lamp - 1, &size);
    const fnl_result result = gltf_load_memory(host, glb, size, "lamps.glb", NULL, &loaded);
    free(glb);
    fnl_scene_destroy(&loaded);
    return result;
}

/* Each allocation fails in turn: an error is told, and nothing is kept. */
static void test_a_lack_of_memory_is_told(void **state) {
    UNUSED(state);
    for (int file = 0; file < 2; file++) {
        struct test_memory memory = {0};
        fnl_scene *scene;
        fnl_host host = fnl_host_default();
        host.user = &memory;
        host.reallocate = fail_once;
        host.log = count_error;
        uint32_t failures = 0;
        bool reached = true;
        for (long long n = 1; reached; n++) {
            assert_int_equal(fnl_scene_create(&host, &scene), FNL_OK);
            const long long before = memory.allocations;
            memory.errors = 0;
            memory.fail_at = before + n;
            const fnl_result result = make(&host, file, scene);
            memory.fail_at = 0;
            reached = memory.allocations - before >= n;
            assert_true(result == FNL_OK || result == FNL_ERROR_MEMORY);
            if (result == FNL_ERROR_MEMORY && memory.errors == 0) fail_msg("nothing is told of allocation %lld, which fails", n);
            if (result == FNL_ERROR_MEMORY && !file && !strstr(memory.last_error, "room.ies: memory ran out")) fail_msg("the name is missing: %s", memory.last_error);
            failures += result == FNL_ERROR_MEMORY;
            fnl_scene_destroy(&scene);
            assert_int_equal(memory.live_bytes, 0);
        }
        if (failures < (file ? 15u : 3u)) fail_msg("only %u allocations failed", failures);
        assert_int_equal(memory.wrong_sizes, 0);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_round_profile_MA_11),      cmocka_unit_test(test_the_last_vertical_angle_MA_11),
        cmocka_unit_test(test_a_lack_of_memory_is_told),
        cmocka_unit_test(test_horizontal_symmetries_MA_11),
        cmocka_unit_test(test_profile_directions_MA_11), cmocka_unit_test(test_odd_files_MA_11),
        cmocka_unit_test(test_broken_files_MA_11),       cmocka_unit_test(test_lights_take_profiles_MA_11),
        cmocka_unit_test(test_lights_of_files_MA_11),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
