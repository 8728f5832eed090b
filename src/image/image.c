/* SPDX-License-Identifier: MIT */
#include "image/image.h"

#include "base/file.h"
#include "image/codec.h"

static size_t image_bytes(const fnl_image *image) {
    return (size_t)image->width * image->height * fnl_pixel_size(image->format);
}

/* ---- what the codecs share ---- */

fnl_result image_fail(const struct image_source *source, fnl_result result, const char *format, ...) {
    char text[1024];
    va_list arguments;
    va_start(arguments, format);
    text_format_list(text, sizeof text, format, arguments);
    va_end(arguments);
    /* Some of the text comes from libraries that quote the file. */
    for (char *c = text; *c; c++)
        if ((unsigned char)*c < 0x20 || (unsigned char)*c == 0x7f) *c = ' ';
    log_error(source->host, "%s: %s", source->name, text);
    return result;
}

fnl_result image_check_size(const struct image_source *source, uint64_t width, uint64_t height) {
    if (width == 0 || height == 0)
        return image_fail(source, FNL_ERROR_FORMAT, "the picture has no pixels (%llu x %llu)", (unsigned long long)width,
                          (unsigned long long)height);
    if (width > IMAGE_SIDE_MAX || height > IMAGE_SIDE_MAX || width * height > IMAGE_PIXELS_MAX)
        return image_fail(source, FNL_ERROR_UNSUPPORTED,
                          "a picture of %llu x %llu pixels is over the limit (%u a side, %u in all)",
                          (unsigned long long)width, (unsigned long long)height, IMAGE_SIDE_MAX, IMAGE_PIXELS_MAX);
    return FNL_OK;
}

fnl_result image_allocate(const struct image_source *source, uint32_t width, uint32_t height, fnl_pixel_format format,
                          uint64_t held_pixels, fnl_image *out) {
    uint64_t pixels = (uint64_t)width * height;
    if (pixels > held_pixels)
        return image_fail(source, FNL_ERROR_FORMAT, "broken: %zu bytes cannot hold the %u x %u pixels of the header",
                          source->size, width, height);
    fnl_image image = {.width = width, .height = height, .format = format};
    const bool fits = image_bytes(&image) / fnl_pixel_size(format) == pixels; /* in a size_t of 32 bits */
    image.pixels = fits ? host_allocate(source->host, image_bytes(&image)) : NULL;
    if (!image.pixels) return image_fail(source, FNL_ERROR_MEMORY, "no memory for %u x %u pixels", width, height);
    *out = image;
    return FNL_OK;
}

/* ---- reading ---- */

static enum image_file_kind recognise(const unsigned char *bytes, size_t size) {
    if (size >= 8 && memcmp(bytes, "\x89PNG\r\n\x1a\n", 8) == 0) return IMAGE_FILE_PNG;
    if (size >= 3 && memcmp(bytes, "\xff\xd8\xff", 3) == 0) return IMAGE_FILE_JPEG;
    if (size >= 12 && memcmp(bytes, "RIFF", 4) == 0 && memcmp(bytes + 8, "WEBP", 4) == 0) return IMAGE_FILE_WEBP;
    if (size >= 4 && memcmp(bytes, "\x76\x2f\x31\x01", 4) == 0) return IMAGE_FILE_EXR;
    if (image_is_hdr(bytes, size)) return IMAGE_FILE_HDR;
    if (image_is_dds(bytes, size)) return IMAGE_FILE_DDS;
    if (image_is_ktx2(bytes, size)) return IMAGE_FILE_KTX2;
    return IMAGE_FILE_UNKNOWN;
}

static fnl_result fail_unknown(const struct image_source *source) {
    if (source->size == 0) return image_fail(source, FNL_ERROR_FORMAT, "is empty, not a picture");
    return image_fail(source, FNL_ERROR_FORMAT, "is not a picture of a known kind (PNG, JPEG, WebP, Radiance HDR, OpenEXR, DDS, KTX2)");
}

fnl_result image_peek(const fnl_host *host, const void *bytes, size_t size, const char *name, struct image_file_info *out) {
    *out = (struct image_file_info){0};
    struct image_source source = {host, bytes, size, name};
    switch (recognise(bytes, size)) {
    case IMAGE_FILE_PNG:
        return image_png_peek(&source, out);
    case IMAGE_FILE_JPEG:
        return image_jpeg_peek(&source, out);
    case IMAGE_FILE_WEBP:
        return image_webp_peek(&source, out);
    case IMAGE_FILE_HDR:
        return image_hdr_peek(&source, out);
    case IMAGE_FILE_EXR:
        return image_exr_peek(&source, out);
    case IMAGE_FILE_DDS:
    case IMAGE_FILE_KTX2:
        return image_texture_peek(&source, out);
    case IMAGE_FILE_UNKNOWN:
        break;
    }
    return fail_unknown(&source);
}

