/* SPDX-License-Identifier: MIT */
#include "base/number.h"

#include <locale.h>
#include <stdio.h>
#include <stdlib.h>

/* The C locale is part of the C library: making it allocates nothing and does not fail. */
static locale_t plain_locale(void) { return newlocale(LC_ALL_MASK, "C", (locale_t)0); }

double number_read(const char *text, char **end) {
    const locale_t plain = plain_locale();
    const double value = strtod_l(text, end, plain);
    freelocale(plain);
    return value;
}

int text_format_list(char *text, size_t capacity, const char *format, va_list arguments) {
    const locale_t plain = plain_locale(), before = uselocale(plain);
    const int length = vsnprintf(text, capacity, format, arguments);
    uselocale(before);
    freelocale(plain);
    return length;
}

int text_format(char *text, size_t capacity, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    const int length = text_format_list(text, capacity, format, arguments);
    va_end(arguments);
    return length;
}
