/* SPDX-License-Identifier: MIT */
#include "ray/light.h"

#include "ray/samples.h"
#include "scene/light_kinds.h"
#include "scene/scene.h"

/* A point relative to a light: `ray` leads from the point to the light's position, `at` is the point in the light's axes. */
struct seen {
    dvec3 ray, at;
};

/* Full to `inner` of the way to the edge, then falling to 0; no fade is steeper than over a thousandth of the way. */
static double fade(double part, double inner) { return clamp01((1 - part) / fmax(0.001, 1 - inner)); }

/* The strength of a light at the end of a ray. */
static double falloff(const struct ray_light *l, dvec3 ray, double edge, dvec3 *to_light, double *distance) {
    *distance = dvec3_length(ray);
    if (*distance == 0 || *distance >= l->range) return 0;
    *to_light = dvec3_scale(ray, 1 / *distance);
    double ratio2 = *distance * *distance / (l->range * l->range);
    return (1 - ratio2 * ratio2) / (*distance * *distance) * edge * edge;
}

static double profiled_falloff(const struct ray_light *l, const struct seen *p, double edge, dvec3 *to_light, double *distance) {
    const double length = dvec3_length(p->ray);
    if (l->profile && length > 0) edge *= sqrt(light_profile_at(l->profile, p->at.x / length, p->at.y / length, p->at.z / length));
    return falloff(l, p->ray, edge, to_light, distance);
}

/* ---- directional lights ---- */

static double directional_strength(const struct ray_light *l, const struct seen *p, dvec3 *to_light, double *distance) {
    UNUSED(p);
    *to_light = dvec3_scale(l->along, -1);
    *distance = (double)INFINITY;
    return 1;
}

/* ---- points ---- */

static double point_strength(const struct ray_light *l, const struct seen *p, dvec3 *to_light, double *distance) {
    return profiled_falloff(l, p, 1, to_light, distance);
}

/* ---- spots ---- */

static void make_spot(struct ray_light *l, const fnl_light_params *params) {
    l->inner_cosine = cos((double)params->inner_cone_angle);
    l->outer_cosine = cos((double)params->outer_cone_angle);
}

static double spot_strength(const struct ray_light *l, const struct seen *p, dvec3 *to_light, double *distance) {
    const double edge = clamp01((p->at.z / dvec3_length(p->ray) - l->outer_cosine) / fmax(0.001, l->inner_cosine - l->outer_cosine));
    return profiled_falloff(l, p, edge, to_light, distance);
}

/* ---- capsules ---- */

static void make_capsule(struct ray_light *l, const fnl_light_params *params) { l->half_length = (double)params->length / 2; }

static double capsule_strength(const struct ray_light *l, const struct seen *p, dvec3 *to_light, double *distance) {
    return falloff(l, dvec3_add_scaled(p->ray, l->along, CLAMP(p->at.z, -l->half_length, l->half_length)), 1, to_light, distance);
}

static double capsule_radius(const struct ray_light *l) { return l->range + l->half_length; }

static dvec3 capsule_middle(const struct ray_light *l, double chance) { return dvec3_add_scaled(l->position, l->along, (2 * chance - 1) * l->half_length); }

/* ---- wedges ---- */

static void make_wedge(struct ray_light *l, const fnl_light_params *params) {
    l->inner_fraction = (double)params->inner_fraction;
    for (int i = 0; i < 2; i++) l->tangents[i] = tan((double)params->wedge_angles[i]);
}

static double wedge_strength(const struct ray_light *l, const struct seen *p, dvec3 *to_light, double *distance) {
    if (!(p->at.z > 0)) return 0;
    const double edge = fade(fabs(p->at.x) / (p->at.z * l->tangents[0]), l->inner_fraction) *
                        fade(fabs(p->at.y) / (p->at.z * l->tangents[1]), l->inner_fraction);
    return falloff(l, p->ray, edge, to_light, distance);
}

/* ---- boxes ---- */

static void make_box(struct ray_light *l, const fnl_light_params *params) {
    l->inner_fraction = (double)params->inner_fraction;
    l->half_size = dvec3_scale(dvec3_from(params->box_size), 0.5);
}

