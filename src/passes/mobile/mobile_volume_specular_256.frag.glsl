#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
#define MOBILE_LAYOUT 3 // specular 256
#include "passes/mobile/mobile_volume.glsl"
