/* SPDX-License-Identifier: MIT */
/* The arguments of `fanal render`, one in a line: an error, or settings within their ranges. */
#define render_run fuzz_render_run /* which checks and does not render */
#include "cli/render.c"
#undef render_run
#include "cli/program.h"
#include "tests/fuzz/fuzz.h"

const char program_commit[] = "";

static bool finite3(fnl_vec3 v) { return isfinite(v.x) && isfinite(v.y) && isfinite(v.z); }

int fuzz_render_run(const struct render_options *o) {
    const fnl_list_options *l = &o->frame.list_options;
    if (!o->scene || o->output_count > RENDER_MAX_OUTPUTS) abort();
    if (o->frame.width < 1 || o->frame.width > 16384 || o->frame.height < 1 || o->frame.height > 16384) abort();
    if (o->frame.shading > FNL_SHADING_AUTO || o->frame.lists > FNL_LISTS_AUTO || !fnl_debug_view_name(o->frame.debug)) abort();
    if (o->frame.msaa < 1 || o->frame.msaa > 8 || (o->frame.msaa & (o->frame.msaa - 1))) abort();
    if (l->tile_size < 8 || l->tile_size > 64 || (l->tile_size & (l->tile_size - 1)) || l->slices < 1) abort();
    if (!finite3(o->eye) || !finite3(o->look_at) || !finite3(o->ambient) || !finite3(o->background)) abort();
    if (!isfinite(o->time) || !isfinite(o->fov) || !isfinite(o->frame.ev) || !isfinite(o->frame_time)) abort();
    if (!isfinite(o->frame.mobile.range) || !isfinite(o->frame.coarse.depth_factor)) abort();
    for (int i = 0; i < FNL_LIGHT_KIND_COUNT; i++)
        if (!(o->scatter.shares[i] >= 0) || isinf(o->scatter.shares[i])) abort();
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
