#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
#include "passes/aa/motion.glsl"

layout(push_constant, scalar) uniform push_block { gpu_motion_objects_push push; };
layout(location = 0) in vec3 in_previous;
layout(location = 1) flat in uint in_new;
layout(location = 0) out vec4 out_motion;

void main() {
    out_motion = motion_of(push.motion, gl_FragCoord.xy, vec4(in_previous, 1.0));
    if (in_new == 1u) out_motion = vec4(0.0, 0.0, max(out_motion.z, 1e-6), 0.0);
}
