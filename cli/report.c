/* SPDX-License-Identifier: MIT */
/* The numbers of a run as a table for people; report_json.c has them for programs. */
#include "legend.h"
#include "counters.h"
#include "print.h"
#include "render.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int compare_doubles(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

struct report_summary report_summarise(const double *times, uint32_t count) {
    struct report_summary s = {0};
    double *sorted = malloc(count * sizeof *sorted);
    if (!sorted || count == 0) {
        free(sorted);
        return s;
    }
    memcpy(sorted, times, count * sizeof *sorted);
    qsort(sorted, count, sizeof *sorted, compare_doubles);
    s.median = count % 2 ? sorted[count / 2] : 0.5 * (sorted[count / 2 - 1] + sorted[count / 2]);
    s.low = sorted[0];
    s.p95 = sorted[(uint32_t)(0.95 * (count - 1) + 0.5)];
    free(sorted);
    return s;
}

/* ---- times of frames ---- */

static void finish_series(struct report_series *series) {
    free(series->rows);
    free(series->times);
    free(series->begins);
    *series = (struct report_series){0};
}

static bool make_series(struct report_series *series, uint32_t count, uint32_t frame_count) {
    const size_t all = (size_t)count * frame_count + 1;
    *series = (struct report_series){count, calloc(count + 1, sizeof *series->rows), calloc(all, sizeof(double)), calloc(all, sizeof(double))};
    return series->rows && series->times && series->begins;
}

/* The row of a name in a series, a new one where no frame has had it so far; false: memory ran out. `place`: where frames mostly have it. */
static bool find_row(struct report_series *s, uint32_t frame_count, const fnl_pass_time *pass, uint32_t place, uint32_t *out) {
    *out = place;
    if (place < s->count && strcmp(s->rows[place].name, pass->name) == 0) return true;
    for (*out = 0; *out < s->count; (*out)++)
        if (strcmp(s->rows[*out].name, pass->name) == 0) return true;
    const size_t before = (size_t)s->count * frame_count, all = before + frame_count + 1;
    struct report_row *rows = realloc(s->rows, (s->count + 1) * sizeof *rows);
    if (rows) s->rows = rows;
    double *times = realloc(s->times, all * sizeof *times);
    if (times) s->times = times;
    double *begins = realloc(s->begins, all * sizeof *begins);
    if (begins) s->begins = begins;
    if (!rows || !times || !begins) return false;
    memset(times + before, 0, (frame_count + 1) * sizeof *times);
    memset(begins + before, 0, (frame_count + 1) * sizeof *begins);
    rows[s->count++] = (struct report_row){pass->name, pass->queue, pass->role};
    return true;
}

static bool begin_notes(struct render_report *r, const fnl_frame_stats *stats) {
    r->cpu_times = calloc(r->frame_count, sizeof(double));
    r->gpu_times = calloc(r->frame_count, sizeof(double));
    if (!r->cpu_times || !r->gpu_times || !make_series(&r->passes, stats->pass_count, r->frame_count) ||
        !make_series(&r->sections, stats->cpu_section_count, r->frame_count))
        return false;
    for (uint32_t i = 0; i < stats->pass_count; i++) {
        const fnl_pass_time *pass = &stats->passes[i];
        r->passes.rows[i] = (struct report_row){pass->name, pass->queue, pass->role};
    }
    for (uint32_t i = 0; i < stats->cpu_section_count; i++) r->sections.rows[i].name = stats->cpu_sections[i].name;
    return true;
}

bool report_note(struct render_report *r, uint32_t index, const fnl_frame_stats *stats) {
    if (index == 0 && !begin_notes(r, stats)) return false;
    for (uint32_t i = 0, row; i < stats->pass_count; i++) { /* a still frame has fewer than one before it */
        if (!find_row(&r->passes, r->frame_count, &stats->passes[i], i, &row)) return false;
        r->passes.times[(size_t)row * r->frame_count + index] = stats->passes[i].milliseconds;
        r->passes.begins[(size_t)row * r->frame_count + index] = stats->passes[i].begin_milliseconds;
    }
    for (uint32_t i = 0; i < r->sections.count && i < stats->cpu_section_count; i++) {
        r->sections.times[(size_t)i * r->frame_count + index] = stats->cpu_sections[i].milliseconds;
        r->sections.begins[(size_t)i * r->frame_count + index] = stats->cpu_sections[i].begin_milliseconds;
    }
    r->cpu_times[index] = stats->cpu_milliseconds;
    r->gpu_times[index] = stats->gpu_milliseconds;
    return true;
}

