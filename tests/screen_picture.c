/* SPDX-License-Identifier: MIT */
/*
 * screen_picture SCREEN WIDTH HEIGHT OUT.png: the upper left corner of the screen that Xvfb keeps in a file (-fbdir), which has the format of xwd:
 * a header of big-endian 32-bit words (/usr/include/X11/XWDFile.h), colours, then rows of pixels.
 */
#include "fanal/image.h"

#include <stdio.h>
#include <stdlib.h>

static uint32_t word(const unsigned char *bytes, int index) {
    const unsigned char *b = bytes + 4 * index;
    return (uint32_t)b[0] << 24 | (uint32_t)b[1] << 16 | (uint32_t)b[2] << 8 | b[3];
}

int main(int argc, char **argv) {
    enum { CAPACITY = 64 << 20, COLOR_BYTES = 12 };
    unsigned char *bytes = malloc(CAPACITY);
    FILE *file = argc == 5 ? fopen(argv[1], "rb") : NULL;
    if (!file || !bytes) return 2;
    size_t size = fread(bytes, 1, CAPACITY, file);
    fclose(file);
    fnl_image picture = {(uint32_t)atoi(argv[2]), (uint32_t)atoi(argv[3]), FNL_PIXEL_FORMAT_RGBA8, NULL};
    /* Words: 0 header size, 1 version, 4 and 5 width and height, 7 byte order, 11 bits per pixel, 12 bytes per line, 19 number of colours. */
    if (size < 100 || word(bytes, 1) != 7 || word(bytes, 11) != 32 || word(bytes, 4) < picture.width ||
        word(bytes, 5) < picture.height)
        return 2;
    size_t start = word(bytes, 0) + (size_t)word(bytes, 19) * COLOR_BYTES, line = word(bytes, 12);
    bool high_first = word(bytes, 7) != 0;
    if (start + line * picture.height > size) return 2;
    unsigned char *out = malloc((size_t)picture.width * picture.height * 4);
    if (!out) return 2;
    picture.pixels = out;
    for (uint32_t y = 0; y < picture.height; y++)
        for (uint32_t x = 0; x < picture.width; x++, out += 4) {
            const unsigned char *in = bytes + start + y * line + 4 * x; /* 0xRRGGBB */
            out[0] = in[high_first ? 1 : 2];
            out[1] = in[high_first ? 2 : 1];
            out[2] = in[high_first ? 3 : 0];
            out[3] = 255;
        }
    bool good = fnl_image_save(NULL, argv[4], &picture) == FNL_OK;
    free(picture.pixels);
    free(bytes);
    return good ? 0 : 1;
}
