/* SPDX-License-Identifier: MIT */
/** What the readers and writers of the single kinds of file share. Private to this folder. */
#ifndef FNL_IMAGE_CODEC_H
#define FNL_IMAGE_CODEC_H

#include "base/file.h"
#include "image/image.h"

/** Most pixels of one picture; 4 GiB as RGBA32F. */
#define IMAGE_PIXELS_MAX (1u << 28)

/** A file in memory, and what to call it in messages. */
struct image_source {
    const fnl_host *host;
    const unsigned char *bytes;
    size_t size;
    const char *name;
};

/** Logs "NAME: …" and returns `result`. */
fnl_result image_fail(const struct image_source *source, fnl_result result, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/** Refuses empty pictures, and sides and areas over the limits. */
fnl_result image_check_size(const struct image_source *source, uint64_t width, uint64_t height);

/**
 * Allocates the pixels of a size that image_check_size has passed. `held_pixels` is the most pixels that this file could
 * hold, judged by its size and its kind of compression: a header that claims more is refused before anything is allocated.
 */
fnl_result image_allocate(const struct image_source *source, uint32_t width, uint32_t height, fnl_pixel_format format,
                          uint64_t held_pixels, fnl_image *out);

/*
 * Each peek logs its errors and checks the size. Each decode sets `out` only on success, and may be called without a peek
 * before it.
 */

fnl_result image_png_peek(const struct image_source *source, struct image_file_info *out);
fnl_result image_png_decode(const struct image_source *source, bool force_rgba8, fnl_image *out);
/** RGBA8 or RGBA16. An opaque picture is written without alpha. */
fnl_result image_png_write(struct file_writer *writer, const fnl_image *image);

fnl_result image_jpeg_peek(const struct image_source *source, struct image_file_info *out);
fnl_result image_jpeg_decode(const struct image_source *source, fnl_image *out);

fnl_result image_webp_peek(const struct image_source *source, struct image_file_info *out);
fnl_result image_webp_decode(const struct image_source *source, fnl_image *out);

bool image_is_hdr(const void *bytes, size_t size);
fnl_result image_hdr_peek(const struct image_source *source, struct image_file_info *out);
fnl_result image_hdr_decode(const struct image_source *source, fnl_image *out);
/** RGBA32F; alpha is dropped, what RGBE cannot hold (negative, NaN, tiny, huge) goes to the nearest it can. */
fnl_result image_hdr_write(struct file_writer *writer, const fnl_image *image);

fnl_result image_exr_peek(const struct image_source *source, struct image_file_info *out);
fnl_result image_exr_decode(const struct image_source *source, fnl_image *out);

#endif
