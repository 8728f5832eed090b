// SPDX-License-Identifier: MIT
// Writes the id of what a pixel shows: what the entry points share.
#include "common.glsl"
#include "view.glsl"
#include "lights/iterate.glsl"
#include "material.glsl"
#include "passes/geometry/geometry_shared.h"

layout(constant_id = FEATURES_ID) const uint FEATURES = 0u; // GPU_FEATURE_…
layout(constant_id = TRIANGLE_BITS_ID) const uint TRIANGLE_BITS = 0u;

layout(constant_id = COUNT_FRAGMENTS_ID) const uint COUNT_FRAGMENTS = 0u; // 1: push.counters holds how often an id was written

layout(push_constant, scalar) uniform push_block { gpu_geometry_push push; };

#ifndef ID_TARGETS
#define ID_TARGETS 0 // render targets before those of ids
#endif
#ifdef ID_BYTES // few devices have several samples of integers
layout(location = ID_TARGETS) out vec4 out_id;
layout(location = ID_TARGETS + 1) out vec4 out_high;
#define ID_STORED(word) unpackUnorm4x8(word)
#else
layout(location = ID_TARGETS) out uint out_id;
layout(location = ID_TARGETS + 1) out uint out_high;
#define ID_STORED(word) (word)
#endif

#include "passes/geometry/triangle_number.glsl"

void write_id() {
    uint item = in_ids.y + 1u;
    if (COUNT_FRAGMENTS == 1u) atomicAdd(push.counters.at[0], 1u);
    out_id = ID_STORED(item << TRIANGLE_BITS | triangle_number());
    out_high = ID_STORED(TRIANGLE_BITS == 0u ? 0u : item >> (32u - TRIANGLE_BITS));
}
