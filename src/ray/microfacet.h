/* SPDX-License-Identifier: MIT */
/** The specular lobe of a surface, round or stretched along the tangent, without Fresnel: its value, and directions by its visible normals. */
#ifndef FNL_RAY_MICROFACET_H
#define FNL_RAY_MICROFACET_H

#include "ray/surface.h"

/** At least 0.001, so that mirrors show point lights. */
double ray_alpha(const struct ray_surface *surface);
/** `h` halves the angle between to_view and to_light. */
double ray_specular_lobe(const struct ray_surface *surface, dvec3 to_view, dvec3 to_light, dvec3 h);
/** Reflectance along the normal for an index of refraction, before color and strength; an index of 0 reflects everything (KHR_materials_ior). */
double ray_ior_reflectance(double ior);
/** A microfacet that the viewer sees, by two numbers in [0, 1); `shadowed`: the part of what it mirrors or refracts that gets away. */
dvec3 ray_microfacet_sample(const struct ray_surface *surface, dvec3 to_view, const double random[2]);

/** A lobe that mirrors by visible normals. */
struct ray_mirror {
    dvec3 normal, side, up;
    double alphas[2]; /* along side and up */
};
struct ray_mirror ray_mirror_of(const struct ray_surface *surface);
/** A direction, by two numbers in [0, 1), and the density per steradian with which it is chosen. */
dvec3 ray_mirror_sample(const struct ray_mirror *mirror, dvec3 to_view, double u1, double u2);
double ray_mirror_density(const struct ray_mirror *mirror, dvec3 to_view, dvec3 to_light);

#endif
