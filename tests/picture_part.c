/* SPDX-License-Identifier: MIT */
/* picture_part IN X Y WIDTH HEIGHT OUT.png: a rectangle of a picture. */
#include "fanal/image.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

int main(int argc, char **argv) {
    fnl_image in, out = {.format = FNL_PIXEL_FORMAT_RGBA8};
    if (argc != 7 || fnl_image_load(NULL, argv[1], &in) != FNL_OK) return 2;
    const uint32_t x = (uint32_t)atoi(argv[2]), y = (uint32_t)atoi(argv[3]);
    out.width = (uint32_t)atoi(argv[4]);
    out.height = (uint32_t)atoi(argv[5]);
    if (in.format != FNL_PIXEL_FORMAT_RGBA8 || x + out.width > in.width || y + out.height > in.height) {
        fprintf(stderr, "%s has %u x %u pixels\n", argv[1], in.width, in.height);
        return 2;
    }
    out.pixels = malloc((size_t)out.width * out.height * 4);
    if (!out.pixels) return 2;
    for (uint32_t row = 0; row < out.height; row++)
        memcpy((char *)out.pixels + 4 * (size_t)row * out.width, (const char *)in.pixels + 4 * ((size_t)(y + row) * in.width + x), 4 * (size_t)out.width);
    const bool good = fnl_image_save(NULL, argv[6], &out) == FNL_OK;
    free(out.pixels);
    fnl_image_free(NULL, &in);
    return good ? 0 : 1;
}
