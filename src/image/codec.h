/* SPDX-License-Identifier: MIT */
/** What the readers and writers of the single kinds of file share. Private to this folder. */
#ifndef FNL_IMAGE_CODEC_H
#define FNL_IMAGE_CODEC_H

#include "base/file.h"
#include "image/image.h"
#include "image/texture.h"

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

/** Colors of other primaries than Rec. 709. */
enum primaries { PRIMARIES_REC709, PRIMARIES_OTHER, PRIMARIES_BAD };
/** `primaries`: x and y of red, green, blue and white. Sets `out`, rows of a matrix, for PRIMARIES_OTHER; its white becomes D65. */
enum primaries primaries_matrix(const float primaries[8], float out[9]);
/** Of RGBA pixels; colors that Rec. 709 does not hold get negative values. */
void primaries_convert(const float matrix[9], float *pixels, size_t count);

bool image_is_hdr(const void *bytes, size_t size);
fnl_result image_hdr_peek(const struct image_source *source, struct image_file_info *out);
fnl_result image_hdr_decode(const struct image_source *source, fnl_image *out);
/** RGBA32F; alpha is dropped, what RGBE cannot hold (negative, NaN, tiny, huge) goes to the nearest it can. */
fnl_result image_hdr_write(struct file_writer *writer, const fnl_image *image);

/** Supercompression of KTX2. */
enum ktx2_scheme { KTX2_PLAIN, KTX2_BASIS_LZ, KTX2_ZSTD, KTX2_ZLIB };

/** Where the parts of a texture lie in its file. All of them lie inside of it. */
struct texture_layout {
    struct texture texture; /* without bytes; of ETC1S RGBA8, as which it is read */
    size_t offsets[TEXTURE_MIPS_MAX][6]; /* of all faces the same where a mip is supercompressed */
    uint32_t scheme;                     /* ktx2_scheme; of the rest: */
    size_t lengths[TEXTURE_MIPS_MAX];    /* of mips in the file */
    size_t global, global_size;          /* BasisLZ's */
    bool alpha;                          /* ETC1S has slices of alpha */
    bool flip_x, flip_y;                 /* rows go left, or up */
    char swizzle[4];                     /* of r g b a 0 1; zeros are as "rgba" */
};
bool image_is_dds(const void *bytes, size_t size);
fnl_result image_dds_find(const struct image_source *source, struct texture_layout *out);
void image_dds_write(struct file_writer *writer, const struct texture *texture);
bool image_is_ktx2(const void *bytes, size_t size);
fnl_result image_ktx2_find(const struct image_source *source, struct texture_layout *out);
void image_ktx2_write(struct file_writer *writer, const struct texture *texture);
/** Checks what both kinds of file say of sides, faces and mips. */
fnl_result texture_check(const struct image_source *source, const struct texture *texture);
fnl_result texture_fail_cut_off(const struct image_source *source, uint32_t mip, uint32_t face);

/** The greatest mip of either kind of file as a picture, RGBA8 or RGBA32F; the faces of a cube map stand one below the other. */
fnl_result image_texture_peek(const struct image_source *source, struct image_file_info *out);
fnl_result image_texture_decode(const struct image_source *source, bool force_rgba8, fnl_image *out);

static inline uint32_t little32(const unsigned char *bytes) {
    return bytes[0] | (uint32_t)bytes[1] << 8 | (uint32_t)bytes[2] << 16 | (uint32_t)bytes[3] << 24;
}
static inline uint64_t little64(const unsigned char *bytes) { return little32(bytes) | (uint64_t)little32(bytes + 4) << 32; }
static inline void put_little32(FILE *stream, uint32_t value) {
    for (int i = 0; i < 4; i++) putc((int)(value >> 8 * i & 255), stream);
}
static inline void put_little64(FILE *stream, uint64_t value) {
    put_little32(stream, (uint32_t)value);
    put_little32(stream, (uint32_t)(value >> 32));
}

fnl_result image_exr_peek(const struct image_source *source, struct image_file_info *out);
fnl_result image_exr_decode(const struct image_source *source, fnl_image *out);

#endif
