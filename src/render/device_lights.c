/* SPDX-License-Identifier: MIT */
#include "render/device_scene.h"

#include "passes/lights/sprites.h"

/* The smallest sphere round a cone and its spherical end: through apex and rim, or round the rim of a wide cone. */
static void bound_cone(struct gpu_light *g, float cosine, float sine) {
    float along = cosine > 0.70710678f ? g->range / (2 * cosine) : g->range * cosine;
    g->bound_radius = cosine > 0.70710678f ? along : g->range * sine;
    g->bound_center = vec3_add_scaled(g->position, g->direction, along);
}

/* Wedges and boxes fade between their inner part and the edge; a hard edge is a thousandth wide. */
static float edge_scale(const fnl_light_params *light) { return 1 / fmaxf(0.001f, 1 - light->inner_fraction); }

/* `range` is the first test of any light: a hair larger than these shapes, which have exact ones of their own. */
#define SHAPE_SLACK (1 + 1e-5f)

static void set_capsule(struct gpu_light *g, const fnl_light_params *light) {
    g->size = (vec3){0.5f * light->length, g->range, 0};
    g->range = (g->range + g->size.x) * SHAPE_SLACK;
    g->bound_radius = g->range;
}

static void set_wedge(struct gpu_light *g, const fnl_light_params *light) {
    g->size = (vec3){tanf(light->wedge_angles[0]), tanf(light->wedge_angles[1]), 0};
    g->spot_scale = edge_scale(light);
    /* Its corners lie on a round cone; seen from the axis nothing is farther. */
    float tangent = hypotf(g->size.x, g->size.y), cosine = 1 / hypotf(1, tangent);
    bound_cone(g, cosine, tangent * cosine);
}

static void set_box(struct gpu_light *g, const fnl_light_params *light) {
    g->size = vec3_scale(light->box_size, 0.5f);
    g->spot_scale = edge_scale(light);
    g->range = vec3_length(g->size) * SHAPE_SLACK;
    g->bound_radius = g->range;
}

struct gpu_light device_light(const fnl_light_params *light) {
    struct gpu_light g = {.position = light->position,
                          .kind = (uint32_t)light->kind,
                          .direction = light->direction,
                          .color = {light->color[0] * light->intensity, light->color[1] * light->intensity,
                                    light->color[2] * light->intensity},
                          .entity = GPU_ENTITY_LIGHT};
    if (light->kind == FNL_LIGHT_DIRECTIONAL) return g;
    bool dark = !(fmaxf(g.color.x, fmaxf(g.color.y, g.color.z)) > 0);
    g.range = light_effective_range(light);
    if (!(g.range > 0)) g.range = 1e-6f;
    g.bound_center = light->position;
    g.bound_radius = g.range;
    if (light->kind != FNL_LIGHT_POINT)
        g.side = vec3_normalize(vec3_cross(light->direction, light_up(light->direction, light->up)));
    if (light->kind == FNL_LIGHT_SPOT) {
        float outer = cosf(light->outer_cone_angle), inner = cosf(light->inner_cone_angle);
        g.spot_scale = 1 / fmaxf(0.001f, inner - outer);
        g.spot_offset = -outer * g.spot_scale;
        bound_cone(&g, outer, sinf(light->outer_cone_angle));
    }
    if (light->kind == FNL_LIGHT_CAPSULE) set_capsule(&g, light);
    if (light->kind == FNL_LIGHT_WEDGE) set_wedge(&g, light);
    if (light->kind == FNL_LIGHT_BOX) set_box(&g, light);
    if (dark) {
        g.bound_center = light->position;
        g.bound_radius = 0;
    }
    return g;
}

/* Adds the planes of a hull, seen from the light: so they stay exact far from the world's origin. */
static void add_hull(struct device_scene *d, struct gpu_light *g, const struct light_hull *hull) {
    g->hull_count = hull->plane_count;
    g->hull_first = d->plane_data.count; /* the lights before the planes are added when their number is known */
    const double at[3] = {g->position.x, g->position.y, g->position.z};
    for (uint32_t i = 0; i < hull->plane_count; i++) {
        const double *n = hull->planes[i];
        d->plane_data.data[d->plane_data.count++] =
            (vec4){(float)n[0], (float)n[1], (float)n[2], (float)-(n[0] * at[0] + n[1] * at[1] + n[2] * at[2] + n[3])};
    }
    if (g->bound_radius > hull->radius) { /* what both hold is held by the smaller */
        g->bound_radius = hull->radius;
        g->bound_center = hull->center;
    }
}

uint64_t device_lights_planes_offset(uint32_t light_count) {
    return DIVIDE_UP(light_count * sizeof(struct gpu_light), sizeof(vec4)) * sizeof(vec4);
}

fnl_result device_lights_gather(const fnl_scene *scene, struct device_scene *d) {
    d->light_data.count = d->plane_data.count = d->bound_radii.count = 0;
    if (!array_reserve(&d->host, &d->light_data, scene->lights.count)) return FNL_ERROR_MEMORY;
    if (!array_reserve(&d->host, &d->plane_data, scene->hull_plane_count)) return FNL_ERROR_MEMORY;
    d->directional_count = 0;
    for (int local = 0; local < 2; local++)
        for (uint32_t i = 0; i < scene->lights.count; i++) {
            const struct scene_light *light = &scene->lights.data[i];
            if (light->removed || (light->node != SCENE_NONE && !scene->nodes.data[light->node].active)) continue;
            if ((light->params.kind != FNL_LIGHT_DIRECTIONAL) != local) continue;
            fnl_light_params params = light->params;
            if (isinf(params.range))
                params.range = fnl_light_range(&params, scene->cutoff_roughness, scene->cutoff_illuminance);
            struct gpu_light g = device_light(&params);
            if (local && light->hull) add_hull(d, &g, light->hull);
            d->light_data.data[d->light_data.count++] = g;
            if (!local) d->directional_count++;
        }
    if (d->plane_data.count) {
        uint32_t base = (uint32_t)(device_lights_planes_offset(d->light_data.count) / 16);
        for (uint32_t i = 0; i < d->light_data.count; i++)
            if (d->light_data.data[i].hull_count) d->light_data.data[i].hull_first += base;
    }
    return FNL_OK;
}

/* What the GPU rounds differently stays in the lists: it finds no colour there. */
#define FADE_SLACK 1e-4f

static void unfade(struct device_scene *d) {
    for (uint32_t i = 0; i < d->bound_radii.count; i++) d->light_data.data[i].bound_radius = d->bound_radii.data[i];
    d->bound_radii.count = 0;
}

fnl_result device_lights_fade(struct device_scene *d, const struct gpu_view *view, float lod, bool walk) {
    unfade(d);
    if (!(lod > 0)) return FNL_OK;
    if (d->faded_lights.size < d->lights.size) {
        gpu_buffer_destroy(d->device, &d->faded_lights);
        TRY(gpu_buffer_create(d->device, "faded lights", d->lights.size, GPU_MEMORY_DEVICE, &d->faded_lights));
    }
    if (!walk) return FNL_OK;
    if (!array_reserve(&d->host, &d->bound_radii, d->light_data.count)) return FNL_ERROR_MEMORY;
    for (uint32_t i = 0; i < d->light_data.count; i++) {
        struct gpu_light *light = &d->light_data.data[i];
        d->bound_radii.data[d->bound_radii.count++] = light->bound_radius;
        if (i >= d->directional_count && light_fade(view, light, lod * (1 - FADE_SLACK)) == 0) light->bound_radius = 0;
    }
    return FNL_OK;
}
