/* SPDX-License-Identifier: MIT */
/* The format: where the bits of a block stand, and what they mean. */
#include "image/bc6h_encode.h"

#include "base/maths.h"

/* ---- where the bits stand ---- */

enum field { RW, GW, BW, RX, GX, BX, RY, GY, BY, RZ, GZ, BZ };

/* Bits `first` .. `last` of an endpoint's channel, in this order (which may fall) from low bits of the block to high ones. */
struct run {
    uint8_t field, first, last;
};

/* Header, bits of an endpoint, bits of differences, then the fields from the lowest bit on. */
static const struct layout {
    struct bc6h_mode mode;
    struct run runs[24]; /* up to the indices or the pattern; the rest is zero */
} layouts[BC6H_MODES + 1] = {
    [1] = {{2, 0x00, 10, {5, 5, 5}}, {{GY, 4, 4}, {BY, 4, 4}, {BZ, 4, 4}, {RW, 0, 9}, {GW, 0, 9}, {BW, 0, 9}, {RX, 0, 4}, {GZ, 4, 4}, {GY, 0, 3}, {GX, 0, 4}, {BZ, 0, 0}, {GZ, 0, 3}, {BX, 0, 4}, {BZ, 1, 1}, {BY, 0, 3}, {RY, 0, 4}, {BZ, 2, 2}, {RZ, 0, 4}, {BZ, 3, 3}}},
    [2] = {{2, 0x01, 7, {6, 6, 6}}, {{GY, 5, 5}, {GZ, 4, 4}, {GZ, 5, 5}, {RW, 0, 6}, {BZ, 0, 0}, {BZ, 1, 1}, {BY, 4, 4}, {GW, 0, 6}, {BY, 5, 5}, {BZ, 2, 2}, {GY, 4, 4}, {BW, 0, 6}, {BZ, 3, 3}, {BZ, 5, 5}, {BZ, 4, 4}, {RX, 0, 5}, {GY, 0, 3}, {GX, 0, 5}, {GZ, 0, 3}, {BX, 0, 5}, {BY, 0, 3}, {RY, 0, 5}, {RZ, 0, 5}}},
    [3] = {{5, 0x02, 11, {5, 4, 4}}, {{RW, 0, 9}, {GW, 0, 9}, {BW, 0, 9}, {RX, 0, 4}, {RW, 10, 10}, {GY, 0, 3}, {GX, 0, 3}, {GW, 10, 10}, {BZ, 0, 0}, {GZ, 0, 3}, {BX, 0, 3}, {BW, 10, 10}, {BZ, 1, 1}, {BY, 0, 3}, {RY, 0, 4}, {BZ, 2, 2}, {RZ, 0, 4}, {BZ, 3, 3}}},
    [4] = {{5, 0x06, 11, {4, 5, 4}}, {{RW, 0, 9}, {GW, 0, 9}, {BW, 0, 9}, {RX, 0, 3}, {RW, 10, 10}, {GZ, 4, 4}, {GY, 0, 3}, {GX, 0, 4}, {GW, 10, 10}, {GZ, 0, 3}, {BX, 0, 3}, {BW, 10, 10}, {BZ, 1, 1}, {BY, 0, 3}, {RY, 0, 3}, {BZ, 0, 0}, {BZ, 2, 2}, {RZ, 0, 3}, {GY, 4, 4}, {BZ, 3, 3}}},
    [5] = {{5, 0x0a, 11, {4, 4, 5}}, {{RW, 0, 9}, {GW, 0, 9}, {BW, 0, 9}, {RX, 0, 3}, {RW, 10, 10}, {BY, 4, 4}, {GY, 0, 3}, {GX, 0, 3}, {GW, 10, 10}, {BZ, 0, 0}, {GZ, 0, 3}, {BX, 0, 4}, {BW, 10, 10}, {BY, 0, 3}, {RY, 0, 3}, {BZ, 1, 1}, {BZ, 2, 2}, {RZ, 0, 3}, {BZ, 4, 4}, {BZ, 3, 3}}},
    [6] = {{5, 0x0e, 9, {5, 5, 5}}, {{RW, 0, 8}, {BY, 4, 4}, {GW, 0, 8}, {GY, 4, 4}, {BW, 0, 8}, {BZ, 4, 4}, {RX, 0, 4}, {GZ, 4, 4}, {GY, 0, 3}, {GX, 0, 4}, {BZ, 0, 0}, {GZ, 0, 3}, {BX, 0, 4}, {BZ, 1, 1}, {BY, 0, 3}, {RY, 0, 4}, {BZ, 2, 2}, {RZ, 0, 4}, {BZ, 3, 3}}},
    [7] = {{5, 0x12, 8, {6, 5, 5}}, {{RW, 0, 7}, {GZ, 4, 4}, {BY, 4, 4}, {GW, 0, 7}, {BZ, 2, 2}, {GY, 4, 4}, {BW, 0, 7}, {BZ, 3, 3}, {BZ, 4, 4}, {RX, 0, 5}, {GY, 0, 3}, {GX, 0, 4}, {BZ, 0, 0}, {GZ, 0, 3}, {BX, 0, 4}, {BZ, 1, 1}, {BY, 0, 3}, {RY, 0, 5}, {RZ, 0, 5}}},
    [8] = {{5, 0x16, 8, {5, 6, 5}}, {{RW, 0, 7}, {BZ, 0, 0}, {BY, 4, 4}, {GW, 0, 7}, {GY, 5, 5}, {GY, 4, 4}, {BW, 0, 7}, {GZ, 5, 5}, {BZ, 4, 4}, {RX, 0, 4}, {GZ, 4, 4}, {GY, 0, 3}, {GX, 0, 5}, {GZ, 0, 3}, {BX, 0, 4}, {BZ, 1, 1}, {BY, 0, 3}, {RY, 0, 4}, {BZ, 2, 2}, {RZ, 0, 4}, {BZ, 3, 3}}},
    [9] = {{5, 0x1a, 8, {5, 5, 6}}, {{RW, 0, 7}, {BZ, 1, 1}, {BY, 4, 4}, {GW, 0, 7}, {BY, 5, 5}, {GY, 4, 4}, {BW, 0, 7}, {BZ, 5, 5}, {BZ, 4, 4}, {RX, 0, 4}, {GZ, 4, 4}, {GY, 0, 3}, {GX, 0, 4}, {BZ, 0, 0}, {GZ, 0, 3}, {BX, 0, 5}, {BY, 0, 3}, {RY, 0, 4}, {BZ, 2, 2}, {RZ, 0, 4}, {BZ, 3, 3}}},
    [10] = {{5, 0x1e, 6, {0, 0, 0}}, {{RW, 0, 5}, {GZ, 4, 4}, {BZ, 0, 0}, {BZ, 1, 1}, {BY, 4, 4}, {GW, 0, 5}, {GY, 5, 5}, {BY, 5, 5}, {BZ, 2, 2}, {GY, 4, 4}, {BW, 0, 5}, {GZ, 5, 5}, {BZ, 3, 3}, {BZ, 5, 5}, {BZ, 4, 4}, {RX, 0, 5}, {GY, 0, 3}, {GX, 0, 5}, {GZ, 0, 3}, {BX, 0, 5}, {BY, 0, 3}, {RY, 0, 5}, {RZ, 0, 5}}},
    [11] = {{5, 0x03, 10, {0, 0, 0}}, {{RW, 0, 9}, {GW, 0, 9}, {BW, 0, 9}, {RX, 0, 9}, {GX, 0, 9}, {BX, 0, 9}}},
    [12] = {{5, 0x07, 11, {9, 9, 9}}, {{RW, 0, 9}, {GW, 0, 9}, {BW, 0, 9}, {RX, 0, 8}, {RW, 10, 10}, {GX, 0, 8}, {GW, 10, 10}, {BX, 0, 8}, {BW, 10, 10}}},
    [13] = {{5, 0x0b, 12, {8, 8, 8}}, {{RW, 0, 9}, {GW, 0, 9}, {BW, 0, 9}, {RX, 0, 7}, {RW, 11, 10}, {GX, 0, 7}, {GW, 11, 10}, {BX, 0, 7}, {BW, 11, 10}}},
    [14] = {{5, 0x0f, 16, {4, 4, 4}}, {{RW, 0, 9}, {GW, 0, 9}, {BW, 0, 9}, {RX, 0, 3}, {RW, 15, 10}, {GX, 0, 3}, {GW, 15, 10}, {BX, 0, 3}, {BW, 15, 10}}},
};

