#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// The level of the normals' pyramid whose texels are tiles: octahedral normals cannot be averaged as they are, so all levels down to it
// are reduced here, by halves. Sky counts for nothing.
#include "common.glsl"
#include "passes/lights/backface.glsl"

layout(local_size_x = 8, local_size_y = 8) in; // one group a tile
// push.front: the normals
layout(push_constant, scalar) uniform push_block { gpu_cells_push push; };


shared vec3 sums[64];

void main() {
    uint tile_size = push.list.list.tile_size;
    uvec2 first = gl_WorkGroupID.xy * tile_size, end = min(first + tile_size, push.view.view.size);
    vec3 sum = vec3(0.0);
    for (uint y = first.y + gl_LocalInvocationID.y; y < end.y; y += 8u)
        for (uint x = first.x + gl_LocalInvocationID.x; x < end.x; x += 8u)
            if (texelFetch(textures[push.depth], ivec2(x, y), 0).r > 0.0)
                sum += octahedral_decode(texelFetch(textures[push.front], ivec2(x, y), 0).xy * 2.0 - 1.0);
    uint index = gl_LocalInvocationIndex;
    sums[index] = sum;
    for (uint half_count = 32u; half_count > 0u; half_count /= 2u) {
        barrier();
        if (index < half_count) sums[index] += sums[index + half_count];
    }
    if (index == 0u) BACKFACE.axes.at[gl_WorkGroupID.y * push.list.list.tiles_x + gl_WorkGroupID.x] = sums[0];
}
