/* SPDX-License-Identifier: MIT */
/* Sequences of pictures: a turntable, and the way that the camera flew. They are those of `fanal render --camera-path`, by its own code. */
#include "view/view.h"

#include "origin.h"
#include "output.h"
#include "print.h"
#include "render.h"

#include <stdlib.h>
#include <string.h>

/* ---- what is shown, as options of the command ---- */

void view_animation_text(const struct view *v, char *out, size_t capacity) {
    const float part = v->files.blend_part;
    if (view_blends(v))
        snprintf(out, capacity, "%u:%.9g,%u:%.9g", v->animation, (double)(1 - part), v->files.blend_with, (double)part);
    else
        snprintf(out, capacity, "%u", v->animation);
}

void view_save_size(const struct view *v, uint32_t *width, uint32_t *height) {
    *width = v->files.save_width ? v->files.save_width : v->width;
    *height = v->files.save_height ? v->files.save_height : v->height;
}

/* ---- sequences ---- */

bool view_save_sequence(struct view *v, const char *camera_path, const char *pattern) {
    struct render_options o = {.world = v->world, .outputs = {pattern}, .output_count = 1, .camera_path = camera_path, .frame_time = 1 / 30.0};
    struct render_report report = {.options = &o};
    char animation[96], text[3000];
    fnl_renderer *renderer = NULL;
    uint32_t width, height;
    if (!render_is_sequence(pattern) || !(render_has_extension(pattern, "png") || render_has_extension(pattern, "exr"))) {
        snprintf(text, sizeof text, "%.200s: is no name of many pictures, such as picture-%%04d.png", pattern);
        view_say(v, FNL_LOG_ERROR, text);
        return false;
    }
    view_save_size(v, &width, &height);
    if (width == 0 || height == 0 || !v->shown.source) return false;
    view_animation_text(v, animation, sizeof animation);
    o.world.animation = v->shown.info.animation_count ? animation : NULL;
    o.world.time = v->time;
    o.world.fov = v->camera.now.vertical_fov;
    if (!v->plays) {
        o.frame_time = 0;
        o.has_frame_time = true;
    }
    o.frame = view_whole_frame(v);
    o.frame.camera = v->camera.now;
    o.frame.width = width;
    o.frame.height = height;
    o.frame.outputs = render_has_extension(pattern, "exr") ? FNL_OUTPUT_RADIANCE : FNL_OUTPUT_COLOR;
    pthread_mutex_lock(&v->device.mutex);
    const bool good = view_wait_for_images(v, &o.frame) && fnl_renderer_create(v->device.device, v->shown.scene, &renderer) == FNL_OK &&
                      render_sequence(&o, &v->host, v->shown.scene, renderer, NULL, &o.frame, &report, NULL);
    fnl_renderer_destroy(&renderer);
    pthread_mutex_unlock(&v->device.mutex);
    if (v->shown.info.animation_count) view_set_time(v, v->time);
    char *path_word = print_shell_word(camera_path), *pattern_word = print_shell_word(pattern);
    const int length = !path_word || !pattern_word ? -1
                                                   : snprintf(v->files.sequence, sizeof v->files.sequence, "--camera-path %s%s -o %s", path_word,
                                                              v->plays ? "" : " --frame-time 0", pattern_word);
    if (length < 0 || length >= (int)sizeof v->files.sequence) v->files.sequence[0] = 0;
    free(path_word);
    free(pattern_word);
    snprintf(text, sizeof text, good ? "wrote the pictures %s" : "the pictures %s were not all written", pattern);
    view_say(v, good ? FNL_LOG_INFO : FNL_LOG_ERROR, text);
    view_want(v, 2);
    return good;
}

bool view_turntable(struct view *v, uint32_t count) {
    char path[40];
    snprintf(path, sizeof path, "turntable:%u", count ? count : 1);
    return view_save_sequence(v, path, v->files.pattern);
}

/* ---- the way of the camera ---- */

void view_record_flight(struct view *v, double seconds) {
    struct view_flight *f = &v->files.flight;
    if (!f->records) return;
    if (f->count == f->capacity) {
        const uint32_t capacity = f->capacity ? 2 * f->capacity : 256;
        struct view_point *bigger = realloc(f->points, capacity * sizeof *bigger);
        if (!bigger) {
            view_say(v, FNL_LOG_ERROR, "memory ran out; the recording ends here");
            f->records = false;
            return;
        }
        f->points = bigger;
        f->capacity = capacity;
    }
    if (f->count > 0) f->seconds += seconds;
    f->points[f->count++] = (struct view_point){.seconds = f->seconds};
    origin_place(v->shown.scene, v->camera.now.position, f->points[f->count - 1].eye);
    origin_place(v->shown.scene, v->camera.now.target, f->points[f->count - 1].target);
}

static bool write_flight(const struct view *v) {
    const struct view_flight *f = &v->files.flight;
    char *text = NULL;
    size_t length;
    FILE *out = open_memstream(&text, &length);
    if (!out) return false;
    fputs("# seconds eye target, for --camera-path\n", out);
    for (uint32_t i = 0; i < f->count; i++) {
        const struct view_point *p = &f->points[i];
        const int digits = origin_digits(v->shown.scene);
        fprintf(out, "%.9g %.*g %.*g %.*g %.*g %.*g %.*g\n", p->seconds, digits, p->eye[0], digits, p->eye[1], digits, p->eye[2], digits, p->target[0], digits,
                p->target[1], digits, p->target[2]);
    }
    const bool good = fclose(out) == 0 && output_save(v->files.flight_path, text, length);
    free(text);
    return good;
}

void view_toggle_flight(struct view *v) {
    struct view_flight *f = &v->files.flight;
    char text[300];
    if (!v->shown.source) return;
    f->records = !f->records;
    if (f->records) {
        f->count = 0;
        f->seconds = 0;
        view_record_flight(v, 0);
        return;
    }
    view_free_name(v->files.flight_path, sizeof v->files.flight_path);
    const bool good = f->count > 0 && write_flight(v);
    snprintf(text, sizeof text, good ? "wrote %s" : "%s was not written", v->files.flight_path);
    view_say(v, good ? FNL_LOG_INFO : FNL_LOG_ERROR, text);
    view_want(v, 2);
}

void view_files_finish(struct view *v) {
    free(v->files.flight.points);
    free(v->files.entries);
}

bool view_save_scene(struct view *v, const char *path) {
    char text[1100];
    if (!view_ends_with(path, ".glb")) {
        snprintf(text, sizeof text, "%.200s: scenes are saved as .glb", path);
        view_say(v, FNL_LOG_ERROR, text);
        return false;
    }
    const bool good = fnl_scene_save(v->shown.scene, path, NULL) == FNL_OK;
    snprintf(text, sizeof text, good ? "wrote %s" : "%s was not written", path);
    view_say(v, good ? FNL_LOG_INFO : FNL_LOG_ERROR, text);
    view_want(v, 2);
    return good;
}
