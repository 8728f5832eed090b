/* SPDX-License-Identifier: MIT */
/* What ran when: the passes of a frame and the work of the CPU on an axis of time, the last frames, and the times of one pass. */
#include "view/view.h"

#include "print.h"
#include "view/ui.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { AXIS = 16, LANE = 20, STRIP = 56, GUTTER = 84 /* with the names of lanes */ };
static const uint32_t SPIKE_COLOR = 0xff4030ff, TEXT_COLOR = 0x000000ff, CHOSEN_COLOR = 0xffffffff;

/* What a pass is for, in the order of stacks. */
enum { ROLES = FNL_PASS_ROLE_COUNT };
static const struct {
    fnl_pass_role role;
    uint32_t color;
} roles[ROLES] = {{FNL_PASS_SHADOWS, 0x9a7fd1ff}, {FNL_PASS_GEOMETRY, 0x5fa8d3ff}, {FNL_PASS_LISTS, 0xe0b040ff}, {FNL_PASS_SHADING, 0x6fbf73ff}, {FNL_PASS_REST, 0xd98a6aff}, {FNL_PASS_READ, 0x909090ff}};

static const char *name_of_role(uint32_t r) { return fnl_value_name(FNL_ENUM_PASS_ROLE, (uint32_t)roles[r].role); }

uint32_t view_role_color(uint32_t role) {
    for (uint32_t i = 0; i < ROLES; i++)
        if ((uint32_t)roles[i].role == role) return roles[i].color;
    return roles[ROLES - 1].color;
}

void view_show_roles(void) {
    for (uint32_t r = 0; r < ROLES; r++) {
        const char *name = roles[r].role == FNL_PASS_READ ? "read back" : name_of_role(r);
        if (r) ui_same_line_if_fits(name);
        ui_key_color(roles[r].color, name);
    }
}

/* ---- the frame that is shown ---- */

const struct trace_frame *view_timeline_frame(const struct view *v) {
    const struct view_timeline *t = &v->timeline;
    const bool frozen = t->is_frozen && t->frozen_generation == trace_generation(t->history);
    return frozen ? &t->frozen : trace_find(t->history, 0);
}

static void freeze(struct view *v, const struct trace_frame *frame) {
    v->timeline.frozen = *frame;
    v->timeline.frozen_generation = trace_generation(v->timeline.history);
    v->timeline.is_frozen = true;
}

/* Spans of the GPU count from its first pass. */
static double begin_of(const struct trace_frame *frame, const struct trace_span *span) {
    return span->begin + (span->lane <= TRACE_COMPUTE ? frame->passes_begin : 0);
}

static double length_of(const struct trace_frame *frame) {
    double end = (frame->end - frame->begin) * 1e3;
    for (uint32_t i = 0; i < frame->span_count; i++) end = fmax(end, begin_of(frame, &frame->spans[i]) + frame->spans[i].milliseconds);
    return fmax(end, 1e-3);
}

/* ---- times of one pass ---- */

struct summary {
    uint32_t count;
    float times[TRACE_FRAMES]; /* the oldest first */
    float low, median, high;
};

