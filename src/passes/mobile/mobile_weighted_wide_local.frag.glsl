#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
#define MOBILE_LAYOUT 2 // that of all 256-bit layouts, as far as light goes
#define MOBILE_LOCAL
#include "passes/mobile/mobile_weighted.glsl"
