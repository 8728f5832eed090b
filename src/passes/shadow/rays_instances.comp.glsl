#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// The draw items as the device's own structures have them, and the way from the world to each.
#include "common.glsl"
#include "passes/shadow/rays_build.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform push_block { gpu_ray_instances_push push; };

void main() {
    uint index = LINEAR_INVOCATION;
    if (index >= push.item_count) return;
    gpu_item item = push.scene.scene.items.at[index];
    gpu_instance instance = push.scene.scene.instances.at[item.instance];
    mat3 m = instance_matrix(instance);
    vec3 origin = vec3(instance.rows[0].w, instance.rows[1].w, instance.rows[2].w);
    push.placed.at[index] = ray_item_of(m, origin, item.primitive);
    gpu_ray_instance made;
    mat3 rows = transpose(m);
    for (int k = 0; k < 3; k++) made.rows[k] = vec4(rows[k], origin[k]);
    made.index_and_mask = index | 0xff000000u;
    made.offset_and_flags = 0u;
    made.structure = push.structures.at[item.primitive];
    push.instances.at[index] = made;
}
