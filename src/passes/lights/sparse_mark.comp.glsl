#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Marks the keys that pixels occupy, then measures what each cell holds of them.
#include "common.glsl"
#include "passes/lights/bvh.glsl"
#include "passes/lights/sparse_shared.h"

layout(constant_id = 1) const uint SAMPLES = 1u;
layout(constant_id = 2) const uint MEASURE = 0u;

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform push_block { gpu_sparse_push push; };

#include "passes/lights/sparse.glsl"

void measure(uint cell, vec3 position) {
    for (uint axis = 0u; axis < 3u; axis++) {
        uint value = ordered(position[axis]);
        // Most pixels widen nothing: what is read may be old, which only costs an operation.
        if (value < push.extents.at[cell * 6u + axis]) atomicMin(push.extents.at[cell * 6u + axis], value);
        if (value > push.extents.at[cell * 6u + 3u + axis]) atomicMax(push.extents.at[cell * 6u + 3u + axis], value);
    }
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(uvec2(pixel), push.view.view.size))) return;
    uvec2 tile = tile_of(push.list, uvec2(pixel));
    uint buckets[4], bucket_count = sparse_buckets(pixel, buckets);
    for (uint s = 0u; s < SAMPLES; s++) {
        float depth = sparse_depth(pixel, s);
        if (depth <= 0.0) continue; // sky
        float view_depth = view_depth_of(push.view, depth);
        uint last = slice_of(push.list, view_depth * (1.0 + SPARSE_DEPTH_SLACK));
        for (uint slice = slice_of(push.list, view_depth * (1.0 - SPARSE_DEPTH_SLACK)); slice <= last; slice++)
            for (uint b = 0u; b < bucket_count; b++) {
                uint key = sparse_key(push.list, tile, slice, buckets[b]);
                if (MEASURE == 0u)
                    push.table.at[key] = 1u;
                else if (push.table.at[key] < push.cell_limit)
                    measure(push.table.at[key], view_position_of(push.view, ndc_of_pixel(push.view, vec2(pixel) + 0.5), view_depth));
            }
    }
}
