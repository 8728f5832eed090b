// SPDX-License-Identifier: MIT
// From a record and a place on the screen to what the rasteriser hands to forward shading.
#ifndef DAIS_SURFACE_GLSL
#define DAIS_SURFACE_GLSL

#define MATERIAL_GRADIENTS
#include "passes/dais/dais.glsl"
#include "material.glsl"
#include "decals_raster.glsl"

float linear(uint_array pool, uint at, uint stride, vec2 ndc) {
    return uintBitsToFloat(pool.at[at + 2u * stride]) + ndc.x * uintBitsToFloat(pool.at[at]) + ndc.y * uintBitsToFloat(pool.at[at + stride]);
}

vec2 linear2(uint_array pool, uint at, vec2 ndc) { return vec2(linear(pool, at, 2u, ndc), linear(pool, at + 1u, 2u, ndc)); }
vec3 linear3(uint_array pool, uint at, vec2 ndc) {
    return vec3(linear(pool, at, 3u, ndc), linear(pool, at + 1u, 3u, ndc), linear(pool, at + 2u, 3u, ndc));
}
vec4 linear4(uint_array pool, uint at, vec2 ndc) {
    return vec4(linear(pool, at, 4u, ndc), linear(pool, at + 1u, 4u, ndc), linear(pool, at + 2u, 4u, ndc), linear(pool, at + 3u, 4u, ndc));
}

// View depth at a point, and what attributes over w are multiplied by.
float depth_of(view_block v, uint_array pool, uint at, vec2 ndc, out float w) {
    float value = linear(pool, at, 1u, ndc);
    bool orthographic = v.view.orthographic > 0.5;
    w = orthographic ? 1.0 : 1.0 / (abs(value) > 1e-37 ? value : 1e-37);
    return orthographic ? value : w;
}

// Fills what material.glsl reads, for a point in pixels from the top left. Returns the view depth.
float dais_interpolate(view_block v, uint_array pool, uint reference, vec2 pixel) {
    uint base = reference - 1u, bits = pool.at[base + 3u], at = base + DAIS_HEADER;
    vec2 ndc = ndc_of_pixel(v, pixel);
    // The differences that a square of four pixels takes, so that textures are filtered as in forward shading.
    vec2 corner = floor(pixel * 0.5) * 2.0 + 0.5;
    vec2 first = ndc_of_pixel(v, corner), right = ndc_of_pixel(v, corner + vec2(1.0, 0.0)), down = ndc_of_pixel(v, corner + vec2(0.0, 1.0));
    float w, w_first, w_right, w_down;
    float depth = depth_of(v, pool, at, ndc, w), depth_first = depth_of(v, pool, at, first, w_first);
    float depth_right = depth_of(v, pool, at, right, w_right), depth_down = depth_of(v, pool, at, down, w_down);
    at += 3u;
    in_position = (v.view.view_to_world * vec4(view_position_of(v, ndc, depth), 1.0)).xyz;
    in_position_dx = in_position_dy = in_bind = in_bind_dx = in_bind_dy = vec3(0.0);
    in_geometric = vec3(0.0);
    if (FEATURES != 0u) {
        vec3 from = view_position_of(v, first, depth_first);
        in_position_dx = mat3(v.view.view_to_world) * (view_position_of(v, right, depth_right) - from);
        in_position_dy = mat3(v.view.view_to_world) * (view_position_of(v, down, depth_down) - from);
        in_geometric = geometric_of(in_position_dx, in_position_dy);
    }
    in_normal = linear3(pool, at, ndc) * w;
    at += 9u;
    in_uv = in_uv_dx = in_uv_dy = in_tangent = vec4(0.0);
    in_color = vec4(1.0);
    if ((bits & DAIS_UV0) != 0u) {
        vec2 from = linear2(pool, at, first) * w_first;
        in_uv.xy = linear2(pool, at, ndc) * w;
        in_uv_dx.xy = linear2(pool, at, right) * w_right - from;
        in_uv_dy.xy = linear2(pool, at, down) * w_down - from;
        at += 6u;
    }
    if ((bits & DAIS_UV1) != 0u) {
        vec2 from = linear2(pool, at, first) * w_first;
        in_uv.zw = linear2(pool, at, ndc) * w;
        in_uv_dx.zw = linear2(pool, at, right) * w_right - from;
        in_uv_dy.zw = linear2(pool, at, down) * w_down - from;
        at += 6u;
    }
    if ((bits & DAIS_TANGENT) != 0u) {
        in_tangent = linear4(pool, at, ndc) * w;
        at += 12u;
    }
    if ((bits & DAIS_COLOR) != 0u) {
        in_color = linear4(pool, at, ndc) * w;
        at += 12u;
    }
    if ((bits & DAIS_BIND) != 0u) {
        vec3 from = linear3(pool, at, first) * w_first;
        in_bind = linear3(pool, at, ndc) * w;
        in_bind_dx = linear3(pool, at, right) * w_right - from;
        in_bind_dy = linear3(pool, at, down) * w_down - from;
    }
    in_ids = uvec3(pool.at[base + 2u], pool.at[base], (bits & DAIS_MIRROR) != 0u ? 1u : 0u);
    in_front_facing = (bits & DAIS_FRONT) != 0u;
    in_pixel = uvec2(pixel);
    return depth;
}

#endif
