#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// A light's share of one pixel: bilinear, so that the four shares add up to one wherever it stands, and move without a jump.
#include "common.glsl"
#include "passes/lights/sprites.glsl"

layout(push_constant, scalar) uniform push_block { gpu_sprites_push push; };

layout(location = 0) flat in vec3 in_color;
layout(location = 1) flat in vec2 in_pixel;
layout(location = 0) out vec4 out_radiance;

void main() {
    vec2 share = max(1.0 - abs(floor(gl_FragCoord.xy) + 0.5 - in_pixel), vec2(0.0));
    out_radiance = vec4(min(in_color * (share.x * share.y), vec3(push.view.view.frame.frame.hdr_max)), 0.0);
}
