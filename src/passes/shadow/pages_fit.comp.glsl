#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Which idle pages stay: the more the better, as long as the new pages fit beside them. One work group.
#include "passes/shadow/pages.glsl"

layout(local_size_x = SHADOW_YOUTHS) in;
layout(push_constant, scalar) uniform push_block { gpu_shadow_room_push push; };

shared uint best;

void main() {
    uint least = gl_LocalInvocationIndex + 1u; // cells of at least this youth stay as they are
    if (least == 1u) best = SHADOW_YOUTHS + 1u;
    barrier();
    uint cells = 0u, needed = 0u;
    for (uint youth = 0u; youth < least; youth++) cells += push.rooms.at[youth * SHADOW_ROOM_WORDS + SHADOW_CLASSES];
    for (uint c = 0u; c < SHADOW_CLASSES; c++) {
        uint fresh = push.rooms.at[SHADOW_ROOMS + c], places = 0u;
        for (uint youth = least; youth <= SHADOW_YOUTHS; youth++) places += push.rooms.at[youth * SHADOW_ROOM_WORDS + c];
        needed += (fresh - min(fresh, places) + places_of_cell(c) - 1u) >> 2u * c;
    }
    if (needed <= cells) atomicMin(best, least);
    barrier();
    if (least == 1u) push.choice.choice.youth = best;
}
