/* SPDX-License-Identifier: MIT */
#include "legend.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static void add(char *text, size_t capacity, const char *lead, const char *name, const fnl_vec3 *c) {
    const size_t length = strlen(text);
    if (length < capacity)
        snprintf(text + length, capacity - length, "%s%s (#%02x%02x%02x)", lead, name, (unsigned)lroundf(c->x * 255), (unsigned)lroundf(c->y * 255),
                 (unsigned)lroundf(c->z * 255));
}

void legend_print(fnl_debug_view view, char *text, size_t capacity) {
    fnl_debug_legend legend;
    text[0] = 0;
    if (view == FNL_DEBUG_NONE || !fnl_debug_legend_query(view, &legend)) return;
    if (legend.kind == FNL_LEGEND_RAMP) {
        add(text, capacity, "", legend.low, &legend.colors[0]);
        add(text, capacity, " to ", legend.high, &legend.colors[legend.color_count - 1]);
    }
    for (uint32_t i = 0; legend.kind == FNL_LEGEND_COLORS && i < legend.color_count; i++) add(text, capacity, i ? ", " : "", legend.names[i], &legend.colors[i]);
    const size_t length = strlen(text);
    if (length < capacity) snprintf(text + length, capacity - length, "%s%s", length ? ": " : "", legend.text);
}
