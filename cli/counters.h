/* SPDX-License-Identifier: MIT */
/** The numbers of techniques: none of them is known here by name, but to the suites that evaluate one. */
#ifndef FNL_CLI_COUNTERS_H
#define FNL_CLI_COUNTERS_H

#include "options.h"

/** Prints all counters: for people, for programs, or as docs/counters.md. */
void counters_print(enum options_form form);
/** The numbers that a frame has, with a line about each. */
void counters_print_table(const fnl_frame_stats *stats);

/** Sets "coarse.by-depth" as by_depth of the object coarse, for every counter: null where the frame does not have it, and for an object without any. */
void counters_set_groups(json_t *object, const fnl_frame_stats *stats);
/** The numbers that the frame has, by their keys. */
json_t *counters_json(const fnl_frame_stats *stats);

/** The number with a key; 0 where the frame does not have it. */
uint64_t counters_value(const fnl_frame_stats *stats, const char *key);
/** How much found no room in the frame and its views, so that the next one may be better. */
uint64_t counters_overflow(const fnl_frame_stats *stats);

#endif
