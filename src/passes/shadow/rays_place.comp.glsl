#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Places the trees of primitives in the world: the way from there to the object, and the box round it.
#include "common.glsl"
#include "passes/shadow/rays_build.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform push_block { gpu_ray_place_push push; };

void main() {
    uint index = LINEAR_INVOCATION;
    if (index >= push.item_count) return;
    scene_block s = push.rays.rays.scene;
    gpu_item item = s.scene.items.at[index];
    gpu_instance instance = s.scene.instances.at[item.instance];
    mat3 m = instance_matrix(instance);
    vec3 origin = vec3(instance.rows[0].w, instance.rows[1].w, instance.rows[2].w);
    push.placed.at[index] = ray_item_of(m, origin, item.primitive);

    gpu_ray_box box = push.rays.rays.primitive_boxes.at[item.primitive];
    if (box.low.x <= box.high.x) {
        vec3 center = m * (0.5 * (box.low + box.high)) + origin, half_size = 0.5 * (box.high - box.low);
        vec3 extent = abs(m[0]) * half_size.x + abs(m[1]) * half_size.y + abs(m[2]) * half_size.z;
        box = ray_box_widened(center - extent, center + extent);
    }
    push.boxes.at[index] = box;
    push.pairs.at[index * 2u] = morton_code((0.5 * (box.low + box.high) - push.low) * push.scale, 10u);
    push.pairs.at[index * 2u + 1u] = index;
}
