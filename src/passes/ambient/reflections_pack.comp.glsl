#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// The first mip of a probe's cube map, once all faces have been seen.
#include "passes/ambient/environment_texels.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform push_block { gpu_reflections_pack_push push; };

void main() {
    uint index = LINEAR_INVOCATION;
    if (index < push.count) push.texels.at[index] = texel_pack(push.radiances.at[index] / texel_unit(push.peak.at[0]));
}
