/* SPDX-License-Identifier: MIT */
/* KHR_meshopt_compression: attributes of version 0 and all indices by the encoder of meshoptimizer 0.18 or later; version 1 and colours by bytes
   that meshoptimizer 1.3 (npm) made of the values below. */
#include "scene/meshcode.h"
#include "tests/gltf_test_file.h"

#include <meshoptimizer.h>
#include <setjmp.h>

#include <cmocka.h>

/* As encodeVertexBufferLevel(values, count, stride, 3, 1) and, after encodeFilterColor(), (…, 2, 1) write; color_… is what decodeVertexBuffer() reads. */
static const unsigned char packed_v1[650] = {
    161, 119, 120, 170, 95, 85, 0, 122, 126, 116, 120, 124, 114, 118, 122, 126, 116, 120, 124, 114, 118, 122, 126, 116, 120, 124, 114, 118,
    122, 126, 116, 120, 124, 114, 118, 122, 126, 116, 120, 124, 114, 118, 122, 126, 116, 120, 124, 114, 118, 122, 126, 116, 120, 124, 114, 118,
    122, 126, 116, 120, 124, 114, 118, 122, 126, 116, 120, 124, 114, 118, 122, 126, 116, 120, 124, 114, 118, 122, 170, 2, 5, 85, 85, 85,
    85, 85, 85, 85, 85, 85, 85, 85, 85, 85, 85, 85, 85, 85, 85, 85, 85, 85, 85, 85, 85, 85, 85, 85, 85, 85, 85, 85,
    85, 85, 85, 85, 0, 0, 0, 0, 0, 87, 87, 87, 87, 87, 87, 87, 87, 87, 87, 87, 87, 87, 87, 87, 87, 87, 87, 87,
    87, 87, 87, 87, 87, 87, 87, 87, 87, 87, 87, 87, 87, 87, 87, 87, 87, 87, 87, 87, 87, 87, 87, 87, 87, 87, 87, 87,
    87, 87, 87, 87, 87, 87, 87, 87, 87, 87, 87, 87, 87, 87, 87, 87, 87, 87, 87, 87, 87, 87, 87, 87, 85, 1, 42, 170,
    170, 170, 170, 170, 170, 170, 170, 170, 170, 170, 170, 170, 170, 170, 170, 170, 0, 0, 16, 0, 1, 0, 15, 0, 4, 20, 52, 100,
    36, 244, 84, 196, 68, 212, 116, 164, 228, 180, 148, 132, 132, 148, 180, 228, 164, 116, 212, 68, 196, 84, 244, 36, 100, 52, 20, 4,
    130, 138, 154, 178, 146, 250, 170, 98, 162, 234, 186, 82, 242, 90, 202, 66, 194, 74, 218, 114, 210, 58, 106, 226, 241, 149, 189, 137,
    153, 141, 133, 129, 129, 133, 141, 153, 137, 189, 149, 88, 1, 0, 81, 1, 3, 1, 112, 16, 48, 31, 16, 49, 113, 49, 15, 196,
    196, 211, 77, 255, 3, 7, 3, 15, 199, 77, 196, 196, 3, 7, 3, 31, 3, 196, 196, 0, 0, 7, 3, 0, 48, 8, 147, 75,
    235, 22, 98, 22, 34, 130, 90, 56, 100, 145, 173, 4, 52, 84, 193, 200, 201, 173, 168, 199, 126, 126, 151, 173, 111, 101, 155, 141,
    139, 133, 118, 99, 66, 239, 249, 113, 211, 191, 105, 214, 158, 229, 41, 231, 72, 229, 157, 169, 8, 249, 143, 108, 103, 19, 113, 102,
    93, 164, 52, 221, 161, 69, 239, 137, 98, 19, 38, 0, 0, 253, 117, 133, 73, 175, 117, 59, 5, 7, 208, 246, 228, 48, 99, 134,
    35, 58, 210, 177, 4, 214, 40, 209, 247, 92, 209, 62, 67, 166, 47, 72, 215, 96, 130, 111, 55, 70, 6, 248, 175, 165, 155, 160,
    81, 106, 24, 212, 101, 16, 124, 28, 182, 23, 68, 215, 45, 162, 11, 168, 217, 127, 144, 56, 44, 95, 222, 160, 111, 34, 134, 170,
    1, 3, 32, 32, 51, 19, 49, 32, 1, 50, 49, 51, 51, 49, 51, 34, 3, 51, 34, 16, 18, 2, 50, 51, 51, 35, 49, 34,
    3, 49, 48, 33, 50, 211, 104, 0, 0, 3, 3, 85, 1, 1, 80, 69, 5, 84, 17, 0, 81, 84, 81, 16, 64, 20, 5, 4,
    4, 20, 81, 0, 0, 85, 1, 0, 128, 128, 128, 128, 128, 128, 128, 128, 128, 128, 128, 128, 128, 128, 128, 128, 128, 0, 0, 85,
    1, 8, 136, 136, 136, 136, 136, 136, 136, 136, 136, 136, 136, 136, 136, 136, 136, 136, 136, 0, 0, 85, 1, 10, 138, 138, 138, 138,
    138, 138, 138, 138, 138, 138, 138, 138, 138, 138, 138, 138, 138, 0, 0, 85, 1, 42, 170, 170, 170, 170, 170, 170, 170, 170, 170, 170,
    170, 170, 170, 170, 170, 170, 170, 0, 0, 0, 0, 96, 234, 0, 0, 128, 63, 4, 3, 2, 1, 60, 94, 1, 0, 0, 0, 0,
    0, 1, 82, 0, 2, 0,
};
static const unsigned char packed_v1_blocks[294] = {
    161, 165, 0, 0, 0, 0, 0, 2, 2, 4, 8, 2, 2, 16, 32, 2, 2, 64, 128, 2, 2, 0, 1, 2, 2, 4, 2, 2,
    8, 16, 2, 2, 32, 64, 2, 2, 128, 0, 2, 1, 2, 2, 2, 4, 8, 2, 2, 16, 32, 2, 2, 64, 128, 2, 2, 0,
    1, 2, 2, 4, 2, 2, 8, 16, 2, 2, 0, 0, 0, 0, 0, 2, 2, 4, 8, 2, 2, 16, 32, 2, 2, 64, 128, 2,
    2, 0, 1, 2, 2, 4, 2, 2, 8, 16, 2, 2, 32, 64, 2, 2, 128, 0, 2, 1, 2, 2, 2, 4, 8, 2, 2, 16,
    32, 2, 2, 64, 128, 2, 2, 0, 1, 2, 2, 4, 2, 2, 8, 16, 2, 2, 165, 0, 0, 0, 0, 32, 64, 2, 2, 128,
    0, 2, 1, 2, 2, 2, 4, 8, 2, 2, 16, 32, 2, 2, 64, 128, 2, 2, 0, 1, 2, 2, 4, 2, 2, 8, 16, 2,
    2, 32, 64, 2, 2, 128, 0, 2, 1, 2, 2, 2, 4, 8, 2, 2, 16, 32, 2, 2, 64, 128, 2, 2, 0, 1, 2, 0,
    0, 0, 0, 32, 64, 2, 2, 128, 0, 2, 1, 2, 2, 2, 4, 8, 2, 2, 16, 32, 2, 2, 64, 128, 2, 2, 0, 1,
    2, 2, 4, 2, 2, 8, 16, 2, 2, 32, 64, 2, 2, 128, 0, 2, 1, 2, 2, 2, 4, 8, 2, 2, 16, 32, 2, 2,
    64, 128, 2, 2, 0, 1, 2, 160, 1, 2, 4, 2, 2, 1, 2, 4, 2, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0,
    0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0,
};
static const unsigned char packed_color_4_8[62] = {
    161, 255, 0, 1, 130, 0, 140, 87, 40, 29, 82, 0, 0, 254, 4, 179, 9, 100, 251, 83, 0, 0, 125, 1, 76, 118, 103, 80,
    4, 0, 254, 0, 125, 90, 27, 60, 223, 5, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0,
    0, 0, 0, 0, 128, 0,
};
static const unsigned char color_4_8[36] = {
    0, 0, 0, 0, 255, 255, 255, 255, 254, 1, 0, 255, 1, 0, 255, 128, 199, 108, 121, 219, 91, 123, 23, 191, 213, 91, 45, 251,
    32, 116, 116, 27, 29, 159, 197, 20,
};
static const unsigned char packed_color_4_5[62] = {
    161, 255, 0, 62, 45, 0, 16, 9, 4, 3, 10, 0, 0, 30, 59, 38, 0, 12, 29, 9, 0, 0, 13, 1, 10, 14, 11, 8,
    0, 0, 30, 0, 13, 10, 3, 8, 27, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0,
    0, 0, 0, 0, 16, 0,
};
static const unsigned char color_4_5[36] = {
    0, 0, 0, 0, 255, 255, 255, 255, 247, 8, 0, 255, 8, 0, 255, 132, 189, 107, 123, 222, 90, 123, 25, 189, 206, 90, 41, 255,
    33, 107, 115, 25, 33, 148, 197, 25,
};
static const unsigned char packed_color_8_16[99] = {
    161, 255, 255, 0, 1, 2, 0, 12, 215, 168, 157, 210, 0, 0, 128, 0, 140, 86, 39, 30, 82, 0, 0, 254, 4, 179, 9, 100,
    251, 83, 0, 0, 255, 0, 177, 9, 99, 253, 83, 0, 0, 2, 1, 204, 246, 24, 208, 123, 0, 0, 127, 0, 74, 118, 103, 82,
    4, 0, 1, 0, 2, 218, 228, 60, 223, 5, 0, 254, 0, 125, 90, 27, 60, 223, 5, 0, 0, 0, 0, 0, 0, 0, 0, 0,
    0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 128, 1, 0,
};
static const unsigned char color_8_16[72] = {
    0, 0, 0, 0, 0, 0, 0, 0, 255, 255, 255, 255, 255, 255, 255, 255, 254, 255, 1, 0, 0, 0, 255, 255, 1, 0, 0, 0,
    255, 255, 0, 128, 199, 199, 108, 107, 121, 121, 219, 218, 91, 92, 123, 123, 23, 23, 191, 191, 213, 213, 91, 91, 45, 45, 251, 251,
    32, 31, 116, 116, 116, 116, 27, 27, 29, 29, 159, 159, 197, 197, 20, 21,
};
static const unsigned char packed_color_8_11[95] = {
    161, 247, 119, 0, 254, 253, 0, 96, 183, 62, 245, 150, 1, 60, 228, 128, 0, 15, 11, 4, 0, 0, 254, 251, 112, 71, 26, 237,
    153, 0, 0, 7, 15, 10, 0, 3, 7, 2, 0, 0, 2, 1, 88, 75, 196, 132, 28, 0, 244, 0, 3, 2, 4, 3, 2, 0,
    1, 0, 2, 214, 217, 29, 250, 47, 1, 49, 155, 0, 0, 6, 5, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0,
    0, 0, 0, 0, 0, 0, 0, 0, 4, 1, 0,
};
static const unsigned char color_8_11[72] = {
    0, 0, 0, 0, 0, 0, 0, 0, 255, 255, 255, 255, 255, 255, 255, 255, 223, 255, 32, 0, 0, 0, 255, 255, 32, 0, 0, 0,
    255, 255, 16, 128, 184, 199, 141, 107, 111, 121, 251, 218, 107, 92, 79, 123, 35, 23, 151, 191, 186, 213, 107, 91, 37, 45, 255, 251,
    36, 31, 78, 116, 110, 116, 3, 27, 36, 29, 115, 159, 184, 197, 3, 21,
};

