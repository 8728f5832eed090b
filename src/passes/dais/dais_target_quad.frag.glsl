#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
#extension GL_KHR_shader_subgroup_quad : require
// Squares of four pixels share shading samples.
#define DAIS_QUADS
#include "passes/dais/dais_target.glsl"
