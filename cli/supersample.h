/* SPDX-License-Identifier: MIT */
/** The mean of frames that sample their pixels at different places (fnl_jitter): what antialiasing is measured against. */
#ifndef FNL_CLI_SUPERSAMPLE_H
#define FNL_CLI_SUPERSAMPLE_H

#include "fanal/fanal.h"

struct supersample {
    double *color, *radiance; /* RGBA; NULL: not asked for */
    uint32_t width, height, count;
};

/**
 * Renders `count` frames and takes the mean of the colour output, of its light after tone mapping, and of the radiance output, as far as `frame`
 * asks for them; the last frame samples centres, so other outputs of the renderer are as ever. False after an error, or without memory.
 */
bool supersample_render(struct supersample *s, fnl_renderer *renderer, const fnl_frame *frame, uint32_t count);
/** Replaces the pixels of a picture of the same size, RGBA8 or RGBA32F, by the mean. */
void supersample_store(const struct supersample *s, fnl_image *picture);
/** Takes the radiance of another mean, and frees the rest of it. */
void supersample_join(struct supersample *s, struct supersample *radiance);
void supersample_free(struct supersample *s);

#endif