static struct test_log file_log;

static uint32_t next_random(uint32_t *state) {
    *state = *state * 1664525u + 1013904223u;
    return *state >> 24;
}

/* ---- attributes ---- */

enum { MOST = 1100 * 256 };
static unsigned char values[MOST], decoded[MOST], packed[MOST * 2 + 4096];

/* Steps, waves of floats, noise of so many bits, constants. */
static void make_values(uint32_t style, size_t count, size_t stride) {
    uint32_t random = style + 1;
    for (size_t i = 0; i < count; i++)
        for (size_t k = 0; k < stride; k += 4) {
            const float wave = sinf((float)i * 0.1f + (float)k) * 10;
            uint32_t word = style == 0 ? (uint32_t)(i * (k + 1)) : style == 3 ? 0x11223344u : 0;
            if (style == 1) memcpy(&word, &wave, 4);
            for (uint32_t b = 0; style == 2 && b < 4; b++) word |= (next_random(&random) >> (k + b) % 8) << b * 8;
            memcpy(values + i * stride + k, &word, 4);
        }
}

static void test_attributes_version_0_MA_10(void **state) {
    UNUSED(state);
    static const size_t shapes[][2] = {{1, 4}, {15, 8}, {16, 12}, {17, 16}, {255, 20}, {256, 32}, {257, 32}, {513, 36}, {300, 252}, {70, 256}, {1100, 4}};
    for (uint32_t style = 0; style < 4; style++)
        for (uint32_t i = 0; i < COUNT_OF(shapes); i++) {
            const size_t count = shapes[i][0], stride = shapes[i][1];
            make_values(style, count, stride);
            const size_t size = meshopt_encodeVertexBuffer(packed, sizeof packed, values, count, stride);
            assert_true(size > 0 && packed[0] == 0xa0);
            memset(decoded, 0xee, count * stride + 1);
            assert_true(meshcode_attributes(decoded, count, stride, packed, size));
            assert_memory_equal(decoded, values, count * stride);
            assert_int_equal(decoded[count * stride], 0xee);
        }
}

