#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Bounds of the tiles: the frustum of the tile between the nearest and the farthest pixel (ES-43), or as far as the flags say.
#include "common.glsl"
#include "passes/lights/cells.glsl"

layout(constant_id = 1) const uint SAMPLES = 1u;

layout(push_constant, scalar) uniform push_block { gpu_cells_push push; };

#include "passes/lights/tile_depth.glsl"

void main() {
    float near, far;
    bool used = tile_depths(near, far);
    if (gl_LocalInvocationIndex == 0u) push.cells.at[tile_index()] = tile_piece(near, far, used);
}
