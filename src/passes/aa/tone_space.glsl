// SPDX-License-Identifier: MIT
// The space in which temporal antialiasing takes means: near what the picture's tone mapper makes of a colour, and invertible, so that a mean
// there is, once tone-mapped, the mean of the tone-mapped samples.
#ifndef TONE_SPACE_GLSL
#define TONE_SPACE_GLSL

#include "passes/post/post_shared.h"

layout(constant_id = 0) const uint TONEMAP = GPU_TONEMAP_NONE;

// Beyond this many times white all operators have come so near their end that nothing is to be told apart.
const float TONE_LIMIT = 256.0;

// Khronos PBR Neutral, exactly: below the start of its shoulder only an offset, above it a hyperbola and some desaturation.
const float NEUTRAL_START = 0.76, NEUTRAL_REST = 0.24, NEUTRAL_DESATURATION = 0.15;

vec3 neutral_of(vec3 x) {
    float low = min(x.r, min(x.g, x.b));
    x -= low < 0.08 ? low - 6.25 * low * low : 0.04;
    float peak = max_component(x);
    if (peak < NEUTRAL_START) return x;
    float shown = 1.0 - NEUTRAL_REST * NEUTRAL_REST / (peak + NEUTRAL_REST - NEUTRAL_START);
    float kept = 1.0 / (NEUTRAL_DESATURATION * (peak - shown) + 1.0);
    return mix(vec3(shown), x * (shown / peak), kept);
}

vec3 neutral_inverse(vec3 y) {
    float shown = max_component(y);
    if (shown >= NEUTRAL_START) {
        float peak = min(NEUTRAL_REST * NEUTRAL_REST / max(1.0 - shown, 1e-5) - NEUTRAL_REST + NEUTRAL_START, TONE_LIMIT);
        float kept = 1.0 / (NEUTRAL_DESATURATION * (peak - shown) + 1.0);
        y = max((y - shown * (1.0 - kept)) / kept, vec3(0.0)) * (peak / shown);
    }
    float low = max(min(y.r, min(y.g, y.b)), 0.0);
    float before = low < 0.04 ? sqrt(low / 6.25) : low + 0.04;
    return y + (before - low);
}

// The curve of ACES as fitted by Hill (tonemap.comp.glsl), without its matrices: a quadratic in its inverse.
vec3 aces_of(vec3 x) { return max((x * (x + 0.0245786) - 0.000090537) / (x * (0.983729 * x + 0.4329510) + 0.238081), vec3(0.0)); }
vec3 aces_inverse(vec3 y) {
    y = min(y, vec3(1.01));
    vec3 a = 1.0 - 0.983729 * y, b = 0.0245786 - 0.4329510 * y, c = -0.000090537 - 0.238081 * y;
    return (sqrt(max(b * b - 4.0 * a * c, vec3(0.0))) - b) / (2.0 * a);
}

// x^1.08 / (x^1.08 + 0.66) is within 0.025 of AgX's curve for greys up to 16 times white.
vec3 agx_of(vec3 x) {
    vec3 p = pow(x, vec3(1.08));
    return p / (p + 0.66);
}
vec3 agx_inverse(vec3 y) {
    y = min(y, vec3(0.999));
    return pow(0.66 * y / (1.0 - y), vec3(1.0 / 1.08));
}

// As it is, with all that is brighter than white in the last fiftieth.
vec3 plain_of(vec3 x) { return mix(x, 1.02 - 0.0004 / (x - 0.98), greaterThan(x, vec3(1.0))); }
vec3 plain_inverse(vec3 y) { return mix(y, 0.98 + 0.0004 / max(1.02 - y, 1e-6), greaterThan(y, vec3(1.0))); }

vec3 to_tone(vec3 x) {
    x = clamp(x, vec3(0.0), vec3(TONE_LIMIT));
    if (TONEMAP == GPU_TONEMAP_KHRONOS_NEUTRAL) return neutral_of(x);
    if (TONEMAP == GPU_TONEMAP_ACES) return aces_of(x);
    if (TONEMAP == GPU_TONEMAP_AGX) return agx_of(x);
    return plain_of(x);
}

vec3 from_tone(vec3 y) {
    y = max(y, vec3(0.0));
    if (TONEMAP == GPU_TONEMAP_KHRONOS_NEUTRAL) return neutral_inverse(y);
    if (TONEMAP == GPU_TONEMAP_ACES) return aces_inverse(y);
    if (TONEMAP == GPU_TONEMAP_AGX) return agx_inverse(y);
    return plain_inverse(y);
}

#endif
