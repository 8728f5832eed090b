#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Counts or writes the lights of a cell: one thread takes one cell and some words of its group's mask of leaves.
#include "common.glsl"
#include "passes/lights/bvh.glsl"

layout(constant_id = 1) const uint FILL = 0u;

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform push_block { gpu_bvh_query_push push; };

// Whether some surface of a cell may face the light (ES-56); what is not a light is for all surfaces. `i`: index among what is in view.
bool cell_faces(uint cell, uint i) {
    uint place = push.visible_ids.at[i];
    if (push.list.list.lights.set.entities.at[place].kind != GPU_ENTITY_LIGHT) return true;
    uint light = push.list.list.directional_count + push.list.list.lights.set.entities.at[place].user;
    uint kind = push.list.list.lights.set.lights.at[light].shape.kind;
    gpu_reach r = push.reaches.at[i];
    if (kind == GPU_SHAPE_BOX) { // the same direction everywhere
        for (int k = 0; k < 4; k++)
            if (!(-dot(push.facings.at[cell].planes[k].xyz, r.axis) < -CELL_SLACK)) return true;
        return false;
    }
    if (shape_is_area(kind)) return true;
    float slack = r.slack + 3.0 * CELL_SLACK * push.list.list.lights.set.lights.at[light].shape.range;
    if (kind == GPU_SHAPE_CAPSULE) slack += push.list.list.lights.set.lights.at[light].shape.size.x; // the nearest point of its segment shines
    for (int k = 0; k < 4; k++) {
        vec4 plane = push.facings.at[cell].planes[k];
        if (!(dot(plane.xyz, r.apex) + plane.w < -slack)) return true;
    }
    return false;
}

void main() {
    gpu_bvh_query q = push.query.query;
    // Cells first: threads that run together ask the same leaves.
    uint cell = LINEAR_INVOCATION % (q.cell_count + 1u), chunk = LINEAR_INVOCATION / (q.cell_count + 1u);
    if (chunk >= q.chunk_count) return;
    if (cell > q.cell_count || (cell == q.cell_count && chunk > 0u)) return;
    uint cell_count = q.rule.run > 0u ? min(push.cell_counter.at[0], q.cell_count) : q.cell_count, slot = 0u, slot_end = 0u;
    if (FILL == 0u) {
        if (cell == q.cell_count) push.overflow.at[0] = 0u;
        if (cell >= cell_count) { // also the one more, which becomes the total
            push.sums.at[cell * q.chunk_count + chunk] = 0u;
            return;
        }
    } else {
        if (cell >= cell_count) return;
        uint first = push.sums.at[cell * q.chunk_count], last = push.sums.at[(cell + 1u) * q.chunk_count];
        bool fits = last <= q.capacity;
        if (chunk == 0u) {
            push.list.list.cells.at[cell].offset = first;
            push.list.list.cells.at[cell].count = fits ? last - first : GPU_CELL_ALL;
            if (!fits) atomicAdd(push.overflow.at[0], 1u);
        }
        if (!fits) return;
        slot = push.sums.at[cell * q.chunk_count + chunk];
        slot_end = push.sums.at[cell * q.chunk_count + chunk + 1u];
        if (slot == slot_end) return;
    }
    gpu_cell_bounds bounds = push.cells.at[cell];
    uint group = group_of(push.list, cell, q.rule), light_count = push.count.at[0], count = 0u;
    uint end = min((chunk + 1u) * q.chunk_words, q.words);
    for (uint word = chunk * q.chunk_words; word < end; word++) {
        for (uint mask = push.masks.at[group * q.words + word]; mask != 0u; mask &= mask - 1u) {
            uint leaf = word * 32u + uint(findLSB(mask));
            if (!cell_touches_box(bounds, push.boxes.at[leaf])) continue;
            uint last = min((leaf + 1u) * BVH_WIDTH, light_count);
            for (uint k = leaf * BVH_WIDTH; k < last; k++) {
                if (!cell_touches(bounds, push.spheres.at[k])) continue;
                if (q.flags != 0u || FILL == 1u) {
                    uint i = push.pairs.at[k * 2u + 1u];
                    if ((q.flags & CELLS_CONES) != 0u && !cell_touches_cone(bounds, push.reaches.at[i])) continue;
                    if ((q.flags & BVH_FACINGS) != 0u && !cell_faces(cell, i)) continue;
                    if (FILL == 1u && slot < slot_end) push.ids.at[slot++] = push.visible_ids.at[i];
                }
                count++;
            }
        }
    }
    if (FILL == 0u) push.sums.at[cell * q.chunk_count + chunk] = count;
}
