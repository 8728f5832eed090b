/* SPDX-License-Identifier: MIT */
/* The arguments of `fanal render`, one in a line: an error, or settings within their ranges. */
#define render_run fuzz_render_run /* which checks and does not render */
#include "cli/render.c"
#undef render_run
#include "cli/program.h"
#include "tests/fuzz/fuzz.h"
#include "../frame_plain.h"

const char program_commit[] = "";

static bool finite3(fnl_vec3 v) { return isfinite(v.x) && isfinite(v.y) && isfinite(v.z); }

int fuzz_render_run(const struct render_options *o) {
    if (!o->world.scene || o->output_count > RENDER_MAX_OUTPUTS) abort();
    if (o->frame.width < 1 || o->frame.width > 16384 || o->frame.height < 1 || o->frame.height > 16384) abort();
    fnl_option option;
    for (uint32_t i = 0; fnl_option_query(i, &option); i++) { /* what is set can be said, and is in its range */
        fnl_frame frame = frame_plain();
        char text[64];
        if (fnl_frame_get(&o->frame, option.key, text, sizeof text) >= sizeof text) abort();
        if (fnl_frame_set(NULL, &frame, option.key, text) != FNL_OK) abort();
    }
    for (int i = 0; i < 3; i++)
        if (!isfinite(o->world.eye[i]) || !isfinite(o->world.look_at[i])) abort();
    if (!finite3(o->world.ambient) || !finite3(o->world.background)) abort();
    if (!isfinite(o->world.time) || !isfinite(o->world.fov) || !isfinite(o->frame.ev) || !isfinite(o->frame_time)) abort();
    for (int i = 0; i < FNL_LIGHT_KIND_COUNT; i++)
        if (!(o->world.scatter.shares[i] >= 0) || isinf(o->world.scatter.shares[i])) abort();
    return 0;
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size) {
    char text[2048], *arguments[64] = {"render"}, *rest = text;
    int count = 1;
    if (size >= sizeof text || memmem(bytes, size, "help", 4)) return 0; /* which ends the program */
    memcpy(text, bytes, size);
    text[size] = 0;
    for (char *line; count < 63 && (line = strsep(&rest, "\n"));) arguments[count++] = line;
    command_render(count, arguments);
    return 0;
}
