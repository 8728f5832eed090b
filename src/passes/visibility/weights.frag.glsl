#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Ids with weights of surfaces without holes.
#include "passes/visibility/weights.glsl"

layout(early_fragment_tests) in;

void main() { write_weights(); }
