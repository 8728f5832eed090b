#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// One triangle in one tile: the slices that it covers there, as raster_shell.comp.glsl finds them.
#include "common.glsl"
#include "passes/lights/raster.glsl"

layout(location = 0) flat in vec3 in_a;
layout(location = 1) flat in vec3 in_b;
layout(location = 2) flat in vec3 in_c;
layout(location = 3) flat in uvec2 in_light;

void main() {
    uint index = in_light.x;
    shell s = shell_of(index, RASTER.bounds.at[index], 0.0);
    uvec2 tile = uvec2(gl_FragCoord.xy);
    if (any(lessThan(tile, s.first_tile)) || any(greaterThan(tile, s.last_tile))) return;
    polygon p = visible_part(in_a, in_b, in_c);
    if (p.count == 0u) return;
    p = row_part(s, p, tile.y);
    vec2 depths = tile_depths(s, p, tile.x);
    if (p.count == 0u || depths.x > depths.y) return;
    span found = span_of(s, depths, in_light.y == 1u);
    uvec2 at = tile - s.first_tile;
    uint slot = RASTER.slot_sums.at[index] + at.y * (s.last_tile.x - s.first_tile.x + 1u) + at.x;
    atomicMin(RASTER.slots.at[slot].first, found.first);
    atomicMin(RASTER.slots.at[slot].last, found.last);
}
