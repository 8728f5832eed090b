/* SPDX-License-Identifier: MIT */
#include "ray/light.h"

#include "scene/scene.h"

struct ray_light ray_light_make(const fnl_light_params *params, double range, const struct light_hull *hull) {
    struct ray_light l = {.kind = params->kind,
                          .position = dvec3_from(params->position),
                          .range = range,
                          .inner_cosine = cos((double)params->inner_cone_angle),
                          .outer_cosine = cos((double)params->outer_cone_angle),
                          .half_length = (double)params->length / 2,
                          .inner_fraction = (double)params->inner_fraction,
                          .half_size = dvec3_scale(dvec3_from(params->box_size), 0.5),
                          .half_width = (double)params->rectangle_size[0] / 2,
                          .half_height = (double)params->rectangle_size[1] / 2,
                          .two_sided = params->two_sided,
                          .hull = params->kind == FNL_LIGHT_DIRECTIONAL ? NULL : hull,
                          .casts_shadows = params->casts_shadows,
                          .mask = params->mask,
                          .source = (double)(fnl_light_kind_find(params->kind)->parallel ? params->source_angle : params->source_radius)};
    l.color = dvec3_scale(dvec3_make((double)params->color[0], (double)params->color[1], (double)params->color[2]),
                          (double)params->intensity);
    if (l.kind == FNL_LIGHT_POINT && !params->profile.generation) return l;
    if (l.kind == FNL_LIGHT_SPOT) {
        l.inner_cosine = cos((double)params->inner_cone_angle);
        l.outer_cosine = cos((double)params->outer_cone_angle);
    }
    for (int i = 0; i < 2 && l.kind == FNL_LIGHT_WEDGE; i++) l.tangents[i] = tan((double)params->wedge_angles[i]);
    dvec3 up = dvec3_from(params->up);
    l.along = dvec3_normalize(dvec3_from(params->direction));
    l.up = dvec3_normalize(dvec3_add_scaled(up, l.along, -dvec3_dot(up, l.along)));
    l.side = dvec3_normalize(dvec3_cross(l.along, l.up));
    return l;
}

/* Full to `inner` of the way to the edge, then falling to 0; no fade is steeper than over a thousandth of the way. */
static double fade(double part, double inner) { return clamp01((1 - part) / fmax(0.001, 1 - inner)); }

static bool hull_holds(const struct light_hull *hull, dvec3 p) {
    for (uint32_t i = 0; i < hull->plane_count; i++) {
        const double *n = hull->planes[i];
        if (n[0] * p.x + n[1] * p.y + n[2] * p.z + n[3] >= 0) return false;
    }
    return true;
}

/* Parallel light: `at` is the point as the light sees it. */
static double parallel_strength(const struct ray_light *l, dvec3 at, dvec3 *to_light, double *distance) {
    *to_light = dvec3_scale(l->along, -1);
    *distance = (double)INFINITY;
    if (l->kind == FNL_LIGHT_DIRECTIONAL) return 1;
    double edge = fade(fabs(at.x) / l->half_size.x, l->inner_fraction) *
                  fade(fabs(at.y) / l->half_size.y, l->inner_fraction) *
                  fade(fabs(at.z) / l->half_size.z, l->inner_fraction);
    *distance = at.z + l->half_size.z;
    return edge * edge;
}

double ray_light_sample(const struct ray_light *l, dvec3 position, double u, double v, dvec3 *to_light, double *distance) {
    const dvec3 middle = dvec3_sub(l->position, position);
    const dvec3 at = {-dvec3_dot(middle, l->side), -dvec3_dot(middle, l->up), -dvec3_dot(middle, l->along)};
    const double x = fmax(fabs(at.x) - l->half_width, 0), y = fmax(fabs(at.y) - l->half_height, 0), ratio2 = (x * x + y * y + at.z * at.z) / (l->range * l->range);
    const dvec3 ray = dvec3_add_scaled(dvec3_add_scaled(middle, l->side, (2 * u - 1) * l->half_width), l->up, (2 * v - 1) * l->half_height);
    *to_light = (dvec3){0, 0, 0};
    *distance = dvec3_length(ray);
    if (l->hull && !hull_holds(l->hull, position)) return 0;
    if (l->two_sided ? at.z == 0 : !(at.z > 0)) return 0;
    if (ratio2 >= 1 || *distance == 0) return 0;
    *to_light = dvec3_scale(ray, 1 / *distance);
    return (1 - ratio2 * ratio2) * fabs(dvec3_dot(*to_light, l->along)) / (*distance * *distance);
}

double ray_light_strength(const struct ray_light *l, dvec3 position, dvec3 *to_light, double *distance) {
    dvec3 ray = dvec3_sub(l->position, position);
    dvec3 at = {-dvec3_dot(ray, l->side), -dvec3_dot(ray, l->up), -dvec3_dot(ray, l->along)};
    double edge = 1;
    *to_light = (dvec3){0, 0, 0};
    *distance = 0;
    if (l->hull && !hull_holds(l->hull, position)) return 0;
    if (l->kind == FNL_LIGHT_DIRECTIONAL || l->kind == FNL_LIGHT_BOX) return parallel_strength(l, at, to_light, distance);
    if (l->kind == FNL_LIGHT_SPOT)
        edge = clamp01((at.z / dvec3_length(ray) - l->outer_cosine) / fmax(0.001, l->inner_cosine - l->outer_cosine));
    if (l->kind == FNL_LIGHT_CAPSULE) ray = dvec3_add_scaled(ray, l->along, CLAMP(at.z, -l->half_length, l->half_length));
    if (l->kind == FNL_LIGHT_WEDGE) {
        if (!(at.z > 0)) return 0;
        edge = fade(fabs(at.x) / (at.z * l->tangents[0]), l->inner_fraction) *
               fade(fabs(at.y) / (at.z * l->tangents[1]), l->inner_fraction);
    }
    *distance = dvec3_length(ray);
    if (*distance == 0 || (*distance >= l->range && l->kind != FNL_LIGHT_RECTANGLE)) return 0;
    *to_light = dvec3_scale(ray, 1 / *distance);
    if (l->kind == FNL_LIGHT_RECTANGLE) { /* as light_reach() has it */
        const double x = fmax(fabs(at.x) - l->half_width, 0), y = fmax(fabs(at.y) - l->half_height, 0);
        const double near2 = x * x + y * y + at.z * at.z, distance2 = *distance * *distance, ratio2 = near2 / (l->range * l->range);
        if (l->two_sided ? at.z == 0 : !(at.z > 0)) return 0;
        if (ratio2 >= 1) return 0;
        return (1 - ratio2 * ratio2) * fabs(at.z) / *distance / (distance2 + 4 * l->half_width * l->half_height / DPI);
    }
    if (l->profile) edge *= sqrt(light_profile_at(l->profile, at.x / *distance, at.y / *distance, at.z / *distance));
    double ratio2 = *distance * *distance / (l->range * l->range);
    return (1 - ratio2 * ratio2) / (*distance * *distance) * edge * edge;
}
