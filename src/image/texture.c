/* SPDX-License-Identifier: MIT */
#include "image/texture.h"

#include "base/maths.h"
#include "image/bc6h.h"
#include "image/blocks.h"
#include "image/etc1s.h"

#include <zlib.h>
#include <zstd.h>

uint32_t texture_mips(uint32_t width, uint32_t height) {
    uint32_t mips = 1;
    while (MAX(width, height) >> mips) mips++;
    return mips;
}

static size_t texel_bytes(enum texture_format format) {
    switch (format) {
    case TEXTURE_R8:
        return 1;
    case TEXTURE_RG8:
        return 2;
    case TEXTURE_RGBA8:
    case TEXTURE_BGRA8:
        return 4;
    case TEXTURE_RGBA16F:
        return 8;
    case TEXTURE_RGBA32F:
        return 16;
    default:
        return 0;
    }
}

size_t texture_face_bytes(const struct texture *texture, uint32_t mip) {
    uint32_t width = texture_side(texture->width, mip), height = texture_side(texture->height, mip);
    const size_t block = block_bytes(texture->format);
    if (block) return (size_t)DIVIDE_UP(width, 4u) * DIVIDE_UP(height, 4u) * block;
    return (size_t)width * height * texel_bytes(texture->format);
}

size_t texture_offset(const struct texture *texture, uint32_t mip, uint32_t face) {
    size_t offset = 0;
    for (uint32_t i = 0; i < mip; i++) offset += texture_face_bytes(texture, i) * texture->faces;
    return face ? offset + texture_face_bytes(texture, mip) * face : offset;
}

fnl_result texture_allocate(const fnl_host *host, struct texture *texture) {
    texture->bytes = host_allocate_zero(host, texture_offset(texture, texture->mips, 0));
    return texture->bytes ? FNL_OK : FNL_ERROR_MEMORY;
}

void texture_free(const fnl_host *host, struct texture *texture) {
    if (texture->bytes) host_free(host, texture->bytes, texture_offset(texture, texture->mips, 0));
    *texture = (struct texture){0};
}

/* ---- reading ---- */

fnl_result texture_check(const struct image_source *source, const struct texture *texture) {
    TRY(image_check_size(source, texture->width, (uint64_t)texture->height * texture->faces));
    if (texture->faces == 6 && texture->width != texture->height)
        return image_fail(source, FNL_ERROR_FORMAT, "broken: the faces of a cube map have %u x %u pixels", texture->width, texture->height);
    if (texture->mips == 0 || texture->mips > texture_mips(texture->width, texture->height))
        return image_fail(source, FNL_ERROR_FORMAT, "broken: %u mips of %u x %u pixels", texture->mips, texture->width, texture->height);
    return FNL_OK;
}

fnl_result texture_fail_cut_off(const struct image_source *source, uint32_t mip, uint32_t face) {
    return image_fail(source, FNL_ERROR_FORMAT, "broken: mip %u, face %u is cut off (the file has %zu bytes)", mip, face, source->size);
}

static fnl_result find(const struct image_source *source, struct texture_layout *out) {
    return image_is_dds(source->bytes, source->size) ? image_dds_find(source, out) : image_ktx2_find(source, out);
}

/* ---- a file's mips, without supercompression ---- */

struct reader {
    struct image_source source;
    struct texture_layout layout;
    struct etc1s *etc1s; /* of BasisLZ */
    unsigned char *own;  /* a mip that does not stand in the file as it is; NULL: none is open */
    size_t own_size;
};

static fnl_result reader_open(const struct image_source *source, struct reader *out) {
    *out = (struct reader){.source = *source};
    TRY(find(source, &out->layout));
    const struct texture_layout *layout = &out->layout;
    if (layout->scheme != KTX2_BASIS_LZ) return FNL_OK;
    return etc1s_create(source, source->bytes + layout->global, layout->global_size, layout->texture.mips * layout->texture.faces, &out->etc1s);
}

static void reader_free_mip(struct reader *r) {
    if (r->own) host_free(r->source.host, r->own, r->own_size);
    r->own = NULL;
}

static void reader_close(struct reader *r) {
    reader_free_mip(r);
    etc1s_destroy(r->source.host, &r->etc1s);
}

