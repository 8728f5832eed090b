#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Marks the lights whose volumes are drawn, spheres and cones apart.
#include "common.glsl"
#include "passes/shade/volumes.glsl"
#include "passes/lights/in_view.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform push_block { gpu_volumes_push push; };

void main() {
    uint index = LINEAR_INVOCATION;
    if (index > push.light_count) return;
    if (index == push.light_count) {
        push.sums.at[2u * index] = 0u; // becomes the total
        return;
    }
    gpu_entity_bounds bounds = push.lighting.scope.lights.entities.at[index];
    bool drawn = bounds.radius > 0.0 && (push.cull == 0u || light_in_view(push.view, bounds.center, bounds.radius));
    bool solid = push.shape == VOLUME_SOLIDS || push.shape == VOLUME_DEPTH_BOUNDS || push.shape == VOLUME_STENCIL;
    bool cone = solid && drawn && volume_is_cone(shape_of(lights_of(push.lighting), bounds));
    push.sums.at[index] = drawn && !cone ? 1u : 0u;
    push.sums.at[push.light_count + index] = drawn && cone ? 1u : 0u;
}
