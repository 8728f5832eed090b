// SPDX-License-Identifier: MIT
#version 460
#extension GL_EXT_multiview : require

layout(location = 0) out vec4 target;

void main() { target = vec4(float(gl_ViewIndex) + 1.0); }
