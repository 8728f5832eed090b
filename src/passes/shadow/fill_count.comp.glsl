#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// The items that each page shows. First they are counted; then, LIST, they are listed for the pages for which there is room,
// and these pages are marked as drawn.
#include "common.glsl"
#include "passes/shadow/fill.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform push_block { gpu_fill_push push; };

uint walk(uint page, uint at) {
    gpu_shadow_page p = push.pages.at[page];
    page_volume volume = page_volume_of(push.shapes.at[p.row], p.bit);
    gpu_ray_tree tree = push.rays.rays.items;
    uint count = 0u;
    for (uint reference = tree.root; reference != RAY_END;) {
        uint last = reference & ~RAY_LEAF;
        if ((reference & RAY_LEAF) == 0u) {
            gpu_ray_node node = tree.nodes.at[reference];
            if (volume_meets_node(volume, node)) {
                reference = node.first;
                continue;
            }
            last = node.last;
        } else {
            uint item = tree.ids.at[last];
            if (volume_meets_caster(volume, caster_of(push.rays, item, push.caster_count))) {
#ifdef LIST
                push.entries.at[at + count] = gpu_fill_entry(item, atomicAdd(push.item_sums.at[item], 1u));
#endif
                count++;
            }
        }
        reference = tree.next.at[last];
    }
    return count;
}

void main() {
    uint page = LINEAR_INVOCATION;
    if (page > push.page_limit) return;
    bool wants = page < min(push.counts.counts.pages, push.page_limit) && (push.pages.at[page].flags & (SHADOW_PAGE_DRAW | SHADOW_PAGE_IDLE)) == SHADOW_PAGE_DRAW;
#ifdef LIST
    if (page == push.page_limit) {
        push.counts.counts.pairs = push.sums.at[page];
        push.totals.totals.clear.index_count = 6u;
        push.totals.totals.groups[1] = push.totals.totals.groups[2] = 1u;
    }
    uint first = push.sums.at[page];
    if (!wants || push.sums.at[page + 1u] > push.pair_capacity) return;
    walk(page, first);
    push.drawn.at[atomicAdd(push.totals.totals.clear.instance_count, 1u)] = page;
    atomicAdd(push.totals.totals.groups[0], 1u);
    push.pages.at[page].flags &= ~(SHADOW_PAGE_DRAW | SHADOW_OLDEST << SHADOW_AGE_SHIFT);
#else
    push.sums.at[page] = wants ? walk(page, 0u) : 0u;
#endif
}
