#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Marks the pages that a changed item touches, where it is or was.
#include "common.glsl"
#include "passes/shadow/fill.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform push_block { gpu_fill_mark_push push; };

bool is_touched(gpu_shadow_page p) {
    if (push.all_changed != 0u) return true;
    uint count = push.changed.at[0];
    if (count == 0u) return false;
    gpu_shape shape = push.shapes.at[p.row];
    if (shape.hull_count != 0u) return false; // it is drawn on request, and pages.h knows when that is
    page_volume volume = page_volume_of(shape, p.bit);
    for (uint i = 1u; i <= count; i++) {
        uint item = push.changed.at[i];
        if (item < push.kept.count && volume_meets_caster(volume, push.kept.at[item])) return true;
        if (item < push.item_count && volume_meets_caster(volume, caster_of(push.rays, item, push.caster_count))) return true;
    }
    return false;
}

void main() {
    uint page = LINEAR_INVOCATION;
    if (page >= min(push.counts.counts.pages, push.page_limit)) return;
    gpu_shadow_page p = push.pages.at[page];
    if ((p.flags & SHADOW_PAGE_DRAW) != 0u || !is_touched(p)) return;
    push.pages.at[page].flags = p.flags | SHADOW_PAGE_DRAW;
    if ((p.flags & SHADOW_PAGE_IDLE) == 0u) atomicAdd(push.counts.counts.drawn, 1u);
}
