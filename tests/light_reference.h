/* SPDX-License-Identifier: MIT */
/** What a light gives to a point, by the CPU's tracer (ray/light.h), in the arrays that tests use. */
#ifndef FNL_TESTS_LIGHT_REFERENCE_H
#define FNL_TESTS_LIGHT_REFERENCE_H

#include "ray/light.h"

static inline double light_dot(const double a[3], const double b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/* Without a range a light has no limit. */
static inline double light_reference_range(const fnl_light_params *light) { return isinf(light->range) ? 1e9 : (double)light->range; }

/* side, up and direction, each unit. */
static inline void light_axes(const fnl_light_params *light, double axes[3][3]) {
    const struct ray_light made = ray_light_make(light, 1, NULL);
    const dvec3 each[3] = {made.side, made.up, made.along};
    for (int i = 0; i < 3; i++) {
        axes[i][0] = each[i].x;
        axes[i][1] = each[i].y;
        axes[i][2] = each[i].z;
    }
}

/**
 * Illuminance at right angles to the ray that the light gives at colour and intensity 1, lux, and the unit direction to it; 0 where its
 * volume does not hold the point.
 */
static inline double light_reference(const fnl_light_params *light, const double position[3], double to_light[3]) {
    const double range = light_reference_range(light);
    if (light->kind == FNL_LIGHT_POINT || light->kind == FNL_LIGHT_SPOT || light->kind == FNL_LIGHT_WEDGE) { /* most are too far away */
        const double ray[3] = {(double)light->position.x - position[0], (double)light->position.y - position[1],
                               (double)light->position.z - position[2]};
        if (light_dot(ray, ray) >= range * range) return 0;
    }
    const struct ray_light made = ray_light_make(light, range, NULL);
    double distance;
    dvec3 to;
    double strength = ray_light_strength(&made, dvec3_make(position[0], position[1], position[2]), &to, &distance);
    to_light[0] = to.x;
    to_light[1] = to.y;
    to_light[2] = to.z;
    return strength;
}

#endif
