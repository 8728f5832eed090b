/* SPDX-License-Identifier: MIT */
/* What a user sees while it measures, and what ends it early. */
#include "bench_lane.h"

#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <unistd.h>

/* ---- Ctrl-C and SIGTERM ---- */

static volatile sig_atomic_t interrupted;

static void note_interrupt(int signal_number) {
    (void)signal_number;
    interrupted = 1;
}

void bench_catch_interrupts(bool on) {
    struct sigaction action = {0};
    action.sa_handler = on ? note_interrupt : SIG_DFL;
    action.sa_flags = (int)SA_RESETHAND;
    sigemptyset(&action.sa_mask);
    sigaction(SIGINT, &action, NULL);
    sigaction(SIGTERM, &action, NULL);
}

bool bench_interrupted(void) { return interrupted; }

/* ---- progress ---- */

enum { BAR_WIDTH = 24 };
#define LINE_SECONDS 5.0 /* between two lines, off a terminal */

static struct {
    bool quiet, terminal;
    double started, told;
} progress = {.quiet = true};

static void format_seconds(double seconds, char *text, size_t capacity) {
    unsigned long s = seconds > 0 && seconds < 1e9 ? (unsigned long)(seconds + 0.5) : 0;
    if (s >= 3600)
        snprintf(text, capacity, "%lu:%02lu:%02lu", s / 3600, s / 60 % 60, s % 60);
    else
        snprintf(text, capacity, "%lu:%02lu", s / 60, s % 60);
}

void bench_progress_begin(bool quiet) {
    progress.quiet = quiet;
    progress.terminal = isatty(STDERR_FILENO);
    progress.started = progress.told = lane_now();
}

double bench_progress_elapsed(void) { return lane_now() - progress.started; }

void bench_progress_show(double left, const char *format, ...) {
    double now = lane_now(), elapsed = now - progress.started;
    if (progress.quiet || (!progress.terminal && now - progress.told < LINE_SECONDS)) return;
    char what[256], gone[32], rest[32] = "?";
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(what, sizeof what, format, arguments);
    va_end(arguments);
    format_seconds(elapsed, gone, sizeof gone);
    if (left >= 0) format_seconds(left, rest, sizeof rest);
    progress.told = now;
    if (!progress.terminal) {
        fprintf(stderr, "%s: %s; about %s left\n", gone, what, rest);
        return;
    }
    double part = left >= 0 && elapsed + left > 0 ? elapsed / (elapsed + left) : 0;
    fputs("\r[", stderr);
    for (int i = 0; i < BAR_WIDTH; i++) fputc(i < part * BAR_WIDTH ? '#' : '.', stderr);
    fprintf(stderr, "] %s left  %.70s\033[K", rest, what);
    fflush(stderr);
}

void bench_progress_clear(void) {
    if (!progress.quiet && progress.terminal) fputs("\r\033[K", stderr);
}
