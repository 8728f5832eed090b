#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Marks what is of the kinds that the list is for and whose bounding sphere touches the view.
#include "common.glsl"
#include "passes/lights/in_view.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform push_block { gpu_lights_push push; };

void main() {
    uint index = LINEAR_INVOCATION;
    if (index > push.light_count) return;
    bool visible = index < push.light_count;
    if (visible) {
        gpu_entity_bounds entity = push.list.list.lights.set.entities.at[index];
        visible = entity.radius > 0.0 && (push.kinds >> entity.kind & 1u) != 0u;
        if (push.cull == 1u) visible = visible && light_in_view(push.view, entity.center, entity.radius);
    }
    push.sums.at[index] = visible ? 1u : 0u;
}
