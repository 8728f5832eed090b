/* SPDX-License-Identifier: MIT */
/*
 * KTX2 and DDS as textures of materials. tests/textures holds the picture of `source_picture` as Basis Universal's encoder (2.x) writes it; the hashes are those
 * of what its transcoder makes of these files, and of the blocks below, as RGBA8.
 */
#include "image/bc7.h"
#include "image/texture.h"

#include "tests/test_memory.h"
#include "tests/texture_file.h"

#include "base/file.h"
#include "image/blocks.h"
#include "image/image.h"

#include <math.h>

static struct test_memory memory;
static const struct texture_use whole = {.mips = true};

static void keep_line(void *user, fnl_log_level level, const char *line) {
    struct test_memory *m = user;
    if (level != FNL_LOG_ERROR) return;
    atomic_fetch_add(&m->errors, 1);
    snprintf(m->last_error, sizeof m->last_error, "%s", line);
}

static fnl_host counting_host(void) {
    memory = (struct test_memory){.last_error = ""};
    return host_resolve(&(fnl_host){.user = &memory, .log = keep_line, .reallocate = test_memory_reallocate});
}

static uint32_t random_state = 12345;
static uint32_t random_next(void) {
    random_state = random_state * 1664525 + 1013904223;
    return random_state >> 8;
}

/* ---- Basis Universal ---- */

enum source { OPAQUE, ALPHA, RUNS };

/* RUNS: a flat half, and blocks that repeat down the diagonal: for runs of selectors and endpoints of the block above to the left. */
static void source_pixel(int x, int y, int width, int height, enum source source, int out[4]) {
    if (source == RUNS) {
        const int column = x / 4, row = y / 4;
        out[0] = out[1] = out[2] = row < 8 ? 90 : 40 + 36 * ((column - row + 16) % 6) + ((x ^ y) & 1 ? 12 : -12);
        out[3] = 255;
        return;
    }
    const int dx = 2 * x - width, dy = 2 * y - height;
    const bool disc = dx * dx + dy * dy < height * height / 4;
    out[0] = disc ? 220 : 255 * x / width;
    out[1] = disc ? 60 + 100 * y / height : 255 * y / height;
    out[2] = disc ? 40 : 160;
    out[3] = source == OPAQUE || disc ? 255 : (255 * width - 120 * x) / width;
}

static double psnr(const struct texture *t, enum source source) {
    double sum = 0;
    for (int y = 0; y < (int)t->height; y++)
        for (int x = 0; x < (int)t->width; x++) {
            int pixel[4];
            source_pixel(x, y, (int)t->width, (int)t->height, source, pixel);
            for (int c = 0; c < 4; c++) {
                const int d = pixel[c] - t->bytes[4 * (y * (int)t->width + x) + c];
                sum += d * d;
            }
        }
    return 10 * log10(255 * 255 * 4.0 * t->width * t->height / sum);
}

static uint64_t hash_of(const struct texture *t) { return hash_bytes(t->bytes, texture_offset(t, t->mips, 0), 0); }

static const struct {
    const char *path;
    uint32_t width, height, mips;
    enum source source;
    enum texture_transfer transfer;
    double least; /* dB */
    uint64_t hash;
} samples[] = {
    {"tests/textures/etc1s.ktx2", 48, 32, 6, OPAQUE, TEXTURE_SRGB, 26, 0xb6bab7f360457c13},
    {"tests/textures/etc1s_alpha.ktx2", 46, 30, 6, ALPHA, TEXTURE_SRGB, 26, 0xafaf422c888fa6fd},
    {"tests/textures/uastc_zstd.ktx2", 48, 32, 6, ALPHA, TEXTURE_SRGB, 44, 0x397562e6ad9ee9e1},
    {"tests/textures/etc1s_runs.ktx2", 128, 64, 1, RUNS, TEXTURE_LINEAR, 40, 0xefc265eac5fc27b2},
};

