/* SPDX-License-Identifier: MIT */
/**
 * Decoders of KHR_meshopt_compression and EXT_meshopt_compression, after the text of the former (Appendices A and B): attributes in version 0 and
 * 1, triangles and index sequences in 0 and 1, and the filters. `out` holds count * stride bytes. False: the data is broken, or not all of it
 * was needed; `out` then holds anything. Nothing outside of `data` is read.
 */
#ifndef FNL_SCENE_MESHCODE_H
#define FNL_SCENE_MESHCODE_H

#include <stdbool.h>
#include <stddef.h>

/** `stride` is a multiple of 4 up to 256. */
bool meshcode_attributes(void *out, size_t count, size_t stride, const unsigned char *data, size_t size);
/** `count` indices, a multiple of 3, of `stride` 2 or 4 bytes. */
bool meshcode_triangles(void *out, size_t count, size_t stride, const unsigned char *data, size_t size);
bool meshcode_indices(void *out, size_t count, size_t stride, const unsigned char *data, size_t size);

/** In place. Values that the extension calls unspecified give anything, but nothing undefined. */
void meshcode_filter_octahedral(void *data, size_t count, size_t stride); /* 4 or 8 */
void meshcode_filter_quaternion(void *data, size_t count);                /* stride 8 */
void meshcode_filter_exponential(void *data, size_t count, size_t stride);
void meshcode_filter_color(void *data, size_t count, size_t stride); /* 4 or 8 */

#endif
