#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// The picture so far, with how far away it is: the mean of the samples.
#include "common.glsl"
#include "view.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 8) buffer texel_array { uvec2 at[]; };
#include "passes/transmission/transmission_behind_shared.h"
#include "passes/transmission/transmission_texels.glsl"

layout(constant_id = 1) const uint SAMPLES = 1u;
layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform push_block { gpu_transmission_behind_push push; };

void main() {
    uvec2 size = push.view.view.size;
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(gl_GlobalInvocationID.xy, size))) return;
    vec4 sum = vec4(0.0);
    for (uint i = 0u; i < SAMPLES; i++) {
        vec3 color = SAMPLES > 1u ? texelFetch(textures_multisampled[push.radiance], pixel, int(i)).rgb : texelFetch(textures[push.radiance], pixel, 0).rgb;
        float depth = SAMPLES > 1u ? texelFetch(textures_multisampled[push.depth], pixel, int(i)).r : texelFetch(textures[push.depth], pixel, 0).r;
        sum += vec4(color, depth > 0.0 ? min(1.0 / view_depth_of(push.view, depth), HALF_MAX) : 0.0);
    }
    texel_write(push.texels, uint(pixel.y) * size.x + uint(pixel.x), sum / float(SAMPLES));
}
