/* SPDX-License-Identifier: MIT */
/* Events wait in a queue, and stand in a file a line each. */
#include "view/view.h"

#include "print.h"

#include <math.h>
#include <string.h>

bool view_queue_add(struct view_queue *q, const struct view_event *event) {
    if (q->count > 0) { /* of two movements in a row the last counts */
        struct view_event *last = &q->events[(q->first + q->count - 1) % VIEW_QUEUE];
        if (last->kind == event->kind && (event->kind == VIEW_MOVE || event->kind == VIEW_SIZE)) {
            *last = *event;
            return true;
        }
    }
    if (q->count == VIEW_QUEUE) return false;
    q->events[(q->first + q->count++) % VIEW_QUEUE] = *event;
    return true;
}

bool view_queue_take(struct view_queue *q, struct view_event *out) {
    if (q->count == 0) return false;
    *out = q->events[q->first];
    q->first = (q->first + 1) % VIEW_QUEUE;
    q->count--;
    return true;
}

static const struct {
    const char *name;
    enum { PLACE, PRESS, NUMBER, AXIS, FACTOR, TEXT, ALONE } takes;
} lines[VIEW_EVENT_COUNT] = {[VIEW_MOVE] = {"move", PLACE},       [VIEW_BUTTON] = {"button", PRESS},  [VIEW_WHEEL] = {"wheel", PLACE},
                             [VIEW_KEY] = {"key", PRESS},         [VIEW_CHARACTER] = {"character", NUMBER}, [VIEW_SIZE] = {"size", PLACE},
                             [VIEW_SCALE] = {"scale", FACTOR},     [VIEW_PAD] = {"pad", AXIS},        [VIEW_PAD_BUTTON] = {"padbutton", PRESS},
                             [VIEW_DROP] = {"drop", TEXT},        [VIEW_CLOSE] = {"close", ALONE},    [VIEW_FRAMES] = {"frames", NUMBER},
                             [VIEW_SETTLE] = {"settle", ALONE},   [VIEW_SET] = {"set", TEXT},            [VIEW_CLICK] = {"click", TEXT},
                             [VIEW_SAVE] = {"save", TEXT},       [VIEW_CAPTURE] = {"capture", TEXT},
                             [VIEW_COMPARE] = {"compare", TEXT},  [VIEW_SET_B] = {"setb", TEXT},      [VIEW_SLIDER] = {"slider", FACTOR},
                             [VIEW_COMMAND] = {"command", TEXT},  [VIEW_REPORT] = {"report", TEXT},   [VIEW_TRACE] = {"trace", TEXT},
                             [VIEW_SAVE_SCENE] = {"savescene", TEXT}, [VIEW_TURNTABLE] = {"turntable", NUMBER}, [VIEW_PANEL] = {"panel", TEXT},
                             [VIEW_POLL] = {"poll", ALONE}};

bool view_event_read(const char *path, uint32_t line, FILE *file, struct view_event *out, bool *bad) {
    char text[VIEW_LINE];
    *bad = false;
    if (!fgets(text, sizeof text, file)) return false;
    if (strlen(text) == sizeof text - 1 && !strchr(text, '\n')) {
        fprintf(stderr, "fanal: error: %s:%u: the line has more than %zu bytes\n", path, line, sizeof text - 2);
        *bad = true;
        return false;
    }
    *bad = !view_event_parse(path, line, text, out);
    return !*bad;
}

bool view_event_parse(const char *path, uint32_t line, const char *text, struct view_event *out) {
    char name[16] = "", state[8] = "", rest[1024] = "";
    int kind = 0, read = 0;
    *out = (struct view_event){.kind = VIEW_EVENT_COUNT};
    if (sscanf(text, " %15s %n", name, &read) < 1 || name[0] == '#') return true;
    while (kind < VIEW_EVENT_COUNT && strcmp(lines[kind].name, name) != 0) kind++;
    bool good = kind < VIEW_EVENT_COUNT;
    if (good) {
        const char *arguments = text + read;
        switch (lines[kind].takes) {
        case PLACE:
            good = sscanf(arguments, "%f %f %1s", &out->x, &out->y, rest) == 2 && isfinite(out->x) && isfinite(out->y);
            break;
        case PRESS:
            good = sscanf(arguments, "%d %7s %u %1s", &out->code, state, &out->modifiers, rest) == 3 && (!strcmp(state, "down") || !strcmp(state, "up"));
            out->down = strcmp(state, "down") == 0;
            break;
        case AXIS:
            good = sscanf(arguments, "%d %f %1s", &out->code, &out->x, rest) == 2;
            break;
        case NUMBER:
            good = sscanf(arguments, "%d %1s", &out->code, rest) == 1;
            break;
        case TEXT:
            good = strcspn(arguments, "\n") < sizeof out->text && sscanf(arguments, "%1023[^\n]", out->text) == 1;
            break;
        case FACTOR:
            good = sscanf(arguments, "%f %1s", &out->x, rest) == 1;
            break;
        case ALONE:
            good = sscanf(arguments, "%1s", rest) < 1;
            break;
        }
    }
    if (good && (kind == VIEW_SIZE || kind == VIEW_FRAMES))
        good = kind == VIEW_SIZE ? out->x >= 0 && out->x <= 16384 && out->y >= 0 && out->y <= 16384 : out->code >= 0 && out->code <= 100000;
    if (good && kind == VIEW_SLIDER) good = out->x >= 0 && out->x <= 1;
    if (good && kind == VIEW_SCALE) good = out->x >= 0.5f && out->x <= 4;
    if (good && kind == VIEW_PAD) good = out->code >= 0 && out->code < 6 && out->x >= -1 && out->x <= 1;
    if (good && kind == VIEW_TURNTABLE) good = out->code >= 1 && out->code <= 3600;
    if (good && kind == VIEW_KEY) good = out->code >= 0 && out->code < 512;
    if (!good) {
        fprintf(stderr, "fanal: error: %s:%u: not an event: %.*s\n", path, line, (int)strcspn(text, "\n") < 100 ? (int)strcspn(text, "\n") : 100, text);
        return false;
    }
    out->kind = (enum view_event_kind)kind;
    return true;
}

void view_event_write(FILE *file, const struct view_event *e) {
    fprintf(file, "%s", lines[e->kind].name);
    switch (lines[e->kind].takes) {
    case PLACE:
        fprintf(file, " %.9g %.9g", (double)e->x, (double)e->y);
        break;
    case PRESS:
        fprintf(file, " %d %s %u", e->code, e->down ? "down" : "up", e->modifiers);
        break;
    case AXIS:
        fprintf(file, " %d %.9g", e->code, (double)e->x);
        break;
    case NUMBER:
        fprintf(file, " %d", e->code);
        break;
    case FACTOR:
        fprintf(file, " %.9g", (double)e->x);
        break;
    case TEXT:
        fputc(' ', file);
        fwrite(e->text, 1, strcspn(e->text, "\n"), file); /* as it is: it is read again */
        break;
    case ALONE:
        break;
    }
    fputc('\n', file);
}
