/* SPDX-License-Identifier: MIT */
#include "supersample.h"

#include <math.h>
#include <stdlib.h>

static double decode(double c) { return c <= 0.04045 ? c / 12.92 : pow((c + 0.055) / 1.055, 2.4); }
static double encode(double c) { return c <= 0.0031308 ? 12.92 * c : 1.055 * pow(c, 1 / 2.4) - 0.055; }

static bool add(fnl_renderer *renderer, fnl_output output, double *sum) {
    fnl_image image;
    double light[256];
    if (!sum) return true;
    if (fnl_renderer_read(renderer, output, &image) != FNL_OK) return false;
    size_t count = (size_t)image.width * image.height * 4;
    for (int i = 0; i < 256; i++) light[i] = decode(i / 255.0);
    for (size_t i = 0; i < count; i++)
        sum[i] += image.format == FNL_PIXEL_FORMAT_RGBA32F ? (double)((const float *)image.pixels)[i]
                  : i % 4 == 3                             ? ((const unsigned char *)image.pixels)[i] / 255.0
                                                           : light[((const unsigned char *)image.pixels)[i]];
    fnl_image_free(NULL, &image);
    return true;
}

bool supersample_render(struct supersample *s, fnl_renderer *renderer, const fnl_frame *frame, uint32_t count) {
    uint32_t height = frame->height * (frame->view_count ? frame->view_count : 1); /* of the pictures of all views together */
    size_t values = (size_t)frame->width * height * 4;
    bool color = frame->outputs & FNL_OUTPUT_COLOR, radiance = frame->outputs & FNL_OUTPUT_RADIANCE;
    *s = (struct supersample){.width = frame->width, .height = height, .count = count};
    if (color) s->color = calloc(values, sizeof *s->color);
    if (radiance) s->radiance = calloc(values, sizeof *s->radiance);
    bool good = (!color || s->color) && (!radiance || s->radiance);
    fnl_frame jittered = *frame;
    for (uint32_t i = count; i-- > 0 && good;) {
        fnl_vec2 place = fnl_jitter(i);
        jittered.jitter = (fnl_vec2){frame->jitter.x + place.x, frame->jitter.y + place.y};
        /* As many as there are; frames that know those before count by themselves, upwards. */
        if (frame->aa != FNL_ANTIALIASING_TAA && !frame->shadow.denoise && !frame->shadow.guide) jittered.shadow.seed = (frame->shadow.seed + i) % 1000000;
        good = fnl_renderer_render(renderer, &jittered) == FNL_OK && add(renderer, FNL_OUTPUT_COLOR, s->color) &&
               add(renderer, FNL_OUTPUT_RADIANCE, s->radiance);
    }
    return good;
}

void supersample_store(const struct supersample *s, fnl_image *picture) {
    size_t values = (size_t)s->width * s->height * 4;
    for (size_t i = 0; i < values; i++) {
        if (picture->format == FNL_PIXEL_FORMAT_RGBA32F && s->radiance)
            ((float *)picture->pixels)[i] = (float)(s->radiance[i] / s->count);
        if (picture->format == FNL_PIXEL_FORMAT_RGBA8 && s->color) {
            double mean = s->color[i] / s->count;
            ((unsigned char *)picture->pixels)[i] = (unsigned char)lrint((i % 4 == 3 ? mean : encode(mean)) * 255);
        }
    }
}

void supersample_join(struct supersample *s, struct supersample *radiance) {
    free(s->radiance);
    s->radiance = radiance->radiance;
    radiance->radiance = NULL;
    supersample_free(radiance);
}

void supersample_free(struct supersample *s) {
    free(s->color);
    free(s->radiance);
    *s = (struct supersample){0};
}
