#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// For the test: which lights a list gives each of its points.
#include "common.glsl"
#include "lights/iterate.glsl"

layout(buffer_reference) buffer walk_point_array;

#include "passes/lights/walk_test_shared.h"

layout(buffer_reference, scalar, buffer_reference_align = 4) buffer walk_point_array { gpu_walk_point at[]; };

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform push_block { gpu_walk_push push; };

void main() {
    uint index = LINEAR_INVOCATION;
    if (index >= push.point_count) return;
    gpu_walk_point p = push.points.at[index];
    light_cursor cursor = lights_begin(push.list, light_point(p.pixel, p.view_depth, p.position, p.normal, LIGHT_NO_ITEM));
    uint row = index * (GPU_WALK_ROOM + 1u), count = 0u;
    FOR_EACH_LIGHT(push.list, cursor, light) {
        if (count < GPU_WALK_ROOM) push.found.at[row + 1u + count] = light;
        count++;
    }
    push.found.at[row] = count;
}
