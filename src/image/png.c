/* SPDX-License-Identifier: MIT */
/* PNG through libspng. */
#include "image/codec.h"

#include <spng.h>

/* No compressed byte gives more than this (RFC 1951: 258 bytes from two bits), with room for the rounding of rows. */
#define DEFLATE_RATIO_MAX 1040u
/* Limit of one ancillary chunk (text, colour profile) and of all of them together, decompressed. */
#define CHUNK_BYTES_MAX (64u << 20)

static fnl_result fail(const struct image_source *source, int error) {
    fnl_result result = error == SPNG_EMEM ? FNL_ERROR_MEMORY : FNL_ERROR_FORMAT;
    return image_fail(source, result, "broken PNG: %s", spng_strerror(error));
}

static fnl_result open_png(const struct image_source *source, spng_ctx **out, struct spng_ihdr *header) {
    spng_ctx *png = spng_ctx_new(0);
    if (!png) return image_fail(source, FNL_ERROR_MEMORY, "out of memory");
    spng_set_chunk_limits(png, CHUNK_BYTES_MAX, CHUNK_BYTES_MAX);
    spng_set_png_buffer(png, source->bytes, source->size);
    int error = spng_get_ihdr(png, header);
    fnl_result result;
    /* Sizes of zero and over 2^31 - 1 are errors of the header itself. */
    if (error == SPNG_EWIDTH || error == SPNG_EHEIGHT)
        result = image_fail(source, FNL_ERROR_FORMAT, "broken PNG: %s (zero or too large)", spng_strerror(error));
    else if (error)
        result = fail(source, error);
    else
        result = image_check_size(source, header->width, header->height);
    if (result != FNL_OK)
        spng_ctx_free(png);
    else
        *out = png;
    return result;
}

fnl_result image_png_peek(const struct image_source *source, struct image_file_info *out) {
    spng_ctx *png;
    struct spng_ihdr header;
    TRY(open_png(source, &png, &header));
    spng_ctx_free(png);
    *out = (struct image_file_info){.kind = IMAGE_FILE_PNG, .width = header.width, .height = header.height, .pixel_bytes = header.bit_depth > 8 ? 8 : 4};
    return FNL_OK;
}

static uint64_t held_pixels(const struct image_source *source, const struct spng_ihdr *header) {
    static const uint8_t samples[] = {[SPNG_COLOR_TYPE_GRAYSCALE] = 1,
                                      [SPNG_COLOR_TYPE_TRUECOLOR] = 3,
                                      [SPNG_COLOR_TYPE_INDEXED] = 1,
                                      [SPNG_COLOR_TYPE_GRAYSCALE_ALPHA] = 2,
                                      [SPNG_COLOR_TYPE_TRUECOLOR_ALPHA] = 4};
    uint32_t bits = samples[header->color_type] * header->bit_depth;
    return (uint64_t)source->size * DEFLATE_RATIO_MAX * 8 / bits;
}

/* Rounds to nearest, in place, and gives the upper half of the memory back. */
static fnl_result narrow(const struct image_source *source, fnl_image *image) {
    size_t count = (size_t)image->width * image->height * 4;
    const uint16_t *wide = image->pixels;
    uint8_t *narrowed = image->pixels;
    for (size_t i = 0; i < count; i++) narrowed[i] = (uint8_t)((wide[i] * 255u + 32767u) / 65535u);
    void *pixels = host_resize(source->host, image->pixels, count * 2, count);
    if (!pixels) return image_fail(source, FNL_ERROR_MEMORY, "out of memory");
    image->pixels = pixels;
    image->format = FNL_PIXEL_FORMAT_RGBA8;
    return FNL_OK;
}

fnl_result image_png_decode(const struct image_source *source, bool force_rgba8, fnl_image *out) {
    spng_ctx *png;
    struct spng_ihdr header;
    TRY(open_png(source, &png, &header));
    bool wide = header.bit_depth == 16;
    fnl_image image = {0};
    fnl_result result =
        image_allocate(source, header.width, header.height, wide ? FNL_PIXEL_FORMAT_RGBA16 : FNL_PIXEL_FORMAT_RGBA8,
                       held_pixels(source, &header), &image);
    if (result == FNL_OK) {
        size_t size = (size_t)image.width * image.height * fnl_pixel_size(image.format);
        int error = spng_decode_image(png, image.pixels, size, wide ? SPNG_FMT_RGBA16 : SPNG_FMT_RGBA8, SPNG_DECODE_TRNS);
        /* Read on to the end mark: without it the file has been cut off. */
        if (!error) error = spng_decode_chunks(png);
        if (error) result = fail(source, error);
    }
    spng_ctx_free(png);
    if (result == FNL_OK && wide && force_rgba8) result = narrow(source, &image);
    if (result == FNL_OK)
        *out = image;
    else
        fnl_image_free(source->host, &image);
    return result;
}

