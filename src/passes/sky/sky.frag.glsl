#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// The environment or a gradient, where nothing else is seen: the triangle lies at the far end of the depth range.
#include "common.glsl"
#include "environment.glsl"
#include "passes/sky/sky_shared.h"

layout(push_constant, scalar) uniform push_block { gpu_sky_push push; };

layout(location = 0) out vec4 out_radiance;

void main() {
    view_block v = push.view;
    vec3 toward = view_position_of(v, ndc_of_pixel(v, gl_FragCoord.xy), 1.0);
    vec3 direction = v.view.orthographic > 0.5 ? -v.view.back : normalize(mat3(v.view.view_to_world) * toward);
    vec3 radiance;
    if (push.gradient != 0u) {
        float mean = push.gradient == 1u ? luminance(v.view.frame.frame.environment.light.diffuse[0]) * v.view.frame.frame.environment_scale : 1.0;
        float part = direction.y > 0.0 ? mix(GRADIENT_HORIZON, GRADIENT_ZENITH, smoothstep(0.0, 1.0, direction.y))
                                       : mix(GRADIENT_HORIZON, GRADIENT_NADIR, smoothstep(0.0, 1.0, -direction.y));
        radiance = vec3(mean * part);
    } else {
        radiance = environment_radiance(v, direction, push.lod);
    }
    out_radiance = vec4(min(radiance, vec3(v.view.frame.frame.hdr_max)), 0.0);
}
