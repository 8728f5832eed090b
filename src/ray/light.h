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
    /* Each kind sets those that it reads (light.c). */
    double inner_cosine, outer_cosine, half_length, inner_fraction, half_width, half_height;
    double tangents[2];
    dvec3 half_size;
    bool two_sided;
    const struct light_hull *hull; /* borrowed; or NULL */
    const struct light_profile *profile; /* borrowed; or NULL. Points that have one have side, up and along too */
    bool casts_shadows;
    uint32_t mask; /* surfaces whose light mask shares no bit with it get nothing */
    double source; /* radius of what casts its shadows, metres; of parallel light half the angle that it fills */
};

/** `range` in metres is used in place of the parameter. */
struct ray_light ray_light_make(const fnl_light_params *params, double range, const struct light_hull *hull);
/**
 * Illuminance at right angles to the ray that the light gives at colour 1, lux; the unit direction to it; and how far away that is where the light
 * comes from: INFINITY for directional lights, for boxes the face where the light enters. 0 where its volume does not hold the point. Of an
 * area light only about that, from its middle: ray_light_sample() has to be asked about many of its points.
 */
double ray_light_strength(const struct ray_light *light, dvec3 position, dvec3 *to_light, double *distance);

/**
 * What a point of an area light gives, times what there are points: the mean over `u` and `v` in 0 .. 1 is what all of it gives, for a function of the
 * direction to the light. `distance`: to that point.
 */
double ray_light_sample(const struct ray_light *light, dvec3 position, double u, double v, dvec3 *to_light, double *distance);
/** ray_light_sample() of a random point of an area light, ray_light_strength() of others. */
double ray_light_draw(const struct ray_light *light, struct ray_samples *samples, dvec3 position, dvec3 *to_light, double *distance);
/**
 * Where a shadow ray goes to: the light, or a random point of a source of this size (ray_light.source) at `distance`. `to_light` and `distance`: of
 * ray_light_draw().
 */
dvec3 ray_light_source(const struct ray_light *light, struct ray_samples *samples, double size, dvec3 position, dvec3 to_light, double distance);
/** Of a sphere about the position that holds the volume, metres. */
double ray_light_radius(const struct ray_light *light);

#endif
