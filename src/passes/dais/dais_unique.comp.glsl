#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Counts the different triangles among the records: each looks for its own kind in a table.
#include "passes/dais/dais.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform push_block { gpu_dais_derive_push push; };

void main() {
    uint index = LINEAR_INVOCATION;
    bool searches = index < push.counts.at[DAIS_STORED];
    uint reference = searches ? push.stored.at[index] : 1u;
    uint item = push.pool.at[reference - 1u], number = push.pool.at[reference];
    uint slot = (item * 0x9e3779b1u ^ number * 0x85ebca6bu) * 0xc2b2ae35u;
    // The table has twice as many places as there can be records.
    for (uint i = 0u; i < push.table_size && searches; i++) {
        uint at = slot + i & push.table_size - 1u;
        uint old = atomicCompSwap(push.table.at[at], 0u, reference);
        if (old == 0u) {
            atomicAdd(push.counts.at[DAIS_UNIQUE], 1u);
            searches = false;
        } else if (push.pool.at[old - 1u] == item && push.pool.at[old] == number) {
            searches = false;
        }
    }
}
