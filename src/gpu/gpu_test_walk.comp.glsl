// SPDX-License-Identifier: MIT
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_buffer_reference_uvec2 : require
#extension GL_EXT_scalar_block_layout : require

layout(local_size_x_id = 2) in;
layout(local_size_x = 64) in;
layout(constant_id = 0) const uint mode = 0u;
layout(constant_id = 1) const uint turns = 5u;
layout(constant_id = 3) const bool doubled = false;
layout(constant_id = 4) const float scale = 1.5;
layout(constant_id = 5) const int shift = -1;

layout(buffer_reference, scalar) buffer words { uint at[]; };
layout(push_constant, scalar) uniform push {
    uvec2 from, to;
    uint count;
};

#define WALK uint
#include "gpu/gpu_test_walk.h"

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= count) return;
    uint x = walk(mode, turns, words(from).at[i]);
    if (doubled) x *= 2u;
    if (shift < 0) x += uint(4.0 * scale);
    else x <<= uint(shift);
    words(to).at[i] = x;
}
