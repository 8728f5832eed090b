// SPDX-License-Identifier: MIT
// From sRGB to linear light; common.glsl has the way back.
#ifndef SRGB_GLSL
#define SRGB_GLSL

vec3 srgb_decode(vec3 c) { return mix(c / 12.92, pow((c + 0.055) / 1.055, vec3(2.4)), greaterThan(c, vec3(0.04045))); }

#endif
