// SPDX-License-Identifier: MIT
// Which keys the pixels of the depth image occupy. Included after the push constants and SAMPLES.
#ifndef SPARSE_PIXELS_GLSL
#define SPARSE_PIXELS_GLSL

#include "gbuffer.glsl"

// Depths and normals this near to a border occupy both sides, so that rounding cannot lead a surface to a cell that is not there. With
// more samples the shaded point lies somewhere between them, or a little beyond.
const float SPARSE_DEPTH_SLACK = SAMPLES > 1u ? 2e-2 : 1e-4;
const float SPARSE_NORMAL_SLACK = 1e-4;

float sparse_depth(ivec2 pixel, uint s) {
    return SAMPLES > 1u ? texelFetch(textures_multisampled[push.gbuffer.depth], pixel, int(s)).r : texelFetch(textures[push.gbuffer.depth], pixel, 0).r;
}

vec3 sparse_normal(ivec2 pixel) { return gbuffer_normal(push.gbuffer, pixel); }

// The buckets of a pixel, up to four of them.
uint sparse_buckets(vec3 n, out uint found[4]) {
    found[0] = 0u;
    if (push.buckets == 1u) return 1u;
    found[0] = normal_bucket(n);
    uint count = 1u;
    for (uint corner = 0u; corner < 8u; corner++) {
        vec3 shift = vec3(uvec3(corner, corner >> 1, corner >> 2) & 1u) * 2.0 - 1.0;
        uint bucket = normal_bucket(n + shift * SPARSE_NORMAL_SLACK);
        bool known = false;
        for (uint i = 0u; i < count; i++) known = known || found[i] == bucket;
        if (!known && count < 4u) found[count++] = bucket;
    }
    return count;
}

// Integers that ascend with floats.
uint ordered(float f) {
    uint bits = floatBitsToUint(f);
    return (bits & 0x80000000u) != 0u ? ~bits : bits | 0x80000000u;
}
float unordered(uint bits) { return uintBitsToFloat((bits & 0x80000000u) != 0u ? bits & 0x7fffffffu : ~bits); }

// Corner 0 .. 3 of the normals of a cell, view space, once they are measured.
vec3 corner_in_view(uint cell, uint bucket, uint corner) {
    uint first = cell * SPARSE_EXTENTS(push.buckets) + 6u;
    vec2 parts;
    for (uint i = 0u; i < 2u; i++) {
        bool high = (corner >> i & 1u) == 1u;
        parts[i] = unordered(push.extents.at[first + i + (high ? 2u : 0u)]) + (high ? SPARSE_NORMAL_SLACK : -SPARSE_NORMAL_SLACK);
    }
    return mat3(push.view.view.world_to_view) * bucket_normal(bucket, parts);
}

#endif
