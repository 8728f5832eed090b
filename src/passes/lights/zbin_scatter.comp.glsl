#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
// Every light goes to the tiles, of each zone, and the bins that it touches: a work group takes the 32 lights of a word and deals their cells out to its
// threads. The first time which words there are is noted, the second time the words are filled. Bits are or'ed together, so the order of
// the threads does not matter.
#include "common.glsl"
#include "passes/lights/zbin.glsl"
#include "passes/lights/light_tiles.glsl"

layout(local_size_x = 64) in;
layout(constant_id = 1) const uint FILL = 0u;

shared gpu_bound lights[32];
shared uvec4 tiles[32];  // first column and row, columns and rows
shared uvec2 bins[32];   // first, count
shared uvec2 zones[32];
shared uint begins[33];  // cells of the lights before

void take_light(uint lane, gpu_bound light) {
    vec2 depths;
    uvec4 range = tiles_of_light(push.view, light, push.list.list.tile_size, uvec2(push.list.list.tiles_x, push.list.list.tiles_y), depths);
    float near = depths.x, far = depths.y;
    uint first_bin = near > 0.0 ? bins_slice(push.list, near) : 0u;
    uint last_bin = far < 1e30 ? bins_slice(push.list, far) : push.list.list.slices - 1u;
    tiles[lane] = uvec4(range.xy, range.zw - range.xy + 1u);
    last_bin = max(last_bin, first_bin);
    bins[lane] = uvec2(first_bin, last_bin - first_bin + 1u);
    uint first_zone = first_bin / push.list.list.zone_slices;
    zones[lane] = uvec2(first_zone, last_bin / push.list.list.zone_slices - first_zone + 1u);
    lights[lane] = light;
    begins[lane] = tiles[lane].z * tiles[lane].w + bins[lane].y;
}

// The part of the tile's frustum that is as deep as the light.
bool touches_tile(uvec2 tile, gpu_bound light) {
    float tile_size = float(push.list.list.tile_size), reach = light.radius * 1.001 + 1e-3 + abs(light.center.z) * 1e-3;
    vec2 first = vec2(tile) * tile_size, end = min(first + tile_size, vec2(push.view.view.size));
    vec2 a = ndc_of_pixel(push.view, first), b = ndc_of_pixel(push.view, end);
    float depth = -light.center.z, near = depth - reach, far = depth + reach;
    if (push.view.view.orthographic <= 0.5) near = max(near, 0.0);
    gpu_cell_bounds bounds = cell_bounds(push.view, vec2(a.x, b.y), vec2(b.x, a.y), near, far);
    return cell_touches(bounds, light);
}

void put(bins_cell c, uint group, uint word_bit, uint bit) {
    uint record = c.records + group * 2u;
    if (FILL == 0u) {
        atomicOr(push.table.at[record + 1u], word_bit);
        atomicOr(push.table.at[c.tops + group / 32u], 1u << (group % 32u));
    } else if (push.table.at[c.state] != BINS_ALL && (push.table.at[record + 1u] & word_bit) != 0u) { // two shaders may round a touch differently
        uint place = push.table.at[record] + uint(bitCount(push.table.at[record + 1u] & (word_bit - 1u)));
        atomicOr(push.pool.at[place], bit);
    }
}

void main() {
    uint word = LINEAR_GROUP, thread = gl_LocalInvocationIndex, count = visible_count();
    if (word * 32u >= count) return; // the whole group
    if (thread < 32u) {
        begins[thread] = 0u;
        if (word * 32u + thread < count) take_light(thread, push.bounds.at[word * 32u + thread]);
    }
    barrier();
    if (thread == 0u) {
        uint sum = 0u;
        [[dont_unroll]] for (uint i = 0u; i < 32u; i++) {
            uint cells = begins[i];
            begins[i] = sum;
            sum += cells;
        }
        begins[32] = sum;
    }
    barrier();
    uint tile_count = push.list.list.tiles_x * push.list.list.tiles_y, group = word / 32u, word_bit = 1u << (word % 32u);
    for (uint i = thread; i < begins[32]; i += 64u) {
        uint lane = 0u; // the last light whose cells begin at or before i
        for (uint step = 16u; step > 0u; step /= 2u)
            if (begins[lane + step] <= i) lane += step;
        uint at = i - begins[lane];
        uvec4 range = tiles[lane];
        uint cell, copies = 1u; // cells that are tile_count apart
        if (at < range.z * range.w) {
            uvec2 tile = range.xy + uvec2(at % range.z, at / range.z);
            if (!touches_tile(tile, lights[lane])) continue;
            cell = zones[lane].x * tile_count + tile.y * push.list.list.tiles_x + tile.x;
            copies = zones[lane].y;
        } else {
            cell = tile_count * bins_zones(push.list) + bins[lane].x + (at - range.z * range.w);
        }
        for (uint copy = 0u; copy < copies; copy++) put(zbin_cell(cell + copy * tile_count), group, word_bit, 1u << lane);
    }
}
