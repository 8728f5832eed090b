#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
#include "passes/post/overlay.glsl"

layout(location = 0) out vec2 out_texel;
layout(location = 1) out vec4 out_color;

void main() {
    gpu_overlay_vertex vertex = push.vertices.at[push.indices.at[gl_VertexIndex]];
    vec2 place = (vertex.position - push.corner) * push.scale;
    gl_Position = vec4(place.x - 1.0, 1.0 - place.y, 0.0, 1.0);
    out_texel = vertex.texel;
    out_color = unpackUnorm4x8(vertex.color);
}
