#version 460
// SPDX-License-Identifier: MIT
// Tells the corners of a triangle apart, so that the rasteriser interpolates their weights.
layout(triangles) in;
layout(triangle_strip, max_vertices = 3) out;

layout(location = 3) centroid in vec4 in_uv[];
layout(location = 4) centroid in vec4 in_color[];
layout(location = 5) flat in uvec3 in_ids[];
layout(location = 8) in vec2 in_weights[];
layout(location = 3) centroid out vec4 out_uv;
layout(location = 4) centroid out vec4 out_color;
layout(location = 5) flat out uvec3 out_ids;
layout(location = 8) out vec2 out_weights; // of the second and third corner

invariant gl_Position;

void main() {
    for (int i = 0; i < 3; i++) {
        gl_Position = gl_in[i].gl_Position;
        gl_PrimitiveID = gl_PrimitiveIDIn;
        out_uv = in_uv[i];
        out_color = in_color[i];
        out_ids = in_ids[i];
        out_weights = vec2(i == 1 ? 1.0 : 0.0, i == 2 ? 1.0 : 0.0);
        EmitVertex();
    }
    EndPrimitive();
}
