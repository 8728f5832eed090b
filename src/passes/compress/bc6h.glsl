// SPDX-License-Identifier: MIT
// A block of BC6H from 4 x 4 texels (Narkowicz, "Real-Time BC6H Compression on GPU", GPU Pro 7, V.2). src/image/bc6h_encode.c has the same on
// the CPU: each operation on floats stands there as it stands here.
#ifndef BC6H_GLSL
#define BC6H_GLSL

#include "common.glsl"
#include "passes/compress/bc6h_shared.h"

layout(constant_id = 0) const bool SIGNED = false;
layout(push_constant, scalar) uniform push_block { gpu_bc6h_push push; };

const float INDEX4_SCALE = 14.9333333, INDEX4_OFFSET = 0.533337333, INDEX3_SCALE = 6.98182, INDEX3_OFFSET = 0.509094;

float dot3(vec3 a, vec3 b) {
    precise float sum = (a.x * b.x + a.y * b.y) + a.z * b.z;
    return sum;
}

// NaN: 0.
float held(float v) { return v > (SIGNED ? -HALF_MAX : 0.0) ? min(v, HALF_MAX) : SIGNED && v < 0.0 ? -HALF_MAX : 0.0; }

// The bits of the half next to a value, with a sign. packHalf2x16() may round as it likes.
int code_of(float v) {
    float positive = min(abs(v), HALF_MAX);
    uint bits = floatBitsToUint(positive);
    precise float shifted = positive + 0.5;
    uint code = bits < 0x38800000u ? floatBitsToUint(shifted) - 0x3f000000u : (bits - 0x38000000u + 0xfffu + (bits >> 13 & 1u)) >> 13;
    return SIGNED && v < 0.0 ? -int(code) : int(code);
}

ivec3 quantise(ivec3 code, uint bits) {
    uvec3 m = uvec3(abs(code));
    if (SIGNED) return ivec3(bits >= 16u ? (m * 32u + 30u) / 31u : (m << (bits - 1u) >> 10) / 31u) * sign(code);
    return ivec3(bits >= 16u ? (m * 64u + 30u) / 31u : (m << bits >> 10) / 31u);
}

#ifdef QUALITY
#include "passes/compress/bc6h_quality.glsl"
#endif

void fetch(uvec2 at, out vec3 texels[16]) {
    vec2 size = vec2(push.width, push.height), corner = vec2(at * 4u + 1u); // of four texels
    [[unroll]] for (int k = 0; k < 4; k++) {
        vec2 uv = (corner + vec2(k & 1, k >> 1) * 2.0) / size;
        vec4 r = textureGather(sampler2D(textures[push.source], samplers[push.sampler_index]), uv, 0);
        vec4 g = textureGather(sampler2D(textures[push.source], samplers[push.sampler_index]), uv, 1);
        vec4 b = textureGather(sampler2D(textures[push.source], samplers[push.sampler_index]), uv, 2);
        int i = (k >> 1) * 8 + (k & 1) * 2;
        texels[i] = vec3(r.w, g.w, b.w);
        texels[i + 1] = vec3(r.z, g.z, b.z);
        texels[i + 4] = vec3(r.x, g.x, b.x);
        texels[i + 5] = vec3(r.y, g.y, b.y);
    }
    [[unroll]] for (int i = 0; i < 16; i++) texels[i] = vec3(held(texels[i].x), held(texels[i].y), held(texels[i].z));
}

// The box of the colours, each side moved to the next colour, by a 16th of the box at most.
void bound(vec3 texels[16], out vec3 low, out vec3 high) {
    vec3 least = texels[0], most = texels[0];
    [[unroll]] for (int i = 1; i < 16; i++) {
        least = min(least, texels[i]);
        most = max(most, texels[i]);
    }
    vec3 next_least = most, next_most = least;
    [[unroll]] for (int i = 0; i < 16; i++) {
        next_least = mix(next_least, min(next_least, texels[i]), notEqual(texels[i], least));
        next_most = mix(next_most, max(next_most, texels[i]), notEqual(texels[i], most));
    }
    precise vec3 inset = (most - least) * 0.0625;
    precise vec3 up = next_least - least, down = most - next_most;
    precise vec3 inner_low = least + min(up, inset), inner_high = most - min(down, inset);
    low = inner_low;
    high = inner_high;
}

