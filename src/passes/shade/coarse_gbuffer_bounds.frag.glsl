#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
#define COARSE_BOUNDS
#include "passes/shade/coarse_gbuffer.glsl"
