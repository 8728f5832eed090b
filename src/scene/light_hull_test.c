/* SPDX-License-Identifier: MIT */
/* Shapes of lights on the CPU: the planes of hulls against their points, what is refused, and axes. */
#include "tests/gltf_test_file.h"

#include <setjmp.h>

#include <cmocka.h>

static struct test_log test_lines;

static struct light_hull *hull_of(const vec3 *points, uint32_t count) {
    fnl_host host = host_resolve(NULL);
    struct light_hull *hull;
    assert_int_equal(light_hull_create(&host, points, count, &hull), FNL_OK);
    return hull;
}

static double highest(const struct light_hull *hull, vec3 p) {
    double worst = -INFINITY;
    for (uint32_t i = 0; i < hull->plane_count; i++) {
        const double *n = hull->planes[i];
        worst = fmax(worst, n[0] * (double)p.x + n[1] * (double)p.y + n[2] * (double)p.z + n[3]);
    }
    return worst;
}

static void test_boxes_have_six_planes(void **state) {
    UNUSED(state);
    struct random_state random = {4};
    for (int turn = 0; turn < 20; turn++) {
        vec3 axis = vec3_normalize(vec3_make(random_range(&random, -1, 1), random_range(&random, -1, 1), 0.3f));
        mat4 m = mat4_from_trs(vec3_make(random_range(&random, -90, 90), 5, 7),
                               turn == 0 ? quat_identity() : quat_axis_angle(axis, random_range(&random, 0, 6)),
                               vec3_make(1, random_range(&random, 0.1f, 9), 2));
        vec3 points[9];
        for (int i = 0; i < 8; i++) points[i] = mat4_point(&m, vec3_make(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1));
        points[8] = mat4_point(&m, vec3_make(0.3f, 0.2f, 0.9f)); /* inside: no part of it */
        struct light_hull *hull = hull_of(points, 9);
        if (turn == 0) assert_int_equal(hull->plane_count, 6);
        assert_in_range(hull->plane_count, 6, 12); /* rounding may bend a side */
        for (int i = 0; i < 500; i++) {
            vec3 p = {random_range(&random, -1.5f, 1.5f), random_range(&random, -1.5f, 1.5f),
                      random_range(&random, -1.5f, 1.5f)};
            float out = fmaxf(fabsf(p.x), fmaxf(fabsf(p.y), fabsf(p.z)));
            if (fabsf(out - 1) < 1e-2f) continue;
            assert_true((highest(hull, mat4_point(&m, p)) > 0) == (out > 1));
        }
        float radius = sqrtf(5 + m.m[4] * m.m[4] + m.m[5] * m.m[5] + m.m[6] * m.m[6]);
        assert_true(hull->radius >= radius * 0.9999f && hull->radius < radius * 1.02f);
        free(hull);
    }
}

/* Points on a ball: every plane touches some, none is passed, and all normals point outward. */
static void test_random_hulls_hold_their_points(void **state) {
    UNUSED(state);
    static const uint32_t counts[] = {4, 5, 6, 13, 40, 64};
    struct random_state random = {11};
    for (uint32_t c = 0; c < COUNT_OF(counts) * 3; c++) {
        vec3 points[64], middle = {0, 0, 0};
        uint32_t count = counts[c / 3];
        float scale = c % 3 == 0 ? 1.0f : c % 3 == 1 ? 1e-3f : 1e4f;
        for (uint32_t i = 0; i < count; i++) {
            vec3 p;
            do p = vec3_make(random_range(&random, -1, 1), random_range(&random, -1, 1), random_range(&random, -1, 1));
            while (!(vec3_length(p) > 0.1f));
            points[i] = vec3_scale(vec3_normalize(p), scale);
            middle = vec3_add_scaled(middle, points[i], 1 / (float)count);
        }
        struct light_hull *hull = hull_of(points, count);
        assert_int_equal(hull->plane_count, 2 * count - 4); /* all points are corners, all faces triangles */
        assert_true(highest(hull, middle) < 0);
        for (uint32_t i = 0; i < count; i++) {
            double out = highest(hull, points[i]);
            assert_true(fabs(out) < 1e-6 * (double)scale);
            assert_true(vec3_distance(points[i], hull->center) <= hull->radius);
        }
        free(hull);
    }
}

