#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// The rectangle of tiles and the range of slices that each light in view can touch, and how many slots its shell takes: none where it lies
// in one tile. A light whose place is not a number touches everything.
#include "common.glsl"
#include "passes/lights/raster.glsl"

layout(local_size_x = 64) in;

// Slopes between which a sphere lies along one axis.
vec2 sphere_slopes(float center, float depth, float radius) {
    if (RASTER.view.view.orthographic > 0.5) return vec2(center - radius, center + radius);
    if (!(depth > radius * 1.02)) return vec2(-3e38, 3e38);
    float root = radius * sqrt(max(center * center + depth * depth - radius * radius, 0.0)), scale = depth * depth - radius * radius;
    vec2 slopes = vec2(center * depth - root, center * depth + root) / scale;
    return slopes + vec2(-1e-4, 1e-4) * (slopes.y - slopes.x) + vec2(-2e-6, 2e-6) * abs(slopes);
}

// First | last << 16; "first > last" where slopes leave the screen.
uint tile_range(vec2 slopes, int axis, uint count) {
    vec2 tiles = slope_tiles(slopes, axis);
    if (tiles.x > float(count - 1u) || tiles.y < 0.0) return 1u;
    return uint(tiles.x > 0.0 ? tiles.x : 0.0) | (tiles.y < float(count - 1u) ? uint(tiles.y) : count - 1u) << 16;
}

void main() {
    uint index = LINEAR_INVOCATION, count = RASTER.visible_sums.at[RASTER.light_count];
    if (index == 0u) {
        RASTER.arguments.at[0] = min(count, 32768u); // as gpu_dispatch_linear makes them
        RASTER.arguments.at[1] = (count + 32767u) / 32768u;
        RASTER.arguments.at[2] = 1u;
        RASTER.arguments.at[3] = 3u * GPU_CONE_TRIANGLES; // and VkDrawIndexedIndirectCommand
        RASTER.arguments.at[4] = count;
        RASTER.arguments.at[5] = RASTER.arguments.at[6] = RASTER.arguments.at[7] = 0u;
    }
    if (index > RASTER.light_count) return;
    RASTER.slot_sums.at[index] = 0u;
    if (index >= count) return;
    gpu_bound bound = RASTER.bounds.at[index];
    light_mesh mesh = mesh_of(RASTER.visible_ids.at[index]);
    float margin = light_margin(bound), radius = bound.radius + margin, depth = -bound.center.z;
    vec2 depths = vec2(depth - radius, depth + radius);
    vec2 x = sphere_slopes(bound.center.x, depth, radius), y = sphere_slopes(bound.center.y, depth, radius);
    if (mesh.kind == MESH_CONE || mesh.kind == MESH_BOX) {
        vec2 mesh_depths = vec2(3e38, -3e38), mesh_x = mesh_depths, mesh_y = mesh_depths;
        for (uint i = 0u; i < mesh.vertex_count; i++) {
            vec3 p = mesh_vertex(mesh, i);
            mesh_depths = vec2(min(mesh_depths.x, p.z), max(mesh_depths.y, p.z));
            vec2 slopes = p.xy / max(depth_scale(p), 1e-30);
            mesh_x = vec2(min(mesh_x.x, slopes.x), max(mesh_x.y, slopes.x));
            mesh_y = vec2(min(mesh_y.x, slopes.y), max(mesh_y.y, slopes.y));
        }
        mesh_depths += vec2(-margin, margin);
        depths = vec2(max(depths.x, mesh_depths.x), min(depths.y, mesh_depths.y));
        bool orthographic = RASTER.view.view.orthographic > 0.5;
        if (orthographic || mesh_depths.x > RASTER.near) {
            float slack = (orthographic ? margin : margin / mesh_depths.x) + 1e-6;
            x = vec2(max(x.x, mesh_x.x - slack), min(x.y, mesh_x.y + slack));
            y = vec2(max(y.x, mesh_y.x - slack), min(y.y, mesh_y.y + slack));
        }
    }
    uint tiles_x = RASTER.list.list.tiles_x, tiles_y = RASTER.list.list.tiles_y, slots = 0u;
    gpu_raster_light light = gpu_raster_light((tiles_x - 1u) << 16, (tiles_y - 1u) << 16, (RASTER.list.list.slices - 1u) << 16);
    bool broken = isnan(depth + radius) || isinf(depth + radius) || isnan(bound.center.x + bound.center.y);
    if (!broken) {
        light.columns = depths.y < RASTER.near ? 1u : tile_range(x, 0, tiles_x);
        light.rows = tile_range(y, 1, tiles_y);
        light.slices = near_slice(depths.x, 0.0) | far_slice(depths.y, 0.0) << 16;
        uvec2 low = uvec2(light.columns, light.rows) & 0xffffu, high = uvec2(light.columns >> 16, light.rows >> 16);
        uvec2 size = high + 1u - low;
        bool one = low == high && mesh.kind != MESH_OWN && x.x >= column_slope(low.x) && x.y <= column_slope(low.x + 1u) &&
                   y.x >= row_slope(low.y + 1u) && y.y <= row_slope(low.y);
        if (all(lessThanEqual(low, high)) && !one) slots = size.x * size.y;
    }
    RASTER.lights.at[index] = light;
    RASTER.slot_sums.at[index] = slots;
}
