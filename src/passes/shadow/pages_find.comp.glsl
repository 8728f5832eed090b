#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Pages that were there in the last frame stay where they are. Counts the others, and all, by class.
#include "passes/shadow/pages_places.glsl"

layout(local_size_x = SHADOW_BLOCK) in;
layout(push_constant, scalar) uniform push_block { gpu_shadow_find_push push; };

shared uint counts[2u * SHADOW_CLASSES], stay;

// Where the page is among those of the last frame, or SHADOW_NO_PLACE.
uint index_before(gpu_shadow_page page) {
    if (page.row >= push.row_count) return SHADOW_NO_PLACE;
    uint word = page.row * SHADOW_ROW_WORDS + page.bit / 32u, bits = push.held.at[word], bit = 1u << page.bit % 32u;
    return (bits & bit) != 0u ? push.before.at[word] + bitCount(bits & bit - 1u) : SHADOW_NO_PLACE;
}

void main() {
    if (LINEAR_GROUP >= push.places.block_count) return;
    uint index = LINEAR_INVOCATION, thread = gl_LocalInvocationIndex, total = push.places.total.at[0];
    if (LINEAR_GROUP * SHADOW_BLOCK >= total) { // the whole group has nothing to do
        if (thread < 2u * SHADOW_CLASSES) push.places.sums.at[thread * push.places.block_count + LINEAR_GROUP] = 0u;
        return;
    }
    if (thread < 2u * SHADOW_CLASSES) counts[thread] = 0u;
    if (thread == 0u) stay = 0u;
    barrier();
    if (index < total) {
        gpu_shadow_page page = push.places.pages.at[index];
        uint c = shadow_class_of(page.bit), last = index_before(page);
        atomicAdd(counts[SHADOW_CLASSES + c], 1u);
        if (last == SHADOW_NO_PLACE) {
            atomicAdd(counts[c], 1u);
        } else {
            atomicAdd(stay, 1u);
            push.places.pages.at[index].place = push.pages.at[last].place;
            push.places.pages.at[index].flags = push.pages.at[last].flags;
        }
    }
    barrier();
    if (thread < SHADOW_CLASSES) {
        push.places.sums.at[first_new(push.places, thread) + LINEAR_GROUP] = counts[thread];
        push.places.sums.at[first_page(push.places, thread) + LINEAR_GROUP] = counts[SHADOW_CLASSES + thread];
    }
    if (thread == 0u && stay > 0u) atomicAdd(push.places.counts.counts.evicted, 0u - stay);
}
