/* SPDX-License-Identifier: MIT */
/** Image files in memory, for the importers; the public face is fanal/image.h. */
#ifndef FNL_IMAGE_IMAGE_H
#define FNL_IMAGE_IMAGE_H

#include "base/base.h"
#include "base/check.h"
#include "fanal/image.h"
#include "image/texture.h"

enum image_file_kind {
    IMAGE_FILE_UNKNOWN,
    IMAGE_FILE_PNG,
    IMAGE_FILE_JPEG,
    IMAGE_FILE_WEBP,
    IMAGE_FILE_HDR,
    IMAGE_FILE_EXR,
    IMAGE_FILE_DDS,
    IMAGE_FILE_KTX2,
};

struct image_file_info {
    enum image_file_kind kind;
    uint32_t width, height;
    uint32_t pixel_bytes; /* of the picture that image_decode makes of it */
    /* Of DDS and KTX2: */
    bool cube, is_float;
    enum texture_transfer transfer; /* what the file says */
};

/** No image side may be longer than this: a broken header cannot ask for all memory. */
#define IMAGE_SIDE_MAX 32768u

/** Whether a program's picture is whole; `name` is the argument. */
fnl_result image_check(const struct call *call, const char *name, const fnl_image *image);

/**
 * Reads only the header. `name` stands for the file in messages ("scene.gltf: /images/3"). `host` is resolved
 * (host_resolve). Unknown contents, zero sizes, sides over IMAGE_SIDE_MAX and more than 2^28 pixels are logged errors.
 */
fnl_result image_peek(const fnl_host *host, const void *bytes, size_t size, const char *name, struct image_file_info *out);

/**
 * Decodes a whole file in memory, to the formats that fnl_image_load documents, or with `force_rgba8` always to RGBA8
 * (16-bit values are rounded; pictures of floats and cube maps are then refused). Thread-safe.
 */
fnl_result image_decode(const fnl_host *host, const void *bytes, size_t size, const char *name, bool force_rgba8,
                        fnl_image *out);

/**
 * fnl_image_load_within, with `more` bytes a pixel that the caller is going to add. `host` is resolved.
 */
fnl_result image_load(const fnl_host *host, const char *path, uint64_t max_bytes, uint32_t more, fnl_image *out);

/** An RGBA8 or RGBA16 picture as a PNG file in memory; free() it. `name` is for messages. */
fnl_result image_png_encode(const fnl_host *host, const char *name, const fnl_image *image, char **out, size_t *out_size);

#endif
