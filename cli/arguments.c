/* SPDX-License-Identifier: MIT */
#include "arguments.h"

#include "print.h"

#include <ctype.h>
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

bool argument_bad(const char *option, const char *value, const char *wanted) {
    fprintf(stderr, "fanal: error: --%s: '%s' is not %s\n", option, value, wanted);
    return false;
}

bool argument_take_number(const char **at, double *out) {
    const char *digits = *at + (**at == '-');
    const bool hexadecimal = digits[0] == '0' && (digits[1] == 'x' || digits[1] == 'X');
    if (hexadecimal || !isdigit((unsigned char)digits[*digits == '.'])) return false;
    char *end;
    *out = strtod(*at, &end);
    *at = end;
    return isfinite(*out);
}

bool argument_take_count(const char **at, uint64_t *out) {
    if (!isdigit((unsigned char)**at)) return false;
    char *end;
    errno = 0;
    *out = strtoull(*at, &end, 10);
    *at = end;
    return errno == 0;
}

/* The next of numbers with commas between, in the range of floats. */
static bool take_next(const char **at, bool first, double *out) {
    if (!first && *(*at)++ != ',') return false;
    return argument_take_number(at, out) && isfinite((float)*out);
}

bool argument_take_numbers(const char **at, float *out, uint32_t count) {
    for (uint32_t i = 0; i < count; i++) {
        double number;
        if (!take_next(at, i == 0, &number)) return false;
        out[i] = (float)number;
    }
    return true;
}

bool argument_take_place(const char **at, double out[3]) {
    for (int i = 0; i < 3; i++)
        if (!take_next(at, i == 0, &out[i])) return false;
    return true;
}

uint32_t argument_take_row(const char **at, double *out, uint32_t most) {
    for (uint32_t i = 0;; i++) {
        *at += strspn(*at, " \t");
        if (i == most || !argument_take_number(at, &out[i]) || (**at && !strchr(" \t\r\n#", **at))) return i;
    }
}

bool argument_integer(const char *option, const char *text, long long low, long long high, long long *out) {
    const char *at = text + (*text == '-');
    uint64_t count;
    const bool whole = argument_take_count(&at, &count) && !*at && count <= INT64_MAX;
    *out = !whole ? 0 : *text == '-' ? -(long long)count : (long long)count;
    if (whole && *out >= low && *out <= high) return true;
    char wanted[96];
    snprintf(wanted, sizeof wanted, "a whole number from %lld to %lld", low, high);
    return argument_bad(option, text, wanted);
}

bool argument_number(const char *option, const char *text, double *out) {
    const char *at = text;
    return (argument_take_number(&at, out) && !*at) || argument_bad(option, text, "a number");
}

bool argument_bytes(const char *option, const char *text, uint64_t *out) {
    static const char wanted[] = "a number of bytes such as 65536, 512K, 300M or 4G";
    char *end;
    if (*text < '0' || *text > '9') return argument_bad(option, text, wanted);
    errno = 0;
    unsigned long long number = strtoull(text, &end, 10);
    unsigned shift = *end == 'K' ? 10 : *end == 'M' ? 20 : *end == 'G' ? 30 : 0;
    if (shift) end++;
    if (*end || errno || number > UINT64_MAX >> shift) return argument_bad(option, text, wanted);
    *out = (uint64_t)number << shift;
    return true;
}

bool argument_vector(const char *option, const char *text, fnl_vec3 *out) {
    const char *at = text;
    float numbers[3];
    if (argument_take_numbers(&at, numbers, 3) && !*at) {
        *out = (fnl_vec3){numbers[0], numbers[1], numbers[2]};
        return true;
    }
    return argument_bad(option, text, "three numbers such as 1,2.5,-3");
}

bool argument_place(const char *option, const char *text, double out[3]) {
    const char *at = text;
    return (argument_take_place(&at, out) && !*at) || argument_bad(option, text, "three numbers such as 1,2.5,-3");
}

bool argument_size(const char *option, const char *text, uint32_t *out_width, uint32_t *out_height) {
    const char *at = text;
    uint64_t width, height;
    if (argument_take_count(&at, &width) && *at++ == 'x' && argument_take_count(&at, &height) && !*at && width >= 1 && width <= 16384 && height >= 1 &&
        height <= 16384) {
        *out_width = (uint32_t)width;
        *out_height = (uint32_t)height;
        return true;
    }
    return argument_bad(option, text, "a size such as 1280x720, with sides from 1 to 16384");
}

bool argument_name(const char *option, const char *text, const char *(*name_of)(int), int *out) {
    char wanted[512] = "one of";
    for (int i = 0; name_of(i); i++) {
        if (strcmp(text, name_of(i)) == 0) {
            *out = i;
            return true;
        }
        size_t length = strlen(wanted);
        snprintf(wanted + length, sizeof wanted - length, " %s", name_of(i));
    }
    return argument_bad(option, text, wanted);
}

static bool bad_light_shapes(const char *option, const char *text) {
    char wanted[256] = "a list such as point=3,spot=1 of";
    for (uint32_t kind = FNL_LIGHT_POINT; kind < FNL_LIGHT_KIND_COUNT; kind++) {
        const size_t used = strlen(wanted);
        snprintf(wanted + used, sizeof wanted - used, "%s %s", kind > FNL_LIGHT_POINT ? "," : "", fnl_value_name(FNL_ENUM_LIGHT_KIND, kind));
    }
    return argument_bad(option, text, wanted);
}

bool argument_light_shapes(const char *option, const char *text, fnl_scatter_params *out) {
    char copy[256], *rest = copy;
    if (strlen(text) >= sizeof copy) return bad_light_shapes(option, text);
    strcpy(copy, text);
    memset(out->shares, 0, sizeof out->shares);
    for (char *part; (part = strsep(&rest, ","));) {
        char *equals = strchr(part, '=');
        const char *at = equals ? equals + 1 : NULL;
        double share = 1;
        if (equals && (!argument_take_number(&at, &share) || *at || !(share > 0 && share <= 1e6))) return bad_light_shapes(option, text);
        if (equals) *equals = 0;
        fnl_light_kind kind = FNL_LIGHT_POINT;
        while (kind < FNL_LIGHT_KIND_COUNT && strcmp(part, fnl_value_name(FNL_ENUM_LIGHT_KIND, kind)) != 0) kind++;
        if (kind == FNL_LIGHT_KIND_COUNT) return bad_light_shapes(option, text);
        out->shares[kind] = (float)share;
    }
    return true;
}

bool argument_exposure(const char *option, const char *text, fnl_exposure *out, float *out_ev) {
    const char *at = text;
    double ev = 0;
    *out = strcmp(text, "auto") == 0 ? FNL_EXPOSURE_AUTO : strcmp(text, "none") == 0 ? FNL_EXPOSURE_NONE : FNL_EXPOSURE_EV;
    if (*out == FNL_EXPOSURE_EV && (!argument_take_number(&at, &ev) || *at || !(ev >= -64 && ev <= 64)))
        return argument_bad(option, text, "auto, none, or an EV100 from -64 to 64");
    *out_ev = (float)ev;
    return true;
}

void argument_device(const char *value, fnl_device_params *out) {
    if (!value) return;
    const bool negative = *value == '-';
    const char *at = value + negative;
    uint64_t index;
    if (argument_take_count(&at, &index) && !*at)
        out->index = negative || index > INT32_MAX ? INT32_MAX : (int32_t)index; /* no machine has that one */
    else
        out->name = value;
}
