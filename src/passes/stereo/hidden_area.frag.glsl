#version 460
// SPDX-License-Identifier: MIT
layout(location = 0) out vec4 out_radiance;

void main() { out_radiance = vec4(0.0, 0.0, 0.0, 1.0); }