static void test_files_of_basis_universal_MA_8(void **state) {
    UNUSED(state);
    fnl_host host = counting_host();
    for (uint32_t i = 0; i < COUNT_OF(samples); i++) {
        struct file_view view;
        struct texture t;
        fnl_image image;
        assert_int_equal(file_load(&host, samples[i].path, &view), FNL_OK);
        assert_int_equal(texture_decode(&host, view.data, view.size, samples[i].path, &whole, &t), FNL_OK);
        assert_true(t.format == TEXTURE_RGBA8 && t.width == samples[i].width && t.height == samples[i].height && t.mips == samples[i].mips);
        assert_int_equal(t.transfer, samples[i].transfer);
        assert_true(psnr(&t, samples[i].source) > samples[i].least);
        assert_true(hash_of(&t) == samples[i].hash);
        /* As a picture it is the greatest mip. */
        assert_int_equal(fnl_image_load(&host, samples[i].path, &image), FNL_OK);
        assert_true(image.format == FNL_PIXEL_FORMAT_RGBA8 && image.width == t.width && image.height == t.height);
        assert_memory_equal(image.pixels, t.bytes, (size_t)t.width * t.height * 4);
        fnl_image_free(&host, &image);
        texture_free(&host, &t);
        file_free(&host, &view);
    }
    assert_int_equal(atomic_load(&memory.live_bytes), 0);
}

/* ---- BC7 of UASTC and ETC1S ---- */

/* Of all mips: what BC7 shows against RGBA8. */
static double psnr_of_blocks(const struct texture *blocks, const struct texture *plain) {
    double sum = 0, count = 0;
    for (uint32_t mip = 0; mip < plain->mips; mip++) {
        const uint32_t width = texture_side(plain->width, mip), height = texture_side(plain->height, mip);
        const unsigned char *block = blocks->bytes + texture_offset(blocks, mip, 0), *want = plain->bytes + texture_offset(plain, mip, 0);
        for (uint32_t y = 0; y < height; y++)
            for (uint32_t x = 0; x < width; x++) {
                uint8_t texels[16][4];
                block_decode(TEXTURE_BC7, block + (size_t)16 * (y / 4 * DIVIDE_UP(width, 4u) + x / 4), texels);
                for (uint32_t c = 0; c < 4; c++) {
                    const double d = texels[y % 4 * 4 + x % 4][c] - want[4 * ((size_t)y * width + x) + c];
                    sum += d * d;
                    count++;
                }
            }
    }
    return sum > 0 ? 10 * log10(255 * 255 * count / sum) : 99;
}

static void test_files_of_basis_universal_become_BC7_MA_8(void **state) {
    UNUSED(state);
    static const double least[] = {40, 40, 44}; /* dB, against RGBA8 */
    const struct texture_use use = {.mips = true, .keep = 1u << TEXTURE_BC7};
    fnl_host host = counting_host();
    for (uint32_t i = 0; i < COUNT_OF(samples); i++) {
        struct file_view view;
        struct texture blocks, plain;
        assert_int_equal(file_load(&host, samples[i].path, &view), FNL_OK);
        assert_int_equal(texture_decode(&host, view.data, view.size, samples[i].path, &use, &blocks), FNL_OK);
        assert_int_equal(texture_decode(&host, view.data, view.size, samples[i].path, &whole, &plain), FNL_OK);
        if (plain.mips == 1) { /* not all mips: those that are made need RGBA8 */
            assert_int_equal(blocks.format, TEXTURE_RGBA8);
        } else {
            assert_true(blocks.format == TEXTURE_BC7 && blocks.width == plain.width && blocks.height == plain.height && blocks.mips == plain.mips);
            assert_true(texture_face_bytes(&blocks, 0) == (size_t)DIVIDE_UP(plain.width, 4u) * DIVIDE_UP(plain.height, 4u) * 16);
            const double found = psnr_of_blocks(&blocks, &plain);
            print_message("%s: BC7 is %.1f dB from RGBA8\n", samples[i].path, found);
            assert_true(found > least[i]);
        }
        texture_free(&host, &blocks);
        texture_free(&host, &plain);
        file_free(&host, &view);
    }
    assert_int_equal(atomic_load(&memory.live_bytes), 0);
}

