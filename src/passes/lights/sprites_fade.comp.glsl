#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Copies the lights and their bounds with what is left of each.
#include "common.glsl"
#include "passes/lights/sprites.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform push_block { gpu_sprites_push push; };

void main() {
    uint index = LINEAR_INVOCATION, light_count = push.directional_count + push.local_count;
    if (index >= light_count) return;
    gpu_light light = push.lights.at[index];
    if (index >= push.directional_count) {
        gpu_entity_bounds bounds = push.bounds.at[index - push.directional_count];
        float fade = light_fade(push.view, bounds.center, bounds.radius, push.lod);
        if (fade < 1.0) light.color *= fade;
        if (fade == 0.0) bounds.radius = light.shape.range = 0.0; // nothing is in its range
        entity_out_array(push.faded_bounds).at[index - push.directional_count] = bounds;
    }
    light_out_array(push.faded).at[index] = light;
}
