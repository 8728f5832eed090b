/* SPDX-License-Identifier: MIT */
/* Frames of two methods at once, and how far they are apart. */
#include "view/view.h"

#include "options.h"
#include "print.h"
#include "view/ui.h"

#include "fanal/vulkan.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const char *const names[VIEW_COMPARE_COUNT] = {"off", "split", "side", "difference"};
enum { DIFFERENCE_IMAGE = 1 }; /* of the overlay */

/* ---- what is compared ---- */

const char *view_compare_name(enum view_compare_mode mode) { return names[mode]; }

static void forget_difference(struct view *v) {
    struct view_compare *c = &v->compare;
    for (int i = 0; i < 2; i++) fnl_image_free(&v->host, &c->pictures[i]);
    ui_set_image(DIFFERENCE_IMAGE, NULL, 0);
    fnl_image_free(&v->host, &c->shown);
    c->is_shown = false;
}

void view_compare_leave(struct view *v) {
    struct view_compare *c = &v->compare;
    forget_difference(v);
    fnl_renderer_destroy(&c->renderer);
    fnl_renderer_destroy(&c->no_renderer);
    fnl_scene_destroy(&c->no_scene);
    c->drags = false;
}

void view_compare_copy(struct view *v) {
    struct view_compare *c = &v->compare;
    c->frame = v->frame;
    c->good = v->good;
    c->own_shadows = v->own_shadows;
    c->begun = true;
    view_want(v, 2);
}

void view_compare_expose(struct view *v) {
    v->compare.frame.exposure = v->frame.exposure;
    v->compare.frame.ev = v->frame.ev;
    view_want(v, 2);
}

void view_compare_begin(struct view *v, enum view_compare_mode mode) {
    struct view_compare *c = &v->compare;
    if (!c->begun) view_compare_copy(v);
    c->mode = mode;
    view_want(v, 2); /* view_compare_update drops what is needed no longer: panels may have drawn it into this frame */
}

bool view_compare_set_mode(struct view *v, const char *name) {
    for (int i = 0; i < VIEW_COMPARE_COUNT; i++) {
        if (strcmp(name, names[i]) != 0) continue;
        view_compare_begin(v, (enum view_compare_mode)i);
        return true;
    }
    fprintf(stderr, "fanal: error: compare: '%s' is not one of off, split, side, difference\n", name);
    return false;
}

bool view_compare_set_b(struct view *v, const char *text) {
    struct view_compare *c = &v->compare;
    const char *key = NULL;
    if (!c->begun) view_compare_copy(v);
    if (!options_set_text(&c->frame, "compare", text, &key)) return false;
    c->own_shadows = c->own_shadows || strcmp(key, "shadows") == 0;
    view_want(v, 2);
    return true;
}

bool view_compare_start(struct view *v, const char *changes) {
    struct view_compare *c = &v->compare;
    char text[1024];
    *c = (struct view_compare){.slider = 0.5f};
    if (!changes) return true;
    if (strlen(changes) >= sizeof text) {
        fputs("fanal: error: --compare: too long\n", stderr);
        return false;
    }
    strcpy(text, changes);
    char *rest = text;
    for (char *item; (item = strsep(&rest, ","));)
        if (!view_compare_set_b(v, item)) return false;
    c->mode = VIEW_COMPARE_SPLIT;
    return true;
}

void view_compare_swap(struct view *v) {
    struct view_compare *c = &v->compare;
    const struct view_compare b = *c;
    if (!c->begun) return;
    c->frame = v->frame;
    c->good = v->good;
    c->own_shadows = v->own_shadows;
    c->times[0].count = c->times[1].count = 0;
    v->frame = b.frame;
    v->good = b.good;
    v->own_shadows = b.own_shadows;
    if (b.renderer) { /* both know the scene: each goes on with what it remembers */
        c->renderer = v->shown.renderer;
        v->shown.renderer = b.renderer;
        c->milliseconds = v->stats.gpu_milliseconds;
        if (fnl_renderer_query_stats(v->shown.renderer, &v->stats) != FNL_OK) v->stats = (fnl_frame_stats){0};
    }
    view_want(v, 2);
}

