#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Writes the lights of each cell, ascending. A cell that the pool cannot hold is marked to use all lights instead.
#include "common.glsl"
#include "passes/lights/cells.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform push_block { gpu_cells_push push; };

#include "passes/lights/cells_entry.glsl"
#include "passes/lights/cells_marks.glsl"

void main() {
    uint cell = push.first_cell + gl_GlobalInvocationID.x, chunk = push.first_chunk + gl_WorkGroupID.y;
    if (cell >= push.cell_count) return;
    uint first = push.sums.at[cell * push.chunk_count], last = push.sums.at[(cell + 1u) * push.chunk_count];
    bool fits = last <= push.capacity;
    if (chunk == 0u) {
        push.list.list.cells.at[cell].offset = first;
        push.list.list.cells.at[cell].count = fits ? last - first : GPU_CELL_ALL;
        if (!fits) atomicAdd(push.overflow.at[0], 1u);
    }
    if (!fits) return;
    uint slot = push.sums.at[cell * push.chunk_count + chunk], slot_end = push.sums.at[cell * push.chunk_count + chunk + 1u];
    if (slot == slot_end) return;
    gpu_cell_bounds bounds = push.cells.at[cell];
    uint end = min((chunk + 1u) * push.chunk_size, push.visible_sums.at[push.list.list.local_count]);
    const bool kept = (FLAGS & CELLS_KEPT) != 0u;
    uint range, marks = cells_marks_of(cell);
    for (uint w = chunk * push.chunk_size / 32u; w < cells_end_word(end); w++)
        for (uint bits = kept ? push.marks.at[cells_kept_at(cell, w)] : cells_marked(marks, w, end); bits != 0u; bits &= bits - 1u) {
            uint i = w * 32u + uint(findLSB(bits));
            bool takes = kept;
            if (!kept || (FLAGS & CELLS_RANGES) != 0u) takes = cell_takes_entry(bounds, cell, i, range);
            if (!takes) continue;
            if ((FLAGS & CELLS_RANGES) != 0u) push.extra.at[slot] = range;
            push.ids.at[slot++] = push.visible_ids.at[i];
        }
}
