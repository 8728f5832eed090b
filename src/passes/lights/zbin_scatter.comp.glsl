#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Every light goes to the tiles and bins that it touches: a work group takes the 32 lights of a word and deals their cells out to its
// threads. The first time which words there are is noted, the second time the words are filled. Bits are or'ed together, so the order of
// the threads does not matter.
#include "common.glsl"
#include "passes/lights/zbin.glsl"

layout(local_size_x = 64) in;
layout(constant_id = 1) const uint FILL = 0u;

shared gpu_bound lights[32];
shared uvec4 tiles[32];  // first column and row, columns and rows
shared uvec2 bins[32];   // first, count
shared uint begins[33];  // cells of the lights before

// Tangents of the two view rays that touch a circle, in a plane through the view axis; infinite where they do not cross the screen.
// cf. Mara & McGuire 2013, 2D Polyhedral Bounds of a Clipped, Perspective-Projected 3D Sphere.
vec2 tangents(float across, float depth, float radius) {
    float far2 = across * across + depth * depth - radius * radius;
    if (!(far2 > 0.0)) return vec2(-1e30, 1e30); // the viewer is in it
    float side = sqrt(far2);
    vec2 low = vec2(across * side - depth * radius, depth * side + across * radius);
    vec2 high = vec2(across * side + depth * radius, depth * side - across * radius);
    return vec2(low.y > 0.0 ? low.x / low.y : -1e30, high.y > 0.0 ? high.x / high.y : 1e30);
}

// First and last tile of an axis; `at` is what the screen's plane is cut at, at depth 1.
uvec2 tile_range(vec2 at, float scale, float offset, bool down, float size, uint tile_count) {
    vec2 part = ((at - offset) / scale) * (down ? -0.5 : 0.5) + 0.5;
    float a = min(part.x, part.y) * size - 0.25, b = max(part.x, part.y) * size + 0.25;
    float tile_size = float(push.list.list.tile_size), last = float(tile_count - 1u);
    // NaN takes all.
    uint first = a > 0.0 ? uint(min(floor(a / tile_size), last)) : 0u;
    uint end = b < size ? uint(clamp(floor(b / tile_size), 0.0, last)) : tile_count - 1u;
    return uvec2(min(first, end), end);
}

void take_light(uint lane, gpu_bound light) {
    view_block v = push.view;
    float radius = light.radius * (1.0 + CELL_SLACK) + CELL_SLACK * (1e-2 + length(light.center) * 1e-2);
    float depth = -light.center.z;
    vec2 x = vec2(light.center.x - radius, light.center.x + radius), y = vec2(light.center.y - radius, light.center.y + radius);
    if (v.view.orthographic <= 0.5) {
        x = tangents(light.center.x, depth, radius);
        y = tangents(light.center.y, depth, radius);
    }
    uvec2 columns = tile_range(x, v.view.ndc_scale.x, v.view.ndc_offset.x, false, float(v.view.size.x), push.list.list.tiles_x);
    uvec2 rows = tile_range(y, v.view.ndc_scale.y, v.view.ndc_offset.y, true, float(v.view.size.y), push.list.list.tiles_y);
    float near = (depth - radius) * (1.0 - CELL_SLACK), far = (depth + radius) * (1.0 + CELL_SLACK);
    uint first_bin = near > 0.0 ? bins_slice(push.list, near) : 0u;
    uint last_bin = far < 1e30 ? bins_slice(push.list, far) : push.list.list.slices - 1u;
    tiles[lane] = uvec4(columns.x, rows.x, columns.y - columns.x + 1u, rows.y - rows.x + 1u);
    bins[lane] = uvec2(first_bin, max(last_bin, first_bin) - first_bin + 1u);
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
        for (uint i = 0u; i < 32u; i++) {
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
        uint cell;
        if (at < range.z * range.w) {
            uvec2 tile = range.xy + uvec2(at % range.z, at / range.z);
            if (!touches_tile(tile, lights[lane])) continue;
            cell = tile.y * push.list.list.tiles_x + tile.x;
        } else {
            cell = tile_count + bins[lane].x + (at - range.z * range.w);
        }
        bins_cell c = zbin_cell(cell);
        uint record = c.records + group * 2u;
        if (FILL == 0u) {
            atomicOr(push.table.at[record + 1u], word_bit);
            atomicOr(push.table.at[c.tops + group / 32u], 1u << (group % 32u));
        } else if (push.table.at[c.state] != BINS_ALL) {
            if ((push.table.at[record + 1u] & word_bit) == 0u) continue; // two shaders may round a touch differently
            uint place = push.table.at[record] + uint(bitCount(push.table.at[record + 1u] & (word_bit - 1u)));
            atomicOr(push.pool.at[place], 1u << lane);
        }
    }
}
