/* SPDX-License-Identifier: MIT */
/** What a light gives to a point, in double precision and as plainly as can be; for tests of shading and of lists. */
#ifndef FNL_TESTS_LIGHT_REFERENCE_H
#define FNL_TESTS_LIGHT_REFERENCE_H

#include "base/base.h"
#include "fanal/scene.h"

#include <math.h>

static inline double light_dot(const double a[3], const double b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
static inline void light_unit(double v[3]) {
    double length = sqrt(light_dot(v, v));
    for (int i = 0; i < 3; i++) v[i] /= length;
}

/* side, up and direction, each unit. */
static inline void light_axes(const fnl_light_params *light, double axes[3][3]) {
    double *side = axes[0], *up = axes[1], *along = axes[2];
    const float direction[3] = {light->direction.x, light->direction.y, light->direction.z},
                given[3] = {light->up.x, light->up.y, light->up.z};
    for (int i = 0; i < 3; i++) along[i] = direction[i];
    light_unit(along);
    for (int i = 0; i < 3; i++) up[i] = given[i];
    double lean = light_dot(up, along);
    for (int i = 0; i < 3; i++) up[i] -= lean * along[i];
    light_unit(up);
    for (int i = 0; i < 3; i++) side[i] = along[(i + 1) % 3] * up[(i + 2) % 3] - along[(i + 2) % 3] * up[(i + 1) % 3];
    light_unit(side);
}

/* Full to `inner` of the way to the edge, then falling to 0; no fade is steeper than over a thousandth of the way. */
static inline double light_fade(double part, double inner) { return fmin(fmax((1 - part) / fmax(0.001, 1 - inner), 0), 1); }

static inline double light_reference_range(const fnl_light_params *light) {
    double brightest = fmax(light->color[0], fmax(light->color[1], light->color[2]));
    return isinf(light->range) ? sqrt(light->intensity * brightest / 0.05) : (double)light->range;
}

/**
 * Illuminance at right angles to the ray that the light gives at colour and intensity 1, lux, and the unit direction to it; 0 where its
 * volume does not hold the point. fanal/scene.h says what the parameters mean; the falloff is that of KHR_lights_punctual.
 */
static inline double light_reference(const fnl_light_params *light, const double position[3], double to_light[3]) {
    double axes[3][3], ray[3], at[3], fade = 1, range = light_reference_range(light);
    const float origin[3] = {light->position.x, light->position.y, light->position.z};
    if (light->kind != FNL_LIGHT_POINT) light_axes(light, axes);
    for (int i = 0; i < 3; i++) ray[i] = (double)origin[i] - position[i];
    for (int i = 0; i < 3; i++) at[i] = light->kind == FNL_LIGHT_POINT ? 0 : -light_dot(ray, axes[i]);
    const double half_box[3] = {(double)light->box_size.x / 2, (double)light->box_size.y / 2, (double)light->box_size.z / 2};
    switch (light->kind) {
    case FNL_LIGHT_DIRECTIONAL:
    case FNL_LIGHT_BOX:
        for (int i = 0; i < 3; i++) to_light[i] = -axes[2][i];
        if (light->kind == FNL_LIGHT_DIRECTIONAL) return 1;
        for (int i = 0; i < 3; i++) fade *= light_fade(fabs(at[i]) / half_box[i], (double)light->inner_fraction);
        return fade * fade;
    case FNL_LIGHT_SPOT: {
        double inner = cos((double)light->inner_cone_angle), outer = cos((double)light->outer_cone_angle);
        double cosine = at[2] / sqrt(light_dot(ray, ray));
        fade = fmin(fmax((cosine - outer) / fmax(0.001, inner - outer), 0), 1);
        break;
    }
    case FNL_LIGHT_CAPSULE: {
        double along = fmin(fmax(at[2], -(double)light->length / 2), (double)light->length / 2);
        for (int i = 0; i < 3; i++) ray[i] += axes[2][i] * along;
        break;
    }
    case FNL_LIGHT_WEDGE:
        if (!(at[2] > 0)) return 0;
        for (int i = 0; i < 2; i++)
            fade *= light_fade(fabs(at[i]) / (at[2] * tan((double)light->wedge_angles[i])), (double)light->inner_fraction);
        break;
    default:
        break;
    }
    double distance = sqrt(light_dot(ray, ray));
    if (distance == 0 || distance >= range) return 0;
    for (int i = 0; i < 3; i++) to_light[i] = ray[i] / distance;
    return (1 - pow(distance / range, 4)) / (distance * distance) * fade * fade;
}

#endif
