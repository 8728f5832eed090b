/* SPDX-License-Identifier: MIT */
/**
 * printf() for text that comes from files, from arguments or from the environment. In a file that includes this, printf(), fprintf() and vfprintf() pass each
 * %s and %c through fnl_text_clean(), so that no name reaches a terminal's control functions or breaks a line; the format itself is printed as it is. Every file of
 * the command that prints includes it, and puts() and fputs() are for the command's own text (tools/check_layers.sh).
 */
#ifndef FNL_CLI_PRINT_H
#define FNL_CLI_PRINT_H

#include <stdarg.h>
#include <stdio.h>

/** fprintf() and vfprintf() with the conversions d i u x X o (with l, ll, z and j), e f g a, c, s and %. Written at once, as several threads may print. */
int print_to(FILE *out, const char *format, ...) __attribute__((format(printf, 2, 3)));
int print_list(FILE *out, const char *format, va_list arguments) __attribute__((format(printf, 2, 0)));

/**
 * A word that a shell reads as `text`: in quotes unless it is plain. If it has control characters or bytes that are not UTF-8, they become escapes of $'…'
 * (bash, zsh, ksh, POSIX.1-2024), so that nothing happens when the word is pasted. To be freed; NULL if memory ran out.
 */
char *print_shell_word(const char *text);

#define printf(...) print_to(stdout, __VA_ARGS__)
#define fprintf(...) print_to(__VA_ARGS__)
#define vfprintf(out, format, arguments) print_list(out, format, arguments)

#endif
