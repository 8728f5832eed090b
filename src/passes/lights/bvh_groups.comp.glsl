#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Boxes round groups of cells.
#include "common.glsl"
#include "passes/lights/bvh.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform push_block { gpu_bvh_mask_push push; };

void add_cell(inout gpu_bvh_box box, uint cell) {
    vec3 low = push.cells.at[cell].low, high = push.cells.at[cell].high;
    if (!(low.z > high.z)) box_add(box, low, high);
}

void main() {
    uint group = LINEAR_INVOCATION;
    if (group >= push.group_count) return;
    gpu_bvh_box box = box_empty();
    gpu_light_list l = push.list.list;
    if (push.rule.run > 0u) {
        uint end = min((group + 1u) * push.rule.run, min(push.cell_counter.at[0], push.cell_count));
        for (uint cell = group * push.rule.run; cell < end; cell++) add_cell(box, cell);
    } else {
        uvec2 groups = (uvec2(l.tiles_x, l.tiles_y) + push.rule.block.xy - 1u) / push.rule.block.xy;
        uvec3 first = uvec3(group % groups.x, group / groups.x % groups.y, group / (groups.x * groups.y)) * push.rule.block;
        uvec3 end = min(first + push.rule.block, uvec3(l.tiles_x, l.tiles_y, l.slices));
        for (uint z = first.z; z < end.z; z++)
            for (uint y = first.y; y < end.y; y++)
                for (uint x = first.x; x < end.x; x++) add_cell(box, (z * l.tiles_y + y) * l.tiles_x + x);
    }
    push.groups.at[group] = box;
}
