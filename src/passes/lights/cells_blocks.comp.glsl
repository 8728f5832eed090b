#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Bounds of blocks of cells.
#include "common.glsl"
#include "passes/lights/cells.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform push_block { gpu_cells_push push; };

#include "passes/lights/cells_marks.glsl"

uint cell_at(uvec3 at) { return (at.z * push.list.list.tiles_y + at.y) * push.list.list.tiles_x + at.x; }

bool is_number(gpu_cell_bounds b) {
    vec4 sum = vec4(b.low + b.high, 0.0);
    for (int i = 0; i < 4; i++) sum += b.planes[i];
    return !any(isnan(sum));
}

void main() {
    uvec3 blocks = cells_blocks();
    uint index = LINEAR_INVOCATION;
    if (index >= blocks.x * blocks.y * blocks.z) return;
    uvec3 block = uvec3(index % blocks.x, index / blocks.x % blocks.y, index / (blocks.x * blocks.y));
    uvec3 first = block * cells_block_size(), last = min(first + cells_block_size(), cells_grid()) - 1u;
    gpu_cell_block b;
    b.all = 0u;
    b.bounds.low = vec3(1e30, 1e30, 1.0); // of no cells: low.z > high.z
    b.bounds.high = vec3(-1e30, -1e30, -1.0);
    bool used = false;
    for (uint z = first.z; z <= last.z; z++)
        for (uint y = first.y; y <= last.y; y++)
            for (uint x = first.x; x <= last.x; x++) {
                gpu_cell_bounds cell = push.cells.at[cell_at(uvec3(x, y, z))];
                if (!is_number(cell)) b.all = 1u;
                if (cell.low.z > cell.high.z) continue;
                b.bounds.low = used ? min(b.bounds.low, cell.low) : cell.low;
                b.bounds.high = used ? max(b.bounds.high, cell.high) : cell.high;
                used = true;
            }
    // Rows count from the top.
    gpu_cell_bounds low = push.cells.at[cell_at(uvec3(first.x, last.y, first.z))], high = push.cells.at[cell_at(uvec3(last.x, first.yz))];
    b.bounds.planes = vec4[4](low.planes[0], high.planes[1], low.planes[2], high.planes[3]);
    b.inner = vec4[4](high.planes[0], low.planes[1], high.planes[2], low.planes[3]);
    BLOCKS.at[index] = b;
}
