/* SPDX-License-Identifier: MIT */
/* Khronos Texture 2.0 (registry.khronos.org/KTX/specs/2.0), without supercompression. The smallest mip comes first. */
#include "image/codec.h"

enum {
    HEADER_BYTES = 80,
    LEVEL_BYTES = 24, /* of an entry of the index of levels */
    DESCRIPTOR_BYTES = 44,
    ALIGNMENT = 16, /* of levels: the least common multiple of a block and 4 */
};

static const unsigned char identifier[12] = {0xAB, 'K', 'T', 'X', ' ', '2', '0', 0xBB, '\r', '\n', 0x1A, '\n'};
static const uint8_t vulkan_formats[TEXTURE_FORMATS] = {
    [TEXTURE_BC6H] = 143, [TEXTURE_BC6H_SIGNED] = 144, [TEXTURE_RGBA16F] = 97, [TEXTURE_RGBA32F] = 109};
static const char metadata[] = "KTXwriter\0fanal"; /* key and value, each with its zero */

bool image_is_ktx2(const void *bytes, size_t size) { return size >= 12 && memcmp(bytes, identifier, 12) == 0; }

fnl_result image_ktx2_find(const struct image_source *source, struct texture_layout *out) {
    *out = (struct texture_layout){0};
    const unsigned char *bytes = source->bytes;
    if (source->size < HEADER_BYTES) return image_fail(source, FNL_ERROR_FORMAT, "broken KTX2: the header is cut off");
    uint32_t format = little32(bytes + 12), depth = little32(bytes + 28), layers = little32(bytes + 32), faces = little32(bytes + 36);
    uint32_t scheme = little32(bytes + 44);
    struct texture *texture = &out->texture;
    *texture = (struct texture){
        .width = little32(bytes + 20), .height = little32(bytes + 24), .faces = faces, .mips = MAX(little32(bytes + 40), 1u)};
    while (texture->format < TEXTURE_FORMATS && vulkan_formats[texture->format] != format) texture->format++;
    if (texture->format == TEXTURE_FORMATS)
        return image_fail(source, FNL_ERROR_UNSUPPORTED, "KTX2 of VkFormat %u (read are BC6H: 143, 144; and RGBA floats: 97, 109)", format);
    if (scheme) return image_fail(source, FNL_ERROR_UNSUPPORTED, "KTX2 with supercompression scheme %u (only 0, none, is read)", scheme);
    if (depth || layers > 1 || (faces != 1 && faces != 6))
        return image_fail(source, FNL_ERROR_UNSUPPORTED, "KTX2 of depth %u with %u layers and %u faces (read are pictures and cube maps)", depth,
                          layers, faces);
    TRY(texture_check(source, texture));
    if (source->size - HEADER_BYTES < (size_t)texture->mips * LEVEL_BYTES)
        return image_fail(source, FNL_ERROR_FORMAT, "broken KTX2: the index of %u levels is cut off", texture->mips);
    uint64_t total = 0;
    for (uint32_t mip = 0; mip < texture->mips; mip++) {
        const unsigned char *entry = bytes + HEADER_BYTES + mip * LEVEL_BYTES;
        uint64_t offset = little64(entry), length = little64(entry + 8);
        size_t face_bytes = texture_face_bytes(texture, mip);
        if (length != (uint64_t)face_bytes * faces)
            return image_fail(source, FNL_ERROR_FORMAT, "broken KTX2: level %u has %llu bytes, not %llu (at byte %u)", mip,
                              (unsigned long long)length, (unsigned long long)face_bytes * faces, HEADER_BYTES + mip * LEVEL_BYTES + 8);
        if (offset > source->size || length > source->size - offset) return texture_fail_cut_off(source, mip, 0);
        total += length;
        for (uint32_t face = 0; face < faces; face++) out->offsets[mip][face] = (size_t)offset + face * face_bytes;
    }
    /* Else a small file could ask for much memory. */
    if (total > source->size) return image_fail(source, FNL_ERROR_FORMAT, "broken KTX2: levels lie over each other");
    return FNL_OK;
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
