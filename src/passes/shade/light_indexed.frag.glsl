#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Leaves the id of a light at the pixels that its sphere may reach.
#include "common.glsl"
#include "gbuffer.glsl"
#include "passes/shade/sample_bounds.glsl"
#include "passes/shade/volumes.glsl"
#include "passes/shade/light_indexed_shared.h"

layout(constant_id = SAMPLES_ID) const uint SAMPLES = 1u;
layout(constant_id = INDEXED_PACKING_ID) const uint PACKING = INDEXED_IDS;
layout(constant_id = INDEXED_STEP_ID) const uint STEP = 0u; // of max: 1 is the second

#ifndef LATE_TESTS // of stencil: where the light does not reach, the fragment does not count
// What the depth test drops is neither counted nor blended.
layout(early_fragment_tests) in;
#endif
layout(push_constant, scalar) uniform push_block { gpu_indexed_push push; };

layout(location = 0) flat in uint in_light;
layout(location = 2) flat in uint in_rank;
layout(location = 0) out vec4 out_id; // where ids go into an image

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    view_block v = push.head.view;
    vec4 seen = texelFetch(textures[push.depth], pixel, 0);
    if (seen.r <= 0.0 && (SAMPLES <= 1u || sample_bounds_empty(seen))) discard; // sky
    // A hair wider than the sphere: surfaces are drawn where interpolation puts them, and are looked at here where depth does.
    gpu_entity_bounds light = push.head.lighting.scope.lights.entities.at[in_light];
    if (SAMPLES > 1u) {
        if (!sample_bounds_reached(v, pixel, seen, light.center, light.radius)) discard;
    } else {
        float view_depth = view_depth_of(v, seen.r);
        float reach = light.radius * 1.001 + 1e-4 + 1e-4 * view_depth;
        vec3 between = light.center - gbuffer_position(v, pixel, view_depth);
        if (dot(between, between) > reach * reach) discard; // NaN stays
    }
    uint at = uint(pixel.y) * v.view.size.x + uint(pixel.x), pixels = v.view.size.x * v.view.size.y;
    if (PACKING == INDEXED_IDS) {
        uint slot = atomicAdd(push.counts.at[at], in_rank < 0xffffu ? 1u : INDEXED_LOST);
        if (in_rank < 0xffffu && slot < push.capacity) {
            uint words = (push.capacity + 1u) / 2u;
            atomicOr(push.slots.at[at * words + slot / 2u], in_rank + 1u << 16u * (slot & 1u));
        }
        return;
    }
    uint batch = in_rank / INDEXED_BATCH, id = in_rank % INDEXED_BATCH + 1u, channel = push.step;
    if (PACKING == INDEXED_SETS_PACKING) {
        uint code = push.sets.at[in_light];
        batch = code == 0u ? push.layers : code / (256u * INDEXED_LAYER_LIGHTS);
        channel = code >> 8 & INDEXED_LAYER_LIGHTS - 1u;
        id = code & 255u;
    }
    if (batch != push.batch) { // one that no layer is for is counted with the first
        if (batch >= push.layers && push.batch == 0u && STEP == 0u && push.step == 0u) atomicAdd(push.counts.at[at], INDEXED_LOST);
        discard;
    }
    if (STEP == 0u && push.step == 0u) atomicAdd(push.counts.at[push.batch * pixels + at], 1u);
    if (PACKING >= INDEXED_STENCIL) {
        out_id = vec4(equal(uvec4(0u, 1u, 2u, 3u), uvec4(channel))) * (float(id) / 255.0);
        return;
    }
    if (PACKING == INDEXED_SHIFT) {
        out_id = vec4(uvec4(id, id >> 2, id >> 4, id >> 6) & 3u) * (64.0 / 255.0);
        return;
    }
    out_id = vec4(float(id), 255.0 - float(id), 0.0, 0.0) / 255.0;
    if (STEP == 1u) { // the first step's two go along
        vec4 first = texelFetch(textures[push.first], pixel, 0);
        uvec2 known = uvec2(round(first.xy * 255.0));
        out_id = vec4(first.xy, id == known.x || id == 255u - known.y ? vec2(0.0) : out_id.xy);
    }
}
