#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Finds the class of each block: one thread a pixel.
#include "common.glsl"
#include "view.glsl"
#include "gbuffer.glsl"
#include "lights/iterate.glsl"
#include "passes/shade/classify_shared.h"

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform push_block { gpu_classify_push push; };

shared uint any_bits[4], all_bits[4];

void main() {
    uvec2 pixel = gl_GlobalInvocationID.xy, local = gl_LocalInvocationID.xy;
    uint part = push.block_size == 8u ? 0u : local.y / 4u * 2u + local.x / 4u;
    if (gl_LocalInvocationIndex < 4u) {
        any_bits[gl_LocalInvocationIndex] = 0u;
        all_bits[gl_LocalInvocationIndex] = SHADE_FULL;
    }
    barrier();
    const uint shaded = 16u; // a pixel that is to be shaded
    if (all(lessThan(pixel, push.view.view.size))) {
        uint bits = 0u;
        float depth = gbuffer_depth(push.gbuffer, ivec2(pixel));
        if (depth > 0.0 && !gbuffer_is_forward(push.gbuffer, ivec2(pixel))) {
            float view_depth = view_depth_of(push.view, depth);
            vec3 position = gbuffer_position(push.view, ivec2(pixel), view_depth);
            surface s = gbuffer_surface(push.gbuffer, ivec2(pixel), position, vec3(0.0));
            if (s.base_color != vec3(0.0) || s.dielectric_f0 != vec3(0.0) || s.dielectric_f90 != 0.0 || s.layered) {
                bits = shaded | SHADE_FULL;
                light_cursor cursor = lights_begin(list_of(push.lighting), light_point(pixel, view_depth, position, s.normal, LIGHT_NO_ITEM));
                uint light;
                if (lights_next(list_of(push.lighting), cursor, light)) bits |= SHADE_LIGHTS;
                if (s.metallic > 0.0) bits |= SHADE_METAL;
            }
        }
        atomicOr(any_bits[part], bits);
        atomicAnd(all_bits[part], bits);
    }
    barrier();
    uvec2 block = pixel / push.block_size;
    if (all(equal(local % push.block_size, uvec2(0u))) && block.x < push.blocks_x && block.y * push.blocks_x < push.block_count) {
        uint index = block.y * push.blocks_x + block.x, any = any_bits[part];
        uint found = (any & shaded) == 0u ? SHADE_NOTHING : any & (SHADE_LIGHTS | SHADE_METAL) | all_bits[part] & SHADE_FULL;
        push.classes.at[index] = found;
        for (uint c = 0u; c < SHADE_CLASSES; c++) push.sums.at[c * push.block_count + index] = uint(c == found);
    }
}