struct bc6h_mode bc6h_mode(uint32_t mode) { return layouts[mode].mode; }

static uint32_t endpoint_count(uint32_t mode) { return mode <= 10 ? 4 : 2; }

uint32_t bc6h_pattern(uint32_t pattern) {
    static const uint16_t patterns[BC6H_PATTERNS] = {
        0xCCCC, 0x8888, 0xEEEE, 0xECC8, 0xC880, 0xFEEC, 0xFEC8, 0xEC80, 0xC800, 0xFFEC, 0xFE80, 0xE800, 0xFFE8, 0xFF00, 0xFFF0, 0xF000,
        0xF710, 0x008E, 0x7100, 0x08CE, 0x008C, 0x7310, 0x3100, 0x8CCE, 0x088C, 0x3110, 0x6666, 0x366C, 0x17E8, 0x0FF0, 0x718E, 0x399C,
    };
    return patterns[pattern % BC6H_PATTERNS];
}

uint32_t bc6h_anchor(uint32_t pattern) {
    const uint32_t second = 0xcd1a0000u, eighth = 0x32640000u; /* patterns whose anchor is texel 2, and 8 */
    return second >> pattern & 1 ? 2 : eighth >> pattern & 1 ? 8 : 15;
}

static uint32_t get_bits(const struct bc6h_block *block, uint32_t at, uint32_t count) {
    uint64_t low = block->words[at / 32] | (uint64_t)block->words[MIN(at / 32 + 1, 3u)] << 32;
    return (uint32_t)(low >> at % 32) & ((1u << count) - 1);
}

