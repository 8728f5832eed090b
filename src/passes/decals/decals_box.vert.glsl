#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// The box of a decal, so much larger that rasterisation loses no pixel whose middle it holds.
#include "common.glsl"
#include "decals.glsl"
#include "passes/decals/decals_pass_shared.h"

layout(push_constant, scalar) uniform push_block { gpu_decals_box_push push; };

layout(location = 0) flat out uint out_decal;

void main() {
    uint id = push.ids.at[gl_InstanceIndex];
    decal_array decals = push.set.set.decals;
    mat3 to_cube = transpose(mat3(decals.at[id].rows[0].xyz, decals.at[id].rows[1].xyz, decals.at[id].rows[2].xyz));
    mat3 axes = inverse(to_cube);
    if (determinant(to_cube) < 0.0) axes[0] = -axes[0]; // windings stay
    vec3 middle = -(inverse(to_cube) * vec3(decals.at[id].rows[0].w, decals.at[id].rows[1].w, decals.at[id].rows[2].w));
    view_block v = push.view;
    float reach = length(axes[0]) + length(axes[1]) + length(axes[2]);
    float view_depth = v.view.orthographic > 0.5 ? 1.0 : abs((v.view.world_to_view * vec4(middle, 1.0)).z) + reach;
    vec2 size = 2.0 * abs(v.view.ndc_scale) * v.view.inverse_size * view_depth;
    float slack = 2.0 * max(size.x, size.y) + 1e-4 * reach + 1e-6 * length(middle);
    vec3 sides = vec3(uvec3(gl_VertexIndex) >> uvec3(0u, 1u, 2u) & 1u) - 0.5;
    vec3 position = middle;
    for (int i = 0; i < 3; i++) {
        float extent = length(axes[i]);
        // Thin axes of skewed boxes are widened by more than they need, which costs fragments alone.
        position += axes[i] * (sides[i] * (1.0 + 2.0 * slack / max(extent, 1e-12)));
    }
    gl_Position = v.view.world_to_clip * vec4(position, 1.0);
    out_decal = id;
}
