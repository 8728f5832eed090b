#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// What each page shows: items, or the clusters of these that it shows. First they are counted; then, LIST, they are listed for the pages for
// which there is room, and these pages are marked as drawn.
#include "common.glsl"
#include "passes/shadow/fill.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform push_block { gpu_fill_push push; };

#ifdef LIST
void list(uint at, uint item, uint unit) { push.entries.at[at] = gpu_fill_entry(item, unit, atomicAdd(push.unit_sums.at[unit], 1u)); }
#endif

// Of an item that the page shows as a whole or in part: how many units. Clusters are worth it where half of them are elsewhere, since each takes a pair;
// and as long as one pair for each item after this one would still fit, so that there is room for the pairs of any one page. `shown`: units before,
// `first`: where they go.
uint show(page_volume volume, uint item, uint shown, uint first) {
    scene_block s = push.rays.rays.scene;
    uint group = group_of(s, push.group_count, item, false), unit = s.scene.groups.at[group].first_unit;
    gpu_primitive primitive = s.scene.primitives.at[s.scene.groups.at[group].primitive];
    gpu_instance instance = s.scene.instances.at[s.scene.items.at[item].instance];
    uint clusters = units_of(s, push.group_count, push.unit_count, group) - 1u, count = 0u;
    if (clusters != primitive.cluster_count) clusters = 0u;
    float scale = clusters > 0u ? stretch(instance) : 0.0;
    for (uint k = 0u; k < clusters && 2u * count <= clusters; k++) {
        gpu_cluster cluster = s.scene.clusters.at[primitive.first_cluster + k];
        if (volume_meets_sphere(volume, transform_point(instance, cluster.center) - volume.origin, cluster.radius * scale)) count++;
    }
    bool whole = clusters == 0u || 2u * count > clusters || shown + count + push.caster_count > push.pair_capacity;
#ifdef LIST
    uint at = first + shown;
    if (whole) list(at, item, unit);
    for (uint k = 0u; k < clusters && !whole; k++) {
        gpu_cluster cluster = s.scene.clusters.at[primitive.first_cluster + k];
        if (volume_meets_sphere(volume, transform_point(instance, cluster.center) - volume.origin, cluster.radius * scale))
            list(at++, item, unit + 1u + k);
    }
#endif
    return whole ? 1u : count;
}

uint walk(uint page, uint first) {
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
            if (volume_meets_caster(volume, caster_of(push.rays, item, push.caster_count))) count += show(volume, item, count, first);
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
