/* SPDX-License-Identifier: MIT */
/*
 * UASTC LDR 4 x 4 (Basis Universal): 19 kinds of ASTC blocks whose fields stand one behind the other from the lowest bit on. What the numbers mean is
 * as in ASTC (Khronos Data Format Specification 1.3, chapter 23), without sRGB: ends are decoded to 8 bits, repeated to 16, interpolated, and cut to 8.
 */
#include "image/blocks.h"

enum { SOLID = 8, MODES = 19 };

static const struct mode {
    uint8_t code, code_bits;
    uint8_t hint_bits; /* for transcoders to other formats; skipped */
    uint8_t subsets, planes, channels; /* channels: 2 are luminance and alpha */
    uint8_t range_bits, range_base;    /* of an end: range_base 3 or 5 is a trit or a quint above the bits, 1: none */
    uint8_t weight_bits;
} modes[MODES] = {
    {0x01, 4, 15, 1, 1, 3, 6, 3, 4}, {0x35, 6, 15, 1, 1, 3, 8, 1, 2}, {0x1d, 5, 15, 2, 1, 3, 4, 1, 3}, {0x03, 5, 15, 3, 1, 3, 2, 3, 2},
    {0x13, 5, 15, 2, 1, 3, 3, 5, 2}, {0x0b, 5, 15, 1, 1, 3, 8, 1, 3}, {0x1b, 5, 15, 1, 2, 3, 5, 5, 2}, {0x07, 5, 15, 2, 1, 3, 3, 5, 2},
    {0x17, 5,  0, 1, 1, 4, 8, 1, 0}, {0x0f, 5, 23, 2, 1, 4, 4, 1, 2}, {0x02, 3, 17, 1, 1, 4, 4, 3, 4}, {0x00, 2, 17, 1, 2, 4, 4, 3, 2},
    {0x06, 3, 17, 1, 1, 4, 6, 3, 3}, {0x1f, 5, 23, 1, 2, 4, 8, 1, 1}, {0x0d, 5, 23, 1, 1, 4, 8, 1, 2}, {0x05, 7, 23, 1, 1, 2, 8, 1, 4},
    {0x15, 6, 23, 2, 1, 2, 8, 1, 2}, {0x25, 6, 23, 1, 2, 2, 8, 1, 2}, {0x09, 4, 15, 1, 1, 3, 5, 1, 5},
};

/* ASTC's partitions that BC7 has too; bit i: texel i is in the second subset. */
static const uint16_t two_subsets[32] = {
    0xcccc, 0x8888, 0x1111, 0xecc8, 0x377f, 0xfeec, 0x0137, 0x137f, 0xc800, 0x0013, 0xfe80, 0x17ff, 0x0017, 0x00ff, 0xfff0, 0x0fff,
    0xff71, 0x8eff, 0x08ce, 0x008c, 0x7310, 0xceff, 0x7331, 0x088c, 0xceef, 0x6666, 0xf00f, 0x5555, 0x0f0f, 0x36c9};
enum { TWO_COUNT = 30, SEVEN_COUNT = 19, THREE_COUNT = 11 };
/* Mode 7: those that BC7 has with three subsets. */
static const uint16_t seven_subsets[32] = {0x00f0, 0x4444, 0x0133, 0xcc80, 0xf0ff, 0x2222, 0xffc8, 0xccce, 0x3c03, 0x00ee,
                                           0x7700, 0x3003, 0x00ce, 0xff80, 0x6fff, 0x1333, 0x11ff, 0x136c, 0x00ef};
/* Two bits for each texel. */
static const uint32_t three_subsets[16] = {0xa5a50000, 0xaa005555, 0xaa000055, 0x0000aa55, 0x25252525, 0x94949494,
                                           0x58585858, 0x56560202, 0x92929292, 0x55aa0055, 0xa05050a0};

/* Which subset each texel is in; false: there is no such pattern. */
static bool read_pattern(struct block_bits *bits, uint32_t mode, uint8_t subsets[16]) {
    memset(subsets, 0, 16);
    if (modes[mode].subsets == 1) return true;
    const bool three = modes[mode].subsets == 3;
    const uint32_t pattern = block_take(bits, three ? 4 : 5), count = three ? THREE_COUNT : mode == 7 ? SEVEN_COUNT : TWO_COUNT;
    if (pattern >= count) return false;
    for (uint32_t i = 0; i < 16; i++)
        subsets[i] = three ? three_subsets[pattern] >> 2 * i & 3 : (mode == 7 ? seven_subsets : two_subsets)[pattern] >> i & 1;
    return true;
}

