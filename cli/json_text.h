/* SPDX-License-Identifier: MIT */
/** JSON that the command writes: with names that are not UTF-8, and safe to print. */
#ifndef FNL_CLI_JSON_TEXT_H
#define FNL_CLI_JSON_TEXT_H

#include <jansson.h>
#include <stdbool.h>
#include <stdio.h>

/** A string of JSON. If `text` is not UTF-8, which JSON cannot hold, it is replaced as by fnl_text_clean(); NULL gives null. */
json_t *json_text(const char *text);

/**
 * json_dumps(), with control characters that JSON allows, such as DEL, C1 and those of the writing direction, as escapes: programs read the same string, and a
 * terminal is safe. To be freed; NULL if memory ran out.
 */
char *json_text_write(const json_t *json, size_t flags);
/** Prints the same with a line break to the standard output; false if that fails. */
bool json_text_print(const json_t *json, size_t flags);

#endif
