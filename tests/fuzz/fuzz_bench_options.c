/* SPDX-License-Identifier: MIT */
/* The arguments of `fanal bench`, one in a line: an error, or a plan whose candidates can all be applied to a frame. */
#include "cli/bench.c"
#include "tests/fuzz/fuzz.h"
#include "../frame_plain.h"

const char program_commit[] = "unknown"; /* of cli/program.h */

static void check_plan(const struct bench_plan *plan) {
    for (uint32_t i = 0; i < plan->case_count; i++) {
        const struct bench_case *c = &plan->cases[i];
        if (c->width < 1 || c->width > 16384 || c->height < 1 || c->height > 16384 || c->msaa < 1 || c->msaa > 8) abort();
        for (uint32_t k = 0; k < c->candidate_count; k++) {
            const struct bench_candidate *candidate = &c->candidates[k];
            fnl_frame frame = frame_plain();
            if (!fnl_shading_supports(candidate->shading, candidate->lists, 1)) abort();
            if (!bench_ways_apply("set", candidate->options, &frame)) abort();
        }
    }
}

/* As command_bench(), up to where scenes are loaded. */
static void plan_and_check(struct bench_options *o, const char *const *scenes, int scene_count) {
    uint64_t count = MAX(o->matrix.light_count, 1u) * MAX(o->matrix.size_count, 1u) * MAX(o->matrix.msaa_count, 1u) * (uint64_t)scene_count;
    bool matrix = !o->suite || bench_suite_kind_of(o->suite) == BENCH_SUITE_MATRIX;
    if (!check_options(o, scene_count) || (matrix && count * combination_count(&o->matrix) > 64)) return; /* more is slow, not different */
    struct bench_plan plan = {.skipped = json_array()};
    const struct bench_matrix *m = &o->matrix;
    uint32_t width = m->size_count ? m->sizes[0][0] : 0, height = m->size_count ? m->sizes[0][1] : 0, lights[64] = {0};
    if (matrix && !m->size_count) memcpy(o->matrix.sizes[o->matrix.size_count++], (uint32_t[2]){640, 360}, sizeof m->sizes[0]);
    if (matrix && !m->msaa_count) o->matrix.msaa[o->matrix.msaa_count++] = 1;
    if (matrix ? bench_plan_matrix(m, scenes, lights, scene_count, &plan) : bench_suite_plan(o->suite, width, height, &plan))
        check_plan(&plan);
    bench_plan_free(&plan);
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size) {
    char text[2048], *arguments[64] = {"bench"}, *rest = text;
    int count = 1;
    if (size >= sizeof text || memmem(bytes, size, "help", 4)) return 0; /* which ends the program */
    memcpy(text, bytes, size);
    text[size] = 0;
    for (char *line; count < 63 && (line = strsep(&rest, "\n"));) arguments[count++] = line;
    struct bench_options o = default_options();
    int early = read_arguments(&o, count, arguments);
    if (early < 0 && o.suite) early = read_over_suite(&o, count, arguments);
    if (early >= 0) return 0;
    plan_and_check(&o, (const char *const *)arguments + optind, count - optind);
    return 0;
}
