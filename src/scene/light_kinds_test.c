/* SPDX-License-Identifier: MIT */
/* The rows of light kinds agree with the calls and with files, and outlines with the volumes of lights. */
#include "scene/light_kinds.h"

#include "scene/scene.h"
#include "tests/gltf_test_file.h"

#include <setjmp.h>
#include <unistd.h>

#include <cmocka.h>

static struct test_log lines;

static fnl_light_params light_of(fnl_light_kind kind) {
    fnl_light_params light = fnl_light_params_default();
    light.kind = kind;
    return light;
}

static fnl_scene *empty_scene(void) {
    fnl_scene *scene;
    fnl_host host = test_host(&lines);
    assert_int_equal(fnl_scene_create(&host, &scene), FNL_OK);
    return scene;
}

static bool is_accepted(fnl_scene *scene, const fnl_light_params *light) {
    fnl_light_id id;
    return fnl_scene_add_light(scene, light, &id) == FNL_OK;
}

/* What a call does with one value of a member; the member that limits it is as large as it can be. */
static bool takes(fnl_scene *scene, fnl_light_kind kind, const fnl_light_member *member, uint32_t i, float value) {
    fnl_light_params light = light_of(kind);
    if (member->at_most) {
        const fnl_light_member *limit = light_member_find(&light_kinds[kind].info, member->at_most);
        *(float *)light_value(&light, limit) = limit->high;
    }
    ((float *)light_value(&light, member))[i] = value;
    return is_accepted(scene, &light);
}

static void check_member(fnl_scene *scene, fnl_light_kind kind, const fnl_light_member *member) {
    const fnl_light_params usual = light_of(kind);
    assert_true(member->offset > 0 && member->offset + light_member_size(member) <= sizeof usual && member->count >= 1 && member->count <= 3);
    for (uint32_t i = 0; i < member->count; i++) assert_true(member->labels[i] && *member->labels[i]);
    assert_non_null(member->hint);
    if (member->unit == FNL_LIGHT_UNIT_SWITCH) {
        assert_int_equal(*(const bool *)light_value_of(&usual, member), member->defaults[0] > 0);
        return;
    }
    assert_memory_equal(light_value_of(&usual, member), member->defaults, light_member_size(member));
    for (uint32_t i = 0; i < member->count; i++) {
        assert_int_equal(takes(scene, kind, member, i, member->low), !member->above_low);
        assert_true(takes(scene, kind, member, i, nextafterf(member->low, INFINITY)) && takes(scene, kind, member, i, member->high));
        assert_true(takes(scene, kind, member, i, fmaxf(member->low, member->useful_low)));
        assert_false(takes(scene, kind, member, i, nextafterf(member->low, -INFINITY)));
        assert_false(takes(scene, kind, member, i, nextafterf(member->high, INFINITY)));
    }
}

static void test_rows_say_what_calls_take(void **state) {
    UNUSED(state);
    fnl_scene *scene = empty_scene();
    for (fnl_light_kind kind = 0; kind < FNL_LIGHT_KIND_COUNT; kind++) {
        const fnl_light_kind_info *info = fnl_light_kind_find(kind);
        assert_non_null(info);
        for (uint32_t i = 0; i < info->member_count; i++) check_member(scene, kind, &info->members[i]);
        fnl_light_params light = light_of(kind);
        light.range = -1;
        assert_int_equal(is_accepted(scene, &light), !info->has_range);
        light = light_of(kind);
        light.source_radius = -1;
        assert_int_equal(is_accepted(scene, &light), !info->has_source_radius);
        light = light_of(kind);
        light.source_angle = -1;
        assert_int_equal(is_accepted(scene, &light), !info->has_source_angle);
        light = light_of(kind);
        light.direction = (vec3){0, 0, 0};
        assert_int_equal(is_accepted(scene, &light), !info->has_direction);
    }
    assert_null(fnl_light_kind_find(FNL_LIGHT_KIND_COUNT));
    assert_null(fnl_light_kind_find((fnl_light_kind)-1));
    fnl_scene_destroy(&scene);
}

static void test_keys_are_names_in_camel_case(void **state) {
    UNUSED(state);
    char key[LIGHT_KEY];
    assert_string_equal(light_member_key(light_member_find(&light_kinds[FNL_LIGHT_WEDGE].info, "wedge_angles"), key), "wedgeAngles");
    assert_string_equal(light_member_key(light_member_find(&light_kinds[FNL_LIGHT_RECTANGLE].info, "two_sided"), key), "twoSided");
    assert_string_equal(light_member_key(light_member_find(&light_kinds[FNL_LIGHT_CAPSULE].info, "length"), key), "length");
}

/* Values that differ from the defaults, from each other and between calls. */
static void change_member(fnl_light_params *light, const fnl_light_member *member, uint32_t turn) {
    if (member->unit == FNL_LIGHT_UNIT_SWITCH) {
        *(bool *)light_value(light, member) = !(member->defaults[0] > 0);
        return;
    }
    for (uint32_t i = 0; i < member->count; i++) ((float *)light_value(light, member))[i] = 0.11f + 0.13f * (float)i + 0.017f * (float)turn;
}

