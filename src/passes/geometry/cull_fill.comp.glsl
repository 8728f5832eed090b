#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Writes the ids of visible items in order, and one indirect draw per group of items of one primitive.
#include "common.glsl"
#include "view.glsl"
#include "scene.glsl"
#include "passes/geometry/hierarchy.glsl"
#include "passes/geometry/cull_shared.h"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform push_block { gpu_cull_push push; };

void main() {
    uint index = LINEAR_INVOCATION;
    if (index < push.item_count) {
        uint slot = push.sums.at[index];
        if (push.sums.at[index + 1u] != slot) push.visible.at[slot] = index;
    }
    if (index < push.group_count) {
        gpu_group group = push.scene.scene.groups.at[index];
        gpu_primitive primitive = push.scene.scene.primitives.at[group.primitive];
        uint first = push.sums.at[group.first_item];
        gpu_draw draw;
        draw.index_count = primitive.index_count;
        draw.instance_count = push.sums.at[group.first_item + group.item_count] - first;
        draw.instance_count *= push.repeat;
        draw.first_index = primitive.first_index;
        draw.vertex_offset = primitive.vertex_offset;
        draw.first_instance = first * push.repeat;
        push.draws.at[index] = draw;
    }
}