/* Texels that lie as a mode of BC7 has them come back nearly as they were. */
static void test_structures_of_blocks_become_those_of_BC7_MA_8(void **state) {
    UNUSED(state);
    random_state = 7;
    double worst[3] = {0};
    for (uint32_t n = 0; n < 3000; n++) {
        struct block_structure structure = {.lone = 4};
        const uint32_t kind = n % 3; /* two subsets; three; a channel of its own */
        uint8_t texels[16][4], ends[3][2][4], decoded[16][4];
        unsigned char block[16];
        if (kind == 2) structure.lone = (uint8_t)(random_next() % 4);
        const uint32_t pattern = random_next() % (kind ? 16 : 64);
        for (uint32_t i = 0; kind < 2 && i < 16; i++) structure.subsets[i] = (uint8_t)bc7_subset_of(kind + 2, pattern, i);
        for (uint32_t i = 0; i < sizeof ends; i++) ((uint8_t *)ends)[i] = (uint8_t)random_next();
        for (uint32_t i = 0; i < 16; i++) {
            const uint32_t s = structure.subsets[i], t = random_next() % 4, own = random_next() % 4;
            for (uint32_t c = 0; c < 4; c++) texels[i][c] = (uint8_t)((ends[s][0][c] * (3 - (c == structure.lone ? own : t)) + ends[s][1][c] * (c == structure.lone ? own : t)) / 3);
            if (kind < 2) texels[i][3] = 255;
        }
        bc7_encode((const uint8_t(*)[4])texels, &structure, block);
        bc7_decode(block, decoded);
        double sum = 0;
        for (uint32_t i = 0; i < 64; i++) sum += pow(((uint8_t *)texels)[i] - ((uint8_t *)decoded)[i], 2);
        worst[kind] = fmax(worst[kind], sqrt(sum / 64));
    }
    print_message("two subsets are at most %.2f off, three %.2f, a channel of its own %.2f (root of the mean square)\n", worst[0], worst[1], worst[2]);
    assert_true(worst[0] < 5 && worst[1] < 6 && worst[2] < 5); /* ends of 6, 5 and 7 bits */
}

/* 12288 blocks of random bits, of all modes and patterns. */
static void test_blocks_of_UASTC_MA_8(void **state) {
    UNUSED(state);
    enum { ACROSS = 128, DOWN = 96 };
    static const struct {
        uint8_t code, bits, hints, subsets, patterns;
    } modes[19] = {{1, 4, 15, 1, 1},    {0x35, 6, 15, 1, 1}, {0x1d, 5, 15, 2, 30}, {3, 5, 15, 3, 11}, {0x13, 5, 15, 2, 30}, {0xb, 5, 15, 1, 1}, {0x1b, 5, 15, 1, 1},
                   {7, 5, 15, 2, 19},   {0x17, 5, 0, 1, 1},  {0xf, 5, 23, 2, 30},  {2, 3, 17, 1, 1},  {0, 2, 17, 1, 1},     {6, 3, 17, 1, 1},   {0x1f, 5, 23, 1, 1},
                   {0xd, 5, 23, 1, 1},  {5, 7, 23, 1, 1},    {0x15, 6, 23, 2, 30}, {0x25, 6, 23, 1, 1}, {9, 4, 15, 1, 1}};
    static unsigned char blocks[ACROSS * DOWN * 16];
    random_state = 12345;
    for (uint32_t b = 0; b < ACROSS * DOWN; b++) {
        const uint32_t mode = b % 19, at = modes[mode].bits + modes[mode].hints;
        unsigned char *block = blocks + 16 * b;
        for (uint32_t i = 0; i < 16; i++) block[i] = (unsigned char)random_next();
        block[0] = (unsigned char)((block[0] & ~((1u << modes[mode].bits) - 1)) | modes[mode].code);
        const uint32_t pattern = modes[mode].subsets > 1 ? random_next() % modes[mode].patterns : 0, length = modes[mode].subsets == 3 ? 4 : 5;
        for (uint32_t i = 0; modes[mode].subsets > 1 && i < length; i++)
            block[(at + i) / 8] = (unsigned char)((block[(at + i) / 8] & ~(1u << (at + i) % 8)) | (pattern >> i & 1) << (at + i) % 8);
    }
    const struct test_ktx2 in = {
        .width = 4 * ACROSS, .height = 4 * DOWN, .mips = 1, .bytes = blocks, .sizes = {sizeof blocks}, .model = 166, .transfer = 1, .channel = 3,
    };
    fnl_host host = counting_host();
    struct texture t;
    size_t size;
    unsigned char *file = test_ktx2_make(&in, &size);
    assert_int_equal(texture_decode(&host, file, size, "blocks.ktx2", &whole, &t), FNL_OK);
    assert_true(hash_of(&t) == 0x04d514efa1d6c844);
    texture_free(&host, &t);
    /* No such mode, and no such pattern. */
    static const unsigned char none[2][16] = {{0x45}, {0x1d, 0, 0xf0, 0x1}};
    for (uint32_t i = 0; i < 2; i++) {
        memcpy(file + size - sizeof blocks + 16 * 77, none[i], 16);
        assert_int_equal(texture_decode(&host, file, size, "none.ktx2", &whole, &t), FNL_ERROR_FORMAT);
        assert_non_null(strstr(memory.last_error, "none.ktx2: broken KTX2: mip 0 has a block that is none of UASTC"));
    }
    free(file);
    assert_int_equal(atomic_load(&memory.live_bytes), 0);
}

