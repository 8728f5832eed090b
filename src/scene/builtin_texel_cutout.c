/* SPDX-License-Identifier: MIT */
/* Surfaces with holes, and those that emit. */
#include "scene/builtin_texel.h"

static struct texel cutout(vec3 color, float alpha) {
    return (struct texel){.color = color, .roughness = 0.6f, .occlusion = 1, .alpha = alpha};
}

/** The nearest whole-period image of a distance on the unit torus. */
static float torus(float d) { return d - roundf(d); }

/** Overlapping pointed leaves, the later ones above the earlier. */
struct texel texel_leaves(float u, float v) {
    struct texel t = cutout(vec3_make(0.035f, 0.08f, 0.015f), 0);
    for (int i = 0; i < 44; i++) {
        float angle = 2 * PI * noise_hash(i, 2, 7), c = cosf(angle), s = sinf(angle),
              half = 0.075f + 0.03f * noise_hash(i, 3, 7);
        float dx = torus(u - noise_hash(i, 0, 7)), dy = torus(v - noise_hash(i, 1, 7));
        float along = (dx * c + dy * s) / half, across = (dy * c - dx * s) / half;
        if (fabsf(along) >= 1) continue;
        float width = 0.42f * (1 - along * along) * (1 - 0.25f * along), rib = fabsf(across);
        if (rib > width) continue;
        float vein =
            smooth_step(0.0f, 0.05f, rib) * (0.85f + 0.15f * smooth_step(0.0f, 0.3f, fabsf(sinf(9 * (along - 0.8f * rib)))));
        vec3 green = vec3_lerp(vec3_make(0.035f, 0.10f, 0.012f), vec3_make(0.13f, 0.20f, 0.03f), noise_hash(i, 4, 7));
        t = cutout(vec3_scale(green, 0.65f + 0.35f * vein), 1);
        t.height = 0.006f * (width - rib) + 0.0005f * (float)i;
        t.roughness = 0.42f + 0.15f * noise_hash(i, 5, 7);
    }
    return t;
}

/** Blades from the lower edge (v = 1) up, bending aside; does not repeat upwards. */
struct texel texel_grass(float u, float v) {
    float up = 1 - v;
    struct texel t = cutout(vec3_make(0.04f, 0.08f, 0.015f), 0);
    for (int i = 0; i < 34; i++) {
        float height = 0.45f + 0.53f * noise_hash(i, 1, 9), f = up / height;
        if (f >= 1) continue;
        float bend = 0.35f * (noise_hash(i, 2, 9) - 0.5f), middle = noise_hash(i, 0, 9) + bend * f * f;
        float width = (0.012f + 0.010f * noise_hash(i, 3, 9)) * (1 - f) + 0.002f, d = fabsf(torus(u - middle));
        if (d > width) continue;
        vec3 root = vec3_make(0.02f, 0.045f, 0.008f),
             tip = vec3_lerp(vec3_make(0.10f, 0.20f, 0.03f), vec3_make(0.24f, 0.24f, 0.07f), noise_hash(i, 4, 9));
        t = cutout(vec3_lerp(root, tip, f), 1);
        t.height = 0.004f * (1 - d / width);
        t.occlusion = 0.3f + 0.7f * f;
    }
    return t;
}

struct texel texel_marking(float u, float v) {
    float broad = noise_fractal(u, v, 6, 6, 4, 151), chip = noise_fractal(u, v, 48, 48, 3, 152),
          gone = smooth_step(0.56f, 0.66f, 0.5f * broad + 0.5f * chip);
    float shade = 0.5f + 0.2f * broad;
    return cutout(vec3_make(shade, shade, 0.95f * shade), 1 - gone);
}

static vec3 lamp_tint(float random) {
    if (random < 0.62f) return vec3_lerp(vec3_make(1, 0.58f, 0.26f), vec3_make(1, 0.78f, 0.5f), random / 0.62f);
    return random < 0.9f ? vec3_make(0.95f, 0.92f, 0.85f) : vec3_make(0.5f, 0.7f, 1);
}

/** 8 x 8 windows, a third of them lit, each dimmer toward its floor and sides; for buildings that are far away. */
struct texel texel_facade(float u, float v) {
    float x = u * 8, y = v * 8, fx = x - floorf(x), fy = y - floorf(y);
    int column = (int)x, row = (int)y;
    bool inside = fx > 0.26f && fx < 0.74f && fy > 0.18f && fy < 0.76f;
    bool bar = fabsf(fx - 0.5f) < 0.022f || fabsf(fy - 0.36f) < 0.02f;
    float wall = 0.32f + 0.16f * noise_fractal(u, v, 16, 16, 3, 161),
          ledge = fy > 0.76f && fy < 0.82f && fx > 0.2f && fx < 0.8f ? 1.35f : 1.0f;
    float belt = fy > 0.95f ? 0.72f : 1.0f;
    struct texel t = cutout(vec3_scale(vec3_make(1, 0.94f, 0.86f), wall * ledge * belt), 1);
    if (!inside) return t;
    t.color = bar ? vec3_make(0.4f, 0.38f, 0.35f) : vec3_make(0.02f, 0.022f, 0.027f);
    float random = noise_hash(column, row, 162);
    if (bar || random > 0.36f) return t;
    float curtain = noise_hash(column, row, 163) < 0.5f ? 0.35f + 0.65f * smooth_step(0.03f, 0.1f, fabsf(fx - 0.5f)) : 1.0f;
    float folds = 0.8f + 0.2f * sinf(fx * 90), fall = 1.1f - 0.7f * (fy - 0.18f) / 0.58f;
    t.emission = vec3_scale(lamp_tint(noise_hash(column, row, 164)), CLAMP(curtain * folds * fall, 0.0f, 1.0f));
    return t;
}

