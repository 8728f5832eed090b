#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// The pages that blended surfaces need: each fragment that nothing opaque hides asks for its own.
#include "common.glsl"
#include "view.glsl"
#include "passes/shadow/requests.glsl"
#include "material.glsl"
#include "passes/geometry/geometry_shared.h"

layout(early_fragment_tests) in;
layout(push_constant, scalar) uniform push_block { gpu_geometry_push push; }; // counters: the pages that are wanted

void main() {
    vec3 seen = (push.view.view.world_to_view * vec4(in_position, 1.0)).xyz;
    light_point point;
    point.pixel = push.view.view.samples > 1u ? pixel_of(push.view, seen) : uvec2(gl_FragCoord.xy);
    point.view_depth = -seen.z;
    point.position = in_position;
    point.normal = vec3(0.0);
    point.item = LIGHT_NO_ITEM;
    request_pages(push.lighting, push.counters, point);
}
