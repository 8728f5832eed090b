// SPDX-License-Identifier: MIT
// What the samples of a pixel refer to, from the render target or the list.
#ifndef DAIS_PIXEL_GLSL
#define DAIS_PIXEL_GLSL

#include "passes/dais/dais.glsl"
#define SAMPLES_AT DAIS_SAMPLES_ID
#define FLOATS_AT DAIS_FLOATS_ID
#include "passes/shade/samples.glsl"

layout(constant_id = DAIS_LISTS_ID) const uint LISTS = 0u;          // 1: pixels have lists
layout(constant_id = DAIS_SHARED_ID) const uint SHARED_SAMPLES = 0u; // 1: there are shading samples

layout(set = 0, binding = 0) uniform utexture2DMS textures_uint_multisampled[];

struct dais_source {
    uint_array pool, heads, nodes;
    uint references, shared_samples;
    uvec2 size;
};

struct dais_pixel {
    uint references[8]; // by sample
    uint shading[8];    // shading samples
};

// Whether `a` was drawn after `b`, both of which pass the depth test.
bool drawn_after(dais_source from, uint a, uint b) {
    if (a == DAIS_NO_ROOM || b == DAIS_NO_ROOM) return a == DAIS_NO_ROOM;
    uint item_a = from.pool.at[a - 1u], item_b = from.pool.at[b - 1u];
    return item_a != item_b ? item_a > item_b : from.pool.at[a] > from.pool.at[b];
}

void take_samples(dais_source from, inout dais_pixel p, uint mask, uint reference, uint shading) {
    for (uint i = 0u; i < SAMPLES; i++) {
        if ((mask >> i & 1u) == 0u) continue;
        bool takes = true;
        if (p.references[i] != 0u) takes = drawn_after(from, reference, p.references[i]);
        if (takes) {
            p.references[i] = reference;
            p.shading[i] = shading;
        }
    }
}

dais_pixel dais_read(dais_source from, ivec2 at) {
    dais_pixel p;
    for (uint i = 0u; i < 8u; i++) p.references[i] = p.shading[i] = 0u;
    if (LISTS == 1u) {
        uint pixel = uint(at.y) * from.size.x + uint(at.x), pixels = from.size.x * from.size.y;
        uint next = from.heads.at[pixel];
        // Elements are few: a sample has one, or one for each of the surfaces that meet there.
        while (next - 1u < DAIS_FULL - 1u) { // neither the end nor a reference
            uint base = next * DAIS_NODE;
            take_samples(from, p, from.nodes.at[base + 2u], from.nodes.at[base + 1u], from.nodes.at[base + 3u]);
            next = from.nodes.at[base];
        }
        if (next == DAIS_NO_LIST) {
            for (uint i = 0u; i < SAMPLES; i++) p.references[i] = DAIS_NO_ROOM;
        } else if (next >= DAIS_FULL) {
            take_samples(from, p, EVERY_SAMPLE, next & ~DAIS_FULL, SHARED_SAMPLES == 1u ? from.heads.at[pixels + pixel] : 0u);
        }
    } else {
        for (uint i = 0u; i < SAMPLES; i++) {
            p.references[i] = SAMPLES == 1u ? texelFetch(textures_uint[from.references], at, 0).r
                                            : texelFetch(textures_uint_multisampled[from.references], at, int(i)).r;
            if (SHARED_SAMPLES == 1u)
                p.shading[i] = SAMPLES == 1u ? texelFetch(textures_uint[from.shared_samples], at, 0).r
                                             : texelFetch(textures_uint_multisampled[from.shared_samples], at, int(i)).r;
        }
    }
    return p;
}

// One triangle, though it may be stored twice.
bool same_triangle(dais_source from, uint a, uint b) {
    if (a == b) return true;
    return from.pool.at[a - 1u] == from.pool.at[b - 1u] && from.pool.at[a] == from.pool.at[b];
}

bool is_shaded(uint reference) { return reference != 0u && reference != DAIS_NO_ROOM; }

uint shaded_samples(dais_pixel p) {
    uint mask = 0u;
    for (uint i = 0u; i < SAMPLES; i++)
        if (is_shaded(p.references[i])) mask |= 1u << i;
    return mask;
}

// Those of `left` that show the triangle of the first of them; 0: none is left.
uint first_triangle(dais_source from, dais_pixel p, uint left) {
    uint first = left == 0u ? 0u : uint(findLSB(left)), found = 0u;
    for (uint i = 0u; i < SAMPLES; i++)
        if ((left >> i & 1u) != 0u && same_triangle(from, p.references[first], p.references[i])) found |= 1u << i;
    return found;
}

// Where in a pixel a triangle is shaded that covers these samples: in their middle, which is the pixel's if it covers all.
vec2 shading_place(uint mask) {
    vec2 sum = vec2(0.0);
    for (uint i = 0u; i < SAMPLES; i++)
        if ((mask >> i & 1u) != 0u) sum += sample_place(i);
    return SAMPLES == 1u || mask == EVERY_SAMPLE ? vec2(0.5) : sum / float(bitCount(mask));
}

#endif
