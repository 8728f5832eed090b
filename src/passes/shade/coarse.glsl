// SPDX-License-Identifier: MIT
// Blocks of pixels that are alike, and the pixels of those that are not: what passes at a coarse rate share. A group has 64 threads and
// 8 x 8 blocks of SIZE x SIZE pixels; first a thread has a block, then a pixel of those blocks that are not alike:
//
//     coarse_block block = coarse_find();
//     for (uint turn = 0u; turn < coarse_turns(); turn++) {
//         ivec2 pixel;
//         if (coarse_work(block, turn, pixel)) { shaded++; … }
//     }
//     coarse_end(shaded);
//
// In the first turn that is the block's own pixel, which stands for all of them where block.kind is COARSE_SHARED.
//
// Sathe and Janczak, "Deferred Coarse Pixel Shading", GPU Pro 7 (2016), III.2.
#ifndef COARSE_GLSL
#define COARSE_GLSL

#include "gbuffer.glsl"
#include "passes/shade/coarse_shared.h"

layout(constant_id = 4) const uint SIZE = 2u; // 1, 2, 4
layout(constant_id = 5) const uint CRITERION = COARSE_CRITERION_Z;
layout(constant_id = 9) const uint FLAGS = 0u;

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform push_block { gpu_coarse_push push; };

struct coarse_block {
    ivec2 first; // its top left pixel, by which the others are measured
    uint kind;
};

shared uint fine_blocks[COARSE_GROUP]; // x | y << 16 of first pixels
shared uint fine_count;
shared uint tally[COARSE_COUNTS];

ivec2 coarse_last() { return ivec2(push.gbuffer.view.view.size) - 1; }
bool coarse_inside(ivec2 pixel) { return all(lessThanEqual(pixel, coarse_last())); }

// The least and greatest of a single-channel image over the block.
vec2 coarse_range(uint image, ivec2 first) {
    vec2 range = vec2(1e38, -1e38);
    if ((FLAGS & COARSE_SAMPLERS) != 0u) {
        for (uint i = 0u; i < SIZE * SIZE / 4u; i++) { // between four texels each
            ivec2 corner = first + 2 * ivec2(i % max(SIZE / 2u, 1u), i / max(SIZE / 2u, 1u)) + 1;
            vec2 at = vec2(min(corner, coarse_last() + 1)) * push.gbuffer.view.view.inverse_size;
            range.x = min(range.x, textureLod(sampler2D(textures[image], samplers[push.least]), at, 0.0).r);
            range.y = max(range.y, textureLod(sampler2D(textures[image], samplers[push.greatest]), at, 0.0).r);
        }
        return range;
    }
    for (uint i = 0u; i < SIZE * SIZE; i++) {
        float value = texelFetch(textures[image], min(first + ivec2(i % SIZE, i / SIZE), coarse_last()), 0).r;
        range = vec2(min(range.x, value), max(range.y, value));
    }
    return range;
}

// The greatest squared distance of two normals in a box of azimuth and height. With heights h and distances r from the axis,
// |a - b|^2 = (h_a - h_b)^2 + (r_a - r_b)^2 + 2 r_a r_b (1 - cos d), and 2 (1 - cos d) <= d^2.
float coarse_chord2(vec2 azimuth, vec2 height) {
    vec2 r = sqrt(max(1.0 - height * height, vec2(0.0)));
    float high = height.x * height.y <= 0.0 ? 1.0 : max(r.x, r.y), turn = (azimuth.y - azimuth.x) * high;
    float up = height.y - height.x, out_of = high - min(r.x, r.y);
    return up * up + out_of * out_of + turn * turn;
}

struct coarse_material {
    vec3 normal, color;
    vec4 f0; // roots of F0, F90
    vec3 rest; // roughness, metalness, occlusion
};
coarse_material coarse_material_at(ivec2 pixel) {
    coarse_material m;
    vec4 stored = texelFetch(textures[push.gbuffer.targets[1]], pixel, 0);
    m.normal = octahedral_decode(stored.xy * 2.0 - 1.0);
    m.rest = vec3(stored.z, gbuffer_split(stored.w));
    m.color = texelFetch(textures[push.gbuffer.targets[0]], pixel, 0).rgb;
    m.f0 = texelFetch(textures[push.gbuffer.targets[2]], pixel, 0);
    return m;
}

float coarse_greatest(vec4 v) { return max(max(v.x, v.y), max(v.z, v.w)); }

// What rounding makes of the view depths of one plane that faces the viewer.
float coarse_precision(float view_depth) {
    return 5e-7 * (push.gbuffer.view.view.orthographic > 0.5 ? push.gbuffer.view.view.depth_decode.x : view_depth);
}

