/* SPDX-License-Identifier: MIT */
/**
 * Specialises SPIR-V before the driver sees it: constants take their values, branches that they decide go away, and so does all that is then not
 * used. Shaders of Fanal hold the code of every list, kind of light and kind of shadow; of that a pipeline needs a tenth to a half, and drivers
 * (and the validation layer) take time for each word that they are given, also for code that cannot be reached.
 *
 * Constants spread through integers and truth values, over branches that are known (sparse conditional constant propagation: Wegman, Zadeck 1991).
 * Arithmetic of floats is left to the driver, so pictures keep their bits.
 */
#ifndef FNL_GPU_SPECIALISE_H
#define FNL_GPU_SPECIALISE_H

#include "base/base.h"

/** The value of a specialisation constant: bits of a 32-bit number, or whether a bool is true. */
struct gpu_constant {
    uint32_t id, value;
};

/** A SPIR-V module. */
struct gpu_spirv {
    uint32_t *words;
    size_t count;
    size_t size; /**< bytes of the block, for host_free */
};

/**
 * The module with these constants; those that are not given have the values that the shader states. It has no specialisation constants of 32 bits
 * or bools left, and where it has no ray query left it does not ask for VK_KHR_ray_query. Names, decorations and interface are kept for what
 * remains. The same input gives the same words.
 * \param words valid SPIR-V 1.4 or later, of `count` words, without switches over 64-bit numbers
 * \param out the caller frees its words
 * \return FNL_ERROR_MEMORY, or FNL_ERROR_INVALID for what is not SPIR-V (neither is logged)
 */
fnl_result gpu_specialise(const fnl_host *host, const uint32_t *words, size_t count, uint32_t constant_count,
                          const struct gpu_constant *constants, struct gpu_spirv *out);

#endif
