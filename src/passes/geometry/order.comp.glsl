#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Front-to-back order: one of the steps of order.c, which alternate with sorts.
#include "common.glsl"
#include "view.glsl"
#include "scene.glsl"
#include "passes/geometry/hierarchy.glsl"
#include "passes/geometry/order_shared.h"

layout(local_size_x = 64) in;
layout(constant_id = 1) const uint STEP = ORDER_DEPTHS;
layout(push_constant, scalar) uniform push_block { gpu_order_push push; };

void put(uint index, uint key, uint value) {
    push.pairs_out.at[2u * index] = key;
    push.pairs_out.at[2u * index + 1u] = value;
}

// The bucket of a group: the last bucket whose first group is not greater. Bucket 0 begins with group 0.
uint bucket_of(uint group) {
    uint low = 0u, high = push.bucket_count;
    while (high - low > 1u) {
        uint middle = (low + high) / 2u;
        if ((push.buckets.at[middle] & ~ORDER_KEPT) <= group) low = middle;
        else high = middle;
    }
    return low;
}
uint group_of(uint item) {
    uint low = 0u, high = push.group_count;
    while (high - low > 1u) {
        uint middle = (low + high) / 2u;
        if (push.scene.scene.groups.at[middle].first_item <= item) low = middle;
        else high = middle;
    }
    return low;
}

// A key that ascends with the distance of the item's nearest point; 0 if the item keeps its order.
uint depth_of(uint item_index) {
    if ((push.buckets.at[bucket_of(group_of(item_index))] & ORDER_KEPT) != 0u) return 0u;
    gpu_item item = push.scene.scene.items.at[item_index];
    gpu_primitive primitive = push.scene.scene.primitives.at[item.primitive];
    gpu_instance instance = push.scene.scene.instances.at[item.instance];
    vec3 center = transform_point(instance, primitive.center), extent;
    for (int i = 0; i < 3; i++) extent[i] = dot(abs(instance.rows[i].xyz), primitive.half_extent);
    vec3 forward = -vec3(push.view.view.world_to_view[0].z, push.view.view.world_to_view[1].z, push.view.view.world_to_view[2].z);
    float depth = -(push.view.view.world_to_view * vec4(center, 1.0)).z - dot(abs(forward), extent);
    return depth > 0.0 ? floatBitsToUint(depth) : 0u; // the bits of positive floats sort like the floats
}

void main() {
    uint index = LINEAR_INVOCATION;
    if (STEP == ORDER_DEPTHS && index < push.item_count) {
        put(index, depth_of(index), index);
    } else if (STEP == ORDER_GROUPS && index < push.item_count) { // from depth order to group order, hidden items last
        uint item = push.pairs_in.at[2u * index + 1u];
        bool visible = push.sums.at[item + 1u] != push.sums.at[item];
        put(index, visible ? group_of(item) : push.group_count, item);
    } else if (STEP == ORDER_ITEMS && index < push.sums.at[push.item_count]) {
        push.visible.at[index] = push.pairs_in.at[2u * index + 1u];
    } else if (STEP == ORDER_KEYS && index < push.group_count) { // groups by bucket, then by their nearest item
        gpu_draw draw = push.draws.at[index];
        uint depth = draw.instance_count > 0u ? depth_of(push.visible.at[draw.first_instance]) : 0x7fffffffu;
        put(index, bucket_of(index) << 22u | depth >> 9u, index);
    } else if (STEP == ORDER_DRAWS && index < push.group_count) {
        push.ordered.at[index] = push.draws.at[push.pairs_in.at[2u * index + 1u]];
    }
}