static void put_bits(struct bc6h_block *block, uint32_t *at, uint32_t count, uint32_t value) {
    for (uint32_t i = 0; i < count; i++, ++*at) block->words[*at / 32] |= (value >> i & 1) << *at % 32;
}

static uint32_t mode_of(const struct bc6h_block *block) {
    uint32_t low = block->words[0] & 31;
    for (uint32_t mode = 1; mode <= BC6H_MODES; mode++)
        if (layouts[mode].mode.header == (low & ((1u << layouts[mode].mode.header_bits) - 1))) return mode;
    return 0;
}

static uint32_t run_length(const struct run *run) { return 1u + (uint32_t)abs(run->last - run->first); }

struct bc6h_fields bc6h_unpack(const struct bc6h_block *block) {
    struct bc6h_fields out = {.mode = mode_of(block)};
    if (!out.mode) return out;
    const struct layout *layout = &layouts[out.mode];
    uint32_t at = layout->mode.header_bits, end = out.mode <= 10 ? 77 : 65;
    for (const struct run *run = layout->runs; at < end; run++)
        for (uint32_t i = 0; i < run_length(run); i++) {
            uint32_t bit = run->last >= run->first ? run->first + i : run->first - i;
            out.endpoints[run->field / 3][run->field % 3] |= (int32_t)(get_bits(block, at++, 1) << bit);
        }
    if (out.mode <= 10) {
        out.pattern = get_bits(block, at, 5);
        at += 5;
    }
    uint32_t width = out.mode <= 10 ? 3 : 4, anchor = out.mode <= 10 ? bc6h_anchor(out.pattern) : 0;
    for (uint32_t i = 0; i < 16; i++) {
        uint32_t bits = i == 0 || i == anchor ? width - 1 : width;
        out.indices[i] = (uint8_t)get_bits(block, at, bits);
        at += bits;
    }
    return out;
}

