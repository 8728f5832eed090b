// SPDX-License-Identifier: MIT
// Finds the oblong block of a sun in which a point is sampled. The block depends on the plane of the surface, which
// the depth image gives around the point's pixel. Request passes and shading use the same plane, so they agree.
#ifndef SHADOWS_OBLONG_GLSL
#define SHADOWS_OBLONG_GLSL

#include "lights/iterate.glsl"
#include "shadows/suns.glsl"

// A page: the grids of its block, its position counted in pages across all blocks, and its name.
struct shadow_oblong {
    ivec2 grid, page;
    uint name;
};

// Finds the page of a point on a plane. False: use square texels.
bool shadow_oblong_on(gpu_shadow_sun sun, view_block v, vec3 position, vec3 normal, float pixel, out shadow_oblong o) {
    vec3 view = v.view.orthographic > 0.5 ? -v.view.view_to_world[2].xyz : normalize(position - v.view.eye);
    o.name = 0u;
    if (!shadow_oblong_grid(sun, view, normal, pixel, o.grid)) return false;
    o.page = ivec2(floor(vec2(dot(position, sun.side), dot(position, sun.up)) * 16.0 / shadow_oblong_block(o.grid)));
    o.name = shadow_oblong_name(sun, o.grid, o.page);
    return o.name != 0u;
}

// Finds the row of a page. False: the page is not in use.
bool shadow_oblong_find(gpu_shadow_maps maps, uint sun, uint name, out uint row) {
    uint key = name >> 8, page = name & 255u;
    for (uint round = 0u; round < OBLONG_ROUNDS; round++) {
        uint slot = sun * SHADOW_SUN_OBLONGS + shadow_oblong_slot(key, round), found = maps.keys.at[slot * SHADOW_OBLONG_WORDS];
        row = SHADOW_SUN_SQUARES + slot + sun * SHADOW_SUN_SQUARES;
        if (found == key) return (maps.keys.at[slot * SHADOW_OBLONG_WORDS + 1u + page / 32u] >> page % 32u & 1u) != 0u;
        if (found == 0u) return false; // the block would have taken this row
    }
    return false;
}

// Finds the page of a visible point, and its row. False: square texels suffice, the plane of the surface is unknown,
// or the page is not in use.
bool shadow_oblong_at(gpu_shadow_maps maps, view_block v, uint sun, vec3 position, float pixel, out shadow_oblong o, out uint row) {
    row = 0u;
    if (maps.planes_across == 0u) return false;
    uvec2 at = pixel_of(v, (v.view.world_to_view * vec4(position, 1.0)).xyz);
    uint plane = maps.planes.at[at.y * maps.planes_across + at.x];
    if (plane == 0u) return false;
    return shadow_oblong_on(maps.suns.at[sun], v, position, octahedral_decode(unpackSnorm2x16(plane)), pixel, o) &&
           shadow_oblong_find(maps, sun, o.name, row);
}

#endif
