/* SPDX-License-Identifier: MIT */
/** The standard output as the place for pictures and numbers (-o -, --stats -). There is one, as there is one standard output. */
#ifndef FNL_CLI_STREAM_H
#define FNL_CLI_STREAM_H

#include "fanal/fanal.h"

/** Takes the standard output: what is printed goes to stderr from then on. A reader that goes away is an error, not a signal. */
bool stream_open(void);
/** All of these: false with a message, which is sent once. */
bool stream_write(const void *bytes, size_t size);
/** Copies a file. */
bool stream_file(const char *path);
/** Pixels of an RGBA8 picture, row by row from the top, without any header. */
bool stream_raw(const fnl_image *picture);
/** The next picture of a YUV4MPEG2 stream, before the first of them its header; `frame_time` in seconds. */
bool stream_y4m(const fnl_image *picture, double frame_time);

/**
 * The planes Y, Cb and Cr, `count` bytes each, of sRGB-encoded RGBA8 pixels; alpha is left out. ITU-R BT.709-6: Y' = 0.2126 R' + 0.7152 G' +
 * 0.0722 B', Cb = (B' - Y') / 1.8556, Cr = (R' - Y') / 1.5748; quantised to 16 + 219 Y' and 128 + 224 C, to the nearest, halves upwards.
 */
void y4m_convert(const uint8_t *pixels, size_t count, uint8_t *planes);
/** The line before the first picture: size, rate, progressive, square pixels, 4:4:4, limited range. */
void y4m_header(char *text, size_t capacity, uint32_t width, uint32_t height, double frame_time);

#endif
