#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
// Maps or rays, for each local light: split.h.
#include "passes/shadow/pages.glsl"
#include "passes/shadow/split.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform push_block { gpu_shadow_split_push push; };

// Pages that pixels ask for; bits that are of no page are left out.
uint pages_asked(uint row) {
    uint count = 0u;
    [[dont_unroll]] for (uint i = 0u; i < SHADOW_ROW_WORDS; i++) { // unrolled, it takes all registers
        uint bits = push.wanted.at[row * SHADOW_ROW_WORDS + i];
        count += bitCount(i % SHADOW_FACE_WORDS == 10u ? bits & 0xffffffu : bits);
    }
    return count;
}

// Takes the next step of a light whose maps would take so many pages, and whose rays cost so much; true: it switches, or is decided for the first time.
bool decide(inout gpu_shadow_split_row kept, uint pages, float rays, bool is_changed) {
    float all = float(pages) * push.page_rays;
    bool is_traced = (kept.flags & SPLIT_TRACED) != 0u;
    if ((kept.flags & SPLIT_KNOWN) == 0u) {
        kept.flags = SPLIT_KNOWN | (rays < all ? SPLIT_TRACED : 0u) | SPLIT_OLD << SPLIT_AGE_SHIFT;
        kept.regret = 0.0;
        return false;
    }
    uint age = min((kept.flags >> SPLIT_AGE_SHIFT) + 1u, SPLIT_OLD), patience = kept.flags >> SPLIT_PATIENCE_SHIFT & 15u;
    float maps = is_traced ? (is_changed ? all : 0.0) : float(kept.drawn) * push.page_rays;
    kept.regret = max(kept.regret + (is_traced ? rays - maps : maps - rays), 0.0);
    bool switches = kept.regret > all * float(1u << patience);
    if (switches) {
        is_traced = !is_traced;
        patience = age < SPLIT_OLD ? min(patience + 1u, SPLIT_MOST_PATIENCE) : patience - min(patience, 1u);
        age = 0u;
        kept.regret = 0.0;
    }
    kept.flags = SPLIT_KNOWN | (is_traced ? SPLIT_TRACED : 0u) | patience << SPLIT_PATIENCE_SHIFT | age << SPLIT_AGE_SHIFT;
    return switches;
}

void main() {
    uint row = LINEAR_INVOCATION;
    if (row >= push.row_count) return;
    push.traced.at[row] = 0u;
    if (row < push.sun_rows) return;
    gpu_shadow_split_row kept = gpu_shadow_split_row(0.0, 0u, 0u);
    if (row < push.known_rows) kept = push.kept.at[row];
    uint pages = pages_asked(row);
    if (pages > 0u) {
        uint pixels = push.wanted.at[push.row_count * SHADOW_ROW_WORDS + row];
        if (decide(kept, pages, float(pixels), (push.rows.at[row] & SHADOW_ROW_CHANGED) != 0u)) atomicAdd(push.counts.counts.switched, 1u);
        bool is_traced = (kept.flags & SPLIT_TRACED) != 0u;
        if (!is_traced) {
            atomicAdd(push.counts.counts.maps, 1u);
        } else {
            atomicAdd(push.counts.counts.rays, 1u);
            atomicAdd(push.counts.counts.reached, pixels);
            [[dont_unroll]] for (uint i = 0u; i < SHADOW_ROW_WORDS; i++) push.wanted.at[row * SHADOW_ROW_WORDS + i] = 0u;
        }
    }
    push.traced.at[row] = (kept.flags & SPLIT_TRACED) != 0u ? 1u : 0u; // also where nothing is asked for
    kept.drawn = 0u;
    push.kept.at[row] = kept;
}
