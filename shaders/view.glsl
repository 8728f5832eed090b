// SPDX-License-Identifier: MIT
#ifndef VIEW_GLSL
#define VIEW_GLSL

#include "common.glsl"

layout(buffer_reference) buffer frame_block;
layout(buffer_reference) buffer environment_block;
#include "environment_shared.h"
#include "view_shared.h"

layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer frame_block { gpu_frame frame; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer view_block { gpu_view view; };

#ifdef SEVERAL_VIEWS
// A view from an array of them. Adding an integer to a reference would need 64-bit integers.
view_block view_at(view_block first, uint index) {
    uvec2 address = uvec2(first);
    uint carry;
    address.x = uaddCarry(address.x, index * GPU_VIEW_BYTES, carry);
    return view_block(uvec2(address.x, address.y + carry));
}
#endif

// The camera that is drawn for: with MULTIVIEW a draw goes to several views at once.
#ifdef MULTIVIEW
#define DRAWN_VIEW(first) view_at(first, uint(gl_ViewIndex))
#else
#define DRAWN_VIEW(first) (first)
#endif

// Positive distance along the view axis of a stored depth; huge for the empty sky of a perspective view.
float view_depth_of(view_block v, float depth) {
    vec4 d = v.view.depth_decode;
    return (d.x + d.y * depth) / max(d.z + d.w * depth, 1e-30);
}

// Normalised device coordinates (+Y up) of a point on the screen, in pixels from the top left.
vec2 ndc_of_pixel(view_block v, vec2 pixel) {
    vec2 uv = pixel * v.view.inverse_size;
    return vec2(uv.x * 2.0 - 1.0, 1.0 - uv.y * 2.0);
}

vec3 view_position_of(view_block v, vec2 ndc, float view_depth) {
    float spread = v.view.orthographic > 0.5 ? 1.0 : view_depth;
    return vec3((ndc * v.view.ndc_scale + v.view.ndc_offset) * spread, -view_depth);
}

// Metres that a pixel is wide at a view depth.
float pixel_width(view_block v, float view_depth) {
    vec2 size = 2.0 * abs(v.view.ndc_scale) * v.view.inverse_size * (v.view.orthographic > 0.5 ? 1.0 : view_depth);
    return max(size.x, size.y);
}

// The pixel on which a point in view space is seen; those beyond the edge are moved to it.
uvec2 pixel_of(view_block v, vec3 view_position) {
    float spread = v.view.orthographic > 0.5 ? 1.0 : -view_position.z;
    vec2 ndc = (view_position.xy / spread - v.view.ndc_offset) / v.view.ndc_scale;
    vec2 at = (vec2(ndc.x, -ndc.y) * 0.5 + 0.5) * vec2(v.view.size);
    vec2 last = vec2(v.view.size) - 1.0;
    return uvec2(at.x > 0.0 ? min(at.x, last.x) : 0.0, at.y > 0.0 ? min(at.y, last.y) : 0.0); // NaN: 0
}

// Unit vector from a world-space point to the viewer.
vec3 to_viewer(view_block v, vec3 position) {
    return v.view.orthographic > 0.5 ? v.view.back : normalize(v.view.eye - position);
}

#endif
