#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// The plane into the depth of an eye: what lies beyond it is not drawn.
#include "passes/stereo/mono.glsl"

layout(push_constant, scalar) uniform push_block { gpu_mono_push push; };

void main() { gl_FragDepth = mono_plane_depth(push.eye, push.mono, gl_FragCoord.xy, push.distance); }
