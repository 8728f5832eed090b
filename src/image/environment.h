/* SPDX-License-Identifier: MIT */
/**
 * Light from all around as cube maps: packed into bytes, and filtered for surfaces of each roughness (Smith and Einig 2016, "Physically
 * Based Deferred Shading on Mobile", 2.5). On the CPU, for bakers.
 */
#ifndef FNL_IMAGE_ENVIRONMENT_H
#define FNL_IMAGE_ENVIRONMENT_H

#include "base/base.h"
#include "base/maths.h"

/**
 * RGBM: square roots of a colour from 0 to RGBM_MOST, as bytes times a common scale M. M rounds up, so that colours stay within bytes.
 * Where the colours are compressed by blocks, keep M apart and uncompressed: an error of M is one of all channels.
 */
#define RGBM_RANGE 6.0f
#define RGBM_MOST (RGBM_RANGE * RGBM_RANGE)
void rgbm_encode(const float color[3], uint8_t out[4]);
void rgbm_decode(const uint8_t rgbm[4], float out[3]);

/** A cube map with mips: RGB floats, mip by mip, in each of them the faces +X -X +Y -Y +Z -Z in rows from the top left as Vulkan has them. */
struct environment {
    uint32_t size, mips; /* texels of a side; the last mip may have one */
    float *texels;
};
/** All mips that the size has; zeroed. Free it with environment_finish. */
fnl_result environment_init(const fnl_host *host, uint32_t size, struct environment *out);
void environment_finish(const fnl_host *host, struct environment *environment);
/** The texel that looks in (the direction of) `direction`, and the direction of a texel's centre, unit. */
float *environment_texel(const struct environment *environment, uint32_t mip, vec3 direction);
vec3 environment_direction(const struct environment *environment, uint32_t mip, uint32_t face, uint32_t x, uint32_t y);

/** Which mip (fractional) a surface of this roughness reads: 0 for a mirror, the last for the roughest. */
float environment_mip(uint32_t mips, float roughness);
/**
 * Fills mips 1 .. last from mip 0: each for the roughness that environment_mip maps to it, by the GGX lobe seen from the front, cosines as
 * weights (Karis 2013, "Real Shading in Unreal Engine 4"). Exact sums over mip 0 when `samples` is 0, else that many samples of the lobe.
 */
void environment_prefilter(struct environment *environment, uint32_t samples);

/** GGX normal distribution (Walter et al. 2007), alpha = roughness^2, and Schlick's Fresnel term for rough surfaces in light from all around. */
double ggx_distribution(double roughness, double n_h);
double schlick_roughness(double f0, double roughness, double n_v);

#endif