static fnl_result inflate_mip(struct reader *r, uint32_t mip) {
    const unsigned char *packed = r->source.bytes + r->layout.offsets[mip][0];
    const size_t size = r->layout.lengths[mip];
    size_t got = 0;
    if (r->layout.scheme == KTX2_ZSTD) {
        got = ZSTD_decompress(r->own, r->own_size, packed, size);
        if (ZSTD_isError(got)) return image_fail(&r->source, FNL_ERROR_FORMAT, "broken KTX2: level %u, zstd: %s", mip, ZSTD_getErrorName(got));
    } else {
        uLongf room = (uLongf)r->own_size;
        const int error = uncompress(r->own, &room, packed, (uLong)size);
        if (error != Z_OK) return image_fail(&r->source, FNL_ERROR_FORMAT, "broken KTX2: level %u, zlib: %s", mip, zError(error));
        got = room;
    }
    if (got != r->own_size) return image_fail(&r->source, FNL_ERROR_FORMAT, "broken KTX2: level %u unpacks to %zu bytes, not %zu", mip, got, r->own_size);
    return FNL_OK;
}

/* A face of a mip as texture_face_bytes() says; it is there until the next call. Faces of one mip one behind the other are unpacked once. */
static fnl_result reader_face(struct reader *r, uint32_t mip, uint32_t face, const unsigned char **out) {
    const struct texture_layout *layout = &r->layout;
    const struct texture *texture = &layout->texture;
    const size_t face_bytes = texture_face_bytes(texture, mip);
    *out = r->source.bytes + layout->offsets[mip][face];
    if (layout->scheme == KTX2_PLAIN) return FNL_OK;
    if (face == 0) {
        reader_free_mip(r);
        r->own_size = face_bytes * texture->faces;
        r->own = host_allocate(r->source.host, r->own_size);
        if (!r->own) return image_fail(&r->source, FNL_ERROR_MEMORY, "out of memory");
        if (layout->scheme != KTX2_BASIS_LZ) TRY(inflate_mip(r, mip));
    }
    unsigned char *own = r->own + face * face_bytes;
    *out = own;
    if (layout->scheme != KTX2_BASIS_LZ) return FNL_OK;
    return etc1s_decode(&r->source, r->etc1s, mip * texture->faces + face, r->source.bytes + layout->offsets[mip][0], layout->lengths[mip], layout->alpha,
                        texture_side(texture->width, mip), texture_side(texture->height, mip), own);
}

static fnl_result read_whole(struct reader *r, struct texture *out) {
    struct texture texture = r->layout.texture;
    if (texture_allocate(r->source.host, &texture) != FNL_OK) return image_fail(&r->source, FNL_ERROR_MEMORY, "out of memory");
    fnl_result result = FNL_OK;
    for (uint32_t mip = 0; mip < texture.mips; mip++)
        for (uint32_t face = 0; face < texture.faces && result == FNL_OK; face++) {
            const unsigned char *bytes;
            result = reader_face(r, mip, face, &bytes);
            if (result == FNL_OK) memcpy(texture.bytes + texture_offset(&texture, mip, face), bytes, texture_face_bytes(&texture, mip));
        }
    if (result == FNL_OK)
        *out = texture;
    else
        texture_free(r->source.host, &texture);
    return result;
}

fnl_result texture_read(const fnl_host *host, const void *bytes, size_t size, const char *name, struct texture *out) {
    *out = (struct texture){0};
    struct image_source source = {host, bytes, size, name};
    if (!image_is_dds(bytes, size) && !image_is_ktx2(bytes, size))
        return image_fail(&source, FNL_ERROR_FORMAT, size ? "is neither a DDS nor a KTX2 file" : "is empty, not a texture");
    struct reader reader;
    fnl_result result = reader_open(&source, &reader);
    if (result == FNL_OK) result = read_whole(&reader, out);
    reader_close(&reader);
    return result;
}

fnl_result texture_load(const fnl_host *host, const char *path, struct texture *out) {
    *out = (struct texture){0};
    struct file_view view;
    TRY(file_load(host, path, &view));
    fnl_result result = texture_read(host, view.data, view.size, path, out);
    file_free(host, &view);
    return result;
}

fnl_result image_texture_peek(const struct image_source *source, struct image_file_info *out) {
    struct texture_layout layout;
    TRY(find(source, &layout));
    const struct texture *texture = &layout.texture;
    *out = (struct image_file_info){.kind = image_is_dds(source->bytes, source->size) ? IMAGE_FILE_DDS : IMAGE_FILE_KTX2,
                                    .width = texture->width,
                                    .height = texture->height * texture->faces,
                                    .pixel_bytes = texture_is_float(texture->format) ? 16 : 4,
                                    .cube = texture->faces == 6,
                                    .is_float = texture_is_float(texture->format),
                                    .transfer = texture->transfer};
    return FNL_OK;
}

