/* SPDX-License-Identifier: MIT */
/* DirectDraw Surface with the header of Direct3D 10 (Microsoft, "Programming Guide for DDS"): face after face, in each of them mip after mip. */
#include "image/codec.h"

enum {
    HEADER_BYTES = 4 + 124 + 20,
    /* Of 32-bit words, counted from the magic: */
    WORD_SIZE = 1,
    WORD_HEIGHT = 3,
    WORD_WIDTH = 4,
    WORD_MIPS = 7,
    WORD_FORMAT_SIZE = 19,
    WORD_FOURCC = 21,
    WORD_CAPS2 = 28,
    WORD_DXGI = 32,
    WORD_DIMENSION = 33,
    WORD_MISC = 34,
    WORD_ARRAY = 35,
};

static const uint8_t dxgi_formats[TEXTURE_FORMATS] = {
    [TEXTURE_BC6H] = 95, [TEXTURE_BC6H_SIGNED] = 96, [TEXTURE_RGBA16F] = 10, [TEXTURE_RGBA32F] = 2};

bool image_is_dds(const void *bytes, size_t size) { return size >= 4 && memcmp(bytes, "DDS ", 4) == 0; }

static uint32_t word(const struct image_source *source, uint32_t index) { return little32(source->bytes + 4 * (size_t)index); }

fnl_result image_dds_find(const struct image_source *source, struct texture_layout *out) {
    *out = (struct texture_layout){0};
    if (source->size < 128) return image_fail(source, FNL_ERROR_FORMAT, "broken DDS: the header is cut off");
    if (word(source, WORD_SIZE) != 124 || word(source, WORD_FORMAT_SIZE) != 32)
        return image_fail(source, FNL_ERROR_FORMAT, "broken DDS: the header says that it has %u bytes (124), its pixel format %u (32)",
                          word(source, WORD_SIZE), word(source, WORD_FORMAT_SIZE));
    if (memcmp(source->bytes + 4 * WORD_FOURCC, "DX10", 4) != 0)
        return image_fail(source, FNL_ERROR_UNSUPPORTED, "DDS without the header of Direct3D 10 (at byte 84), which BC6H needs");
    if (source->size < HEADER_BYTES) return image_fail(source, FNL_ERROR_FORMAT, "broken DDS: the header of Direct3D 10 is cut off");
    struct texture *texture = &out->texture;
    *texture = (struct texture){.width = word(source, WORD_WIDTH),
                                .height = word(source, WORD_HEIGHT),
                                .faces = word(source, WORD_MISC) & 4 ? 6 : 1,
                                .mips = MAX(word(source, WORD_MIPS), 1u)};
    uint32_t dxgi = word(source, WORD_DXGI);
    while (texture->format < TEXTURE_FORMATS && dxgi_formats[texture->format] != dxgi) texture->format++;
    if (texture->format == TEXTURE_FORMATS)
        return image_fail(source, FNL_ERROR_UNSUPPORTED, "DDS of DXGI format %u (read are BC6H: 95, 96; and RGBA floats: 10, 2)", dxgi);
    if (word(source, WORD_DIMENSION) != 3 || word(source, WORD_ARRAY) != 1)
        return image_fail(source, FNL_ERROR_UNSUPPORTED, "DDS of dimension %u with an array of %u (read are pictures and cube maps: 3, 1)",
                          word(source, WORD_DIMENSION), word(source, WORD_ARRAY));
    TRY(texture_check(source, texture));
    size_t at = HEADER_BYTES;
    for (uint32_t face = 0; face < texture->faces; face++)
        for (uint32_t mip = 0; mip < texture->mips; mip++) {
            size_t bytes = texture_face_bytes(texture, mip);
            if (bytes > source->size - at) return texture_fail_cut_off(source, mip, face);
            out->offsets[mip][face] = at;
            at += bytes;
        }
    return FNL_OK;
}

void image_dds_write(struct file_writer *writer, const struct texture *texture) {
    uint32_t words[HEADER_BYTES / 4] = {0};
    bool cube = texture->faces == 6, several = texture->mips > 1;
    words[WORD_SIZE] = 124;
    words[2] = 0x81007u | (several ? 0x20000u : 0); /* caps, height, width, pixel format, linear size, mips */
    words[WORD_HEIGHT] = texture->height;
    words[WORD_WIDTH] = texture->width;
    words[5] = (uint32_t)texture_face_bytes(texture, 0);
    words[WORD_MIPS] = texture->mips;
    words[WORD_FORMAT_SIZE] = 32;
    words[20] = 4; /* has a FourCC */
    words[27] = 0x1000u | (several ? 0x400008u : 0) | (cube ? 8u : 0); /* texture; mips and complex */
    words[WORD_CAPS2] = cube ? 0xfe00u : 0;
    words[WORD_DXGI] = dxgi_formats[texture->format];
    words[WORD_DIMENSION] = 3;
    words[WORD_MISC] = cube ? 4 : 0;
    words[WORD_ARRAY] = 1;
    words[36] = 3; /* opaque */
    for (uint32_t i = 0; i < HEADER_BYTES / 4; i++) {
        if (i == 0 || i == WORD_FOURCC)
            fwrite(i ? "DX10" : "DDS ", 1, 4, writer->stream);
        else
            put_little32(writer->stream, words[i]);
    }
    for (uint32_t face = 0; face < texture->faces; face++)
        for (uint32_t mip = 0; mip < texture->mips; mip++)
            fwrite(texture->bytes + texture_offset(texture, mip, face), 1, texture_face_bytes(texture, mip), writer->stream);
}
