#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Debug views: surface attributes, the heat map of light counts with its legend, cells, overdraw.
#include "common.glsl"
#include "view.glsl"
#include "lights/iterate.glsl"
#include "passes/lights/backface.glsl"
#include "passes/debug/debug_shared.h"
#include "passes/debug/legend.glsl"
#include "passes/shade/coarse_shared.h"
#include "passes/shade/edges_shared.h"

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform push_block { gpu_debug_push push; };

// From a word of passes/shade/edges_shared.h: grey for one surface, a colour for several things.
vec3 edge_color(uint word, float grey) {
    const vec3 colors[5] = vec3[](vec3(0.0), DEBUG_EDGE_SKY(vec3), DEBUG_EDGE_2(vec3), DEBUG_EDGE_3(vec3), DEBUG_EDGE_4(vec3));
    uint surfaces = 0u;
    bool edge = false;
    for (uint i = 0u; i < push.view.view.samples; i++) {
        uint found = word >> (SURFACE_BITS * i) & SURFACE_NONE;
        edge = edge || found != (word & SURFACE_NONE);
        if (found != SURFACE_NONE) surfaces = max(surfaces, found + 1u);
    }
    return edge ? colors[min(surfaces, 4u)] : vec3(grey * 0.5);
}

// The largest depth of the surfaces in the pixel's tile over the smallest; 1: there is none. Lists without tiles: squares of 16 pixels.
float depth_ratio(ivec2 pixel) {
    bool has_tiles = LIST_KIND != GPU_LIST_ALL && LIST_KIND != GPU_LIST_WORLD && LIST_KIND != GPU_LIST_ITEMS;
    int size = has_tiles ? int(push.lights.list.tile_size) : 16;
    ivec2 first = pixel / size * size, end = min(first + size, ivec2(push.view.view.size));
    float least = 3e38, most = 0.0;
    for (int y = first.y; y < end.y; y++)
        for (int x = first.x; x < end.x; x++) {
            float depth = texelFetch(textures[push.normal], ivec2(x, y), 0).w;
            if (!(depth > 0.0)) continue;
            least = min(least, depth);
            most = max(most, depth);
        }
    return most > 0.0 ? most / least : 1.0;
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(uvec2(pixel), push.view.view.size))) return;
    vec4 albedo = texelFetch(textures[push.albedo], pixel, 0), normal = texelFetch(textures[push.normal], pixel, 0);
    bool sky = normal.w <= 0.0;
    float grey = sky ? 0.0 : 0.12 + 0.88 * luminance(albedo.rgb) * (0.6 + 0.4 * normal.y);
    vec3 color = vec3(0.0);
    uint mode = push.mode;
    if (mode == GPU_DEBUG_ALBEDO) color = srgb_encode(clamp(albedo.rgb, 0.0, 1.0));
    if (mode == GPU_DEBUG_NORMAL) color = sky ? vec3(0.0) : normal.xyz * 0.5 + 0.5;
    if (mode == GPU_DEBUG_DEPTH) color = sky ? vec3(0.0) : vec3(1.0 / (1.0 + 0.05 * normal.w));
    if (mode == GPU_DEBUG_ROUGHNESS) color = sky ? vec3(0.0) : vec3(albedo.a);
    uint counted = 0u;
    if (push.count_stride != 0u) counted = push.counts.at[(uint(pixel.y) * push.view.view.size.x + uint(pixel.x)) * push.count_stride];
    if (mode == GPU_DEBUG_OVERDRAW) color = heat(count_level(counted)) * float(counted != 0u);
    if (mode == GPU_DEBUG_OVERSHADING && counted != 0u)
        color = heat((log2(float(counted) / float(GPU_OVERSHADING_UNIT)) + 1.0) / float(DEBUG_COUNT_PARTS)); // as count_level() has whole numbers
    if (mode == GPU_DEBUG_LAYERS || mode == GPU_DEBUG_DECALS) color = counted == 0u ? vec3(grey) * 0.5 : mix(vec3(grey), heat(count_level(counted)), 0.8);
    if (mode == GPU_DEBUG_EDGES) color = push.count_stride != 0u ? edge_color(counted, grey) : vec3(grey * 0.5);
    if (mode == GPU_DEBUG_HALOS) {
        vec2 metal = texelFetch(textures[push.metal], pixel, 0).xy;
        color = metal.x >= 0.9 ? mix(vec3(grey), DEBUG_METAL(vec3), 0.6) : vec3(grey * 0.5);
        if (metal.x > 0.1 && metal.x < 0.9) color = mix(DEBUG_HALO_DARK(vec3), DEBUG_HALO_BRIGHT(vec3), min(4.0 * metal.y, 1.0));
    }
    if (mode == GPU_DEBUG_COARSE || mode == GPU_DEBUG_COARSE_REASON) {
        const vec3 kinds[COARSE_KINDS] = vec3[](vec3(0.0), DEBUG_COARSE_SHARED(vec3), DEBUG_COARSE_DEPTH(vec3), DEBUG_COARSE_NORMAL(vec3),
                                                DEBUG_COARSE_OTHER(vec3), DEBUG_COARSE_EACH(vec3), DEBUG_COARSE_HALF(vec3));
        bool is_shown = counted != COARSE_NOTHING && (mode == GPU_DEBUG_COARSE_REASON || counted == COARSE_SHARED || counted > COARSE_OTHER);
        color = is_shown ? mix(vec3(grey), kinds[min(counted, COARSE_KINDS - 1u)], 0.5) : vec3(grey);
    }
    if (mode == GPU_DEBUG_CLUSTERS || mode == GPU_DEBUG_TRIANGLES) {
        vec3 hue = abs(fract(float(counted >> 8 & 0xffffu) / 65536.0 + vec3(0.0, 0.333, 0.667)) * 6.0 - 3.0) - 1.0;
        color = counted < 2u ? vec3(grey * 0.5) : mix(vec3(grey), clamp(hue, 0.0, 1.0), 0.65);
    }
    if (mode == GPU_DEBUG_DEPTH_JUMPS) {
        float ratio = depth_ratio(pixel);
        color = ratio < GPU_JUMP_LEAST ? vec3(grey) * 0.5 : mix(vec3(grey), heat(log2(ratio) / GPU_JUMP_OCTAVES), 0.8);
    }
    if (mode == GPU_DEBUG_LIGHT_COUNT || mode == GPU_DEBUG_CELLS) {
        vec4 position = texelFetch(textures[push.position], pixel, 0);
        light_point point = light_point(uvec2(pixel), sky ? 1.0 : normal.w, position.xyz, normal.xyz, uint(position.w) - 1u);
        uint count = sky && LIST_KIND != GPU_LIST_TILES ? 0u : lights_count(push.lights, point);
        if (push.count_stride != 0u) count = counted;
        vec3 map = count == 0u ? vec3(0.0) : heat(count_level(count));
        color = mode == GPU_DEBUG_LIGHT_COUNT ? mix(vec3(grey), map, 0.8) : vec3(grey) * 0.5;
        if (mode == GPU_DEBUG_CELLS && LIST_KIND != GPU_LIST_ALL) {
            uint tile_size = push.lights.list.tile_size;
            bool by_place = LIST_KIND == GPU_LIST_WORLD || LIST_KIND == GPU_LIST_ITEMS; // not by pixel
            if ((LIST_KIND == GPU_LIST_CLUSTERS || LIST_KIND == GPU_LIST_BINS || LIST_KIND == GPU_LIST_SPARSE || by_place) && !sky) {
                uint slice = by_place ? cell_of(push.lights, point) : slice_of(push.lights, normal.w);
                if (LIST_KIND == GPU_LIST_SPARSE && push.lights.list.buckets > 1u) slice += 7u * normal_bucket(normal.xyz);
                vec3 hue = abs(fract(float(slice) * 0.381966 + vec3(0.0, 0.333, 0.667)) * 6.0 - 3.0) - 1.0;
                color = mix(color, clamp(hue, 0.0, 1.0), 0.45);
            } else if (LIST_KIND == GPU_LIST_HALVES && !sky) {
                bool near_half = cell_of(push.lights, point) < push.lights.list.tiles_x * push.lights.list.tiles_y;
                color = mix(color, near_half ? vec3(1.0, 0.45, 0.1) : vec3(0.1, 0.45, 1.0), 0.45);
            } else {
                color = mix(color, map, 0.45);
            }
            if (by_place) tile_size = 0xffffffffu;
            if (uint(pixel.x) % tile_size == 0u || uint(pixel.y) % tile_size == 0u) color = mix(color, vec3(1.0), 0.35);
        }
    }
    if (mode == GPU_DEBUG_TILE_NORMALS || mode == GPU_DEBUG_BACKFACES) {
        color = vec3(grey) * 0.5;
        if (push.has_cones == 1u) {
            uvec2 tile = tile_of(push.lights, uvec2(pixel));
            gpu_cone cone = push.cones.at[tile.y * push.lights.list.tiles_x + tile.x];
            vec3 map = cone.dropped == 0u ? vec3(0.0) : heat(count_level(cone.dropped));
            color = mode == GPU_DEBUG_BACKFACES ? mix(vec3(grey), map, 0.8) : cone.axis == vec3(0.0) ? vec3(0.0) : cone.axis * 0.5 + 0.5;
        }
    }
    if (mode == GPU_DEBUG_LIGHT_COUNT || mode == GPU_DEBUG_OVERDRAW || mode == GPU_DEBUG_BACKFACES || mode == GPU_DEBUG_OVERSHADING ||
        mode == GPU_DEBUG_LAYERS || mode == GPU_DEBUG_DECALS) {
        vec3 key;
        if (count_legend(pixel, ivec2(push.view.view.size), key)) color = key;
    }
    imageStore(images[push.target], pixel, push.swap == 1u ? vec4(color.bgr, 1.0) : vec4(color, 1.0));
}
