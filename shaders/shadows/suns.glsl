// SPDX-License-Identifier: MIT
// The grids of directional lights: maps_shared.h says what they are. A grid goes by the logarithm to base 2 of the width of its texels in metres.
#ifndef SHADOWS_SUNS_GLSL
#define SHADOWS_SUNS_GLSL

#include "shadows/faces.glsl"

int shadow_sun_finest(gpu_shadow_sun sun) { return sun.coarsest - SHADOW_SUN_LEVELS + 1; }

// The coarsest grid whose texels are no wider than a pixel of so many metres, as far as there are grids.
int shadow_sun_grid(gpu_shadow_sun sun, float pixel) {
    int exponent = int(floatBitsToUint(pixel) >> 23 & 0xffu) - 127;
    return clamp(exponent, shadow_sun_finest(sun), sun.coarsest);
}

// Metres across a page and a block of a grid.
float shadow_sun_page(int grid) { return ldexp(float(SHADOW_PAGE - 2u * SHADOW_BORDER), grid); }
float shadow_sun_block(int grid) { return ldexp(float(SHADOW_BLOCK_TEXELS), grid); }

// The least of the blocks that have rows.
ivec2 shadow_sun_first(gpu_shadow_sun sun, int grid) {
    return ivec2(floor(sun.eye / shadow_sun_block(grid) + 0.5)) - SHADOW_SUN_SIDE / 2;
}

uint shadow_sun_row(uint sun, int grid, ivec2 block) {
    uint slot = uint(grid + 100 * SHADOW_SUN_LEVELS) % uint(SHADOW_SUN_LEVELS);
    uvec2 at = uvec2(block) % uint(SHADOW_SUN_SIDE);
    return sun * SHADOW_SUN_ROWS + (slot * uint(SHADOW_SUN_SIDE) + at.y) * uint(SHADOW_SUN_SIDE) + at.x;
}

// The box that the first face of a row shows: all casters between four sides along the light; `size` in meters.
gpu_shape shadow_sun_box(gpu_shadow_sun sun, vec2 size, ivec2 block) {
    vec2 center = (vec2(block) + 0.5) * size;
    gpu_shape s;
    s.position = center.x * sun.side + center.y * sun.up + sun.middle * sun.direction;
    s.size = vec3(0.5 * size, sun.reach);
    s.range = length(s.size);
    s.kind = GPU_SHAPE_BOX;
    s.hull_count = 0u;
    s.direction = sun.direction;
    s.spot_scale = 0.0;
    s.spot_offset = 0.0;
    s.side = sun.side;
    s.hull_first = 0u;
    return s;
}
gpu_shape shadow_sun_shape(gpu_shadow_sun sun, int grid, ivec2 block) { return shadow_sun_box(sun, vec2(shadow_sun_block(grid)), block); }

// ---- oblong blocks: texels are not square ----
// Surfaces at grazing angles to the light stretch square texels into strips. If a square texel is longer than
// OBLONG_LENGTH pixels on the screen, each axis has its own grid: the coarsest whose texels are no longer than that.
// Edges are off by half a texel at most.

const int OBLONG_LEVELS = 16;       // grids along an axis, from sun.coarsest down
const int OBLONG_RATIO = 7;         // levels by which the grids of the two axes may differ
const int OBLONG_WIDER = 1;         // levels by which they may be coarser than the square grid
const float OBLONG_LENGTH = 1.5;    // longest texel on the screen, pixels
const float OBLONG_LEAST = 1.0 / 128.0; // least cosine between normal and light; smaller ones count as this
const int OBLONG_FAR = 120;         // greatest distance of a named block from the viewer, in blocks
const uint OBLONG_ROUNDS = 8u;      // rows that a block tries, one per round

// Finds the grids along side and up for a point on a plane. `view`: unit direction toward the point; `pixel`: width of
// a pixel there across `view`, meters. False: use square texels.
bool shadow_oblong_grid(gpu_shadow_sun sun, vec3 view, vec3 normal, float pixel, out ivec2 grid) {
    float facing = dot(normal, sun.direction);
    grid = ivec2(shadow_sun_grid(sun, pixel));
    if (!(facing < 0.0)) return false;
    // Movement of a point on the plane per unit of movement across the light, then the part of it across the view.
    vec3 along = sun.direction / min(facing, -OBLONG_LEAST), side = sun.side - along * dot(normal, sun.side), up = sun.up - along * dot(normal, sun.up);
    side -= view * dot(view, side);
    up -= view * dot(view, up);
    vec2 width = OBLONG_LENGTH * pixel * inversesqrt(max(vec2(dot(side, side), dot(up, up)), vec2(1e-12)));
    int square = grid.x, finest = sun.coarsest - OBLONG_LEVELS + 1;
    if (!(min(width.x, width.y) < ldexp(1.0, square))) return false;
    grid = ivec2(floatBitsToUint(width.x) >> 23 & 0xffu, floatBitsToUint(width.y) >> 23 & 0xffu) - 127;
    grid = clamp(grid, ivec2(finest), ivec2(min(square + OBLONG_WIDER, sun.coarsest)));
    grid = max(grid, grid.yx - OBLONG_RATIO);
    return true;
}

vec2 shadow_oblong_block(ivec2 grid) { return ldexp(vec2(float(SHADOW_BLOCK_TEXELS)), grid); }

// The name of a page: the key of its block, then the page's number, 0 to 255, in the low 8 bits. 0: the block is too
// far from the viewer. Names contain the low bits of grids and positions, so they stay the same while the viewer
// moves.
uint shadow_oblong_name(gpu_shadow_sun sun, ivec2 grid, ivec2 page) {
    ivec2 block = page >> 4, from = block - ivec2(floor(sun.eye / shadow_oblong_block(grid)));
    if (any(greaterThan(abs(from), ivec2(OBLONG_FAR)))) return 0u;
    uint pages = uint(page.y & 15) << 4 | uint(page.x & 15);
    return uint(grid.x & 15) << 28 | uint(grid.y - grid.x + 8) << 24 | uint(block.x & 255) << 16 | uint(block.y & 255) << 8 | pages;
}
// The shape of a block; `key`: the name of one of its pages >> 8.
gpu_shape shadow_oblong_shape(gpu_shadow_sun sun, uint key) {
    int x = sun.coarsest - ((sun.coarsest - int(key >> 20)) & 15);
    ivec2 grid = ivec2(x, x + int(key >> 16 & 15u) - 8);
    vec2 size = shadow_oblong_block(grid);
    ivec2 eye = ivec2(floor(sun.eye / size)), from = (ivec2(key >> 8, key) - eye & 255) << 24 >> 24;
    return shadow_sun_box(sun, size, eye + from);
}

// The row that a block tries in a round, counted from the sun's first oblong row (oblong.comp.glsl). `key`: the name
// of one of the block's pages >> 8.
uint shadow_oblong_slot(uint key, uint round) {
    uint h = (key ^ round * 0x9e3779b9u) * 0x85ebca6bu;
    h = (h ^ h >> 13) * 0xc2b2ae35u;
    return (h ^ h >> 16) % SHADOW_SUN_OBLONGS;
}

#endif
