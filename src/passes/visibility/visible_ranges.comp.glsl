#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Finds where each class begins and ends in the list, and sizes the dispatches that shade them. Lists that are not sorted have one class.
#include "common.glsl"
#include "scene.glsl"
#include "view.glsl"
#include "passes/visibility/visible.glsl"

layout(local_size_x = 32) in; // GPU_CLASSES
layout(push_constant, scalar) uniform push_block { gpu_visible_push push; };

// Number of entries with keys below `key`.
uint entries_below(uint key, uint total) {
    uint low = 0u, high = total;
    while (low < high) {
        uint middle = low + (high - low) / 2u;
        if (push.entries.at[middle * 2u] < key)
            low = middle + 1u;
        else
            high = middle;
    }
    return low;
}

void main() {
    uint kind = gl_LocalInvocationIndex, total = push.sums.at[push.places];
    uint first = 0u, end = kind == 0u ? total : 0u;
    if (LISTED == VISIBLE_SORTED) {
        first = entries_below(kind << push.material_bits, total);
        end = kind + 1u == GPU_CLASSES ? total : entries_below((kind + 1u) << push.material_bits, total);
    }
    push.ranges.at[kind * 2u] = first;
    push.ranges.at[kind * 2u + 1u] = end;
    uint groups = (end - first + 63u) / 64u, wide = min(groups, 32768u);
    push.dispatches.at[kind * 3u] = wide;
    push.dispatches.at[kind * 3u + 1u] = wide == 0u ? 0u : (groups + wide - 1u) / wide;
    push.dispatches.at[kind * 3u + 2u] = 1u;
}
