#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
#extension GL_ARB_post_depth_coverage : require
#extension GL_KHR_shader_subgroup_quad : require
// Coverage after the depth test; squares of four pixels share shading samples.
#define DAIS_QUADS
layout(post_depth_coverage) in;
#include "passes/dais/dais_list.glsl"
