/* SPDX-License-Identifier: MIT */
/** What stands between the eyes of a headset and its display: `--lens`, `--lens-view`, `--hidden-mesh`. */
#ifndef FNL_CLI_HEADSET_DISPLAY_H
#define FNL_CLI_HEADSET_DISPLAY_H

#include "stereo.h"

struct display_options {
    bool given;   /* --lens: the picture is that of the display */
    fnl_warp warp;
    fnl_display_view view;
    bool hides;   /* --hidden-mesh */
};

#define DISPLAY_HELP                                                                                                        \
    "  --lens mesh|pixel|off      makes the picture of the headset's display: its lenses undone by a mesh or for each pixel,\n" \
    "                             or not at all; with --hmd, and --stereo side-by-side, left or right\n"                  \
    "  --lens-view mask|mesh|fringes what is never seen; the quads of the mesh; how far colours are apart\n"               \
    "  --hidden-mesh on|off       leaves out what the headset's lenses hide (off)\n"

/** "mesh", "pixel", "off"; NULL beyond. Likewise "none", "mask", "mesh", "fringes". */
const char *display_warp_name(int warp);
const char *display_view_name(int view);
/** What of the options does not go together; NULL: all does. `makes_exr`: some output is no PNG. */
const char *display_problem(const struct display_options *options, const struct stereo_options *stereo, bool makes_exr);

/** A display while the command runs. */
struct display {
    struct display_options options;
    const struct stereo *stereo;
    fnl_hidden_area areas[HEADSET_EYES]; /* of the views that are rendered */
    fnl_compositor *compositor;
};
/** False after a message. `width` and `height`: of an eye's picture, which is also its part of the display. */
bool display_open(struct display *display, const struct display_options *options, const struct stereo *stereo, fnl_device *device, uint32_t width, uint32_t height);
void display_close(struct display *display);
/** What the views do not show; NULL without --hidden-mesh. */
const fnl_hidden_area *display_hidden(const struct display *display);
/** Makes the picture of the display, of that of the eyes one below the other, in its place. */
bool display_show(struct display *display, const fnl_host *host, fnl_image *picture);

#endif
