#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Sort keys of blended items: the farthest first, hidden ones last.
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
    uint item_index = push.first_item + index;
    uint key = 0xffffffffu;
    if (push.sums.at[item_index + 1u] != push.sums.at[item_index]) {
        gpu_item item = push.scene.scene.items.at[item_index];
        vec3 center = transform_point(push.scene.scene.instances.at[item.instance], push.scene.scene.primitives.at[item.primitive].center);
        float depth = -(push.view.view.world_to_view * vec4(center, 1.0)).z;
        // The bits of a non-negative float ascend with it.
        key = 0x7fffffffu - (depth > 0.0 ? floatBitsToUint(depth) : 0u);
    }
    push.keys_out.at[index * 2u] = key;
    push.keys_out.at[index * 2u + 1u] = item_index;
}
