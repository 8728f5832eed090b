/* SPDX-License-Identifier: MIT */
/* What the colours of the debug view mean. */
#include "view/view.h"

#include "view/ui.h"

#include "fanal/legend.h"

static void show(fnl_debug_view view) {
    fnl_debug_legend legend;
    if (!fnl_debug_legend_query(view, &legend)) return;
    if (legend.kind == FNL_LEGEND_RAMP) ui_ramp(legend.colors, legend.color_count, legend.low, legend.high);
    for (uint32_t i = 0; legend.kind == FNL_LEGEND_COLORS && i < legend.color_count; i++) {
        ui_swatch(&legend.colors[i]);
        ui_same_line();
        ui_text("%s", legend.names[i]);
    }
    ui_note("%s", legend.text);
}

static void show_all(const struct view *v) {
    const fnl_debug_view a = v->frame.debug, b = v->compare.mode != VIEW_COMPARE_OFF ? v->compare.frame.debug : a;
    if (a == b) {
        show(a);
        return;
    }
    if (a != FNL_DEBUG_NONE) ui_text("A: %s", fnl_value_name(FNL_ENUM_DEBUG_VIEW, a));
    if (a != FNL_DEBUG_NONE) show(a);
    if (b != FNL_DEBUG_NONE) ui_text("B: %s", fnl_value_name(FNL_ENUM_DEBUG_VIEW, b));
    if (b != FNL_DEBUG_NONE) show(b);
}

void view_show_legend(struct view *v) {
    const bool shown = v->frame.debug != FNL_DEBUG_NONE || (v->compare.mode != VIEW_COMPARE_OFF && v->compare.frame.debug != FNL_DEBUG_NONE);
    const struct ui_rectangle area = view_area(v);
    const float wide = fminf(270, area.width / v->scale - 16);
    if (!shown || wide < 60) return;
    ui_corner("##legend", (area.x + area.width) / v->scale - 8, (area.y + area.height) / v->scale - 8, wide);
    show_all(v);
    ui_window_end();
}
