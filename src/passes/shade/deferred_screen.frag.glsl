#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Deferred shading of the pixels that the stencil lets through.
#include "common.glsl"
#include "shade.glsl"
#include "gbuffer.glsl"
#include "passes/shade/deferred_screen_shared.h"

layout(early_fragment_tests) in;
layout(push_constant, scalar) uniform push_block { gpu_deferred_screen_push push; };

layout(location = 0) out vec4 out_radiance;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    float view_depth = view_depth_of(push.gbuffer.view, gbuffer_depth(push.gbuffer, pixel));
    vec3 emissive = texelFetch(textures[push.emission], pixel, 0).rgb;
    surface s = gbuffer_surface(push.gbuffer, pixel, gbuffer_position(push.gbuffer.view, pixel, view_depth), emissive);
    vec3 radiance = shade_surface(s, push.gbuffer.view, push.lighting, push.counters, uvec2(pixel), view_depth, LIGHT_NO_ITEM);
    out_radiance = vec4(min(radiance, vec3(push.gbuffer.view.view.frame.frame.hdr_max)), 1.0);
}
