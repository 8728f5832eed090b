#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Where the grids of directional lights lie: along the light they reach as far as the scene does, across it they are round the viewer.
#include "common.glsl"
#include "passes/shadow/fill.glsl"

layout(buffer_reference) buffer shadow_sun_array;
#include "passes/shadow/suns_shared.h"
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer shadow_sun_array { gpu_shadow_sun at[]; };

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform push_block { gpu_shadow_suns_push push; };

// The box round everything that may cast shadows.
struct world_box {
    vec3 center;
    vec3 half_size;
};

world_box world_box_of(rays_block rays) {
    gpu_ray_tree tree = rays.rays.items;
    if (tree.root == RAY_END) return world_box(vec3(0.0), vec3(0.0));
    if ((tree.root & RAY_LEAF) == 0u) {
        gpu_ray_node node = tree.nodes.at[tree.root];
        return world_box(0.5 * (node.low + node.high), 0.5 * (node.high - node.low));
    }
    gpu_fill_caster c = caster_of(rays, tree.ids.at[tree.root & ~RAY_LEAF], 0xffffffffu);
    gpu_instance instance = gpu_instance(c.rows);
    vec3 size = 0.5 * (c.high - c.low);
    return world_box(transform_point(instance, 0.5 * (c.low + c.high)),
                     abs(transform_direction(instance, vec3(size.x, 0.0, 0.0))) + abs(transform_direction(instance, vec3(0.0, size.y, 0.0))) +
                         abs(transform_direction(instance, vec3(0.0, 0.0, size.z))));
}

// The least exponent of a power of two that is not less. Of nothing and what is broken: some exponent.
int exponent_above(float x) { return int(floatBitsToUint(clamp(x, 1e-6, 1e30)) >> 23) - 126; }

void main() {
    uint index = LINEAR_INVOCATION;
    if (index >= push.lighting.scope.lights.directional_count) return;
    view_block v = push.lighting.scope.view;
    world_box box = world_box_of(push.rays);
    gpu_shadow_sun sun;
    sun.direction = push.lighting.scope.lights.lights.at[index].shape.direction;
    vec3 size = abs(sun.direction), aside = size.x <= size.y && size.x <= size.z ? vec3(1.0, 0.0, 0.0)
                                          : size.y <= size.z                   ? vec3(0.0, 1.0, 0.0)
                                                                               : vec3(0.0, 0.0, 1.0);
    sun.side = normalize(cross(sun.direction, aside));
    sun.up = cross(sun.side, sun.direction);
    sun.eye = vec2(dot(v.view.eye, sun.side), dot(v.view.eye, sun.up));
    // Both are rounded, so that pages stay true while something moves a little.
    float half_depth = dot(size, box.half_size);
    sun.reach = ldexp(1.0, exponent_above(1.25 * half_depth));
    sun.middle = 0.25 * sun.reach * floor(dot(sun.direction, box.center) / (0.25 * sun.reach) + 0.5);
    // Coordinates round: texels are at least as wide as that.
    float away = max(distance(v.view.eye, box.center) + length(box.half_size), length(v.view.eye));
    sun.coarsest = exponent_above(away / SHADOW_SUN_REACH);
    push.suns.at[index] = sun;
}
