#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Bounds of draw items in view space: the box of the primitive, seen as a box along the view's axes, and between the planes of its own two
// thinner sides, which a slanted box fits far better. What deforms has a box without end.
#include "common.glsl"
#include "scene.glsl"
#include "passes/lights/cells.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform push_block { gpu_cells_push push; };

void main() {
    uint cell = LINEAR_INVOCATION;
    if (cell >= push.cell_count) return;
    scene_block scene = scene_block(push.list.list.extra);
    gpu_item item = scene.scene.items.at[cell];
    gpu_primitive primitive = scene.scene.primitives.at[item.primitive];
    gpu_instance instance = scene.scene.instances.at[item.instance];
    vec3 world_center = transform_point(instance, primitive.center);
    vec3 center = (push.view.view.world_to_view * vec4(world_center, 1.0)).xyz;
    // Positions are interpolated, which rounds more than moving a point does: on the faces of the box they are still inside of it.
    float rounding = 16.0 * float(BOUND_ROUNDING) * (length(world_center) + length(push.view.view.eye));
    mat3 to_view = mat3(push.view.view.world_to_view);
    vec3 sides[3], extent = vec3(rounding);
    for (int k = 0; k < 3; k++) {
        vec3 axis = vec3(instance.rows[0][k], instance.rows[1][k], instance.rows[2][k]);
        sides[k] = to_view * axis * primitive.half_extent[k];
        extent += abs(sides[k]);
    }
    extent *= 1.0 + CELL_SLACK;
    gpu_cell_bounds b;
    b.low = center - extent;
    b.high = center + extent;
    int longest = 0;
    for (int k = 1; k < 3; k++)
        if (dot(sides[k], sides[k]) > dot(sides[longest], sides[longest])) longest = k;
    for (int k = 0; k < 2; k++) {
        // The slab between two opposite faces: at right angles to the other two sides.
        vec3 along = sides[longest], across = sides[(longest + 1 + (1 - k)) % 3], side = sides[(longest + 1 + k) % 3];
        vec3 normal = cross(along, across);
        float size = length(normal);
        if (!(size > 1e-12) || isinf(size)) { // flat or without end: a plane that holds everything
            b.planes[2 * k] = b.planes[2 * k + 1] = vec4(0.0, 0.0, 0.0, 1e30);
            continue;
        }
        normal /= size;
        float half_width = abs(dot(normal, side)) * (1.0 + CELL_SLACK) + rounding + CELL_SLACK * 1e-2;
        b.planes[2 * k] = vec4(normal, half_width - dot(normal, center));
        b.planes[2 * k + 1] = vec4(-normal, half_width + dot(normal, center));
    }
    push.cells.at[cell] = b;
}
