#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Marks the lights that touch each block of tiles, so that a tile only looks at those: a group takes 2048 lights in view, a block and
// a list.
#include "common.glsl"
#include "passes/lights/fine_steps.glsl"

layout(local_size_x = 64) in;

shared uint nearest, farthest;
shared uint words[64];

void main() {
    uint thread = gl_LocalInvocationIndex, flags = fine_flags(gl_WorkGroupID.z);
    uvec2 tiles = uvec2(push.list.list.tiles_x, push.list.list.tiles_y), blocks = fine_blocks();
    uvec2 first = uvec2(gl_WorkGroupID.y % blocks.x, gl_WorkGroupID.y / blocks.x) * push.block, end = min(first + push.block, tiles);
    words[thread] = 0u;
    if (thread == 0u) {
        nearest = 0xffffffffu;
        farthest = 0u;
    }
    barrier();
    vec2 depths = vec2(0.0, FINE_FAR);
    if ((flags & (FINE_MIN_DEPTH | FINE_MAX_DEPTH)) != 0u) {
        uint width = end.x - first.x;
        for (uint i = thread; i < width * (end.y - first.y); i += 64u) {
            vec2 tile = fine_depths(flags, fine_range_of(flags, first + uvec2(i % width, i / width)));
            if (tile.x > tile.y) continue;
            atomicMin(nearest, floatBitsToUint(tile.x));
            atomicMax(farthest, floatBitsToUint(tile.y));
        }
        barrier();
        depths = nearest == 0xffffffffu ? vec2(1.0, -1.0) : vec2(uintBitsToFloat(nearest), uintBitsToFloat(farthest));
    }
    uint count = push.visible_sums.at[push.list.list.local_count];
    if (depths.x <= depths.y) {
        vec4 rect = vec4(first * push.list.list.tile_size, min(end * push.list.list.tile_size, push.view.view.size));
        for (uint i = 0u; i < 32u; i++) { // neighbouring threads read neighbouring lights
            uint index = gl_WorkGroupID.x * 2048u + i * 64u + thread;
            if (index < count && fine_touches(push.boxes.at[index], flags, rect, depths))
                atomicOr(words[i * 2u + thread / 32u], 1u << (thread & 31u));
        }
    }
    barrier();
    uint word = gl_WorkGroupID.x * 64u + thread;
    if (word < fine_words()) push.marks.at[fine_marks_of(gl_WorkGroupID.z, first) + word] = words[thread];
}
