#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Counts the lights that touch a cell: one thread takes one cell and one chunk of the lights in view.
#include "common.glsl"
#include "passes/lights/cells.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform push_block { gpu_cells_push push; };

#include "passes/lights/cells_entry.glsl"
#include "passes/lights/cells_marks.glsl"

void main() {
    uint cell = push.first_cell + gl_GlobalInvocationID.x, chunk = push.first_chunk + gl_WorkGroupID.y;
    if (cell > push.cell_count || (cell == push.cell_count && chunk > 0u)) return;
    if (cell == push.cell_count) {
        push.sums.at[cell * push.chunk_count] = 0u; // becomes the total
        push.overflow.at[0] = 0u;
        return;
    }
    gpu_cell_bounds bounds = push.cells.at[cell];
    uint end = min((chunk + 1u) * push.chunk_size, push.visible_sums.at[push.list.list.local_count]);
    if (cell_is_empty(bounds)) end = 0u; // the fill asks for nothing that is kept of it
    uint count = 0u, range, marks = cells_marks_of(cell);
    for (uint w = chunk * push.chunk_size / 32u; w < cells_end_word(end); w++) {
        uint taken = 0u;
        for (uint bits = cells_marked(marks, w, end); bits != 0u; bits &= bits - 1u)
            if (cell_takes_entry(bounds, cell, w * 32u + uint(findLSB(bits)), range)) taken |= bits & ~(bits - 1u);
        count += uint(bitCount(taken));
        if ((FLAGS & CELLS_KEPT) != 0u) push.ids.at[cells_kept_at(cell, w)] = taken;
    }
    push.sums.at[cell * push.chunk_count + chunk] = count;
}
