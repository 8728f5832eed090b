#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Forward shading of everything else: hidden fragments are not shaded, and so not counted, although counting has side effects.
layout(early_fragment_tests) in;
#include "passes/shade/forward.glsl"
