#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Which pages of the last frame are still good: those that pixels look up, and idle ones of lights that are as they were.
#include "passes/shadow/pages.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform push_block { gpu_shadow_stay_push push; };

void main() {
    uint index = LINEAR_INVOCATION;
    if (index >= push.choice.choice.last) return;
    gpu_shadow_page page = push.last_pages.at[index];
    bool was_idle = (page.flags & SHADOW_PAGE_IDLE) != 0u, is_lost = (page.flags & SHADOW_PAGE_DRAW) != 0u; // nobody drew it
    uint last = page.flags >> SHADOW_YOUTH_SHIFT & 0xffu, youth = was_idle ? last - min(push.frames, last - 1u) : SHADOW_YOUTHS - 1u, flags = 0u;
    uint age = min((page.flags >> SHADOW_AGE_SHIFT) + push.frames, SHADOW_OLDEST) << SHADOW_AGE_SHIFT;
    if (page.row < push.row_count) {
        uint c = shadow_class_of(page.bit), cell = cell_of(push.side, page.place), slot = slot_of(page.place, c);
        bool is_wanted = (push.held.at[page.row * SHADOW_ROW_WORDS + page.bit / 32u] & 1u << page.bit % 32u) != 0u;
        is_lost = is_lost || (push.rows.at[page.row] & SHADOW_ROW_CHANGED) != 0u;
        if (is_wanted) {
            flags = is_lost ? SHADOW_PAGE_DRAW : age;
            atomicOr(push.cells.at[cell].taken[slot / 32u], 1u << slot % 32u);
        } else if (!is_lost) {
            flags = SHADOW_PAGE_IDLE | youth << SHADOW_YOUTH_SHIFT | age;
            atomicOr(push.cells.at[cell].idle[slot / 32u], 1u << slot % 32u);
            atomicMax(push.cells.at[cell].youth, youth);
        }
        if (is_wanted || !is_lost) push.cells.at[cell].size = c + 1u; // the same from all that are in it
    }
    push.last_pages.at[index].flags = flags;
}
