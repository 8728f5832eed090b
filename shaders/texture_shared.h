/* SPDX-License-Identifier: MIT */
/** A texture of a material. */
#ifndef FNL_SHADERS_TEXTURE_SHARED_H
#define FNL_SHADERS_TEXTURE_SHARED_H

#include "shared.h"

#define GPU_TEXTURE_NONE 0xffffffffu
#define GPU_TEXTURE_UV1 1u     /* flags: the second texture coordinates */
#define GPU_TEXTURE_ROUND 2u   /* its sampler has no anisotropy */

struct gpu_texture {
    uint image;     /* index into the bindless textures, or GPU_TEXTURE_NONE */
    uint sampler_index;
    uint flags;     /* GPU_TEXTURE_… */
    float transform[6];
};

#endif
