/* SPDX-License-Identifier: MIT */
/** The rays of a camera: through the same points of the picture as a frame's. */
#ifndef FNL_RAY_CAMERA_H
#define FNL_RAY_CAMERA_H

#include "fanal/camera.h"
#include "ray/dvec.h"

struct ray_camera {
    dvec3 eye, right, up, forward;
    double scale[2], offset[2]; /* from -1 .. 1 to metres at a distance of 1, or for orthographic ones at any */
    double width, height, near_distance, far_distance;
    bool orthographic;
};

struct ray_camera ray_camera_make(const fnl_camera *camera, uint32_t width, uint32_t height);
/** The ray through a point in pixels from the top left, and between which distances along it things are seen. */
void ray_camera_ray(const struct ray_camera *camera, double x, double y, dvec3 *origin, dvec3 *direction, double *low,
                    double *high);

#endif