/* An end as 8 bits (Khronos Data Format Specification 1.3, 23.13). */
static uint8_t unquantise(uint32_t bits, uint32_t base, uint32_t low, uint32_t high) {
    if (base == 1) {
        if (bits == 8) return (uint8_t)low;
        return (uint8_t)(bits == 5 ? low << 3 | low >> 2 : low << 4 | low);
    }
    const uint32_t a = low & 1 ? 0x1ff : 0, b = low >> 1; /* the bits above the lowest, spread by rules of each range */
    uint32_t spread, factor;
    if (base == 3) {
        factor = bits == 2 ? 93 : bits == 4 ? 22 : 5;
        spread = bits == 2 ? b << 1 | b << 2 | b << 4 | b << 8 : bits == 4 ? b << 6 | b : b << 4 | b >> 4;
    } else {
        factor = bits == 3 ? 26 : 6;
        spread = bits == 3 ? b << 7 | b << 1 | b >> 1 : b << 5 | b >> 3;
    }
    const uint32_t t = (high * factor + spread) ^ a;
    return (uint8_t)((a & 0x80) | t >> 2);
}

/* All ends: first their trits in groups of five or quints in groups of three, each group one number, then the bits of each. */
static void read_ends(struct block_bits *bits, const struct mode *m, uint8_t ends[18]) {
    static const uint8_t trit_bits[6] = {0, 2, 4, 5, 7, 8}, quint_bits[4] = {0, 3, 5, 7};
    const uint32_t count = 2u * m->subsets * m->channels, group = m->range_base == 3 ? 5 : 3;
    uint8_t high[18] = {0};
    for (uint32_t i = 0; m->range_base > 1 && i < count; i += group) {
        const uint32_t some = MIN(count - i, group);
        uint32_t packed = block_take(bits, m->range_base == 3 ? trit_bits[some] : quint_bits[some]);
        for (uint32_t k = 0; k < some; k++, packed /= m->range_base) high[i + k] = (uint8_t)(packed % m->range_base);
    }
    for (uint32_t i = 0; i < count; i++) ends[i] = unquantise(m->range_bits, m->range_base, block_take(bits, m->range_bits), high[i]);
}

/* Of 64. The first texel of each subset has one bit less: its highest bit is 0. */
static void read_weights(struct block_bits *bits, const struct mode *m, const uint8_t subsets[16], uint8_t weights[16][2]) {
    bool begun[3] = {false, false, false};
    for (uint32_t i = 0; i < 16; i++) {
        const bool first = !begun[subsets[i]];
        begun[subsets[i]] = true;
        for (uint32_t plane = 0; plane < m->planes; plane++) {
            const uint32_t size = m->weight_bits;
            uint32_t value = block_take(bits, size - first);
            value = size == 1   ? value * 63
                    : size == 2 ? value * 21
                    : size == 3 ? value * 9
                    : size == 4 ? value << 2 | value >> 2
                                : value << 1 | value >> 4;
            weights[i][plane] = (uint8_t)(value + (value > 32));
        }
    }
}

static uint8_t interpolate(uint32_t a, uint32_t b, uint32_t weight) { return (uint8_t)((a * 257 * (64 - weight) + b * 257 * weight + 32) >> 14); }

bool uastc_decode(const unsigned char block[16], uint8_t texels[16][4], struct block_structure *structure) {
    uint32_t mode = 0;
    while (mode < MODES && (block[0] & ((1u << modes[mode].code_bits) - 1)) != modes[mode].code) mode++;
    memset(texels, 0, 16 * 4);
    if (structure) *structure = (struct block_structure){.lone = 4};
    if (mode == MODES) return false;
    const struct mode *m = &modes[mode];
    struct block_bits bits = block_bits(block);
    bits.at = m->code_bits + m->hint_bits;
    if (mode == SOLID) {
        for (uint32_t c = 0; c < 4; c++) texels[0][c] = (uint8_t)block_take(&bits, 8);
        for (uint32_t i = 1; i < 16; i++) memcpy(texels[i], texels[0], 4);
        return true;
    }
    uint8_t subsets[16], ends[18], weights[16][2];
    if (!read_pattern(&bits, mode, subsets)) return false;
    uint32_t lone = m->planes == 1 ? 4 : m->channels == 2 ? 3 : block_take(&bits, 2); /* the channel of the second plane */
    if (structure) {
        memcpy(structure->subsets, subsets, sizeof subsets);
        structure->lone = (uint8_t)lone;
    }
    read_ends(&bits, m, ends);
    read_weights(&bits, m, subsets, weights);
    for (uint32_t i = 0; i < 16; i++) {
        const uint8_t *own = ends + 2 * m->channels * subsets[i];
        for (uint32_t c = 0; c < 4; c++) {
            const uint32_t from = m->channels > 2 ? c : c == 3;
            texels[i][c] = from < m->channels ? interpolate(own[2 * from], own[2 * from + 1], weights[i][c == lone]) : 255;
        }
    }
    return true;
}
