/* SPDX-License-Identifier: MIT */
#include "render/device_scene.h"

struct gpu_light device_light(const fnl_light_params *light) {
    struct gpu_light g = {.position = light->position,
                          .kind = (uint32_t)light->kind,
                          .direction = light->direction,
                          .color = {light->color[0] * light->intensity, light->color[1] * light->intensity,
                                    light->color[2] * light->intensity}};
    if (light->kind == FNL_LIGHT_DIRECTIONAL) return g;
    bool dark = !(fmaxf(g.color.x, fmaxf(g.color.y, g.color.z)) > 0);
    g.range = light_effective_range(light);
    if (!(g.range > 0)) g.range = 1e-6f;
    g.bound_center = light->position;
    g.bound_radius = dark ? 0 : g.range;
    if (light->kind == FNL_LIGHT_SPOT) {
        float outer = cosf(light->outer_cone_angle), inner = cosf(light->inner_cone_angle);
        g.spot_scale = 1 / fmaxf(0.001f, inner - outer);
        g.spot_offset = -outer * g.spot_scale;
        if (!dark) {
            /* The smallest sphere round the cone and its spherical end: through apex and rim, or round the rim of a wide cone. */
            float along = outer > 0.70710678f ? g.range / (2 * outer) : g.range * outer;
            g.bound_radius = outer > 0.70710678f ? along : g.range * sinf(light->outer_cone_angle);
            g.bound_center = vec3_add_scaled(light->position, light->direction, along);
        }
    }
    return g;
}

fnl_result device_lights_gather(const fnl_scene *scene, struct device_scene *d) {
    d->light_data.count = 0;
    if (!array_reserve(&d->host, &d->light_data, scene->lights.count)) return FNL_ERROR_MEMORY;
    d->directional_count = 0;
    for (int local = 0; local < 2; local++)
        for (uint32_t i = 0; i < scene->lights.count; i++) {
            const struct scene_light *light = &scene->lights.data[i];
            if (light->removed || (light->node != SCENE_NONE && !scene->nodes.data[light->node].active)) continue;
            if ((light->params.kind != FNL_LIGHT_DIRECTIONAL) != local) continue;
            d->light_data.data[d->light_data.count++] = device_light(&light->params);
            if (!local) d->directional_count++;
        }
    return FNL_OK;
}
