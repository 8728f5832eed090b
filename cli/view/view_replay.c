/* SPDX-License-Identifier: MIT */
/* Events from a file. */
#include "view/view.h"

#include "input.h"
#include "options.h"
#include "output.h"
#include "print.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

static bool settle(struct view *v) {
    view_take_loaded(v, true);
    view_want(v, 2);
    for (uint32_t i = 0; (i < 1000 || v->pending > 0) && v->wanted > 0 && !v->plays; i++) {
        if (v->pending > 0) nanosleep(&(struct timespec){.tv_nsec = 2000000}, NULL);
        v->moving = false;
        view_advance(v, 1.0 / 60);
        if (!view_draw_frame(v, 1.0 / 60)) return false;
    }
    return true;
}

static bool write_command(const struct view *v, const char *path) {
    struct output out;
    if (!output_begin(path, &out)) return false;
    view_print_command(v, out.stream);
    return output_commit(&out);
}

/* As somebody would: the mouse goes there, and the button goes down and up, with a frame after each. */
static bool click(struct view *v, const char *label) {
    struct view_event e = {.kind = VIEW_MOVE};
    bool ignored;
    if (!view_draw_frame(v, 1.0 / 60)) return false;
    if (!ui_find(label, &e.x, &e.y)) { /* folded away, or it can be scrolled to */
        ui_seek(label);
        const bool drawn = view_draw_frame(v, 1.0 / 60) && view_draw_frame(v, 1.0 / 60);
        ui_seek(NULL);
        if (!drawn) return false;
    }
    if (!ui_find(label, &e.x, &e.y)) {
        fprintf(stderr, "fanal: error: %s: no widget in sight is called so\n", label);
        return false;
    }
    if (!view_feed(v, &e, &ignored)) return false;
    e = (struct view_event){.kind = VIEW_BUTTON, .down = true, .modifiers = v->modifiers};
    if (!view_feed(v, &e, &ignored) || !view_draw_frame(v, 1.0 / 60)) return false;
    e.down = false;
    return view_feed(v, &e, &ignored) && view_draw_frame(v, 1.0 / 60);
}

/* "FILE", or "FILE WIDTH HEIGHT", a size that stays for what follows. */
static bool save(struct view *v, const char *text) {
    char path[VIEW_PATH];
    int used = 0;
    uint32_t width, height;
    if (sscanf(text, "%1023s %u %u %n", path, &width, &height, &used) == 3 && !text[used] && width <= 16384 && height <= 16384) {
        v->files.save_width = width;
        v->files.save_height = height;
        text = path;
    }
    return view_save_picture(v, text);
}

static bool replay_event(struct view *v, const struct view_event *e) {
    switch (e->kind) {
    case VIEW_FRAMES:
        for (int i = 0; i < e->code; i++) {
            if (v->window) view_window_poll(v->window, 0);
            v->queue.count = 0; /* what the real window says does not count */
            v->moving = false;
            view_advance(v, 1.0 / 60);
            if (!view_draw_frame(v, 1.0 / 60)) return false;
        }
        return true;
    case VIEW_SETTLE:
        return settle(v);
    case VIEW_SET:
        view_want(v, 2);
        v->own_shadows = v->own_shadows || strncmp(e->text, "shadows=", 8) == 0;
        return options_set_text(&v->frame, "replay", e->text, NULL);
    case VIEW_CLICK:
        return click(v, e->text);
    case VIEW_SAVE:
        return save(v, e->text);
    case VIEW_SAVE_SCENE:
        return view_save_scene(v, e->text);
    case VIEW_TURNTABLE:
        return view_turntable(v, (uint32_t)e->code);
    case VIEW_PANEL:
        return view_open_panel_named(v, e->text);
    case VIEW_POLL:
        view_watch_at_once(v);
        return true;
    case VIEW_CAPTURE:
        return view_save_capture(v, e->text);
    case VIEW_COMMAND:
        return write_command(v, e->text);
    case VIEW_COMPARE:
        return view_compare_set_mode(v, e->text);
    case VIEW_SET_B:
        return view_compare_set_b(v, e->text);
    case VIEW_SLIDER:
        v->compare.slider = e->x;
        view_want(v, 2);
        return true;
    case VIEW_REPORT:
        return view_write_report(v, e->text);
    case VIEW_TRACE:
        return view_save_trace(v, e->text);
    default: {
        bool wants_frame;
        return view_feed(v, e, &wants_frame) && (!wants_frame || view_draw_frame(v, 1.0 / 60));
    }
    }
}

bool view_replay(struct view *v, const char *path, uint32_t exit_after) {
    enum { BYTES_MOST = 1 << 28 };
    const bool is_stdin = strcmp(path, "-") == 0;
    FILE *file = is_stdin ? stdin : input_open(path, BYTES_MOST);
    if (!file) return false;
    struct view_event event;
    bool good = settle(v), bad = false;
    for (uint32_t line = 1; good && !v->quit && view_event_read(path, line, file, &event, &bad); line++) {
        if (event.kind != VIEW_EVENT_COUNT) good = replay_event(v, &event);
        if (exit_after && v->frames_drawn >= exit_after) break;
    }
    if (!is_stdin) fclose(file);
    return good && !bad;
}
