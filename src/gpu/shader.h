/* SPDX-License-Identifier: MIT */
/**
 * SPIR-V that the build embeds in the library. fanal_shaders() of cmake/fanal.cmake makes one of these per entry point:
 * tiled_count.comp.glsl becomes shader_tiled_count_comp. The generated "shaders.h" declares them all.
 */
#ifndef FNL_GPU_SHADER_H
#define FNL_GPU_SHADER_H

#include <stddef.h>
#include <stdint.h>

struct gpu_shader {
    const char *name;     /**< such as "tiled_count.comp" */
    const uint32_t *code; /**< optimised SPIR-V for Vulkan 1.3, entry point "main" */
    size_t size;          /**< bytes of code, a multiple of 4 */
};

#endif
