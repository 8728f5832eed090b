#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// The quads of the mesh that are drawn, two triangles each.
#include "passes/stereo/lens.glsl"

layout(location = 0) out vec2 out_red;
layout(location = 1) out vec2 out_green;
layout(location = 2) out vec2 out_blue;

void main() {
    const uvec2 corners[6] = uvec2[](uvec2(0, 0), uvec2(0, 1), uvec2(1, 0), uvec2(1, 0), uvec2(0, 1), uvec2(1, 1));
    uint cell = push.cells.at[gl_VertexIndex / 6];
    uvec2 corner = uvec2(cell % LENS_QUADS, cell / LENS_QUADS) + corners[gl_VertexIndex % 6];
    gpu_lens_vertex v = push.vertices.at[corner.y * (LENS_QUADS + 1u) + corner.x];
    vec2 place = (push.origin + v.position * push.size) / push.target;
    gl_Position = vec4(place.x * 2.0 - 1.0, 1.0 - place.y * 2.0, 0.0, 1.0);
    out_red = v.red;
    out_green = v.green;
    out_blue = v.blue;
}
