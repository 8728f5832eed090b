#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
// The encoder in a pixel shader: a pixel is a block.
#include "passes/compress/bc6h.glsl"

layout(location = 0) out uvec4 out_block;

void main() { out_block = bc6h_encode(uvec2(gl_FragCoord.xy)); }
