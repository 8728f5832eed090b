/* SPDX-License-Identifier: MIT */
/* Khronos Texture 2.0 (registry.khronos.org/KTX/specs/2.0). It is written without supercompression, the smallest mip first. */
#include "image/codec.h"

enum {
    HEADER_BYTES = 80,
    LEVEL_BYTES = 24, /* of an entry of the index of levels */
    DESCRIPTOR_BYTES = 44,
    ALIGNMENT = 16, /* of levels: the least common multiple of a block and 4 */
};

static const unsigned char identifier[12] = {0xAB, 'K', 'T', 'X', ' ', '2', '0', 0xBB, '\r', '\n', 0x1A, '\n'};
static const uint8_t vulkan_formats[TEXTURE_BYTES] = {
    [TEXTURE_BC6H] = 143, [TEXTURE_BC6H_SIGNED] = 144, [TEXTURE_RGBA16F] = 97, [TEXTURE_RGBA32F] = 109};
/* Of 8 bits: linear, sRGB. */
static const struct {
    uint8_t linear, srgb, format;
} byte_formats[] = {
    {9, 15, TEXTURE_R8},         {16, 22, TEXTURE_RG8},   {37, 43, TEXTURE_RGBA8}, {44, 50, TEXTURE_BGRA8}, {131, 132, TEXTURE_BC1},
    {133, 134, TEXTURE_BC1_ALPHA}, {137, 138, TEXTURE_BC3}, {139, 0, TEXTURE_BC4},   {141, 0, TEXTURE_BC5},   {145, 146, TEXTURE_BC7},
};
static const char metadata[] = "KTXwriter\0fanal"; /* key and value, each with its zero */

bool image_is_ktx2(const void *bytes, size_t size) { return size >= 12 && memcmp(bytes, identifier, 12) == 0; }

static bool find_format(uint32_t vulkan, struct texture *texture) {
    for (uint32_t i = 0; i < TEXTURE_BYTES; i++)
        if (vulkan_formats[i] == vulkan) {
            texture->format = (enum texture_format)i;
            texture->transfer = TEXTURE_LINEAR;
            return true;
        }
    for (uint32_t i = 0; i < COUNT_OF(byte_formats); i++)
        if (byte_formats[i].linear == vulkan || (vulkan && byte_formats[i].srgb == vulkan)) {
            texture->format = (enum texture_format)byte_formats[i].format;
            texture->transfer = byte_formats[i].linear == vulkan ? TEXTURE_LINEAR : TEXTURE_SRGB;
            return true;
        }
    return false;
}

