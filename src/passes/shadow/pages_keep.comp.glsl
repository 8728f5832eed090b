#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Adds the idle pages that stay to those that are held.
#include "passes/shadow/pages.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform push_block { gpu_shadow_stay_push push; };

void main() {
    uint index = LINEAR_INVOCATION;
    gpu_shadow_choice choice = push.choice.choice;
    if (index >= choice.last) return;
    gpu_shadow_page page = push.last_pages.at[index];
    if ((page.flags & SHADOW_PAGE_IDLE) == 0u || shadow_youth(push.cells.at[cell_of(push.side, page.place)]) < choice.youth) return;
    atomicOr(push.held.at[page.row * SHADOW_ROW_WORDS + page.bit / 32u], 1u << page.bit % 32u);
    atomicAdd(push.sums.at[page.row * SHADOW_FACES + page.bit / (SHADOW_FACE_WORDS * 32u)], 1u);
}
