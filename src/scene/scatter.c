/* SPDX-License-Identifier: MIT */
#include "scene/light_kinds.h"
#include "scene/scene.h"

/** Lights of the scatter that hold a point of the bounds, on average. */
#define SCATTER_OVERLAP 8.0

/**
 * The chance that two random points of a box are nearer than `radius`: the integral over the ball of the box's
 * autocorrelation, the product of (e - |d|) / e^2 per axis. Midpoint rule over one octant.
 */
static double near_chance(const double extent[3], double radius) {
    enum { STEPS = 24 };
    double reach[3], sum = 0;
    for (int i = 0; i < 3; i++) reach[i] = fmin(radius, extent[i]);
    for (int x = 0; x < STEPS; x++)
        for (int y = 0; y < STEPS; y++)
            for (int z = 0; z < STEPS; z++) {
                double d[3] = {reach[0] * (x + 0.5) / STEPS, reach[1] * (y + 0.5) / STEPS, reach[2] * (z + 0.5) / STEPS};
                if (d[0] * d[0] + d[1] * d[1] + d[2] * d[2] >= radius * radius) continue;
                double weight = 1;
                for (int i = 0; i < 3; i++) weight *= 2 * reach[i] / STEPS * (extent[i] - d[i]) / (extent[i] * extent[i]);
                sum += weight;
            }
    return sum;
}

static float scatter_radius(const struct box *bounds, uint32_t count) {
    double extent[3] = {(double)bounds->high.x - (double)bounds->low.x, (double)bounds->high.y - (double)bounds->low.y,
                        (double)bounds->high.z - (double)bounds->low.z};
    double longest = fmax(extent[0], fmax(extent[1], extent[2]));
    for (int i = 0; i < 3; i++) extent[i] = fmax(extent[i], longest * 1e-4);
    double diagonal = sqrt(extent[0] * extent[0] + extent[1] * extent[1] + extent[2] * extent[2]);
    double wanted = SCATTER_OVERLAP / count, low = 0, high = diagonal;
    if (wanted >= 1) return (float)diagonal;
    for (int i = 0; i < 40; i++) {
        double middle = (low + high) / 2;
        if (near_chance(extent, middle) < wanted)
            low = middle;
        else
            high = middle;
    }
    return (float)high;
}

static vec3 random_direction(struct random_state *random) {
    float z = random_range(random, -1, 1), angle = random_range(random, 0, 2 * PI), r = sqrtf(fmaxf(0, 1 - z * z));
    return vec3_make(r * cosf(angle), r * sinf(angle), z);
}

/** A tinted white: one of the hue circle's colours, mixed with white, of maximum 1. */
static void random_tint(struct random_state *random, float color[3]) {
    float hue = random_range(random, 0, 2 * PI), strength = random_range(random, 0.2f, 0.8f), highest = 0;
    for (int i = 0; i < 3; i++) {
        color[i] = 1 - strength * (0.5f - 0.5f * cosf(hue + 2 * PI / 3 * (float)i));
        highest = fmaxf(highest, color[i]);
    }
    for (int i = 0; i < 3; i++) color[i] /= highest;
}

/** The kind that lags behind its share the most; `given` counts. */
static fnl_light_kind next_kind(const float *shares, uint32_t *given) {
    fnl_light_kind next = FNL_LIGHT_KIND_COUNT;
    for (fnl_light_kind k = FNL_LIGHT_POINT; k < FNL_LIGHT_KIND_COUNT; k++)
        if (shares[k] > 0 && (next == FNL_LIGHT_KIND_COUNT ||
                              (given[k] + 1.0) / (double)shares[k] < (given[next] + 1.0) / (double)shares[next]))
            next = k;
    given[next]++;
    return next;
}

fnl_result fnl_scene_scatter_light_shapes(fnl_scene *scene, const fnl_scatter_params *params) {
    TRY(check_handle(__func__, "scene", scene));
    const struct call *call = CALL(&scene->host);
    TRY(check_pointer(call, "params", params));
    TRY(check_floats(call, "shares", params->shares, FNL_LIGHT_KIND_COUNT, 0, (double)FLT_MAX, ""));
    double shares = 0;
    for (int k = 0; k < FNL_LIGHT_KIND_COUNT; k++) shares += (double)params->shares[k];
    if (!(shares > 0)) return misuse(call, "shares are all 0, one must be above");
    for (int k = 0; k < FNL_LIGHT_KIND_COUNT; k++)
        if (params->shares[k] != 0 && !light_kinds[k].scatter)
            return misuse(call, "shares[%d] is %g, must be 0: %s lights cannot be scattered", k, (double)params->shares[k],
                          fnl_value_name(FNL_ENUM_LIGHT_KIND, (uint32_t)k));
    TRY(check_above(call, "radius_scale", (double)params->radius_scale, 0, (double)FLT_MAX, ""));
    uint32_t count = params->count, given[FNL_LIGHT_KIND_COUNT] = {0};
    if (count == 0) return FNL_OK;
    struct box bounds = scene_bounds(scene);
    if (box_is_empty(&bounds)) bounds = (struct box){{-5, -5, -5}, {5, 5, 5}};
    if (!(vec3_distance(bounds.low, bounds.high) > 0)) { /* a single point: a metre around it */
        bounds.low = vec3_sub(bounds.low, vec3_make(0.5f, 0.5f, 0.5f));
        bounds.high = vec3_add(bounds.high, vec3_make(0.5f, 0.5f, 0.5f));
    }
    float radius = scatter_radius(&bounds, count) * params->radius_scale;
    TRY(scene_reserve_lights(scene, count)); /* from here on nothing fails */
    struct random_state random = {params->seed};
    for (uint32_t i = 0; i < count; i++) {
        fnl_light_params light = fnl_light_params_default();
        light.position.x = random_range(&random, bounds.low.x, bounds.high.x);
        light.position.y = random_range(&random, bounds.low.y, bounds.high.y);
        light.position.z = random_range(&random, bounds.low.z, bounds.high.z);
        light.range = radius * random_range(&random, 0.8f, 1.2f);
        light.intensity = SCATTER_ILLUMINANCE * light.range * light.range;
        random_tint(&random, light.color);
        const vec3 direction = random_direction(&random);
        struct scatter_numbers numbers = {.cone = random_range(&random, 0.4f, 0.8f)};
        light.kind = next_kind(params->shares, given);
        const struct light_kind *kind = &light_kinds[light.kind];
        if (kind->info.has_direction) light.direction = direction;
        if (!kind->punctual) {
            light.up = light_up(light.direction, random_direction(&random));
            for (int k = 0; k < 3; k++) numbers.parts[k] = random_float(&random);
        }
        kind->scatter(&light, &numbers);
        scene_add_light(scene, &light, SCENE_NONE);
    }
    return FNL_OK;
}
