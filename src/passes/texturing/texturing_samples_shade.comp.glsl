#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Reads the textures of what is seen through the bindless set, and shades it, once for each surface that a pixel's samples show.
#define MATERIAL_GRADIENTS
#define SHADES_SAMPLES
#include "passes/texturing/texturing_shade.glsl"