/* ---- formats that GPUs sample ---- */

/* What the formats say, written as slowly as can be. `at`: the block or texel; x, y inside of it. */
static void expect_color(const unsigned char *at, bool four, bool clear, uint32_t i, double out[4]) {
    const uint32_t ends[2] = {at[0] | (uint32_t)at[1] << 8, at[2] | (uint32_t)at[3] << 8};
    double c[2][3];
    for (int k = 0; k < 2; k++) {
        c[k][0] = (ends[k] >> 11) * 8 + (ends[k] >> 11) / 4; /* as GPUs do it, within 1 of 255 / 31 times the number */
        c[k][1] = (ends[k] >> 5 & 63) * 4 + (ends[k] >> 5 & 63) / 16;
        c[k][2] = (ends[k] & 31) * 8 + (ends[k] & 31) / 4;
    }
    const uint32_t index = at[4 + i / 4] >> i % 4 * 2 & 3;
    const bool steps = four || ends[0] > ends[1];
    const double weight = index == 0 ? 0 : index == 1 ? 1 : index == 2 ? (steps ? 1 / 3.0 : 0.5) : 2 / 3.0;
    for (int k = 0; k < 3; k++) out[k] = !steps && index == 3 ? 0 : c[0][k] * (1 - weight) + c[1][k] * weight;
    out[3] = clear && !steps && index == 3 ? 0 : 255;
}

static double expect_channel(const unsigned char *at, uint32_t i) {
    uint32_t index = 0;
    for (uint32_t k = 0; k < 3; k++) index |= (uint32_t)(at[2 + (3 * i + k) / 8] >> (3 * i + k) % 8 & 1) << k;
    const double a = at[0], b = at[1];
    if (index < 2) return index ? b : a;
    if (at[0] > at[1]) return a + (b - a) * (index - 1) / 7;
    return index == 6 ? 0 : index == 7 ? 255 : a + (b - a) * (index - 1) / 5;
}

static void expect_texel(enum texture_format format, const unsigned char *at, uint32_t i, double out[4]) {
    const double plain[4] = {0, 0, 0, 255};
    memcpy(out, plain, sizeof plain);
    switch (format) {
    case TEXTURE_R8:
        out[0] = at[0];
        return;
    case TEXTURE_RG8:
        out[0] = at[0];
        out[1] = at[1];
        return;
    case TEXTURE_RGBA8:
        for (int c = 0; c < 4; c++) out[c] = at[c];
        return;
    case TEXTURE_BGRA8:
        for (int c = 0; c < 4; c++) out[c] = at[c < 3 ? 2 - c : 3];
        return;
    case TEXTURE_BC1:
    case TEXTURE_BC1_ALPHA:
        expect_color(at, false, format == TEXTURE_BC1_ALPHA, i, out);
        return;
    case TEXTURE_BC3:
        expect_color(at + 8, true, false, i, out);
        out[3] = expect_channel(at, i);
        return;
    case TEXTURE_BC4:
        out[0] = expect_channel(at, i);
        return;
    case TEXTURE_BC5:
        out[0] = expect_channel(at, i);
        out[1] = expect_channel(at + 8, i);
        return;
    default:
        fail();
    }
}

static void check_texels(const struct texture *in, const struct texture *out, bool flip_x, bool flip_y, const char *swizzle) {
    assert_true(out->format == TEXTURE_RGBA8 && out->width == in->width && out->height == in->height && out->mips == in->mips);
    for (uint32_t mip = 0; mip < in->mips; mip++) {
        const uint32_t width = texture_side(in->width, mip), height = texture_side(in->height, mip), block = block_bytes(in->format);
        for (uint32_t y = 0; y < height; y++)
            for (uint32_t x = 0; x < width; x++) {
                const size_t index = block ? (size_t)y / 4 * DIVIDE_UP(width, 4u) + x / 4 : (size_t)y * width + x;
                const size_t size = block ? block : texture_face_bytes(in, mip) / width / height;
                double texel[6] = {0, 0, 0, 0, 0, 255};
                expect_texel(in->format, in->bytes + texture_offset(in, mip, 0) + index * size, y % 4 * 4 + x % 4, texel);
                const uint32_t to_x = flip_x ? width - 1 - x : x, to_y = flip_y ? height - 1 - y : y;
                const unsigned char *got = out->bytes + texture_offset(out, mip, 0) + 4 * ((size_t)to_y * width + to_x);
                for (int c = 0; c < 4; c++) assert_true(fabs(got[c] - texel[swizzle ? strchr("rgba01", swizzle[c]) - "rgba01" : c]) < 0.501);
            }
    }
}

