// SPDX-License-Identifier: MIT
// |dz/dx| + |dz/dy| of the view depth z at a pixel in 8 bits, which the default layout has to spare: the logarithm of what that sum is of z,
// from 2^-16 to 2 in steps of less than 5 %. Planes that face the viewer give 0.
#ifndef COARSE_GRADIENT_GLSL
#define COARSE_GRADIENT_GLSL

const float GRADIENT_STEPS = 254.0 / 17.0, GRADIENT_LEAST = -16.0; // codes an octave; octave of code 1
const float GRADIENT_NOISE = 1e-6; // what rounding makes of a plane that faces the viewer

// 0 .. 1, for a target of 8 bits.
float gradient_encode(float sum, float view_depth) {
    float part = sum / max(view_depth, 1e-30);
    float code = part > GRADIENT_NOISE ? clamp(1.0 + (log2(part) - GRADIENT_LEAST) * GRADIENT_STEPS, 1.0, 255.0) : 0.0;
    return code * (1.0 / 255.0);
}

float gradient_decode(float stored, float view_depth) {
    float code = round(stored * 255.0);
    return code > 0.0 ? exp2((code - 1.0) / GRADIENT_STEPS + GRADIENT_LEAST) * view_depth : 0.0;
}

#endif
