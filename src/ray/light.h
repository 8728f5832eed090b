/* SPDX-License-Identifier: MIT */
/** What a light gives to a point, in double precision: fanal/light.h says what the parameters mean, the falloff is that of KHR_lights_punctual. */
#ifndef FNL_RAY_LIGHT_H
#define FNL_RAY_LIGHT_H

#include "fanal/light.h"
#include "ray/dvec.h"

struct light_hull;
struct light_profile;
struct ray_samples;

struct ray_light {
    fnl_light_kind kind;
    bool parallel;
    dvec3 position, color; /* colour: times intensity, cd or lux */
    dvec3 side, up, along; /* unit; not of points */
    double range;
    /* Each kind sets the members that it reads (light.c). */
    double inner_cosine, outer_cosine, half_length, inner_fraction, half_width, half_height;
    double tangents[2];
    dvec3 half_size;
    bool two_sided;
    const struct light_hull *hull; /* borrowed; or NULL */
    const struct light_profile *profile; /* borrowed; or NULL. Points that have one have side, up and along too */
    bool casts_shadows;
    uint32_t mask; /* surfaces whose light mask shares no bit with it get nothing */
    double source; /* radius of the source for soft shadows, meters; for parallel light the angular radius */
};

/** `range` in metres is used in place of the parameter. */
struct ray_light ray_light_make(const fnl_light_params *params, double range, const struct light_hull *hull);
/**
 * Illuminance at right angles to the ray at color 1, lux; the unit direction to the light; and the distance from which the light comes: INFINITY for
 * directional lights, to the face where the light enters for boxes. 0 if the light's volume does not contain the point. Approximate for area lights, from
 * the center: average ray_light_sample() over many points instead.
 */
double ray_light_strength(const struct ray_light *light, dvec3 position, dvec3 *to_light, double *distance);

/**
 * Illuminance as ray_light_strength(), as if the whole area light shone from its point (`u`, `v`), both 0 .. 1. The mean over `u` and `v` is the illuminance
 * of the whole light, also with a weight that depends on the direction to the light. `distance`: to that point.
 */
double ray_light_sample(const struct ray_light *light, dvec3 position, double u, double v, dvec3 *to_light, double *distance);
/** ray_light_sample() of a random point for area lights, ray_light_strength() for all others. */
double ray_light_draw(const struct ray_light *light, struct ray_samples *samples, dvec3 position, dvec3 *to_light, double *distance);
/**
 * The end of a shadow ray: the light, or a random point of a source of `size` (ray_light.source) at `distance`. `to_light` and `distance`: from
 * ray_light_draw().
 */
dvec3 ray_light_source(const struct ray_light *light, struct ray_samples *samples, double size, dvec3 position, dvec3 to_light, double distance);
/** Radius of a sphere around the position that contains the volume, meters. */
double ray_light_radius(const struct ray_light *light);

#endif
