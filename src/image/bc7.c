/* SPDX-License-Identifier: MIT */
/* BC7 (Khronos Data Format Specification 1.3, 20.1): tables of modes, patterns and anchors are those of the specification. */
#include "image/bc7.h"
#include "image/bc6h.h"

const struct bc7_mode bc7_modes[8] = {
    {3, 4, 0, 0, 4, 0, 1, 0, 3, 0}, {2, 6, 0, 0, 6, 0, 0, 1, 3, 0}, {3, 6, 0, 0, 5, 0, 0, 0, 2, 0}, {2, 6, 0, 0, 7, 0, 1, 0, 2, 0},
    {1, 0, 2, 1, 5, 6, 0, 0, 2, 3}, {1, 0, 2, 0, 7, 8, 0, 0, 2, 2}, {1, 0, 0, 0, 7, 7, 1, 0, 4, 0}, {2, 6, 0, 0, 5, 5, 1, 0, 2, 0},
};

/* Bit i: texel i is in the second subset. The first 32 are those of BC6H. */
static const uint16_t two_subsets[32] = {
    0xAAAA, 0xF0F0, 0x5A5A, 0x33CC, 0x3C3C, 0x55AA, 0x9696, 0xA55A, 0x73CE, 0x13C8, 0x324C, 0x3BDC, 0x6996, 0xC33C, 0x9966, 0x0660,
    0x0272, 0x04E4, 0x4E40, 0x2720, 0xC936, 0x936C, 0x39C6, 0x639C, 0x9336, 0x9CC6, 0x817E, 0xE718, 0xCCF0, 0x0FCC, 0x7744, 0xEE22,
};
static const uint8_t two_anchors[32] = {15, 15, 6, 8, 2, 8, 15, 15, 2, 8, 2, 2, 2, 15, 15, 6, 6, 2, 6, 8, 15, 15, 2, 2, 15, 15, 15, 15, 15, 2, 2, 15};

/* Two bits for each texel. */
static const uint32_t three_subsets[64] = {
    0xaa685050, 0x6a5a5040, 0x5a5a4200, 0x5450a0a8, 0xa5a50000, 0xa0a05050, 0x5555a0a0, 0x5a5a5050, 0xaa550000, 0xaa555500, 0xaaaa5500, 0x90909090, 0x94949494,
    0xa4a4a4a4, 0xa9a59450, 0x2a0a4250, 0xa5945040, 0x0a425054, 0xa5a5a500, 0x55a0a0a0, 0xa8a85454, 0x6a6a4040, 0xa4a45000, 0x1a1a0500, 0x0050a4a4, 0xaaa59090,
    0x14696914, 0x69691400, 0xa08585a0, 0xaa821414, 0x50a4a450, 0x6a5a0200, 0xa9a58000, 0x5090a0a8, 0xa8a09050, 0x24242424, 0x00aa5500, 0x24924924, 0x24499224,
    0x50a50a50, 0x500aa550, 0xaaaa4444, 0x66660000, 0xa5a0a5a0, 0x50a050a0, 0x69286928, 0x44aaaa44, 0x66666600, 0xaa444444, 0x54a854a8, 0x95809580, 0x96969600,
    0xa85454a8, 0x80959580, 0xaa141414, 0x96960000, 0xaaaa1414, 0xa05050a0, 0xa0a5a5a0, 0x96000000, 0x40804080, 0xa9a8a9a8, 0xaaaaaa44, 0x2a4a5254,
};
static const uint8_t three_anchors[2][64] = {
    {3,  3,  15, 15, 8, 3,  15, 15, 8,  8,  6, 6,  6, 5,  3, 3,  3,  3, 8, 15, 3, 3,  6, 10, 5, 8,  8, 6,  8,  5,  15, 15,
     8,  15, 3,  5,  6, 10, 8,  15, 15, 3, 15, 5, 15, 15, 15, 15, 3, 15, 5, 5,  5, 8,  5, 10, 5, 10, 8, 13, 15, 12, 3,  3},
    {15, 8, 8,  3,  15, 15, 3, 8,  15, 15, 15, 15, 15, 15, 15, 8,  15, 8, 15, 3,  15, 8,  15, 8,  3,  15, 6,  10, 15, 15, 10, 8,
     15, 3, 15, 10, 10, 8,  9, 10, 6,  15, 8,  15, 3,  6,  6,  8,  15, 3, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 3,  15, 15, 8},
};