fnl_result image_decode(const fnl_host *host, const void *bytes, size_t size, const char *name, bool force_rgba8,
                        fnl_image *out) {
    *out = (fnl_image){0};
    struct image_source source = {host, bytes, size, name};
    enum image_file_kind kind = recognise(bytes, size);
    if (force_rgba8 && (kind == IMAGE_FILE_HDR || kind == IMAGE_FILE_EXR))
        return image_fail(&source, FNL_ERROR_UNSUPPORTED,
                          "floating-point pictures cannot be used here, only PNG, JPEG, WebP, DDS and KTX2");
    switch (kind) {
    case IMAGE_FILE_PNG:
        return image_png_decode(&source, force_rgba8, out);
    case IMAGE_FILE_JPEG:
        return image_jpeg_decode(&source, out);
    case IMAGE_FILE_WEBP:
        return image_webp_decode(&source, out);
    case IMAGE_FILE_HDR:
        return image_hdr_decode(&source, out);
    case IMAGE_FILE_EXR:
        return image_exr_decode(&source, out);
    case IMAGE_FILE_DDS:
    case IMAGE_FILE_KTX2:
        return image_texture_decode(&source, force_rgba8, out);
    case IMAGE_FILE_UNKNOWN:
        break;
    }
    return fail_unknown(&source);
}

static fnl_result decode_within(const struct image_source *source, uint64_t max_bytes, uint32_t more, fnl_image *out) {
    struct image_file_info info;
    TRY(image_peek(source->host, source->bytes, source->size, source->name, &info));
    const uint64_t needed = (uint64_t)info.width * info.height * (info.pixel_bytes + more);
    if (needed > max_bytes)
        return image_fail(source, FNL_ERROR_MEMORY, "the picture of %u x %u pixels needs %llu bytes of memory, over the limit of %llu", info.width,
                          info.height, (unsigned long long)needed, (unsigned long long)max_bytes);
    return image_decode(source->host, source->bytes, source->size, source->name, false, out);
}

fnl_result image_load(const fnl_host *host, const char *path, uint64_t max_bytes, uint32_t more, fnl_image *out) {
    *out = (fnl_image){0};
    struct file_view view;
    TRY(file_load(host, path, &view));
    fnl_result result = decode_within(&(struct image_source){host, view.data, view.size, path}, max_bytes, more, out);
    file_free(host, &view);
    return result;
}

fnl_result fnl_image_load_within(const fnl_host *host, const char *path, uint64_t max_bytes, fnl_image *out) {
    fnl_host resolved = host_resolve(host);
    TRY(check_pointer(CALL(&resolved), "path", path));
    TRY(check_pointer(CALL(&resolved), "out", out));
    return image_load(&resolved, path, max_bytes, 0, out);
}

fnl_result fnl_image_load(const fnl_host *host, const char *path, fnl_image *out) {
    fnl_host resolved = host_resolve(host);
    TRY(check_pointer(CALL(&resolved), "path", path));
    TRY(check_pointer(CALL(&resolved), "out", out));
    return image_load(&resolved, path, host_memory_limit(), 0, out);
}

void fnl_image_free(const fnl_host *host, fnl_image *image) {
    if (!image) return;
    fnl_host resolved = host_resolve(host);
    host_free(&resolved, image->pixels, image_bytes(image));
    *image = (fnl_image){0};
}

/* ---- writing ---- */

static fnl_result save_exr(const fnl_host *host, const char *path, const fnl_image *image) {
    const float *pixels = image->pixels;
    const fnl_exr_channel channels[] = {{"R", pixels, 4}, {"G", pixels + 1, 4}, {"B", pixels + 2, 4}, {"A", pixels + 3, 4}};
    return fnl_exr_save(host, path, image->width, image->height, channels, COUNT_OF(channels));
}

fnl_result image_check(const struct call *call, const char *name, const fnl_image *image) {
    TRY(check_pointer(call, name, image));
    char field[64];
    snprintf(field, sizeof field, "%s.format", name);
    TRY(check_enum(call, field, (int)image->format, FNL_PIXEL_FORMAT_RGBA32F + 1, "fnl_pixel_format"));
    snprintf(field, sizeof field, "%s.width", name);
    TRY(check_count(call, field, image->width, 1, IMAGE_SIDE_MAX));
    snprintf(field, sizeof field, "%s.height", name);
    TRY(check_count(call, field, image->height, 1, IMAGE_SIDE_MAX));
    snprintf(field, sizeof field, "%s.pixels", name);
    return check_pointer(call, field, image->pixels);
}

fnl_result fnl_image_save(const fnl_host *host, const char *path, const fnl_image *image) {
    fnl_host resolved = host_resolve(host);
    TRY(check_pointer(CALL(&resolved), "path", path));
    TRY(image_check(CALL(&resolved), "image", image));
    struct image_source target = {.host = &resolved, .name = path};
    if (image_check_size(&target, image->width, image->height) != FNL_OK) return FNL_ERROR_INVALID; /* too many pixels */

    bool is_float = image->format == FNL_PIXEL_FORMAT_RGBA32F;
    bool png = path_has_extension(path, "png"), exr = path_has_extension(path, "exr"), hdr = path_has_extension(path, "hdr");
    if (!png && !exr && !hdr)
        return image_fail(&target, FNL_ERROR_UNSUPPORTED, "pictures are written as .png, .exr or .hdr, not as '.%s'",
                          path_extension(path));
    if (png && is_float) return image_fail(&target, FNL_ERROR_INVALID, "PNG holds 8-bit or 16-bit pixels, not floats");
    if (!png && !is_float) return image_fail(&target, FNL_ERROR_INVALID, "EXR and HDR hold float pixels, not integers");
    if (exr) return save_exr(&resolved, path, image);

    struct file_writer writer;
    TRY(file_write_begin(&resolved, path, &writer));
    fnl_result result = png ? image_png_write(&writer, image) : image_hdr_write(&writer, image);
    if (result == FNL_OK) return file_write_commit(&writer);
    file_write_abandon(&writer);
    return result;
}