static const struct {
    enum texture_format format;
    uint8_t vulkan, srgb, dxgi;
} formats[] = {
    {TEXTURE_R8, 9, 15, 61},   {TEXTURE_RG8, 16, 22, 49},        {TEXTURE_RGBA8, 37, 43, 28}, {TEXTURE_BGRA8, 44, 50, 87}, {TEXTURE_BC1, 131, 132, 0},
    {TEXTURE_BC1_ALPHA, 133, 134, 71}, {TEXTURE_BC3, 137, 138, 77}, {TEXTURE_BC4, 139, 0, 80},   {TEXTURE_BC5, 141, 0, 83},
};

static struct texture random_texture(const fnl_host *host, enum texture_format format, uint32_t mips) {
    struct texture t = {.format = format, .width = 19, .height = 10, .faces = 1, .mips = mips};
    assert_int_equal(texture_allocate(host, &t), FNL_OK);
    for (size_t i = 0; i < texture_offset(&t, mips, 0); i++) t.bytes[i] = (unsigned char)random_next();
    return t;
}

static struct test_ktx2 file_of(const struct texture *t, uint32_t vulkan, uint32_t scheme) {
    struct test_ktx2 in = {.format = vulkan, .width = t->width, .height = t->height, .mips = t->mips, .scheme = scheme, .bytes = t->bytes};
    for (uint32_t mip = 0; mip < t->mips; mip++) in.sizes[mip] = texture_face_bytes(t, mip);
    return in;
}

static void test_formats_of_KTX2_MA_8(void **state) {
    UNUSED(state);
    static const uint32_t schemes[] = {0, 2, 3};
    fnl_host host = counting_host();
    for (uint32_t k = 0; k < COUNT_OF(formats) * 3; k++) {
        const uint32_t vulkan = k & 1 && formats[k / 3].srgb ? formats[k / 3].srgb : formats[k / 3].vulkan;
        struct texture t = random_texture(&host, formats[k / 3].format, 5), decoded, kept;
        const struct test_ktx2 in = file_of(&t, vulkan, schemes[k % 3]);
        size_t size;
        unsigned char *file = test_ktx2_make(&in, &size);
        assert_int_equal(texture_decode(&host, file, size, "a.ktx2", &whole, &decoded), FNL_OK);
        assert_int_equal(decoded.transfer, vulkan == formats[k / 3].srgb ? TEXTURE_SRGB : TEXTURE_LINEAR);
        check_texels(&t, &decoded, false, false, NULL);
        texture_free(&host, &decoded);
        /* Kept as it is where that is allowed. */
        assert_int_equal(texture_decode(&host, file, size, "a.ktx2", &(struct texture_use){.mips = true, .keep = 1u << t.format}, &kept), FNL_OK);
        assert_true(kept.format == t.format && kept.mips == 5);
        assert_memory_equal(kept.bytes, t.bytes, texture_offset(&t, 5, 0));
        texture_free(&host, &kept);
        free(file);
        texture_free(&host, &t);
    }
    assert_int_equal(atomic_load(&memory.live_bytes), 0);
}

/* A file with some mips is one with none: they are made, as for other pictures. */
static void test_mips_are_whole_or_none_MA_8(void **state) {
    UNUSED(state);
    fnl_host host = counting_host();
    for (uint32_t mips = 1; mips <= 5; mips++) {
        struct texture t = random_texture(&host, TEXTURE_BC3, mips), out;
        const struct test_ktx2 in = file_of(&t, 137, 2);
        size_t size;
        unsigned char *file = test_ktx2_make(&in, &size);
        for (uint32_t k = 0; k < 4; k++) {
            assert_int_equal(texture_decode(&host, file, size, "a.ktx2", &(struct texture_use){.mips = k & 1, .keep = k & 2 ? UINT32_MAX : 0}, &out), FNL_OK);
            assert_int_equal(out.mips, k & 1 && mips == 5 ? 5 : 1);
            assert_int_equal(out.format, k == 3 && mips == 5 ? TEXTURE_BC3 : TEXTURE_RGBA8);
            texture_free(&host, &out);
        }
        free(file);
        texture_free(&host, &t);
    }
}

