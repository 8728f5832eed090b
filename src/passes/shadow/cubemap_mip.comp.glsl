#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// A coarser level of a cube map: 4x4 texels with weights 1 3 3 1 make one. Beyond the border of a face they are those of its neighbours, so that no seam
// shows, and blurs of all levels together come near a bell.
#include "common.glsl"
#include "shadows/cube.glsl"

#include "shadows/rays.glsl"

layout(buffer_reference) buffer probe_array;
layout(buffer_reference) buffer probes_block;
#include "passes/shadow/cubemap_push_shared.h"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform push_block { gpu_cubemap_push push; };

void main() {
    uint texel = LINEAR_INVOCATION, side = push.side, finer = 2u * side;
    if (texel >= 6u * side * side) return;
    uint face = texel / (side * side);
    ivec2 first = 2 * ivec2(texel % side, texel / side % side) - 1;
    vec4 sum = vec4(0.0);
    for (int k = 0; k < 16; k++) {
        ivec2 tap = ivec2(k & 3, k >> 2), place = first + tap;
        uint tap_face = face;
        if (any(lessThan(place, ivec2(0))) || any(greaterThanEqual(place, ivec2(finer)))) {
            vec2 at;
            tap_face = cube_face(cube_direction(face, (vec2(place) + 0.5) * (2.0 / float(finer)) - 1.0), at);
            place = clamp(ivec2(floor((at * 0.5 + 0.5) * float(finer))), ivec2(0), ivec2(finer) - 1);
        }
        float weight = ((tap.x + 1 & 2) != 0 ? 3.0 : 1.0) * ((tap.y + 1 & 2) != 0 ? 3.0 : 1.0);
        sum += weight * unpackUnorm4x8(push.texels.at[push.from + (tap_face * finer + uint(place.y)) * finer + uint(place.x)]);
    }
    push.texels.at[push.to + texel] = packUnorm4x8(sum * (1.0 / 64.0));
}
