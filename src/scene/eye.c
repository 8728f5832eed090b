/* SPDX-License-Identifier: MIT */
/* Cameras of eyes. */
#include "fanal/stereo.h"
#include "base/check.h"
#include "base/maths.h"

static fnl_result check_pose(const struct call *call, const char *position, const char *rotation, const fnl_rigid_pose *pose) {
    TRY(check_finite(call, position, pose->position));
    const quat q = pose->rotation;
    float length = sqrtf(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w);
    return fabsf(length - 1) < 1e-3f ? FNL_OK : misuse(call, "%s is %g, %g, %g, %g, must be a unit quaternion", rotation, (double)q.x, (double)q.y, (double)q.z, (double)q.w);
}

static fnl_result check_edges(const struct call *call, const fnl_eye *eye) {
    const double most = 1e4;
    TRY(check_range(call, "eye->left", (double)eye->left, -most, most, ""));
    TRY(check_above(call, "eye->right", (double)eye->right, (double)eye->left, most, " (left)"));
    TRY(check_range(call, "eye->down", (double)eye->down, -most, most, ""));
    return check_above(call, "eye->up", (double)eye->up, (double)eye->down, most, " (down)");
}

fnl_result fnl_eye_query_camera(const fnl_host *host, const fnl_eye *eye, const fnl_rigid_pose *head, uint32_t width, uint32_t height,
                                float near_distance, fnl_camera *out) {
    const fnl_host resolved = host_resolve(host);
    const struct call *call = CALL(&resolved);
    TRY(check_pointer(call, "eye", eye));
    TRY(check_pointer(call, "head", head));
    TRY(check_pointer(call, "out", out));
    TRY(check_pose(call, "eye->pose.position", "eye->pose.rotation", &eye->pose));
    TRY(check_pose(call, "head->position", "head->rotation", head));
    TRY(check_edges(call, eye));
    TRY(check_count(call, "width", width, 1, 16384));
    TRY(check_count(call, "height", height, 1, 16384));
    TRY(check_above(call, "near_distance", (double)near_distance, 0, (double)FLT_MAX, " metres"));

    const vec3 one = vec3_make(1, 1, 1);
    const mat4 of_head = mat4_from_trs(head->position, quat_normalize(head->rotation), one),
               of_eye = mat4_from_trs(eye->pose.position, quat_normalize(eye->pose.rotation), one), world = mat4_mul(of_head, of_eye);
    const float *m = world.m;
    fnl_camera camera = fnl_camera_default();
    camera.position = vec3_make(m[12], m[13], m[14]);
    /* Far from the origin a target one metre away would round the direction. */
    camera.target = vec3_add_scaled(camera.position, vec3_make(-m[8], -m[9], -m[10]), fmaxf(1, 0.1f * vec3_length(camera.position)));
    camera.up = vec3_make(m[4], m[5], m[6]);
    const float across = eye->right - eye->left, along = eye->up - eye->down;
    camera.vertical_fov = 2 * atanf(along / 2);
    camera.pixel_aspect = across / along * (float)height / (float)width;
    camera.shift = (fnl_vec2){-(eye->right + eye->left) / across, -(eye->up + eye->down) / along};
    camera.near_distance = near_distance;
    *out = camera;
    return FNL_OK;
}
