#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// cells_fill without the lights that are behind all surfaces of their tile.
#include "common.glsl"
#include "passes/lights/backface.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform push_block { gpu_cells_push push; };

#include "passes/lights/cells_takes.glsl"
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
    bool marking = BACKFACE.marking == 1u;
    uint slot = push.sums.at[cell * push.chunk_count + chunk], slot_end = push.sums.at[cell * push.chunk_count + chunk + 1u];
    if (!marking && (slot == slot_end || !fits)) return;
    gpu_cell_bounds bounds = push.cells.at[cell];
    gpu_cone cone = BACKFACE.cones.at[cell];
    bool culls = cone.sine < 1.0 && (cone.dropped != 0u || marking);
    backface_tile tile;
    if (culls) tile = backface_tile_at(push.view, push.list, bounds, cell, cone.axis, cone.sine);
    uint end = min((chunk + 1u) * push.chunk_size, push.visible_sums.at[push.list.list.local_count]);
    if (cell_is_empty(bounds)) end = 0u; // nothing is kept of it
    const bool kept = (FLAGS & CELLS_KEPT) != 0u;
    uint marks = cells_marks_of(cell);
    for (uint w = chunk * push.chunk_size / 32u; w < cells_end_word(end); w++)
        for (uint bits = kept ? push.marks.at[cells_kept_at(cell, w)] : cells_marked(marks, w, end); bits != 0u; bits &= bits - 1u) {
            uint i = w * 32u + uint(findLSB(bits));
            if (!kept && !cell_takes(bounds, i)) continue;
            uint id = push.visible_ids.at[i];
            bool behind = culls && light_is_behind(tile, light_source_of(push.list, id));
            if (marking) atomicOr(BACKFACE.marks.at[i], behind ? 1u : 2u);
            if (behind && cone.keeps == 0u) continue;
            if (fits) push.ids.at[slot++] = id;
        }
}