/* Formats that Vulkan does not have are told by their data format descriptor: ETC1S, which becomes RGBA8, and UASTC. */
static fnl_result find_universal(const struct image_source *source, struct texture_layout *out) {
    enum { MODEL_ETC1S = 163, MODEL_UASTC = 166, TRANSFER_LINEAR = 1, TRANSFER_SRGB = 2, PREMULTIPLIED = 1, BLOCK_BYTES = 24, SAMPLE_BYTES = 16 };
    const uint32_t offset = little32(source->bytes + 48), size = little32(source->bytes + 52);
    if ((uint64_t)offset + size > source->size || size < 4 + BLOCK_BYTES + SAMPLE_BYTES)
        return image_fail(source, FNL_ERROR_FORMAT, "broken KTX2: the data format descriptor is cut off (%u bytes from byte %u on)", size, offset);
    const unsigned char *block = source->bytes + offset + 4, *samples = block + BLOCK_BYTES;
    const uint32_t model = block[8], transfer = block[10], first = samples[3] & 15;
    uint32_t sample_count = (uint32_t)((size - 4 - BLOCK_BYTES) / SAMPLE_BYTES), block_size = block[6] | (uint32_t)block[7] << 8;
    if (block_size >= BLOCK_BYTES + SAMPLE_BYTES) sample_count = MIN(sample_count, (block_size - BLOCK_BYTES) / SAMPLE_BYTES);
    const uint32_t second = sample_count > 1 ? samples[SAMPLE_BYTES + 3] & 15 : 0;
    if (block[11] & PREMULTIPLIED) return image_fail(source, FNL_ERROR_UNSUPPORTED, "KTX2 of colours that are multiplied by alpha (at byte %u)", offset + 15);
    out->texture.transfer = transfer == TRANSFER_SRGB ? TEXTURE_SRGB : transfer == TRANSFER_LINEAR ? TEXTURE_LINEAR : TEXTURE_TRANSFER_UNKNOWN;
    if (model == MODEL_ETC1S) {
        if (out->scheme != KTX2_BASIS_LZ)
            return image_fail(source, FNL_ERROR_FORMAT, "broken KTX2: ETC1S with supercompression scheme %u (1, BasisLZ)", out->scheme);
        if (first != 0 || (sample_count > 1 && second != 15))
            return image_fail(source, FNL_ERROR_UNSUPPORTED, "KTX2 of ETC1S with channels %u and %u (read are RGB, 0, and alpha, 15)", first, second);
        out->texture.format = TEXTURE_RGBA8;
        out->alpha = sample_count > 1;
        return FNL_OK;
    }
    if (model == MODEL_UASTC) {
        if (out->scheme == KTX2_BASIS_LZ) return image_fail(source, FNL_ERROR_FORMAT, "broken KTX2: UASTC under BasisLZ, which is for ETC1S");
        if (first != 0 && first != 3) return image_fail(source, FNL_ERROR_UNSUPPORTED, "KTX2 of UASTC with channels %u (read are RGB, 0, and RGBA, 3)", first);
        out->texture.format = TEXTURE_UASTC;
        return FNL_OK;
    }
    return image_fail(source, FNL_ERROR_UNSUPPORTED, "KTX2 of no VkFormat and colour model %u (read are ETC1S, 163, and UASTC, 166)", model);
}

/* Keys and values: which way the rows go, and which channels are shown. */
static fnl_result find_values(const struct image_source *source, struct texture_layout *out) {
    const uint32_t offset = little32(source->bytes + 56), size = little32(source->bytes + 60);
    memcpy(out->swizzle, "rgba", 4);
    if (size == 0) return FNL_OK;
    if ((uint64_t)offset + size > source->size) return image_fail(source, FNL_ERROR_FORMAT, "broken KTX2: keys and values are cut off (at byte %u)", offset);
    const unsigned char *at = source->bytes + offset;
    for (uint32_t left = size; left >= 4;) {
        const uint32_t length = little32(at);
        if (length > left - 4)
            return image_fail(source, FNL_ERROR_FORMAT, "broken KTX2: a key and its value are cut off (at byte %zu)", (size_t)(at - source->bytes));
        const char *key = (const char *)at + 4;
        const size_t key_length = strnlen(key, length);
        const char *value = key + key_length + 1;
        const size_t value_length = key_length < length ? length - key_length - 1 : 0;
        if (key_length == 14 && memcmp(key, "KTXorientation", 14) == 0) {
            if (value_length < 2 || (value[0] != 'r' && value[0] != 'l') || (value[1] != 'd' && value[1] != 'u'))
                return image_fail(source, FNL_ERROR_UNSUPPORTED, "KTX2 of an unknown KTXorientation (known are rd, ru, ld and lu)");
            out->flip_x = value[0] == 'l';
            out->flip_y = value[1] == 'u';
        }
        if (key_length == 10 && memcmp(key, "KTXswizzle", 10) == 0) {
            for (uint32_t i = 0; i < 4; i++)
                if (value_length < 4 || !value[i] || !strchr("rgba01", value[i]))
                    return image_fail(source, FNL_ERROR_UNSUPPORTED, "KTX2 of an unknown KTXswizzle (four of rgba01)");
            memcpy(out->swizzle, value, 4);
        }
        const uint32_t step = 4 + (length + 3) / 4 * 4;
        if (step >= left) break;
        at += step;
        left -= step;
    }
    return FNL_OK;
}

/* The most bytes that so many can stand for, by their supercompression: a header that claims more is refused before anything is allocated. */
static uint64_t most_bytes(uint32_t scheme, uint64_t length) {
    if (scheme == KTX2_ZSTD) return (length / 4 + 1) * (128 << 10); /* blocks of one repeated byte: 4 bytes for 128 KiB (RFC 8878) */
    return scheme == KTX2_ZLIB ? length * 1032 + 1032 : length; /* codes of one bit for 258 bytes each, twice (RFC 1951) */
}

