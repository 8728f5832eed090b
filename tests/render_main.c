/* SPDX-License-Identifier: MIT */
#include "tests/render_harness.h"
#include "tests/render_parts.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

static double seconds(clockid_t clock) {
    struct timespec t;
    clock_gettime(clock, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* Quick runs leave out what is slow. */
static bool is_skipped(const char *part) {
    const char *names = getenv("FANAL_SKIP");
    size_t length = strlen(part);
    for (const char *at = names ? strstr(names, part) : NULL; at; at = strstr(at + 1, part))
        if ((at == names || at[-1] == ' ') && (at[length] == ' ' || !at[length])) return true;
    return false;
}

/* Pipelines stay as long as the device does. On machines with little memory parts begin anew rather than run out of it. */
static bool is_large(void) {
    long pages = 0;
    FILE *file = fopen("/proc/self/statm", "r");
    if (!file) return false;
    bool known = fscanf(file, "%*s %ld", &pages) == 1;
    fclose(file);
    return known && (double)pages * (double)sysconf(_SC_PAGESIZE) > 3e9;
}

static int run(const struct render_part *part, const char *filter) {
    if (is_skipped(part->name)) return 0;
    double start = seconds(CLOCK_MONOTONIC), processor = seconds(CLOCK_PROCESS_CPUTIME_ID);
    cmocka_set_test_filter(filter);
    int failed = part->run();
    printf("== %s: %d failed, %.1f s (%.1f s of processors)\n", part->name, failed, seconds(CLOCK_MONOTONIC) - start,
           seconds(CLOCK_PROCESS_CPUTIME_ID) - processor);
    fflush(stdout);
    if (is_large()) failed += !harness_finish();
    return failed;
}

int main(int count, char **arguments) {
    int failed = 0;
    harness_share_device();
    for (size_t i = 0; count == 1 && i < render_part_count; i++) failed += run(&render_parts[i], NULL);
    for (int a = 1; a < count; a++) {
        const char *colon = strchr(arguments[a], ':');
        size_t length = colon ? (size_t)(colon - arguments[a]) : strlen(arguments[a]), i = 0;
        while (i < render_part_count &&
               (strncmp(render_parts[i].name, arguments[a], length) != 0 || render_parts[i].name[length]))
            i++;
        if (i == render_part_count) {
            fprintf(stderr, "%s: there is no part %.*s. Parts:", arguments[0], (int)length, arguments[a]);
            for (i = 0; i < render_part_count; i++) fprintf(stderr, " %s", render_parts[i].name);
            fprintf(stderr, "\n");
            return 2;
        }
        failed += run(&render_parts[i], colon ? colon + 1 : NULL);
    }
    failed += !harness_finish();
    return failed > 0;
}
