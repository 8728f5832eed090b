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
/** How YUV4MPEG2 holds color: for squares of 2x2 pixels, which every player reads, or for each pixel. */
enum y4m_chroma { Y4M_420, Y4M_444 };
/** The next picture of a YUV4MPEG2 stream, before the first of them its header; `frame_time` in seconds. */
bool stream_y4m(const fnl_image *picture, enum y4m_chroma chroma, double frame_time);

/** Whether pictures of this size can be written; false with a message that names the next even size. */
bool y4m_check_size(uint32_t width, uint32_t height, enum y4m_chroma chroma);
/** Bytes of a picture. */
size_t y4m_size(uint32_t width, uint32_t height, enum y4m_chroma chroma);
/**
 * The planes Y, Cb and Cr of sRGB-encoded RGBA8 pixels; alpha is left out. ITU-R BT.709-6: Y' = 0.2126 R' + 0.7152 G' + 0.0722 B',
 * Cb = (B' - Y') / 1.8556, Cr = (R' - Y') / 1.5748; quantized to 16 + 219 Y' and 128 + 224 C, to the nearest, halves upwards. Y4M_420: Cb and Cr are the
 * means of 2x2 pixels, and belong to the middle of these.
 */
void y4m_convert(const uint8_t *pixels, uint32_t width, uint32_t height, enum y4m_chroma chroma, uint8_t *planes);
/** The line before the first picture: size, rate, progressive, square pixels, chroma, limited range. */
void y4m_header(char *text, size_t capacity, uint32_t width, uint32_t height, enum y4m_chroma chroma, double frame_time);

#endif
