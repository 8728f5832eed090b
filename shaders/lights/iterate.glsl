// SPDX-License-Identifier: MIT
// The one loop over the lights of a pixel. Shading never knows which list it got:
//
//     light_cursor cursor = lights_begin(list, point);
//     FOR_EACH_LIGHT(list, cursor, light) { sum += ...list.list.lights.set.lights.at[light]...; }
//
// The kind of list is the specialization constant LIST_KIND. Every kind gives the lights in ascending order, so the sums are
// equal to the bit.
#ifndef LIGHTS_ITERATE_GLSL
#define LIGHTS_ITERATE_GLSL

#include "lighting/scopes.glsl"

// Items: turns of the loop, whatever the number of lights up to this; 0: as many as there are lights.
layout(constant_id = FIXED_LIGHTS_ID) const uint FIXED_LIGHTS = 0u;

// Who asks for lights: what a kind of list may find its cell by.
struct light_point {
    uvec2 pixel;
    float view_depth;
    vec3 position; // world space
    vec3 normal;   // world space; in deferred shading exactly the G-buffer's
    uint item;     // draw item; LIGHT_NO_ITEM in deferred shading
};
const uint LIGHT_NO_ITEM = 0xffffffffu;

uint slice_of(light_list_block l, float view_depth) {
    float slice = (l.list.linear == 1u ? view_depth : log2(view_depth)) * l.list.slice_scale + l.list.slice_bias;
    return uint(clamp(slice, 0.0, float(l.list.slices - 1u)));
}

uvec2 tile_of(light_list_block l, uvec2 pixel) { return min(pixel / l.list.tile_size, uvec2(l.list.tiles_x, l.list.tiles_y) - 1u); }

#include "lights/spare.glsl"
#include "lights/bins.glsl"
#include "lights/fine.glsl"
#include "lights/sparse.glsl"
#include "lights/tree.glsl"

struct light_cursor {
    uint next, end; // positions
    bool direct;    // a position is a light, not an index into ids
    uint turn;      // of FIXED_LIGHTS
    bool padding;   // this turn has no light
    bins_cursor bins; // of GPU_LIST_BINS alone
    fine_cursor fine; // of GPU_LIST_FINE alone
    tree_cursor tree; // of GPU_LIST_TREE alone
    uint depth;       // of GPU_LIST_RANGES alone: code of the view depth
    bool unserved;    // no cell serves the point: all lights are visited, or
    bool spared;      // those of the spare list, by
    spare_cursor spare;
};

light_cursor cursor_over(uint next, uint end, bool direct) {
    light_cursor c;
    c.next = next;
    c.end = end;
    c.direct = direct;
    c.turn = 0u;
    c.padding = false;
    c.unserved = c.spared = false;
    return c;
}

// For a point that no cell serves.
light_cursor cursor_over_spare(light_list_block l, light_point p) {
    light_cursor c = cursor_over(0u, l.list.local_count, true);
    c.unserved = true;
    c.spared = spare_begin(l, p.position, c.spare);
    return c;
}

// The cell of a grid in world space; those at its border reach on to infinity.
uint world_cell_of(light_list_block l, vec3 position) {
    vec3 at = (position - l.list.origin) * l.list.inverse_size;
    uvec3 size = uvec3(l.list.tiles_x, l.list.tiles_y, l.list.slices), cell = uvec3(0u);
    for (int k = 0; k < 3; k++)
        if (at[k] > 0.0) cell[k] = uint(min(at[k], float(size[k] - 1u))); // NaN: 0
    return (cell.z * size.y + cell.y) * size.x + cell.x;
}

uint cell_of_as(uint kind, light_list_block l, light_point p) {
    if (kind == GPU_LIST_WORLD) return world_cell_of(l, p.position);
    if (kind == GPU_LIST_ITEMS) return p.item;
    uvec2 tile = tile_of(l, p.pixel);
    if (kind == GPU_LIST_HALVES) {
        uint index = tile.y * l.list.tiles_x + tile.x;
        return p.view_depth < uintBitsToFloat(l.list.extra.at[index]) ? index : l.list.tiles_x * l.list.tiles_y + index;
    }
    uint slice = kind == GPU_LIST_CLUSTERS || kind == GPU_LIST_LINKS ? slice_of(l, p.view_depth) : 0u;
    return (slice * l.list.tiles_y + tile.y) * l.list.tiles_x + tile.x;
}

// The light of a node; moves on to the next one, or to GPU_NODE_END.
uint links_next(light_list_block l, inout uint node) {
    if (l.list.nodes == GPU_NODES_32) {
        uint word = l.list.ids.at[node];
        node = (word & GPU_NODE_32_END) == GPU_NODE_32_END ? GPU_NODE_END : word & GPU_NODE_32_END;
        return word >> 20;
    }
    uint light = l.list.ids.at[2u * node] & 0xffffffu;
    node = l.list.ids.at[2u * node + 1u];
    return light;
}