static void test_orientation_and_swizzle_MA_8(void **state) {
    UNUSED(state);
    static const struct {
        const char *orientation, *swizzle;
        bool x, y;
    } cases[] = {{"rd", "rgba", false, false}, {"ru", NULL, false, true},     {"ld", NULL, true, false},
                 {"lu", "bgr1", true, true}, {NULL, "rrr1", false, false}, {"rd", "0gab", false, false}};
    fnl_host host = counting_host();
    for (uint32_t k = 0; k < COUNT_OF(cases); k++) {
        struct texture t = random_texture(&host, k & 1 ? TEXTURE_RGBA8 : TEXTURE_BC3, 5), out;
        struct test_ktx2 in = file_of(&t, k & 1 ? 37 : 137, 0);
        in.orientation = cases[k].orientation;
        in.swizzle = cases[k].swizzle;
        size_t size;
        unsigned char *file = test_ktx2_make(&in, &size);
        /* What would have to be turned on the device is decoded. */
        assert_int_equal(texture_decode(&host, file, size, "a.ktx2", &(struct texture_use){.mips = true, .keep = k ? UINT32_MAX : 0}, &out), FNL_OK);
        check_texels(&t, &out, cases[k].x, cases[k].y, cases[k].swizzle);
        texture_free(&host, &out);
        free(file);
        texture_free(&host, &t);
    }
}

/* Normal maps of two channels get the third, and are decoded for it; other data does not. */
static void test_normals_of_two_channels_MA_8(void **state) {
    UNUSED(state);
    fnl_host host = counting_host();
    for (uint32_t k = 0; k < 4; k++) {
        const enum texture_format formats_of[] = {TEXTURE_RG8, TEXTURE_BC5, TEXTURE_BC5, TEXTURE_BC3};
        const uint32_t vulkan[] = {16, 141, 141, 137};
        struct texture t = random_texture(&host, formats_of[k], 5), plain, out;
        const struct test_ktx2 in = file_of(&t, vulkan[k], 0);
        size_t size;
        unsigned char *file = test_ktx2_make(&in, &size);
        const struct texture_use use = {.mips = true, .normals = k != 2, .keep = k == 3 ? 0 : UINT32_MAX};
        assert_int_equal(texture_decode(&host, file, size, "a.ktx2", &whole, &plain), FNL_OK);
        assert_int_equal(texture_decode(&host, file, size, "a.ktx2", &use, &out), FNL_OK);
        assert_int_equal(out.format, k == 2 ? TEXTURE_BC5 : TEXTURE_RGBA8);
        for (size_t i = 0; out.format == TEXTURE_RGBA8 && i < texture_offset(&out, 5, 0); i += 4) {
            const double x = plain.bytes[i] / 127.5 - 1, y = plain.bytes[i + 1] / 127.5 - 1, z = sqrt(fmax(1 - x * x - y * y, 0));
            assert_true(out.bytes[i] == plain.bytes[i] && out.bytes[i + 1] == plain.bytes[i + 1] && out.bytes[i + 3] == plain.bytes[i + 3]);
            assert_true(fabs(out.bytes[i + 2] - (k == 3 ? plain.bytes[i + 2] : 127.5 + 127.5 * z)) < 0.501);
        }
        texture_free(&host, &plain);
        texture_free(&host, &out);
        free(file);
        texture_free(&host, &t);
    }
    assert_int_equal(atomic_load(&memory.live_bytes), 0);
}

static void test_DDS_MA_8(void **state) {
    UNUSED(state);
    static const struct {
        const char *name;
        enum texture_format format;
    } old[] = {{"DXT1", TEXTURE_BC1_ALPHA}, {"DXT5", TEXTURE_BC3}, {"ATI1", TEXTURE_BC4}, {"ATI2", TEXTURE_BC5}};
    fnl_host host = counting_host();
    for (uint32_t k = 0; k < COUNT_OF(formats) + COUNT_OF(old); k++) {
        const bool is_old = k >= COUNT_OF(formats);
        const enum texture_format format = is_old ? old[k - COUNT_OF(formats)].format : formats[k].format;
        if (!is_old && !formats[k].dxgi) continue;
        struct texture t = random_texture(&host, format, 5), out;
        const size_t bytes = texture_offset(&t, 5, 0), head = is_old ? 128 : 148;
        unsigned char *file = calloc(1, head + bytes);
        assert_non_null(file);
        memcpy(file, "DDS ", 4);
        const uint32_t words[][2] = {{1, 124}, {3, 10}, {4, 19}, {7, 5}, {19, 32}, {20, 4}};
        for (uint32_t i = 0; i < COUNT_OF(words); i++) test_put32(file + 4 * words[i][0], words[i][1]);
        memcpy(file + 84, is_old ? old[k - COUNT_OF(formats)].name : "DX10", 4);
        if (!is_old) {
            test_put32(file + 128, formats[k].dxgi);
            test_put32(file + 132, 3);
            test_put32(file + 140, 1);
        }
        memcpy(file + head, t.bytes, bytes);
        assert_int_equal(texture_decode(&host, file, head + bytes, "a.dds", &whole, &out), FNL_OK);
        check_texels(&t, &out, false, false, NULL);
        texture_free(&host, &out);
        assert_int_equal(texture_decode(&host, file, head + bytes - 1, "a.dds", &whole, &out), FNL_ERROR_FORMAT);
        assert_non_null(strstr(memory.last_error, "a.dds: broken: mip 4, face 0 is cut off"));
        free(file);
        texture_free(&host, &t);
    }
    assert_int_equal(atomic_load(&memory.live_bytes), 0);
}