/** Pale wall colours by a random number. */
static vec3 paper_tint(float random) {
    const vec3 tints[] = {{0.9f, 0.6f, 0.45f}, {0.6f, 0.75f, 0.6f}, {0.55f, 0.65f, 0.9f}, {0.95f, 0.85f, 0.6f}};
    return tints[(int)(random * 8) % 4];
}

/** Is (x, y) in a box? */
static bool in_box(float x, float y, float x0, float y0, float x1, float y1) { return x > x0 && x < x1 && y > y0 && y < y1; }

/** Furniture as darker shapes before the back wall; y down, the floor at 1. */
static float furniture(float x, float y, int kind, int cell) {
    switch (kind) {
    case 0: /* shelves with books */
        if (!in_box(x, y, 0.15f, 0.3f, 0.55f, 1)) return 1;
        return fmodf(y, 0.14f) < 0.02f ? 0.25f : 0.25f + 0.5f * noise_hash((int)(x * 45), (int)(y / 0.14f), (uint32_t)cell);
    case 1: /* somebody */
        if (hypotf(x - 0.6f, (y - 0.48f) * 0.9f) < 0.085f) return 0.12f;
        return y > 0.57f && fabsf(x - 0.6f) < 0.11f + 0.12f * smooth_step(0.57f, 0.68f, y) ? 0.14f : 1;
    case 2: /* a plant on the sill */
        if (in_box(x, y, 0.24f, 0.86f, 0.4f, 1)) return 0.2f;
        return y > 0.5f && y < 0.88f && fabsf(x - 0.32f + 0.06f * sinf(22 * y)) < 0.05f + 0.06f * sinf(40 * y + 3) ? 0.22f
                                                                                                                   : 1;
    case 3: /* pictures and a cupboard */
        if (in_box(x, y, 0.2f, 0.32f, 0.42f, 0.52f) || in_box(x, y, 0.55f, 0.28f, 0.7f, 0.5f)) return 0.45f;
        return in_box(x, y, 0.5f, 0.72f, 0.92f, 1) ? 0.35f : 1;
    default:
        return 1;
    }
}

/** 4 x 4 rooms behind windows: a wall lit by a lamp, furniture before it, curtains at the sides. */
struct texel texel_rooms(float u, float v) {
    int column = (int)(u * 4), row = (int)(v * 4), cell = row * 4 + column;
    float x = u * 4 - (float)column, y = v * 4 - (float)row, random = noise_hash(cell, 0, 171);
    struct texel t = cutout(vec3_make(0.03f, 0.03f, 0.032f), 1);
    float lamp_x = 0.3f + 0.4f * noise_hash(cell, 1, 171), lamp_y = 0.12f + 0.15f * noise_hash(cell, 2, 171),
          d = hypotf(x - lamp_x, y - lamp_y);
    float wall = (0.30f + 0.5f / (1 + 9 * d * d)) * furniture(x, y, cell % 5, cell);
    vec3 paper = vec3_lerp(vec3_make(1, 0.95f, 0.88f), paper_tint(random), 0.5f);
    vec3 light = vec3_mul(vec3_scale(lamp_tint(noise_hash(cell, 3, 171)), wall), paper);
    if (d < 0.055f) light = vec3_make(1, 0.95f, 0.85f);
    float drawn = 0.12f + 0.3f * noise_hash(cell, 4, 171), side = fminf(x, 1 - x);
    if (cell % 3 != 1 && side < drawn) {
        float fold = 0.5f + 0.5f * sinf(75 * x + 4 * random);
        light =
            vec3_mul(vec3_scale(vec3_lerp(vec3_make(1, 0.85f, 0.6f), paper_tint(random + 0.4f), 0.6f), 0.22f + 0.3f * fold),
                     lamp_tint(noise_hash(cell, 3, 171)));
    }
    if (cell % 7 == 5)
        light = vec3_scale(vec3_mul(lamp_tint(0.3f), vec3_make(1, 0.9f, 0.75f)),
                           fmodf(y * 22, 1) < 0.75f ? 0.55f : 0.2f); /* a blind */
    t.emission = light;
    return t;
}
