#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Which nodes of one level touch a group of cells: a thread takes the children of one node above, if that one touches.
#include "common.glsl"
#include "passes/lights/bvh.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform push_block { gpu_bvh_mask_push push; };

void main() {
    uint group = LINEAR_INVOCATION / push.words, word = LINEAR_INVOCATION % push.words;
    if (group >= push.group_count) return;
    uint mask = 0u;
    bool visit = push.rule.run == 0u || group * push.rule.run < push.cell_counter.at[0];
    if (visit && push.parent_words > 0u)
        visit = (push.masks.at[push.first_parent + group * push.parent_words + word / 32u] >> (word % 32u) & 1u) == 1u;
    if (visit) {
        gpu_bvh_box box = push.groups.at[group];
        uint light_count = push.count.at[0], node_count = light_count / push.node_lights + (light_count % push.node_lights > 0u ? 1u : 0u);
        uint end = min((word + 1u) * 32u, node_count);
        for (uint node = word * 32u; node < end; node++) {
            gpu_bvh_box b = push.boxes.at[push.first_node + node];
            if (boxes_touch(box.low, box.high, b.low, b.high)) mask |= 1u << (node % 32u);
        }
    }
    push.masks.at[push.first_mask + group * push.words + word] = mask;
}
