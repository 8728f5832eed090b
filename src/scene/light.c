/* SPDX-License-Identifier: MIT */
/* What the parameters of a light say about its volume. */
#include "scene/scene.h"

float fnl_light_range(const fnl_light_params *light, float min_roughness, float threshold) {
    if (check_handle(__func__, "params", light) != FNL_OK) return 0;
    if (light->kind == FNL_LIGHT_DIRECTIONAL) return INFINITY;
    if (light->kind == FNL_LIGHT_BOX) return 0.5f * vec3_length(light->box_size);
    if (isfinite(light->range)) return light->range;
    float alpha = fmaxf(min_roughness * min_roughness, 0.001f), gain = fmaxf(1, 0.25f / (alpha * alpha));
    float brightest = fmaxf(light->color[0], fmaxf(light->color[1], light->color[2]));
    return fminf(sqrtf(light->intensity * brightest * gain / threshold), 1e18f); /* its square must be finite */
}

float light_effective_range(const fnl_light_params *light) {
    return fnl_light_range(light, LIGHT_CUTOFF_ROUGHNESS, LIGHT_CUTOFF_ILLUMINANCE);
}

vec3 light_up(vec3 direction, vec3 up) {
    vec3 across = vec3_add_scaled(up, direction, -vec3_dot(up, direction));
    if (!(vec3_length(across) > 1e-4f * vec3_length(up))) across = vec3_perpendicular(direction);
    across = vec3_normalize(across);
    return vec3_normalize(vec3_add_scaled(across, direction, -vec3_dot(across, direction)));
}
