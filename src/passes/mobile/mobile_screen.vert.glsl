#version 460
// SPDX-License-Identifier: MIT
// One triangle over everything.
void main() {
    vec2 corner = vec2(gl_VertexIndex & 1, gl_VertexIndex >> 1);
    gl_Position = vec4(corner * 4.0 - 1.0, 0.5, 1.0);
}
