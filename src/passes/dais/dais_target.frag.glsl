#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Shading samples are each pixel's own.
#include "passes/dais/dais_target.glsl"
