/* SPDX-License-Identifier: MIT */
/* Noise, and the solid surfaces. Albedos are of the order of measured ones: asphalt 0.05, brick 0.2, plaster 0.6. */
#include "scene/builtin_texel.h"

/* ---- noise ---- */

static uint32_t mix_bits(uint32_t x) {
    x = (x ^ (x >> 16)) * 0x7feb352du;
    x = (x ^ (x >> 15)) * 0x846ca68bu;
    return x ^ (x >> 16);
}

static uint32_t lattice_bits(int x, int y, uint32_t seed) {
    return mix_bits((uint32_t)x * 0x9e3779b9u + (uint32_t)y * 0x85ebca6bu + (seed + 1) * 0xc2b2ae35u);
}

float noise_hash(int x, int y, uint32_t seed) { return (float)(lattice_bits(x, y, seed) >> 8) * 0x1p-24f; }

/** Quick when x is in range, as it nearly always is. */
static int wrap(int x, int period) {
    if (x >= 0 && x < period) return x;
    int r = x % period;
    return r < 0 ? r + period : r;
}

float smooth_step(float low, float high, float x) {
    float t = CLAMP((x - low) / (high - low), 0.0f, 1.0f);
    return t * t * (3 - 2 * t);
}

float noise_value(float u, float v, int columns, int rows, uint32_t seed) {
    float x = u * (float)columns, y = v * (float)rows, fx = floorf(x), fy = floorf(y);
    int x0 = wrap((int)fx, columns), y0 = wrap((int)fy, rows);
    int x1 = x0 + 1 == columns ? 0 : x0 + 1, y1 = y0 + 1 == rows ? 0 : y0 + 1;
    float s = x - fx, t = y - fy;
    s = s * s * (3 - 2 * s);
    t = t * t * (3 - 2 * t);
    float low = noise_hash(x0, y0, seed) * (1 - s) + noise_hash(x1, y0, seed) * s;
    float high = noise_hash(x0, y1, seed) * (1 - s) + noise_hash(x1, y1, seed) * s;
    return low * (1 - t) + high * t;
}

float noise_fractal(float u, float v, int columns, int rows, int octaves, uint32_t seed) {
    float sum = 0, weight = 0.5f, total = 0;
    for (int i = 0; i < octaves; i++, weight *= 0.5f) {
        sum += weight * noise_value(u, v, columns << i, rows << i, seed + (uint32_t)i);
        total += weight;
    }
    return sum / total;
}

struct noise_cell noise_cells(float u, float v, int columns, int rows, uint32_t seed) {
    float x = u * (float)columns, y = v * (float)rows, first = 9, second = 9;
    int cx = (int)floorf(x), cy = (int)floorf(y), nearest_x = 0, nearest_y = 0;
    for (int j = cy - 1; j <= cy + 1; j++)
        for (int i = cx - 1; i <= cx + 1; i++) {
            int wx = wrap(i, columns), wy = wrap(j, rows);
            uint32_t bits = lattice_bits(wx, wy, seed);
            float dx = (float)i + (float)(bits & 0xffff) * 0x1p-16f - x, dy = (float)j + (float)(bits >> 16) * 0x1p-16f - y;
            float d = dx * dx + dy * dy;
            if (d < first) {
                second = first;
                first = d;
                nearest_x = wx;
                nearest_y = wy;
            } else {
                second = fminf(second, d);
            }
        }
    return (struct noise_cell){sqrtf(first), sqrtf(second), noise_hash(nearest_x, nearest_y, seed + 1)};
}

/* ---- masonry: rows of blocks with joints ---- */

struct block {
    float edge;   /* metres to the nearest joint line */
    float random; /* of this block */
    float x, y;   /* metres from its low corner */
    int column, row;
};

/** Blocks of width/columns by height/rows metres, every other row shifted by `shift` blocks. */
static struct block find_block(float u, float v, int columns, int rows, float width, float height, float shift,
                               uint32_t seed) {
    int row = (int)floorf(v * (float)rows);
    float x = u * (float)columns + (row & 1 ? shift : 0), y = v * (float)rows;
    int column = (int)floorf(x);
    float w = width / (float)columns, h = height / (float)rows, bx = (x - (float)column) * w, by = (y - (float)row) * h;
    int wrapped = wrap(column, columns);
    return (struct block){fminf(fminf(bx, w - bx), fminf(by, h - by)), noise_hash(wrapped, row, seed), bx, by, wrapped, row};
}

static vec3 gray(float x) { return vec3_make(x, x, x); }

static struct texel solid(vec3 color, float height, float roughness, float occlusion) {
    return (struct texel){.color = color, .height = height, .roughness = roughness, .occlusion = occlusion, .alpha = 1};
}

