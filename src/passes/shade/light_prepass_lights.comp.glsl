#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// The lights of each pixel, or of one pixel out of each square of them, summed up without the material.
#include "common.glsl"
#include "gbuffer.glsl"
#include "passes/shade/light_prepass.glsl"
#include "passes/shade/light_samples.glsl"
#include "passes/shade/light_scale.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform push_block { gpu_light_prepass_push push; };

void main() {
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy), pixel = texel;
    if (any(greaterThanEqual(uvec2(texel), uvec2(push.width, push.height)))) return;
    uint count = LIGHT_BUFFER == LIGHT_BUFFER_RGBA ? 1u : LIGHT_BUFFER == LIGHT_BUFFER_TWO || LIGHT_BUFFER == LIGHT_BUFFER_NARROW ? 2u : 4u;
    if (SAMPLES > 1u && push.scale == 1u) { // one surface of each pixel that has so many
        uint samples = surface_samples(push.words.at[uint(texel.y) * push.width + uint(texel.x)], push.layer);
        if (samples == 0u) return;
        float view_depth;
        light_surface s = light_samples_surface(push.view, push.surfaces, texel, samples, view_depth);
        light_sums sums = light_sums_of(s, push.view, push.lighting, push.counters, uvec2(texel), view_depth);
        for (uint i = 0u; i < count; i++)
            imageStore(images[push.targets[i]], texel, min(sums.at[i], vec4(push.view.view.frame.frame.hdr_max)));
        return;
    }
    if (push.scale > 1u) {
        pixel = light_sample_pixel(push.view, push.surfaces.depth, texel, int(push.scale));
        ivec2 inside = pixel - texel * int(push.scale);
        imageStore(images_uint[push.samples], texel, uvec4(inside.y * int(push.scale) + inside.x));
    }
    float depth = light_scale_depth(push.surfaces.depth, pixel);
    light_sums sums = light_sums_none();
    if (depth > 0.0) {
        float view_depth = view_depth_of(push.view, depth);
        light_surface s = light_surface_of(push.surfaces, pixel, LIGHT_SCALE_SAMPLE, light_scale_position(push.view, pixel, view_depth));
        sums = light_sums_of(s, push.view, push.lighting, push.counters, uvec2(pixel), view_depth);
    }
    for (uint i = 0u; i < count; i++)
        imageStore(images[push.targets[i]], texel, min(sums.at[i], vec4(push.view.view.frame.frame.hdr_max)));
}
