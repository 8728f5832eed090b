// SPDX-License-Identifier: MIT
// Which keys the pixels of the depth image occupy. Included after the push constants and SAMPLES.
#ifndef SPARSE_PIXELS_GLSL
#define SPARSE_PIXELS_GLSL

// Depths and normals this near to a border occupy both sides, so that rounding cannot lead a surface to a cell that is not there. With
// more samples the shaded point lies somewhere between them, or a little beyond.
const float SPARSE_DEPTH_SLACK = SAMPLES > 1u ? 2e-2 : 1e-4;
const float SPARSE_NORMAL_SLACK = 1e-4;

float sparse_depth(ivec2 pixel, uint s) {
    return SAMPLES > 1u ? texelFetch(textures_multisampled[push.depth], pixel, int(s)).r : texelFetch(textures[push.depth], pixel, 0).r;
}

// The buckets of a pixel, up to four of them.
uint sparse_buckets(ivec2 pixel, out uint found[4]) {
    found[0] = 0u;
    if (push.buckets == 1u) return 1u;
    vec3 n = octahedral_decode(texelFetch(textures[push.normals], pixel, 0).xy * 2.0 - 1.0); // as gbuffer_unpack()
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

#endif
