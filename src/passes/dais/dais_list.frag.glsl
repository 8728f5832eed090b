#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
#extension GL_ARB_post_depth_coverage : require
// Coverage after the depth test.
layout(post_depth_coverage) in;
#include "passes/dais/dais_list.glsl"
