/* SPDX-License-Identifier: MIT */
/** Legends of debug views, from their rows. */
#include "base/check.h"
#include "fanal/legend.h"
#include "passes/debug/colors_shared.h"
#include "render/debug_views.h"
#include "render/shading.h"

/* heat() of passes/debug/legend.glsl. */
static fnl_vec3 heat(float t) {
#define STOP(r, g, b) {r, g, b}
    static const float stops[DEBUG_RAMP_STOPS][3] = {DEBUG_RAMP(STOP)};
    const float x = fminf(fmaxf(t, 0), 1) * (DEBUG_RAMP_STOPS - 1);
    const int i = MIN((int)x, DEBUG_RAMP_STOPS - 2);
    float color[3];
    for (int c = 0; c < 3; c++) color[c] = (stops[i][c] + (stops[i + 1][c] - stops[i][c]) * (x - (float)i)) / 255;
    return (fnl_vec3){color[0], color[1], color[2]};
}

static void fill(const struct debug_legend *row, fnl_debug_legend *out) {
    *out = (fnl_debug_legend){.kind = row->kind, .text = row->text, .low = row->low, .high = row->high, .color_count = row->color_count};
    for (uint32_t i = 0; i < row->color_count; i++) {
        const float *color = row->colors[i].color;
        out->colors[i] = (fnl_vec3){color[0], color[1], color[2]};
        out->names[i] = row->colors[i].name;
    }
    if (row->kind != FNL_LEGEND_RAMP) return;
    out->color_count = FNL_LEGEND_COLORS_MAX;
    for (uint32_t i = 0; i < FNL_LEGEND_COLORS_MAX; i++) {
        const float t = row->from + (row->to - row->from) * (float)i / (FNL_LEGEND_COLORS_MAX - 1);
        out->colors[i] = row->is_grey ? (fnl_vec3){t, t, t} : heat(t);
    }
}

bool fnl_debug_legend_query(fnl_debug_view view, fnl_debug_legend *out) {
    if (check_handle(__func__, "out", out) != FNL_OK || (uint32_t)view >= FNL_DEBUG_COUNT) return false;
    for (uint32_t i = 0; i < FNL_SHADING_AUTO; i++) {
        const struct debug_view *row = debug_views_find((fnl_shading)i, view);
        if (!row) continue;
        fill(&row->legend, out);
        return true;
    }
    return false;
}
