#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Marks the items that some view draws, where each has been culled by itself.
#include "common.glsl"
#include "view.glsl"
#include "scene.glsl"
#include "passes/geometry/hierarchy.glsl"
#include "passes/geometry/cull_shared.h"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform push_block { gpu_cull_union_push push; };

void main() {
    uint index = LINEAR_INVOCATION;
    if (index > push.item_count) return;
    bool visible = false;
    for (uint v = 0u; v < push.view_count && index < push.item_count; v++)
        visible = visible || push.views[v].at[index + 1u] != push.views[v].at[index];
    push.sums.at[index] = visible ? 1u : 0u;
}
