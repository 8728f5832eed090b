#version 460
// SPDX-License-Identifier: MIT
// A triangle over the screen for each slot.
layout(location = 0) flat out uint out_slot;

void main() {
    out_slot = gl_InstanceIndex;
    gl_Position = vec4(vec2(gl_VertexIndex & 1, gl_VertexIndex >> 1) * 4.0 - 1.0, 0.0, 1.0);
}
