/* SPDX-License-Identifier: MIT */
/** Going through the options of a command. */
#ifndef FNL_CLI_ARGUMENT_NEXT_H
#define FNL_CLI_ARGUMENT_NEXT_H

#include <getopt.h>

/** getopt_long(), but an option whose value was forgotten does not swallow the next one: for --stats -q it prints an error and returns '?'.
 * A value that looks like an option can be given as --stats=-q. An empty value is an error. */
int argument_next(int argc, char **argv, const char *letters, const struct option *options);

#endif