static void test_attributes_version_1_MA_10(void **state) {
    UNUSED(state);
    enum { COUNT = 72, STRIDE = 20, LONG = 530 };
    /* Every control mode, and every channel mode, one of them with a rotation. */
    static const unsigned char channels[5] = {1, 0x52, 0, 2, 0};
    uint32_t random = 1, controls = 0;
    assert_memory_equal(packed_v1 + sizeof packed_v1 - 5, channels, sizeof channels);
    for (uint32_t i = 0; i < 20; i++) controls |= 1u << (packed_v1[1 + i / 4] >> i % 4 * 2 & 3);
    assert_int_equal(controls, 15);
    for (uint32_t i = 0; i < COUNT; i++) {
        unsigned char *at = values + i * STRIDE;
        const uint16_t halves[2] = {(uint16_t)(i * 700 + i * i % 7), (uint16_t)(60000 - i * 300)};
        const float single = 1 + (float)(i * i) / 1024;
        const uint32_t word = 0x01020304;
        memcpy(at, halves, 4);
        memcpy(at + 4, &single, 4);
        memcpy(at + 8, &word, 4);
        for (uint32_t k = 0; k < 4; k++) {
            const uint32_t byte = next_random(&random);
            at[12 + k] = (unsigned char)(k < 2 ? byte : byte & (k == 2 ? 3 : 1));
            at[16 + k] = (unsigned char)(i * (k + 1) >> 2);
        }
    }
    assert_true(meshcode_attributes(decoded, COUNT, STRIDE, packed_v1, sizeof packed_v1));
    assert_memory_equal(decoded, values, COUNT * STRIDE);
    for (uint32_t i = 0; i < LONG; i++) { /* three blocks */
        const uint32_t word = i / 9 * 257;
        memcpy(values + i * 4, &word, 4);
    }
    assert_true(meshcode_attributes(decoded, LONG, 4, packed_v1_blocks, sizeof packed_v1_blocks));
    assert_memory_equal(decoded, values, LONG * 4);
}

