/* SPDX-License-Identifier: MIT */
/* Small pictures for the page, and the comparison of big ones. */
#include "bench.h"

#include "output.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* The mean of the pixels that each small one covers, in the encoded values: these are pictures for a quick look. */
static bool shrink(const fnl_image *picture, uint32_t width, fnl_image *out) {
    uint32_t factor = (picture->width + width - 1) / width;
    *out = (fnl_image){picture->width / factor, picture->height / factor, FNL_PIXEL_FORMAT_RGBA8, NULL};
    if (out->width < 1) out->width = 1;
    if (out->height < 1) out->height = 1;
    unsigned char *to = out->pixels = malloc((size_t)out->width * out->height * 4);
    const unsigned char *from = picture->pixels;
    if (!to) return false;
    for (uint32_t y = 0; y < out->height; y++)
        for (uint32_t x = 0; x < out->width; x++)
            for (uint32_t c = 0; c < 4; c++) {
                uint32_t sum = 0, count = 0;
                for (uint32_t v = y * factor; v < (y + 1) * factor && v < picture->height; v++)
                    for (uint32_t u = x * factor; u < (x + 1) * factor && u < picture->width; u++, count++)
                        sum += from[((size_t)v * picture->width + u) * 4 + c];
                *to++ = (unsigned char)((sum + count / 2) / count);
            }
    return true;
}

static char *encode_base64(const unsigned char *bytes, size_t size, const char *prefix) {
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    size_t start = strlen(prefix);
    char *text = malloc(start + (size + 2) / 3 * 4 + 1), *to = text ? text + start : NULL;
    if (!text) return NULL;
    memcpy(text, prefix, start);
    for (size_t i = 0; i < size; i += 3) {
        uint32_t group = (uint32_t)bytes[i] << 16;
        if (i + 1 < size) group |= (uint32_t)bytes[i + 1] << 8;
        if (i + 2 < size) group |= bytes[i + 2];
        *to++ = digits[group >> 18];
        *to++ = digits[group >> 12 & 63];
        *to++ = i + 1 < size ? digits[group >> 6 & 63] : '=';
        *to++ = i + 2 < size ? digits[group & 63] : '=';
    }
    *to = 0;
    return text;
}

static json_t *encode_file(const char *path) {
    FILE *file = fopen(path, "rb");
    json_t *uri = NULL;
    if (!file) return NULL;
    fseek(file, 0, SEEK_END);
    long size = ftell(file);
    rewind(file);
    unsigned char *bytes = size > 0 ? malloc((size_t)size) : NULL;
    if (bytes && fread(bytes, 1, (size_t)size, file) == (size_t)size) {
        char *text = encode_base64(bytes, (size_t)size, "data:image/png;base64,");
        if (text) uri = json_string(text);
        free(text);
    }
    free(bytes);
    fclose(file);
    return uri;
}

json_t *bench_picture_uri(const fnl_image *picture, uint32_t width) {
    char folder[PATH_MAX], path[PATH_MAX + 16];
    fnl_image small;
    json_t *uri = NULL;
    if (picture->format != FNL_PIXEL_FORMAT_RGBA8 || !picture->width || !picture->height) return NULL;
    if (!output_make_folder(folder)) return NULL;
    snprintf(path, sizeof path, "%s/picture.png", folder);
    if (shrink(picture, width, &small) && fnl_image_save(NULL, path, &small) == FNL_OK) uri = encode_file(path);
    unlink(path);
    rmdir(folder);
    free(small.pixels);
    return uri;
}

void bench_picture_compare(const fnl_image *a, const fnl_image *b, uint64_t *differing, double *max) {
    *differing = 0;
    *max = 0;
    size_t size = fnl_pixel_size(a->format);
    uint64_t count = (uint64_t)a->width * a->height;
    if (a->width != b->width || a->height != b->height || a->format != b->format) {
        *differing = count;
        *max = INFINITY;
        return;
    }
    for (uint64_t i = 0; i < count; i++)
        *differing += memcmp((const char *)a->pixels + i * size, (const char *)b->pixels + i * size, size) != 0;
    fnl_image_difference difference;
    if (*differing && fnl_image_compare(NULL, a, b, &difference) == FNL_OK) *max = difference.max;
}
