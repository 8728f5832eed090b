/* SPDX-License-Identifier: MIT */
/**
 * SPIR-V that the build embeds in the library. fanal_shaders() of cmake/shaders.cmake makes one of these per entry point:
 * tiled_count.comp.glsl becomes shader_tiled_count_comp. The generated "shaders.h" declares them all.
 */
#ifndef FNL_GPU_SHADER_H
#define FNL_GPU_SHADER_H

#include "base/base.h"

struct gpu_shader {
    const char *name;            /**< such as "tiled_count.comp" */
    const unsigned char *packed; /**< optimised SPIR-V for Vulkan 1.3, entry point "main", compressed by zstd */
    size_t packed_size;
    size_t size;              /**< bytes of SPIR-V, a multiple of 4 */
    uint32_t inputs, outputs; /**< bits of the locations below 32 that it reads and writes, after optimisation */
};

/** The SPIR-V; its `size` bytes are freed by host_free. NULL when memory ran out (logged, with the shader's name). */
uint32_t *gpu_shader_code(const fnl_host *host, const struct gpu_shader *shader);

#endif
