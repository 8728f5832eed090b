#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
#define MOBILE_LAYOUT 2 // metallic 256
#define MOBILE_LOCAL
#include "passes/mobile/mobile_volume.glsl"
