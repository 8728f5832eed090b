/* SPDX-License-Identifier: MIT */
#include "ray/samples.h"

enum { INDEX_BITS = 20 };

struct ray_samples ray_samples_make(uint64_t seed, uint32_t x, uint32_t y, uint32_t index) {
    struct ray_samples s = {.random = {seed}, .index = index};
    s.random.state = random_bits(&s.random) ^ ((uint64_t)y << 32 | x);
    s.pixel = s.random.state = random_bits(&s.random);
    s.random.state ^= index;
    s.random.state = random_bits(&s.random);
    return s;
}

void ray_samples_next(struct ray_samples *s) {
    s->place++;
    s->drawn = 0;
}

static uint32_t reverse(uint32_t x) {
    x = x >> 16 | x << 16;
    x = (x >> 8 & 0x00ff00ffu) | (x & 0x00ff00ffu) << 8;
    x = (x >> 4 & 0x0f0f0f0fu) | (x & 0x0f0f0f0fu) << 4;
    x = (x >> 2 & 0x33333333u) | (x & 0x33333333u) << 2;
    return (x >> 1 & 0x55555555u) | (x & 0x55555555u) << 1;
}

/* Flips each bit by chance, which depends on the bits above it. */
static uint32_t scramble(uint32_t x, uint32_t seed) {
    x = reverse(x);
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= seed >> 16 | 1;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return reverse(x);
}

/* Point `index` of Sobol's sequence, by the direction numbers of S. Joe and F. Y. Kuo 2008: columns of the matrices are computed on the way. */
static void sobol(uint32_t index, uint32_t out[RAY_DRAW_MAX]) {
    uint32_t first = 1u << 31, second = 1u << 31, third = 1u << 31, after = 3u << 30;
    memset(out, 0, RAY_DRAW_MAX * sizeof *out);
    for (; index; index >>= 1) {
        const uint32_t taken = 0u - (index & 1), next = third ^ third >> 2 ^ after;
        out[0] ^= taken & first;
        out[1] ^= taken & second;
        out[2] ^= taken & third;
        first >>= 1;
        second ^= second >> 1;
        third = after;
        after = next;
    }
}

void ray_samples_draw(struct ray_samples *s, int count, double *out) {
    struct random_state keys = {s->pixel ^ ((uint64_t)s->place << 32 | s->drawn++)};
    uint64_t key = random_bits(&keys);
    uint32_t point[RAY_DRAW_MAX];
    sobol(scramble(s->index, (uint32_t)key) & ((1u << INDEX_BITS) - 1), point);
    for (int i = 0; i < count; i++) {
        if (i % 2) key = random_bits(&keys);
        const uint32_t seed = i % 2 ? (uint32_t)key : (uint32_t)(key >> 32);
        out[i] = scramble(point[i], seed) * 0x1p-32;
    }
}