// Whether the list of a cell was made for a place like the point's; `seen` is in view space. What lies so little beyond the bounds loses no
// light to that: cells take lights that are a little farther away. Bounds that are not numbers hold everything, as where lights are tested.
bool cell_serves(uint kind, light_list_block l, uint cell, vec3 seen) {
    if (kind != GPU_LIST_TILES && kind != GPU_LIST_HALVES && kind != GPU_LIST_ITEMS) return true;
    gpu_cell_bounds b = l.list.bounds.at[cell];
    float slack = 5e-7 * (1.0 + length(seen));
    bool outside = any(lessThan(seen, b.low - slack)) || any(greaterThan(seen, b.high + slack));
    for (int i = 0; i < 4; i++) outside = outside || dot(b.planes[i].xyz, seen) + b.planes[i].w < -slack;
    if (kind == GPU_LIST_TILES && l.list.masks_depth == 1u)
        outside = outside || (l.list.extra.at[cell] >> depth_cell(b, -seen.z) & 1u) == 0u;
    return !outside;
}

light_cursor lights_begin_as(uint kind, light_list_block l, light_point p) {
    light_cursor c = cursor_over(0u, l.list.local_count, true);
    if (kind == GPU_LIST_ALL || kind == GPU_LIST_ITEMS && p.item >= l.list.tiles_x) return c;
    vec3 seen = vec3(0.0);
    bool served = true;
    if (LIST_SCATTERED && kind != GPU_LIST_WORLD) {
        view_block v = l.list.view;
        seen = (v.view.world_to_view * vec4(p.position, 1.0)).xyz;
        served = seen_on(v, seen, p.pixel);
        p.view_depth = served ? -seen.z : 1.0;
    }
    uvec2 tile = tile_of(l, p.pixel);
    if (kind == GPU_LIST_BINS) {
        served = served && bins_begin(l, tile.y * l.list.tiles_x + tile.x, p.view_depth, c.bins);
    } else if (kind == GPU_LIST_FINE) {
        c.direct = false;
        served = served && fine_begin(l, tile, p.pixel, p.position, c.fine);
    } else if (kind == GPU_LIST_LINKS) {
        uint first = const_uint_array(l.list.cells).at[cell_of_as(kind, l, p)];
        served = served && first != GPU_NODE_ALL;
        c = cursor_over(first, GPU_NODE_END, false);
    } else {
        uint index = 0u;
        if (kind == GPU_LIST_SPARSE) {
            uint bucket = l.list.buckets > 1u ? normal_bucket(p.normal) : 0u;
            bool found = sparse_find(l, sparse_key(l, tile, slice_of(l, p.view_depth), bucket), index);
            if (!found) index = 0u;
            served = served && found;
        } else {
            index = cell_of_as(kind, l, p);
        }
        gpu_cell cell = l.list.cells.at[index];
        served = served && cell.count != GPU_CELL_ALL;
        if (LIST_SCATTERED) served = served && cell_serves(kind, l, index, seen);
        c = cursor_over(cell.offset, cell.offset + cell.count, false);
        if (kind == GPU_LIST_RANGES) c.depth = depth_code(p.view_depth);
        if (kind == GPU_LIST_TREE) c.tree = tree_begin(cell, p.view_depth);
    }
    if (!served) c = cursor_over_spare(l, p);
    return c;
}

// Moves on; false at the end. `light` is an index into the set's lights.set.lights.
bool lights_next_as(uint kind, light_list_block l, inout light_cursor c, out uint light) {
    light = 0u;
    if (kind == GPU_LIST_ITEMS && FIXED_LIGHTS != 0u) {
        if (c.turn == FIXED_LIGHTS) return false;
        c.padding = c.next + c.turn >= c.end;
        light = l.list.directional_count + l.list.ids.at[min(c.next + c.turn, c.end - 1u)];
        c.turn++;
        return true;
    }
    if (kind != GPU_LIST_ALL && c.spared) {
        uint id;
        bool found = spare_next(l, c.spare, id);
        light = l.list.directional_count + id;
        return found;
    }
    if (kind == GPU_LIST_BINS && !c.unserved || (kind == GPU_LIST_FINE || kind == GPU_LIST_TREE) && !c.direct) {
        uint id;
        bool found = kind == GPU_LIST_BINS   ? bins_next(l, c.bins, id)
                     : kind == GPU_LIST_FINE ? fine_next(l, c.fine, id)
                                                  : tree_next(l, c.tree, id);
        light = l.list.directional_count + id;
        return found;
    }
    if (kind == GPU_LIST_RANGES && !c.direct)
        while (c.next < c.end && !depth_in_range(c.depth, l.list.extra.at[c.next])) c.next++;
    if (c.next >= c.end) return false;
    if (kind == GPU_LIST_LINKS && !c.direct) {
        light = l.list.directional_count + links_next(l, c.next);
        return true;
    }
    uint id = c.next++;
    if (!c.direct) id = l.list.ids.at[id];
    light = l.list.directional_count + id;
    return true;
}

// The list of the shader's kind. Those above take a kind that the caller knows, for other lists beside it.
uint cell_of(light_list_block l, light_point p) { return cell_of_as(LIST_KIND, l, p); }
light_cursor lights_begin(light_list_block l, light_point p) { return lights_begin_as(LIST_KIND, l, p); }
bool lights_next(light_list_block l, inout light_cursor c, out uint light) { return lights_next_as(LIST_KIND, l, c, light); }

#define FOR_EACH_LIGHT(list, cursor, light) for (uint light; lights_next(list, cursor, light);) if (!(cursor).padding)

// How many lights the loop visits for a point.
uint lights_count(light_list_block l, light_point p) {
    light_cursor c = lights_begin(l, p);
    uint count = 0u;
    FOR_EACH_LIGHT(l, c, light) count++;
    return count;
}

#endif
