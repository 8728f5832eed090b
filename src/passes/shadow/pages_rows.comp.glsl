#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// How important each light is, and whether it is what it was when its pages were drawn.
#include "lights/iterate.glsl"
#include "passes/shadow/pages.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform push_block { gpu_shadow_rows_push push; };

// Lumens, but for the part that the ramp of a cone and wedge takes away.
float flux_of(gpu_light light) {
    float intensity = luminance(light.color);
    gpu_shape s = light.shape;
    if (s.kind == GPU_SHAPE_BOX) return intensity * 4.0 * s.size.x * s.size.y;
    if (s.kind == GPU_SHAPE_CONE) return intensity * 2.0 * PI * (1.0 + s.spot_offset / s.spot_scale);
    if (s.kind == GPU_SHAPE_WEDGE) { // the solid angle of a pyramid
        vec2 sines = s.size.xy * inversesqrt(1.0 + s.size.xy * s.size.xy);
        return intensity * 4.0 * asin(sines.x * sines.y);
    }
    return intensity * 4.0 * PI;
}

// The flux, times the part of the directions from the viewer that the light's volume takes; up to a factor that all lights of a view share.
float importance_of(light_list_block l, uint row, gpu_light light) {
    gpu_entity_bounds bounds = l.list.entities.at[row];
    float away = l.list.view.view.orthographic > 0.5 ? 1.0 : max(distance(bounds.center, l.list.view.view.eye), bounds.radius);
    float size = bounds.radius / max(away, 1e-20);
    return max(flux_of(light) * size * size, 0.0);
}

void main() {
    uint row = LINEAR_INVOCATION;
    if (row >= push.row_count) return;
    gpu_light light = push.list.list.lights.at[push.list.list.directional_count + row];
    gpu_shadow_shape now = gpu_shadow_shape(light.shape.position, light.shape.range, light.shape.kind, vec3(0.0), vec3(0.0), vec3(0.0));
    if (now.kind == GPU_SHAPE_BOX) {
        now.direction = light.shape.direction;
        now.side = light.shape.side;
        now.size = light.shape.size;
    }
    bool changed = push.shapes.at[row] != now;
    if (changed) push.shapes.at[row] = now;
    uint exponent = floatBitsToUint(importance_of(push.list, row, light)) >> 23 & SHADOW_ROW_IMPORTANCE;
    push.rows.at[row] = exponent | (changed ? SHADOW_ROW_CHANGED : 0u);
}