static void test_attributes_broken_MA_10(void **state) {
    UNUSED(state);
    for (uint32_t version = 0; version < 2; version++) {
        const size_t count = 72, stride = 20;
        size_t size = sizeof packed_v1;
        memcpy(packed, packed_v1, size);
        if (version == 0) size = meshopt_encodeVertexBuffer(packed, sizeof packed, values, count, stride);
        assert_true(meshcode_attributes(decoded, count, stride, packed, size));
        for (size_t cut = 0; cut < size; cut++) { /* a copy of its own size, so that reading on is seen */
            unsigned char *copy = malloc(MAX(cut, 1));
            memcpy(copy, packed, cut);
            assert_false(meshcode_attributes(decoded, count, stride, copy, cut));
            free(copy);
        }
        assert_false(meshcode_attributes(decoded, count, stride, packed, size + 1));
        assert_false(meshcode_attributes(decoded, count + 64, stride, packed, size));
        packed[0] ^= 0x10;
        assert_false(meshcode_attributes(decoded, count, stride, packed, size));
        packed[0] = 0xa2;
        assert_false(meshcode_attributes(decoded, count, stride, packed, size));
        packed[0] = (unsigned char)(0xa0 + version);
        if (version == 0) continue;
        static const unsigned char wrong[] = {3, 0x10, 0x21, 0x0f};
        for (uint32_t i = 0; i < COUNT_OF(wrong); i++) {
            packed[size - 3] = wrong[i];
            assert_false(meshcode_attributes(decoded, count, stride, packed, size));
        }
    }
    assert_false(meshcode_attributes(decoded, 1, 6, packed_v1, sizeof packed_v1));
    assert_false(meshcode_attributes(decoded, 1, 260, packed_v1, sizeof packed_v1));
    assert_false(meshcode_attributes(decoded, 0, 4, packed_v1, sizeof packed_v1));
}

