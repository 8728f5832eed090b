/* SPDX-License-Identifier: MIT */
#include "print.h"

#include "fanal/base.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#undef printf
#undef fprintf
#undef vfprintf

/* ---- text that is printed ---- */

/* At most `most` bytes of a text, cleaned. A character that does not fit is left out as a whole. */
static char *cleaned(const char *text, size_t most) {
    if (!text) text = "(null)";
    size_t length = strnlen(text, most), lead = length;
    if (length == most && most > 0) { /* the last character may be cut */
        do lead--;
        while (lead > 0 && (unsigned char)text[lead] >> 6 == 2);
        const unsigned char first = (unsigned char)text[lead];
        if (lead + (first < 0xc0 ? 1 : first < 0xe0 ? 2 : first < 0xf0 ? 3 : 4) > length) length = lead;
    }
    char *copy = strndup(text, length);
    fnl_text_clean(copy);
    return copy;
}

static void print_text(FILE *out, const char *conversion, const char *text) {
    const char *precision = strchr(conversion, '.');
    char *copy = cleaned(text, precision ? (size_t)atoi(precision + 1) : SIZE_MAX);
    fprintf(out, conversion, copy ? copy : "");
    free(copy);
}

struct arguments {
    va_list list;
};

#define PRINT_INTEGER(type_int, type_long, type_long_long, type_size, type_max)                                             \
    (strcmp(size, "ll") == 0  ? fprintf(out, conversion, va_arg(a->list, type_long_long))                                   \
     : strcmp(size, "l") == 0 ? fprintf(out, conversion, va_arg(a->list, type_long))                                        \
     : strcmp(size, "z") == 0 ? fprintf(out, conversion, va_arg(a->list, type_size))                                        \
     : strcmp(size, "j") == 0 ? fprintf(out, conversion, va_arg(a->list, type_max))                                         \
                              : fprintf(out, conversion, va_arg(a->list, type_int)))

/* Prints the next argument as the conversion at `at` says; returns what follows that. */
static const char *print_argument(FILE *out, const char *at, struct arguments *a) {
    char conversion[64], size[3] = "";
    size_t length = 0;
    for (; strchr("%-+ #0123456789.*", *at) && length < 32; at++) {
        if (*at == '*') {
            const int number = va_arg(a->list, int);
            if (number < 0 && conversion[length - 1] == '.') length--; /* as if it was not there */
            else length += (size_t)snprintf(conversion + length, 16, "%d", number);
        } else {
            conversion[length++] = *at;
            if (*at == '%' && length > 1) { /* %% */
                fputc('%', out);
                return at + 1;
            }
        }
    }
    for (size_t i = 0; strchr("lzjh", *at) && i < 2; i++) conversion[length++] = size[i] = *at++;
    conversion[length] = *at;
    conversion[length + 1] = 0;
    char letter[2] = "";
    switch (*at) {
    case 'd':
    case 'i':
        PRINT_INTEGER(int, long, long long, ptrdiff_t, intmax_t);
        break;
    case 'u':
    case 'x':
    case 'X':
    case 'o':
        PRINT_INTEGER(unsigned, unsigned long, unsigned long long, size_t, uintmax_t);
        break;
    case 'c':
        letter[0] = (char)va_arg(a->list, int);
        conversion[length] = 's';
        print_text(out, conversion, letter);
        break;
    case 's':
        print_text(out, conversion, va_arg(a->list, const char *));
        break;
    default: /* the compiler checks formats: what is left is for double */
        fprintf(out, conversion, va_arg(a->list, double));
        break;
    }
    return at + 1;
}

int print_list(FILE *out, const char *format, va_list arguments) {
    struct arguments a;
    char *text = NULL;
    size_t length = 0;
    FILE *line = open_memstream(&text, &length);
    if (!line) return -1;
    va_copy(a.list, arguments);
    while (*format) {
        const size_t plain = strcspn(format, "%");
        fwrite(format, 1, plain, line);
        format += plain;
        if (*format) format = print_argument(line, format, &a);
    }
    va_end(a.list);
    const bool good = fclose(line) == 0 && fwrite(text, 1, length, out) == length;
    free(text);
    return good ? (int)length : -1;
}

int print_to(FILE *out, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    const int length = print_list(out, format, arguments);
    va_end(arguments);
    return length;
}

/* ---- words of a shell ---- */

char *print_shell_word(const char *text) {
    static const char plain[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-+=.,:/%@";
    char *word = NULL, *copy = strdup(text);
    size_t length;
    FILE *out = copy ? open_memstream(&word, &length) : NULL;
    if (!out) {
        free(copy);
        return NULL;
    }
    const bool escapes = fnl_text_clean(copy), quotes = !*text || text[strspn(text, plain)] || *text == '=';
    free(copy);
    if (quotes) fputs(escapes ? "$'" : "'", out);
    for (const unsigned char *c = (const unsigned char *)text; *c; c++) {
        if (escapes && (*c < 0x20 || *c >= 0x7f)) fprintf(out, "\\%03o", *c);
        else if (escapes && (*c == '\'' || *c == '\\')) fprintf(out, "\\%c", *c);
        else if (*c == '\'') fputs("'\\''", out);
        else fputc(*c, out);
    }
    if (quotes) fputc('\'', out);
    if (fclose(out) == 0) return word;
    free(word);
    return NULL;
}
