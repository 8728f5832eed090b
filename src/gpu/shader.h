/* SPDX-License-Identifier: MIT */
/**
 * SPIR-V that the build embeds in the library. fanal_shaders() of cmake/shaders.cmake makes one of these per entry point:
 * tiled_count.comp.glsl becomes shader_tiled_count_comp. The generated "shaders.h" declares them all.
 */
#ifndef FNL_GPU_SHADER_H
#define FNL_GPU_SHADER_H

#include "base/base.h"

struct gpu_code {
    const unsigned char *packed; /**< optimised SPIR-V for Vulkan 1.3, entry point "main", compressed by zstd */
    size_t packed_size;
    size_t size; /**< bytes of SPIR-V, a multiple of 4 */
};

struct gpu_shader {
    const char *name; /**< such as "tiled_count.comp" */
    struct gpu_code code;
    struct gpu_code lean;     /**< the same without the code that only lean_bits of constant 0 ask for, or empty: drivers compile it in half the time */
    uint32_t lean_bits;
    uint32_t inputs, outputs; /**< bits of the locations below 32 that it reads and writes, after optimisation */
};

/** `lean` where it does for these specialisation constants, or `code`. */
const struct gpu_code *gpu_shader_choose(const struct gpu_shader *shader, uint32_t constant_count, const uint32_t *constants);

/** The SPIR-V; its `size` bytes are freed by host_free. NULL when memory ran out (logged, with the shader's name). */
uint32_t *gpu_shader_code(const fnl_host *host, const char *name, const struct gpu_code *code);

#endif
