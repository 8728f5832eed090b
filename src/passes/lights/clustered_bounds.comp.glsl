#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Bounds of the clusters: tiles times slices of view depth (ES-50).
#include "common.glsl"
#include "passes/lights/cells.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform push_block { gpu_cells_push push; };

void main() {
    uint cell = LINEAR_INVOCATION;
    if (cell >= push.cell_count) return;
    push.cells.at[cell] = cluster_bounds(push.view, push.list, cell);
}
