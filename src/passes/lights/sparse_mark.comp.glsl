#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Marks the keys that pixels occupy; then measures what each cell holds of them, and how far they face.
#include "common.glsl"
#include "passes/lights/bvh.glsl"
#include "passes/lights/sparse_shared.h"

layout(constant_id = 1) const uint SAMPLES = 1u;
layout(constant_id = 2) const uint STEP = SPARSE_MARK;

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform push_block { gpu_sparse_push push; };

#include "passes/lights/sparse.glsl"

// Most pixels widen nothing: what is read may be old, which only costs an operation.
void lower(uint at, float value) {
    if (ordered(value) < push.extents.at[at]) atomicMin(push.extents.at[at], ordered(value));
}
void raise(uint at, float value) {
    if (ordered(value) > push.extents.at[at]) atomicMax(push.extents.at[at], ordered(value));
}

void measure(uint cell, uint bucket, vec3 position, vec3 normal) {
    uint first = cell * SPARSE_EXTENTS(push.buckets);
    if (STEP == SPARSE_FACE) {
        for (uint corner = 0u; corner < 4u; corner++) lower(first + 10u + corner, dot(corner_in_view(cell, bucket, corner), position));
        return;
    }
    for (uint axis = 0u; axis < 3u; axis++) {
        lower(first + axis, position[axis]);
        raise(first + 3u + axis, position[axis]);
    }
    if (push.buckets == 1u) return;
    vec2 parts = bucket_parts(bucket, normal);
    for (uint i = 0u; i < 2u; i++) {
        lower(first + 6u + i, parts[i]);
        raise(first + 8u + i, parts[i]);
    }
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(uvec2(pixel), push.view.view.size))) return;
    uvec2 tile = tile_of(push.list, uvec2(pixel));
    vec3 normal = push.buckets > 1u ? sparse_normal(pixel) : vec3(0.0);
    uint buckets[4], bucket_count = sparse_buckets(normal, buckets);
    for (uint s = 0u; s < SAMPLES; s++) {
        float depth = sparse_depth(pixel, s);
        if (depth <= 0.0) continue; // sky
        float view_depth = view_depth_of(push.view, depth);
        uint last = slice_of(push.list, view_depth * (1.0 + SPARSE_DEPTH_SLACK));
        for (uint slice = slice_of(push.list, view_depth * (1.0 - SPARSE_DEPTH_SLACK)); slice <= last; slice++)
            for (uint b = 0u; b < bucket_count; b++) {
                uint key = sparse_key(push.list, tile, slice, buckets[b]);
                if (STEP == SPARSE_MARK)
                    push.table.at[key] = 1u;
                else if (push.table.at[key] < push.cell_limit)
                    measure(push.table.at[key], buckets[b],
                            view_position_of(push.view, ndc_of_pixel(push.view, vec2(pixel) + 0.5), view_depth), normal);
            }
    }
}
