/* SPDX-License-Identifier: MIT */
/** Tables of albedos: the part of uniform light from all directions that lobes reflect (ray_albedos_fill() of brdf.h). */
#ifndef FNL_RAY_ALBEDOS_H
#define FNL_RAY_ALBEDOS_H

#include "ray/dvec.h"

/** Side of ray_albedos. */
enum { RAY_ALBEDO_SIDE = 33 };
/** Albedos of lobes, by roughness and the cosine of the viewer, both 0 .. 1. */
struct ray_albedos {
    float specular[RAY_ALBEDO_SIDE][RAY_ALBEDO_SIDE][2]; /* f0 times the first and f90 times the second */
    float sheen[RAY_ALBEDO_SIDE][RAY_ALBEDO_SIDE];       /* of white fibers */
};

/** Of the specular lobe: f0 times the first and f90 times the second. */
void ray_specular_albedo(const struct ray_albedos *albedos, double roughness, double n_v, double out[2]);
/** Of white fibers. */
double ray_sheen_albedo(const struct ray_albedos *albedos, double roughness, double n_v);

#endif
