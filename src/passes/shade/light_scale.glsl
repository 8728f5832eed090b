// SPDX-License-Identifier: MIT
// Light at a part of the screen's resolution: which pixel of a square is lit for all of it.
#ifndef LIGHT_SCALE_GLSL
#define LIGHT_SCALE_GLSL

#include "view.glsl"
#include "passes/shade/samples.glsl"

// Squares whose depths are farther apart than this hold an edge.
const float LIGHT_SCALE_EDGE = 1.05;

// Of a pixel with several samples light is summed up for the first.
const int LIGHT_SCALE_SAMPLE = SAMPLES > 1u ? 0 : -1;

float light_scale_depth(uint depths, ivec2 pixel) {
    return SAMPLES > 1u ? texelFetch(textures_multisampled[depths], pixel, 0).r : texelFetch(textures[depths], pixel, 0).r;
}

vec3 light_scale_position(view_block v, ivec2 pixel, float view_depth) {
    vec2 at = vec2(pixel) + (SAMPLES > 1u ? sample_place(0u) : vec2(0.5));
    return (v.view.view_to_world * vec4(view_position_of(v, ndc_of_pixel(v, at), view_depth), 1.0)).xyz;
}

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
            float depth = light_scale_depth(depths, ivec2(x, y));
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
    if (most < least * LIGHT_SCALE_EDGE && light_scale_depth(depths, plain) > 0.0) return plain;
    return ((texel.x + texel.y) & 1) == 0 ? nearest : farthest;
}

#endif
