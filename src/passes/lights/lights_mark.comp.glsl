#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Marks the lights whose bounding sphere touches the view.
#include "common.glsl"
#include "passes/lights/cells.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform push_block { gpu_lights_push push; };

void main() {
    uint index = LINEAR_INVOCATION;
    if (index > push.light_count) return;
    bool visible = index < push.light_count;
    if (visible) {
        gpu_light light = push.list.list.lights.at[push.list.list.directional_count + index];
        visible = light.bound_radius > 0.0;
        float slack = light.bound_radius * (1.0 + CELL_SLACK) + CELL_SLACK * (1e-2 + distance(light.bound_center, push.view.view.eye) * 1e-2) +
                      float(BOUND_ROUNDING) * (length(light.bound_center) + length(push.view.view.eye));
        for (int i = 0; i < 5; i++) {
            vec4 plane = push.view.view.planes[i];
            visible = visible && !(dot(plane.xyz, light.bound_center) + plane.w < -slack);
        }
    }
    push.sums.at[index] = visible ? 1u : 0u;
}