// Pixels beyond the edge of the picture are those at its edge: the same block's. `pixels` is how many show a surface.
uint coarse_kind(ivec2 first, out uint pixels) {
    view_block v = push.gbuffer.view;
    gpu_coarse_settings settings = push.settings.settings;
    float depth = gbuffer_depth(push.gbuffer, first), view_depth = view_depth_of(v, depth);
    coarse_material reference = coarse_material_at(first);
    float bound = 0.0, away = 0.0, chord2 = 0.0, color = 0.0, other = 0.0;
    uvec2 id = uvec2(0u);
    if (CRITERION == COARSE_CRITERION_ID) {
        id = texelFetch(textures_uint[push.geometry], first, 0).rg;
    } else {
        vec2 gradient = abs(texelFetch(textures[push.geometry], first, 0).rg);
        bound = settings.depth_bound * (gradient.x + gradient.y) + coarse_precision(view_depth);
    }
    bool same = true, surfaces_alone = true;
    pixels = 0u;
    for (uint i = 0u; i < SIZE * SIZE; i++) {
        ivec2 at = first + ivec2(i % SIZE, i / SIZE), pixel = min(at, coarse_last());
        float d = gbuffer_depth(push.gbuffer, pixel);
        pixels += uint(d > 0.0 && at == pixel);
        surfaces_alone = surfaces_alone && d > 0.0;
        coarse_material m = coarse_material_at(pixel);
        if (CRITERION == COARSE_CRITERION_Z) away = max(away, abs(view_depth_of(v, d) - view_depth));
        if (CRITERION == COARSE_CRITERION_ID) same = same && texelFetch(textures_uint[push.geometry], pixel, 0).rg == id;
        vec3 turn = m.normal - reference.normal;
        chord2 = max(chord2, dot(turn, turn));
        color = max(color, max_component(abs(m.color - reference.color)));
        other = max(other, max(coarse_greatest(abs(m.f0 - reference.f0)), max_component(abs(m.rest - reference.rest))));
    }
    if (CRITERION == COARSE_CRITERION_MINMAX) {
        vec2 depths = coarse_range(push.gbuffer.depth, first);
        away = view_depth_of(v, depths.x) - view_depth_of(v, depths.y); // depth is reversed
        chord2 = coarse_chord2(coarse_range(push.azimuth, first), coarse_range(push.height, first));
    }
    if (pixels == 0u) return COARSE_NOTHING;
    if (SIZE == 1u) return COARSE_SHARED;
    if (!surfaces_alone || !same || !(away <= bound)) return COARSE_DEPTH;
    if (!(chord2 <= settings.normal_chord * settings.normal_chord)) return COARSE_NORMAL;
    if (!(color <= settings.albedo_tolerance) || !(other <= settings.tolerance)) return COARSE_OTHER;
    return COARSE_SHARED;
}

// All threads of the group call this.
coarse_block coarse_find() {
    uint thread = gl_LocalInvocationIndex;
    if (thread == 0u) fine_count = 0u;
    if (thread < COARSE_COUNTS) tally[thread] = 0u;
    barrier();
    coarse_block block;
    block.first = ivec2(gl_GlobalInvocationID.xy * SIZE);
    block.kind = COARSE_NOTHING;
    uint pixels = 0u;
    if (coarse_inside(block.first)) block.kind = coarse_kind(block.first, pixels);
    if (block.kind > COARSE_SHARED) fine_blocks[atomicAdd(fine_count, 1u)] = uint(block.first.x) | uint(block.first.y) << 16;
    if (pixels > 0u) {
        atomicAdd(tally[block.kind], 1u);
        atomicAdd(tally[COARSE_COUNT_PIXELS], pixels);
    }
    barrier();
    return block;
}

uint coarse_items() { return fine_count * (SIZE * SIZE - 1u); }
uint coarse_turns() { return 1u + (coarse_items() + COARSE_GROUP - 1u) / COARSE_GROUP; }

// The thread's pixel in a turn; false when it has none.
bool coarse_work(coarse_block block, uint turn, out ivec2 pixel) {
    pixel = block.first;
    bool has = block.kind != COARSE_NOTHING;
    if (turn > 0u) {
        uint item = (turn - 1u) * COARSE_GROUP + gl_LocalInvocationIndex;
        has = item < coarse_items();
        uint corner = fine_blocks[has ? item / (SIZE * SIZE - 1u) : 0u], inside = 1u + item % max(SIZE * SIZE - 1u, 1u);
        pixel = ivec2(corner & 0xffffu, corner >> 16) + ivec2(inside % SIZE, inside / SIZE);
    }
    return has && coarse_inside(pixel) && gbuffer_depth(push.gbuffer, pixel) > 0.0;
}

// All threads call this at last; `shaded` is how often the thread had work.
void coarse_end(uint shaded) {
    atomicAdd(tally[COARSE_COUNT_SHADED], shaded);
    barrier();
    uint thread = gl_LocalInvocationIndex;
    if (thread < COARSE_COUNTS && tally[thread] > 0u) atomicAdd(push.counts.at[thread], tally[thread]);
}

#endif
