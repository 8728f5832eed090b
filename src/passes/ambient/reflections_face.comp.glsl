#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// A face of a cube map from what a camera has seen that looks along its axis. Faces are seen from outside of the cube: left is right.
#include "passes/ambient/environment_texels.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform push_block { gpu_reflections_face_push push; };

void main() {
    uint index = LINEAR_INVOCATION, side = push.side;
    if (index >= side * side) return;
    uvec2 at = uvec2(index % side, index / side);
    vec3 color = texelFetch(sampler2D(textures[push.picture], samplers[push.sampler_index]), ivec2(side - 1u - at.x, at.y), 0).rgb;
    push.radiances.at[push.face * side * side + index] = color;
    atomicMax(push.peak.at[0], floatBitsToUint(max(max_component(color), 0.0)));
}
