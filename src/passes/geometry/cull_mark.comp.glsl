#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Marks the items whose bounding box touches the view. SEVERAL_VIEWS: one of several views.
#include "common.glsl"
#include "view.glsl"
#include "scene.glsl"
#include "passes/geometry/hierarchy.glsl"
#include "passes/geometry/cull_shared.h"

layout(local_size_x = 64) in;
#ifdef SEVERAL_VIEWS
layout(push_constant, scalar) uniform push_block { gpu_cull_views_push push; };
#else
layout(push_constant, scalar) uniform push_block { gpu_cull_push push; };
#endif

// Negated, so that a NaN keeps the item.
#define IS_INSIDE(plane) (!(dot(plane.xyz, center) + plane.w < -dot(abs(plane.xyz), extent) * 1.0001))

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
    uint mask = item.receivers >> GPU_ITEM_VIEWS_SHIFT; // 8 bits
#ifdef SEVERAL_VIEWS
    bool visible = false;
    for (uint v = 0u; v < push.view_count && !visible; v++) {
        visible = (view_at(push.view, v).view.mask & mask) != 0u;
        for (int i = 0; i < 5; i++) {
            vec4 plane = view_at(push.view, v).view.planes[i];
            visible = visible && IS_INSIDE(plane);
        }
    }
#else
    bool visible = (push.view.view.mask & mask) != 0u;
    for (int i = 0; i < 5; i++) {
        vec4 plane = push.view.view.planes[i];
        visible = visible && IS_INSIDE(plane);
    }
    vec3 seen = (push.view.view.world_to_view * vec4(center, 1.0)).xyz, size = vec3(0.0);
    for (int i = 0; i < 3; i++) size += abs(push.view.view.world_to_view[i].xyz) * extent[i];
    vec2 low, high;
    float depth;
    if (visible && push.least_pixels > 0.0 && screen_rectangle(push.view, seen, size, 0.0, low, high, depth))
        visible = !(max(high.x - low.x, high.y - low.y) < push.least_pixels);
    if (visible && push.hierarchy_width > 0u && index < push.occludee_count) {
        // Two pixels: lines and points are wider than their bounds.
        if (screen_rectangle(push.view, seen, size * 1.0001 + 1e-6 * length(seen), 2.0, low, high, depth) &&
            hierarchy_hides(push.hierarchy, uvec2(push.hierarchy_width, push.hierarchy_height), low, high, depth, push.view.view.orthographic > 0.5)) {
            visible = false;
            push.hidden.at[index] = 1u;
            atomicAdd(push.hidden.at[push.item_count], 1u);
        }
    }
#endif
    push.sums.at[index] = visible ? 1u : 0u;
}