static void test_members_survive_files(void **state) {
    UNUSED(state);
    char path[] = "/tmp/fanal-light-kinds-XXXXXX.glb";
    const int file = mkstemps(path, 4);
    assert_true(file >= 0);
    close(file);
    fnl_scene *scene = empty_scene(), *again;
    for (fnl_light_kind kind = 0; kind < FNL_LIGHT_KIND_COUNT; kind++) {
        fnl_light_params light = light_of(kind);
        for (uint32_t i = 0; i < light_kinds[kind].info.member_count; i++) change_member(&light, &light_kinds[kind].info.members[i], i);
        assert_true(is_accepted(scene, &light));
    }
    assert_int_equal(fnl_scene_save(scene, path, NULL), FNL_OK);
    const fnl_host host = test_host(&lines);
    lines.count = 0;
    assert_int_equal(fnl_scene_load(&host, path, NULL, &again), FNL_OK);
    assert_int_equal(lines.count, 0);
    unlink(path);
    assert_int_equal(fnl_scene_count(again, FNL_ENTITY_LIGHT), FNL_LIGHT_KIND_COUNT);
    for (uint32_t i = 0; i < FNL_LIGHT_KIND_COUNT; i++) {
        fnl_light_params saved, loaded;
        assert_int_equal(fnl_scene_query_light(scene, i, &saved), FNL_OK);
        assert_int_equal(fnl_scene_query_light(again, i, &loaded), FNL_OK);
        assert_int_equal(saved.kind, loaded.kind);
        const fnl_light_kind_info *info = fnl_light_kind_find(saved.kind);
        for (uint32_t k = 0; k < info->member_count; k++)
            assert_memory_equal(light_value_of(&saved, &info->members[k]), light_value_of(&loaded, &info->members[k]), light_member_size(&info->members[k]));
    }
    fnl_scene_destroy(&scene);
    fnl_scene_destroy(&again);
}

/* ---- outlines ---- */

enum { MOST = 64 };

static fnl_light_params placed_light(fnl_light_kind kind) {
    fnl_light_params light = light_of(kind);
    light.position = (vec3){1, 2, 3};
    light.direction = (vec3){0.6f, 0, -0.8f};
    light.up = (vec3){0, 1, 0};
    light.range = 10;
    return light;
}

static vec3 seen_from(const fnl_light_params *light, vec3 point) {
    const vec3 ray = vec3_sub(point, light->position);
    return (vec3){vec3_dot(ray, vec3_cross(light->direction, light->up)), vec3_dot(ray, light->up), vec3_dot(ray, light->direction)};
}

static bool is_near(float a, float b) { return fabsf(a - b) < 1e-5f; }

/* On the border of the shape, or at the apex of a cone or pyramid. */
static bool is_on_outline(const fnl_light_params *light, vec3 p, float length) {
    const bool apex = vec3_length(p) < 1e-5f;
    switch (light->kind) {
    case FNL_LIGHT_SPOT:
        return apex || (is_near(vec3_length(p), length) && is_near(p.z, length * cosf(light->outer_cone_angle)));
    case FNL_LIGHT_CAPSULE:
        return is_near(p.x, 0) && is_near(p.y, 0) && is_near(fabsf(p.z), light->length / 2);
    case FNL_LIGHT_WEDGE:
        return apex || (is_near(vec3_length(p), length) && is_near(fabsf(p.x), p.z * tanf(light->wedge_angles[0])) &&
                        is_near(fabsf(p.y), p.z * tanf(light->wedge_angles[1])));
    case FNL_LIGHT_BOX:
        return is_near(fabsf(p.x), light->box_size.x / 2) && is_near(fabsf(p.y), light->box_size.y / 2) && is_near(fabsf(p.z), light->box_size.z / 2);
    default: /* the ray of a rectangle starts at its center */
        return (is_near(p.x, 0) && is_near(p.y, 0) && p.z >= -1e-5f) ||
               (is_near(fabsf(p.x), light->rectangle_size[0] / 2) && is_near(fabsf(p.y), light->rectangle_size[1] / 2) && is_near(p.z, 0));
    }
}

static void test_outlines_follow_shapes(void **state) {
    UNUSED(state);
    static const uint32_t lines_of[FNL_LIGHT_KIND_COUNT] = {[FNL_LIGHT_SPOT] = 16, [FNL_LIGHT_CAPSULE] = 1, [FNL_LIGHT_WEDGE] = 8, [FNL_LIGHT_BOX] = 12, [FNL_LIGHT_RECTANGLE] = 5};
    for (fnl_light_kind kind = 0; kind < FNL_LIGHT_KIND_COUNT; kind++) {
        fnl_light_params light = placed_light(kind);
        light.box_size = (vec3){1, 2, 4};
        light.rectangle_size[1] = 3;
        vec3 points[MOST], fewer[MOST];
        const uint32_t count = fnl_light_outline(&light, 2.5f, MOST, points);
        assert_int_equal(count, 2 * lines_of[kind]);
        for (uint32_t i = 0; i < count; i++) assert_true(is_on_outline(&light, seen_from(&light, points[i]), 2.5f));
        for (uint32_t i = 0; i < count; i += 2) assert_true(vec3_distance(points[i], points[i + 1]) > 0.1f);
        for (uint32_t i = 0; i < MOST; i++) fewer[i] = (vec3){77, 77, 77};
        assert_int_equal(fnl_light_outline(&light, 2.5f, 3, fewer), count);
        assert_int_equal(fnl_light_outline(&light, 2.5f, 0, NULL), count);
        assert_memory_equal(fewer, points, MIN(count, 3u) * sizeof *points);
        for (uint32_t i = MIN(count, 3u); i < MOST; i++) assert_true(fewer[i].x == 77);
    }
    const fnl_light_params none = {.kind = FNL_LIGHT_KIND_COUNT};
    assert_int_equal(fnl_light_outline(&none, 1, 0, NULL), 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_rows_say_what_calls_take),
        cmocka_unit_test(test_keys_are_names_in_camel_case),
        cmocka_unit_test(test_members_survive_files),
        cmocka_unit_test(test_outlines_follow_shapes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
