/* SPDX-License-Identifier: MIT */
/** Small files of every kind the readers take, made by code for the tests and as seeds of the fuzzer. Not in the library. */
#ifndef FNL_IMAGE_IMAGE_SAMPLES_H
#define FNL_IMAGE_IMAGE_SAMPLES_H

#include "image/image.h"

struct image_sample {
    const char *name; /* a file name */
    enum image_file_kind kind;
    unsigned char *bytes;
    size_t size;
    fnl_image expected;
    double tolerance;  /* greatest difference to `expected` that the file's compression may make */
    fnl_result result; /* what decoding gives */
};

#define IMAGE_SAMPLES_MAX 64

/** Makes all samples in one size; returns how many. Aborts when a library fails to write. */
uint32_t image_samples_make(struct image_sample samples[IMAGE_SAMPLES_MAX], uint32_t width, uint32_t height);
void image_samples_free(struct image_sample *samples, uint32_t count);

#endif
