// SPDX-License-Identifier: MIT
// Chooses lights by chance (GPU_LIGHTING_SAMPLED). Their weights, what each gives without shadows, stand side by side on a line as long as their sum, and
// shadow_rays marks at equal distances are laid on it, all shifted by one random number: systematic sampling (W. G. Madow, "On the Theory of Systematic
// Sampling, II", 1949). A light under a mark is sent one ray. Its chance to be chosen is p = min(1, shadow_rays * weight / sum), so that what it
// gives times visibility / p has the right mean, whatever the weights are, as long as they are positive where there is light.
//
// It takes two walks through the lights, for the sum and for the choice, and no memory for the chosen. Lights without weight take no part, so that
// all kinds of lists choose the same ones.
#ifndef SHADOWS_SAMPLED_GLSL
#define SHADOWS_SAMPLED_GLSL

#include "lights/iterate.glsl"
#include "shadows/guide_shared.h"

// Shaders that can do it define SHADOWS_GUIDED.
#ifdef SHADOWS_GUIDED
const bool LIGHTING_GUIDED = (LIGHTING_BITS & GPU_LIGHTING_GUIDED) != 0u;
layout(set = 0, binding = 2, r32ui) uniform uimage2D images_counted[];
#else
const bool LIGHTING_GUIDED = false;
#endif

struct light_draw {
    float scale;  // marks for each unit of weight; 0: all lights are chosen
    float shift;  // of the first mark, 0 .. 1 of their distance
    float passed; // sum of the weights so far
    float mark;   // the last mark that was passed, -1: none
    float last;   // of all marks
};

// 0 < x < 1. In neighbouring pixels, and in frames with neighbouring seeds, the numbers keep as far from each other as they can, so that errors average
// out: multiples of the plastic number's powers (M. Roberts, "The Unreasonable Effectiveness of Quasirandom Sequences", 2018) and of the golden ratio,
// as parts of 2^32.
float light_draw_number(uvec2 pixel, uint seed) {
    uint n = pixel.x * 3242174889u + pixel.y * 2447445414u + seed * 2654435769u;
    return (float(n >> 9) + 0.5) * (1.0 / 8388608.0);
}

// `sum` of the weights of `count` lights.
light_draw light_draw_begin(lighting_block l, uvec2 pixel, float sum, uint count) {
    uint rays = l.scope.shadows.ray_count;
    return light_draw(count <= rays ? 0.0 : float(rays) / sum, light_draw_number(pixel, l.scope.shadows.seed), 0.0, -1.0, float(rays) - 1.0);
}

// For each of the lights, in the order of the first walk, with its weight: what its light counts, 1 / p, or 0 where it is not chosen.
float light_draw_next(inout light_draw d, float weight) {
    if (d.scale == 0.0) return 1.0;
    precise float passed = d.passed + weight;
    float mark = min(floor(passed * d.scale - d.shift), d.last);
    bool chosen = mark > d.mark;
    d.passed = passed;
    d.mark = mark;
    return chosen ? max(1.0, 1.0 / (weight * d.scale)) : 0.0;
}

// Whether all marks are passed.
bool light_draw_done(light_draw d) { return d.scale != 0.0 && d.mark == d.last; }

// ---- guided (LIGHTING_GUIDED): weights are also by what the tile saw of the light (guide_shared.h) ----

struct light_guide {
    uint weights, seen; // images
    ivec2 tile;
};
light_guide guide; // the shader fills it in

light_guide guide_of(uint weights, uint seen, ivec2 pixel) { return light_guide(weights, seen, pixel / int(GUIDE_TILE)); }

// GUIDE_LEAST .. 1.
float guide_weight(uint light) {
    uint slot = light % GUIDE_SLOTS, texel = slot / 4u;
    return texelFetch(textures[guide.weights], guide.tile * int(GUIDE_SIDE / 2u) + ivec2(texel % (GUIDE_SIDE / 2u), texel / (GUIDE_SIDE / 2u)), 0)[slot % 4u];
}

// Denoised: the variance of the part of all light that is seen, as guides expect it, over that of unguided rays. The chance of a light to be seen is the square
// of its guide g, so that what is expected of it is f g^2, and the second moment of a ray the square of the sum of f g.
float guided_noise(float weights, float expected, float all) {
    float mean = expected / all, root = weights / all, unguided = mean * (1.0 - mean);
    return unguided > 1e-4 ? clamp((root * root - mean * mean) / unguided, GUIDE_SURE, 1.0) : 1.0;
}

// Of a ray that was sent to the light, what came through.
void guide_note(uint light, float passed) {
#ifdef SHADOWS_GUIDED
    uint slot = light % GUIDE_SLOTS;
    imageAtomicAdd(images_counted[guide.seen], guide.tile * int(GUIDE_SIDE) + ivec2(slot % GUIDE_SIDE, slot / GUIDE_SIDE),
                   GUIDE_UNIT << 16 | uint(round(clamp(passed, 0.0, 1.0) * float(GUIDE_UNIT))));
#endif
}

#endif
