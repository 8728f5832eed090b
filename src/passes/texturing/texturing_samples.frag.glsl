#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Surfaces without holes, several samples a pixel.
#define TARGETS_STORED
#include "passes/texturing/texturing_write.glsl"

layout(early_fragment_tests) in;

void main() { write_targets(find_changes()); }
