/* SPDX-License-Identifier: MIT */
/** ETC1S under BasisLZ (KTX 2.0, "BasisLZ Global Data" and "BasisLZ/ETC1S Bitstream Specification"), decoded to RGBA8. */
#ifndef FNL_IMAGE_ETC1S_H
#define FNL_IMAGE_ETC1S_H

#include "image/codec.h"

/** The codebooks and tables that all slices of a file share. */
struct etc1s;

/** `global`: the supercompression's global data, of a file of `images` pictures (mips and faces). Errors are logged. */
fnl_result etc1s_create(const struct image_source *source, const unsigned char *global, size_t size, uint32_t images, struct etc1s **out);
void etc1s_destroy(const fnl_host *host, struct etc1s **etc1s);
/** A picture from its slices, which stand in `level`; `alpha`: it must have one of alpha. `pixels`: RGBA8, width * height of them. */
fnl_result etc1s_decode(const struct image_source *source, const struct etc1s *etc1s, uint32_t image, const unsigned char *level, size_t level_size,
                        bool alpha, uint32_t width, uint32_t height, uint8_t *pixels);

#endif
