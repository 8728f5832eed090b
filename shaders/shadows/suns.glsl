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

// What the first face of a row shows: all that casts between four sides along the light.
gpu_shape shadow_sun_shape(gpu_shadow_sun sun, int grid, ivec2 block) {
    float size = shadow_sun_block(grid);
    vec2 center = (vec2(block) + 0.5) * size;
    gpu_shape s;
    s.position = center.x * sun.side + center.y * sun.up + sun.middle * sun.direction;
    s.size = vec3(0.5 * size, 0.5 * size, sun.reach);
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

#endif
