#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Marks the lights that touch a block of cells: one thread takes one block and one chunk of the lights in view.
#include "common.glsl"
#include "passes/lights/cells.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform push_block { gpu_cells_push push; };

#include "passes/lights/cells_marks.glsl"
#include "passes/lights/cells_takes.glsl"

// Whether a light may touch a cell of the block: true for all that cell_takes() keeps. Of the planes that turn from one edge of the block to the
// other, each leaves a light no farther outside than the farther of the first and the last one does.
bool block_touches(gpu_cell_block block, uint i) {
    gpu_bound light = push.bounds.at[i];
    gpu_cell_bounds b = block.bounds;
    if (block.all == 1u) return true;
    if ((FLAGS & CELLS_RECTANGLE) != 0u) return cell_touches_rectangle(b, light, push.reaches.at[i]);
    float radius = cell_radius(light) * (1.0 + CELL_SLACK) + CELL_SLACK * 1e-2 * length(light.center); // rounding, again
    bool outside = b.low.z > b.high.z;
    for (int k = 0; k < 4; k++)
        outside = outside || dot(b.planes[k].xyz, light.center) + b.planes[k].w < -radius &&
                                 dot(block.inner[k].xyz, light.center) + block.inner[k].w < -radius;
    if ((FLAGS & CELLS_PLANES) != 0u)
        return !(outside || light.center.z - radius > b.high.z || light.center.z + radius < b.low.z);
    vec3 away = max(max(b.low - light.center, light.center - b.high), vec3(0.0));
    return !(outside || dot(away, away) > radius * radius);
}

void main() {
    uint index = push.first_cell + gl_GlobalInvocationID.x, chunk = push.first_chunk + gl_WorkGroupID.y;
    uvec3 blocks = cells_blocks();
    if (index >= blocks.x * blocks.y * blocks.z) return;
    gpu_cell_block block = BLOCKS.at[index];
    bool empty = block.all == 0u && cell_is_empty(block.bounds);
    uint end = min((chunk + 1u) * push.chunk_size, push.visible_sums.at[push.list.list.local_count]);
    for (uint w = chunk * push.chunk_size / 32u; w < cells_end_word(end); w++) {
        uint bits = 0u;
        for (uint i = w * 32u; i < (empty ? 0u : min(w * 32u + 32u, end)); i++)
            if (block_touches(block, i)) bits |= 1u << (i & 31u);
        push.marks.at[index * cells_mark_words() + w] = bits;
    }
}
