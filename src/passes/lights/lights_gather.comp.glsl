#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Gathers the lights in view, in order, with their bounds in view space.
#include "common.glsl"
#include "passes/lights/cells.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform push_block { gpu_lights_push push; };

void main() {
    uint index = LINEAR_INVOCATION;
    if (index >= push.light_count) return;
    uint slot = push.sums.at[index];
    if (push.sums.at[index + 1u] == slot) return;
    gpu_entity_bounds entity = push.list.list.lights.set.entities.at[index];
    push.ids.at[slot] = index;
    gpu_bound bound;
    bound.center = (push.view.view.world_to_view * vec4(entity.center, 1.0)).xyz;
    bound.radius = entity.radius + float(BOUND_ROUNDING) * (length(entity.center) + length(push.view.view.eye));
    push.bounds.at[slot] = bound;
    if (push.reach == 0u) return;
    gpu_reach reach;
    gpu_shape shape = shape_of(set_of(push.list), entity);
    reach_cone(shape, push.view.view.world_to_view,
               float(BOUND_ROUNDING) * (length(shape.position) + length(push.view.view.eye)), reach);
    reach_rectangle(push.view, bound, reach);
    push.reaches.at[slot] = reach;
}