static void decode_floats(enum texture_format format, const unsigned char *bytes, uint32_t width, uint32_t height, float *rgba) {
    size_t values = (size_t)width * height * 4;
    if (format == TEXTURE_RGBA32F) {
        memcpy(rgba, bytes, values * sizeof(float));
    } else if (format == TEXTURE_RGBA16F) {
        for (size_t i = 0; i < values; i++) rgba[i] = half_to_float((uint16_t)(bytes[i * 2] | bytes[i * 2 + 1] << 8));
    } else {
        bc6h_decode_picture(bytes, format == TEXTURE_BC6H_SIGNED, width, height, rgba);
    }
}

/* False: a block is none. */
static bool decode_blocks(enum texture_format format, const unsigned char *bytes, uint32_t width, uint32_t height, uint8_t *rgba) {
    const uint32_t size = block_bytes(format);
    for (uint32_t y = 0; y < height; y += 4)
        for (uint32_t x = 0; x < width; x += 4, bytes += size) {
            uint8_t texels[16][4];
            if (!block_decode(format, bytes, texels)) return false;
            for (uint32_t row = 0; row < MIN(height - y, 4u); row++)
                memcpy(rgba + 4 * ((size_t)(y + row) * width + x), texels[4 * row], (size_t)4 * MIN(width - x, 4u));
        }
    return true;
}

static bool decode_bytes(enum texture_format format, const unsigned char *bytes, uint32_t width, uint32_t height, uint8_t *rgba) {
    const size_t count = (size_t)width * height;
    if (block_bytes(format)) return decode_blocks(format, bytes, width, height, rgba);
    if (format == TEXTURE_RGBA8) {
        memcpy(rgba, bytes, 4 * count);
        return true;
    }
    const size_t size = texel_bytes(format);
    for (size_t i = 0; i < count; i++, bytes += size, rgba += 4) {
        const uint8_t texel[4] = {format == TEXTURE_BGRA8 ? bytes[2] : bytes[0], size > 1 ? bytes[1] : 0, format == TEXTURE_BGRA8 ? bytes[0] : 0,
                                  format == TEXTURE_BGRA8 ? bytes[3] : 255};
        memcpy(rgba, texel, 4);
    }
    return true;
}

static void swizzle(const char order[4], uint8_t *rgba, size_t count) {
    if (!order[0] || memcmp(order, "rgba", 4) == 0) return;
    uint8_t from[4];
    for (uint32_t c = 0; c < 4; c++) from[c] = (uint8_t)(strchr("rgba01", order[c]) - "rgba01");
    for (size_t i = 0; i < count; i++, rgba += 4) {
        const uint8_t texel[6] = {rgba[0], rgba[1], rgba[2], rgba[3], 0, 255};
        for (uint32_t c = 0; c < 4; c++) rgba[c] = texel[from[c]];
    }
}

static void exchange(uint8_t *a, uint8_t *b, size_t size) {
    for (size_t i = 0; i < size; i++) {
        uint8_t value = a[i];
        a[i] = b[i];
        b[i] = value;
    }
}

static void flip(bool x, bool y, uint8_t *rgba, uint32_t width, uint32_t height) {
    const size_t row = (size_t)width * 4;
    for (uint32_t i = 0; y && i < height / 2; i++) exchange(rgba + i * row, rgba + (height - 1 - i) * row, row);
    for (uint32_t k = 0; x && k < height; k++)
        for (uint32_t i = 0; i < width / 2; i++) exchange(rgba + k * row + (size_t)i * 4, rgba + k * row + (size_t)(width - 1 - i) * 4, 4);
}

static fnl_result decode_rgba8(struct reader *r, uint32_t mip, uint32_t face, uint8_t *rgba) {
    const struct texture_layout *layout = &r->layout;
    const struct texture *texture = &layout->texture;
    const uint32_t width = texture_side(texture->width, mip), height = texture_side(texture->height, mip);
    const unsigned char *bytes;
    TRY(reader_face(r, mip, face, &bytes));
    if (!decode_bytes(texture->format, bytes, width, height, rgba))
        return image_fail(&r->source, FNL_ERROR_FORMAT, "broken KTX2: mip %u has a block that is none of UASTC", mip);
    swizzle(layout->swizzle, rgba, (size_t)width * height);
    flip(layout->flip_x, layout->flip_y, rgba, width, height);
    return FNL_OK;
}

