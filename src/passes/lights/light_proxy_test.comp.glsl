#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// For the test: asks each light about each of its points, and for its corners.
#include "common.glsl"
#include "lighting/reach.glsl"
#include "lights/proxy.glsl"

layout(buffer_reference) buffer answer_array;
layout(buffer_reference) buffer point_array;

#include "passes/lights/light_proxy_test_shared.h"

layout(buffer_reference, scalar, buffer_reference_align = 4) buffer answer_array { gpu_light_answer at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer point_array { vec3 at[]; };

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform push_block { gpu_light_proxy_push push; };

void main() {
    uint index = LINEAR_INVOCATION;
    if (index >= push.light_count * push.points_each) return;
    uint light = index / push.points_each;
    vec3 to_light;
    push.answers.at[index].illuminance = light_reach(set_of(push.list), light, push.points.at[index], LIGHT_MASK_ALL, to_light);
    push.answers.at[index].to_light = to_light;
    push.answers.at[index].reaches = light_reaches(set_of(push.list), light, push.points.at[index]) ? 1u : 0u;
    if (index % push.points_each == 0u) {
        vec3 corners[8];
        gpu_entity_bounds bounds = push.list.list.lights.set.entities.at[light];
        shape_corners(shape_of(set_of(push.list), bounds), bounds.center, bounds.radius, corners);
        for (uint i = 0u; i < 8u; i++) push.corners.at[light * 8u + i] = corners[i];
    }
}
