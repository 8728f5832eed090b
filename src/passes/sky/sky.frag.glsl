#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// The environment, where nothing else is seen: the triangle lies at the far end of the depth range.
#include "common.glsl"
#include "environment.glsl"
#include "passes/sky/sky_shared.h"

layout(push_constant, scalar) uniform push_block { gpu_sky_push push; };

layout(location = 0) out vec4 out_radiance;

void main() {
    view_block v = push.view;
    vec3 toward = view_position_of(v, ndc_of_pixel(v, gl_FragCoord.xy), 1.0);
    vec3 direction = v.view.orthographic > 0.5 ? -v.view.back : normalize(mat3(v.view.view_to_world) * toward);
    out_radiance = vec4(min(environment_radiance(v, direction, 0.0), vec3(v.view.frame.frame.hdr_max)), 1.0);
}
