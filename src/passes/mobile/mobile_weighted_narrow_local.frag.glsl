#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
#define MOBILE_LAYOUT 0 // and specular 160, as far as light goes
#define MOBILE_LOCAL
#include "passes/mobile/mobile_weighted.glsl"
