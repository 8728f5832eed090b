/* SPDX-License-Identifier: MIT */
/** For tests: KTX2 files put together in memory. */
#ifndef FNL_TESTS_TEXTURE_FILE_H
#define FNL_TESTS_TEXTURE_FILE_H

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <zlib.h>
#include <zstd.h>

struct test_ktx2 {
    uint32_t format, width, height, faces, mips, scheme; /* format: of Vulkan; 0: `model` */
    const unsigned char *bytes;                          /* mip after mip */
    size_t sizes[16];                                    /* of mips */
    uint32_t model, transfer, channel, flags;            /* of the data format descriptor */
    const char *orientation, *swizzle;                   /* NULL: none */
};

static inline void test_put32(unsigned char *at, uint64_t value) {
    for (int i = 0; i < 4; i++) at[i] = (unsigned char)(value >> 8 * i);
}

static inline size_t test_put_value(unsigned char *at, const char *key, const char *value) {
    size_t length = strlen(key) + strlen(value) + 2;
    test_put32(at, length);
    memcpy(at + 4, key, strlen(key) + 1);
    memcpy(at + 5 + strlen(key), value, strlen(value) + 1);
    return 4 + (length + 3) / 4 * 4;
}

/** Free with free(). */
static inline unsigned char *test_ktx2_make(const struct test_ktx2 *in, size_t *out_size) {
    size_t total = 4096, at = 80 + 24 * (size_t)in->mips;
    for (uint32_t i = 0; i < in->mips; i++) total += in->sizes[i] + in->sizes[i] / 8 + 1024;
    unsigned char *file = calloc(1, total);
    memcpy(file, "\xabKTX 20\xbb\r\n\x1a\n", 12);
    const uint32_t header[] = {in->format, 1, in->width, in->height, 0, 0, in->faces ? in->faces : 1, in->mips, in->scheme, (uint32_t)at, 44, (uint32_t)at + 44};
    for (uint32_t i = 0; i < sizeof header / sizeof *header; i++) test_put32(file + 12 + 4 * i, header[i]);
    const uint32_t descriptor[] = {44, 0, 2 | 40 << 16, in->model | 1u << 8 | in->transfer << 16 | in->flags << 24, 0x303, 16, 0,
                                   127u << 16 | in->channel << 24, 0, 0, UINT32_MAX};
    for (uint32_t i = 0; i < 11; i++) test_put32(file + at + 4 * i, descriptor[i]);
    at += 44;
    const size_t values = at;
    if (in->orientation) at += test_put_value(file + at, "KTXorientation", in->orientation);
    if (in->swizzle) at += test_put_value(file + at, "KTXswizzle", in->swizzle);
    test_put32(file + 60, at - values);
    const unsigned char *from = in->bytes;
    for (uint32_t mip = 0; mip < in->mips; from += in->sizes[mip++]) {
        size_t length = in->sizes[mip];
        uLongf room = (uLongf)(total - at);
        if (in->scheme == 2) {
            length = ZSTD_compress(file + at, total - at, from, in->sizes[mip], 3);
        } else if (in->scheme == 3) {
            compress2(file + at, &room, from, (uLong)in->sizes[mip], 6);
            length = room;
        } else {
            memcpy(file + at, from, length);
        }
        test_put32(file + 80 + 24 * mip, at);
        test_put32(file + 88 + 24 * mip, length);
        test_put32(file + 96 + 24 * mip, in->sizes[mip]);
        at += length;
    }
    *out_size = at;
    return file;
}

#endif
