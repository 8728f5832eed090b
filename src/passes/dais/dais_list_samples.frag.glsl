#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Where the device does not tell coverage after the depth test: an element for each sample, merged when they are shaded.
#define DAIS_EACH_SAMPLE
#include "passes/dais/dais_list.glsl"