/* ---- broken files ---- */

static void refuse(struct test_ktx2 in, const char *message) {
    fnl_host host = counting_host();
    static const unsigned char bytes[16 * 16 * 64];
    struct texture out;
    size_t size;
    in.bytes = bytes;
    in.mips = 1;
    in.width = in.height = 16;
    if (!in.sizes[0]) in.sizes[0] = 16 * 16 * 4;
    unsigned char *file = test_ktx2_make(&in, &size);
    assert_true(texture_decode(&host, file, size, "a.ktx2", &whole, &out) != FNL_OK);
    if (!strstr(memory.last_error, message)) fail_msg("'%s' is not in '%s'", message, memory.last_error);
    assert_int_equal(strncmp(memory.last_error, "a.ktx2: ", 8), 0);
    assert_int_equal(atomic_load(&memory.live_bytes), 0);
    free(file);
}

static void test_what_is_refused_MA_8(void **state) {
    UNUSED(state);
    refuse((struct test_ktx2){.format = 10}, "KTX2 of VkFormat 10");
    refuse((struct test_ktx2){.format = 37, .scheme = 4}, "supercompression scheme 4");
    refuse((struct test_ktx2){.format = 37, .scheme = 1}, "VkFormat 37 under BasisLZ");
    refuse((struct test_ktx2){.format = 37, .scheme = 2, .sizes = {1000}}, "level 0 has");
    refuse((struct test_ktx2){.format = 97, .sizes = {16 * 16 * 8}}, "floating-point pictures cannot be used here");
    refuse((struct test_ktx2){.format = 37, .faces = 6, .sizes = {16 * 16 * 24}}, "cube maps cannot be used here");
    refuse((struct test_ktx2){.format = 37, .orientation = "rx"}, "unknown KTXorientation");
    refuse((struct test_ktx2){.format = 37, .swizzle = "rgbx"}, "unknown KTXswizzle");
    refuse((struct test_ktx2){.format = 97, .orientation = "ru", .sizes = {16 * 16 * 8}}, "heeded for pictures of 8 bits alone");
    refuse((struct test_ktx2){.model = 167}, "colour model 167");
    refuse((struct test_ktx2){.model = 166, .channel = 5}, "UASTC with channels 5");
    refuse((struct test_ktx2){.model = 166, .scheme = 1}, "UASTC under BasisLZ");
    refuse((struct test_ktx2){.model = 163}, "ETC1S with supercompression scheme 0");
    refuse((struct test_ktx2){.model = 163, .scheme = 1, .channel = 4}, "ETC1S with channels 4");
    refuse((struct test_ktx2){.model = 166, .flags = 1}, "multiplied by alpha");
    refuse((struct test_ktx2){.model = 163, .scheme = 1}, "the global data is cut off");
}

/* A header may not ask for memory that the file could not fill. */
static void test_memory_of_small_files_MA_8(void **state) {
    UNUSED(state);
    static const unsigned char bytes[1024];
    for (uint32_t scheme = 2; scheme <= 3; scheme++) {
        const struct test_ktx2 in = {.format = 37, .width = 16, .height = 16, .mips = 1, .scheme = scheme, .bytes = bytes, .sizes = {sizeof bytes}};
        fnl_host host = counting_host();
        struct texture out;
        size_t size;
        unsigned char *file = test_ktx2_make(&in, &size);
        test_put32(file + 20, 1 << 14);
        test_put32(file + 24, 1 << 14);
        test_put32(file + 96, 1u << 30);
        assert_int_equal(texture_decode(&host, file, size, "a.ktx2", &whole, &out), FNL_ERROR_FORMAT);
        assert_int_equal(atomic_load(&memory.allocations), 0);
        free(file);
    }
}

