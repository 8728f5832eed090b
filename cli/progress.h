/* SPDX-License-Identifier: MIT */
/**
 * How far a command is, on stderr: one line that is rewritten on a terminal, elsewhere a new line every few seconds. What
 * takes less than that prints nothing there. One at a time.
 */
#ifndef FNL_CLI_PROGRESS_H
#define FNL_CLI_PROGRESS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { PROGRESS_SECONDS = 5 };
/** Starts the clock; with `quiet` nothing is ever printed. `line_seconds` lie between lines where there is no terminal: PROGRESS_SECONDS. */
void progress_begin(bool quiet, double line_seconds);
/** What is being done now, and how much of it is over; a total of 0 or 1 is shown without numbers. */
void progress_show(const char *what, uint32_t done, uint32_t total);
/** The same for what has its own idea of the seconds that are left; negative: not known. */
__attribute__((format(printf, 2, 3))) void progress_tell(double left, const char *format, ...);
/** Clears the terminal's line; nothing more is printed. May be called twice. */
void progress_end(void);
/** Seconds since progress_begin(), on a clock that only runs forward. */
double progress_seconds(void);

/** Seconds that `total - done` steps will take if `done` took `spent`, and the next one has been running for `current`; -1: none is done, or all are. */
double progress_estimate(uint32_t done, uint32_t total, double spent, double current);
/**
 * The line: "rendering 3/10, 12 s, about 28 s left". `elapsed` counts from progress_begin(); `left` below 0: not known. What does not fit into
 * `capacity` is cut from the end of `what`.
 */
void progress_format(char *text, size_t capacity, const char *what, uint32_t done, uint32_t total, double elapsed, double left);

#endif
