/* SPDX-License-Identifier: MIT */
/* What the frame costs. */
#include "view/view.h"

#include "print.h"
#include "view/ui.h"

#include <math.h>

static void show_passes(const struct view *v, double most) {
    char text[96];
    if (!ui_table("passes", 2, 0.62f)) return;
    for (uint32_t i = 0; i < v->pass_count; i++) {
        if (v->passes[i].milliseconds < 0.005 * most) continue;
        ui_cell();
        ui_text("%s", v->passes[i].name);
        ui_tooltip(v->passes[i].name);
        ui_cell();
        snprintf(text, sizeof text, "%.2f ms", v->passes[i].milliseconds);
        ui_bar((float)(v->passes[i].milliseconds / most), text);
    }
    ui_table_end();
}

static void show_memory(const fnl_frame_stats *s) {
    char text[48];
    if (!ui_table("memory", 2, 0.4f)) return;
    for (uint32_t i = 0; i < s->memory_kind_count; i++) {
        if (s->memory_kinds[i].bytes == 0) continue;
        ui_cell();
        ui_text("%s", s->memory_kinds[i].name);
        ui_cell();
        snprintf(text, sizeof text, "%.2f MB", (double)s->memory_kinds[i].bytes / 1e6);
        ui_bar((float)s->memory_kinds[i].bytes / (float)s->device_bytes, text);
    }
    ui_table_end();
}

/* What auto has measured. */
static void show_candidates(const fnl_frame_stats *s) {
    if (s->candidate_count == 0 || !ui_header("candidates", false) || !ui_table("candidates", 3, 0.5f)) return;
    for (uint32_t i = 0; i < s->candidate_count; i++) {
        const fnl_candidate *c = &s->candidates[i];
        ui_cell();
        ui_text("%s%s, %s", c->chosen ? "* " : "", fnl_value_name(FNL_ENUM_SHADING, c->shading), fnl_value_name(FNL_ENUM_LISTS, c->lists));
        if (c->chosen) ui_tooltip("What auto has chosen");
        ui_cell();
        if (c->milliseconds > 0)
            ui_text("%.3f ms", c->milliseconds);
        else
            ui_text("not yet");
        ui_cell();
        if (c->frames > 0)
            ui_text("%u %s", c->frames, view_plural(c->frames, "frame", "frames"));
        else
            ui_text("%s", c->milliseconds > 0 ? "remembered" : "");
    }
    ui_table_end();
}

/* ---- what lists and shadow maps hold, and what they are worth ---- */

/* Lights that a pixel visits, and those of them that reach its surface: no list could have fewer. */
struct visits {
    double mean, useful, ratio; /* of the two; 1 where nothing is lit */
};
static struct visits visits_of(const fnl_frame_stats *s) {
    const double useful = s->evaluations ? s->mean_per_pixel * (double)s->evaluations_useful / (double)s->evaluations : 0;
    return (struct visits){s->mean_per_pixel, useful, s->evaluations_useful ? (double)s->evaluations / (double)s->evaluations_useful : 1};
}

static uint64_t count_of(const fnl_frame_stats *s, const char *key) {
    const fnl_counter *counter = fnl_counter_find(s, key);
    return counter ? counter->value : 0;
}

/* Of 128 x 128 texels of 4 bytes, as many as fit into a square atlas. */
static uint64_t atlas_cells(const struct view *v) {
    const uint64_t side = (uint64_t)sqrt(16.0 * v->frame.shadow.memory);
    return side * side;
}

static void show_visits(const fnl_frame_stats *s) {
    const struct visits visits = visits_of(s);
    if (!s->evaluations_counted) {
        ui_note("The option count-lights counts the lights that pixels visit.");
        return;
    }
    ui_text("a pixel visits %.2f lights, %u at most", visits.mean, s->max_per_pixel);
    ui_text("%.2f reach it: %.2f times the least", visits.useful, visits.ratio);
    ui_tooltip("Lights visited over lights that reach the surface. 1: the list holds nothing else");
    if (s->unserved_points) ui_text("%llu points without a list of their own", (unsigned long long)s->unserved_points);
}

