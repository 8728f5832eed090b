/* SPDX-License-Identifier: MIT */
/** Numbers as text, the same in every locale: after setlocale the functions of C read and write the decimal point of that locale. */
#ifndef FNL_BASE_NUMBER_H
#define FNL_BASE_NUMBER_H

#include <stdarg.h>
#include <stddef.h>

/** As strtod in the C locale. */
double number_read(const char *text, char **end);
/** As snprintf and vsnprintf in the C locale. */
int text_format(char *text, size_t capacity, const char *format, ...) __attribute__((format(printf, 3, 4)));
int text_format_list(char *text, size_t capacity, const char *format, va_list arguments) __attribute__((format(printf, 3, 0)));

#endif
