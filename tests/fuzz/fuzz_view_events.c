/* SPDX-License-Identifier: MIT */
/* Recordings of `fanal view`: whatever the lines, an error, or an event that is written as a line that says the same. */
#include "cli/view/view.h"
#include "tests/fuzz/fuzz.h"

static void check_event(const struct view_event *e) {
    char line[VIEW_LINE];
    FILE *file = fmemopen(line, sizeof line, "w");
    struct view_event again;
    if (!file) abort();
    view_event_write(file, e);
    if (fclose(file) != 0 || !view_event_parse("again", 1, line, &again)) abort();
    if (again.kind != e->kind || again.x != e->x || again.y != e->y || again.code != e->code || again.down != e->down) abort();
    if (again.modifiers != e->modifiers || strcmp(again.text, e->text) != 0) abort();
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size) {
    struct view_event event;
    bool bad;
    FILE *file = size ? fmemopen((void *)(uintptr_t)bytes, size, "r") : NULL;
    for (uint32_t line = 1; file && view_event_read("input", line, file, &event, &bad); line++)
        if (event.kind != VIEW_EVENT_COUNT) check_event(&event);
    if (file) fclose(file);
    return 0;
}