static fnl_result decode_picture(struct reader *r, fnl_image *out) {
    const struct texture *texture = &r->layout.texture;
    const bool floats = texture_is_float(texture->format);
    const size_t face_pixels = (size_t)texture->width * texture->height;
    fnl_image image;
    TRY(image_allocate(&r->source, texture->width, texture->height * texture->faces, floats ? FNL_PIXEL_FORMAT_RGBA32F : FNL_PIXEL_FORMAT_RGBA8,
                       IMAGE_PIXELS_MAX, &image));
    fnl_result result = FNL_OK;
    for (uint32_t face = 0; face < texture->faces && result == FNL_OK; face++) {
        const unsigned char *bytes;
        if (!floats) result = decode_rgba8(r, 0, face, (uint8_t *)image.pixels + face * face_pixels * 4);
        if (!floats) continue;
        result = reader_face(r, 0, face, &bytes);
        if (result == FNL_OK) decode_floats(texture->format, bytes, texture->width, texture->height, (float *)image.pixels + face * face_pixels * 4);
    }
    if (result == FNL_OK)
        *out = image;
    else
        fnl_image_free(r->source.host, &image);
    return result;
}

/* What materials cannot use. */
static fnl_result check_use(const struct image_source *source, const struct texture *texture) {
    if (texture_is_float(texture->format))
        return image_fail(source, FNL_ERROR_UNSUPPORTED, "floating-point pictures cannot be used here, only those of 8 bits a channel");
    return texture->faces == 6 ? image_fail(source, FNL_ERROR_UNSUPPORTED, "cube maps cannot be used here, only pictures") : FNL_OK;
}

fnl_result image_texture_decode(const struct image_source *source, bool force_rgba8, fnl_image *out) {
    struct reader reader;
    fnl_result result = reader_open(source, &reader);
    if (result == FNL_OK && force_rgba8) result = check_use(source, &reader.layout.texture);
    if (result == FNL_OK) result = decode_picture(&reader, out);
    reader_close(&reader);
    return result;
}

static bool has_two_channels(enum texture_format format) { return format == TEXTURE_RG8 || format == TEXTURE_BC5; }

/* z of normals of unit length, all of which point out of the surface. */
static void find_z(uint8_t *rgba, size_t count) {
    for (size_t i = 0; i < count; i++, rgba += 4) {
        const float x = (float)rgba[0] / 127.5f - 1, y = (float)rgba[1] / 127.5f - 1;
        rgba[2] = (uint8_t)(127.5f + 127.5f * sqrtf(fmaxf(1 - x * x - y * y, 0)) + 0.5f);
    }
}

static fnl_result decode_mips(struct reader *r, bool normals, struct texture *out) {
    struct texture texture = *out;
    if (texture_allocate(r->source.host, &texture) != FNL_OK) return image_fail(&r->source, FNL_ERROR_MEMORY, "out of memory");
    fnl_result result = FNL_OK;
    for (uint32_t mip = 0; mip < texture.mips && result == FNL_OK; mip++) result = decode_rgba8(r, mip, 0, texture.bytes + texture_offset(&texture, mip, 0));
    if (normals) find_z(texture.bytes, texture_offset(&texture, texture.mips, 0) / 4);
    if (result == FNL_OK)
        *out = texture;
    else
        texture_free(r->source.host, &texture);
    return result;
}

/* UASTC and ETC1S as BC7: a quarter of the device's memory. */
static fnl_result transcode_mips(struct reader *r, struct texture *out) {
    const struct texture *from = &r->layout.texture;
    struct texture texture = *from;
    texture.format = TEXTURE_BC7;
    if (texture_allocate(r->source.host, &texture) != FNL_OK) return image_fail(&r->source, FNL_ERROR_MEMORY, "out of memory");
    fnl_result result = FNL_OK;
    for (uint32_t mip = 0; mip < texture.mips && result == FNL_OK; mip++) {
        const uint32_t width = texture_side(texture.width, mip), height = texture_side(texture.height, mip), across = DIVIDE_UP(width, 4u);
        const unsigned char *bytes;
        unsigned char *to = texture.bytes + texture_offset(&texture, mip, 0);
        result = reader_face(r, mip, 0, &bytes);
        for (uint32_t i = 0; result == FNL_OK && i < across * DIVIDE_UP(height, 4u); i++, to += 16) {
            uint8_t texels[16][4];
            struct block_structure structure = {.lone = 3}; /* ETC1S: one line, and alpha has a block of its own */
            if (from->format == TEXTURE_UASTC) {
                if (!uastc_decode(bytes + (size_t)16 * i, texels, &structure))
                    result = image_fail(&r->source, FNL_ERROR_FORMAT, "broken KTX2: mip %u has a block that is none of UASTC", mip);
            } else { /* RGBA8 of ETC1S; over the edge the last texels are repeated */
                for (uint32_t k = 0; k < 16; k++) {
                    const uint32_t x = MIN(i % across * 4 + k % 4, width - 1), y = MIN(i / across * 4 + k / 4, height - 1);
                    memcpy(texels[k], bytes + 4 * ((size_t)y * width + x), 4);
                }
            }
            bc7_encode((const uint8_t(*)[4])texels, from->format == TEXTURE_UASTC || r->layout.alpha ? &structure : NULL, to);
        }
    }
    if (result == FNL_OK)
        *out = texture;
    else
        texture_free(r->source.host, &texture);
    return result;
}

