/* SPDX-License-Identifier: MIT */
/**
 * Light on a surface in double precision, from the specifications: the BRDF of glTF 2.0, appendix B, with KHR_materials_ior and
 * KHR_materials_specular.
 */
#ifndef FNL_RAY_BRDF_H
#define FNL_RAY_BRDF_H

#include "ray/dvec.h"

struct ray_surface {
    dvec3 position, normal; /* world space; the shading normal, unit, on the viewer's side */
    dvec3 geometric;        /* the triangle's normal, unit, on the viewer's side */
    dvec3 base_color, emissive;
    double alpha; /* coverage; 1 unless the material blends */
    double metallic, roughness, occlusion;
    double offset; /* how far off it rays have to start so that rounding does not make them hit it, metres */
    dvec3 f0;      /* reflectance of the dielectric part along the normal */
    double f90;    /* and at grazing angles */
    dvec3 again;   /* diffuse reflectance besides, for light of paths: ray_environment_again(); else 0 */
};

/** Reflectance along the normal for an index of refraction, before colour and strength; an index of 0 reflects everything (KHR_materials_ior). */
double ray_ior_reflectance(double ior);
/** f(l, v) times the cosine; 0 for light from below. The smallest alpha is 0.001, so that mirrors show point lights. */
dvec3 ray_brdf_cos(const struct ray_surface *surface, dvec3 to_view, dvec3 to_light);
/**
 * What a surface sends of ambient light that nothing shadows: the light blends from ground to sky by height; the reflected part comes from the
 * mirror direction, through the fit of the environment integral by Karis ("Physically Based Shading on Mobile", 2014).
 */
dvec3 ray_ambient(const struct ray_surface *surface, dvec3 to_view, dvec3 sky, dvec3 ground);
/** Ambient light from a direction. */
dvec3 ray_sky(dvec3 direction, dvec3 sky, dvec3 ground);

/**
 * Chooses a direction from which light may come, by three numbers in [0, 1): returns f cos / density for it, 0 where there is none. The lobes are
 * chosen by their reflectance; normals of the specular one follow Heitz, "Sampling the GGX Distribution of Visible Normals", 2018.
 */
dvec3 ray_brdf_sample(const struct ray_surface *surface, dvec3 to_view, const double random[3], dvec3 *to_light);

#endif