static double box_strength(const struct ray_light *l, const struct seen *p, dvec3 *to_light, double *distance) {
    const double edge = fade(fabs(p->at.x) / l->half_size.x, l->inner_fraction) * fade(fabs(p->at.y) / l->half_size.y, l->inner_fraction) *
                        fade(fabs(p->at.z) / l->half_size.z, l->inner_fraction);
    *to_light = dvec3_scale(l->along, -1);
    *distance = p->at.z + l->half_size.z;
    return edge * edge;
}

static double box_radius(const struct ray_light *l) { return dvec3_length(l->half_size); }

/* ---- rectangles ---- */

static void make_rectangle(struct ray_light *l, const fnl_light_params *params) {
    l->half_width = (double)params->rectangle_size[0] / 2;
    l->half_height = (double)params->rectangle_size[1] / 2;
    l->two_sided = params->two_sided;
}

/* The squared distance to the nearest point of the rectangle, in ranges. */
static double rectangle_ratio2(const struct ray_light *l, dvec3 at) {
    const double x = fmax(fabs(at.x) - l->half_width, 0), y = fmax(fabs(at.y) - l->half_height, 0);
    return (x * x + y * y + at.z * at.z) / (l->range * l->range);
}

static bool is_lit_side(const struct ray_light *l, dvec3 at) { return l->two_sided ? at.z != 0 : at.z > 0; }

/* From the center, as in light_reach(). */
static double rectangle_strength(const struct ray_light *l, const struct seen *p, dvec3 *to_light, double *distance) {
    *distance = dvec3_length(p->ray);
    if (*distance == 0) return 0;
    *to_light = dvec3_scale(p->ray, 1 / *distance);
    const double distance2 = *distance * *distance, ratio2 = rectangle_ratio2(l, p->at);
    if (!is_lit_side(l, p->at) || ratio2 >= 1) return 0;
    return (1 - ratio2 * ratio2) * fabs(p->at.z) / *distance / (distance2 + 4 * l->half_width * l->half_height / DPI);
}

static double rectangle_sample(const struct ray_light *l, const struct seen *p, double u, double v, dvec3 *to_light, double *distance) {
    const double ratio2 = rectangle_ratio2(l, p->at);
    const dvec3 ray = dvec3_add_scaled(dvec3_add_scaled(p->ray, l->side, (2 * u - 1) * l->half_width), l->up, (2 * v - 1) * l->half_height);
    *distance = dvec3_length(ray);
    if (!is_lit_side(l, p->at) || ratio2 >= 1 || *distance == 0) return 0;
    *to_light = dvec3_scale(ray, 1 / *distance);
    return (1 - ratio2 * ratio2) * fabs(dvec3_dot(*to_light, l->along)) / (*distance * *distance);
}

static double rectangle_radius(const struct ray_light *l) { return l->range + hypot(l->half_width, l->half_height); }

/* ---- the kinds ---- */

static const struct {
    void (*make)(struct ray_light *l, const fnl_light_params *params); /* sets what only this kind has; NULL: nothing */
    double (*strength)(const struct ray_light *l, const struct seen *p, dvec3 *to_light, double *distance);
    double (*sample)(const struct ray_light *l, const struct seen *p, double u, double v, dvec3 *to_light, double *distance); /* area lights */
    double (*radius)(const struct ray_light *l);               /* of a sphere around the position that contains the volume; NULL: the range */
    dvec3 (*middle)(const struct ray_light *l, double chance); /* center of the disk to sample; NULL: where strength() finds the light */
} kinds[FNL_LIGHT_KIND_COUNT] = {
    [FNL_LIGHT_DIRECTIONAL] = {.strength = directional_strength},
    [FNL_LIGHT_POINT] = {.strength = point_strength},
    [FNL_LIGHT_SPOT] = {.make = make_spot, .strength = spot_strength},
    [FNL_LIGHT_CAPSULE] = {.make = make_capsule, .strength = capsule_strength, .radius = capsule_radius, .middle = capsule_middle},
    [FNL_LIGHT_WEDGE] = {.make = make_wedge, .strength = wedge_strength},
    [FNL_LIGHT_BOX] = {.make = make_box, .strength = box_strength, .radius = box_radius},
    [FNL_LIGHT_RECTANGLE] = {.make = make_rectangle, .strength = rectangle_strength, .sample = rectangle_sample, .radius = rectangle_radius},
};

