/* SPDX-License-Identifier: MIT */
/**
 * Light on a surface in double precision, from the specifications: the BRDF of glTF 2.0, appendix B, with KHR_materials_ior and
 * KHR_materials_specular, with the layers of ray/layers.h.
 */
#ifndef FNL_RAY_BRDF_H
#define FNL_RAY_BRDF_H

#include "ray/layers.h"

/** Fills the tables that layers, environments and FNL_ENERGY_CONSERVING use. */
void ray_albedos_fill(struct ray_albedos *out);

/** f(l, v) times the cosine; 0 for light from below, unless some goes through the surface, as through a sheet. The smallest alpha is 0.001, so that mirrors show point lights. */
dvec3 ray_brdf_cos(const struct ray_surface *surface, dvec3 to_view, dvec3 to_light);
/**
 * What a surface sends of ambient light that nothing shadows: the light blends from ground to sky by height; the reflected part comes from the
 * mirror direction, by a fit of what the specular lobe reflects (environment_brdf() of shaders/brdf.glsl).
 */
dvec3 ray_ambient(const struct ray_surface *surface, dvec3 to_view, dvec3 sky, dvec3 ground);

/**
 * Chooses a direction from which light may come, by three numbers in [0, 1): returns f cos / density for it, 0 where there is none. The lobes are
 * chosen by their reflectance; normals of the specular one follow Heitz, "Sampling the GGX Distribution of Visible Normals", 2018.
 * `density`: per steradian.
 */
dvec3 ray_brdf_sample(const struct ray_surface *surface, dvec3 to_view, const double random[3], dvec3 *to_light, double *density);
/** f cos of light from a direction, as ray_brdf_sample() counts it, and the density with which that would have chosen it. */
dvec3 ray_brdf_light(const struct ray_surface *surface, dvec3 to_view, dvec3 to_light, double *density);

#endif
