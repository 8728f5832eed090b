/* SPDX-License-Identifier: MIT */
/*
 * check_trace FILE [NAME…]: whether a trace of `fanal render --trace-file` or of `fanal view` is what it should be: nothing in a lane overlaps or goes
 * back, everything lies in the time of its frame or after its beginning, passes begin when the frame is submitted, and add up to what the frame says. Each NAME
 * is the name of some event. Prints the number of frames.
 */
#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

enum { LANES = 6 };

static int fail(size_t event, const char *problem) {
    fprintf(stderr, "check_trace: event %zu: %s\n", event, problem);
    return 1;
}

int main(int argc, char **argv) {
    json_error_t error = {.line = 0};
    json_t *root = argc > 1 ? json_load_file(argv[1], JSON_REJECT_DUPLICATES, &error) : NULL, *event;
    if (!root) {
        fprintf(stderr, "check_trace: %s:%d: %s\n", argc > 1 ? argv[1] : "no file", error.line, error.text);
        return 2;
    }
    const json_t *events = json_object_get(root, "traceEvents");
    double ends[LANES] = {0}, frame_begin = 0, first_pass = -1, wanted = -1, sum = 0, counted = -1;
    int frames = 0, failures = json_array_size(events) == 0, counters = 0, spans[LANES] = {0};
    char seen[64] = {0};
    size_t i;
    json_array_foreach(events, i, event) {
        const char *name = json_string_value(json_object_get(event, "name")), *kind = json_string_value(json_object_get(event, "ph"));
        if (!name || !kind || !json_is_integer(json_object_get(event, "pid"))) return fail(i, "no name, ph or pid");
        for (int k = 2; k < argc && k < 64; k++) seen[k] |= strcmp(argv[k], name) == 0;
        if (strcmp(kind, "M") == 0) continue;
        const double begin = json_number_value(json_object_get(event, "ts"));
        if (!json_is_number(json_object_get(event, "ts")) || begin < 0) return fail(i, "no ts");
        if (strcmp(kind, "C") == 0) {
            if (begin < counted) failures += fail(i, "a counter goes back in time");
            if (json_object_size(json_object_get(event, "args")) != 1) failures += fail(i, "a counter without a value");
            counted = begin;
            counters++;
            continue;
        }
        const int lane = (int)json_integer_value(json_object_get(event, "tid"));
        const double length = json_number_value(json_object_get(event, "dur"));
        if (strcmp(kind, "X") != 0 || lane < 1 || lane >= LANES || !json_is_number(json_object_get(event, "dur")) || length < 0)
            return fail(i, "no span of a known lane");
        if (begin < ends[lane] - 5e-4) failures += fail(i, "overlaps the one before in its lane");
        if (begin < frame_begin - 5e-4) failures += fail(i, "begins before its frame");
        ends[lane] = begin + length;
        spans[lane]++;
        if (lane == 1) {
            if (wanted >= 0 && fabs(sum - wanted) > 1e-3) failures += fail(i, "the passes of the frame before do not add up");
            wanted = json_number_value(json_object_get(json_object_get(event, "args"), "gpu_milliseconds"));
            sum = 0;
            frame_begin = begin;
            first_pass = -1;
            frames++;
        } else if (ends[lane] > ends[1] + 2000 && lane > 3) {
            failures += fail(i, "ends after its frame");
        }
        if (lane == 2 || lane == 3) {
            sum += length * 1e-3;
            first_pass = first_pass < 0 || begin < first_pass ? begin : first_pass;
        }
        if (lane == 4 && strcmp(name, "submit") == 0 && first_pass >= 0 && fabs(begin - first_pass) > 1) failures += fail(i, "the passes do not begin at it");
    }
    if (wanted >= 0 && fabs(sum - wanted) > 1e-3) failures += fail(i, "the passes of the last frame do not add up");
    if (frames > 0 && (spans[2] == 0 || spans[4] < 9 * frames || spans[5] == 0 || counters < 3 * frames)) failures += fail(i, "a lane or the counters are empty");
    for (int k = 2; k < argc && k < 64; k++)
        if (!seen[k]) {
            fprintf(stderr, "check_trace: %s: no event is called %s\n", argv[1], argv[k]);
            failures++;
        }
    printf("%d\n", frames);
    json_decref(root);
    return failures > 0;
}