fnl_frame *view_edited(struct view *v) { return v->compare.mode != VIEW_COMPARE_OFF && v->compare.edits_b ? &v->compare.frame : &v->frame; }

void view_compare_method(const struct view *v, bool of_b, char *text, size_t capacity) {
    fnl_option o;
    char own[64], other[64];
    size_t length = 0;
    text[0] = 0;
    for (uint32_t i = 0; fnl_option_query(i, &o); i++) {
        if (strcmp(o.key, "width") == 0 || strcmp(o.key, "height") == 0) continue;
        fnl_frame_get(of_b ? &v->compare.frame : &v->frame, o.key, own, sizeof own);
        fnl_frame_get(of_b ? &v->frame : &v->compare.frame, o.key, other, sizeof other);
        if (strcmp(own, other) == 0 || length >= capacity) continue;
        length += (size_t)snprintf(text + length, capacity - length, "%s%s=%s", length ? " " : "", o.key, own);
    }
}

/* ---- frames ---- */

static bool can_be_taken_back(fnl_result result) {
    return result == FNL_ERROR_INVALID || result == FNL_ERROR_UNSUPPORTED || result == FNL_ERROR_MEMORY;
}

/* B's renderer is there; else it compares no longer. */
static bool is_ready(struct view *v) {
    struct view_compare *c = &v->compare;
    if (c->mode == VIEW_COMPARE_OFF) return false;
    if (c->renderer || fnl_renderer_create(v->device.device, v->shown.scene, &c->renderer) == FNL_OK) return true;
    view_compare_begin(v, VIEW_COMPARE_OFF);
    return false;
}

/* As A's frame, with B's options. */
static fnl_frame b_frame(const struct view *v, const fnl_frame *a) {
    fnl_frame frame = v->compare.frame;
    frame.width = a->width;
    frame.height = a->height;
    frame.camera = a->camera;
    frame.outputs = a->outputs;
    frame.overlay = a->overlay;
    frame.pin_choice = frame.pin_choice || a->pin_choice;
    return frame;
}

static fnl_result render(fnl_renderer *renderer, const fnl_frame *frame, const fnl_vulkan_target *target) {
    return target ? fnl_renderer_render_to(renderer, frame, target) : fnl_renderer_render(renderer, frame);
}

/* What B cannot draw is taken back: nothing of it was submitted. */
static fnl_result render_b(struct view *v, const fnl_frame *a, const fnl_vulkan_target *target) {
    struct view_compare *c = &v->compare;
    fnl_frame frame = b_frame(v, a);
    fnl_result result = render(c->renderer, &frame, target);
    if (can_be_taken_back(result)) {
        c->frame = c->good;
        view_want(v, 2);
        frame = b_frame(v, a);
        result = render(c->renderer, &frame, target);
    }
    if (result == FNL_OK) c->good = c->frame;
    return result;
}

/* The first column of B's picture. */
static uint32_t border(const struct view *v, uint32_t width) {
    const struct ui_rectangle area = view_area(v);
    const bool whole = area.width == (float)v->width;
    const float part = v->compare.mode == VIEW_COMPARE_SIDE ? 0.5f : fminf(fmaxf(v->compare.slider, 0), 1);
    const float at = whole ? part * (float)width : (area.x + part * area.width) * (float)width / (float)v->width;
    return v->compare.mode == VIEW_COMPARE_SIDE ? (uint32_t)at : (uint32_t)lroundf(at);
}

