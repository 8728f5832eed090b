#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// The largest mip of the cube map, from a picture by longitude and latitude.
#include "passes/ambient/environment_texels.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform push_block { gpu_environment_faces_push push; };

void main() {
    uint face, index = LINEAR_INVOCATION;
    uvec2 at;
    if (!texel_place(index, push.side, face, at)) return;
    vec3 sum = vec3(0.0);
    for (uint i = 0u; i < push.taps * push.taps; i++) {
        vec2 place = (vec2(at) + (vec2(i % push.taps, i / push.taps) + 0.5) / float(push.taps)) / float(push.side) * 2.0 - 1.0;
        vec3 direction = normalize(face_point(face, place.x, place.y));
        vec2 uv = vec2(atan(direction.z, direction.x) * (0.5 / PI) + 0.5, acos(clamp(direction.y, -1.0, 1.0)) / PI);
        sum += textureLod(sampler2D(textures[push.picture], samplers[push.sampler_index]), uv, 0.0).rgb;
    }
    push.texels.at[index] = texel_pack(sum / float(push.taps * push.taps));
}
