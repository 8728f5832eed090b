#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Reads the atlas of what is seen, and shades it, once for each surface that a pixel's samples show.
#define MATERIAL_GRADIENTS
#define MATERIAL_TEXEL
#define SHADES_SAMPLES
#include "passes/texturing/texturing_shade.glsl"
