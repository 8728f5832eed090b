/* SPDX-License-Identifier: MIT */
/** Light along a camera's ray. */
#ifndef FNL_RAY_INTEGRATE_H
#define FNL_RAY_INTEGRATE_H

#include "fanal/trace.h"
#include "ray/camera.h"
#include "ray/ray_scene.h"
#include "ray/samples.h"

struct ray_sum {
    dvec3 radiance;
    double direct, unshadowed; /* luminance of the lights' direct light at the nearest surface */
    uint32_t surfaces;         /* samples that met one that is not blended */
};

/** Adds a sample of a pixel, through a point in pixels. `camera` is that of the parameters. */
void ray_integrate(const struct ray_scene *scene, const fnl_trace_params *params, const struct ray_camera *camera, double x,
                   double y, struct ray_samples *samples, struct ray_walk *walk, struct ray_sum *sum);

#endif
