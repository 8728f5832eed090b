#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// How many pages of each row were drawn.
#include "common.glsl"
#include "shadows/faces.glsl"
#include "passes/shadow/split.glsl"

layout(local_size_x = 1) in;
layout(push_constant, scalar) uniform push_block { gpu_shadow_drawn_push push; };

void main() {
    atomicAdd(push.kept.at[push.pages.at[push.drawn.at[gl_WorkGroupID.x]].row].drawn, 1u);
}
