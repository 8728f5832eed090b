#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Counts what is to be shaded at each pixel: its triangle, or those of its samples.
#include "common.glsl"
#include "scene.glsl"
#include "view.glsl"
#include "passes/visibility/visible.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform push_block { gpu_visible_push push; };

shared uint group_counts[EDGES_SHADED];

uint triangles_of(ivec2 pixel, out uint word) {
    uvec2 seen[8];
    uint count = 0u;
    word = 0xffffffffu;
    for (uint i = 0u; i < SAMPLES; i++) {
        uvec2 id = visible_id(push.ids, push.ids_high, pixel, int(i));
        if (visible_item(id, push.triangle_bits) == 0u) continue;
        uint found = 0u;
        while (found < count && seen[found] != id) found++;
        seen[found] = id;
        count = max(count, found + 1u);
        word ^= (SURFACE_NONE ^ found) << (SURFACE_BITS * i);
    }
    return count;
}

void main() {
    uint place = (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * 64u + gl_LocalInvocationIndex, count = 0u, word;
    uvec2 size = push.view.view.size, pixel = pixel_of_place(gl_WorkGroupID.xy, gl_LocalInvocationIndex);
    bool inside = all(lessThan(pixel, size));
    if (inside) count = triangles_of(ivec2(pixel), word);
    push.sums.at[place] = count;
    if (SAMPLES == 1u) {
        if (inside && count == 0u)
            imageStore(images[push.radiance], ivec2(pixel), vec4(min(push.background, vec3(push.view.view.frame.frame.hdr_max)), 0.0));
        return;
    }
    if (gl_LocalInvocationIndex < EDGES_SHADED) group_counts[gl_LocalInvocationIndex] = 0u;
    barrier();
    if (inside) {
        push.words.at[pixel.y * size.x + pixel.x] = word;
        if (count > 0u) atomicAdd(group_counts[EDGES_PIXELS], 1u);
        if (surface_is_edge(word)) atomicAdd(group_counts[EDGES_MIXED], 1u);
        if (count > 0u) atomicAdd(group_counts[EDGES_SURFACES], count);
        atomicAdd(group_counts[EDGES_SAMPLES], SAMPLES - uint(bitCount(surface_samples(word, SURFACE_NONE))));
    }
    barrier();
    uint counter = gl_LocalInvocationIndex;
    if (counter < EDGES_SHADED && group_counts[counter] != 0u) atomicAdd(push.counts.at[counter], group_counts[counter]);
}