static int by_size(const void *a, const void *b) {
    const float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

static void finish_summary(struct summary *s) {
    float sorted[TRACE_FRAMES];
    if (s->count == 0) return;
    memcpy(sorted, s->times, s->count * sizeof *sorted);
    qsort(sorted, s->count, sizeof *sorted, by_size);
    s->low = sorted[0];
    s->high = sorted[s->count - 1];
    s->median = s->count % 2 ? sorted[s->count / 2] : 0.5f * (sorted[s->count / 2 - 1] + sorted[s->count / 2]);
}

/* Of the frames that had the span, a pass or a part of the CPU's work. */
static void summarise(const struct view *v, const char *name, struct summary *s) {
    const struct trace_history *h = v->timeline.history;
    s->count = 0;
    for (uint32_t age = trace_count(h); age-- > 0;) {
        const struct trace_frame *frame = trace_find(h, age);
        float time = 0;
        bool has = false;
        for (uint32_t i = 0; i < frame->span_count; i++) {
            if (strcmp(trace_name(h, frame->spans[i].name), name) != 0) continue;
            time += (float)frame->spans[i].milliseconds;
            has = true;
        }
        if (has) s->times[s->count++] = time;
    }
    finish_summary(s);
}

/* Of whole frames. */
static void summarise_frames(const struct view *v, struct summary *s) {
    s->count = 0;
    for (uint32_t age = trace_count(v->timeline.history); age-- > 0;) s->times[s->count++] = (float)trace_find(v->timeline.history, age)->gpu_milliseconds;
    finish_summary(s);
}

/* More than twice what frames usually take. */
enum { ENOUGH_FRAMES = 8 };
static bool is_spike(const struct summary *frames, double milliseconds) { return frames->count >= ENOUGH_FRAMES && milliseconds > 2 * (double)frames->median; }

static void show_pass(struct view *v) {
    struct summary s;
    char label[300];
    if (!v->timeline.pass[0]) {
        ui_note("Click a bar to see its last %d times.", TRACE_FRAMES);
        return;
    }
    summarise(v, v->timeline.pass, &s);
    if (s.count == 0) {
        ui_note("%s: not in the last frames", v->timeline.pass);
        return;
    }
    ui_text("%s: %.3f ms; of %u %s least %.3f, median %.3f, most %.3f", v->timeline.pass, (double)s.times[s.count - 1], s.count, view_plural(s.count, "frame", "frames"), (double)s.low,
            (double)s.median, (double)s.high);
    snprintf(label, sizeof label, "##times of %s", v->timeline.pass);
    ui_plot(label, s.times, s.count, 0, s.high, 36);
}

/* ---- the lanes ---- */

/* 1, 2 or 5 times a power of ten milliseconds, such that marks do not stand too close. */
static double axis_step(double per_millisecond) {
    double step = pow(10, floor(log10(70 / per_millisecond)));
    const double wanted = 70 / per_millisecond;
    return wanted <= step ? step : wanted <= 2 * step ? 2 * step : wanted <= 5 * step ? 5 * step : 10 * step;
}

static uint32_t word_color(const struct view *v) { return v->settings.dark ? 0xc0c0c0ff : 0x303030ff; }

static void draw_axis(const struct view *v, const struct ui_canvas *canvas, double length, double per_millisecond, float height) {
    const double step = axis_step(per_millisecond), first = floor(fmax((double)canvas->left / per_millisecond, 0) / step) * step;
    const double last = fmin(length, (double)(canvas->left + canvas->width - GUTTER) / per_millisecond);
    char text[32];
    for (uint32_t i = 0; first + i * step <= last && i < 1000; i++) {
        const double at = first + i * step;
        const float x = GUTTER + (float)(at * per_millisecond);
        ui_canvas_line(x, 0, x, height, 0x80808060);
        snprintf(text, sizeof text, step < 0.1 ? "%.3f ms" : step < 1 ? "%.1f ms" : "%.0f ms", at);
        ui_canvas_text(x + 2, 0, 66, word_color(v), text);
    }
}

static const char *const lane_names[TRACE_LANE_COUNT] = {"GPU", "GPU compute", "CPU Fanal", "CPU window"};

static void draw_lanes(struct view *v, const struct trace_frame *frame) {
    const struct trace_history *h = v->timeline.history;
    const double length = length_of(frame);
    const float width = fmaxf((ui_width_left() - 20 - GUTTER) * v->timeline.zoom, 10);
    const double per_millisecond = (double)width / length;
    bool has[TRACE_LANE_COUNT] = {[TRACE_GRAPHICS] = true, [TRACE_LIBRARY] = true};
    float tops[TRACE_LANE_COUNT], height = AXIS;
    for (uint32_t i = 0; i < frame->span_count; i++) has[frame->spans[i].lane] = true;
    for (int lane = 0; lane < TRACE_LANE_COUNT; lane++) {
        tops[lane] = height;
        if (has[lane]) height += LANE;
    }
    struct ui_canvas canvas;
    const struct trace_span *over = NULL;
    float nearest = 0;
    ui_canvas_begin("lanes", GUTTER + width, height, height + (v->timeline.zoom > 1 ? 32 : 18), &canvas);
    draw_axis(v, &canvas, length, per_millisecond, height);
    for (uint32_t i = 0; i < frame->span_count; i++) {
        const struct trace_span *span = &frame->spans[i];
        const char *name = trace_name(h, span->name);
        char label[280];
        const float x = GUTTER + (float)(begin_of(frame, span) * per_millisecond), wide = fmaxf((float)(span->milliseconds * per_millisecond), 1 / v->scale);
        if (x > canvas.left + canvas.width || x + wide < canvas.left) continue;
        const bool gpu = span->lane <= TRACE_COMPUTE, chosen = strcmp(v->timeline.pass, name) == 0;
        snprintf(label, sizeof label, "%s %s", gpu ? "pass" : "cpu", name);
        const uint32_t color = chosen ? CHOSEN_COLOR : gpu ? view_role_color(span->role) : span->lane == TRACE_LIBRARY ? 0xc0a890ff : 0xa0b0b0ff;
        /* Neighbours of one colour stay apart. */
        if (ui_canvas_rect(label, x, tops[span->lane] + 1, wide > 3 ? wide - 1 : wide, LANE - 2, color)) { /* narrow bars may overlap */
            const float away = fabsf(canvas.mouse_x - x - wide / 2);
            if (!over || away < nearest) over = span, nearest = away;
        }
        if (wide > 24) ui_canvas_text(x + 2, tops[span->lane] + 3, wide - 4, TEXT_COLOR, name);
    }
    for (int lane = 0; lane < TRACE_LANE_COUNT; lane++) { /* over what has been scrolled below it */
        if (!has[lane]) continue;
        if (ui_canvas_rect(NULL, canvas.left, tops[lane], GUTTER - 2, LANE, v->settings.dark ? 0x202020ff : 0xe0e0e0ff)) over = NULL;
        ui_canvas_text(canvas.left + 8, tops[lane] + 3, GUTTER - 10, word_color(v), lane_names[lane]);
    }
    if (over) {
        const bool gpu = over->lane <= TRACE_COMPUTE;
        const double whole = gpu ? frame->gpu_milliseconds : length;
        ui_hint("%s: %s\n%.3f ms, %.1f %% of %s\nfrom %.3f ms on", lane_names[over->lane], trace_name(h, over->name), over->milliseconds,
                whole > 0 ? 100 * over->milliseconds / whole : 0, gpu ? "all passes" : "the frame", begin_of(frame, over));
        if (ui_clicked()) snprintf(v->timeline.pass, sizeof v->timeline.pass, "%s", trace_name(h, over->name));
    }
    ui_canvas_end();
}

/* ---- the last frames ---- */

/* In the order of `roles`. */
static void frame_sums(const struct trace_frame *frame, double sums[ROLES]) {
    double of_role[ROLES] = {0};
    for (uint32_t i = 0; i < frame->span_count; i++)
        if (frame->spans[i].lane <= TRACE_COMPUTE) of_role[frame->spans[i].role] += frame->spans[i].milliseconds;
    for (uint32_t r = 0; r < ROLES; r++) sums[r] = of_role[roles[r].role];
}

static void draw_strip(struct view *v) {
    const struct trace_history *h = v->timeline.history;
    const uint32_t count = trace_count(h);
    struct summary frames;
    summarise_frames(v, &frames);
    /* A spike goes out of the strip at its top, so that the others can be told apart. */
    const double most = fmax(frames.count >= ENOUGH_FRAMES ? fmin((double)frames.high, 3 * (double)frames.median) : (double)frames.high, 1e-3);
    struct ui_canvas canvas;
    const struct trace_frame *over = NULL;
    uint32_t over_age = 0;
    const float bar = fmaxf((ui_width_left() - 18) / TRACE_FRAMES, 1);
    ui_canvas_begin("frames", TRACE_FRAMES * bar, STRIP, STRIP + 18, &canvas);
    for (uint32_t age = 0; age < count; age++) {
        const struct trace_frame *frame = trace_find(h, age);
        const float x = (float)(TRACE_FRAMES - 1 - age) * bar, wide = bar > 3 ? bar - 1 : bar;
        double sums[ROLES];
        char label[40];
        snprintf(label, sizeof label, "frame %u back", age);
        const bool shown = view_timeline_frame(v)->number == frame->number;
        if (ui_canvas_rect(label, x, 0, bar, STRIP, shown ? 0x808080a0 : 0x80808010)) {
            over = frame;
            over_age = age;
        }
        frame_sums(frame, sums);
        float y = STRIP;
        for (uint32_t r = 0; r < ROLES; r++) {
            const float high = fminf((float)(sums[r] / most) * (STRIP - 6), y);
            y -= high;
            if (high > 0) ui_canvas_rect(NULL, x, y, wide, high, roles[r].color);
        }
        if (is_spike(&frames, frame->gpu_milliseconds)) ui_canvas_rect(NULL, x, 0, bar, 4, SPIKE_COLOR);
    }
    if (over) {
        double sums[ROLES];
        char text[300] = "";
        frame_sums(over, sums);
        for (uint32_t r = 0; r < ROLES; r++)
            if (sums[r] > 0) snprintf(text + strlen(text), sizeof text - strlen(text), "\n%s %.3f ms", name_of_role(r), sums[r]);
        ui_hint("%u %s back: %.3f ms in passes%s%s", over_age, view_plural(over_age, "frame", "frames"), over->gpu_milliseconds, is_spike(&frames, over->gpu_milliseconds) ? ", a spike" : "", text);
        if (ui_clicked()) freeze(v, over);
    }
    ui_canvas_end();
    view_show_roles();
}

/* ---- the panel ---- */

void view_show_wide(struct view *v, enum view_wide what) {
    v->timeline.shown = v->timeline.shown == what ? VIEW_NOTHING_WIDE : what;
    if (v->timeline.shown != VIEW_NOTHING_WIDE) v->hides_panels = false;
    view_want(v, 2);
}

void view_panel_timeline(struct view *v) {
    const struct trace_frame *frame = view_timeline_frame(v);
    if (!frame) {
        ui_note("No frame has been drawn yet.");
        return;
    }
    if (!v->timeline.is_frozen && ui_button("freeze")) freeze(v, frame);
    if (v->timeline.is_frozen && ui_button("live")) v->timeline.is_frozen = false;
    ui_tooltip("Keeps this frame in view, or goes on with the last one");
    ui_same_line();
    ui_item_width(90);
    ui_number("zoom", &v->timeline.zoom, 1, 64, "%.1f");
    ui_same_line();
    ui_item_width(110);
    ui_input("##trace", v->timeline.trace_path, sizeof v->timeline.trace_path);
    ui_same_line();
    if (ui_button("save trace")) {
        view_free_name(v->timeline.trace_path, sizeof v->timeline.trace_path);
        view_save_trace(v, v->timeline.trace_path);
    }
    ui_tooltip("Writes the kept frames for Perfetto (ui.perfetto.dev) and chrome://tracing");
    frame = view_timeline_frame(v);
    ui_text("frame %llu%s: %.3f ms in passes, %.3f ms of the CPU", (unsigned long long)frame->number, v->timeline.is_frozen ? " (frozen)" : "",
            frame->gpu_milliseconds, frame->cpu_milliseconds);
    draw_lanes(v, frame);
    draw_strip(v);
    show_pass(v);
}

void view_panel_wide(struct view *v, struct ui_rectangle at) {
    ui_dock("##below", at);
    if (ui_button(v->timeline.shown == VIEW_TIMELINE ? "show the graph" : "show the timeline"))
        v->timeline.shown = v->timeline.shown == VIEW_TIMELINE ? VIEW_GRAPH : VIEW_TIMELINE;
    ui_same_line();
    const bool closed = ui_button("close##below");
    ui_same_line();
    if (v->timeline.shown == VIEW_TIMELINE)
        view_panel_timeline(v);
    else
        view_panel_graph(v);
    ui_window_end();
    if (closed) v->timeline.shown = VIEW_NOTHING_WIDE;
}

bool view_save_trace(struct view *v, const char *path) {
    char text[1100];
    const bool good = trace_count(v->timeline.history) > 0 && trace_save(v->timeline.history, path);
    snprintf(text, sizeof text, good ? "wrote %s" : "%s was not written", path);
    view_say(v, good ? FNL_LOG_INFO : FNL_LOG_ERROR, text);
    view_want(v, 2);
    return good;
}

void view_timeline_finish(struct view *v) {
    trace_destroy(&v->timeline.history);
    view_graph_free(&v->timeline.graph);
}

/* ---- as text ---- */

void view_report_timeline(const struct view *v, FILE *file) {
    const struct trace_history *h = v->timeline.history;
    const struct trace_frame *frame = trace_find(h, 0), *shown = view_timeline_frame(v);
    const fnl_frame_stats *s = &v->stats;
    for (uint32_t i = 0; frame && i < frame->span_count; i++) {
        const struct trace_span *span = &frame->spans[i];
        static const char *const kinds[TRACE_LANE_COUNT] = {"pass", "pass", "cpu", "window"};
        fprintf(file, "%s\t%s\t%.4f\t%.4f\t%s\n", kinds[span->lane], trace_name(h, span->name), span->milliseconds, span->begin,
                span->lane == TRACE_GRAPHICS  ? "graphics"
                : span->lane == TRACE_COMPUTE ? "compute"
                                              : "");
    }
    fprintf(file, "cpu_ms\t%.4f\n", s->cpu_milliseconds);
    for (uint32_t i = 0; i < s->candidate_count; i++) {
        const fnl_candidate *c = &s->candidates[i];
        fprintf(file, "candidate\t%s\t%s\t%.4f\t%u\t%s\n", fnl_value_name(FNL_ENUM_SHADING, c->shading), fnl_value_name(FNL_ENUM_LISTS, c->lists), c->milliseconds,
                c->frames, c->chosen ? "chosen" : "");
    }
    static const char *const panels[] = {"none", "timeline", "graph"};
    fprintf(file, "wide\t%s\nhistory\t%u\n", panels[v->timeline.shown], trace_count(h));
    if (shown) fprintf(file, "timeline\t%s\t%llu\t%llu\t%.4f\n", v->timeline.is_frozen ? "frozen" : "live", (unsigned long long)shown->number,
                       (unsigned long long)frame->number, shown->gpu_milliseconds);
    if (shown) {
        double sums[ROLES];
        struct summary frames;
        uint32_t spikes = 0;
        frame_sums(shown, sums);
        for (uint32_t r = 0; r < ROLES; r++) fprintf(file, "purpose\t%s\t%.4f\n", name_of_role(r), sums[r]);
        summarise_frames(v, &frames);
        for (uint32_t age = 0; age < trace_count(h); age++) spikes += is_spike(&frames, trace_find(h, age)->gpu_milliseconds);
        fprintf(file, "spikes\t%u\n", spikes);
    }
    if (v->timeline.pass[0]) {
        struct summary one;
        summarise(v, v->timeline.pass, &one);
        fprintf(file, "times\t%s\t%u\t%.4f\t%.4f\t%.4f\n", v->timeline.pass, one.count, (double)one.low, (double)one.median, (double)one.high);
    }
}