/* Slices that end too early, as their description says. */
static void test_short_slices_MA_8(void **state) {
    UNUSED(state);
    for (uint32_t i = 0; i < COUNT_OF(samples); i++) {
        fnl_host host = counting_host();
        struct file_view view;
        struct texture out;
        assert_int_equal(file_load(&host, samples[i].path, &view), FNL_OK);
        unsigned char *file = malloc(view.size);
        assert_non_null(file);
        memcpy(file, view.data, view.size);
        const uint32_t length_at = (file[64] | (uint32_t)file[65] << 8) + 20 + 8; /* of the first image's colours */
        const uint32_t length = file[length_at] | (uint32_t)file[length_at + 1] << 8;
        for (uint32_t less = 2; file[44] == 1 && less < length; less += 3) {
            test_put32(file + length_at, length - less);
            assert_int_equal(texture_decode(&host, file, view.size, "short.ktx2", &whole, &out), FNL_ERROR_FORMAT);
            assert_non_null(strstr(memory.last_error, "short.ktx2: broken BasisLZ: the colour of image 0 cannot be decoded"));
        }
        free(file);
        file_free(&host, &view);
    }
}

/* Cut off anywhere, with any byte changed, or without memory: an error with a name or a texture, and nothing is kept. */
static void test_broken_files_MA_8(void **state) {
    UNUSED(state);
    for (uint32_t i = 0; i < COUNT_OF(samples); i++) {
        fnl_host host = counting_host();
        struct file_view view;
        struct texture out;
        assert_int_equal(file_load(&host, samples[i].path, &view), FNL_OK);
        const long long before = atomic_load(&memory.live_bytes);
        unsigned char *file = malloc(view.size);
        assert_non_null(file);
        memcpy(file, view.data, view.size);
        for (size_t cut = 0; cut < view.size; cut += 3) {
            memory.last_error[0] = 0;
            unsigned char *exact = malloc(MAX(cut, 1u)); /* sanitizers see what is read behind it */
            assert_non_null(exact);
            memcpy(exact, file, cut);
            assert_true(texture_decode(&host, exact, cut, "cut.ktx2", &whole, &out) != FNL_OK);
            assert_true(strstr(memory.last_error, "cut.ktx2: ") && !out.bytes);
            free(exact);
        }
        for (size_t at = 0; at < view.size; at++) {
            const unsigned char was = file[at];
            memory.last_error[0] = 0;
            file[at] ^= (unsigned char)(1u << at % 8);
            const fnl_result result = at >= 20 && at < 28 ? FNL_OK : texture_decode(&host, file, view.size, "changed.ktx2", &whole, &out);
            if (result == FNL_OK && !(at >= 20 && at < 28)) texture_free(&host, &out);
            assert_true(result == FNL_OK || strstr(memory.last_error, "changed.ktx2: "));
            file[at] = was;
        }
        atomic_store(&memory.errors, 0);
        for (long long number = 1;; number++) {
            atomic_store(&memory.fail_at, atomic_load(&memory.allocations) + number);
            const fnl_result result = texture_decode(&host, file, view.size, "poor.ktx2", &whole, &out);
            atomic_store(&memory.fail_at, 0);
            if (result == FNL_OK) {
                assert_true(number > 1);
                texture_free(&host, &out);
                break;
            }
            assert_int_equal(result, FNL_ERROR_MEMORY);
            assert_true(atomic_exchange(&memory.errors, 0) > 0);
        }
        assert_int_equal(atomic_load(&memory.live_bytes), before);
        assert_int_equal(atomic_load(&memory.wrong_sizes), 0);
        free(file);
        file_free(&host, &view);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_files_of_basis_universal_MA_8),
        cmocka_unit_test(test_files_of_basis_universal_become_BC7_MA_8),
        cmocka_unit_test(test_structures_of_blocks_become_those_of_BC7_MA_8),
        cmocka_unit_test(test_blocks_of_UASTC_MA_8),
        cmocka_unit_test(test_formats_of_KTX2_MA_8),
        cmocka_unit_test(test_mips_are_whole_or_none_MA_8),
        cmocka_unit_test(test_orientation_and_swizzle_MA_8),
        cmocka_unit_test(test_normals_of_two_channels_MA_8),
        cmocka_unit_test(test_DDS_MA_8),
        cmocka_unit_test(test_what_is_refused_MA_8),
        cmocka_unit_test(test_memory_of_small_files_MA_8),
        cmocka_unit_test(test_short_slices_MA_8),
        cmocka_unit_test(test_broken_files_MA_8),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
