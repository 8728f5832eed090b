#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
#include "common.glsl"

layout(buffer_reference) buffer hidden_area_corners;
#include "passes/stereo/hidden_area_shared.h"
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer hidden_area_corners { vec2 at[]; };

layout(push_constant, scalar) uniform push_block { gpu_hidden_area_push push; };

void main() { gl_Position = vec4(push.corners.at[gl_VertexIndex], push.depth, 1.0); }
