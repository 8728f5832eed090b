/* SPDX-License-Identifier: MIT */
/** Reading values of options. On a bad value all print one line that names the option and what it takes, and return false. */
#ifndef FNL_CLI_ARGUMENTS_H
#define FNL_CLI_ARGUMENTS_H

#include "fanal/fanal.h"

/** Prints "--option: 'value' is not wanted"; returns false. */
bool argument_bad(const char *option, const char *value, const char *wanted);
/**
 * Each reads a number at `*at` and moves `*at` behind it; false prints nothing. Numbers begin with a digit, a point or a minus sign, and are finite: no
 * blanks, no plus sign, no hexadecimal, no "inf". A count has digits only.
 */
bool argument_take_number(const char **at, double *out);
bool argument_take_count(const char **at, uint64_t *out);
/** `count` numbers with commas between; the same. */
bool argument_take_numbers(const char **at, float *out, uint32_t count);
/** Up to `most` numbers of a line of a file, with blanks between; moves `*at` to what follows. Returns how many there are. */
uint32_t argument_take_row(const char **at, double *out, uint32_t most);
bool argument_integer(const char *option, const char *text, long long low, long long high, long long *out);
bool argument_number(const char *option, const char *text, double *out);
/** Bytes: "65536", "512K", "300M", "4G". */
bool argument_bytes(const char *option, const char *text, uint64_t *out);
/** Three numbers: "1,2.5,-3". */
bool argument_vector(const char *option, const char *text, fnl_vec3 *out);
/** Three numbers in doubles: a place (origin.h). */
bool argument_place(const char *option, const char *text, double out[3]);
bool argument_take_place(const char **at, double out[3]);
/** "1280x720". */
bool argument_size(const char *option, const char *text, uint32_t *out_width, uint32_t *out_height);
/** Index of `text` among the names that `name_of` gives for 0, 1, 2 … until NULL. */
bool argument_name(const char *option, const char *text, const char *(*name_of)(int), int *out);
/** "point,spot,box" or, with shares, "point=3,spot=1": which lights are scattered; kinds that are not named get none. */
bool argument_light_shapes(const char *option, const char *text, fnl_scatter_params *out);
/** "auto", "none", or an EV100 from -64 to 64. */
bool argument_exposure(const char *option, const char *text, fnl_exposure *out, float *out_ev);

/** --device INDEX|NAME; NULL: any. */
void argument_device(const char *value, fnl_device_params *out);

#endif