struct bc6h_block bc6h_pack(const struct bc6h_fields *fields) {
    struct bc6h_block out = {{0}};
    const struct layout *layout = &layouts[fields->mode];
    uint32_t at = 0, end = fields->mode <= 10 ? 77 : 65;
    put_bits(&out, &at, layout->mode.header_bits, layout->mode.header);
    for (const struct run *run = layout->runs; at < end; run++) {
        uint32_t value = (uint32_t)fields->endpoints[run->field / 3][run->field % 3];
        for (uint32_t i = 0, count = run_length(run); i < count; i++)
            put_bits(&out, &at, 1, value >> (run->last >= run->first ? run->first + i : run->first - i));
    }
    if (fields->mode <= 10) put_bits(&out, &at, 5, fields->pattern);
    uint32_t width = fields->mode <= 10 ? 3 : 4, anchor = fields->mode <= 10 ? bc6h_anchor(fields->pattern) : 0;
    for (uint32_t i = 0; i < 16; i++) put_bits(&out, &at, i == 0 || i == anchor ? width - 1 : width, fields->indices[i]);
    return out;
}

/* ---- what they mean ---- */

float bc6h_limit(float value, bool is_signed) {
    const float most = 65504;
    if (is_signed) return value > -most ? fminf(value, most) : value < 0 ? -most : 0;
    return value > 0 ? fminf(value, most) : 0; /* NaN: 0 */
}

int32_t bc6h_code(float value, bool is_signed) {
    uint16_t half = half_from_float(bc6h_limit(value, is_signed));
    return half & 0x8000 ? -(int32_t)(half & 0x7fff) : half;
}

static uint16_t half_of(int32_t code) { return (uint16_t)(code < 0 ? 0x8000 | -code : code); }

float bc6h_value(int32_t code) { return half_to_float(half_of(code)); }

/* The steps are of equal width, and the decoder gives their middle; with 16 bits, each code has a number of its own. */
int32_t bc6h_quantise(int32_t code, uint32_t bits, bool is_signed) {
    uint32_t magnitude = (uint32_t)abs(code), out;
    if (is_signed)
        out = bits >= 16 ? (magnitude * 32 + 30) / 31 : (magnitude << (bits - 1) >> 10) / 31;
    else
        out = bits >= 16 ? (magnitude * 64 + 30) / 31 : (magnitude << bits >> 10) / 31;
    return code < 0 ? -(int32_t)out : (int32_t)out;
}

int32_t bc6h_unquantise(int32_t endpoint, uint32_t bits, bool is_signed) {
    if (!is_signed) {
        if (bits >= 15 || endpoint == 0) return endpoint;
        if (endpoint == (1 << bits) - 1) return 0xffff;
        return ((endpoint << 16) + 0x8000) >> bits;
    }
    if (bits >= 16 || endpoint == 0) return endpoint;
    int32_t magnitude = abs(endpoint);
    int32_t out = magnitude >= (1 << (bits - 1)) - 1 ? 0x7fff : ((magnitude << 15) + 0x4000) >> (bits - 1);
    return endpoint < 0 ? -out : out;
}

int32_t bc6h_finish(int32_t number, bool is_signed) {
    if (!is_signed) return number * 31 >> 6;
    return number < 0 ? -(-number * 31 >> 5) : number * 31 >> 5;
}

static int32_t extend(int32_t value, uint32_t bits) {
    uint32_t sign = 1u << (bits - 1), low = (uint32_t)value & ((1u << bits) - 1);
    return (int32_t)(low ^ sign) - (int32_t)sign;
}

void bc6h_whole_endpoints(struct bc6h_fields *fields, bool is_signed) {
    struct bc6h_mode mode = bc6h_mode(fields->mode);
    for (uint32_t e = endpoint_count(fields->mode); e-- > 0;) /* the first, which the others are added to, last */
        for (uint32_t c = 0; c < 3; c++) {
            int32_t *value = &fields->endpoints[e][c];
            if (e && mode.delta[c]) *value = (fields->endpoints[0][c] + extend(*value, mode.delta[c])) & ((1 << mode.bits) - 1);
            if (is_signed) *value = extend(*value, mode.bits);
        }
}

