// SPDX-License-Identifier: MIT
// Light at a part of the screen's resolution: which pixel of a square is lit for all of it.
#ifndef LIGHT_SCALE_GLSL
#define LIGHT_SCALE_GLSL

#include "view.glsl"

// Squares whose depths are farther apart than this hold an edge.
const float LIGHT_SCALE_EDGE = 1.05;

// Where in its square that pixel is on plain surfaces.
ivec2 light_sample_plain(int scale) { return ivec2((scale - 1) / 2); }

// On plain surfaces always the same pixel of the square, so that samples are evenly spaced. Where an edge runs through, the nearest and the
// farthest surface in turns: with its neighbours a square then has a sample of either.
ivec2 light_sample_pixel(view_block v, uint depths, ivec2 texel, int scale) {
    ivec2 first = texel * scale, end = min(first + scale, ivec2(v.view.size));
    ivec2 plain = min(first + light_sample_plain(scale), end - 1), nearest = plain, farthest = plain;
    float least = 3e38, most = 0.0;
    for (int y = first.y; y < end.y; y++)
        for (int x = first.x; x < end.x; x++) {
            float depth = texelFetch(textures[depths], ivec2(x, y), 0).r;
            if (depth <= 0.0) continue; // sky
            float view_depth = view_depth_of(v, depth);
            if (view_depth < least) {
                least = view_depth;
                nearest = ivec2(x, y);
            }
            if (view_depth > most) {
                most = view_depth;
                farthest = ivec2(x, y);
            }
        }
    if (most < least * LIGHT_SCALE_EDGE && texelFetch(textures[depths], plain, 0).r > 0.0) return plain;
    return ((texel.x + texel.y) & 1) == 0 ? nearest : farthest;
}

#endif
