/* SPDX-License-Identifier: MIT */
#include "ray/camera.h"

struct ray_camera ray_camera_make(const fnl_camera *camera, uint32_t width, uint32_t height) {
    struct ray_camera c = {.eye = dvec3_from(camera->position),
                           .width = width,
                           .height = height,
                           .near_distance = (double)camera->near_distance,
                           .far_distance = camera->orthographic ? (double)camera->far_distance : (double)INFINITY,
                           .orthographic = camera->orthographic};
    /* The axes of a frame, with what it does where `up` leads along the view. */
    const mat4 view = mat4_look_at(camera->position, camera->target, camera->up);
    dvec3 up = {(double)view.m[1], (double)view.m[5], (double)view.m[9]};
    c.forward = dvec3_normalize(dvec3_sub(dvec3_from(camera->target), c.eye));
    c.right = dvec3_normalize(dvec3_cross(c.forward, up));
    c.up = dvec3_cross(c.right, c.forward);
    double aspect = (double)width / (double)height * (double)camera->pixel_aspect;
    c.scale[1] = camera->orthographic ? (double)camera->vertical_extent / 2 : tan((double)camera->vertical_fov / 2);
    c.scale[0] = c.scale[1] * aspect;
    c.offset[0] = -(double)camera->shift.x * c.scale[0];
    c.offset[1] = -(double)camera->shift.y * c.scale[1];
    return c;
}

void ray_camera_ray(const struct ray_camera *c, double x, double y, dvec3 *origin, dvec3 *direction, double *low,
                    double *high) {
    double right = (2 * x / c->width - 1) * c->scale[0] + c->offset[0],
           up = (1 - 2 * y / c->height) * c->scale[1] + c->offset[1];
    dvec3 across = dvec3_add_scaled(dvec3_scale(c->right, right), c->up, up);
    *origin = c->orthographic ? dvec3_add(c->eye, across) : c->eye;
    *direction = c->orthographic ? c->forward : dvec3_normalize(dvec3_add(c->forward, across));
    *low = c->near_distance / dvec3_dot(*direction, c->forward);
    *high = c->far_distance;
}
