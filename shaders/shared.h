/* SPDX-License-Identifier: MIT */
/*
 * What lets one struct be read by C and by GLSL. In *_shared.h write `struct gpu_x { … };` with float, uint, int, vec2, vec3, vec4,
 * uvec2, uvec3, mat4 and ADDRESS(block): a 64-bit buffer address, which GLSL sees as a reference to that block; a member
 * that is itself a shared struct is written STRUCT(gpu_y). All are laid out
 * as `scalar`; the build compares C's offsets with the SPIR-V.
 */
#ifndef FNL_SHADERS_SHARED_H
#define FNL_SHADERS_SHARED_H

#ifdef GL_core_profile /* GLSL */
#define ADDRESS(block) block
#define STRUCT(name) name
#else
#include "base/maths.h"
#include <sys/types.h>
typedef struct uvec2 {
    uint32_t x, y;
} uvec2;
typedef struct uvec3 {
    uint32_t x, y, z;
} uvec3;
#define ADDRESS(block) uint64_t
#define STRUCT(name) struct name
#endif

#endif