/* ---- indices ---- */

enum { SIDE = 24, CORNERS = SIDE * SIDE * 6 };
static uint32_t corners[CORNERS], read_corners[CORNERS];

/* A grid in order; its triangles jumbled with jumps; no order at all. */
static void make_corners(uint32_t style) {
    uint32_t *to = corners, random = 5;
    for (uint32_t y = 0; y < SIDE; y++)
        for (uint32_t x = 0; x < SIDE; x++) {
            const uint32_t a = y * (SIDE + 1) + x, quad[6] = {a, a + SIDE + 1, a + 1, a + 1, a + SIDE + 1, a + SIDE + 2};
            memcpy(to, quad, sizeof quad);
            to += 6;
        }
    for (uint32_t i = 0; style && i < CORNERS; i++) {
        if (style == 1 && i % 40 < 3) corners[i] += 1000 * (i % 7);
        if (style == 2) corners[i] = next_random(&random) * 131 + next_random(&random);
    }
}

static bool same_turned(const uint32_t *a, const uint32_t *b) {
    for (uint32_t turn = 0; turn < 3; turn++)
        if (a[0] == b[turn] && a[1] == b[(turn + 1) % 3] && a[2] == b[(turn + 2) % 3]) return true;
    return false;
}

static void test_indices_MA_10(void **state) {
    UNUSED(state);
    for (uint32_t version = 0; version < 2; version++)
        for (uint32_t style = 0; style < 3; style++) {
            make_corners(style);
            meshopt_encodeIndexVersion((int)version);
            size_t size = meshopt_encodeIndexBuffer(packed, sizeof packed, corners, CORNERS);
            assert_int_equal(packed[0], 0xe0 + version);
            assert_true(meshcode_triangles(read_corners, CORNERS, 4, packed, size));
            for (uint32_t i = 0; i < CORNERS; i += 3) assert_true(same_turned(corners + i, read_corners + i));
            assert_int_equal(meshopt_decodeIndexBuffer(decoded, CORNERS, 4, packed, size), 0);
            assert_memory_equal(read_corners, decoded, sizeof read_corners);
            assert_true(meshcode_triangles(decoded, CORNERS, 2, packed, size));
            for (uint32_t i = 0; i < CORNERS; i++) assert_int_equal(((uint16_t *)decoded)[i], (uint16_t)read_corners[i]);
            for (size_t cut = 0; style == 1 && cut < size; cut += 3) {
                unsigned char *copy = malloc(MAX(cut, 1));
                memcpy(copy, packed, cut);
                assert_false(meshcode_triangles(decoded, CORNERS, 4, copy, cut));
                free(copy);
            }
            assert_false(meshcode_triangles(decoded, CORNERS, 4, packed, size + 1));
            size = meshopt_encodeIndexSequence(packed, sizeof packed, corners, CORNERS);
            assert_int_equal(packed[0], 0xd0 + version);
            assert_true(meshcode_indices(read_corners, CORNERS, 4, packed, size));
            assert_memory_equal(read_corners, corners, sizeof corners);
            assert_true(meshcode_indices(decoded, CORNERS, 2, packed, size));
            assert_int_equal(((uint16_t *)decoded)[CORNERS - 1], (uint16_t)corners[CORNERS - 1]);
            assert_false(meshcode_indices(decoded, CORNERS, 4, packed, size - 1));
            assert_false(meshcode_indices(decoded, CORNERS - 1, 4, packed, size));
        }
    meshopt_encodeIndexVersion(1);
    /* By hand: one triangle 0 1 2; then an edge, and a vertex, that no triangle has left; a table that must not be; a number of six bytes. */
    unsigned char one[] = {0xe1, 0xf0, 0x00, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0};
    assert_false(meshcode_triangles(read_corners, 3, 4, one, sizeof one)); /* a byte of data that nothing reads */
    assert_true(meshcode_triangles(read_corners, 3, 4, one, sizeof one - 1));
    assert_true(read_corners[0] == 0 && read_corners[1] == 1 && read_corners[2] == 2);
    one[1] = 0x00;
    assert_false(meshcode_triangles(read_corners, 3, 4, one, sizeof one - 1));
    one[1] = 0xf0;
    one[2] = 0x10;
    assert_false(meshcode_triangles(read_corners, 3, 4, one, sizeof one - 1));
    one[2] = 0;
    one[16] = 1;
    assert_false(meshcode_triangles(read_corners, 3, 4, one, sizeof one - 1));
    /* Five triangles alone, then one at the youngest edge: in version 0 with the 14th youngest vertex, in version 1 with the one before the last. */
    unsigned char old[] = {0xe0, 0xf0, 0xf0, 0xf0, 0xf0, 0xf0, 0x0d, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0};
    assert_true(meshcode_triangles(read_corners, 18, 4, old, sizeof old));
    assert_true(read_corners[15] == 12 && read_corners[16] == 14 && read_corners[17] == 1);
    old[0] = 0xe1;
    assert_true(meshcode_triangles(read_corners, 18, 4, old, sizeof old));
    assert_true(read_corners[17] == UINT32_MAX);
    static const unsigned char number[] = {0xd1, 0x80, 0x80, 0x80, 0x80, 0x80, 0x00, 0, 0, 0, 0};
    assert_false(meshcode_indices(read_corners, 1, 4, number, sizeof number));
}