uint32_t bc7_subset_of(uint32_t subsets, uint32_t pattern, uint32_t texel) {
    if (subsets == 3) return three_subsets[pattern] >> 2 * texel & 3;
    if (subsets == 2) return (pattern < BC6H_PATTERNS ? bc6h_pattern(pattern) : two_subsets[pattern - BC6H_PATTERNS]) >> texel & 1;
    return 0;
}

uint32_t bc7_anchor_of(uint32_t subsets, uint32_t pattern, uint32_t subset) {
    if (subset == 0) return 0;
    if (subsets == 3) return three_anchors[subset - 1][pattern];
    return pattern < BC6H_PATTERNS ? bc6h_anchor(pattern) : two_anchors[pattern - BC6H_PATTERNS];
}

uint8_t bc7_interpolate(uint32_t a, uint32_t b, uint32_t index, uint32_t bits) {
    static const uint8_t weights[3][16] = {{0, 21, 43, 64}, {0, 9, 18, 27, 37, 46, 55, 64}, {0, 4, 9, 13, 17, 21, 26, 30, 34, 38, 43, 47, 51, 55, 60, 64}};
    uint32_t weight = weights[bits - 2][index];
    return (uint8_t)((a * (64 - weight) + b * weight + 32) >> 6);
}

/* Of all subsets two ends each, as 8 bits. */
static void read_ends(struct block_bits *bits, const struct bc7_mode *m, uint32_t ends[6][4]) {
    const uint32_t count = 2u * m->subsets, p = m->own_p | m->shared_p;
    for (uint32_t c = 0; c < 4; c++)
        for (uint32_t i = 0; i < count; i++) ends[i][c] = c < 3 ? block_take(bits, m->color_bits) : m->alpha_bits ? block_take(bits, m->alpha_bits) : 255;
    for (uint32_t i = 0, bit = 0; p && i < count; i++) {
        if (m->own_p || i % 2 == 0) bit = block_take(bits, 1);
        for (uint32_t c = 0; c < (m->alpha_bits ? 4 : 3); c++) ends[i][c] = ends[i][c] << 1 | bit;
    }
    for (uint32_t i = 0; i < count; i++)
        for (uint32_t c = 0; c < (m->alpha_bits ? 4 : 3); c++) {
            uint32_t size = (c < 3 ? m->color_bits : m->alpha_bits) + p;
            ends[i][c] = ends[i][c] << (8 - size) | ends[i][c] >> (2 * size - 8);
        }
}

void bc7_decode(const unsigned char block[16], uint8_t texels[16][4]) {
    struct block_bits bits = block_bits(block);
    uint32_t mode = 0;
    while (mode < 8 && !block_take(&bits, 1)) mode++;
    if (mode == 8) {
        memset(texels, 0, 16 * 4);
        return;
    }
    const struct bc7_mode *m = &bc7_modes[mode];
    uint32_t pattern = block_take(&bits, m->pattern_bits), rotation = block_take(&bits, m->rotation_bits), swap = block_take(&bits, m->selection_bits);
    uint32_t ends[6][4], indices[2][16] = {0};
    read_ends(&bits, m, ends);
    for (uint32_t i = 0; i < 16; i++) {
        bool anchor = bc7_anchor_of(m->subsets, pattern, bc7_subset_of(m->subsets, pattern, i)) == i;
        indices[0][i] = block_take(&bits, m->index_bits - anchor);
    }
    for (uint32_t i = 0; m->second_bits && i < 16; i++) indices[1][i] = block_take(&bits, m->second_bits - (i == 0));
    const uint32_t sizes[2] = {m->index_bits, m->second_bits};
    for (uint32_t i = 0; i < 16; i++) {
        const uint32_t *a = ends[2 * bc7_subset_of(m->subsets, pattern, i)], *b = a + 4;
        for (uint32_t c = 0; c < 4; c++) {
            uint32_t which = m->second_bits ? (c == 3) ^ swap : 0;
            texels[i][c] = bc7_interpolate(a[c], b[c], indices[which][i], sizes[which]);
        }
        if (rotation) {
            uint8_t alpha = texels[i][3];
            texels[i][3] = texels[i][rotation - 1];
            texels[i][rotation - 1] = alpha;
        }
    }
}
