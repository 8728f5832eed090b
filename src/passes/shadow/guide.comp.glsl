#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Before shading: takes up what the last frame saw of each tile's surfaces, and makes weights of it (guide.h). A work group for each tile, an invocation for
// each slot.
#include "common.glsl"
#include "view.glsl"
#include "shadows/guide_shared.h"

layout(local_size_x = GUIDE_SLOTS) in;
layout(push_constant, scalar) uniform push_block { gpu_guide_push push; };

const float STEPS = 256.0; // of a pixel: sums of whole numbers do not depend on their order

shared int moved_x, moved_y, movers;
shared float weights[GUIDE_SLOTS];

// By how many pixels what the tile shows has moved since the last frame, on average.
vec2 tile_motion(ivec2 tile, ivec2 slot) {
    if (gl_LocalInvocationIndex == 0u) moved_x = moved_y = movers = 0;
    barrier();
    ivec2 p = tile * int(GUIDE_TILE) + slot;
    if (push.moves == 1u && all(lessThan(uvec2(slot), uvec2(GUIDE_TILE))) && all(lessThan(p, ivec2(push.view.view.size)))) {
        vec4 motion = texelFetch(textures[push.motion], p, 0);
        if (motion.w > 0.0 && motion.z < 1e29) {
            ivec2 steps = ivec2(round(clamp(motion.xy, -16384.0, 16384.0) * STEPS));
            atomicAdd(moved_x, steps.x);
            atomicAdd(moved_y, steps.y);
            atomicAdd(movers, 1);
        }
    }
    barrier();
    return movers > 0 ? vec2(moved_x, moved_y) / (STEPS * float(movers)) : vec2(0.0);
}

// Rays that the last frame knew to be sent, and to have passed.
vec2 was_seen(ivec2 tile, ivec2 tiles, ivec2 slot) {
    if (any(lessThan(tile, ivec2(0))) || any(greaterThanEqual(tile, tiles))) return vec2(0.0);
    uint seen = texelFetch(textures_uint[push.was], tile * int(GUIDE_SIDE) + slot, 0).x;
    return vec2(GUIDE_SENT(seen), GUIDE_PASSED(seen));
}

void main() {
    ivec2 tile = ivec2(gl_WorkGroupID.xy), tiles = ivec2(gl_NumWorkGroups.xy);
    uint index = gl_LocalInvocationIndex;
    ivec2 slot = ivec2(index % GUIDE_SIDE, index / GUIDE_SIDE);
    vec2 motion = tile_motion(tile, slot), own = vec2(0.0), around = vec2(0.0);
    if (push.keeps == 1u) {
        vec2 at = vec2(tile) + motion / float(GUIDE_TILE), base = floor(at), part = at - base;
        for (int i = 0; i < 4; i++) {
            ivec2 side = ivec2(i & 1, i >> 1);
            vec2 share = mix(1.0 - part, part, vec2(side));
            if (share.x * share.y > 0.0) own += share.x * share.y * was_seen(ivec2(base) + side, tiles, slot);
        }
        ivec2 middle = ivec2(floor(at + 0.5));
        for (int i = 0; i < 9; i++)
            if (i != 4) around += was_seen(middle + ivec2(i % 3 - 1, i / 3 - 1), tiles, slot);
    }
    uvec2 kept = uvec2(own * GUIDE_KEPT);
    imageStore(images_uint[push.seen], tile * int(GUIDE_SIDE) + slot, uvec4(kept.x << 16 | kept.y));
    // The tiles around, and where they know nothing that all lights are seen, count as a few rays more. The chance of a ray to come through is v; with
    // weights in proportion to its root the variance is least.
    float one = float(GUIDE_UNIT), prior = (around.y + one) / (around.x + one), more = GUIDE_PRIOR * one;
    float visible = (own.y + more * prior) / (own.x + more);
    float weight = max(sqrt(visible), GUIDE_LEAST);
    if (push.adverse == 1u) weight = ((tile.x * 7 + tile.y * 13 + int(index) * 5) & 3) == 0 ? 1.0 : GUIDE_LEAST;
    weights[index] = weight;
    barrier();
    if (index < GUIDE_SLOTS / 4u)
        imageStore(images[push.weights], tile * int(GUIDE_SIDE / 2u) + ivec2(index % (GUIDE_SIDE / 2u), index / (GUIDE_SIDE / 2u)),
                   vec4(weights[4u * index], weights[4u * index + 1u], weights[4u * index + 2u], weights[4u * index + 3u]));
}