struct texel texel_asphalt(float u, float v) {
    float broad = noise_fractal(u, v, 3, 3, 4, 11), grain = noise_value(u, v, 256, 256, 12);
    struct noise_cell stone = noise_cells(u, v, 128, 128, 13);
    float worn = noise_fractal(u, v, 6, 6, 3, 14), crack = fabsf(noise_fractal(u, v, 5, 5, 5, 15) - 0.5f);
    float puddle = smooth_step(0.50f, 0.57f, broad), damp = smooth_step(0.33f, 0.50f, broad);
    float open = smooth_step(0.0f, 0.006f, crack);
    float albedo = (0.035f + 0.025f * stone.id + 0.015f * grain) * (0.75f + 0.4f * worn) * (0.5f + 0.5f * open);
    albedo *= 1 - 0.45f * damp;
    float height = 0.0018f * (1 - stone.first) * (1 - 0.7f * damp) + 0.004f * open;
    struct texel t = solid(gray(albedo), height * (1 - 0.97f * puddle), 0, 1);
    t.color = vec3_mul(t.color, vec3_make(1, 1, 1.06f));
    float wet = 0.19f + 0.07f * grain + 0.08f * worn - 0.07f * damp;
    t.roughness = wet + (0.07f - wet) * puddle;
    return t;
}

struct texel texel_paving(float u, float v) {
    struct block slab = find_block(u, v, 4, 4, 2.4f, 2.4f, 0.5f, 21);
    float joint = smooth_step(0.004f, 0.011f, slab.edge), fine = noise_value(u, v, 200, 200, 22),
          broad = noise_fractal(u, v, 4, 4, 4, 23);
    float albedo = (0.20f + 0.10f * slab.random + 0.06f * (fine - 0.5f)) * (0.7f + 0.5f * broad);
    float tilt = (noise_hash(slab.column, slab.row, 24) - 0.5f) * 0.006f * (slab.x - 0.3f);
    float stain = smooth_step(0.55f, 0.7f, noise_fractal(u, v, 7, 7, 3, 25));
    struct texel t = solid(gray(albedo * (0.35f + 0.65f * joint) * (1 - 0.3f * stain)),
                           0.006f * joint + tilt + 0.0012f * fine, 0.62f - 0.3f * stain + 0.1f * fine, 0.6f + 0.4f * joint);
    t.color = vec3_mul(t.color, vec3_make(1.03f, 1, 0.95f));
    return t;
}

struct texel texel_concrete(float u, float v) {
    float broad = noise_fractal(u, v, 3, 3, 5, 31), fine = noise_value(u, v, 128, 128, 32);
    struct noise_cell pit = noise_cells(u, v, 28, 28, 33);
    float hole = pit.id > 0.8f ? 1 - smooth_step(0.06f, 0.14f, pit.first) : 0;
    float seam = 1 - smooth_step(0.004f, 0.012f, fabsf(v - 0.5f) * 4) * smooth_step(0.004f, 0.012f, fminf(u, 1 - u) * 4);
    float streak = noise_value(u, 0.5f, 40, 1, 34) * noise_value(u, v, 20, 3, 35);
    float albedo =
        (0.22f + 0.18f * broad + 0.04f * (fine - 0.5f)) * (1 - 0.5f * hole) * (1 - 0.3f * seam) * (1 - 0.25f * streak);
    return solid(vec3_scale(vec3_make(1.0f, 0.98f, 0.95f), albedo), 0.001f * fine - 0.008f * hole - 0.004f * seam,
                 0.75f + 0.15f * fine, 1 - 0.4f * hole);
}

struct texel texel_brick(float u, float v) {
    struct block brick = find_block(u, v, 8, 24, 1.92f, 1.92f, 0.5f, 41);
    float rough = noise_fractal(u, v, 48, 48, 3, 42),
          joint = smooth_step(0.003f, 0.009f, brick.edge - 0.004f * (rough - 0.4f));
    float burnt = smooth_step(0.8f, 0.95f, brick.random), pale = noise_hash(brick.column, brick.row, 43),
          dirt = noise_fractal(u, v, 3, 3, 3, 44);
    vec3 clay = vec3_lerp(vec3_make(0.28f, 0.085f, 0.05f), vec3_make(0.36f, 0.15f, 0.085f), pale);
    clay = vec3_lerp(clay, vec3_make(0.09f, 0.05f, 0.045f), burnt);
    vec3 color =
        vec3_scale(vec3_lerp(vec3_make(0.26f, 0.24f, 0.21f), clay, joint), (0.75f + 0.4f * rough) * (0.75f + 0.4f * dirt));
    return solid(color, 0.008f * joint + 0.002f * rough + 0.003f * (brick.random - 0.5f) * joint, 0.78f + 0.15f * rough,
                 0.55f + 0.45f * joint);
}

