#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference_uvec2 : require
// Takes the lights out of a tile's list that give nothing to the surfaces in its 8x8 pixels: they do not reach them, or the maps show all of them in shadow.
#include "passes/shadow/requests_box.glsl"
#include "passes/shadow/pages.glsl"
#include "passes/shadow/dark_shared.h"

layout(local_size_x = 64) in;
layout(constant_id = 1) const uint SAMPLES = 1u;
layout(push_constant, scalar) uniform push_block { gpu_shadow_dark_push push; };

#include "passes/shadow/requests_group.glsl"

const uint MOST_PAGES = 4u, MOST_SQUARES = 16u;

// Whether the texels round all points of a rectangle of a page are nearer to the light than `depth`.
bool is_covered(gpu_shadow_maps maps, uint place, shadow_page at, vec2 low, vec2 high, float depth) {
    float last = float(shadow_page_size(at.level)) - 2.0;
    uvec2 origin = uvec2(place & 0xffffu, place >> 16u) * SHADOW_UNIT;
    uvec2 first = uvec2(clamp(shadow_page_texel(at, low) - 0.5, vec2(0.0), vec2(last))) + origin;
    uvec2 end = uvec2(clamp(shadow_page_texel(at, high) - 0.5, vec2(0.0), vec2(last))) + 1u + origin;
    uint size = SHADOW_DARK_BLOCK, base = 0u, limit = floatBitsToUint(depth);
    uvec2 squares = end / size - first / size + 1u;
    if (squares.x * squares.y > MOST_SQUARES) {
        if (at.level > SHADOW_SQUARE_LEVELS) return false; // smaller than the next squares
        base = (push.side / size) * (push.side / size);
        size = SHADOW_DARK_WIDE;
        squares = end / size - first / size + 1u;
        if (squares.x * squares.y > MOST_SQUARES) return false;
    }
    uvec2 from = first / size;
    uint across = push.side / size;
    for (uint y = 0u; y < squares.y; y++)
        for (uint x = 0u; x < squares.x; x++)
            if (!(push.least.at[base + (from.y + y) * across + from.x + x] > limit)) return false;
    return true;
}

// Whether no point of the box gets light, by map_visibility().
bool is_dark(gpu_shadow_maps maps, uint row, uint bias, gpu_shape shape, request_box box) {
    float least;
    uint faces = request_box_faces(shape, box, least);
    if (faces == 0u) return false;
    for (; faces != 0u; faces &= faces - 1u) {
        uint face = uint(findLSB(faces));
        request_seen s = request_box_seen(shape, box, face, least);
        uvec2 levels = min(request_seen_levels(shape, box, s) + bias, SHADOW_LEVELS - 1u);
        for (uint level = levels.x; level <= levels.y; level++) {
            uvec2 low, high, unused;
            shadow_pages_round(level, s.low, s.slack, low, unused);
            shadow_pages_round(level, s.high, s.slack, unused, high);
            uvec2 size = high - low + 1u;
            if (size.x * size.y > MOST_PAGES) return false;
            for (uint i = 0u; i < size.x * size.y; i++) {
                shadow_page at = shadow_page(face, level, low + uvec2(i % size.x, i / size.x));
                uint place;
                while (!shadow_find(maps, row, shadow_bit(face, at.level, at.at), place)) {
                    if (++at.level == SHADOW_LEVELS) return false;
                    at.at = min(at.at >> 1, uvec2(shadow_side(at.level) - 1u));
                }
                float texel = 2.0 / shadow_width(at.level), depth;
                if (shape.kind == GPU_SHAPE_BOX) {
                    float before = box.near + 0.5 * texel * max(shape.size.x, shape.size.y);
                    vec3 middle = 0.5 * (box.low + box.high) - shape.position, half_size = 0.5 * (box.high - box.low);
                    float along = dot(middle, shape.direction) - dot(half_size, abs(shape.direction));
                    depth = max(0.5 - 0.5 * along / shape.size.z + 0.5 * before / shape.size.z + 1e-6, 0.0);
                } else {
                    float along = s.along.x - box.near - 0.5 * texel * s.along.x;
                    if (!(along > 0.0)) return false;
                    depth = SHADOW_NEAR / along * 1.00001;
                }
                if (!is_covered(maps, place, at, s.low - s.slack, s.high + s.slack, depth)) return false;
            }
        }
    }
    return true;
}

bool stays(gpu_shadow_maps maps, uint light, request_box box) {
    lighting_block l = push.lighting;
    if (!request_box_reached(box, l.scope.lights.lights.at[light].shape)) return false;
    gpu_shape shape = request_shape(l, light);
    if (!light_casts(lights_of(l), light) || !shadow_has_map(shape)) return true;
    uint row = request_row(l, light), bias = maps.biases.at[row];
    return bias == SHADOW_TRACED || !is_dark(maps, row, bias, shape, box);
}

shared uint words[GROUP / 32u];

void main() {
    lighting_block l = push.lighting;
    uint thread = gl_LocalInvocationIndex, tile = gl_WorkGroupID.y * l.scope.list.list.tiles_x + gl_WorkGroupID.x;
    gpu_cell cell = l.scope.list.list.cells.at[tile];
    bool told = thread == 0u && uvec2(push.classes) != uvec2(0u);
    if (told) push.classes.at[2u * tile] = push.classes.at[2u * tile + 1u] = 0u;
    if (cell.count == GPU_CELL_ALL || cell.count == 0u) return;
    find_boxes();
    request_box whole = box_of(group_parts);
    uint_array ids = uint_array(l.scope.list.list.ids);
    gpu_shadow_maps maps = shadow_maps_block(l.scope.shadows.maps).maps;
    uint kept = 0u;
    for (uint first = 0u; first < cell.count && !is_empty(whole); first += GROUP) {
        if (thread < GROUP / 32u) words[thread] = 0u;
        barrier();
        uint at = first + thread, id = 0u;
        bool is_left = at < cell.count;
        if (is_left) {
            id = ids.at[cell.offset + at];
            is_left = stays(maps, l.scope.lights.directional_count + id, whole);
        }
        uint word = thread / 32u, bit = 1u << (thread % 32u);
        if (is_left) atomicOr(words[word], bit);
        barrier(); // everything of this batch has been read
        uint before = uint(bitCount(words[word] & (bit - 1u))) + (word > 0u ? uint(bitCount(words[0])) : 0u);
        if (is_left) ids.at[cell.offset + kept + before] = id;
        kept += uint(bitCount(words[0]) + bitCount(words[1]));
        barrier();
    }
    if (thread == 0u) {
        l.scope.list.list.cells.at[tile].count = kept;
        if (told) push.classes.at[2u * tile] = cell.count;
        if (told) push.classes.at[2u * tile + 1u] = cell.count - kept;
        atomicAdd(push.counts.counts.entries, cell.count);
        atomicAdd(push.counts.counts.dark, cell.count - kept);
    }
}
