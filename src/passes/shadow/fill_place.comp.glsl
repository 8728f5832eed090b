#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// From the order of pages to that of units; and a draw for each unit that some page shows. Draws and the pages of a unit have no fixed order:
// depth does not depend on it.
#include "common.glsl"
#include "passes/shadow/fill.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform push_block { gpu_fill_push push; };

void place(uint page) {
    uint first = push.sums.at[page], end = push.sums.at[page + 1u];
    if (end > push.pair_capacity) return;
    for (uint i = first; i < end; i++) {
        gpu_fill_entry e = push.entries.at[i];
        push.pairs.at[push.unit_sums.at[e.unit] + e.rank] = gpu_fill_pair(e.item, page);
    }
}

void draw(uint index) {
    scene_block s = push.rays.rays.scene;
    uint first = push.unit_sums.at[index], count = push.unit_sums.at[index + 1u] - first;
    if (count == 0u) return;
    gpu_group group = s.scene.groups.at[group_of(s, push.group_count, index, true)];
    gpu_primitive primitive = s.scene.primitives.at[group.primitive];
    gpu_draw d = gpu_draw(primitive.index_count, count, primitive.first_index, primitive.vertex_offset, first);
    if (index > group.first_unit) {
        gpu_cluster cluster = s.scene.clusters.at[primitive.first_cluster + (index - group.first_unit - 1u)];
        d.index_count = 3u * cluster.triangle_count;
        d.first_index += 3u * cluster.first_triangle;
    }
    uint cutout = (s.scene.materials.at[primitive.material].flags & (GPU_MATERIAL_MASK | GPU_MATERIAL_TRANSMISSIVE)) != 0u ? 1u : 0u;
    push.draws.at[cutout * push.unit_count + atomicAdd(push.totals.totals.draw_counts[cutout], 1u)] = d;
    atomicAdd(push.totals.totals.triangles, d.index_count / 3u * count);
}

void main() {
    uint index = LINEAR_INVOCATION;
    if (index < push.page_limit) place(index);
    if (index < push.unit_count) draw(index);
}
