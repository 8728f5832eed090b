#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// What the walls of a room let through, seen from one point: a ray for each texel, through the walls alone. What stands in the room is passed by, and so is
// what moves.
#include "common.glsl"

#define RAYS_TINTED
#include "shadows/rays.glsl"
#include "shadows/cube.glsl"

layout(buffer_reference) buffer probe_array;
layout(buffer_reference) buffer probes_block;
#include "passes/shadow/cubemap_push_shared.h"
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer probe_array { gpu_probe at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer probes_block { gpu_probes probes; };

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform push_block { gpu_cubemap_push push; };

void main() {
    uint texel = LINEAR_INVOCATION, side = push.side;
    if (texel >= 6u * side * side) return;
    gpu_probe p = push.probes.probes.probes.at[push.probe];
    vec2 at = (vec2(texel % side, texel / side % side) + 0.5) * (2.0 / float(side)) - 1.0;
    vec3 along = normalize(cube_direction(texel / (side * side), at));
    vec3 room = max(p.half_size - p.wall, vec3(0.0));
    float begin = all(lessThan(abs(p.capture), room)) ? box_exit(p.capture, along, room) : 0.0;
    float end = box_exit(p.capture, along, p.half_size + p.wall);
    vec3 from = p.capture + along * begin;
    // The rows are a rotation and a shift: back by the transposed one.
    vec3 shift = vec3(p.rows[0].w, p.rows[1].w, p.rows[2].w), origin = vec3(0.0), direction = vec3(0.0);
    for (int k = 0; k < 3; k++) {
        origin += p.rows[k].xyz * (from[k] - shift[k]);
        direction += p.rows[k].xyz * along[k];
    }
    ray_scope still = ray_scope(RAY_STILL, 0.0, push.probes.probes.moving);
    if ((push.probes.probes.flags & PROBES_MOVERS) == 0u) still = ray_everything();
    vec4 open = tree_visibility(push.rays, still, origin, direction, end - begin, 0.0);
    push.texels.at[push.to + texel] = packUnorm4x8(open);
}
