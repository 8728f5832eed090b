#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference_uvec2 : require
// How important each light is, and whether it is what it was when its pages were drawn.
#include "lights/iterate.glsl"
#include "shadows/suns.glsl"
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
float importance_of(lighting_block l, uint row, gpu_light light) {
    gpu_entity_bounds bounds = l.scope.lights.entities.at[row];
    float away = l.scope.view.view.orthographic > 0.5 ? 1.0 : max(distance(bounds.center, l.scope.view.view.eye), bounds.radius);
    float size = bounds.radius / max(away, 1e-20);
    return max(flux_of(light) * size * size, 0.0);
}

// What the pages of a local light depend on; nothing else, or they would be drawn again when that changes.
gpu_shape shape_of(gpu_shape s) {
    s.hull_count = s.hull_first = 0u;
    s.spot_scale = s.spot_offset = 0.0;
    if (s.kind != GPU_SHAPE_BOX) s.direction = s.side = s.size = vec3(0.0);
    return s;
}

// The shape of the block that has a row of a sun. A row without a block keeps the shape of its last block, so its
// pages stay until they are needed again.
gpu_shape shape_of_row(gpu_shadow_sun sun, uint index, uint row) {
    if (row >= SHADOW_SUN_SQUARES) {
        uint key = uvec2(push.keys) != uvec2(0u) ? push.keys.at[(index * SHADOW_SUN_OBLONGS + row - SHADOW_SUN_SQUARES) * SHADOW_OBLONG_WORDS] : 0u;
        if (key != 0u) return shadow_oblong_shape(sun, key);
        return push.shapes.at[index * SHADOW_SUN_ROWS + row];
    }
    uint slot = row / uint(SHADOW_SUN_SIDE * SHADOW_SUN_SIDE), levels = uint(SHADOW_SUN_LEVELS), side = uint(SHADOW_SUN_SIDE);
    int grid = sun.coarsest - int((uint(sun.coarsest + 100 * SHADOW_SUN_LEVELS) - slot) % levels);
    ivec2 first = shadow_sun_first(sun, grid);
    uvec2 at = uvec2(row, row / side) - uvec2(first);
    return shadow_sun_shape(sun, grid, first + ivec2(at % side));
}

// hull_count says whether the maps are drawn on request, and that a request is another one.
uint update_of(uint light) { return uvec2(push.updates) != uvec2(0u) ? push.updates.at[light] : 0u; }

void main() {
    uint row = LINEAR_INVOCATION;
    if (row >= push.row_count) return;
    gpu_shape now;
    float importance;
    if (row < push.sun_rows) {
        uint index = row / SHADOW_SUN_ROWS;
        gpu_shadow_sun sun = push.suns.at[index];
        now = shape_of_row(sun, index, row % SHADOW_SUN_ROWS);
        now.hull_count = update_of(index);
        float radius = ldexp(SHADOW_SUN_REACH, sun.coarsest); // its light falls on all of this
        importance = luminance(push.lighting.scope.lights.lights.at[index].color) * PI * radius * radius;
    } else {
        uint local = row - push.sun_rows;
        gpu_light light = push.lighting.scope.lights.lights.at[push.lighting.scope.lights.directional_count + local];
        now = shape_of(light.shape);
        now.hull_count = update_of(push.lighting.scope.lights.directional_count + local);
        importance = importance_of(push.lighting, local, light);
    }
    bool changed = push.shapes.at[row] != now;
    if (changed) push.shapes.at[row] = now;
    uint exponent = max(floatBitsToUint(max(importance, 0.0)) >> 23 & SHADOW_ROW_IMPORTANCE, SHADOW_SPARE + 1u);
    if (row < push.sun_rows && row % SHADOW_SUN_ROWS >= SHADOW_SUN_SQUARES) exponent = SHADOW_SPARE;
    push.rows.at[row] = exponent | (changed ? SHADOW_ROW_CHANGED : 0u);
}
