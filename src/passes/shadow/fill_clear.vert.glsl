#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// The square of a page that is drawn, where nothing is: indices 0 .. 5 are the corners of two triangles.
#include "common.glsl"
#include "passes/shadow/fill.glsl"

layout(push_constant, scalar) uniform push_block { gpu_fill_draw_push push; };

void main() {
    gpu_shadow_page page = push.pages.at[push.drawn.at[gl_InstanceIndex]];
    uint corner = gl_VertexIndex < 3 ? gl_VertexIndex : 6u - gl_VertexIndex; // 0 1 2, 3 2 1
    vec2 texel = vec2(page.place & 0xffffu, page.place >> 16u) * float(SHADOW_UNIT) +
                 vec2(corner & 1u, corner >> 1u) * float(shadow_page_size(shadow_page_of(page.bit).level));
    vec2 at = texel * (2.0 / push.side) - 1.0;
    gl_Position = vec4(at.x, -at.y, 0.0, 1.0);
}
