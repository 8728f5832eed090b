/* SPDX-License-Identifier: MIT */
#include "progress.h"

#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

static const double TERMINAL_SECONDS = 0.2;

static struct {
    pthread_mutex_t lock;
    pthread_cond_t wake;
    pthread_t thread;
    bool running, stop, terminal;
    const char *what;
    uint32_t done, total;
    double period;                      /* seconds between lines */
    double begun, stage, step, printed; /* times: of progress_begin, of this `what`, of its last step, of the last line */
} p = {.lock = PTHREAD_MUTEX_INITIALIZER};

static double now(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

void progress_format(char *text, size_t capacity, const char *what, uint32_t done, uint32_t total, double elapsed,
                     double spent, double current) {
    char count[32] = "", left[48] = "";
    if (total > 1) snprintf(count, sizeof count, " %u/%u", done, total);
    if (done > 0 && done < total)
        snprintf(left, sizeof left, ", about %.0f s left", ceil(fmax(spent / done * (total - done) - current, 0)));
    snprintf(text, capacity, "%s%s, %.0f s%s", what, count, floor(elapsed), left);
}

/* The cursor waits at the start of the line, so that a message takes the line's place. */
static void print(void) {
    char text[160];
    double time = now();
    progress_format(text, sizeof text, p.what, p.done, p.total, time - p.begun, p.step - p.stage, time - p.step);
    fprintf(stderr, p.terminal ? "\r\033[K%s\r" : "fanal: %s\n", text);
    fflush(stderr);
    p.printed = time;
}

static void *tick(void *unused) {
    (void)unused;
    pthread_mutex_lock(&p.lock);
    while (!p.stop) {
        double due = p.printed + p.period;
        if (now() >= due && p.what) print();
        struct timespec until;
        due = fmax(p.printed + p.period, now() + 0.05);
        until.tv_sec = (time_t)due;
        until.tv_nsec = (long)((due - floor(due)) * 1e9);
        pthread_cond_timedwait(&p.wake, &p.lock, &until);
    }
    pthread_mutex_unlock(&p.lock);
    return NULL;
}

void progress_begin(bool quiet, double line_seconds) {
    p.begun = p.stage = p.step = p.printed = now();
    p.what = NULL;
    p.stop = false;
    p.terminal = isatty(STDERR_FILENO);
    p.period = p.terminal ? TERMINAL_SECONDS : line_seconds;
    if (quiet) return;
    pthread_condattr_t attributes;
    pthread_condattr_init(&attributes);
    pthread_condattr_setclock(&attributes, CLOCK_MONOTONIC);
    pthread_cond_init(&p.wake, &attributes);
    pthread_condattr_destroy(&attributes);
    p.running = pthread_create(&p.thread, NULL, tick, NULL) == 0;
}

void progress_show(const char *what, uint32_t done, uint32_t total) {
    if (!p.running) return;
    pthread_mutex_lock(&p.lock);
    p.step = now();
    if (!p.what || strcmp(p.what, what) != 0) p.stage = p.step;
    p.what = what;
    p.done = done;
    p.total = total;
    pthread_mutex_unlock(&p.lock);
}

void progress_end(void) {
    if (!p.running) return;
    pthread_mutex_lock(&p.lock);
    p.stop = true;
    pthread_cond_signal(&p.wake);
    pthread_mutex_unlock(&p.lock);
    pthread_join(p.thread, NULL);
    pthread_cond_destroy(&p.wake);
    p.running = false;
    if (p.terminal) fputs("\r\033[K", stderr);
}

double progress_seconds(void) { return now() - p.begun; }
