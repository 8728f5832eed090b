// SPDX-License-Identifier: MIT
// Which block of a sun's texels that are not square a point is looked up in: its surface decides, as the depth image shows it round the point's pixel. Passes
// that ask for pages and those that look them up both take it from there, so that they agree.
#ifndef SHADOWS_OBLONG_GLSL
#define SHADOWS_OBLONG_GLSL

#include "lights/iterate.glsl"
#include "shadows/suns.glsl"

// The grids of a block, which of its pages it is, as if blocks lay side by side, and the page's name.
struct shadow_oblong {
    ivec2 grid, page;
    uint name;
};

// Of a point of a plane. False: square texels do.
bool shadow_oblong_on(gpu_shadow_sun sun, view_block v, vec3 position, vec3 normal, float pixel, out shadow_oblong o) {
    vec3 view = v.view.orthographic > 0.5 ? -v.view.view_to_world[2].xyz : normalize(position - v.view.eye);
    o.name = 0u;
    if (!shadow_oblong_grid(sun, view, normal, pixel, o.grid)) return false;
    o.page = ivec2(floor(vec2(dot(position, sun.side), dot(position, sun.up)) * 16.0 / shadow_oblong_block(o.grid)));
    o.name = shadow_oblong_name(sun, o.grid, o.page);
    return o.name != 0u;
}

// The row in which a page is, if it is in use.
bool shadow_oblong_find(gpu_shadow_maps maps, uint sun, uint name, out uint row) {
    uint key = name >> 8, page = name & 255u;
    for (uint round = 0u; round < OBLONG_ROUNDS; round++) {
        uint slot = sun * SHADOW_SUN_OBLONGS + shadow_oblong_slot(key, round), found = maps.keys.at[slot * SHADOW_OBLONG_WORDS];
        row = SHADOW_SUN_SQUARES + slot + sun * SHADOW_SUN_SQUARES;
        if (found == key) return (maps.keys.at[slot * SHADOW_OBLONG_WORDS + 1u + page / 32u] >> page % 32u & 1u) != 0u;
        if (found == 0u) return false; // it would have it
    }
    return false;
}

// Of a point that is seen. False: square texels do, or nothing is known of its surface, or too few pixels need the page.
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