/* ---- making them ---- */

struct ray_light ray_light_make(const fnl_light_params *params, double range, const struct light_hull *hull) {
    const fnl_light_kind_info *kind = &light_kinds[params->kind].info;
    struct ray_light l = {.kind = params->kind,
                          .parallel = kind->parallel,
                          .position = dvec3_from(params->position),
                          .range = range,
                          .hull = kind->has_position ? hull : NULL,
                          .casts_shadows = params->casts_shadows,
                          .mask = params->mask,
                          .source = (double)(kind->parallel ? params->source_angle : params->source_radius)};
    l.color = dvec3_scale(dvec3_make((double)params->color[0], (double)params->color[1], (double)params->color[2]),
                          (double)params->intensity);
    if (kinds[l.kind].make) kinds[l.kind].make(&l, params);
    if (!light_has_direction(params)) return l;
    dvec3 up = dvec3_from(params->up);
    l.along = dvec3_normalize(dvec3_from(params->direction));
    l.up = dvec3_normalize(dvec3_add_scaled(up, l.along, -dvec3_dot(up, l.along)));
    l.side = dvec3_normalize(dvec3_cross(l.along, l.up));
    return l;
}

/* ---- what they give ---- */

static bool hull_holds(const struct light_hull *hull, dvec3 p) {
    for (uint32_t i = 0; i < hull->plane_count; i++) {
        const double *n = hull->planes[i];
        if (n[0] * p.x + n[1] * p.y + n[2] * p.z + n[3] >= 0) return false;
    }
    return true;
}

static struct seen see(const struct ray_light *l, dvec3 position) {
    const dvec3 ray = dvec3_sub(l->position, position);
    return (struct seen){ray, {-dvec3_dot(ray, l->side), -dvec3_dot(ray, l->up), -dvec3_dot(ray, l->along)}};
}

double ray_light_strength(const struct ray_light *l, dvec3 position, dvec3 *to_light, double *distance) {
    const struct seen p = see(l, position);
    *to_light = (dvec3){0, 0, 0};
    *distance = 0;
    if (l->hull && !hull_holds(l->hull, position)) return 0;
    return kinds[l->kind].strength(l, &p, to_light, distance);
}

double ray_light_sample(const struct ray_light *l, dvec3 position, double u, double v, dvec3 *to_light, double *distance) {
    const struct seen p = see(l, position);
    *to_light = (dvec3){0, 0, 0};
    *distance = 0;
    if (l->hull && !hull_holds(l->hull, position)) return 0;
    return kinds[l->kind].sample(l, &p, u, v, to_light, distance);
}

double ray_light_draw(const struct ray_light *l, struct ray_samples *samples, dvec3 position, dvec3 *to_light, double *distance) {
    double random[2];
    if (!kinds[l->kind].sample) return ray_light_strength(l, position, to_light, distance);
    ray_samples_draw(samples, 2, random);
    return ray_light_sample(l, position, random[0], random[1], to_light, distance);
}

dvec3 ray_light_source(const struct ray_light *l, struct ray_samples *samples, double size, dvec3 position, dvec3 to_light, double distance) {
    dvec3 point = dvec3_add_scaled(position, to_light, distance), side, up;
    if (!(size > 0) || kinds[l->kind].sample) return point; /* for an area light it is already one of its points */
    double random[2], along;
    ray_samples_draw(samples, 2, random);
    const double radius = sqrt(random[0]) * (l->parallel ? distance * tan(size) : size), angle = 2 * DPI * random[1];
    if (kinds[l->kind].middle) {
        ray_samples_draw(samples, 1, &along);
        point = kinds[l->kind].middle(l, along);
    }
    dvec3_basis(to_light, &side, &up);
    return dvec3_combine(side, up, point, dvec3_make(radius * cos(angle), radius * sin(angle), 1));
}

double ray_light_radius(const struct ray_light *l) { return kinds[l->kind].radius ? kinds[l->kind].radius(l) : l->range; }