/* ---- writing ---- */

static bool is_opaque(const fnl_image *image) {
    size_t count = (size_t)image->width * image->height;
    if (image->format == FNL_PIXEL_FORMAT_RGBA8) {
        const uint8_t *pixels = image->pixels;
        for (size_t i = 0; i < count; i++)
            if (pixels[i * 4 + 3] != UINT8_MAX) return false;
    } else {
        const uint16_t *pixels = image->pixels;
        for (size_t i = 0; i < count; i++)
            if (pixels[i * 4 + 3] != UINT16_MAX) return false;
    }
    return true;
}

static int write_rows(spng_ctx *png, const fnl_image *image, bool opaque, unsigned char *row) {
    size_t sample = fnl_pixel_size(image->format) / 4, pixel = sample * 4, kept = opaque ? sample * 3 : pixel;
    int error = 0;
    for (uint32_t y = 0; y < image->height && (!error || error == SPNG_EOI); y++) {
        const unsigned char *pixels = (const unsigned char *)image->pixels + (size_t)y * image->width * pixel;
        for (size_t x = 0; x < image->width; x++) memcpy(row + x * kept, pixels + x * pixel, kept);
        error = spng_encode_row(png, row, kept * image->width);
    }
    return error == SPNG_EOI ? 0 : error;
}

fnl_result image_png_write(struct file_writer *writer, const fnl_image *image) {
    const fnl_host *host = &writer->host;
    bool opaque = is_opaque(image), wide = image->format == FNL_PIXEL_FORMAT_RGBA16;
    size_t row_size = (size_t)image->width * fnl_pixel_size(image->format);
    unsigned char *row = host_allocate(host, row_size);
    if (!row) return FNL_ERROR_MEMORY;
    spng_ctx *png = spng_ctx_new(SPNG_CTX_ENCODER);
    struct spng_ihdr header = {
        .width = image->width,
        .height = image->height,
        .bit_depth = wide ? 16 : 8,
        .color_type = opaque ? SPNG_COLOR_TYPE_TRUECOLOR : SPNG_COLOR_TYPE_TRUECOLOR_ALPHA,
    };
    int error = png ? spng_set_png_file(png, writer->stream) : SPNG_EMEM;
    if (!error) error = spng_set_ihdr(png, &header);
    if (!error) error = spng_set_srgb(png, 0);
    if (!error) error = spng_encode_image(png, NULL, 0, SPNG_FMT_PNG, SPNG_ENCODE_PROGRESSIVE | SPNG_ENCODE_FINALIZE);
    if (!error) error = write_rows(png, image, opaque, row);
    spng_ctx_free(png);
    host_free(host, row, row_size);
    if (!error || ferror(writer->stream)) return FNL_OK; /* an error of the stream is told, with its reason, when the file is committed */
    log_error(host, "%s: cannot be written: %s", writer->path, spng_strerror(error));
    return error == SPNG_EMEM ? FNL_ERROR_MEMORY : FNL_ERROR_FILE;
}

fnl_result image_png_encode(const fnl_host *host, const char *name, const fnl_image *image, char **out, size_t *out_size) {
    *out = NULL;
    struct file_writer writer = {.stream = open_memstream(out, out_size), .path = (char *)name, .host = *host};
    fnl_result result = writer.stream ? image_png_write(&writer, image) : FNL_ERROR_MEMORY;
    const bool lost = writer.stream && ferror(writer.stream);
    if (writer.stream && (fclose(writer.stream) != 0 || lost) && result == FNL_OK) result = FNL_ERROR_MEMORY;
    if (result == FNL_OK) return FNL_OK;
    if (result == FNL_ERROR_MEMORY) log_error(host, "%s: memory ran out", name);
    free(*out);
    *out = NULL;
    return result;
}
