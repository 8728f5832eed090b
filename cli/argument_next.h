/* SPDX-License-Identifier: MIT */
/** Going through the options of a command. */
#ifndef FNL_CLI_ARGUMENT_NEXT_H
#define FNL_CLI_ARGUMENT_NEXT_H

#include <getopt.h>

/** getopt_long(); but where an option's value is the next word and that is an option as well (--stats -q), it says so and returns '?'. A name
 * that begins with a hyphen can be given as --stats=-q. */
int argument_next(int argc, char **argv, const char *letters, const struct option *options);

#endif