static fnl_result decode_reader(struct reader *r, const struct texture_use *use, struct texture *out) {
    const struct texture_layout *layout = &r->layout;
    const bool whole = layout->texture.mips == texture_mips(layout->texture.width, layout->texture.height);
    const bool plain = !layout->flip_x && !layout->flip_y && (!layout->swizzle[0] || memcmp(layout->swizzle, "rgba", 4) == 0);
    TRY(check_use(&r->source, &layout->texture));
    const bool normals = use->normals && has_two_channels(layout->texture.format);
    if (use->mips && whole && plain && !normals && use->keep >> layout->texture.format & 1) return read_whole(r, out);
    const bool packed = layout->texture.format == TEXTURE_UASTC || r->etc1s;
    if (use->mips && whole && plain && packed && use->keep >> TEXTURE_BC7 & 1) return transcode_mips(r, out);
    struct texture texture = layout->texture;
    texture.format = TEXTURE_RGBA8;
    if (!use->mips || !whole) texture.mips = 1;
    TRY(decode_mips(r, normals, &texture));
    *out = texture;
    return FNL_OK;
}

fnl_result texture_decode(const fnl_host *host, const void *bytes, size_t size, const char *name, const struct texture_use *use, struct texture *out) {
    *out = (struct texture){0};
    if (!image_is_dds(bytes, size) && !image_is_ktx2(bytes, size)) {
        fnl_image image;
        TRY(image_decode(host, bytes, size, name, true, &image));
        *out = (struct texture){.format = TEXTURE_RGBA8, .width = image.width, .height = image.height, .faces = 1, .mips = 1, .bytes = image.pixels};
        return FNL_OK;
    }
    struct image_source source = {host, bytes, size, name};
    struct reader reader;
    fnl_result result = reader_open(&source, &reader);
    if (result == FNL_OK) result = decode_reader(&reader, use, out);
    reader_close(&reader);
    return result;
}

fnl_result texture_unpack(const fnl_host *host, const struct texture *texture, struct texture *out) {
    *out = *texture;
    out->format = TEXTURE_RGBA8;
    out->mips = 1;
    TRY(texture_allocate(host, out));
    decode_bytes(texture->format, texture->bytes, texture->width, texture->height, out->bytes);
    return FNL_OK;
}

static bool has_blue(const uint8_t *texels, uint32_t count, uint8_t blue) {
    for (uint32_t i = 0; i < count; i++)
        if (texels[4 * i + 2] != blue) return false;
    return true;
}

int16_t texture_common_blue(const struct texture *texture) {
    const uint32_t size = block_bytes(texture->format);
    uint8_t texels[16][4], blue = 0;
    if (!size) {
        blue = texture->bytes[2];
        for (size_t i = 0; i < texture_offset(texture, texture->mips, 0); i += 4)
            if (texture->bytes[i + 2] != blue) return -1;
        return blue;
    }
    for (uint32_t mip = 0; mip < texture->mips; mip++) {
        const unsigned char *block = texture->bytes + texture_offset(texture, mip, 0);
        const uint32_t width = texture_side(texture->width, mip), height = texture_side(texture->height, mip);
        for (uint32_t y = 0; y < height; y += 4)
            for (uint32_t x = 0; x < width; x += 4, block += size) {
                if (!block_decode(texture->format, block, texels)) return -1;
                if (x + y + mip == 0) blue = texels[0][2];
                for (uint32_t row = 0; row < MIN(height - y, 4u); row++)
                    if (!has_blue(texels[4 * row], MIN(width - x, 4u), blue)) return -1;
            }
    }
    return blue;
}

/* ---- writing ---- */

fnl_result texture_save(const fnl_host *host, const char *path, const struct texture *texture) {
    struct image_source target = {.host = host, .name = path};
    bool dds = path_has_extension(path, "dds");
    if (!dds && !path_has_extension(path, "ktx2"))
        return image_fail(&target, FNL_ERROR_UNSUPPORTED, "textures are written as .dds or .ktx2, not as '.%s'", path_extension(path));
    struct file_writer writer;
    TRY(file_write_begin(host, path, &writer));
    if (dds)
        image_dds_write(&writer, texture);
    else
        image_ktx2_write(&writer, texture);
    return file_write_commit(&writer);
}