fnl_camera view_compare_camera(const struct view *v, bool of_b) {
    struct ui_rectangle area = view_area(v);
    float width = (float)v->width;
    if (v->compare.mode == VIEW_COMPARE_SIDE) {
        const float at = (float)border(v, v->width);
        area.width = of_b ? area.x + area.width - at : at - area.x;
        area.x = of_b ? 0 : area.x;
        width = of_b ? width - at : at;
    }
    return view_fitted_camera(&v->camera.now, area, fmaxf(width, 1), (float)v->height);
}

uint32_t view_compare_place(const struct view *v, uint32_t *x) {
    const uint32_t at = border(v, v->width);
    if (v->compare.mode != VIEW_COMPARE_SIDE || at == 0) return v->width;
    if (*x < at) return at;
    *x -= at;
    return v->width - at;
}

/* A's frame for what stands in its part of the window: side by side it has its width. */
static fnl_frame part_frame(const struct view *v, const fnl_frame *frame, uint32_t width, uint32_t part_width, bool of_b) {
    fnl_frame own = *frame;
    if (v->compare.mode != VIEW_COMPARE_SIDE) return own;
    own.width = (uint32_t)fmax(1, round((double)frame->width * part_width / width));
    own.camera = view_compare_camera(v, of_b);
    return own;
}

/* The picture is all overlay: of a scene with nothing in it. */
static fnl_result draw_difference(struct view *v, const fnl_frame *frame, const fnl_vulkan_target *target) {
    struct view_compare *c = &v->compare;
    fnl_frame own = view_bare_frame();
    own.width = target ? 1 : frame->width;
    own.height = target ? 1 : frame->height;
    own.outputs = frame->outputs;
    own.overlay = frame->overlay;
    if (!c->no_scene && fnl_scene_create(&v->host, &c->no_scene) != FNL_OK) return FNL_ERROR_MEMORY;
    if (!c->no_renderer && fnl_renderer_create(v->device.device, c->no_scene, &c->no_renderer) != FNL_OK) return FNL_ERROR_MEMORY;
    return render(c->no_renderer, &own, target);
}

fnl_result view_compare_draw(struct view *v, const fnl_frame *frame, const fnl_vulkan_target *target) {
    struct view_compare *c = &v->compare;
    if (!is_ready(v)) return render(v->shown.renderer, frame, target);
    if (c->is_shown) return draw_difference(v, frame, target);
    const uint32_t width = target ? target->width : v->width, at = border(v, width);
    const fnl_frame a = part_frame(v, frame, width, at, false), b = part_frame(v, frame, width, width - at, true);
    if (!target) {
        const fnl_result drawn = fnl_renderer_render(v->shown.renderer, &a);
        return drawn == FNL_OK ? render_b(v, &b, NULL) : drawn;
    }
    const bool fitted = c->mode == VIEW_COMPARE_SIDE;
    fnl_vulkan_target left = *target, right = *target;
    left.part = (fnl_vulkan_part){0, 0, at, target->height, fitted};
    right.part = (fnl_vulkan_part){at, 0, width - at, target->height, fitted};
    if (at > 0 && at < width) { /* A's waits for the image, B's hands it on */
        left.signal = VK_NULL_HANDLE;
        left.final_layout = right.initial_layout = VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL;
        right.wait = VK_NULL_HANDLE;
    }
    fnl_result result = render(v->shown.renderer, &a, at > 0 ? &left : NULL);
    if (result != FNL_OK) return result;
    result = render_b(v, &b, at < width ? &right : NULL);
    if (!can_be_taken_back(result)) return result;
    view_say(v, FNL_LOG_ERROR, "B cannot be drawn: nothing is compared any more");
    view_compare_begin(v, VIEW_COMPARE_OFF);
    if (at == width) return FNL_OK;
    right.part = (fnl_vulkan_part){0}; /* somebody waits for the picture */
    return fnl_renderer_render_to(v->shown.renderer, frame, &right);
}

/* ---- pictures that are read back ---- */

