#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Deals the visible items out to keys: the lights that touch them (a draw per light and group), or the class of their number of lights.
// Where the items of a key lie among each other does not matter: a pixel shows one item, and every light adds to it once.
#include "common.glsl"
#include "scene.glsl"
#include "view.glsl"
#include "lights/iterate.glsl"
#include "passes/shade/regroup_shared.h"

layout(local_size_x = 64) in;
layout(constant_id = 1) const uint STEP = REGROUP_COUNT;
layout(constant_id = 2) const uint BY_CLASS = 0u;
layout(push_constant, scalar) uniform push_block { gpu_regroup_push push; };

uint class_of(uint count) {
    if (count <= 2u) return count;
    return count <= 4u ? 3u : count <= 8u ? 4u : count <= 16u ? 5u : 6u; // also those that use all lights
}

uint group_of(uint item) {
    uint low = 0u, high = push.group_count - 1u; // the last group that begins at or before the item
    while (low < high) {
        uint middle = (low + high + 1u) / 2u;
        if (push.scene.scene.groups.at[middle].first_item <= item)
            low = middle;
        else
            high = middle - 1u;
    }
    return low;
}

void take(uint key, uint group, uint item) {
    uint at = key * push.group_count + group;
    if (STEP == REGROUP_COUNT) {
        atomicAdd(push.counts.at[at], 1u);
    } else if (push.counts.at[at + 1u] <= push.capacity) {
        push.items.at[push.item_count + push.counts.at[at] + atomicAdd(push.cursors.at[at], 1u)] = item;
    }
}

void deal_item(uint item) {
    if (push.culled.at[item + 1u] == push.culled.at[item]) return;
    if (STEP == REGROUP_FILL) push.items.at[push.culled.at[item]] = item;
    gpu_cell cell = push.list.list.cells.at[item];
    uint group = group_of(item);
    if (BY_CLASS == 1u) {
        take(class_of(cell.count), group, item);
    } else if (cell.count == GPU_CELL_ALL) {
        for (uint i = 0u; i < push.key_count; i++) take(i, group, item);
    } else {
        for (uint i = 0u; i < cell.count; i++) take(push.list.list.ids.at[cell.offset + i], group, item);
    }
}

void main() {
    uint index = LINEAR_INVOCATION;
    if (STEP != REGROUP_DRAWS) {
        if (index < push.item_count) deal_item(index);
        return;
    }
    if (index >= push.key_count * push.group_count) return;
    gpu_group group = push.scene.scene.groups.at[index % push.group_count];
    gpu_primitive primitive = push.scene.scene.primitives.at[group.primitive];
    uint first = push.counts.at[index], end = push.counts.at[index + 1u];
    gpu_draw draw;
    draw.index_count = primitive.index_count;
    draw.instance_count = end - first;
    draw.first_index = primitive.first_index;
    draw.vertex_offset = primitive.vertex_offset;
    draw.first_instance = push.item_count + first;
    if (end > push.capacity && end != first) { // there was no place: all of the group that is in view
        draw.first_instance = push.culled.at[group.first_item];
        draw.instance_count = push.culled.at[group.first_item + group.item_count] - draw.first_instance;
    }
    push.draws.at[index] = draw;
}
