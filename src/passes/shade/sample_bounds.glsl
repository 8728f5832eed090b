// SPDX-License-Identifier: MIT
// Lights and points against the ranges of sample_bounds.h.
#ifndef SAMPLE_BOUNDS_GLSL
#define SAMPLE_BOUNDS_GLSL

#include "view.glsl"

// Nothing but sky.
bool sample_bounds_empty(vec4 ranges) { return ranges == vec4(0.0); }

// Whether a sphere of the world may touch what a pixel shows within one range: the part of the ray through its middle, as thick as the pixel.
bool sample_range_reached(view_block v, ivec2 pixel, vec2 range, vec3 center, float radius) {
    vec2 ndc = ndc_of_pixel(v, vec2(pixel) + 0.5);
    vec3 at = (v.view.world_to_view * vec4(center, 1.0)).xyz;
    vec3 from = view_position_of(v, ndc, range.x), to = view_position_of(v, ndc, range.y);
    vec3 along = to - from;
    float part = clamp(dot(at - from, along) / max(dot(along, along), 1e-30), 0.0, 1.0);
    vec2 size = 2.0 * abs(v.view.ndc_scale) * v.view.inverse_size * (v.view.orthographic > 0.5 ? 1.0 : abs(range.y));
    float reach = radius * 1.001 + 1e-4 + 1e-4 * abs(range.y) + max(size.x, size.y);
    vec3 between = at - (from + along * part);
    return !(dot(between, between) > reach * reach); // NaN stays
}

bool sample_bounds_reached(view_block v, ivec2 pixel, vec4 ranges, vec3 center, float radius) {
    return sample_range_reached(v, pixel, ranges.xy, center, radius) ||
           ranges.z < ranges.w && sample_range_reached(v, pixel, ranges.zw, center, radius);
}

// Whether the lights of a point on the pixel were looked for.
bool sample_bounds_hold(vec4 ranges, float view_depth) {
    return view_depth >= ranges.x && view_depth <= ranges.y || view_depth >= ranges.z && view_depth <= ranges.w;
}

#endif
