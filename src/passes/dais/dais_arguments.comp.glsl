#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Indirect dispatches over records and shading samples.
#include "passes/dais/dais.glsl"

layout(local_size_x = 1) in;
layout(push_constant, scalar) uniform push_block { gpu_dais_derive_push push; };

void dispatch(uint at, uint count) {
    uint groups = (count + 63u) / 64u, wide = min(groups, 65535u);
    push.counts.at[at] = wide;
    push.counts.at[at + 1u] = wide == 0u ? 0u : (groups + wide - 1u) / wide;
    push.counts.at[at + 2u] = 1u;
}

void main() {
    dispatch(DAIS_DISPATCH, push.counts.at[DAIS_STORED]);
    dispatch(DAIS_SPAWNED, min(push.counts.at[DAIS_SAMPLES] + 1u, push.sample_capacity)); // they are numbered from 1
}
