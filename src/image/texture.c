/* SPDX-License-Identifier: MIT */
#include "image/texture.h"

#include "base/maths.h"
#include "image/bc6h.h"
#include "image/codec.h"

uint32_t texture_mips(uint32_t width, uint32_t height) {
    uint32_t mips = 1;
    while (MAX(width, height) >> mips) mips++;
    return mips;
}

size_t texture_face_bytes(const struct texture *texture, uint32_t mip) {
    uint32_t width = texture_side(texture->width, mip), height = texture_side(texture->height, mip);
    switch (texture->format) {
    case TEXTURE_RGBA16F:
        return (size_t)width * height * 8;
    case TEXTURE_RGBA32F:
        return (size_t)width * height * 16;
    default:
        return bc6h_block_count(width, height) * BC6H_BLOCK_BYTES;
    }
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

fnl_result texture_read(const fnl_host *host, const void *bytes, size_t size, const char *name, struct texture *out) {
    *out = (struct texture){0};
    struct image_source source = {host, bytes, size, name};
    struct texture_layout layout;
    if (!image_is_dds(bytes, size) && !image_is_ktx2(bytes, size))
        return image_fail(&source, FNL_ERROR_FORMAT, size ? "is neither a DDS nor a KTX2 file" : "is empty, not a texture");
    TRY(find(&source, &layout));
    struct texture texture = layout.texture;
    if (texture_allocate(host, &texture) != FNL_OK) return image_fail(&source, FNL_ERROR_MEMORY, "out of memory");
    for (uint32_t mip = 0; mip < texture.mips; mip++)
        for (uint32_t face = 0; face < texture.faces; face++)
            memcpy(texture.bytes + texture_offset(&texture, mip, face), source.bytes + layout.offsets[mip][face],
                   texture_face_bytes(&texture, mip));
    *out = texture;
    return FNL_OK;
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
    *out = (struct image_file_info){IMAGE_FILE_TEXTURE, layout.texture.width, layout.texture.height * layout.texture.faces};
    return FNL_OK;
}

static void decode_face(enum texture_format format, const unsigned char *bytes, uint32_t width, uint32_t height, float *rgba) {
    size_t values = (size_t)width * height * 4;
    if (format == TEXTURE_RGBA32F) {
        memcpy(rgba, bytes, values * sizeof(float));
    } else if (format == TEXTURE_RGBA16F) {
        for (size_t i = 0; i < values; i++) rgba[i] = half_to_float((uint16_t)(bytes[i * 2] | bytes[i * 2 + 1] << 8));
    } else {
        bc6h_decode_picture(bytes, format == TEXTURE_BC6H_SIGNED, width, height, rgba);
    }
}

fnl_result image_texture_decode(const struct image_source *source, fnl_image *out) {
    struct texture_layout layout;
    TRY(find(source, &layout));
    const struct texture *texture = &layout.texture;
    fnl_image image;
    TRY(image_allocate(source, texture->width, texture->height * texture->faces, FNL_PIXEL_FORMAT_RGBA32F, IMAGE_PIXELS_MAX, &image));
    for (uint32_t face = 0; face < texture->faces; face++)
        decode_face(texture->format, source->bytes + layout.offsets[0][face], texture->width, texture->height,
                    (float *)image.pixels + (size_t)face * texture->width * texture->height * 4);
    *out = image;
    return FNL_OK;
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
