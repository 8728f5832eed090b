#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Motion vectors as colours.
#include "passes/aa/motion.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform push_block { gpu_motion_view_push push; };

void main() {
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    if (p.x >= int(push.width) || p.y >= int(push.height)) return;
    vec4 m = texelFetch(textures[push.motion], p, 0);
    float turn = atan(m.y, m.x) / (2.0 * PI), speed = clamp(log2(1.0 + 4.0 * length(m.xy)) / 8.0, 0.0, 1.0);
    vec3 hue = clamp(abs(fract(turn + vec3(0.0, 0.667, 0.333)) * 6.0 - 3.0) - 1.0, 0.0, 1.0);
    vec3 color = m.w == 0.0 ? vec3(0.0) : mix(vec3(128.0 / 255.0), hue, speed);
    imageStore(images[push.target], p, vec4(push.swap == 1u ? color.bgr : color, 1.0));
}
