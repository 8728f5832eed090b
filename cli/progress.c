/* SPDX-License-Identifier: MIT */
#include "progress.h"

#include "print.h"

#include <math.h>
#include <pthread.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <sys/ioctl.h>
#include <time.h>
#include <unistd.h>

static const double TERMINAL_SECONDS = 0.2;

static struct {
    pthread_mutex_t lock;
    pthread_cond_t wake;
    pthread_t thread;
    bool running, stop, terminal;
    char what[256];
    uint32_t done, total;
    double left;                        /* seconds from the last step on, as progress_tell() had it; NAN: as long as the steps so far; negative: not known */
    double period;                      /* seconds between lines */
    double begun, stage, step, printed; /* times: of progress_begin, of this `what`, of its last step, of the last line */
} p = {.lock = PTHREAD_MUTEX_INITIALIZER};

static double now(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void format_seconds(double seconds, char *text, size_t capacity) {
    unsigned long s = seconds < 1e9 ? (unsigned long)seconds : 0;
    if (s >= 3600)
        snprintf(text, capacity, "%lu:%02lu:%02lu", s / 3600, s / 60 % 60, s % 60);
    else if (s >= 100)
        snprintf(text, capacity, "%lu:%02lu", s / 60, s % 60);
    else
        snprintf(text, capacity, "%lu s", s);
}

double progress_estimate(uint32_t done, uint32_t total, double spent, double current) {
    return done > 0 && done < total ? fmax(spent / done * (total - done) - current, 0) : -1;
}

void progress_format(char *text, size_t capacity, const char *what, uint32_t done, uint32_t total, double elapsed, double left) {
    char gone[32], rest[32], end[128];
    int used = 0;
    format_seconds(floor(elapsed), gone, sizeof gone);
    format_seconds(ceil(fmax(left, 0)), rest, sizeof rest);
    if (total > 1) used = snprintf(end, sizeof end, " %u/%u", done, total);
    used += snprintf(end + used, sizeof end - (size_t)used, left >= 0 ? ", %s, about %s left" : ", %s", gone, rest);
    int room = (int)capacity - 1 - used;
    snprintf(text, capacity, "%.*s%s", room > 0 ? room : 0, what, end);
}

/* The cursor waits at the start of the line, so that a message takes the line's place. */
static void print(void) {
    char text[400];
    size_t capacity = sizeof text;
    struct winsize window;
    double time = now(), left = isnan(p.left) ? progress_estimate(p.done, p.total, p.step - p.stage, time - p.step)
                                : p.left < 0  ? -1
                                              : fmax(p.left - (time - p.step), 0);
    if (p.terminal && ioctl(STDERR_FILENO, TIOCGWINSZ, &window) == 0 && window.ws_col > 0 && window.ws_col < capacity)
        capacity = window.ws_col; /* a line that is broken could not be rewritten */
    progress_format(text, capacity, p.what, p.done, p.total, time - p.begun, left);
    fprintf(stderr, p.terminal ? "\r\033[K%s\r" : "fanal: %s\n", text);
    fflush(stderr);
    p.printed = time;
}

static void *tick(void *unused) {
    (void)unused;
    pthread_mutex_lock(&p.lock);
    while (!p.stop) {
        double due = p.printed + p.period;
        if (now() >= due && *p.what) print();
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
    *p.what = 0;
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

static void show(const char *what, uint32_t done, uint32_t total, double left) {
    pthread_mutex_lock(&p.lock);
    p.step = now();
    const bool begins = strcmp(p.what, what) != 0;
    if (begins) p.stage = p.step;
    snprintf(p.what, sizeof p.what, "%s", what);
    p.done = done;
    p.total = total;
    p.left = left;
    if (begins && p.terminal) print(); /* however short it is */
    pthread_mutex_unlock(&p.lock);
}

void progress_show(const char *what, uint32_t done, uint32_t total) {
    if (p.running) show(what, done, total, NAN);
}

void progress_tell(double left, const char *format, ...) {
    char what[sizeof p.what];
    if (!p.running) return;
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(what, sizeof what, format, arguments);
    va_end(arguments);
    show(what, 0, 0, left);
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
