#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Gives each occupied key its cell.
#include "common.glsl"
#include "passes/lights/bvh.glsl"
#include "passes/lights/sparse_shared.h"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform push_block { gpu_sparse_push push; };

void main() {
    uint key = LINEAR_INVOCATION;
    if (key >= push.key_count) return;
    uint cell = push.table.at[key];
    if (push.table.at[key + 1u] == cell || cell >= push.cell_limit) return;
    push.keys.at[cell] = key;
    uint count = SPARSE_EXTENTS(push.buckets);
    for (uint i = 0u; i < count; i++) push.extents.at[cell * count + i] = (i >= 3u && i < 6u) || i == 8u || i == 9u ? 0u : 0xffffffffu;
}
