/* SPDX-License-Identifier: MIT */
/* DirectDraw Surface (Microsoft, "Programming Guide for DDS"): face after face, in each of them mip after mip. Written with the header of Direct3D 10. */
#include "image/codec.h"

enum {
    OLD_HEADER_BYTES = 4 + 124,
    HEADER_BYTES = OLD_HEADER_BYTES + 20,
    /* Of 32-bit words, counted from the magic: */
    WORD_SIZE = 1,
    WORD_HEIGHT = 3,
    WORD_WIDTH = 4,
    WORD_MIPS = 7,
    WORD_FORMAT_SIZE = 19,
    WORD_FORMAT_FLAGS = 20,
    WORD_FOURCC = 21,
    WORD_BITS = 22, /* of a texel; then the masks of R, G, B, A */
    WORD_CAPS2 = 28,
    WORD_DXGI = 32,
    WORD_DIMENSION = 33,
    WORD_MISC = 34,
    WORD_ARRAY = 35,
};

static const uint8_t dxgi_formats[TEXTURE_BYTES] = {
    [TEXTURE_BC6H] = 95, [TEXTURE_BC6H_SIGNED] = 96, [TEXTURE_RGBA16F] = 10, [TEXTURE_RGBA32F] = 2};
/* Of 8 bits: linear, sRGB. */
static const struct {
    uint8_t linear, srgb, format;
} byte_formats[] = {
    {61, 0, TEXTURE_R8},         {49, 0, TEXTURE_RG8},  {28, 29, TEXTURE_RGBA8}, {87, 91, TEXTURE_BGRA8}, {71, 72, TEXTURE_BC1_ALPHA},
    {77, 78, TEXTURE_BC3}, {80, 0, TEXTURE_BC4}, {83, 0, TEXTURE_BC5},     {98, 99, TEXTURE_BC7},
};
/* Files of before Direct3D 10, which do not say how colours are stored. */
static const struct {
    char name[5];
    uint8_t format;
} old_formats[] = {
    {"DXT1", TEXTURE_BC1_ALPHA}, {"DXT5", TEXTURE_BC3}, {"ATI1", TEXTURE_BC4}, {"BC4U", TEXTURE_BC4}, {"ATI2", TEXTURE_BC5}, {"BC5U", TEXTURE_BC5},
};

bool image_is_dds(const void *bytes, size_t size) { return size >= 4 && memcmp(bytes, "DDS ", 4) == 0; }

static uint32_t word(const struct image_source *source, uint32_t index) { return little32(source->bytes + 4 * (size_t)index); }

static bool find_format(uint32_t dxgi, struct texture *texture) {
    for (uint32_t i = 0; i < TEXTURE_BYTES; i++)
        if (dxgi_formats[i] == dxgi) {
            texture->format = (enum texture_format)i;
            texture->transfer = TEXTURE_LINEAR;
            return true;
        }
    for (uint32_t i = 0; i < COUNT_OF(byte_formats); i++)
        if (byte_formats[i].linear == dxgi || (dxgi && byte_formats[i].srgb == dxgi)) {
            texture->format = (enum texture_format)byte_formats[i].format;
            texture->transfer = byte_formats[i].linear == dxgi ? TEXTURE_LINEAR : TEXTURE_SRGB;
            return true;
        }
    return false;
}

static bool find_old_format(const struct image_source *source, struct texture *texture) {
    enum { HAS_FOURCC = 4, HAS_RGB = 0x40 };
    const uint32_t flags = word(source, WORD_FORMAT_FLAGS), red = word(source, WORD_BITS + 1), blue = word(source, WORD_BITS + 3);
    if (flags & HAS_RGB && word(source, WORD_BITS) == 32 && word(source, WORD_BITS + 2) == 0xff00 && word(source, WORD_BITS + 4) == 0xff000000) {
        texture->format = red == 0xff ? TEXTURE_RGBA8 : TEXTURE_BGRA8;
        return (red == 0xff && blue == 0xff0000) || (red == 0xff0000 && blue == 0xff);
    }
    for (uint32_t i = 0; flags & HAS_FOURCC && i < COUNT_OF(old_formats); i++)
        if (memcmp(source->bytes + 4 * WORD_FOURCC, old_formats[i].name, 4) == 0) {
            texture->format = (enum texture_format)old_formats[i].format;
            return true;
        }
    return false;
}

fnl_result image_dds_find(const struct image_source *source, struct texture_layout *out) {
    enum { CUBE = 0x200, VOLUME = 0x200000 };
    *out = (struct texture_layout){0};
    if (source->size < OLD_HEADER_BYTES) return image_fail(source, FNL_ERROR_FORMAT, "broken DDS: the header is cut off");
    if (word(source, WORD_SIZE) != 124 || word(source, WORD_FORMAT_SIZE) != 32)
        return image_fail(source, FNL_ERROR_FORMAT, "broken DDS: the header says that it has %u bytes (124), its pixel format %u (32)",
                          word(source, WORD_SIZE), word(source, WORD_FORMAT_SIZE));
    struct texture *texture = &out->texture;
    *texture = (struct texture){.width = word(source, WORD_WIDTH), .height = word(source, WORD_HEIGHT), .faces = 1, .mips = MAX(word(source, WORD_MIPS), 1u)};
    size_t at = OLD_HEADER_BYTES;
    if (memcmp(source->bytes + 4 * WORD_FOURCC, "DX10", 4) == 0) {
        if (source->size < HEADER_BYTES) return image_fail(source, FNL_ERROR_FORMAT, "broken DDS: the header of Direct3D 10 is cut off");
        texture->faces = word(source, WORD_MISC) & 4 ? 6 : 1;
        if (!find_format(word(source, WORD_DXGI), texture))
            return image_fail(source, FNL_ERROR_UNSUPPORTED,
                              "DDS of DXGI format %u (read are R8, RG8, RGBA8, BGRA8, BC1, BC3, BC4, BC5, BC7, BC6H and RGBA floats)", word(source, WORD_DXGI));
        if (word(source, WORD_DIMENSION) != 3 || word(source, WORD_ARRAY) != 1)
            return image_fail(source, FNL_ERROR_UNSUPPORTED, "DDS of dimension %u with an array of %u (read are pictures and cube maps: 3, 1)",
                              word(source, WORD_DIMENSION), word(source, WORD_ARRAY));
        at = HEADER_BYTES;
    } else if (!find_old_format(source, texture) || word(source, WORD_CAPS2) & (CUBE | VOLUME)) {
        return image_fail(source, FNL_ERROR_UNSUPPORTED,
                          "DDS without the header of Direct3D 10 (at byte 84) and no picture of DXT1, DXT5, ATI1, ATI2 or 32-bit RGBA");
    }
    TRY(texture_check(source, texture));
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
    words[WORD_FORMAT_FLAGS] = 4; /* has a FourCC */
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
