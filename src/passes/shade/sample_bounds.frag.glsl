#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// The two ranges of view depths in which the samples of a pixel lie: parted at the middle, where there is nothing near it.
#include "view.glsl"
#include "passes/shade/samples.glsl"
#include "passes/shade/sample_bounds_shared.h"

layout(push_constant, scalar) uniform push_block { gpu_sample_bounds_push push; };
layout(location = 0) out vec4 out_ranges;

// Depths of one surface reach on by as much as they cover already, and by two pixels: a plane that is not steeper than that, of which one
// sample alone is seen, is within the range all over the pixel.
vec2 widened(vec2 range) {
    view_block v = push.view;
    vec2 size = 2.0 * abs(v.view.ndc_scale) * v.view.inverse_size * (v.view.orthographic > 0.5 ? 1.0 : range.y);
    float more = range.y - range.x + 2.0 * max(size.x, size.y);
    return vec2(range.x - more, range.y + more);
}

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    float depths[8];
    vec2 all = vec2(3e38, -3e38);
    for (uint i = 0u; i < SAMPLES; i++) {
        float depth = texelFetch(textures_multisampled[push.depth], pixel, int(i)).r;
        depths[i] = -1.0;
        if (!(depth > 0.0)) continue;
        depths[i] = view_depth_of(push.view, depth);
        all = vec2(min(all.x, depths[i]), max(all.y, depths[i]));
    }
    if (all.x > all.y) discard; // sky
    float middle = 0.5 * (all.x + all.y);
    vec2 near = vec2(all.x), far = vec2(all.y);
    for (uint i = 0u; i < SAMPLES; i++) {
        if (depths[i] < 0.0) continue;
        if (depths[i] <= middle)
            near.y = max(near.y, depths[i]);
        else
            far.x = min(far.x, depths[i]);
    }
    near = widened(near);
    far = widened(far);
    out_ranges = near.y >= far.x ? vec4(widened(all), 3e38, -3e38) : vec4(near, far);
    // Solids whose far side is before that reach nothing. The whole of depths where it lies behind the viewer.
    float start = out_ranges.x;
    vec4 clip = push.view.view.view_to_clip * vec4(0.0, 0.0, -start, 1.0);
    gl_FragDepth = start > push.view.view.near_distance ? clamp(clip.z / clip.w * (1.0 + 1e-6) + 1e-6, 0.0, 1.0) : 1.0;
}