void bc6h_decode_codes(const struct bc6h_fields *fields, bool is_signed, int32_t codes[16][3]) {
    static const uint8_t weights3[8] = {0, 9, 18, 27, 37, 46, 55, 64};
    static const uint8_t weights4[16] = {0, 4, 9, 13, 17, 21, 26, 30, 34, 38, 43, 47, 51, 55, 60, 64};
    memset(codes, 0, 16 * sizeof *codes);
    if (!fields->mode) return;
    struct bc6h_fields whole = *fields;
    bc6h_whole_endpoints(&whole, is_signed);
    uint32_t bits = bc6h_mode(fields->mode).bits;
    int32_t numbers[4][3];
    for (uint32_t e = 0; e < endpoint_count(fields->mode); e++)
        for (uint32_t c = 0; c < 3; c++) numbers[e][c] = bc6h_unquantise(whole.endpoints[e][c], bits, is_signed);
    uint32_t mask = fields->mode <= 10 ? bc6h_pattern(fields->pattern) : 0;
    for (uint32_t i = 0; i < 16; i++) {
        int32_t weight = fields->mode <= 10 ? weights3[fields->indices[i] & 7] : weights4[fields->indices[i] & 15];
        const int32_t (*pair)[3] = (const int32_t (*)[3])(numbers + (mask >> i & 1) * 2);
        for (uint32_t c = 0; c < 3; c++) codes[i][c] = bc6h_finish((pair[0][c] * (64 - weight) + pair[1][c] * weight + 32) >> 6, is_signed);
    }
}

void bc6h_decode(const struct bc6h_block *block, bool is_signed, uint16_t halves[16][3]) {
    struct bc6h_fields fields = bc6h_unpack(block);
    int32_t codes[16][3];
    bc6h_decode_codes(&fields, is_signed, codes);
    for (uint32_t i = 0; i < 16; i++)
        for (uint32_t c = 0; c < 3; c++) halves[i][c] = half_of(codes[i][c]);
}

/* ---- pictures ---- */

void bc6h_decode_picture(const void *blocks, bool is_signed, uint32_t width, uint32_t height, float *rgba) {
    const char *at = blocks;
    for (uint32_t y = 0; y < height; y += 4)
        for (uint32_t x = 0; x < width; x += 4, at += BC6H_BLOCK_BYTES) {
            struct bc6h_block block;
            uint16_t halves[16][3];
            memcpy(&block, at, sizeof block);
            bc6h_decode(&block, is_signed, halves);
            for (uint32_t i = 0; i < 16; i++) {
                if (x + i % 4 >= width || y + i / 4 >= height) continue;
                float *pixel = rgba + 4 * ((size_t)(y + i / 4) * width + x + i % 4);
                for (uint32_t c = 0; c < 3; c++) pixel[c] = half_to_float(halves[i][c]);
                pixel[3] = 1;
            }
        }
}

void bc6h_fetch(const struct bc6h_picture *picture, uint32_t block_x, uint32_t block_y, float texels[16][3]) {
    for (uint32_t i = 0; i < 16; i++) {
        uint32_t x = MIN(block_x * 4 + i % 4, picture->width - 1), y = MIN(block_y * 4 + i / 4, picture->height - 1);
        memcpy(texels[i], picture->pixels + picture->channels * ((size_t)y * picture->width + x), 3 * sizeof(float));
    }
}

struct bc6h_error bc6h_compare(const struct bc6h_picture *a, const struct bc6h_picture *b) {
    double sum = 0, log_sum = 0;
    size_t count = (size_t)a->width * a->height;
    for (size_t i = 0; i < count; i++)
        for (uint32_t c = 0; c < 3; c++) {
            double x = (double)a->pixels[i * a->channels + c], y = (double)b->pixels[i * b->channels + c];
            double log_difference = copysign(log1p(fabs(x)), x) - copysign(log1p(fabs(y)), y);
            sum += (x - y) * (x - y);
            log_sum += log_difference * log_difference;
        }
    return (struct bc6h_error){sqrt(sum / (3 * (double)count)), sqrt(log_sum / (3 * (double)count))};
}
