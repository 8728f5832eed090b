#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Histograms of log luminance, of surfaces and of the background, for automatic exposure. Integer counts: the same in every run.
#include "common.glsl"

layout(buffer_reference) buffer float_array;
#include "passes/post/post_shared.h"
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer float_array { float at[]; };

layout(constant_id = 0) const uint SAMPLES = 1u;
layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform push_block { gpu_meter_push push; };

shared uint bins[2u * METER_BINS];

void main() {
    for (uint i = gl_LocalInvocationIndex; i < 2u * METER_BINS; i += 64u) bins[i] = 0u;
    barrier();
    // A group takes 32 x 32 pixels.
    for (uint i = 0u; i < 16u; i++) {
        uvec2 pixel = gl_WorkGroupID.xy * 32u + uvec2(i & 3u, i >> 2u) * 8u + gl_LocalInvocationID.xy;
        if (pixel.x >= push.width || pixel.y >= push.height) continue;
        vec3 color = SAMPLES > 1u ? texelFetch(textures_multisampled[push.radiance], ivec2(pixel), 0).rgb
                                  : texelFetch(textures[push.radiance], ivec2(pixel), 0).rgb;
        float depth = SAMPLES > 1u ? texelFetch(textures_multisampled[push.depth], ivec2(pixel), 0).r
                                   : texelFetch(textures[push.depth], ivec2(pixel), 0).r;
        vec2 place = (2.0 * vec2(pixel) + 1.0) / vec2(push.width, push.height) - 1.0;
        float level = (log2(max(luminance(color), 1e-12)) - METER_LOW) / (METER_HIGH - METER_LOW);
        uint bin = uint(clamp(level * float(METER_BINS), 0.0, float(METER_BINS - 1u)));
        atomicAdd(bins[depth > 0.0 ? bin : METER_BINS + bin], uint(METER_WEIGHT(max(METER_NEARNESS(place.x, place.y), 0.0))));
    }
    barrier();
    for (uint i = gl_LocalInvocationIndex; i < 2u * METER_BINS; i += 64u)
        if (bins[i] != 0u) atomicAdd(push.histogram.at[i], bins[i]);
}
