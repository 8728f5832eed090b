/* SPDX-License-Identifier: MIT */
#include "trace_file.h"

#include "output.h"
#include "print.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { MARKS = 48 };

struct trace_history {
    uint64_t next; /* number of the next frame */
    uint32_t count;
    char *names[TRACE_NAMES];
    uint32_t name_count, last_name, generation;
    struct {
        const char *name;
        double begin, end;
    } marks[MARKS];
    uint32_t mark_count;
    bool marking;
    struct trace_frame frames[TRACE_FRAMES];
};

double trace_now(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

struct trace_history *trace_create(void) { return calloc(1, sizeof(struct trace_history)); }

static void forget_names(struct trace_history *h) {
    for (uint32_t i = 0; i < h->name_count; i++) free(h->names[i]);
    h->name_count = h->last_name = h->count = 0;
    h->generation++;
}

void trace_destroy(struct trace_history **history) {
    if (*history) forget_names(*history);
    free(*history);
    *history = NULL;
}

/* ---- keeping ---- */

void trace_mark(struct trace_history *h, const char *name) {
    if (!h) return;
    const double now = trace_now();
    if (h->marking) h->marks[h->mark_count - 1].end = now;
    h->marking = name && h->mark_count < MARKS;
    if (!h->marking) return;
    h->marks[h->mark_count].name = name;
    h->marks[h->mark_count++].begin = now;
}

/* The number of a name; TRACE_NAMES: there are too many. Most often it is the one after the last that was asked for. */
static uint32_t number_of(struct trace_history *h, const char *name) {
    const uint32_t likely = h->last_name + 1 < h->name_count ? h->last_name + 1 : 0;
    if (likely < h->name_count && strcmp(h->names[likely], name) == 0) return h->last_name = likely;
    for (uint32_t i = 0; i < h->name_count; i++)
        if (strcmp(h->names[i], name) == 0) return h->last_name = i;
    if (h->name_count == TRACE_NAMES || !(h->names[h->name_count] = strdup(name))) return TRACE_NAMES;
    return h->last_name = h->name_count++;
}

static bool add_span(struct trace_history *h, struct trace_frame *frame, enum trace_lane lane, const char *name, double begin, double milliseconds, fnl_pass_role role) {
    const uint32_t number = number_of(h, name);
    if (number == TRACE_NAMES) return false;
    if (frame->span_count < TRACE_SPANS) frame->spans[frame->span_count++] = (struct trace_span){begin, milliseconds, (uint16_t)number, (uint8_t)lane, (uint8_t)role};
    return true;
}

static bool add_spans(struct trace_history *h, struct trace_frame *frame, const fnl_frame_stats *s, double called) {
    bool good = true;
    const double call = (called - frame->begin) * 1e3;
    frame->span_count = 0;
    for (int lane = TRACE_GRAPHICS; lane <= TRACE_COMPUTE; lane++)
        for (uint32_t i = 0; i < s->pass_count && good; i++)
            if ((s->passes[i].queue == FNL_QUEUE_COMPUTE) == (lane == TRACE_COMPUTE))
                good = add_span(h, frame, (enum trace_lane)lane, s->passes[i].name, s->passes[i].begin_milliseconds, s->passes[i].milliseconds, s->passes[i].role);
    frame->passes_begin = call;
    for (uint32_t i = 0; i < s->cpu_section_count && good; i++) {
        const fnl_cpu_section *section = &s->cpu_sections[i];
        good = add_span(h, frame, TRACE_LIBRARY, section->name, call + section->begin_milliseconds, section->milliseconds, FNL_PASS_REST);
        if (strcmp(section->name, "submit") == 0) frame->passes_begin = call + section->begin_milliseconds;
    }
    for (uint32_t i = 0; i < h->mark_count && good; i++)
        good = add_span(h, frame, TRACE_PROGRAM, h->marks[i].name, (h->marks[i].begin - frame->begin) * 1e3, (h->marks[i].end - h->marks[i].begin) * 1e3, FNL_PASS_REST);
    return good;
}

void trace_end_frame(struct trace_history *h, const fnl_frame_stats *s, double called) {
    if (!h) return;
    trace_mark(h, NULL);
    const double now = trace_now(), begin = h->mark_count ? fmin(called, h->marks[0].begin) : called;
    for (int attempt = 0; s && attempt < 2; attempt++) {
        struct trace_frame *frame = &h->frames[h->next % TRACE_FRAMES];
        frame->number = h->next;
        frame->begin = begin;
        frame->end = now;
        frame->gpu_milliseconds = s->gpu_milliseconds;
        frame->cpu_milliseconds = s->cpu_milliseconds;
        frame->device_bytes = s->device_bytes;
        frame->list_entries = s->list_entries;
        frame->lights_in_view = s->lights_in_view;
        frame->evaluations = s->evaluations;
        frame->evaluations_counted = s->evaluations_counted;
        if (add_spans(h, frame, s, called)) {
            h->next++;
            if (h->count < TRACE_FRAMES) h->count++;
            break;
        }
        forget_names(h); /* too many: of many scenes, or of frames of many kinds */
    }
    h->mark_count = 0;
}

/* ---- looking at it ---- */

uint32_t trace_count(const struct trace_history *h) { return h ? h->count : 0; }

const struct trace_frame *trace_find(const struct trace_history *h, uint32_t age) {
    return h && age < h->count ? &h->frames[(h->next - 1 - age) % TRACE_FRAMES] : NULL;
}

const char *trace_name(const struct trace_history *h, uint32_t name) { return h && name < h->name_count ? h->names[name] : ""; }
uint32_t trace_generation(const struct trace_history *h) { return h ? h->generation : 0; }

/* ---- the file ---- */

static void put_string(FILE *file, const char *text) {
    fputc('"', file);
    for (; *text; text++) {
        const unsigned char c = (unsigned char)*text;
        if (c < 0x20 || c == 0x7f)
            fprintf(file, "\\u%04x", c);
        else if (c == '"' || c == '\\')
            fprintf(file, "\\%c", c);
        else
            fputc(c, file);
    }
    fputc('"', file);
}

struct writer {
    FILE *file;
    double start;                          /* seconds: 0 of the file */
    long long lane_end[TRACE_LANE_COUNT];  /* nanoseconds */
};

/* Whole nanoseconds, so that what follows without a gap does not overlap in the file either. */
static void put_span(struct writer *w, const struct trace_history *h, const struct trace_frame *frame, const struct trace_span *span) {
    static const char *const kinds[TRACE_LANE_COUNT] = {"pass", "pass", "cpu", "program"};
    const double offset = (frame->begin - w->start) * 1e3 + (span->lane <= TRACE_COMPUTE ? frame->passes_begin : 0) + span->begin;
    long long begin = llround(offset * 1e6), length = llround(span->milliseconds * 1e6);
    if (begin < w->lane_end[span->lane]) begin = w->lane_end[span->lane];
    w->lane_end[span->lane] = begin + length;
    fputs(",\n{\"name\":", w->file);
    put_string(w->file, trace_name(h, span->name));
    fprintf(w->file, ",\"cat\":\"%s\",\"ph\":\"X\",\"ts\":%lld.%03lld,\"dur\":%lld.%03lld,\"pid\":1,\"tid\":%d}", kinds[span->lane], begin / 1000, begin % 1000,
            length / 1000, length % 1000, 2 + span->lane);
}

static void put_counter(const struct writer *w, long long at, const char *name, const char *unit, double value) {
    fprintf(w->file, ",\n{\"name\":\"%s\",\"ph\":\"C\",\"ts\":%lld.%03lld,\"pid\":1,\"args\":{\"%s\":%.9g}}", name, at / 1000, at % 1000, unit, value);
}

static void put_frame(struct writer *w, const struct trace_history *h, const struct trace_frame *frame) {
    const long long begin = llround((frame->begin - w->start) * 1e9), length = llround((frame->end - frame->begin) * 1e9);
    fprintf(w->file,
            ",\n{\"name\":\"frame %llu\",\"cat\":\"frame\",\"ph\":\"X\",\"ts\":%lld.%03lld,\"dur\":%lld.%03lld,\"pid\":1,\"tid\":1,"
            "\"args\":{\"gpu_milliseconds\":%.17g,\"cpu_milliseconds\":%.17g}}",
            (unsigned long long)frame->number, begin / 1000, begin % 1000, length / 1000, length % 1000, frame->gpu_milliseconds, frame->cpu_milliseconds);
    put_counter(w, begin, "lights in view", "lights", frame->lights_in_view);
    put_counter(w, begin, "list entries", "entries", (double)frame->list_entries);
    put_counter(w, begin, "device memory", "MB", (double)frame->device_bytes * 1e-6);
    if (frame->evaluations_counted) put_counter(w, begin, "light evaluations", "evaluations", (double)frame->evaluations);
    for (uint32_t i = 0; i < frame->span_count; i++) put_span(w, h, frame, &frame->spans[i]);
}

bool trace_save(const struct trace_history *h, const char *path) {
    static const char *const lanes[] = {"frames", "GPU, graphics queue", "GPU, compute queue", "CPU, Fanal", "CPU, the program"};
    char *text = NULL;
    size_t size;
    struct writer w = {.file = open_memstream(&text, &size)};
    const uint32_t count = trace_count(h);
    if (w.file) {
        fprintf(w.file, "{\"displayTimeUnit\":\"ms\",\"traceEvents\":[\n{\"name\":\"process_name\",\"ph\":\"M\",\"pid\":1,\"args\":{\"name\":\"fanal\"}}");
        for (size_t i = 0; i < sizeof lanes / sizeof *lanes; i++)
            fprintf(w.file, ",\n{\"name\":\"thread_name\",\"ph\":\"M\",\"pid\":1,\"tid\":%zu,\"args\":{\"name\":\"%s\"}}", i + 1, lanes[i]);
        if (count > 0) w.start = trace_find(h, count - 1)->begin;
        for (uint32_t age = count; age-- > 0;) put_frame(&w, h, trace_find(h, age));
        fputs("\n]}\n", w.file);
    }
    const bool written = w.file && fclose(w.file) == 0;
    if (!written) fprintf(stderr, "fanal: error: %s: memory ran out\n", path);
    const bool good = written && output_save(path, text, size);
    free(text);
    return good;
}
