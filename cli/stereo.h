/* SPDX-License-Identifier: MIT */
/** Stereo pictures: `--stereo KIND`, `--ipd METRES`, `--hmd FILE`. */
#ifndef FNL_CLI_STEREO_H
#define FNL_CLI_STEREO_H

#include "headset.h"

enum stereo_kind { STEREO_NONE, STEREO_SIDE_BY_SIDE, STEREO_TOP_BOTTOM, STEREO_ANAGLYPH, STEREO_LAYERS, STEREO_LEFT, STEREO_RIGHT };

struct stereo_options {
    enum stereo_kind kind;
    const char *hmd;
    float ipd; /* metres; NAN: the headset's, or STEREO_IPD */
};

#define STEREO_IPD 0.0635f /* metres: the mean of 4000 US soldiers (Real-Time Rendering, 4th ed., chapter 21) */

#define STEREO_HELP                                                                                                         \
    "  --stereo KIND              two eyes: side-by-side top-bottom anaglyph (red: left, cyan: right) layers (each output has\n" \
    "                             one %d for the number of the eye) left right\n"                                          \
    "  --ipd METRES               how far they are apart (that of the headset, or 0.0635)\n"                               \
    "  --hmd FILE                 a headset of a JSON file, or builtin:simple, builtin:asymmetric, builtin:canted: its fields of\n" \
    "                             view, its size, how the head moves (without: two eyes with the camera's field of view)\n"

/** "side-by-side" ... "right": of kind index + 1; NULL beyond. */
const char *stereo_kind_name(int index);
/** What of the options does not go together; NULL: all does. */
const char *stereo_problem(const struct stereo_options *options);

struct stereo {
    struct stereo_options options;
    struct headset headset; /* without a file: no tangents, they follow the camera */
};

/** Reads the file, and prints warnings about what is uncomfortable unless `quiet`. False after a message. */
bool stereo_open(const struct stereo_options *options, bool quiet, struct stereo *out);
void stereo_close(struct stereo *stereo);
/** The size of an eye's picture, where nobody gave one: that of the larger display; unchanged where the file has none. */
void stereo_size(const struct stereo *stereo, uint32_t *width, uint32_t *height);
/** Eyes that are rendered: 2, or 1 of STEREO_LEFT and STEREO_RIGHT. */
uint32_t stereo_view_count(const struct stereo *stereo);
/** The cameras of a head that stands at `camera`, or moves there as the file says. False after a message. */
bool stereo_cameras(const struct stereo *stereo, const fnl_camera *camera, double time, uint32_t width, uint32_t height, fnl_camera out[HEADSET_EYES]);
/** The point in the world that the eyes look at then: `out`, or NULL where the file does not say. */
const fnl_vec3 *stereo_gaze(const struct stereo *stereo, const fnl_camera *camera, double time, fnl_vec3 *out);
/** Whether the pictures of both eyes become one. */
bool stereo_joins(enum stereo_kind kind);
/**
 * Makes one picture of two that stand one below the other, in their place. `color`: it is light, of which an anaglyph takes red from the left eye and
 * the rest from the right; of other pictures an anaglyph takes the left eye's. False after a message.
 */
bool stereo_join(enum stereo_kind kind, bool color, fnl_image *picture);

#endif
