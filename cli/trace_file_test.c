/* SPDX-License-Identifier: MIT */
/* The history of frames, and the file that it is written to. */
#include "trace_file.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>
#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static const fnl_cpu_section sections[] = {{"update", 0, 1}, {"submit", 1, 0.5}};

/* A frame with a pass on each queue, of so many milliseconds. */
static fnl_frame_stats make_stats(fnl_pass_time passes[2], const char *first, double milliseconds) {
    passes[0] = (fnl_pass_time){first, milliseconds, 0, FNL_QUEUE_GRAPHICS, FNL_PASS_SHADOWS};
    passes[1] = (fnl_pass_time){"beside", milliseconds / 2, milliseconds / 4, FNL_QUEUE_COMPUTE, FNL_PASS_LISTS};
    return (fnl_frame_stats){.pass_count = 2,
                             .passes = passes,
                             .gpu_milliseconds = 1.5 * milliseconds,
                             .cpu_section_count = 2,
                             .cpu_sections = sections,
                             .lights_in_view = 7,
                             .device_bytes = 1000000};
}

static void note(struct trace_history *h, const char *first, double milliseconds) {
    fnl_pass_time passes[2];
    const fnl_frame_stats stats = make_stats(passes, first, milliseconds);
    trace_mark(h, "panels");
    const double called = trace_now();
    trace_mark(h, "render");
    trace_end_frame(h, &stats, called);
}

static void test_a_frame_is_kept_as_it_was(void **state) {
    (void)state;
    struct trace_history *h = trace_create();
    assert_int_equal(trace_count(h), 0);
    assert_null(trace_find(h, 0));
    note(h, "gbuffer", 4);
    const struct trace_frame *frame = trace_find(h, 0);
    static const struct {
        const char *name;
        enum trace_lane lane;
        double milliseconds;
    } spans[] = {{"gbuffer", TRACE_GRAPHICS, 4}, {"beside", TRACE_COMPUTE, 2}, {"update", TRACE_LIBRARY, 1}, {"submit", TRACE_LIBRARY, 0.5}, {"panels", TRACE_PROGRAM, -1},
                 {"render", TRACE_PROGRAM, -1}};
    assert_int_equal(frame->span_count, 6);
    for (uint32_t i = 0; i < 6; i++) {
        assert_string_equal(trace_name(h, frame->spans[i].name), spans[i].name);
        assert_int_equal(frame->spans[i].lane, spans[i].lane);
        assert_int_equal(frame->spans[i].role, i == 0 ? FNL_PASS_SHADOWS : i == 1 ? FNL_PASS_LISTS : FNL_PASS_REST);
        if (spans[i].milliseconds >= 0) assert_true(frame->spans[i].milliseconds == spans[i].milliseconds);
    }
    assert_true(frame->spans[1].begin == 1 && frame->gpu_milliseconds == 6);
    assert_true(fabs(frame->passes_begin - (frame->spans[3].begin)) < 1e-9); /* when it was submitted */
    assert_true(frame->spans[5].begin >= frame->spans[4].begin + frame->spans[4].milliseconds - 1e-9);

    /* A frame that does not count leaves nothing to the next one. */
    trace_mark(h, "lost");
    trace_end_frame(h, NULL, 0);
    assert_int_equal(trace_count(h), 1);
    note(h, "gbuffer", 1);
    assert_int_equal(trace_find(h, 0)->span_count, 6);
    assert_int_equal(trace_find(h, 0)->number, 1);
    for (int i = 0; i < 100; i++) trace_mark(h, "too many");
    note(h, "gbuffer", 1);
    assert_true(trace_find(h, 0)->span_count < 60);
    trace_destroy(&h);
    assert_null(h);
    trace_destroy(&h);
}

static void test_the_history_does_not_grow(void **state) {
    (void)state;
    struct trace_history *h = trace_create();
    for (int i = 0; i < TRACE_FRAMES + 10; i++) note(h, "gbuffer", i);
    assert_int_equal(trace_count(h), TRACE_FRAMES);
    assert_int_equal(trace_find(h, 0)->number, TRACE_FRAMES + 9);
    assert_int_equal(trace_find(h, TRACE_FRAMES - 1)->number, 10);
    assert_null(trace_find(h, TRACE_FRAMES));
    assert_true(trace_find(h, 3)->spans[0].milliseconds == TRACE_FRAMES + 6);
    /* More names than there is room for: all is forgotten but the last frame, whose names are right. */
    assert_int_equal(trace_generation(h), 0);
    for (int i = 0; i < TRACE_NAMES + 5; i++) {
        char name[32];
        snprintf(name, sizeof name, "pass %d", i);
        note(h, name, 1);
        assert_string_equal(trace_name(h, trace_find(h, 0)->spans[0].name), name);
    }
    assert_int_equal(trace_generation(h), 1);
    assert_true(trace_count(h) < 20);
    /* A frame with more passes than fit keeps those that do. */
    static fnl_pass_time passes[TRACE_SPANS + 100];
    for (int i = 0; i < TRACE_SPANS + 100; i++) passes[i] = (fnl_pass_time){"one of many", 1, i, FNL_QUEUE_GRAPHICS, FNL_PASS_REST};
    trace_end_frame(h, &(fnl_frame_stats){.pass_count = TRACE_SPANS + 100, .passes = passes}, trace_now());
    assert_int_equal(trace_find(h, 0)->span_count, TRACE_SPANS);
    trace_destroy(&h);
}

static void test_nobody_wants_a_history(void **state) {
    (void)state;
    struct trace_history *none = NULL;
    trace_mark(none, "a");
    trace_end_frame(none, NULL, 0);
    assert_int_equal(trace_count(none), 0);
    assert_null(trace_find(none, 0));
    assert_string_equal(trace_name(none, 0), "");
    trace_destroy(&none);
}

/* Names with all that JSON knows, times that follow one another without a gap. */
static void test_the_file(void **state) {
    (void)state;
    static const char odd[] = "a \"b\" \\ c\n\x01 \xc3\xa4";
    char path[] = "/tmp/fanal-trace-XXXXXX";
    close(mkstemp(path));
    struct trace_history *h = trace_create();
    assert_true(trace_save(h, path)); /* of no frame */
    json_t *root = json_load_file(path, 0, NULL), *event;
    assert_non_null(root);
    json_decref(root);
    for (int i = 0; i < 3; i++) note(h, odd, 0.1 + i / 3.0);
    assert_true(trace_save(h, path));
    json_error_t error;
    root = json_load_file(path, JSON_REJECT_DUPLICATES, &error);
    if (!root) fail_msg("line %d: %s", error.line, error.text);
    size_t i;
    int odd_count = 0;
    double last = -1;
    json_array_foreach(json_object_get(root, "traceEvents"), i, event) {
        if (strcmp(json_string_value(json_object_get(event, "name")), odd) != 0) continue;
        const double begin = json_number_value(json_object_get(event, "ts")), length = json_number_value(json_object_get(event, "dur"));
        assert_true(fabs(length - (0.1 + odd_count / 3.0) * 1000) < 1e-3); /* microseconds */
        assert_true(begin >= last - 1e-6);
        last = begin + length;
        odd_count++;
    }
    assert_int_equal(odd_count, 3);
    json_decref(root);
    assert_false(trace_save(h, "/tmp/no-such-folder-of-fanal/a.json"));
    unlink(path);
    trace_destroy(&h);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_a_frame_is_kept_as_it_was), cmocka_unit_test(test_the_history_does_not_grow),
                                       cmocka_unit_test(test_nobody_wants_a_history), cmocka_unit_test(test_the_file)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
