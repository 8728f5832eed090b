/* SPDX-License-Identifier: MIT */
/** For tests: a locale with a decimal comma, wherever they run. It is a file of the GNU C library, written by hand: systems need not have one. */
#ifndef FNL_TESTS_COMMA_LOCALE_H
#define FNL_TESTS_COMMA_LOCALE_H

#include <locale.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/stat.h>

/** Makes the locale in a folder that exists, and the program's numbers use it: what setlocale(LC_ALL, "") of a toolkit does in Germany. */
static inline bool comma_locale_set(const char *folder) {
    static const struct {
        uint32_t magic, count, at[6];
        char point[2], separator[1], grouping[1];
        uint32_t wide_point, wide_separator;
        char codeset[6];
    } numbers = {0x20031115 ^ LC_NUMERIC, 6, {32, 34, 35, 36, 40, 44}, ",", "", "\177", ',', 0, "UTF-8"};
    char path[512];
    snprintf(path, sizeof path, "%s/comma", folder);
    mkdir(path, 0777);
    snprintf(path, sizeof path, "%s/comma/LC_NUMERIC", folder);
    FILE *file = fopen(path, "wb");
    if (!file || fwrite(&numbers, sizeof numbers, 1, file) != 1 || fclose(file) != 0 || setenv("LOCPATH", folder, 1) != 0) return false;
    return setlocale(LC_NUMERIC, "comma") && localeconv()->decimal_point[0] == ',';
}

#endif
