/* SPDX-License-Identifier: MIT */
/**
 * For tests: generated files that replace sample models and panoramas missing from a checkout. A stand-in has its
 * sample's size, its number of meshes, materials and images, and its tested features, with fewer triangles and
 * texels. Names are relative to stand_in_folder().
 */
#ifndef FNL_TESTS_STAND_IN_H
#define FNL_TESTS_STAND_IN_H

#include "base/base.h"

#include "fanal/image.h"

/** Where samples are: $FANAL_SCENES, default ../shared/scenes. */
const char *stand_in_folder(void);
/** Path of a sample, in a buffer that the next call reuses; NULL where it is missing. */
const char *stand_in_sample(const char *name);

/** A GLB, to free with free(); NULL: nothing replaces the sample. */
unsigned char *stand_in_model(const char *name, size_t *size);
/** stand_in_figures.c: animals and people; the same contract. */
unsigned char *stand_in_figure(const char *name, size_t *size);

enum stand_in_texture {
    STAND_IN_COLOR,      /* a checkered cloth with stains */
    STAND_IN_CLEAR,      /* the same with an alpha of 0.2 to 0.4 */
    STAND_IN_HOLES,      /* the same with an alpha that falls from 1 in the middle to 0 at the border */
    STAND_IN_NORMAL,     /* bumps */
    STAND_IN_SURFACE,    /* occlusion, roughness, metal in R, G, B */
    STAND_IN_GLOW,       /* lit spots on black */
    STAND_IN_DIRECTIONS, /* of anisotropy: direction in R, G, strength in B */
};

/** RGBA8 pixels, to free with free(). */
fnl_image stand_in_picture(enum stand_in_texture texture, uint32_t side, uint32_t seed);
/** RGBA32F pixels of a sky or a hall with lamps, to free with free(). Aborts where nothing replaces the sample. */
fnl_image stand_in_panorama(const char *name);

/** The sample, or the panorama that replaces it; free it with free(). */
static inline fnl_image stand_in_or_sample(const char *name) {
    const char *path = stand_in_sample(name);
    fnl_image image;
    if (!path || fnl_image_load(NULL, path, &image) != FNL_OK) image = stand_in_panorama(name); /* the default host has malloc() too */
    return image;
}

/** An RGBA8 picture as PNG (deflate blocks that are stored; RGB if all is opaque), to free with free(). */
unsigned char *stand_in_png(const fnl_image *image, size_t *size);
/** An RGBA32F picture as Radiance HDR with the newer runs, to free with free(). */
unsigned char *stand_in_hdr(const fnl_image *image, size_t *size);

#endif
