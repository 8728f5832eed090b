#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Places the trees of primitives in the world: the way from there to the object, and the box round it.
#include "common.glsl"
#include "passes/shadow/rays_build.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform push_block { gpu_ray_place_push push; };

// A transform that flattens has no inverse: what it flattens gets a thickness that is nothing beside its size.
mat3 invertible(mat3 m) {
    float size = max(max(length(m[0]), length(m[1])), max(length(m[2]), 1e-20));
    if (abs(determinant(m / size)) > 1e-12) return m;
    for (int k = 0; k < 3; k++) {
        vec3 a = m[(k + 1) % 3] / size, b = m[(k + 2) % 3] / size, normal = cross(a, b);
        if (dot(normal, normal) < 1e-12) continue;
        m[k] += normalize(normal) * (1e-6 * size);
        break;
    }
    return m;
}

void main() {
    uint index = LINEAR_INVOCATION;
    if (index >= push.item_count) return;
    scene_block s = push.rays.rays.scene;
    gpu_item item = s.scene.items.at[index];
    gpu_instance instance = s.scene.instances.at[item.instance];
    mat3 m = invertible(transpose(mat3(instance.rows[0].xyz, instance.rows[1].xyz, instance.rows[2].xyz)));
    mat3 inverted = inverse(m);
    vec3 origin = vec3(instance.rows[0].w, instance.rows[1].w, instance.rows[2].w), moved = -(inverted * origin);
    gpu_ray_item placed;
    mat3 rows = transpose(inverted);
    for (int k = 0; k < 3; k++) placed.rows[k] = vec4(rows[k], moved[k]);
    placed.primitive = item.primitive;
    push.placed.at[index] = placed;

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
