// SPDX-License-Identifier: MIT
#version 460

// One triangle over everything, a quarter of the way to the nearest depth.
void main() {
    vec2 corner = vec2(gl_VertexIndex & 1, gl_VertexIndex >> 1);
    gl_Position = vec4(corner * 4.0 - 1.0, 0.25, 1.0);
}
