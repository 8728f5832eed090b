#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Forward shading of cutouts that write depth themselves: their depth test has to wait for the holes.
#include "passes/shade/forward.glsl"
