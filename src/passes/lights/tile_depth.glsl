// SPDX-License-Identifier: MIT
// The depths of a tile, found by one work group. Included after the push constants (gpu_cells_push), which must say SAMPLES.
#ifndef TILE_DEPTH_GLSL
#define TILE_DEPTH_GLSL

// Eight columns, and as many rows as a subgroup has (tiled.c): barriers are cheap then, and few threads add their results by atomics.
layout(local_size_x = 8, local_size_y = 8, local_size_y_id = 2) in;
layout(constant_id = 3) const uint FLAGS = 0u; // CELLS_…

// Depth is reversed and not negative, so its bits order like the numbers: the greatest bits are the nearest.
shared uint tile_nearest, tile_farthest;

const float FAR_AWAY = 1e9;

// With more samples points are shaded between them or a little beyond: most of those are served by bounds that reach so much farther.
const float TILE_SLACK = SAMPLES > 1u ? 2e-2 : CELL_SLACK;

float tile_fetch(uint image, ivec2 pixel, int s) {
    return SAMPLES > 1u ? texelFetch(textures_multisampled[image], pixel, s).r : texelFetch(textures[image], pixel, 0).r;
}

// Stored depths of the nearest and the farthest surface that looks lights up at a sample; far 0: it may be as far as can be. False:
// nothing does. Blended surfaces lie between the nearest of them and what is opaque (ES-44).
bool tile_surfaces(ivec2 pixel, int s, out float near, out float far) {
    if (push.front == GPU_NO_DEPTH) {
        near = far = tile_fetch(push.depth, pixel, s);
        return near > 0.0;
    }
    near = tile_fetch(push.front, pixel, s);
    far = 0.0;
    if (near <= 0.0) return false; // mostly so: what is behind is not looked at
    far = tile_fetch(push.depth, pixel, s);
    return near > far;
}

// The tile's pixels.
uvec2 tile_first() { return gl_WorkGroupID.xy * push.list.list.tile_size; }
uvec2 tile_end() { return min(tile_first() + push.list.list.tile_size, push.view.view.size); }
uint tile_index() { return gl_WorkGroupID.y * push.list.list.tiles_x + gl_WorkGroupID.x; }

// View depths between which the tile's surfaces lie, or as the flags say. False: it has none. All of the group call this.
bool tile_depths(out float near, out float far) {
    near = 0.0;
    far = FAR_AWAY;
    if (push.depth == GPU_NO_DEPTH) return true;
    if (gl_LocalInvocationIndex == 0u) {
        tile_nearest = 0u;
        tile_farthest = 0xffffffffu;
    }
    barrier();
    uvec2 first = tile_first(), end = tile_end();
    uint near_bits = 0u, far_bits = 0xffffffffu;
    for (uint y = first.y + gl_LocalInvocationID.y; y < end.y; y += gl_WorkGroupSize.y)
        for (uint x = first.x + gl_LocalInvocationID.x; x < end.x; x += gl_WorkGroupSize.x)
            for (uint s = 0u; s < SAMPLES; s++) {
                float near_depth, far_depth;
                if (!tile_surfaces(ivec2(x, y), int(s), near_depth, far_depth)) continue;
                near_bits = max(near_bits, floatBitsToUint(near_depth));
                far_bits = min(far_bits, floatBitsToUint(far_depth));
            }
    if (near_bits != 0u) {
        atomicMax(tile_nearest, near_bits);
        atomicMin(tile_farthest, far_bits);
    }
    barrier();
    if ((FLAGS & CELLS_MIN_DEPTH) != 0u) near = view_depth_of(push.view, uintBitsToFloat(tile_nearest)) * (1.0 - TILE_SLACK);
    if ((FLAGS & CELLS_MAX_DEPTH) != 0u && tile_farthest != 0u)
        far = view_depth_of(push.view, uintBitsToFloat(tile_farthest)) * (1.0 + TILE_SLACK);
    return tile_nearest != 0u;
}

// The piece of the tile between two view depths; empty unless `used`.
gpu_cell_bounds tile_piece(float near, float far, bool used) {
    vec2 a = ndc_of_pixel(push.view, vec2(tile_first())), b = ndc_of_pixel(push.view, vec2(tile_end()));
    gpu_cell_bounds bounds = cell_bounds(push.view, vec2(a.x, b.y), vec2(b.x, a.y), near, far);
    if (!used) {
        bounds.low.z = 1.0;
        bounds.high.z = -1.0;
    }
    return bounds;
}

#endif