static fnl_result find_levels(const struct image_source *source, struct texture_layout *out) {
    const struct texture *texture = &out->texture;
    const unsigned char *bytes = source->bytes;
    uint64_t total = 0;
    if (source->size - HEADER_BYTES < (size_t)texture->mips * LEVEL_BYTES)
        return image_fail(source, FNL_ERROR_FORMAT, "broken KTX2: the index of %u levels is cut off", texture->mips);
    for (uint32_t mip = 0; mip < texture->mips; mip++) {
        const unsigned char *entry = bytes + HEADER_BYTES + mip * LEVEL_BYTES;
        uint64_t offset = little64(entry), length = little64(entry + 8), plain = little64(entry + 16);
        const size_t face_bytes = texture_face_bytes(texture, mip);
        const uint64_t expected = (uint64_t)face_bytes * texture->faces;
        if (out->scheme == KTX2_PLAIN && length != expected)
            return image_fail(source, FNL_ERROR_FORMAT, "broken KTX2: level %u has %llu bytes, not %llu (at byte %u)", mip,
                              (unsigned long long)length, (unsigned long long)expected, HEADER_BYTES + mip * LEVEL_BYTES + 8);
        if (offset > source->size || length > source->size - offset) return texture_fail_cut_off(source, mip, 0);
        if ((out->scheme == KTX2_ZSTD || out->scheme == KTX2_ZLIB) && (plain != expected || most_bytes(out->scheme, length) < expected))
            return image_fail(source, FNL_ERROR_FORMAT, "broken KTX2: level %u has %llu bytes, %llu before compression, not %llu (at byte %u)", mip,
                              (unsigned long long)length, (unsigned long long)plain, (unsigned long long)expected, HEADER_BYTES + mip * LEVEL_BYTES + 8);
        total += length;
        out->lengths[mip] = (size_t)length;
        for (uint32_t face = 0; face < texture->faces; face++) out->offsets[mip][face] = (size_t)offset + (out->scheme ? 0 : face * face_bytes);
    }
    /* Else a small file could ask for much memory. */
    if (total > source->size) return image_fail(source, FNL_ERROR_FORMAT, "broken KTX2: levels lie over each other");
    return FNL_OK;
}

fnl_result image_ktx2_find(const struct image_source *source, struct texture_layout *out) {
    *out = (struct texture_layout){0};
    const unsigned char *bytes = source->bytes;
    if (source->size < HEADER_BYTES) return image_fail(source, FNL_ERROR_FORMAT, "broken KTX2: the header is cut off");
    uint32_t format = little32(bytes + 12), depth = little32(bytes + 28), layers = little32(bytes + 32), faces = little32(bytes + 36);
    struct texture *texture = &out->texture;
    *texture = (struct texture){
        .width = little32(bytes + 20), .height = little32(bytes + 24), .faces = faces, .mips = MAX(little32(bytes + 40), 1u)};
    out->scheme = little32(bytes + 44);
    if (out->scheme > KTX2_ZLIB)
        return image_fail(source, FNL_ERROR_UNSUPPORTED, "KTX2 with supercompression scheme %u (read are none, BasisLZ, zstd and zlib: 0 to 3)", out->scheme);
    if (format == 0) {
        TRY(find_universal(source, out));
    } else if (!find_format(format, texture)) {
        return image_fail(source, FNL_ERROR_UNSUPPORTED,
                          "KTX2 of VkFormat %u (read are R8, RG8, RGBA8, BGRA8, BC1, BC3, BC4, BC5, BC7, ETC1S, UASTC, BC6H and RGBA floats)", format);
    } else if (out->scheme == KTX2_BASIS_LZ) {
        return image_fail(source, FNL_ERROR_FORMAT, "broken KTX2: VkFormat %u under BasisLZ, which is for ETC1S", format);
    }
    if (depth || layers > 1 || (faces != 1 && faces != 6))
        return image_fail(source, FNL_ERROR_UNSUPPORTED, "KTX2 of depth %u with %u layers and %u faces (read are pictures and cube maps)", depth,
                          layers, faces);
    TRY(texture_check(source, texture));
    TRY(find_values(source, out));
    const bool plain = !out->flip_x && !out->flip_y && memcmp(out->swizzle, "rgba", 4) == 0;
    if (!plain && (texture_is_float(texture->format) || faces == 6))
        return image_fail(source, FNL_ERROR_UNSUPPORTED, "KTX2 with KTXorientation or KTXswizzle, which are heeded for pictures of 8 bits alone");
    if (out->scheme == KTX2_BASIS_LZ) {
        const uint64_t at = little64(bytes + 64), size = little64(bytes + 72);
        if (at > source->size || size > source->size - at) return image_fail(source, FNL_ERROR_FORMAT, "broken KTX2: the global data is cut off");
        out->global = (size_t)at;
        out->global_size = (size_t)size;
    }
    return find_levels(source, out);
}