void report_finish(struct render_report *r) {
    finish_series(&r->passes);
    finish_series(&r->sections);
    free(r->cpu_times);
    free(r->gpu_times);
    r->cpu_times = r->gpu_times = NULL;
}

static struct report_summary summary_of(const struct render_report *r, const struct report_series *series, uint32_t index) {
    return report_summarise(series->times + (size_t)index * r->frame_count, r->frame_count);
}

/* ---- the table ---- */

static void print_legend(const struct render_report *r) {
    char legend[1024];
    legend_print(r->frame.debug, legend, sizeof legend);
    if (legend[0]) printf("  %s: %s\n", fnl_value_name(FNL_ENUM_DEBUG_VIEW, r->frame.debug), legend);
}

/* "tiled lists", "brute force". */
static const char *lists_text(fnl_light_lists lists, char *text, size_t capacity) {
    snprintf(text, capacity, lists == FNL_LISTS_ALL ? "brute force" : "%s lists", fnl_value_name(FNL_ENUM_LISTS, lists));
    return text;
}

static void print_method(const struct render_report *r) {
    const fnl_frame_stats *s = &r->stats;
    char lists[64];
    printf("%ux%u, %s, %s, %u light%s", r->frame.width, r->frame.height, fnl_value_name(FNL_ENUM_SHADING, s->shading),
           lists_text(s->lists, lists, sizeof lists), s->lights_total, s->lights_total == 1 ? "" : "s");
    if (s->view_count) printf(", %u views", s->view_count);
}

void report_print_picture(const struct render_report *r, double seconds) {
    print_method(r);
    printf(": %.2f s for the frame on %s, %.2f s in total\n", r->stats.gpu_milliseconds * 1e-3, r->device.name, seconds);
    print_legend(r);
}

void report_print_sequence(const struct render_report *r, uint32_t count, double seconds) {
    print_method(r);
    printf(": %u picture%s on %s in %.1f s\n", count, count == 1 ? "" : "s", r->device.name, seconds);
    print_legend(r);
}

static void print_candidates(const fnl_frame_stats *s) {
    uint32_t measured = 0;
    for (uint32_t i = 0; i < s->candidate_count; i++) measured += s->candidates[i].frames > 0;
    for (uint32_t i = 0; i < s->candidate_count && measured > 0; i++) {
        const fnl_candidate *c = &s->candidates[i];
        char time[32] = "not measured", frames[48] = "";
        if (c->milliseconds > 0) snprintf(time, sizeof time, "%.3f ms", c->milliseconds);
        if (c->milliseconds > 0 && c->frames) snprintf(frames, sizeof frames, ", %u frame%s", c->frames, c->frames == 1 ? "" : "s");
        printf("  %c %-16s %-16s %s%s\n", c->chosen ? '*' : ' ', fnl_value_name(FNL_ENUM_SHADING, c->shading), fnl_value_name(FNL_ENUM_LISTS, c->lists), time,
               frames);
    }
}

