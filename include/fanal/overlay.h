/* SPDX-License-Identifier: MIT */
/** Triangles in two dimensions over the finished picture: user interfaces, text, pointers. */
#ifndef FANAL_OVERLAY_H
#define FANAL_OVERLAY_H

#include "fanal/image.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct fnl_overlay_vertex {
    fnl_vec2 position; /**< pixels of what is drawn to, right and down from its upper left corner */
    fnl_vec2 texel;    /**< place in the image, 0 .. 1, right and down */
    uint8_t color[4];  /**< sRGB and alpha, not premultiplied; multiplied by the image's */
} fnl_overlay_vertex;

/** Triangles, three indices each, of either winding, in a rectangle of pixels. */
typedef struct fnl_overlay_draw {
    uint32_t first_index, index_count; /**< all inside the indices; a multiple of 3 */
    uint32_t first_vertex;             /**< is added to each index */
    int32_t x, y;                      /**< upper left corner of the rectangle: nothing is drawn outside of it */
    uint32_t width, height;
    uint32_t image; /**< which of fnl_overlay.images it shows */
} fnl_overlay_draw;

enum { FNL_OVERLAY_IMAGES_MAX = 4 };

typedef struct fnl_overlay_image {
    /** RGBA8 in sRGB, alpha not premultiplied, sampled bilinearly; such as the letters of a font. NULL: white. */
    const fnl_image *image;
    /** The image is sent to the device when this number is another than in the renderer's last frame with an image in this place. */
    uint64_t version;
} fnl_overlay_image;

/**
 * Draws in order, each over the ones before, blended by alpha in the encoding of the picture, as user interfaces expect. All arrays are the caller's and
 * read only during the call that renders.
 */
typedef struct fnl_overlay {
    const fnl_overlay_vertex *vertices;
    uint32_t vertex_count;
    const uint32_t *indices;
    uint32_t index_count;
    const fnl_overlay_draw *draws;
    uint32_t draw_count;
    fnl_overlay_image images[FNL_OVERLAY_IMAGES_MAX];
} fnl_overlay;

#ifdef __cplusplus
}
#endif
#endif
