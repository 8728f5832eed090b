#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Marks the items whose bounding box touches the view.
#include "common.glsl"
#include "view.glsl"
#include "scene.glsl"
#include "passes/geometry/cull_shared.h"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform push_block { gpu_cull_push push; };

void main() {
    uint index = LINEAR_INVOCATION;
    if (index > push.item_count) return;
    if (index == push.item_count) {
        push.sums.at[index] = 0u;
        return;
    }
    gpu_item item = push.scene.scene.items.at[index];
    gpu_primitive primitive = push.scene.scene.primitives.at[item.primitive];
    gpu_instance instance = push.scene.scene.instances.at[item.instance];
    vec3 center = transform_point(instance, primitive.center);
    vec3 extent = vec3(dot(abs(instance.rows[0].xyz), primitive.half_extent), dot(abs(instance.rows[1].xyz), primitive.half_extent),
                       dot(abs(instance.rows[2].xyz), primitive.half_extent));
    bool visible = true;
    for (int i = 0; i < 5; i++) {
        vec4 plane = push.view.view.planes[i];
        // Negated, so that a NaN keeps the item.
        visible = visible && !(dot(plane.xyz, center) + plane.w < -dot(abs(plane.xyz), extent) * 1.0001);
    }
    push.sums.at[index] = visible ? 1u : 0u;
}
