/* SPDX-License-Identifier: MIT */
#include "scene/query.h"

#include <errno.h>
#include <stdlib.h>

size_t query_name_length(const char *text) { return strcspn(text, "?"); }

/* An optional minus sign, digits, and an optional fraction: no exponent, no space, whatever the locale. */
static bool parse_decimal(const char *text, size_t length, double *out) {
    const bool negative = length > 0 && *text == '-';
    double number = 0, unit = 0;
    size_t digits = 0;
    for (size_t i = negative; i < length; i++) {
        if (text[i] == '.' && unit == 0) {
            unit = 1;
            continue;
        }
        if (text[i] < '0' || text[i] > '9') return false;
        number = 10 * number + (text[i] - '0');
        if (unit > 0) unit *= 10;
        digits++;
    }
    *out = (negative ? -number : number) / (unit > 0 ? unit : 1);
    return digits > 0 && digits < 20;
}

static bool parse_whole(const char *text, size_t length, double *out) {
    char digits[24];
    if (length == 0 || length >= sizeof digits) return false;
    for (size_t i = 0; i < length; i++)
        if (text[i] < '0' || text[i] > '9') return false;
    memcpy(digits, text, length);
    digits[length] = 0;
    errno = 0;
    *out = (double)strtoull(digits, NULL, 10);
    return errno == 0;
}

static fnl_result read_value(const fnl_host *host, const char *text, const struct query_key *key, const char *value, size_t length, double *out) {
    double number;
    const bool good = key->decimal ? parse_decimal(value, length, &number) : parse_whole(value, length, &number);
    if (!good || number < key->low || number > key->high) {
        log_error(host, "builtin:%s: %s=%.*s is not a %s from %.0f to %.0f", text, key->name, (int)MIN(length, 64), value,
                  key->decimal ? "number" : "whole number", key->low, key->high);
        return FNL_ERROR_INVALID;
    }
    *out = number;
    return FNL_OK;
}

/* Reads one "key=value" of `length` characters. */
static fnl_result read_pair(const fnl_host *host, const char *text, const char *what, const struct query_key *keys, uint32_t key_count, const char *pair,
                            size_t length, double *values) {
    const char *equals = memchr(pair, '=', length);
    const size_t name_length = equals ? (size_t)(equals - pair) : length;
    char known[256] = "";
    for (uint32_t i = 0; i < key_count; i++) {
        const struct query_key *key = &keys[i];
        if (equals && strlen(key->name) == name_length && memcmp(key->name, pair, name_length) == 0)
            return read_value(host, text, key, equals + 1, length - name_length - 1, &values[i]);
        const size_t used = strlen(known);
        snprintf(known + used, sizeof known - used, "%s%s=%.0f..%.0f", i ? ", " : "", key->name, key->low, key->high);
    }
    log_error(host, "builtin:%s: '%.*s' is not a key of %s with a value; there are: %s", text, (int)MIN(length, 64), pair, what, key_count ? known : "none");
    return FNL_ERROR_INVALID;
}

fnl_result query_read(const fnl_host *host, const char *text, const char *what, const struct query_key *keys, uint32_t key_count, double *values) {
    const char *query = text + query_name_length(text);
    for (const char *pair = *query ? query + 1 : query; *pair;) {
        const size_t length = strcspn(pair, "&");
        TRY(read_pair(host, text, what, keys, key_count, pair, length, values));
        pair += length;
        if (*pair == '&') pair++;
    }
    return FNL_OK;
}