static fnl_result render_and_read(struct view *v, const fnl_frame *a, bool of_b, fnl_image *out) {
    const fnl_result result = of_b ? render_b(v, a, NULL) : fnl_renderer_render(v->shown.renderer, a);
    return result == FNL_OK ? fnl_renderer_read(of_b ? v->compare.renderer : v->shown.renderer, FNL_OUTPUT_COLOR, out) : result;
}

/* An overlay whose places count from a column on. */
struct moved_overlay {
    fnl_overlay overlay;
    fnl_overlay_vertex *vertices;
    fnl_overlay_draw *draws;
};

static bool move_overlay(const fnl_overlay *from, uint32_t column, struct moved_overlay *out) {
    out->overlay = *from;
    out->vertices = malloc(from->vertex_count * sizeof *out->vertices + 1);
    out->draws = malloc(from->draw_count * sizeof *out->draws + 1);
    if (!out->vertices || !out->draws) return false;
    for (uint32_t i = 0; i < from->vertex_count; i++) {
        out->vertices[i] = from->vertices[i];
        out->vertices[i].position.x -= (float)column;
    }
    for (uint32_t i = 0; i < from->draw_count; i++) {
        out->draws[i] = from->draws[i];
        out->draws[i].x -= (int32_t)column;
    }
    out->overlay.vertices = out->vertices;
    out->overlay.draws = out->draws;
    return true;
}

/* Columns `at` and up of `to` become those of `from`, which begin there (side by side), or are those of the same place. */
static void put_right(fnl_image *to, const fnl_image *from, uint32_t at, uint32_t from_at) {
    for (uint32_t y = 0; y < to->height; y++)
        memcpy((char *)to->pixels + 4 * ((size_t)y * to->width + at), (const char *)from->pixels + 4 * ((size_t)y * from->width + from_at),
               4 * (size_t)(to->width - at));
}

/* Side by side, of two pictures; `left` becomes a new one. */
static bool widen(struct view *v, fnl_image *left, uint32_t width) {
    fnl_image wide = {width, left->height, left->format, v->host.reallocate(v->host.user, NULL, 0, 4 * (size_t)width * left->height)};
    if (!wide.pixels) return false;
    for (uint32_t y = 0; y < left->height; y++)
        memcpy((char *)wide.pixels + 4 * (size_t)y * width, (const char *)left->pixels + 4 * (size_t)y * left->width, 4 * (size_t)left->width);
    fnl_image_free(&v->host, left);
    *left = wide;
    return true;
}

fnl_result view_compare_read(struct view *v, const fnl_frame *frame, fnl_image *out) {
    struct view_compare *c = &v->compare;
    const bool side = c->mode == VIEW_COMPARE_SIDE;
    *out = (fnl_image){0};
    if (!is_ready(v)) return render_and_read(v, frame, false, out);
    if (c->is_shown) {
        const fnl_result result = draw_difference(v, frame, NULL);
        return result == FNL_OK ? fnl_renderer_read(c->no_renderer, FNL_OUTPUT_COLOR, out) : result;
    }
    const uint32_t at = border(v, frame->width);
    struct moved_overlay moved = {0};
    fnl_image right = {0};
    fnl_frame a = part_frame(v, frame, frame->width, at, false), b = part_frame(v, frame, frame->width, frame->width - at, true);
    fnl_result result = !side || !frame->overlay || move_overlay(frame->overlay, at, &moved) ? FNL_OK : FNL_ERROR_MEMORY;
    if (side && frame->overlay) b.overlay = &moved.overlay;
    if (result == FNL_OK) result = render_and_read(v, &a, false, out);
    if (result == FNL_OK) result = render_and_read(v, &b, true, &right);
    if (result == FNL_OK && side && !widen(v, out, frame->width)) result = FNL_ERROR_MEMORY;
    if (result == FNL_OK) put_right(out, &right, at, side ? 0 : at);
    fnl_image_free(&v->host, &right);
    if (result != FNL_OK) fnl_image_free(&v->host, out);
    free(moved.vertices);
    free(moved.draws);
    return result;
}

