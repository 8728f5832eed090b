/* SPDX-License-Identifier: MIT */
/* What the parameters of a light say about its volume. */
#include "scene/scene.h"

/** Illuminance in lux at which an unlimited light is cut off. */
#define RANGE_ILLUMINANCE 0.05f

float light_effective_range(const fnl_light_params *light) {
    if (light->kind == FNL_LIGHT_DIRECTIONAL) return INFINITY;
    if (light->kind == FNL_LIGHT_BOX) return 0.5f * vec3_length(light->box_size);
    if (isfinite(light->range)) return light->range;
    float brightest = fmaxf(light->color[0], fmaxf(light->color[1], light->color[2]));
    return sqrtf(light->intensity * brightest / RANGE_ILLUMINANCE);
}

vec3 light_up(vec3 direction, vec3 up) {
    vec3 across = vec3_add_scaled(up, direction, -vec3_dot(up, direction));
    if (!(vec3_length(across) > 1e-4f * vec3_length(up))) across = vec3_perpendicular(direction);
    across = vec3_normalize(across);
    return vec3_normalize(vec3_add_scaled(across, direction, -vec3_dot(across, direction)));
}
