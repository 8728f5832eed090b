/* SPDX-License-Identifier: MIT */
/* Files of the shown scene that change on disk: it is loaded again, and seen from where the old one was. */
#include "view/view.h"

#include "origin.h"

#include <string.h>
#include <sys/stat.h>
#include <time.h>

static uint64_t mix(uint64_t hash, uint64_t value) {
    for (int i = 0; i < 8; i++) hash = (hash ^ (value >> 8 * i & 255)) * 1099511628211u; /* FNV-1a */
    return hash;
}

/* Of sizes and times; a file that is missing counts as well. */
static uint64_t stamp_of(const struct view *v) {
    uint64_t hash = 14695981039346656037u;
    const char *path;
    for (uint32_t i = 0; v->shown.scene && (path = fnl_scene_source(v->shown.scene, i)); i++) {
        struct stat s;
        const bool there = stat(path, &s) == 0;
        hash = mix(hash, there);
        if (!there) continue;
        hash = mix(mix(mix(hash, (uint64_t)s.st_size), (uint64_t)s.st_mtim.tv_sec), (uint64_t)s.st_mtim.tv_nsec);
        hash = mix(hash, (uint64_t)s.st_ino);
    }
    return hash;
}

void view_watch_begin(struct view *v) {
    v->files.stamp = stamp_of(v);
    v->files.changed = false;
}

static int64_t nanoseconds(struct timespec t) { return (int64_t)t.tv_sec * 1000000000 + t.tv_nsec; }

static int64_t file_clock(void) {
    struct timespec now = {0};
    clock_gettime(CLOCK_REALTIME, &now);
    return nanoseconds(now);
}

void view_watch_loading(struct view *v) { v->files.load_begun = file_clock(); }

void view_watch_loaded(struct view *v) {
    const char *path;
    view_watch_begin(v);
    for (uint32_t i = 0; v->shown.scene && (path = fnl_scene_source(v->shown.scene, i)); i++) {
        struct stat s;
        if (stat(path, &s) != 0) continue;
        const int64_t changed = nanoseconds(s.st_mtim);
        if (changed > v->files.load_begun && changed <= file_clock()) v->files.changed = true; /* not where another machine's clock is ahead */
    }
    v->files.quiet = 0;
}

static void reload(struct view *v) {
    char text[1100];
    snprintf(text, sizeof text, "%s has changed: loading it again%s", v->shown.source, v->shown.changed ? ", without what was changed in the window" : "");
    view_say(v, FNL_LOG_INFO, text);
    v->files.again = view_load(v, v->shown.source);
    view_want(v, 1);
}

/* A file that is being written changes from look to look. */
static void look(struct view *v) {
    enum { QUIET = 2 };
    if (!v->shown.source || v->loader.running) return;
    const uint64_t stamp = stamp_of(v);
    if (stamp != v->files.stamp) {
        v->files.stamp = stamp;
        v->files.changed = true;
        v->files.quiet = 0;
    } else if (v->files.changed && ++v->files.quiet >= QUIET) {
        v->files.changed = false;
        reload(v);
    }
}

void view_watch(struct view *v) {
    const double now = view_now(), period = 0.5;
    if (now < v->files.next_look) return;
    v->files.next_look = now + period;
    look(v);
}

void view_watch_at_once(struct view *v) {
    for (int i = 0; i < 3; i++) look(v);
}

bool view_take_loaded(struct view *v, bool wait) {
    struct view_scene scene;
    if (!view_loader_take(&v->loader, wait, &scene)) return false;
    const bool again = v->files.again;
    v->files.again = false;
    if (!again) {
        view_show(v, &scene);
        return true;
    }
    if (!scene.scene) {
        view_say(v, FNL_LOG_ERROR, "what has changed cannot be loaded; the scene stays as it was");
        view_want(v, 2);
        return true;
    }
    struct view_camera camera = v->camera;
    double position[3], target[3];
    origin_place(v->shown.scene, camera.now.position, position);
    origin_place(v->shown.scene, camera.now.target, target);
    const fnl_frame frame = v->frame;
    const uint32_t animation = v->animation;
    const double time = v->time;
    const uint64_t looked = v->files.stamp;
    const struct view_surroundings surroundings = v->surroundings;
    char variant[sizeof v->variant];
    memcpy(variant, v->variant, sizeof variant);
    view_show(v, &scene);
    if (surroundings.changed) {
        v->surroundings = surroundings;
        view_apply_surroundings(v);
    }
    uint32_t number;
    if (variant[0] && fnl_scene_find(v->shown.scene, FNL_ENTITY_VARIANT, variant, &number) == FNL_OK && fnl_scene_select_variant(v->shown.scene, number) == FNL_OK)
        memcpy(v->variant, variant, sizeof variant);
    v->files.stamp = looked; /* what has changed while it was loaded is seen at the next look */
    camera.now.position = origin_position(v->shown.scene, position); /* the reloaded file may have another origin */
    camera.now.target = origin_position(v->shown.scene, target);
    v->camera.now = camera.now;
    v->frame = v->good = frame;
    v->animation = animation < v->shown.info.animation_count ? animation : 0;
    if (time > 0 || v->animation || view_blends(v)) view_set_time(v, time);
    return true;
}