struct texel texel_plaster(float u, float v) {
    float broad = noise_fractal(u, v, 2, 2, 5, 51), fine = noise_fractal(u, v, 48, 48, 2, 52);
    float streak = smooth_step(0.5f, 0.9f, noise_value(u, v, 24, 2, 53)) * noise_value(u, v, 6, 6, 54);
    float albedo = (0.55f + 0.2f * broad) * (1 - 0.25f * streak) * (0.95f + 0.1f * fine);
    return solid(gray(albedo), 0.0022f * fine + 0.004f * broad, 0.8f + 0.1f * fine, 0.9f + 0.1f * fine);
}

struct texel texel_stone(float u, float v) {
    struct block block = find_block(u, v, 4, 8, 3.2f, 3.2f, 0.5f, 61);
    float rough = noise_fractal(u, v, 32, 32, 4, 62), joint = smooth_step(0.006f, 0.022f, block.edge),
          broad = noise_fractal(u, v, 3, 3, 3, 63);
    float albedo = (0.33f + 0.14f * block.random) * (0.75f + 0.35f * rough) * (0.8f + 0.3f * broad) * (0.5f + 0.5f * joint);
    vec3 color =
        vec3_lerp(vec3_make(1, 0.94f, 0.83f), vec3_make(0.9f, 0.92f, 0.95f), noise_hash(block.column, block.row, 64));
    return solid(vec3_scale(color, albedo), 0.014f * joint + 0.004f * rough, 0.72f + 0.2f * rough, 0.6f + 0.4f * joint);
}

struct texel texel_sandstone(float u, float v) {
    float bend = noise_fractal(u, v, 2, 2, 3, 71), strata = noise_value(0.5f, v + 0.06f * bend, 1, 24, 72),
          fine = noise_fractal(u, v, 40, 40, 2, 73);
    vec3 color = vec3_lerp(vec3_make(0.52f, 0.40f, 0.27f), vec3_make(0.66f, 0.55f, 0.40f), 0.5f * strata + 0.5f * bend);
    return solid(vec3_scale(color, 0.85f + 0.25f * fine), 0.0016f * fine + 0.001f * strata, 0.7f + 0.15f * fine, 1);
}

/** Dark veins where a warped noise crosses its middle. */
static float marble_veins(float u, float v, uint32_t seed) {
    float wu = noise_fractal(u, v, 3, 3, 4, seed), wv = noise_fractal(u, v, 3, 3, 4, seed + 10);
    float crossing = fabsf(noise_fractal(u + 0.35f * wu, v + 0.35f * wv, 3, 3, 4, seed + 20) - 0.5f);
    return 1 - smooth_step(0.0f, 0.09f, crossing);
}

struct texel texel_marble(float u, float v) {
    float vein = marble_veins(u, v, 81), cloud = noise_fractal(u, v, 4, 4, 4, 85);
    vec3 color =
        vec3_lerp(vec3_make(0.72f, 0.70f, 0.66f), vec3_make(0.34f, 0.34f, 0.36f), 0.7f * vein * cloud + 0.15f * cloud);
    return solid(color, 0, 0.16f + 0.08f * cloud, 1);
}

struct texel texel_tiles(float u, float v) {
    struct block tile = find_block(u, v, 4, 4, 2, 2, 0, 91);
    float joint = smooth_step(0.002f, 0.006f, tile.edge),
          vein = marble_veins(u + 0.37f * tile.random, v + 0.61f * tile.random, 92);
    float diamond = fabsf(tile.x - 0.25f) + fabsf(tile.y - 0.25f), inlay = 1 - smooth_step(0.098f, 0.102f, diamond);
    float ring = smooth_step(0.128f, 0.131f, diamond) - smooth_step(0.138f, 0.141f, diamond);
    bool dark = (tile.column + tile.row) & 1;
    vec3 base = dark ? vec3_make(0.13f, 0.055f, 0.04f) : vec3_make(0.60f, 0.53f, 0.42f);
    vec3 other = dark ? vec3_make(0.58f, 0.50f, 0.38f) : vec3_make(0.10f, 0.13f, 0.11f);
    vec3 color = vec3_lerp(base, other, fmaxf(inlay, ring));
    color = vec3_scale(vec3_lerp(color, vec3_make(0.4f, 0.38f, 0.34f), 0.35f * vein), 0.8f + 0.3f * tile.random);
    float scuff = noise_fractal(u, v, 10, 10, 4, 98);
    return solid(vec3_scale(color, 0.4f + 0.6f * joint), 0.003f * joint, 0.13f + 0.22f * scuff + 0.4f * (1 - joint),
                 0.7f + 0.3f * joint);
}