/* ---- filters ---- */

static int32_t worst_difference(const void *a, const void *b, size_t count, size_t stride, bool is_signed) {
    int32_t worst = 0;
    for (size_t i = 0; i < count * 4; i++) {
        int32_t x, y;
        if (stride == 4) {
            x = is_signed ? ((const int8_t *)a)[i] : ((const uint8_t *)a)[i];
            y = is_signed ? ((const int8_t *)b)[i] : ((const uint8_t *)b)[i];
        } else {
            x = is_signed ? ((const int16_t *)a)[i] : ((const uint16_t *)a)[i];
            y = is_signed ? ((const int16_t *)b)[i] : ((const uint16_t *)b)[i];
        }
        worst = MAX(worst, abs(x - y));
    }
    return worst;
}

/* One unit in the last place, as the extension allows; the exponential filter is exact. */
static void test_filters_MA_10(void **state) {
    UNUSED(state);
    enum { COUNT = 500 };
    static float given[COUNT * 4], exact[COUNT * 4];
    static unsigned char theirs[COUNT * 16], ours[COUNT * 16];
    struct random_state random = {3};
    for (int i = 0; i < COUNT; i++) {
        float square = 0;
        for (int k = 0; k < 4; k++) given[i * 4 + k] = random_range(&random, -1, 1);
        const int parts = 3;
        for (int k = 0; k < parts; k++) square += given[i * 4 + k] * given[i * 4 + k];
        for (int k = 0; k < parts; k++) given[i * 4 + k] /= sqrtf(square);
    }
    for (int bits = 2; bits <= 16; bits++)
        for (size_t stride = 4; stride <= 8; stride += 4) {
            if (stride == 4 && bits > 8) continue;
            meshopt_encodeFilterOct(ours, COUNT, stride, bits, given);
            memcpy(theirs, ours, sizeof ours);
            meshcode_filter_octahedral(ours, COUNT, stride);
            meshopt_decodeFilterOct(theirs, COUNT, stride);
            assert_true(worst_difference(ours, theirs, COUNT, stride, true) <= 1);
        }
    for (int i = 0; i < COUNT; i++)
        for (int k = 0; k < 4; k++) exact[i * 4 + k] = k == 3 ? sqrtf(0.5f) : given[i * 4 + k] * sqrtf(0.5f); /* unit quaternions */
    for (int bits = 4; bits <= 16; bits++) {
        meshopt_encodeFilterQuat(ours, COUNT, 8, bits, exact);
        memcpy(theirs, ours, sizeof ours);
        meshcode_filter_quaternion(ours, COUNT);
        meshopt_decodeFilterQuat(theirs, COUNT, 8);
        assert_true(worst_difference(ours, theirs, COUNT, 8, true) <= 1);
    }
    for (int i = 0; i < COUNT * 4; i++) exact[i] = ldexpf(given[i], i % 160 - 80);
    for (int bits = 1; bits <= 24; bits++) {
        meshopt_encodeFilterExp(ours, COUNT, 16, bits, exact);
        memcpy(theirs, ours, sizeof ours);
        meshcode_filter_exponential(ours, COUNT, 16);
        meshopt_decodeFilterExp(theirs, COUNT, 16);
        assert_memory_equal(ours, theirs, sizeof ours);
    }
    /* Nonsense gives something, without undefined behaviour. */
    for (uint32_t seed = 1; seed < 9; seed++) {
        uint32_t bytes = seed;
        for (size_t i = 0; i < sizeof ours; i++) theirs[i] = (unsigned char)(seed == 1 ? 0 : seed == 2 ? 0x80 * (i % 2) : next_random(&bytes));
        for (int filter = 0; filter < 6; filter++) {
            memcpy(ours, theirs, sizeof ours);
            if (filter < 2) meshcode_filter_octahedral(ours, COUNT, filter ? 8 : 4);
            if (filter == 2) meshcode_filter_quaternion(ours, COUNT);
            if (filter == 3) meshcode_filter_exponential(ours, COUNT, 16);
            if (filter > 3) meshcode_filter_color(ours, COUNT, filter == 4 ? 4 : 8);
        }
    }
}