/* ---- the difference ---- */

static bool is_same(const fnl_image *a, const fnl_image *b) {
    return a->pixels && b->pixels && a->width == b->width && a->height == b->height && memcmp(a->pixels, b->pixels, 4 * (size_t)a->width * a->height) == 0;
}

/* Takes the pictures. */
static bool find_difference(struct view *v, fnl_image pictures[2]) {
    struct view_compare *c = &v->compare;
    const bool known = is_same(&pictures[0], &c->pictures[0]) && is_same(&pictures[1], &c->pictures[1]);
    for (int i = 0; i < 2; i++) {
        fnl_image_free(&v->host, &c->pictures[i]);
        c->pictures[i] = pictures[i];
    }
    if (!known && fnl_image_compare(&v->host, &c->pictures[0], &c->pictures[1], &c->numbers) != FNL_OK) return false;
    if (known && c->shown.pixels && c->gain == c->shown_gain) return true;
    fnl_image_free(&v->host, &c->shown);
    c->shown_gain = c->gain;
    if (fnl_image_difference_picture(&v->host, &c->pictures[0], &c->pictures[1], c->gain, &c->shown) != FNL_OK) return false;
    ui_set_image(DIFFERENCE_IMAGE, &c->shown, ++c->version);
    return true;
}

void view_compare_update(struct view *v) {
    struct view_compare *c = &v->compare;
    fnl_image pictures[2] = {{0}};
    c->is_shown = false;
    if (c->mode == VIEW_COMPARE_OFF) view_compare_leave(v);
    if (c->mode != VIEW_COMPARE_DIFFERENCE) forget_difference(v);
    if (c->mode != VIEW_COMPARE_DIFFERENCE || v->moving || v->part < 1 || v->width == 0 || v->height == 0 || !is_ready(v)) return;
    fnl_frame frame = view_whole_frame(v);
    fnl_result result = FNL_OK;
    for (int i = 0; i < 2 && result == FNL_OK; i++) {
        result = render_and_read(v, &frame, i == 1, &pictures[i]);
        if (i == 0 && can_be_taken_back(result)) {
            v->frame = v->good;
            view_want(v, 2);
        }
    }
    if (result == FNL_OK) {
        c->is_shown = find_difference(v, pictures);
        return;
    }
    for (int i = 0; i < 2; i++) fnl_image_free(&v->host, &pictures[i]);
}

/* ---- over the picture ---- */

struct spread {
    float low, median, high; /* a quarter of the frames is below low, and a quarter above high */
    uint32_t count;
};

