#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// The box of a decal, drawn to a grid of tiles: so much larger that the middle of every tile that the box touches is in it.
#include "common.glsl"
#include "decals.glsl"
#include "passes/decals/decals_pass_shared.h"

layout(push_constant, scalar) uniform push_block { gpu_decals_box_push push; };

layout(location = 0) flat out uint out_decal;
layout(location = 1) flat out vec2 out_depths;

void main() {
    uint id = push.ids.at[gl_InstanceIndex];
    decal_array decals = push.set.set.decals;
    mat3 to_cube = transpose(mat3(decals.at[id].rows[0].xyz, decals.at[id].rows[1].xyz, decals.at[id].rows[2].xyz));
    mat3 axes = inverse(to_cube);
    vec3 middle = -(axes * vec3(decals.at[id].rows[0].w, decals.at[id].rows[1].w, decals.at[id].rows[2].w));
    vec3 extent = vec3(length(axes[0]), length(axes[1]), length(axes[2]));
    float volume = dot(axes[0], cross(axes[1], axes[2]));
    if (volume < 0.0) axes[0] = -axes[0]; // windings stay
    view_block v = push.view;
    float reach = 0.5 * (extent.x + extent.y + extent.z);
    float view_depth = -(v.view.world_to_view * vec4(middle, 1.0)).z, farthest = max(view_depth + reach, 0.0);
    // Half the diagonal of a tile at the farthest depth, and a little for rounding; a skewed box needs more along its axes.
    vec2 size = 2.0 * abs(v.view.ndc_scale) * v.view.inverse_size * (v.view.orthographic > 0.5 ? 1.0 : farthest);
    float slack = 0.8 * float(DECAL_TILE) * max(size.x, size.y) + 1e-4 * reach + 1e-6 * length(middle);
    slack /= clamp(abs(volume) / max(extent.x * extent.y * extent.z, 1e-30), 1e-3, 1.0);
    vec3 sides = vec3(uvec3(gl_VertexIndex) >> uvec3(0u, 1u, 2u) & 1u) - 0.5;
    vec3 position = middle;
    for (int i = 0; i < 3; i++) position += axes[i] * (sides[i] * (1.0 + 2.0 * slack / max(extent[i], 1e-12)));
    vec4 clip = v.view.world_to_clip * vec4(position, 1.0);
    // Tiles reach over the picture's right and lower edge.
    vec2 part = vec2(v.view.size) / vec2(push.tiles * DECAL_TILE);
    gl_Position = vec4((clip.x + clip.w) * part.x - clip.w, clip.w - (clip.w - clip.y) * part.y, clip.zw);
    out_decal = id;
    float rounding = 1e-4 * (reach + abs(view_depth)) + 1e-6 * length(middle);
    out_depths = view_depth + vec2(-reach - rounding, reach + rounding);
}
