// SPDX-License-Identifier: MIT
// The tone mappers, for all that make pictures. Include post_shared.h first.
#ifndef TONEMAP_GLSL
#define TONEMAP_GLSL

// Khronos PBR Neutral tone mapper, from its specification (Khronos Group 2024).
vec3 khronos_neutral(vec3 color) {
    const float start = 0.8 - 0.04, desaturation = 0.15;
    float low = min(color.r, min(color.g, color.b));
    float offset = low < 0.08 ? low - 6.25 * low * low : 0.04;
    color -= offset;
    float peak = max_component(color);
    if (peak < start) return color;
    const float d = 1.0 - start;
    float new_peak = 1.0 - d * d / (peak + d - start);
    color *= new_peak / peak;
    float g = 1.0 - 1.0 / (desaturation * (peak - new_peak) + 1.0);
    return mix(color, vec3(new_peak), g);
}

// ACES reference transforms as fitted by S. Hill (2016): sRGB to a saturated working space, rational fit, and back.
vec3 aces(vec3 color) {
    const mat3 into = mat3(0.59719, 0.07600, 0.02840, 0.35458, 0.90834, 0.13383, 0.04823, 0.01566, 0.83777);
    const mat3 back = mat3(1.60475, -0.10208, -0.00327, -0.53108, 1.10813, -0.07276, -0.07367, -0.00605, 1.07602);
    color = into * color;
    color = (color * (color + 0.0245786) - 0.000090537) / (color * (0.983729 * color + 0.4329510) + 0.238081);
    return clamp(back * color, 0.0, 1.0);
}

// AgX (Sobotka 2022): log2 encoding in an inset space and the polynomial fit of its contrast curve by B. Wrensch (2023).
vec3 agx(vec3 color) {
    const mat3 inset = mat3(0.842479062253094, 0.0423282422610123, 0.0423756549057051, 0.0784335999999992, 0.878468636469772,
                            0.0784336, 0.0792237451477643, 0.0791661274605434, 0.879142973793104);
    const mat3 outset = mat3(1.19687900512017, -0.0528968517574562, -0.0529716355144438, -0.0980208811401368, 1.15190312990417,
                             -0.0980434501171241, -0.0990297440797205, -0.0989611768448433, 1.15107367264116);
    color = clamp((log2(max(inset * color, vec3(1e-10))) + 12.47393) / (4.026069 + 12.47393), 0.0, 1.0);
    vec3 x2 = color * color, x4 = x2 * x2;
    color = 15.5 * x4 * x2 - 40.14 * x4 * color + 31.96 * x4 - 6.868 * x2 * color + 0.4298 * x2 + 0.1191 * color - 0.00232;
    // The curve's result is display-encoded with exponent 2.2; linear light is wanted here.
    return pow(clamp(outset * color, 0.0, 1.0), vec3(2.2));
}

// Of exposed radiance; not yet clamped to 0..1. `tonemap` is a GPU_TONEMAP_…
vec3 tone_map(uint tonemap, vec3 color) {
    if (tonemap == GPU_TONEMAP_KHRONOS_NEUTRAL) return khronos_neutral(color);
    if (tonemap == GPU_TONEMAP_ACES) return aces(color);
    if (tonemap == GPU_TONEMAP_AGX) return agx(color);
    return color;
}

#endif
