/* SPDX-License-Identifier: MIT */
/** What the colours of debug views mean. */
#ifndef FANAL_LEGEND_H
#define FANAL_LEGEND_H

#include "fanal/frame.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum fnl_legend_kind {
    FNL_LEGEND_TEXT = 0, /**< a sentence alone */
    FNL_LEGEND_COLORS,   /**< each colour has a meaning */
    FNL_LEGEND_RAMP,     /**< colours for numbers from a low to a high one */
    FNL_LEGEND_KIND_COUNT
} fnl_legend_kind;

enum { FNL_LEGEND_COLORS_MAX = 33 };

/** The legend of a debug view. Strings live as long as the program. */
typedef struct fnl_debug_legend {
    fnl_legend_kind kind;
    const char *text;      /**< one line, for all kinds */
    const char *low, *high; /**< FNL_LEGEND_RAMP: the numbers of the first and the last colour; else NULL */
    uint32_t color_count;
    /** As the picture has them (sRGB-encoded), each 0 .. 1; of a ramp evenly spaced. Where a view also shows the surface's brightness, colours are mixed with it. */
    fnl_vec3 colors[FNL_LEGEND_COLORS_MAX];
    const char *names[FNL_LEGEND_COLORS_MAX]; /**< FNL_LEGEND_COLORS: what each means */
} fnl_debug_legend;

/** False for FNL_DEBUG_NONE and where there is no such view. */
FNL_API bool fnl_debug_legend_query(fnl_debug_view view, fnl_debug_legend *out);

#ifdef __cplusplus
}
#endif
#endif
