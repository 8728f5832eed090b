// SPDX-License-Identifier: MIT
#ifndef ROUGHNESS_GLSL
#define ROUGHNESS_GLSL

// Smallest squared roughness. At 0 the highlight of a point light would be a single direction that no pixel samples.
const float ALPHA_MIN = 1e-3;

float alpha_of(float roughness) { return max(roughness * roughness, ALPHA_MIN); }

#endif
