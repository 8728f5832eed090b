#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
#include "passes/shade/coarse_gbuffer.glsl"