static int by_size(const void *a, const void *b) {
    const float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

static struct spread spread_of(const struct view_times *times) {
    float sorted[VIEW_TIMES];
    const uint32_t count = times->count < VIEW_TIMES ? times->count : VIEW_TIMES;
    if (count == 0) return (struct spread){0};
    memcpy(sorted, times->last, count * sizeof *sorted);
    qsort(sorted, count, sizeof *sorted, by_size);
    return (struct spread){sorted[count / 4], count % 2 ? sorted[count / 2] : 0.5f * (sorted[count / 2 - 1] + sorted[count / 2]), sorted[count - 1 - count / 4], count};
}

static void label(const struct view *v, bool of_b, float x, bool left_of) {
    char method[160], text[260], time[80];
    const struct spread s = spread_of(&v->compare.times[of_b]);
    view_compare_method(v, of_b, method, sizeof method);
    if (!method[0]) snprintf(method, sizeof method, "the same");
    snprintf(time, sizeof time, s.count > 1 ? "%.2f ms (%.2f to %.2f)" : "%.2f ms", (double)s.median, (double)s.low, (double)s.high);
    if (of_b) /* nearest to the middle what is shortest: the rest may be behind a panel */
        snprintf(text, sizeof text, "B  %s  %s", time, method);
    else
        snprintf(text, sizeof text, "%s  %s  A", method, time);
    ui_back_label(x, view_area(v).y + 8 * v->scale, left_of, text);
}

void view_compare_back(struct view *v) {
    struct view_compare *c = &v->compare;
    const float width = (float)v->width, height = (float)v->height, x = (float)border(v, v->width), gap = 6 * v->scale;
    if (c->mode == VIEW_COMPARE_OFF || !v->shown.scene) return;
    if (c->is_shown) ui_back_image(DIFFERENCE_IMAGE, 0, 0, width, height);
    if (v->hides_panels) return;
    if (c->is_shown) {
        const struct ui_rectangle area = view_area(v);
        label(v, false, area.x + area.width / 2 - gap, true);
        label(v, true, area.x + area.width / 2 + gap, false);
        return;
    }
    ui_back_line(x, height);
    label(v, false, x - gap, true);
    label(v, true, x + gap, false);
}

/* Times of other options or another size do not count; where the camera is makes no difference. */
static void note_time(struct view *v, bool of_b, double milliseconds) {
    struct view_times *times = &v->compare.times[of_b];
    fnl_frame frame = of_b ? v->compare.frame : v->frame;
    frame.width = (uint32_t)((float)v->width * v->part);
    frame.height = (uint32_t)((float)v->height * v->part);
    if (memcmp(&frame, &v->compare.timed[of_b], sizeof frame) != 0) times->count = 0;
    v->compare.timed[of_b] = frame;
    times->last[times->count++ % VIEW_TIMES] = (float)milliseconds;
}

void view_compare_note(struct view *v) {
    fnl_frame_stats stats;
    if (v->compare.mode == VIEW_COMPARE_OFF || !v->compare.renderer || fnl_renderer_query_stats(v->compare.renderer, &stats) != FNL_OK) return;
    v->compare.milliseconds = stats.gpu_milliseconds;
    note_time(v, false, v->stats.gpu_milliseconds);
    note_time(v, true, stats.gpu_milliseconds);
}

/* ---- the slider ---- */

bool view_compare_press(struct view *v, const struct view_event *e) {
    struct view_compare *c = &v->compare;
    if (!e->down) {
        if (e->code == 0) c->drags = false;
        return false;
    }
    const bool moves = c->mode == VIEW_COMPARE_SPLIT || (c->mode == VIEW_COMPARE_DIFFERENCE && !c->is_shown);
    if (!moves || e->code != 0 || e->modifiers || ui_wants_mouse() || fabsf(v->mouse_x - (float)border(v, v->width)) > 6 * v->scale) return false;
    c->drags = true;
    return true;
}

void view_compare_move(struct view *v) {
    const struct ui_rectangle area = view_area(v);
    if (v->compare.drags && area.width > 0) v->compare.slider = fminf(fmaxf((v->mouse_x - area.x) / area.width, 0), 1);
}

/* ---- as text ---- */

void view_compare_report(const struct view *v, FILE *file) {
    const struct view_compare *c = &v->compare;
    char method[1024];
    fprintf(file, "compare\t%s\n", names[c->mode]);
    if (c->mode == VIEW_COMPARE_OFF) return;
    fprintf(file, "slider\t%.9g\n", (double)c->slider);
    for (int b = 0; b < 2; b++) {
        view_compare_method(v, b, method, sizeof method);
        const struct spread s = spread_of(&c->times[b]);
        fprintf(file, "method_%c\t%s\t%.4f\n", "ab"[b], method, b ? c->milliseconds : v->stats.gpu_milliseconds);
        fprintf(file, "times_%c\t%u\t%.4f\t%.4f\t%.4f\n", "ab"[b], s.count, (double)s.low, (double)s.median, (double)s.high);
    }
    if (!c->is_shown) return;
    fprintf(file, "psnr\t%.4f\nmax_difference\t%.9g\ndiffering_pixels\t%llu\n", c->numbers.psnr, c->numbers.max,
            (unsigned long long)c->numbers.differing_pixels);
}
