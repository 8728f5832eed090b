/* SPDX-License-Identifier: MIT */
/* Attributes and filters of KHR_meshopt_compression; indices: meshcode_index.c. Sections are those of the extension's appendices. */
#include "scene/meshcode.h"

#include "base/base.h"

#include <math.h>

typedef uint8_t bytes16 __attribute__((vector_size(16)));
typedef uint16_t halves8 __attribute__((vector_size(16)));
typedef uint32_t words4 __attribute__((vector_size(16)));

enum { GROUP = 16, BLOCK_BYTES = 8192, BLOCK_MOST = 256, GROUP_BYTES_MOST = 24 };

static inline bytes16 zip_low(bytes16 a, bytes16 b) {
    return __builtin_shufflevector(a, b, 0, 16, 1, 17, 2, 18, 3, 19, 4, 20, 5, 21, 6, 22, 7, 23);
}

static inline bytes16 zip_high(bytes16 a, bytes16 b) {
    return __builtin_shufflevector(a, b, 8, 24, 9, 25, 10, 26, 11, 27, 12, 28, 13, 29, 14, 30, 15, 31);
}

static inline bytes16 zip_low_pairs(bytes16 a, bytes16 b) {
    return (bytes16)__builtin_shufflevector((halves8)a, (halves8)b, 0, 8, 1, 9, 2, 10, 3, 11);
}

static inline bytes16 zip_high_pairs(bytes16 a, bytes16 b) {
    return (bytes16)__builtin_shufflevector((halves8)a, (halves8)b, 4, 12, 5, 13, 6, 14, 7, 15);
}

static inline bytes16 from_word(uint64_t word) {
    uint64_t both[2] = {word, 0};
    bytes16 v;
    memcpy(&v, both, sizeof v);
    return v;
}

/* ---- mode 0: groups of 16 deltas, each in so many bits; all bits set mean that a whole byte follows ---- */

static inline const unsigned char *read_bits1(const unsigned char *in, uint8_t out[GROUP]) {
    uint32_t bits = in[0] | (uint32_t)in[1] << 8;
    memset(out, 0, GROUP);
    for (in += 2; bits; bits &= bits - 1) out[__builtin_ctz(bits)] = *in++;
    return in;
}

static inline const unsigned char *read_bits2(const unsigned char *in, uint8_t out[GROUP]) {
    uint32_t packed;
    memcpy(&packed, in, sizeof packed);
    const bytes16 all = from_word(packed), a = all >> 6, b = (all >> 4) & 3, c = (all >> 2) & 3, d = all & 3;
    const bytes16 values = zip_low(zip_low(a, c), zip_low(b, d));
    memcpy(out, &values, GROUP);
    uint32_t whole = packed & packed >> 1 & 0x55555555u; /* the first value of a byte stands highest: turn them round */
    whole = (whole & 0x0f0f0f0fu) << 4 | (whole >> 4 & 0x0f0f0f0fu);
    whole = (whole & 0x33333333u) << 2 | (whole >> 2 & 0x33333333u);
    for (in += 4; whole; whole &= whole - 1) out[__builtin_ctz(whole) / 2] = *in++;
    return in;
}

static inline const unsigned char *read_bits4(const unsigned char *in, uint8_t out[GROUP]) {
    uint64_t packed;
    memcpy(&packed, in, sizeof packed);
    const bytes16 all = from_word(packed), values = zip_low(all >> 4, all & 15);
    memcpy(out, &values, GROUP);
    uint64_t whole = packed & packed >> 1;
    whole = whole & whole >> 2 & 0x1111111111111111u;
    whole = (whole & 0x0f0f0f0f0f0f0f0fu) << 4 | (whole >> 4 & 0x0f0f0f0f0f0f0f0fu);
    for (in += 8; whole; whole &= whole - 1) out[__builtin_ctzll(whole) / 4] = *in++;
    return in;
}

