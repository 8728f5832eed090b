/* SPDX-License-Identifier: MIT */
/** The options of a frame on the command line: by key (--set), and the common ones by names of their own. */
#ifndef FNL_CLI_OPTIONS_H
#define FNL_CLI_OPTIONS_H

#include "fanal/fanal.h"

#include <getopt.h>
#include <jansson.h>

/** Options with a name of their own, such as "cull" for "culling"; NULL beyond the last. `key` may be NULL. */
const char *options_named(uint32_t index, const char **key);

enum { OPTIONS_NAMED = 512, OPTIONS_NAMED_MAX = 32 }; /* values of getopt_long: OPTIONS_NAMED and up */
/**
 * Writes the `count` long options of a command, those with names that it does not have itself, and the end: room for count +
 * OPTIONS_NAMED_MAX. `several`: each takes a list of values, else switches take none.
 */
void options_make_long(const struct option *own, int count, bool several, struct option *out);

/** Sets one; a wrong key or value prints a line that begins with --`option` and returns false. */
bool options_set(fnl_frame *frame, const char *option, const char *key, const char *value);
/** The same from "KEY=VALUE"; `key` (or NULL) becomes that of the option, which lives as long as the program. */
bool options_set_text(fnl_frame *frame, const char *option, const char *text, const char **key);

/** "8, 16, 32 or 64 pixels": what an option takes. */
void options_print_range(const fnl_option *option, char *text, size_t capacity);
/** Who uses an option or has a number: "coarse", "deferred, deferred-volumes"; of most, those that do not: "not low-res, inferred"; "": all. */
void options_print_users(uint32_t bits, fnl_enum type, char *text, size_t capacity);
/** The same as an array of names; null: all. */
json_t *options_users_json(uint32_t bits, fnl_enum type);
enum options_form { OPTIONS_TEXT, OPTIONS_JSON, OPTIONS_MARKDOWN };
/** Prints all options: for people, for programs, or as docs/options.md. */
void options_print(enum options_form form);
/** The value of each option by its key. */
json_t *options_json(const fnl_frame *frame);

/** Where the value given to an option is "help" and the option takes names: prints these, with a line about each if there is one, and returns true. */
bool options_print_values(const char *key, const char *value);

#endif
