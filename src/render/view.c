/* SPDX-License-Identifier: MIT */
#include "render/view.h"

/* A plane (row3 + sign * row) of the clip matrix, scaled so that its normal is unit. */
static vec4 clip_plane(const mat4 *m, int row, float sign) {
    float p[4];
    for (int k = 0; k < 4; k++) p[k] = m->m[k * 4 + 3] + sign * m->m[k * 4 + row];
    float length = sqrtf(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]);
    float scale = length > 0 ? 1 / length : 0;
    return (vec4){p[0] * scale, p[1] * scale, p[2] * scale, p[3] * scale};
}

static void set_planes(struct gpu_view *v) {
    v->planes[0] = clip_plane(&v->world_to_clip, 0, 1);
    v->planes[1] = clip_plane(&v->world_to_clip, 0, -1);
    v->planes[2] = clip_plane(&v->world_to_clip, 1, 1);
    v->planes[3] = clip_plane(&v->world_to_clip, 1, -1);
    v->planes[4] = clip_plane(&v->world_to_clip, 2, -1);
}

/* What an orthographic depth of floats resolves: this part of the distance between its planes, with room to spare. */
#define DEPTH_RANGE 1000

fnl_camera view_fit_depth(const fnl_camera *camera, const struct box *bounds, bool deforms) {
    fnl_camera fitted = *camera;
    if (!camera->orthographic || box_is_empty(bounds)) return fitted;
    const mat4 to_view = mat4_look_at(camera->position, camera->target, camera->up);
    float low = INFINITY, high = -INFINITY;
    for (int i = 0; i < 8; i++) {
        const vec3 corner = {i & 1 ? bounds->high.x : bounds->low.x, i & 2 ? bounds->high.y : bounds->low.y, i & 4 ? bounds->high.z : bounds->low.z};
        const float depth = -mat4_point(&to_view, corner).z;
        low = fminf(low, depth);
        high = fmaxf(high, depth);
    }
    const float size = vec3_distance(bounds->low, bounds->high), room = size * (deforms ? 100 : 1); /* joints may carry vertices out of the bounds */
    const float near = fmaxf(camera->near_distance, low - room), far = fminf(camera->far_distance, high + room);
    if (!(far > near) || !(camera->far_distance - camera->near_distance > DEPTH_RANGE * size)) return fitted;
    fitted.near_distance = near;
    fitted.far_distance = far;
    return fitted;
}

struct gpu_view view_from_camera(const fnl_camera *camera, uint32_t width, uint32_t height) {
    struct gpu_view v = {.world_to_view = mat4_look_at(camera->position, camera->target, camera->up),
                         .eye = camera->position,
                         .near_distance = camera->near_distance > 0 ? camera->near_distance : 1e-6f * camera->far_distance, /* lists divide by it */
                         .orthographic = camera->orthographic,
                         .mask = camera->view_mask,
                         .size = {width, height},
                         .inverse_size = {1 / (float)width, 1 / (float)height}};
    float aspect = (float)width / (float)height * camera->pixel_aspect, near = camera->near_distance, far = camera->far_distance;
    float *p = v.view_to_clip.m;
    if (camera->orthographic) {
        p[5] = 2 / camera->vertical_extent;
        p[0] = p[5] / aspect;
        p[10] = 1 / (far - near);
        p[14] = far / (far - near);
        p[12] = camera->shift.x;
        p[13] = camera->shift.y;
        p[15] = 1;
        v.depth_decode = (vec4){far, near - far, 1, 0};
    } else {
        p[5] = 1 / tanf(camera->vertical_fov * 0.5f);
        p[0] = p[5] / aspect;
        p[8] = -camera->shift.x;
        p[9] = -camera->shift.y;
        p[14] = near;
        p[11] = -1;
        v.depth_decode = (vec4){near, 0, 0, 1};
    }
    v.ndc_scale = (vec2){1 / p[0], 1 / p[5]};
    v.ndc_offset = (vec2){-camera->shift.x / p[0], -camera->shift.y / p[5]};
    v.world_to_clip = mat4_mul(v.view_to_clip, v.world_to_view);
    mat4_inverse(&v.world_to_view, &v.view_to_world);
    v.back = (vec3){v.view_to_world.m[8], v.view_to_world.m[9], v.view_to_world.m[10]};
    set_planes(&v);
    return v;
}

struct gpu_view view_with_origin(const struct gpu_view *view, const double moved[3]) {
    struct gpu_view v = *view;
    float *eye = &v.eye.x, *to_world = v.view_to_world.m + 12, *to_view = v.world_to_view.m + 12;
    if (moved[0] == 0 && moved[1] == 0 && moved[2] == 0) return v;
    for (int i = 0; i < 3; i++) {
        eye[i] = (float)((double)eye[i] - moved[i]);
        to_world[i] = (float)((double)to_world[i] - moved[i]);
    }
    for (int row = 0; row < 3; row++) {
        double sum = 0;
        for (int k = 0; k < 3; k++) sum -= (double)v.world_to_view.m[k * 4 + row] * (double)to_world[k];
        to_view[row] = (float)sum;
    }
    v.world_to_clip = mat4_mul(v.view_to_clip, v.world_to_view);
    set_planes(&v);
    return v;
}

float view_reach(const struct gpu_view *view, const struct box *bounds) {
    float far = 1;
    if (box_is_empty(bounds)) return far;
    for (int i = 0; i < 8; i++) {
        vec3 corner = {i & 1 ? bounds->high.x : bounds->low.x, i & 2 ? bounds->high.y : bounds->low.y,
                       i & 4 ? bounds->high.z : bounds->low.z};
        far = fmaxf(far, -mat4_point(&view->world_to_view, corner).z);
    }
    return far;
}
