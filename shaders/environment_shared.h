/* SPDX-License-Identifier: MIT */
/** Light from all around, as shaders find it by gpu_frame.environment. */
#ifndef FNL_SHADERS_ENVIRONMENT_SHARED_H
#define FNL_SHADERS_ENVIRONMENT_SHARED_H

#include "shared.h"

/*
 * What a diffuse surface of albedo 1 reflects, by its normal n in the axes of the cube map, as spherical harmonics: the basis is 1, y, z, x, xy, yz,
 * 3 z^2 - 1, xz, x^2 - y^2, all constant factors are in here (Ramamoorthi and Hanrahan 2001). cd/m^2 where the cube map is.
 */
struct gpu_environment {
    vec3 diffuse[9];
    float unit; /* of probes: what the texels of their cube are multiplied by, a power of two */
};

#endif