/** One byte of all elements of a block. `in` is left unchanged where the data ends too early. */
static bool read_plane(const unsigned char **in, const unsigned char *end, const uint8_t widths[4], size_t group_count, uint8_t *out) {
    const unsigned char *at = *in, *heads = at;
    const size_t head_size = (group_count + 3) / 4;
    if ((size_t)(end - at) < head_size) return false;
    at += head_size;
    for (size_t i = 0; i < group_count; i++, out += GROUP) {
        /* The tail of the data is longer than a group, so that none of a good stream ends here. */
        if ((size_t)(end - at) < GROUP_BYTES_MOST) return false;
        switch (widths[heads[i / 4] >> i % 4 * 2 & 3]) {
        case 0:
            memset(out, 0, GROUP);
            break;
        case 1:
            at = read_bits1(at, out);
            break;
        case 2:
            at = read_bits2(at, out);
            break;
        case 4:
            at = read_bits4(at, out);
            break;
        default:
            memcpy(out, at, GROUP);
            at += GROUP;
            break;
        }
    }
    *in = at;
    return true;
}

/* ---- mode 0: from deltas to values, four bytes of four elements at once ---- */

static inline bytes16 up_one(bytes16 v) {
    return (bytes16)__builtin_shufflevector((words4)v, (words4){0}, 4, 0, 1, 2);
}

static inline bytes16 up_two(bytes16 v) {
    return (bytes16)__builtin_shufflevector((words4)v, (words4){0}, 4, 4, 0, 1);
}

static inline bytes16 last_of(bytes16 v) {
    const words4 words = (words4)v;
    return (bytes16)__builtin_shufflevector(words, words, 3, 3, 3, 3);
}

/* Running sums and, for XOR, running parities. */
static inline bytes16 values_bytes(bytes16 delta, bytes16 before) {
    delta = delta >> 1 ^ -(delta & 1);
    delta += up_one(delta);
    delta += up_two(delta);
    return delta + before;
}

static inline bytes16 values_halves(bytes16 delta, bytes16 before) {
    halves8 d = (halves8)delta;
    d = d >> 1 ^ -(d & 1);
    d += (halves8)up_one((bytes16)d);
    d += (halves8)up_two((bytes16)d);
    return (bytes16)(d + (halves8)before);
}

static inline bytes16 values_words(bytes16 delta, bytes16 before, uint32_t rotation) {
    words4 d = (words4)delta;
    d = d >> rotation | d << ((32 - rotation) & 31);
    delta = (bytes16)d;
    delta ^= up_one(delta);
    delta ^= up_two(delta);
    return delta ^ before;
}

#define EACH_FOUR(body)                                                                                                                       \
    for (size_t i = 0; i < count; i += GROUP) {                                                                                               \
        bytes16 plane[4], quads[4];                                                                                                           \
        for (size_t p = 0; p < 4; p++) memcpy(&plane[p], planes[p] + i, GROUP);                                                               \
        const bytes16 low01 = zip_low(plane[0], plane[1]), high01 = zip_high(plane[0], plane[1]);                                             \
        const bytes16 low23 = zip_low(plane[2], plane[3]), high23 = zip_high(plane[2], plane[3]);                                             \
        quads[0] = zip_low_pairs(low01, low23);                                                                                               \
        quads[1] = zip_high_pairs(low01, low23);                                                                                              \
        quads[2] = zip_low_pairs(high01, high23);                                                                                             \
        quads[3] = zip_high_pairs(high01, high23);                                                                                            \
        for (size_t q = 0; q < 4 && i + q * 4 < count; q++) {                                                                                 \
            const bytes16 delta = quads[q];                                                                                                   \
            before = last_of(body);                                                                                                           \
        }                                                                                                                                     \
    }

/** Stores four bytes of up to four elements. */
static inline bytes16 store(bytes16 values, unsigned char *out, size_t stride, size_t left) {
    uint32_t words[4];
    memcpy(words, &values, sizeof words);
    if (left >= 4) {
        for (size_t i = 0; i < 4; i++) memcpy(out + i * stride, &words[i], 4);
    } else {
        for (size_t i = 0; i < left; i++) memcpy(out + i * stride, &words[i], 4);
    }
    return values;
}

