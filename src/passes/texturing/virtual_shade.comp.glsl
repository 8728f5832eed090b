#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Reads the atlas of what is seen, and shades it.
#define MATERIAL_GRADIENTS
#define MATERIAL_TEXEL
#include "passes/texturing/texturing_shade.glsl"
