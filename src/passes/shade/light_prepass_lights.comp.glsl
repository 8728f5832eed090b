#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// The lights of each pixel, or of one pixel out of each square of them, summed up without the material.
#include "common.glsl"
#include "gbuffer.glsl"
#include "passes/shade/light_prepass.glsl"
#include "passes/shade/light_scale.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform push_block { gpu_light_prepass_push push; };

void main() {
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy), pixel = texel;
    if (any(greaterThanEqual(uvec2(texel), uvec2(push.width, push.height)))) return;
    if (push.scale > 1u) {
        pixel = light_sample_pixel(push.view, push.surfaces.depth, texel, int(push.scale));
        ivec2 inside = pixel - texel * int(push.scale);
        imageStore(images_uint[push.samples], texel, uvec4(inside.y * int(push.scale) + inside.x));
    }
    float depth = texelFetch(textures[push.surfaces.depth], pixel, 0).r;
    light_sums sums = light_sums_none();
    if (depth > 0.0) {
        float view_depth = view_depth_of(push.view, depth);
        light_surface s = light_surface_of(push.surfaces, pixel, gbuffer_position(push.view, pixel, view_depth));
        sums = light_sums_of(s, push.view, push.lights, push.counters, uvec2(pixel), view_depth);
    }
    uint count = LIGHT_BUFFER == LIGHT_BUFFER_RGBA ? 1u : LIGHT_BUFFER == LIGHT_BUFFER_TWO ? 2u : 4u;
    for (uint i = 0u; i < count; i++)
        imageStore(images[push.targets[i]], texel, min(sums.at[i], vec4(push.view.view.hdr_max)));
}
