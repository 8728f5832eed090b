/* SPDX-License-Identifier: MIT */
#include "scene/query.h"

size_t query_name_length(const char *text) { return strcspn(text, "?"); }

/* Digits; of a decimal also a minus sign and a fraction. No exponent, no space. */
static bool parse_number(const char *text, size_t length, bool decimal, double *out) {
    char copy[24];
    bool has_digits = false, has_point = !decimal;
    if (length >= sizeof copy) return false;
    for (size_t i = 0; i < length; i++) {
        if (text[i] >= '0' && text[i] <= '9') has_digits = true;
        else if (text[i] == '.' && !has_point) has_point = true;
        else if (text[i] != '-' || i > 0 || !decimal) return false;
    }
    memcpy(copy, text, length);
    copy[length] = 0;
    *out = number_read(copy, NULL);
    return has_digits;
}

static fnl_result read_value(const fnl_host *host, const char *text, const struct query_key *key, const char *value, size_t length, double *out) {
    double number;
    if (!parse_number(value, length, key->decimal, &number) || number < key->low || number > key->high) {
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
        text_format(known + used, sizeof known - used, "%s%s=%.0f..%.0f", i ? ", " : "", key->name, key->low, key->high);
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
