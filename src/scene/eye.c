/* SPDX-License-Identifier: MIT */
/* Cameras of eyes. */
#include "scene/eye.h"

#include "base/maths.h"

fnl_result rigid_pose_check(const struct call *call, const char *name, const fnl_rigid_pose *pose) {
    const vec3 at = pose->position;
    const quat q = pose->rotation;
    const float length = sqrtf(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w);
    if (!vec3_finite(at)) return misuse(call, "%s.position is %g, %g, %g, must be finite", name, (double)at.x, (double)at.y, (double)at.z);
    if (fabsf(length - 1) < 1e-3f) return FNL_OK;
    return misuse(call, "%s.rotation is %g, %g, %g, %g, must be a unit quaternion", name, (double)q.x, (double)q.y, (double)q.z, (double)q.w);
}

fnl_result edges_check(const struct call *call, const char *name, float left, float right, float down, float up) {
    const float most = 1e4f;
    if (left < right && down < up && left >= -most && right <= most && down >= -most && up <= most) return FNL_OK;
    return misuse(call, "%s: edges are %g .. %g and %g .. %g, must ascend and lie within %g",
                  name, (double)left, (double)right, (double)down, (double)up, (double)most);
}

fnl_result eye_check(const struct call *call, const fnl_eye *eye) {
    TRY(check_pointer(call, "eye", eye));
    TRY(rigid_pose_check(call, "eye->pose", &eye->pose));
    return edges_check(call, "eye", eye->left, eye->right, eye->down, eye->up);
}

fnl_result fnl_eye_query_camera(const fnl_host *host, const fnl_eye *eye, const fnl_rigid_pose *head, uint32_t width, uint32_t height,
                                float near_distance, fnl_camera *out) {
    const fnl_host resolved = host_resolve(host);
    const struct call *call = CALL(&resolved);
    TRY(check_pointer(call, "head", head));
    TRY(check_pointer(call, "out", out));
    TRY(eye_check(call, eye));
    TRY(rigid_pose_check(call, "head", head));
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
