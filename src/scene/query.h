/* SPDX-License-Identifier: MIT */
/** Reads "NAME?key=value&key=value", which names built-in scenes and environments. */
#ifndef FNL_SCENE_QUERY_H
#define FNL_SCENE_QUERY_H

#include "base/base.h"

/** A key, and the range of its value; `decimal`: a fraction and a minus sign are allowed. */
struct query_key {
    const char *name;
    double low, high;
    bool decimal;
};

/**
 * Sets the values of the keys that `text` gives; the others keep theirs. `text` is what follows "builtin:", and `what` the name in it.
 * FNL_ERROR_INVALID for an unknown key or a bad value, with a line that names the allowed ones.
 */
fnl_result query_read(const fnl_host *host, const char *text, const char *what, const struct query_key *keys, uint32_t key_count, double *values);
/** How many characters of `text` are the name. */
size_t query_name_length(const char *text);

#endif