void report_print(const struct render_report *r) {
    const fnl_frame_stats *s = &r->stats;
    printf("%s, %s\n", r->device.name, r->device.driver);
    char lists[64];
    printf("%ux%u, %s, %s, MSAA %u: %" PRIu64 " triangles, %" PRIu64 " instances, %u lights\n", r->frame.width,
           r->frame.height, fnl_value_name(FNL_ENUM_SHADING, s->shading), lists_text(s->lists, lists, sizeof lists), s->msaa,
           r->scene.triangle_count, r->scene.instance_count, s->lights_total);
    if (s->view_count) printf("%u views; the numbers of lights and triangles below are those of the first, --stats has all\n", s->view_count);
    if (s->choice[0]) printf("auto: %s\n", s->choice);
    print_candidates(s);
    struct report_summary gpu = report_summarise(r->gpu_times, r->frame_count), cpu = report_summarise(r->cpu_times, r->frame_count);
    printf("\n  %-28s %10s %10s %10s\n", "pass, ms", "median", "min", "p95");
    double small = 0;
    uint32_t small_count = 0;
    for (uint32_t i = 0; i < r->passes.count; i++) {
        struct report_summary p = summary_of(r, &r->passes, i);
        if (p.median < 0.005 * gpu.median) { /* the table shows what matters; the JSON shows all */
            small += p.median;
            small_count++;
            continue;
        }
        printf("  %-28s %10.3f %10.3f %10.3f\n", r->passes.rows[i].name, p.median, p.low, p.p95);
    }
    char others[32];
    snprintf(others, sizeof others, "%u smaller passes", small_count);
    if (small_count) printf("  %-28s %10.3f\n", others, small);
    printf("  %-28s %10.3f %10.3f %10.3f\n", "all passes", gpu.median, gpu.low, gpu.p95);
    for (uint32_t i = 0; i < r->sections.count; i++) {
        struct report_summary p = summary_of(r, &r->sections, i);
        char name[40];
        snprintf(name, sizeof name, "CPU: %.30s", r->sections.rows[i].name);
        if (p.median >= 0.05 * cpu.median) printf("  %-28s %10.3f %10.3f %10.3f\n", name, p.median, p.low, p.p95);
    }
    printf("  %-28s %10.3f %10.3f %10.3f\n", "CPU, record and submit", cpu.median, cpu.low, cpu.p95);
    printf("\n  lights in view %u of %u; list entries %" PRIu64 " in %u cells, %.1f KiB; overflow cells %u; dropped %u\n",
           s->lights_in_view, s->lights_total, s->list_entries, s->cells, (double)s->list_bytes / 1024, s->overflow_cells,
           s->lights_dropped);
    if (s->evaluations_counted)
        printf("  light evaluations %" PRIu64 ": %.2f per pixel, at most %u; %.2f times those that reach the surface\n",
               s->evaluations, s->mean_per_pixel, s->max_per_pixel,
               (double)s->evaluations / (double)(s->evaluations_useful ? s->evaluations_useful : 1));
    if (r->frame.culling != FNL_CULLING_INSTANCES && s->triangles_total) {
        double whole = 100 / (double)s->triangles_total;
        printf("  triangles drawn %" PRIu64 " of %" PRIu64
               " (%.1f%%); out of view %.1f%%, facing away %.1f%%, too small %.1f%%; clusters %" PRIu64 " of %" PRIu64
               "; whole items %u; by %s shaders\n",
               s->triangles_drawn, s->triangles_total, (double)s->triangles_drawn * whole,
               (double)s->triangles_outside * whole, (double)s->triangles_back * whole, (double)s->triangles_small * whole,
               s->clusters_drawn, s->clusters_total, s->items_whole, fnl_value_name(FNL_ENUM_GEOMETRY, s->geometry));
    }
    if (s->occlusion)
        printf("  items hidden by others %" PRIu64 "; triangles, by clusters and items: %" PRIu64 "\n", s->items_occluded,
               s->triangles_occluded);
    printf("  images: %.2f MiB read, %.2f MiB written by passes; %.2f MiB of attachments in tile memory%s\n",
           (double)s->image_bytes_read / (1 << 20), (double)s->image_bytes_written / (1 << 20),
           (double)s->tile_bytes / (1 << 20), s->lazy_bytes ? ", lazily allocated" : "");
    printf("  draws %u; items %" PRIu64 " of %" PRIu64 "; triangles %" PRIu64
           "; EV100 %.2f; device memory %.1f MiB (peak %.1f)\n",
           s->draws, s->items_visible, s->items, s->triangles_visible, (double)s->ev, (double)s->device_bytes / (1 << 20),
           (double)s->device_peak_bytes / (1 << 20));
    printf("  device memory, MiB:");
    for (uint32_t i = 0; i < s->memory_kind_count; i++)
        printf("%s %s %.1f", i ? "," : "", s->memory_kinds[i].name, (double)s->memory_kinds[i].bytes / (1 << 20));
    putchar('\n');
    print_legend(r);
    counters_print_table(s);
}
