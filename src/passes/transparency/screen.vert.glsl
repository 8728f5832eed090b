#version 460
// SPDX-License-Identifier: MIT
// One triangle over the whole screen, to be drawn with three vertices.
void main() {
    gl_Position = vec4(vec2(gl_VertexIndex & 1, gl_VertexIndex >> 1) * 4.0 - 1.0, 0.0, 1.0);
}
