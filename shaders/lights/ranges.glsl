// SPDX-License-Identifier: MIT
// Ranges of view depth, two codes of 16 bits in a word. A code orders as the depths do, so a range holds a depth where its codes do.
#ifndef LIGHTS_RANGES_GLSL
#define LIGHTS_RANGES_GLSL

// A float of 5 bits of exponent and 11 of mantissa: steps of 1/2048 from half a millimetre to 2000 km.
uint depth_code(float view_depth) {
    return uint(clamp(int(floatBitsToUint(max(view_depth, 0.0)) >> 12) - (116 << 11), 0, 0xffff));
}

uint depth_range(float near, float far) { return depth_code(near) | depth_code(far) << 16; }

bool depth_in_range(uint code, uint range) { return code >= (range & 0xffffu) && code <= range >> 16; }

#endif