// Where the colours stand on the line between the ends of the box: codes of what they are along its direction. An index in each four bits.
uvec2 indices_on_line(vec3 texels[16], vec3 low, vec3 high) {
    precise vec3 direction = high - low;
    precise float sum = (direction.x + direction.y) + direction.z;
    float scale = sum > 1.4901161193847656e-8 ? 1.0 / sum : 0.0;
    direction = direction * scale;
    float first = float(code_of(dot3(low, direction))), last = float(code_of(dot3(high, direction)));
    precise float per = last != first ? 1.0 / (last - first) : 0.0;
    uvec2 indices = uvec2(0u);
    [[unroll]] for (int i = 0; i < 16; i++) {
        precise float r = (float(code_of(dot3(texels[i], direction))) - first) * per;
        precise float index = r * INDEX4_SCALE + INDEX4_OFFSET;
        uint bits = uint(clamp(index, 0.0, 15.0)) << (4 * (i & 7));
        if (i < 8)
            indices.x |= bits;
        else
            indices.y |= bits;
    }
    return indices;
}

// Modes 11 to 14: the differences stand below the highest bits of the first end, which are turned round.
uvec4 pack_one(uint mode, ivec3 w, ivec3 x, uvec2 indices) {
    if ((indices.x & 15u) > 7u) {
        indices = ~indices; // 15 - index
        ivec3 swap = w;
        w = x;
        x = swap;
    }
    uvec3 field = uvec3(x);
    uint header = 3u;
    if (mode != 11u) {
        uint bits = mode == 14u ? 16u : mode - 1u, delta = 20u - bits;
        header = (mode - 11u) * 4u + 3u;
        uvec3 upper = bitfieldReverse(uvec3(w) >> 10 & ((1u << (bits - 10u)) - 1u)) >> (42u - bits);
        field = (uvec3(x - w) & ((1u << delta) - 1u)) | upper << delta;
    }
    uvec3 base = uvec3(w) & 1023u;
    field &= 1023u;
    return uvec4(header | base.r << 5 | base.g << 15 | base.b << 25, base.b >> 7 | field.r << 3 | field.g << 13 | field.b << 23,
                 field.b >> 9 | (indices.x & 7u) << 1 | (indices.x & 0xfffffff0u), indices.y);
}

// The block of the texels from 4 * at on.
uvec4 bc6h_encode(uvec2 at) {
    vec3 texels[16], low, high;
    fetch(at, texels);
    bound(texels, low, high);
    ivec3 first = ivec3(code_of(low.x), code_of(low.y), code_of(low.z)), last = ivec3(code_of(high.x), code_of(high.y), code_of(high.z));
    uvec2 indices = indices_on_line(texels, low, high);
    ivec3 w = quantise(first, 10u), x = quantise(last, 10u);
#ifdef QUALITY
    vec3 codes[16];
    [[unroll]] for (int i = 0; i < 16; i++) codes[i] = vec3(code_of(texels[i].x), code_of(texels[i].y), code_of(texels[i].z));
    bc6h_best best = bc6h_best(error_of(codes, indices, w, x, w, x, 10u, 0u, false), 11u, 0u, w, x, w, x, indices);
    bc6h_lines l = bc6h_lines(vec3(first), vec3(last), vec3(0.0), vec3(0.0));
    try_one(best, codes, l);
    try_one(best, codes, fit_regions(codes, 0u, false));
    uint pattern = choose_pattern(codes);
    try_two(best, codes, fit_regions(codes, pattern_mask(pattern), true), pattern);
    return best.mode <= 10u ? pack_two(best) : pack_one(best.mode, best.w, best.x, best.indices);
#else
    return pack_one(11u, w, x, indices);
#endif
}

#endif
