#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// The cell and the list in which shading looked the lights of a pixel up, whatever kind of list it is. One work group, after inspect_lights.comp.glsl.
#include "common.glsl"
#include "view.glsl"
#include "lighting/reach.glsl"
#include "passes/debug/inspect.glsl"

layout(local_size_x = int(INSPECT_GROUP)) in;
layout(push_constant, scalar) uniform push_block { gpu_inspect_push push; };

shared uint reaching;

uint told_light(uint i) { return i < push.out_pixel.pixel.told ? push.out_pixel.lights[i].light : 0xffffffffu; }

// The cell of a point, and its place among them; INSPECT_NONE: lists are not in cells.
uint find_cell(light_list_block l, light_point p, out uvec3 place) {
    place = uvec3(tile_of(l, p.pixel), 0u);
    if (LIST_KIND == GPU_LIST_ALL || LIST_KIND == GPU_LIST_ITEMS && p.item >= l.list.tiles_x) {
        place = uvec3(0u);
        return INSPECT_NONE;
    }
    uint tile = place.y * l.list.tiles_x + place.x;
    if (LIST_KIND == GPU_LIST_FINE) return l.list.first_cell + tile;
    if (LIST_KIND == GPU_LIST_BINS) {
        place.z = bins_slice(l, p.view_depth);
        return tile;
    }
    if (LIST_KIND == GPU_LIST_SPARSE) {
        uint cell, bucket = l.list.buckets > 1u ? normal_bucket(p.normal) : 0u;
        place.z = slice_of(l, p.view_depth);
        return sparse_find(l, sparse_key(l, place.xy, place.z, bucket), cell) ? cell : INSPECT_NONE;
    }
    uint cell = cell_of(l, p);
    if (LIST_KIND == GPU_LIST_ITEMS) {
        place = uvec3(0u);
    } else if (LIST_KIND == GPU_LIST_WORLD) {
        place.x = cell % l.list.tiles_x;
        place.y = cell / l.list.tiles_x % l.list.tiles_y;
        place.z = cell / l.list.tiles_x / l.list.tiles_y;
    } else {
        place.z = cell / (l.list.tiles_x * l.list.tiles_y);
    }
    return cell;
}

void main() {
    uint lane = gl_LocalInvocationIndex, flags = push.out_pixel.pixel.flags;
    if ((flags & INSPECT_HIT) == 0u || push.skips_layered == 1u && (flags & INSPECT_LAYERED) != 0u) return;
    vec3 position = push.out_pixel.pixel.position;
    light_point point = light_point(push.pixel, push.out_pixel.pixel.view_depth, position, push.out_pixel.pixel.normal, push.out_pixel.pixel.item);
    uvec4 told = uvec4(told_light(lane), told_light(lane + INSPECT_GROUP), told_light(lane + 2u * INSPECT_GROUP), told_light(lane + 3u * INSPECT_GROUP));
    uvec4 listed = uvec4(lessThan(told, uvec4(push.lighting.scope.lights.directional_count)));
    uint visited = 0u;
    if (lane == 0u) reaching = 0u;
    barrier();
    light_cursor cursor = lights_begin(list_of(push.lighting), point);
    bool unserved = cursor.unserved;
    FOR_EACH_LIGHT(list_of(push.lighting), cursor, light) {
        visited++;
        listed |= uvec4(equal(told, uvec4(light)));
        if (light % INSPECT_GROUP == lane && light_reaches(lights_of(push.lighting), light, position)) atomicAdd(reaching, 1u);
    }
    for (uint i = 0u; i < 4u; i++)
        if (told[i] != 0xffffffffu) push.out_pixel.lights[lane + i * INSPECT_GROUP].listed = listed[i];
    barrier();
    if (lane != 0u) return;
    uvec3 place;
    push.out_pixel.pixel.cell = find_cell(list_of(push.lighting), point, place);
    push.out_pixel.pixel.cell_place = place;
    push.out_pixel.pixel.visited = visited;
    push.out_pixel.pixel.listed_reaching = reaching;
    push.out_pixel.pixel.flags = flags | INSPECT_LISTED | (unserved ? INSPECT_UNSERVED : 0u);
}
