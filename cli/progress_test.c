/* SPDX-License-Identifier: MIT */
#include "progress.h"

#include <fcntl.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmocka.h>

static const char *line(const char *what, uint32_t done, uint32_t total, double elapsed, double spent, double current) {
    static char text[160];
    progress_format(text, sizeof text, what, done, total, elapsed, progress_estimate(done, total, spent, current));
    return text;
}

static void test_lines(void **state) {
    (void)state;
    assert_string_equal(line("loading", 0, 0, 2.9, 0, 2.9), "loading, 2 s");
    assert_string_equal(line("rendering", 0, 1, 7, 0, 5), "rendering, 7 s");
    assert_string_equal(line("rendering", 0, 10, 3, 0, 3), "rendering 0/10, 3 s");
    /* Three steps took 12 s, so seven take 28; one of those has been running for a second. */
    assert_string_equal(line("rendering", 3, 10, 20, 12, 1), "rendering 3/10, 20 s, about 27 s left");
    /* A step that takes longer than the others leaves less time, but never a negative one. */
    assert_string_equal(line("rendering", 9, 10, 100, 9, 50), "rendering 9/10, 1:40, about 0 s left");
    assert_string_equal(line("rendering", 10, 10, 100, 9, 0), "rendering 10/10, 1:40");
    assert_string_equal(line("rendering", 1, 100, 4000, 100, 0), "rendering 1/100, 1:06:40, about 2:45:00 left");
    /* A narrow terminal keeps the numbers. */
    char narrow[24];
    progress_format(narrow, sizeof narrow, "rendering everything there is", 0, 0, 3, 2);
    assert_string_equal(narrow, "re, 3 s, about 2 s left");
}

/* What a process prints that works for this long, away from a terminal. */
static void run(bool quiet, double seconds, char *text, size_t capacity) {
    int ends[2];
    assert_int_equal(pipe(ends), 0);
    pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        dup2(ends[1], STDERR_FILENO);
        progress_begin(quiet, 1);
        progress_show("working", 1, 4);
        usleep((useconds_t)(seconds * 1e6));
        progress_end();
        progress_end();
        _exit(0);
    }
    close(ends[1]);
    size_t length = 0;
    for (ssize_t got; (got = read(ends[0], text + length, capacity - 1 - length)) > 0;) length += (size_t)got;
    text[length] = 0;
    close(ends[0]);
    int status;
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_int_equal(status, 0);
}

/* Away from a terminal: nothing for what is short, then whole lines without control characters, though no step ends meanwhile. */
static void test_off_a_terminal(void **state) {
    (void)state;
    char text[1024];
    run(false, 0.2, text, sizeof text);
    assert_string_equal(text, "");
    run(false, 1.5, text, sizeof text);
    assert_ptr_equal(strstr(text, "fanal: working 1/4, "), text);
    assert_null(strpbrk(text, "\r\033"));
    assert_ptr_equal(strchr(text, '\n'), text + strlen(text) - 1); /* one line */
    run(true, 1.5, text, sizeof text);
    assert_string_equal(text, "");
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_lines), cmocka_unit_test(test_off_a_terminal)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
