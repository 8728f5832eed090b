#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// A mip: each texel is the mean of the area that it covers, which of odd sizes is more than two texels wide.
#include "common.glsl"

layout(buffer_reference) buffer view_block;
layout(buffer_reference, scalar, buffer_reference_align = 8) buffer texel_array { uvec2 at[]; };
#include "passes/transmission/transmission_behind_shared.h"
#include "passes/transmission/transmission_texels.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform push_block { gpu_transmission_level_push push; };

void main() {
    uvec2 to = gl_GlobalInvocationID.xy;
    if (any(greaterThanEqual(to, push.to_size))) return;
    vec2 scale = vec2(push.from_size) / vec2(push.to_size), low = vec2(to) * scale, high = low + scale;
    uvec2 first = uvec2(low), end = min(uvec2(ceil(high)), push.from_size);
    vec4 sum = vec4(0.0);
    float weights = 0.0;
    for (uint y = first.y; y < end.y; y++)
        for (uint x = first.x; x < end.x; x++) {
            vec2 covered = min(high, vec2(x, y) + 1.0) - max(low, vec2(x, y));
            float weight = max(covered.x, 0.0) * max(covered.y, 0.0);
            sum += weight * texel_read(push.texels, push.from + y * push.from_size.x + x);
            weights += weight;
        }
    texel_write(push.texels, push.to + to.y * push.to_size.x + to.x, sum / weights);
}
