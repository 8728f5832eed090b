/* SPDX-License-Identifier: MIT */
/** Where fnl_scene_place_probes finds rooms, and where it finds none. */
#include "scene/scene.h"
#include "tests/test_memory.h"

#include <setjmp.h>

#include <cmocka.h>

static struct test_memory memory;

static fnl_host host(void) {
    fnl_host out = fnl_host_default();
    out.user = &memory;
    out.reallocate = test_memory_reallocate;
    return out;
}

static fnl_scene *create(void) {
    const fnl_host h = host();
    fnl_scene *scene;
    assert_int_equal(fnl_scene_create(&h, &scene), FNL_OK);
    return scene;
}

static fnl_scene *load(const char *source) {
    const fnl_host h = host();
    fnl_scene *scene;
    assert_int_equal(fnl_scene_load(&h, source, NULL, &scene), FNL_OK);
    return scene;
}

static int no_memory_is_left(void **state) {
    UNUSED(state);
    assert_true(memory.live_bytes == 0 && memory.wrong_sizes == 0);
    return 0;
}

/* ---- scenes ---- */

/* A box whose faces look out of it, or with `inwards` into it. */
static fnl_instance_id add_box(fnl_scene *scene, vec3 low, vec3 high, bool inwards, const mat4 *placed) {
    static const uint32_t corners[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
    float positions[24];
    uint32_t indices[36];
    for (uint32_t i = 0; i < 8; i++) {
        positions[3 * i] = i & 1 ? high.x : low.x;
        positions[3 * i + 1] = i & 2 ? high.y : low.y;
        positions[3 * i + 2] = i & 4 ? high.z : low.z;
    }
    for (uint32_t f = 0; f < 6; f++) {
        const uint32_t *c = corners[f], quad[6] = {c[0], c[1], c[2], c[0], c[2], c[3]};
        for (uint32_t k = 0; k < 6; k++) indices[6 * f + k] = quad[inwards ? k / 3 * 3 + 2 - k % 3 : k];
    }
    const fnl_mesh_params mesh = {.vertex_count = 8, .index_count = 36, .positions = positions, .indices = indices};
    fnl_mesh_id id;
    fnl_instance_id instance;
    assert_int_equal(fnl_scene_add_mesh(scene, &mesh, &id), FNL_OK);
    assert_int_equal(fnl_scene_add_instance(scene, id, placed, &instance), FNL_OK);
    return instance;
}

/* Rooms of 4 x 2.8 x 5 and 6 x 2.8 x 3 m in one shell of walls 0.2 m thick, with a door of 0.9 x 2 m between them and a window of 1.5 x 1.2 m in the second. */
static const vec3 first_low = {0, 0, 0}, first_high = {4, 2.8f, 5}, second_low = {4.2f, 0, 1}, second_high = {10.2f, 2.8f, 4};
static fnl_instance_id add_rooms(fnl_scene *scene, const mat4 *placed) {
    const fnl_instance_id door = add_box(scene, vec3_make(4, 0, 2.9f), vec3_make(4.2f, 2, 3.4f), false, placed); /* closed but for 0.4 m */
    add_box(scene, vec3_make(-0.2f, -0.2f, -0.2f), vec3_make(10.4f, 0, 5.2f), false, placed);
    add_box(scene, vec3_make(-0.2f, 2.8f, -0.2f), vec3_make(10.4f, 3, 5.2f), false, placed);
    add_box(scene, vec3_make(-0.2f, 0, -0.2f), vec3_make(0, 2.8f, 5.2f), false, placed);
    add_box(scene, vec3_make(0, 0, -0.2f), vec3_make(4.2f, 2.8f, 0), false, placed);
    add_box(scene, vec3_make(0, 0, 5), vec3_make(4.2f, 2.8f, 5.2f), false, placed);
    add_box(scene, vec3_make(4, 0, 0), vec3_make(4.2f, 2.8f, 2.5f), false, placed); /* the wall with the door */
    add_box(scene, vec3_make(4, 0, 3.4f), vec3_make(4.2f, 2.8f, 5), false, placed);
    add_box(scene, vec3_make(4, 2, 2.5f), vec3_make(4.2f, 2.8f, 3.4f), false, placed);
    add_box(scene, vec3_make(4.2f, 0, 0.8f), vec3_make(10.4f, 2.8f, 1), false, placed);
    add_box(scene, vec3_make(4.2f, 0, 4), vec3_make(10.4f, 2.8f, 4.2f), false, placed);
    add_box(scene, vec3_make(10.2f, 0, 1), vec3_make(10.4f, 0.9f, 4), false, placed); /* and the one with the window */
    add_box(scene, vec3_make(10.2f, 2.1f, 1), vec3_make(10.4f, 2.8f, 4), false, placed);
    add_box(scene, vec3_make(10.2f, 0.9f, 1), vec3_make(10.4f, 2.1f, 1.7f), false, placed);
    add_box(scene, vec3_make(10.2f, 0.9f, 3.2f), vec3_make(10.4f, 2.1f, 4), false, placed);
    add_box(scene, vec3_make(1.2f, 0, 1.5f), vec3_make(2.8f, 0.8f, 3.5f), false, placed); /* a table, a cupboard, a pillar */
    add_box(scene, vec3_make(0.02f, 0, 3.8f), vec3_make(0.6f, 2, 4.9f), false, placed);
    add_box(scene, vec3_make(7, 0, 2.3f), vec3_make(7.3f, 2.8f, 2.6f), false, placed);
    return door;
}

static uint32_t place(fnl_scene *scene, uint32_t most) {
    uint32_t count;
    assert_int_equal(fnl_scene_place_probes(scene, NULL, most, &count), FNL_OK);
    assert_int_equal(fnl_scene_count(scene, FNL_ENTITY_PROBE), count);
    return count;
}

static fnl_probe_params probe(const fnl_scene *scene, uint32_t index) {
    fnl_probe_params out;
    assert_int_equal(fnl_scene_query_probe(scene, index, &out), FNL_OK);
    return out;
}

static void assert_box(const fnl_probe_params *p, vec3 low, vec3 high, float within) {
    const vec3 got[2] = {vec3_sub(p->centre, p->half_size), vec3_add(p->centre, p->half_size)}, want[2] = {low, high};
    for (int end = 0; end < 2; end++)
        for (int k = 0; k < 3; k++) {
            const float a = (&got[end].x)[k], b = (&want[end].x)[k];
            if (!(fabsf(a - b) <= within)) fail_msg("%s %c is %g, not %g", end ? "high" : "low", "xyz"[k], (double)a, (double)b);
        }
}

/* ---- tests ---- */

static void test_a_box_room_is_one_box(void **state) {
    UNUSED(state);
    fnl_scene *scene = load("builtin:room");
    const uint32_t own = fnl_scene_count(scene, FNL_ENTITY_PROBE);
    uint32_t count;
    fnl_probe_params params = fnl_probe_params_default();
    params.reflection = true;
    params.priority = 3;
    params.centre.x = 100;
    assert_int_equal(fnl_scene_place_probes(scene, &params, 16, &count), FNL_OK);
    assert_int_equal(count, 1);
    const fnl_probe_params p = probe(scene, own);
    assert_box(&p, vec3_make(-3, 0, -4), vec3_make(3, 3, 4), 1e-3f);
    assert_true(p.reflection && p.priority == 3 && p.wall == params.wall);
    fnl_scene_destroy(&scene);
    scene = load("builtin:room?cave=40"); /* walls that come up to 0.4 m into the box */
    assert_int_equal(fnl_scene_place_probes(scene, &params, 16, &count), FNL_OK);
    assert_int_equal(count, 1);
    const fnl_probe_params cave = probe(scene, own);
    assert_box(&cave, vec3_make(-3, 0, -4), vec3_make(3, 3, 4), 0.45f);
    assert_true(cave.wall > params.wall);
    fnl_scene_destroy(&scene);
}

static void test_two_rooms_with_a_door_are_two_boxes(void **state) {
    UNUSED(state);
    for (int turned = 0; turned < 2; turned++) {
        const float yaw = turned ? 0.4f : 0;
        const mat4 placed = mat4_from_trs(vec3_make(3, 2, -7), quat_axis_angle(vec3_make(0, 1, 0), yaw), vec3_make(1, 1, 1));
        mat4 back;
        mat4_inverse(&placed, &back);
        fnl_scene *scene = create(), *again = create();
        add_rooms(scene, &placed);
        add_rooms(again, &placed);
        assert_int_equal(place(scene, 16), 2);
        assert_int_equal(place(again, 16), 2);
        for (uint32_t i = 0; i < 2; i++) {
            fnl_probe_params p = probe(scene, i), q = probe(again, i);
            assert_memory_equal(&p, &q, sizeof p); /* the same scene, the same probes */
            const mat4 own = mat4_from_trs(p.centre, p.rotation, vec3_make(1, 1, 1)), local = mat4_mul(back, own);
            const vec3 capture = mat4_point(&local, p.capture);
            p.centre = mat4_point(&local, vec3_make(0, 0, 0));
            if (fabsf(local.m[0]) < 0.7f) p.half_size = vec3_make(p.half_size.z, p.half_size.y, p.half_size.x); /* by a quarter turn more */
            assert_true(fmaxf(fabsf(local.m[0]), fabsf(local.m[2])) > 0.99998f);
            const bool first = p.centre.x < 4;
            assert_int_equal(first, i == 0); /* the larger one comes first */
            if (fabsf(p.wall - 0.1f) > 1e-3f) fail_msg("turned %d, room %u: wall is %g", turned, i, (double)p.wall); /* half of what is between them */
            assert_box(&p, first ? first_low : second_low, first ? first_high : second_high, 1e-3f);
            /* Not in the table or the pillar. */
            assert_false(first ? capture.y < 0.85f && fabsf(capture.x - 2) < 0.85f && fabsf(capture.z - 2.5f) < 1.05f
                               : fabsf(capture.x - 7.15f) < 0.2f && fabsf(capture.z - 2.45f) < 0.2f);
        }
        fnl_scene_destroy(&scene);
        fnl_scene_destroy(&again);
    }
}

static void test_the_number_is_bounded(void **state) {
    UNUSED(state);
    const mat4 identity = mat4_identity();
    fnl_scene *scene = create();
    add_rooms(scene, &identity);
    assert_int_equal(place(scene, 1), 1);
    const fnl_probe_params p = probe(scene, 0);
    assert_box(&p, first_low, first_high, 1e-3f);
    uint32_t count = 7;
    assert_int_equal(fnl_scene_place_probes(scene, NULL, 0, &count), FNL_ERROR_INVALID);
    assert_int_equal(count, 0);
    assert_int_equal(fnl_scene_place_probes(scene, NULL, 65, NULL), FNL_ERROR_INVALID);
    fnl_scene_destroy(&scene);
}

/* The gallery's corridor and its eight rooms. */
static void test_a_gallery_is_nine_boxes(void **state) {
    UNUSED(state);
    fnl_scene *scene = load("builtin:interior");
    const uint32_t count = place(scene, 16);
    uint32_t corridor = 0, left = 0, right = 0;
    for (uint32_t i = 0; i < count; i++) {
        const fnl_probe_params p = probe(scene, i);
        print_message("centre %6.2f %6.2f %6.2f, half size %5.2f %5.2f %5.2f, wall %.2f\n", (double)p.centre.x, (double)p.centre.y, (double)p.centre.z,
                      (double)p.half_size.x, (double)p.half_size.y, (double)p.half_size.z, (double)p.wall);
        const bool room = fabsf(p.half_size.x - 4) < 0.3f && fabsf(p.half_size.z - 4.4f) < 0.4f;
        assert_true(fabsf(p.wall - 0.15f) < 1e-3f);
        corridor += fabsf(p.centre.x) < 0.3f && fabsf(p.half_size.x - 3.2f) < 0.3f && p.half_size.z > 17;
        left += room && p.centre.x < -7;
        right += room && p.centre.x > 7;
    }
    assert_true(count == 9 && corridor == 1 && left == 4 && right == 4);
    fnl_scene_destroy(&scene);
}

/* A thing seen from outside has no room in it; nor has nothing, or a plane. What is hidden is not there. */
static void test_no_rooms(void **state) {
    UNUSED(state);
    const mat4 identity = mat4_identity();
    fnl_scene *scene = create();
    assert_int_equal(place(scene, 16), 0);
    const fnl_instance_id shell = add_box(scene, vec3_make(-9, -9, -9), vec3_make(9, 9, 9), true, &identity);
    add_box(scene, vec3_make(-1, 0, -2), vec3_make(1, 3, 2), false, &identity);
    assert_int_equal(fnl_scene_set_instance_visible(scene, shell, false), FNL_OK);
    assert_int_equal(place(scene, 16), 1);
    fnl_probe_params p = probe(scene, 0);
    assert_box(&p, vec3_make(-1, 0, -2), vec3_make(1, 3, 2), 1e-5f);
    assert_int_equal(fnl_scene_set_instance_visible(scene, shell, true), FNL_OK);
    uint32_t count;
    assert_int_equal(fnl_scene_place_probes(scene, NULL, 16, &count), FNL_OK);
    assert_int_equal(count, 1);
    p = probe(scene, 1);
    assert_box(&p, vec3_make(-9, -9, -9), vec3_make(9, 9, 9), 1e-3f);
    assert_true(p.capture.y < -0.2f); /* the thing is in the middle */
    fnl_scene_destroy(&scene);
    scene = create();
    add_box(scene, vec3_make(-1, 0, -1), vec3_make(1, 0, 1), true, &identity);
    assert_int_equal(place(scene, 16), 0);
    fnl_scene_destroy(&scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_a_box_room_is_one_box, no_memory_is_left),
        cmocka_unit_test_teardown(test_two_rooms_with_a_door_are_two_boxes, no_memory_is_left),
        cmocka_unit_test_teardown(test_the_number_is_bounded, no_memory_is_left),
        cmocka_unit_test_teardown(test_a_gallery_is_nine_boxes, no_memory_is_left),
        cmocka_unit_test_teardown(test_no_rooms, no_memory_is_left),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
