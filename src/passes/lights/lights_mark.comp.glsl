#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Marks the lights whose bounding sphere touches the view.
#include "common.glsl"
#include "passes/lights/in_view.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform push_block { gpu_lights_push push; };

void main() {
    uint index = LINEAR_INVOCATION;
    if (index > push.light_count) return;
    bool visible = index < push.light_count;
    if (visible) {
        gpu_light light = push.list.list.lights.at[push.list.list.directional_count + index];
        visible = light.bound_radius > 0.0;
        if (push.cull == 1u) visible = visible && light_in_view(push.view, light.bound_center, light.bound_radius);
    }
    push.sums.at[index] = visible ? 1u : 0u;
}