static void test_color_filter_MA_10(void **state) {
    UNUSED(state);
    static const struct {
        const unsigned char *packed, *want;
        size_t size, stride;
    } cases[] = {
        {packed_color_4_8, color_4_8, sizeof packed_color_4_8, 4},
        {packed_color_4_5, color_4_5, sizeof packed_color_4_5, 4},
        {packed_color_8_16, color_8_16, sizeof packed_color_8_16, 8},
        {packed_color_8_11, color_8_11, sizeof packed_color_8_11, 8},
    };
    for (uint32_t i = 0; i < COUNT_OF(cases); i++) {
        assert_true(meshcode_attributes(decoded, 9, cases[i].stride, cases[i].packed, cases[i].size));
        meshcode_filter_color(decoded, 9, cases[i].stride);
        assert_true(worst_difference(decoded, cases[i].want, 9, cases[i].stride, false) <= 1);
    }
}

/* ---- files ---- */

/* Positions and colours of nine points in buffer 0, one after the other. */
static fnl_scene *load_points(const char *extension, const char *filter) {
    static unsigned char binary[4096];
    float positions[9 * 3];
    for (uint32_t i = 0; i < 27; i++) positions[i] = (float)i;
    memcpy(binary, packed_color_4_8, sizeof packed_color_4_8);
    const size_t size = meshopt_encodeVertexBuffer(binary + 512, 1024, positions, 9, 12);
    char json[2048];
    snprintf(json, sizeof json,
             "{\"asset\":{\"version\":\"2.0\"},\"extensionsUsed\":[\"%s\"],\"extensionsRequired\":[\"%s\"],"
             "\"buffers\":[{\"byteLength\":4096},{\"byteLength\":144,\"uri\":\"missing.bin\",\"extensions\":{\"%s\":{\"fallback\":true}}}],"
             "\"bufferViews\":[{\"buffer\":1,\"byteLength\":36,\"byteStride\":4,\"extensions\":{\"%s\":{\"buffer\":0,\"byteLength\":%zu,"
             "\"byteStride\":4,\"count\":9,\"mode\":\"ATTRIBUTES\",\"filter\":\"%s\"}}},{\"buffer\":1,\"byteOffset\":36,\"byteLength\":108,"
             "\"byteStride\":12,\"extensions\":{\"%s\":{\"buffer\":0,\"byteOffset\":512,\"byteLength\":%zu,\"byteStride\":12,\"count\":9,"
             "\"mode\":\"ATTRIBUTES\"}}}],\"accessors\":[{\"bufferView\":1,\"componentType\":5126,\"type\":\"VEC3\",\"count\":9},"
             "{\"bufferView\":0,\"componentType\":5121,\"normalized\":true,\"type\":\"VEC4\",\"count\":9}],"
             "\"meshes\":[{\"primitives\":[{\"mode\":0,\"attributes\":{\"POSITION\":0,\"COLOR_0\":1}}]}]}",
             extension, extension, extension, extension, sizeof packed_color_4_8, filter, extension, size);
    fnl_scene *scene = NULL;
    if (test_load(&file_log, json, binary, sizeof binary, &scene) != FNL_OK) fail_msg("not loaded: %s", file_log.text);
    return scene;
}

