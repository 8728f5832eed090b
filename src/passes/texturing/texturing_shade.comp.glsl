#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Reads the textures of what is seen through the bindless set, and shades it.
#define MATERIAL_GRADIENTS
#include "passes/texturing/texturing_shade.glsl"
