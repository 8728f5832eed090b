#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// From the order of pages to that of items, which is that of groups; and a draw for each group that some page shows. Draws and
// the pages of an item have no fixed order: depth does not depend on it.
#include "common.glsl"
#include "passes/shadow/fill.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform push_block { gpu_fill_push push; };

void place(uint page) {
    uint first = push.sums.at[page], end = push.sums.at[page + 1u];
    if (end > push.pair_capacity) return;
    for (uint i = first; i < end; i++) {
        gpu_fill_entry e = push.entries.at[i];
        push.pairs.at[push.item_sums.at[e.item] + e.rank] = gpu_fill_pair(e.item, page);
    }
}

void draw(uint index) {
    scene_block s = push.rays.rays.scene;
    gpu_group group = s.scene.groups.at[index];
    uint first = push.item_sums.at[group.first_item], count = push.item_sums.at[group.first_item + group.item_count] - first;
    if (count == 0u) return;
    gpu_primitive primitive = s.scene.primitives.at[group.primitive];
    uint cutout = (s.scene.materials.at[primitive.material].flags & GPU_MATERIAL_MASK) != 0u ? 1u : 0u;
    uint at = atomicAdd(push.totals.totals.draw_counts[cutout], 1u);
    push.draws.at[cutout * push.group_count + at] =
        gpu_draw(primitive.index_count, count, primitive.first_index, primitive.vertex_offset, first);
}

void main() {
    uint index = LINEAR_INVOCATION;
    if (index < push.page_limit) place(index);
    if (index < push.group_count) draw(index);
}
