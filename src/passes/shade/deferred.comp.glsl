#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Deferred shading: one thread a pixel reads the G-buffer once and writes its radiance once. Either every pixel, or those of blocks of
// one class (classify.h).
#include "common.glsl"
#define SHADOWS_GUIDED
#include "shade.glsl"
#include "gbuffer.glsl"
#include "passes/shade/shade_shared.h"
#include "passes/shadow/denoise.glsl"

layout(constant_id = IS_FULL_ID) const uint IS_FULL = 0u;    // every pixel of the blocks is to be shaded
layout(constant_id = BLOCK_SIZE_ID) const uint BLOCK_SIZE = 0u; // 0: not classified

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform push_block { gpu_deferred_push push; };

// The thread's pixel of the class's blocks; false when there is none.
bool block_pixel(out ivec2 pixel) {
    pixel = ivec2(0);
    uint first = push.sums.at[push.class_index * push.block_count], end = push.sums.at[(push.class_index + 1u) * push.block_count];
    uint blocks_per_group = 64u / (BLOCK_SIZE * BLOCK_SIZE);
    uint slot = first + LINEAR_GROUP * blocks_per_group + gl_LocalInvocationIndex / (BLOCK_SIZE * BLOCK_SIZE);
    if (slot >= end) return false;
    uint block = push.blocks.at[slot], inside = gl_LocalInvocationIndex % (BLOCK_SIZE * BLOCK_SIZE);
    uint blocks_x = (push.gbuffer.view.view.size.x + BLOCK_SIZE - 1u) / BLOCK_SIZE;
    pixel = ivec2(uvec2(block % blocks_x, block / blocks_x) * BLOCK_SIZE + uvec2(inside % BLOCK_SIZE, inside / BLOCK_SIZE));
    return true;
}

// What is denoised, as parts of the luminance of all light, and the normal (denoise_shared.h).
void store_apart(ivec2 pixel, vec3 normal) {
    float all = luminance(apart.open), scale = all > 0.0 ? 1.0 / all : 0.0;
    vec2 encoded = octahedral_encode(normal);
    imageStore(images[push.open], pixel, vec4(min(apart.open, vec3(push.gbuffer.view.view.frame.frame.hdr_max)), encoded.x));
    imageStore(images[push.seen], pixel, vec4(apart.seen * scale, encoded.y));
    imageStore(images[push.drawn], pixel, vec4(apart.drawn * scale, apart.noise));
    imageStore(images[push.field], pixel, vec4(apart.field.xyz / max(apart.field.w, 1e-30), min(apart.field.w, HALF_MAX)));
}

void main() {
    uint thread = gl_LocalInvocationIndex; // eight in a row are 4x2 pixels: they look up places that lie closer together than those of 8x1
    uvec2 group = uvec2(gl_WorkGroupID.z * DEFERRED_STRIP + gl_WorkGroupID.x, gl_WorkGroupID.y);
    ivec2 pixel = ivec2(group * 8u + uvec2(thread & 3u | thread >> 1 & 4u, thread >> 2 & 1u | thread >> 3 & 6u)) + ivec2(0, push.first_row);
    if (BLOCK_SIZE != 0u && !block_pixel(pixel)) return;
    if (any(greaterThanEqual(uvec2(pixel), push.gbuffer.view.view.size))) return;
    float depth = gbuffer_depth(push.gbuffer, pixel);
    if (IS_FULL == 0u && (depth <= 0.0 || gbuffer_is_forward(push.gbuffer, pixel))) { // sky keeps the background
        if (LIGHTING_DENOISED) {
            imageStore(images[push.open], pixel, vec4(0.0, 0.0, 0.0, DENOISE_SKY));
            imageStore(images[push.field], pixel, vec4(0.0));
        }
        return;
    }
    float view_depth = view_depth_of(push.gbuffer.view, depth);
    vec3 emissive = imageLoad(images[push.radiance], pixel).rgb;
    surface s = gbuffer_surface(push.gbuffer, pixel, gbuffer_position(push.gbuffer.view, pixel, view_depth), emissive);
    if (LIGHTING_GUIDED) guide = guide_of(push.guide_weights, push.guide_seen, pixel);
    vec3 radiance = shade_surface(s, push.gbuffer.view, push.lighting, push.counters, uvec2(pixel), view_depth, LIGHT_NO_ITEM);
    if (LIGHTING_DENOISED) store_apart(pixel, s.normal);
    imageStore(images[push.radiance], pixel, vec4(min(radiance, vec3(push.gbuffer.view.view.frame.frame.hdr_max)), 1.0));
}