/** `mode` is the channel's, `last` its four bytes of the element before the block. */
static bool write_channel(uint8_t planes[4][BLOCK_MOST], size_t count, uint32_t mode, unsigned char *last, unsigned char *out, size_t stride) {
    const uint32_t kind = mode & 15, rotation = mode >> 4;
    uint32_t start;
    memcpy(&start, last, sizeof start);
    bytes16 before = (bytes16)(words4){start, start, start, start};
    if (kind > 2 || (kind < 2 && rotation)) return false;
#define STORED(values) store(values, out + (i + q * 4) * stride, stride, count - i - q * 4)
    if (kind == 0) {
        EACH_FOUR(STORED(values_bytes(delta, before)))
    } else if (kind == 1) {
        EACH_FOUR(STORED(values_halves(delta, before)))
    } else {
        EACH_FOUR(STORED(values_words(delta, before, rotation)))
    }
#undef STORED
    memcpy(last, out + (count - 1) * stride, 4);
    return true;
}

bool meshcode_attributes(void *out, size_t count, size_t stride, const unsigned char *data, size_t size) {
    static const uint8_t widths0[4] = {0, 2, 4, 8}, widths1[2][4] = {{0, 1, 2, 4}, {1, 2, 4, 8}};
    if (count == 0 || stride == 0 || stride > 256 || stride % 4 != 0) return false;
    if (size == 0 || (data[0] & 0xf0) != 0xa0 || (data[0] & 15) > 1) return false;
    const bool newer = data[0] & 1;
    const size_t baseline_size = stride + (newer ? stride / 4 : 0), tail_size = MAX(baseline_size, newer ? 24u : 32u);
    if (size < 1 + tail_size) return false;
    const unsigned char *in = data + 1, *end = data + size, *baseline = end - baseline_size, *modes = baseline + stride;
    const size_t block_most = MIN((BLOCK_BYTES / stride) & ~(size_t)15, BLOCK_MOST);
    uint8_t last[256], planes[4][BLOCK_MOST];
    unsigned char *to = out;
    memcpy(last, baseline, stride);
    for (size_t done = 0, block; done < count; done += block, to += block * stride) {
        block = MIN(count - done, block_most);
        const size_t group_count = (block + GROUP - 1) / GROUP;
        const unsigned char *controls = in;
        if (newer) {
            if ((size_t)(end - in) < stride / 4) return false;
            in += stride / 4;
        }
        for (size_t channel = 0; channel < stride / 4; channel++) {
            for (uint32_t p = 0; p < 4; p++) {
                const uint32_t control = newer ? controls[channel] >> p * 2 & 3 : 0;
                if (control == 2) {
                    memset(planes[p], 0, group_count * GROUP);
                } else if (control == 3) { /* the last group is not filled up */
                    if ((size_t)(end - in) < block) return false;
                    memcpy(planes[p], in, block);
                    memset(planes[p] + block, 0, group_count * GROUP - block);
                    in += block;
                } else if (!read_plane(&in, end, newer ? widths1[control] : widths0, group_count, planes[p])) {
                    return false;
                }
            }
            if (!write_channel(planes, block, newer ? modes[channel] : 0, last + channel * 4, to + channel * 4, stride)) return false;
        }
    }
    return (size_t)(end - in) == tail_size;
}

/* ---- filters (Appendix B) ---- */

static inline int32_t nearest(float value) { return (int32_t)(value + copysignf(0.5f, value)); }

static inline void to_unit(const int32_t in[3], float most, int32_t out[3]) {
    const float one = in[2] ? (float)in[2] : 1, sharp = 1 / one;
    float x = (float)in[0] * sharp, y = (float)in[1] * sharp;
    const float z = 1 - fabsf(x) - fabsf(y), fold = MIN(z, 0.0f);
    x -= copysignf(fold, x);
    y -= copysignf(fold, y);
    const float scale = most / sqrtf(x * x + y * y + z * z);
    out[0] = nearest(x * scale);
    out[1] = nearest(y * scale);
    out[2] = nearest(z * scale);
}

