#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// One indirect draw per blended item, in sorted order; hidden items draw nothing.
#include "common.glsl"
#include "view.glsl"
#include "scene.glsl"
#include "passes/geometry/hierarchy.glsl"
#include "passes/geometry/cull_shared.h"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform push_block { gpu_sort_push push; };

void main() {
    uint index = LINEAR_INVOCATION;
    if (index >= push.item_count) return;
    uint item_index = push.keys_in.at[index * 2u + 1u];
    gpu_primitive primitive = push.scene.scene.primitives.at[push.scene.scene.items.at[item_index].primitive];
    gpu_draw draw;
    draw.index_count = primitive.index_count;
    draw.instance_count = push.keys_in.at[index * 2u] == 0xffffffffu ? 0u : 1u;
    draw.first_index = primitive.first_index;
    draw.vertex_offset = primitive.vertex_offset;
    draw.first_instance = index;
    push.draws.at[index] = draw;
    push.visible.at[index] = item_index;
}