static void test_flat_points_are_refused(void **state) {
    UNUSED(state);
    fnl_host host = test_host(&test_lines);
    fnl_scene *scene;
    assert_int_equal(fnl_scene_create(&host, &scene), FNL_OK);
    fnl_light_params lamp = fnl_light_params_default();
    fnl_light_id light;
    assert_int_equal(fnl_scene_add_light(scene, &lamp, &light), FNL_OK);
    vec3 good[5] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}}, bad[5];
    assert_int_equal(fnl_scene_set_light_hull(scene, light, good, 5), FNL_OK);
    assert_int_equal(scene->hull_plane_count, 6);
    static const char *const messages[] = {"in one place", "on one line", "in one plane"};
    for (int kind = 0; kind < 3; kind++) {
        for (uint32_t i = 0; i < 5; i++) {
            float t = (float)i * 0.7f - 1, u = kind == 2 ? (float)(i * i) * 0.3f : 0;
            if (kind == 0) t = 0.3f;
            bad[i] = vec3_make(2 * t, 5 + t + u, t - 3 * u);
        }
        test_host(&test_lines);
        assert_int_equal(fnl_scene_set_light_hull(scene, light, bad, 5), FNL_ERROR_INVALID);
        if (!strstr(test_lines.text, messages[kind])) fail_msg("no '%s' in: %s", messages[kind], test_lines.text);
        assert_int_equal(scene->hull_plane_count, 6); /* the old one is still there */
    }
    assert_int_equal(fnl_scene_set_light_hull(scene, light, good, 3), FNL_ERROR_INVALID);
    assert_int_equal(fnl_scene_set_light_hull(scene, light, good, 65), FNL_ERROR_INVALID);
    good[4].y = NAN;
    assert_int_equal(fnl_scene_set_light_hull(scene, light, good, 5), FNL_ERROR_INVALID);
    assert_int_equal(fnl_scene_set_light_hull(scene, light, NULL, 5), FNL_ERROR_INVALID);
    assert_int_equal(fnl_scene_set_light_hull(scene, light, NULL, 0), FNL_OK);
    assert_int_equal(scene->hull_plane_count, 0);
    assert_int_equal(fnl_scene_set_light_hull(scene, light, good, 4), FNL_OK);
    assert_int_equal(fnl_scene_remove_light(scene, light), FNL_OK);
    assert_int_equal(scene->hull_plane_count, 0);
    assert_int_equal(fnl_scene_set_light_hull(scene, light, good, 4), FNL_ERROR_INVALID);
    fnl_scene_destroy(&scene);
}

static void test_shapes_are_checked(void **state) {
    UNUSED(state);
    fnl_host host = test_host(&test_lines);
    fnl_scene *scene;
    assert_int_equal(fnl_scene_create(&host, &scene), FNL_OK);
    for (int i = 0; i < 8; i++) {
        fnl_light_params lamp = fnl_light_params_default();
        static const char *const expected[] = {
            "length is -1, must be at least 0 metres", "wedge_angles[0]",     "wedge_angles[1]", "box_size", "box_size", "inner_fraction",
            "up",          "kind is 7, must be"};
        lamp.kind = i == 0 ? FNL_LIGHT_CAPSULE : i < 3 || i == 6 ? FNL_LIGHT_WEDGE : FNL_LIGHT_BOX;
        if (i == 0) lamp.length = -1;
        if (i == 1) lamp.wedge_angles[0] = 1.6f;
        if (i == 2) lamp.wedge_angles[1] = 0;
        if (i == 3) lamp.box_size.y = 0;
        if (i == 4) lamp.box_size.z = INFINITY;
        if (i == 5) lamp.inner_fraction = 1.1f;
        if (i == 6) lamp.up.z = NAN;
        if (i == 7) lamp.kind = FNL_LIGHT_KIND_COUNT;
        fnl_light_id light;
        test_host(&test_lines);
        assert_int_equal(fnl_scene_add_light(scene, &lamp, &light), FNL_ERROR_INVALID);
        if (!strstr(test_lines.text, expected[i])) fail_msg("no '%s' in: %s", expected[i], test_lines.text);
    }
    static const vec3 directions[] = {{0, -1, 0}, {0, 2, 0}, {1, 1, 1}, {0, 0, -1}, {-1e-5f, 1, 0}};
    for (uint32_t i = 0; i < COUNT_OF(directions); i++) {
        fnl_light_params lamp = fnl_light_params_default(), kept;
        lamp.kind = FNL_LIGHT_BOX;
        lamp.direction = directions[i];
        lamp.up = vec3_make(0, 3, 0);
        fnl_light_id light;
        assert_int_equal(fnl_scene_add_light(scene, &lamp, &light), FNL_OK);
        assert_int_equal(fnl_scene_query_light(scene, i, &kept), FNL_OK);
        assert_true(fabsf(vec3_length(kept.up) - 1) < 1e-6f && fabsf(vec3_dot(kept.up, kept.direction)) < 1e-6f);
        if (i == 2 || i == 3) assert_true(kept.up.y > 0.5f);
    }
    fnl_scene_info info;
    assert_int_equal(fnl_scene_query_info(scene, &info), FNL_OK);
    assert_int_equal(info.light_kind_counts[FNL_LIGHT_BOX], COUNT_OF(directions));
    fnl_scene_destroy(&scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_boxes_have_six_planes),
        cmocka_unit_test(test_random_hulls_hold_their_points),
        cmocka_unit_test(test_flat_points_are_refused),
        cmocka_unit_test(test_shapes_are_checked),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
