#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Ids of surfaces without holes, several samples a pixel.
#define ID_BYTES
#include "passes/visibility/visibility.glsl"

layout(early_fragment_tests) in;

void main() { write_id(); }