static void test_files_of_both_names_MA_10(void **state) {
    UNUSED(state);
    static const char *const names[] = {"KHR_meshopt_compression", "EXT_meshopt_compression"};
    for (uint32_t i = 0; i < 2; i++) {
        fnl_scene *scene = load_points(names[i], "COLOR");
        const struct scene_primitive *p = &scene->primitives.data[0];
        assert_int_equal(p->vertex_count, 9);
        assert_string_equal(scene->extensions.data[0].treatment, "full");
        for (uint32_t k = 0; k < 9; k++) {
            assert_true(p->positions[k].y == (float)(k * 3 + 1));
            assert_float_equal(p->colors[k].x, (float)color_4_8[k * 4] / 255, 0.004f);
            assert_float_equal(p->colors[k].w, (float)color_4_8[k * 4 + 3] / 255, 0.004f);
        }
        assert_int_equal(file_log.count, i * 2); /* the old name has neither the filter nor the version */
        fnl_scene_destroy(&scene);
    }
    fnl_scene *scene = load_points("KHR_meshopt_compression", "COLOUR");
    assert_non_null(strstr(file_log.text, "/bufferViews/0/extensions/KHR_meshopt_compression: has an unknown 'filter'"));
    fnl_scene_destroy(&scene);
}

int main(void) {
    meshopt_encodeVertexVersion(0); /* later versions of the library write 1 */
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_attributes_version_0_MA_10), cmocka_unit_test(test_attributes_version_1_MA_10),
        cmocka_unit_test(test_attributes_broken_MA_10),    cmocka_unit_test(test_indices_MA_10),
        cmocka_unit_test(test_filters_MA_10),              cmocka_unit_test(test_color_filter_MA_10),
        cmocka_unit_test(test_files_of_both_names_MA_10),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
