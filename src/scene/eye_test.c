/* SPDX-License-Identifier: MIT */
/* Cameras of eyes against the projection of OpenXR, written out: edges of the picture are where their tangents say. */
#include "base/maths.h"
#include "fanal/stereo.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

static const fnl_rigid_pose no_pose = {{0, 0, 0}, {0, 0, 0, 1}};

/* Where a direction of the eye falls in the picture: -1 .. 1 right and up, by what fnl_camera says of its members. */
static vec2 place(const fnl_camera *camera, float width, float height, vec3 world) {
    const mat4 view = mat4_look_at(camera->position, camera->target, camera->up);
    const vec3 p = mat4_point(&view, world);
    const float half_height = tanf(camera->vertical_fov / 2), half_width = half_height * width / height * camera->pixel_aspect;
    return (vec2){p.x / -p.z / half_width + camera->shift.x, p.y / -p.z / half_height + camera->shift.y};
}

static void test_edges_are_where_their_tangents_say(void **state) {
    (void)state;
    const fnl_rigid_pose head = {{3, 1.7f, -2}, quat_axis_angle(vec3_normalize(vec3_make(0.3f, 1, -0.2f)), 1.1f)};
    const fnl_eye eye = {{{-0.032f, 0.01f, 0}, quat_axis_angle(vec3_make(0, 1, 0), 0.17f)}, -1.3f, 0.9f, -1.1f, 1.4f};
    fnl_camera camera;
    assert_int_equal(fnl_eye_query_camera(NULL, &eye, &head, 200, 97, 0.1f, &camera), FNL_OK);
    const mat4 of_head = mat4_from_trs(head.position, head.rotation, vec3_make(1, 1, 1)),
               of_eye = mat4_from_trs(eye.pose.position, eye.pose.rotation, vec3_make(1, 1, 1)), world = mat4_mul(of_head, of_eye);
    for (int corner = 0; corner < 4; corner++) {
        const vec3 seen = {2 * ((corner & 1) ? eye.right : eye.left), 2 * ((corner & 2) ? eye.up : eye.down), -2};
        const vec2 at = place(&camera, 200, 97, mat4_point(&world, seen));
        assert_float_equal(at.x, ((corner & 1) ? 1 : -1), 1e-5f);
        assert_float_equal(at.y, ((corner & 2) ? 1 : -1), 1e-5f);
    }
    assert_float_equal(camera.near_distance, 0.1f, 0);
}

static void test_bad_eyes(void **state) {
    (void)state;
    const fnl_eye good = {no_pose, -1, 1, -1, 1};
    fnl_camera camera;
    assert_int_equal(fnl_eye_query_camera(NULL, &good, &no_pose, 64, 64, 0.1f, &camera), FNL_OK);
    assert_float_equal(camera.pixel_aspect, 1, 1e-6f);
    fnl_eye bad = good;
    bad.right = -1;
    assert_int_equal(fnl_eye_query_camera(NULL, &bad, &no_pose, 64, 64, 0.1f, &camera), FNL_ERROR_INVALID);
    bad = good;
    bad.pose.rotation.w = 2;
    assert_int_equal(fnl_eye_query_camera(NULL, &bad, &no_pose, 64, 64, 0.1f, &camera), FNL_ERROR_INVALID);
    bad = good;
    bad.up = NAN;
    assert_int_equal(fnl_eye_query_camera(NULL, &bad, &no_pose, 64, 64, 0.1f, &camera), FNL_ERROR_INVALID);
    assert_int_equal(fnl_eye_query_camera(NULL, &good, &no_pose, 64, 0, 0.1f, &camera), FNL_ERROR_INVALID);
    assert_int_equal(fnl_eye_query_camera(NULL, &good, &no_pose, 64, 64, 0, &camera), FNL_ERROR_INVALID);
    assert_int_equal(fnl_eye_query_camera(NULL, NULL, &no_pose, 64, 64, 1, &camera), FNL_ERROR_INVALID);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_edges_are_where_their_tangents_say), cmocka_unit_test(test_bad_eyes)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
