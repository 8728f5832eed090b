#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Shades a blended fragment and writes it into its pixel's list; blends it at once where the pool has no list for the pixel.
#include "passes/shade/forward.glsl"
#include "passes/transparency/linked.glsl"
#include "passes/transparency/transparency_draw_shared.h"

layout(early_fragment_tests) in; // as when they were counted
layout(push_constant, scalar) uniform push_block { gpu_linked_push push; };
layout(location = 6) flat in uint in_corner;

layout(location = 0) out vec4 out_radiance;

void main() {
    float depth = gl_FragCoord.z, view_depth;
    vec2 slope = vec2(dFdxFine(depth), dFdyFine(depth)); // all of the square is still there
    vec4 color = forward_shade(push.geometry, view_depth);
    uvec2 pixel = min(uvec2(gl_FragCoord.xy), push.geometry.view.view.size - 1u); // helpers lie beside the picture too
    uint index = pixel.y * push.geometry.view.view.size.x + pixel.x;
    uint end = push.sums.at[index + 1u];
    out_radiance = color;
    if (end > push.capacity) return;
    if (color.a > 0.0) { // nothing else would show
        uint at = push.sums.at[index] + atomicAdd(push.written.at[index], 1u);
        if (at < end) {
            push.colors.at[at] = color;
            push.keys.at[at] = gpu_blend_key(depth, in_ids.y, in_corner);
            if (push.samples > 1u) push.extents.at[at] = gpu_blend_extent(slope, uint(gl_SampleMaskIn[0]));
        }
    }
    discard;
}
