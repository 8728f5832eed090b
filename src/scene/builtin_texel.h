/* SPDX-License-Identifier: MIT */
/** The procedural surfaces, point by point; builtin_texture.c makes pictures of them. */
#ifndef FNL_SCENE_BUILTIN_TEXEL_H
#define FNL_SCENE_BUILTIN_TEXEL_H

#include "base/base.h"
#include "base/maths.h"

/** What a surface is at one point. */
struct texel {
    vec3 color;   /* linear albedo */
    float height; /* metres */
    float roughness, metallic, occlusion, alpha;
    vec3 emission; /* linear, 0..1; the material's factor gives cd/m^2 */
};

/** (u, v) in [0, 1)^2, v downwards; periodic in both. */
typedef struct texel texel_function(float u, float v);

/* ---- noise that repeats after whole periods; deterministic ---- */

float noise_hash(int x, int y, uint32_t seed); /* 0..1 per lattice point */
/** Smooth noise of `columns` x `rows` cells, 0..1. */
float noise_value(float u, float v, int columns, int rows, uint32_t seed);
/** Sum of octaves, each of double frequency and half strength, 0..1. */
float noise_fractal(float u, float v, int columns, int rows, int octaves, uint32_t seed);
/** Distances in cells to the nearest and second nearest of one random point per cell; `id` is the nearest's own. */
struct noise_cell {
    float first, second, id;
};
struct noise_cell noise_cells(float u, float v, int columns, int rows, uint32_t seed);
/** 0 below `low`, 1 above `high`, smooth between. */
float smooth_step(float low, float high, float x);

texel_function texel_asphalt, texel_paving, texel_concrete, texel_brick, texel_plaster, texel_stone, texel_sandstone,
    texel_marble, texel_tiles, texel_wood, texel_bark, texel_ground, texel_fabric, texel_metal;
texel_function texel_leaves, texel_grass, texel_marking, texel_facade, texel_rooms;

#endif