/* How the blocks are made (Khronos Data Format Specification 1.3, the basic descriptor). */
static void write_descriptor(FILE *stream, bool is_signed) {
    const uint32_t words[DESCRIPTOR_BYTES / 4] = {
        DESCRIPTOR_BYTES,
        0,                                     /* Khronos, basic format */
        2 | (DESCRIPTOR_BYTES - 4) << 16,      /* version 1.3; bytes of what follows the first word */
        133 | 1 << 8 | 1 << 16,                /* BC6H, primaries of BT.709, linear, straight alpha */
        3 | 3 << 8,                            /* 4 x 4 texels */
        16,                                    /* bytes of the first plane */
        0,                                     /* of planes 4 to 7 */
        127u << 16 | (is_signed ? 0xc0u : 0x80u) << 24, /* a sample of 128 bits from 0: colour, floats, signed */
        0,                                     /* position */
        is_signed ? 0xbf800000u : 0,           /* lower: -1 or 0 */
        0x3f800000u,                           /* upper: 1 */
    };
    for (uint32_t i = 0; i < DESCRIPTOR_BYTES / 4; i++) put_little32(stream, words[i]);
}

static void write_padding(FILE *stream, size_t bytes) {
    while (bytes--) putc(0, stream);
}

void image_ktx2_write(struct file_writer *writer, const struct texture *texture) {
    FILE *stream = writer->stream;
    size_t descriptor = HEADER_BYTES + (size_t)texture->mips * LEVEL_BYTES, values = descriptor + DESCRIPTOR_BYTES;
    size_t values_bytes = align_up(4 + sizeof metadata, 4), start = align_up(values + values_bytes, ALIGNMENT);
    fwrite(identifier, 1, sizeof identifier, stream);
    const uint32_t header[] = {vulkan_formats[texture->format], 1, texture->width, texture->height, 0, 0, texture->faces, texture->mips, 0,
                               (uint32_t)descriptor, DESCRIPTOR_BYTES, (uint32_t)values, (uint32_t)values_bytes};
    for (uint32_t i = 0; i < COUNT_OF(header); i++) put_little32(stream, header[i]);
    write_padding(stream, 16); /* no data of supercompression */
    /* All faces have a multiple of 16 bytes, so levels need no padding between them. */
    for (uint32_t mip = 0; mip < texture->mips; mip++) {
        size_t at = start, bytes = texture_face_bytes(texture, mip) * texture->faces;
        for (uint32_t smaller = mip + 1; smaller < texture->mips; smaller++) at += texture_face_bytes(texture, smaller) * texture->faces;
        put_little64(stream, at);
        put_little64(stream, bytes);
        put_little64(stream, bytes);
    }
    write_descriptor(stream, texture->format == TEXTURE_BC6H_SIGNED);
    put_little32(stream, sizeof metadata);
    fwrite(metadata, 1, sizeof metadata, stream);
    write_padding(stream, start - values - 4 - sizeof metadata);
    for (uint32_t mip = texture->mips; mip-- > 0;)
        fwrite(texture->bytes + texture_offset(texture, mip, 0), 1, texture_face_bytes(texture, mip) * texture->faces, stream);
}