static void show_residency(const struct view *v) {
    const fnl_frame_stats *s = &v->stats;
    char text[96];
    if (s->list_bytes) {
        snprintf(text, sizeof text, "lists %.1f of %.1f KB", (double)s->list_used_bytes / 1e3, (double)s->list_bytes / 1e3);
        ui_bar((float)fmin((double)s->list_used_bytes / (double)s->list_bytes, 1), text);
        ui_tooltip("What this frame's lights fill of the memory of the lists");
    }
    if (s->overflow_cells) ui_warning("%u of %u cells did not fit", s->overflow_cells, s->cells);
    if (!fnl_counter_find(s, "shadows.pages")) return;
    snprintf(text, sizeof text, "shadow atlas %llu of %llu squares", (unsigned long long)count_of(s, "shadows.cells"), (unsigned long long)atlas_cells(v));
    ui_bar((float)fmin((double)count_of(s, "shadows.cells") / fmax((double)atlas_cells(v), 1), 1), text);
    ui_tooltip("Squares of 128 x 128 texels that pages of shadow maps fill");
    ui_text("%llu shadow %s, %llu wanted", (unsigned long long)count_of(s, "shadows.pages"), view_plural(count_of(s, "shadows.pages"), "page", "pages"), (unsigned long long)count_of(s, "shadows.wanted"));
    ui_text("  %llu drawn in this frame, %llu evicted", (unsigned long long)count_of(s, "shadows.drawn"), (unsigned long long)count_of(s, "shadows.evicted"));
    const uint64_t coarsened = count_of(s, "shadows.coarsened"), traced = count_of(s, "shadows.traced");
    if (coarsened || traced) ui_text("  %llu lights have coarser ones, %llu none", (unsigned long long)coarsened, (unsigned long long)traced);
}

void view_report_frame(const struct view *v, FILE *file) {
    const fnl_frame_stats *s = &v->stats;
    const struct visits visits = visits_of(s);
    if (s->evaluations_counted)
        fprintf(file, "visits-per-pixel\t%.9g\nuseful-per-pixel\t%.9g\nvisits-ratio\t%.9g\nunserved-points\t%llu\n", visits.mean, visits.useful, visits.ratio,
                (unsigned long long)s->unserved_points);
    fprintf(file, "list-bytes\t%llu\t%llu\noverflow-cells\t%u\t%u\n", (unsigned long long)s->list_used_bytes, (unsigned long long)s->list_bytes,
            s->overflow_cells, s->cells);
    if (fnl_counter_find(s, "shadows.pages"))
        fprintf(file, "shadow-atlas\t%llu\t%llu\nshadow-pages\t%llu\t%llu\n", (unsigned long long)count_of(s, "shadows.cells"),
                (unsigned long long)atlas_cells(v), (unsigned long long)count_of(s, "shadows.pages"), (unsigned long long)count_of(s, "shadows.wanted"));
}

/* ---- the panel ---- */

void view_panel_statistics(struct view *v) {
    const fnl_frame_stats *s = &v->stats;
    double most = 1e-3;
    float highest = 1;
    for (uint32_t i = 0; i < v->pass_count; i++) most = fmax(most, v->passes[i].milliseconds);
    for (uint32_t i = 0; i < VIEW_HISTORY; i++) highest = fmaxf(highest, v->history[i]);
    ui_text("%.1f ms in passes, %.1f from end to end", s->gpu_milliseconds, v->frame_seconds * 1e3);
    ui_tooltip("The passes on the GPU; the whole frame of the window, with panels and waiting");
    ui_text("%.2f ms of the CPU to record it", s->cpu_milliseconds);
    ui_plot("##history", v->history, VIEW_HISTORY, v->history_at, highest, 50);
    ui_tooltip("Milliseconds of the last frames");
    ui_text("%s, lists %s%s", fnl_value_name(FNL_ENUM_SHADING, s->shading), fnl_value_name(FNL_ENUM_LISTS, s->lists), s->choosing ? " (choosing)" : "");
    if (s->choice && s->choice[0]) ui_note("%s", s->choice);
    show_candidates(s);
    if (ui_button("timeline")) view_show_wide(v, VIEW_TIMELINE);
    ui_tooltip("When each pass ran, in this and recent frames (F2)");
    ui_same_line();
    if (ui_button("graph")) view_show_wide(v, VIEW_GRAPH);
    ui_tooltip("The frame graph: passes, what they read and write, barriers (F3)");
    ui_text("%.1f MB on the device, %u %s, %llu of %llu %s", (double)s->device_bytes / 1e6, s->draws, view_plural(s->draws, "draw", "draws"), (unsigned long long)s->items_visible,
            (unsigned long long)s->items, view_plural(s->items, "object", "objects"));
    ui_text("%u of %u %s in view, %llu list %s", s->lights_in_view, s->lights_total, view_plural(s->lights_total, "light", "lights"), (unsigned long long)s->list_entries,
            view_plural(s->list_entries, "entry", "entries"));
    show_visits(s);
    show_residency(v);
    if (ui_header("passes", true)) show_passes(v, most);
    if (ui_header("memory", false)) show_memory(s);
    if (!ui_header("counters", false) || !ui_table("counters", 2, 0.62f)) return;
    for (uint32_t i = 0; i < s->counter_count; i++) {
        ui_cell();
        ui_text("%s", s->counters[i].key);
        ui_tooltip(s->counters[i].help);
        ui_cell();
        ui_text("%llu %s", (unsigned long long)s->counters[i].value, s->counters[i].unit);
    }
    ui_table_end();
}
