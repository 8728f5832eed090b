#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// For the test: where rays leave boxes, and directions by way of the faces of a cube.
#include "common.glsl"
#include "shadows/cube.glsl"

layout(buffer_reference) buffer cube_cases;
layout(buffer_reference) buffer cube_answers;
#include "passes/shadow/cubemap_test_shared.h"
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer cube_cases { gpu_cube_case at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer cube_answers { gpu_cube_answer at[]; };

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform push_block { gpu_cubes_push push; };

void main() {
    uint i = LINEAR_INVOCATION;
    if (i >= push.count) return;
    gpu_cube_case c = push.cases.at[i];
    vec2 place;
    uint face = cube_face(c.along, place);
    push.answers.at[i] = gpu_cube_answer(box_exit(c.from, c.along, c.half_size), cube_direction(face, place));
}
