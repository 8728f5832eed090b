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

void view_panel_legend(const struct view *v) {
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

bool view_has_legend(const struct view *v) {
    return v->frame.debug != FNL_DEBUG_NONE || (v->compare.mode != VIEW_COMPARE_OFF && v->compare.frame.debug != FNL_DEBUG_NONE);
}
