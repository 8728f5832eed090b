#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Deferred shading: one thread a pixel reads the G-buffer once and writes its radiance once.
#include "common.glsl"
#include "shade.glsl"
#include "gbuffer.glsl"
#include "passes/shade/shade_shared.h"

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform push_block { gpu_deferred_push push; };

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(uvec2(pixel), push.view.view.size))) return;
    float depth = texelFetch(textures[push.depth], pixel, 0).r;
    if (depth <= 0.0) return; // sky keeps the background
    gbuffer g;
    g.color = texelFetch(textures[push.color], pixel, 0);
    g.normal = texelFetch(textures[push.normal], pixel, 0);
    g.dielectric = texelFetch(textures[push.dielectric], pixel, 0);
    float view_depth = view_depth_of(push.view, depth);
    vec3 view_position = view_position_of(push.view, ndc_of_pixel(push.view, vec2(pixel) + 0.5), view_depth);
    vec3 position = (push.view.view.view_to_world * vec4(view_position, 1.0)).xyz;
    vec3 emissive = imageLoad(images[push.radiance], pixel).rgb;
    surface s = gbuffer_unpack(g, position, emissive);
    vec3 radiance = shade_surface(s, push.view, push.lights, push.counters, uvec2(pixel), view_depth, LIGHT_NO_ITEM);
    imageStore(images[push.radiance], pixel, vec4(min(radiance, vec3(push.view.view.hdr_max)), 1.0));
}