void meshcode_filter_octahedral(void *data, size_t count, size_t stride) {
    for (size_t i = 0; i < count; i++) {
        int32_t unit[3];
        if (stride == 4) {
            int8_t *v = (int8_t *)data + i * 4;
            to_unit((const int32_t[3]){v[0], v[1], v[2]}, 127, unit);
            for (int k = 0; k < 3; k++) v[k] = (int8_t)unit[k];
        } else {
            int16_t *v = (int16_t *)data + i * 4;
            to_unit((const int32_t[3]){v[0], v[1], v[2]}, 32767, unit);
            for (int k = 0; k < 3; k++) v[k] = (int16_t)unit[k];
        }
    }
}

void meshcode_filter_quaternion(void *data, size_t count) {
    for (size_t i = 0; i < count; i++) {
        int16_t *v = (int16_t *)data + i * 4;
        const uint32_t largest = (uint32_t)v[3] & 3;
        const float scale = 0.70710678f / (float)(v[3] | 3);
        float part[3], square = 1;
        for (int k = 0; k < 3; k++) {
            part[k] = (float)v[k] * scale;
            square -= part[k] * part[k];
        }
        for (uint32_t k = 0; k < 3; k++) {
            const float kept = MIN(part[k], 1.0f);
            v[(largest + 1 + k) % 4] = (int16_t)nearest(MAX(kept, -1.0f) * 32767);
        }
        v[largest] = (int16_t)nearest(sqrtf(MAX(square, 0.0f)) * 32767);
    }
}

void meshcode_filter_exponential(void *data, size_t count, size_t stride) {
    unsigned char *at = data;
    for (size_t i = 0; i < count * (stride / 4); i++, at += 4) {
        uint32_t bits;
        memcpy(&bits, at, sizeof bits);
        const int32_t exponent = MAX((int32_t)(bits >> 24 ^ 0x80) - 0x80, -126), mantissa = (int32_t)((bits & 0xffffff) ^ 0x800000) - 0x800000;
        const uint32_t power_bits = (uint32_t)(exponent + 127) << 23;
        float power;
        memcpy(&power, &power_bits, sizeof power);
        const float value = power * (float)mantissa;
        memcpy(at, &value, sizeof value);
    }
}

static inline void to_rgb(const int32_t in[4], float most, uint32_t out[4]) {
    const int32_t all = in[3] > 0 ? (int32_t)((2u << (31 - __builtin_clz((uint32_t)in[3]))) - 1) : 1, alpha = in[3] & all >> 1;
    const int32_t rgba[4] = {in[0] + in[1] - in[2], in[0] + in[2], in[0] - in[1] - in[2], alpha << 1 | (alpha & 1)};
    const float scale = most / (float)all;
    for (int k = 0; k < 4; k++) out[k] = (uint32_t)nearest(CLAMP((float)rgba[k] * scale, 0.0f, most));
}

void meshcode_filter_color(void *data, size_t count, size_t stride) {
    for (size_t i = 0; i < count; i++) {
        uint32_t rgba[4];
        if (stride == 4) {
            uint8_t *v = (uint8_t *)data + i * 4;
            to_rgb((const int32_t[4]){v[0], (int8_t)v[1], (int8_t)v[2], v[3]}, 255, rgba);
            for (int k = 0; k < 4; k++) v[k] = (uint8_t)rgba[k];
        } else {
            uint16_t *v = (uint16_t *)data + i * 4;
            to_rgb((const int32_t[4]){v[0], (int16_t)v[1], (int16_t)v[2], v[3]}, 65535, rgba);
            for (int k = 0; k < 4; k++) v[k] = (uint16_t)rgba[k];
        }
    }
}