struct texel texel_wood(float u, float v) {
    struct block plank = find_block(u, v, 8, 1, 1.2f, 1.2f, 0, 101);
    float shift = plank.random, side = fminf(plank.x, 0.15f - plank.x), gap = smooth_step(0.001f, 0.004f, side);
    float bend = noise_fractal(u, v, 8, 2, 3, 102),
          ring = 0.5f + 0.5f * sinf(2 * PI * (6 * (plank.x / 0.15f) + 5 * bend + 7 * shift));
    float fibre = noise_value(u, v, 256, 6, 103);
    vec3 color = vec3_lerp(vec3_make(0.16f, 0.075f, 0.03f), vec3_make(0.30f, 0.16f, 0.075f), 0.55f * ring + 0.45f * fibre);
    return solid(vec3_scale(color, (0.8f + 0.4f * shift) * (0.3f + 0.7f * gap)), 0.003f * gap + 0.0005f * fibre,
                 0.45f + 0.2f * fibre, 0.7f + 0.3f * gap);
}

struct texel texel_bark(float u, float v) {
    float warp = noise_fractal(u, v, 4, 4, 3, 111);
    struct noise_cell plate = noise_cells(u + 0.05f * warp, v, 14, 5, 112);
    float crack = smooth_step(0.02f, 0.3f, plate.second - plate.first), fine = noise_fractal(u, v, 32, 16, 3, 113);
    vec3 color =
        vec3_scale(vec3_lerp(vec3_make(0.035f, 0.025f, 0.018f), vec3_make(0.17f, 0.13f, 0.095f), crack), 0.6f + 0.7f * fine);
    return solid(color, 0.02f * crack + 0.004f * fine, 0.85f + 0.1f * fine, 0.4f + 0.6f * crack);
}

struct texel texel_ground(float u, float v) {
    float broad = noise_fractal(u, v, 4, 4, 4, 121), fine = noise_fractal(u, v, 64, 64, 2, 122),
          blade = noise_value(u, v, 256, 64, 123);
    vec3 soil = vec3_make(0.075f, 0.05f, 0.03f),
         lawn = vec3_lerp(vec3_make(0.03f, 0.065f, 0.014f), vec3_make(0.075f, 0.12f, 0.03f), blade);
    float grown = smooth_step(0.35f, 0.5f, broad + 0.15f * (fine - 0.5f));
    return solid(vec3_scale(vec3_lerp(soil, lawn, grown), 0.7f + 0.5f * fine), 0.012f * fine + 0.01f * blade * grown, 0.9f,
                 0.7f + 0.3f * fine);
}

struct texel texel_fabric(float u, float v) {
    float warp_thread = sinf(2 * PI * 64 * u), weft_thread = sinf(2 * PI * 64 * v),
          weave = 0.5f + 0.25f * (warp_thread * warp_thread - weft_thread * weft_thread);
    float cx = u * 2 - floorf(u * 2) - 0.5f, cy = v * 2 - floorf(v * 2) - 0.5f, angle = atan2f(cy, cx), r = hypotf(cx, cy);
    float petal = 0.24f + 0.09f * cosf(6 * angle), flower = 1 - smooth_step(petal - 0.01f, petal + 0.01f, r);
    float heart = 1 - smooth_step(0.07f, 0.08f, r), band = smooth_step(0.455f, 0.465f, fmaxf(fabsf(cx), fabsf(cy)));
    float gold = fmaxf(flower - heart, band) * 0.85f, wear = noise_fractal(u, v, 4, 4, 4, 131);
    vec3 color = vec3_scale(vec3_lerp(gray(0.55f), vec3_make(0.95f, 0.82f, 0.45f), gold),
                            (0.8f + 0.3f * weave) * (0.8f + 0.3f * wear));
    return solid(color, 0.0008f * weave, 0.8f - 0.2f * gold, 0.85f + 0.15f * weave);
}

struct texel texel_metal(float u, float v) {
    float brush = noise_value(u, v, 4, 256, 141), broad = noise_fractal(u, v, 4, 4, 4, 142),
          spot = smooth_step(0.62f, 0.75f, noise_fractal(u, v, 9, 9, 4, 143));
    vec3 color = vec3_lerp(gray(0.75f + 0.1f * broad), vec3_make(0.3f, 0.22f, 0.16f), 0.5f * spot);
    struct texel t = solid(color, 0.0002f * brush - 0.0006f * spot, 0.28f + 0.15f * brush + 0.3f * spot, 1);
    t.metallic = 1 - 0.6f * spot;
    return t;
}
