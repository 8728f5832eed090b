/* SPDX-License-Identifier: MIT */
/** The options of a frame by name, as `fanal render --set KEY=VALUE` takes them. */
#ifndef FANAL_OPTIONS_H
#define FANAL_OPTIONS_H

#include "fanal/values.h"

#include <string.h>

#ifdef __cplusplus
extern "C" {
#endif

struct fnl_frame;

typedef enum fnl_option_kind {
    FNL_OPTION_SWITCH = 0, /**< bool: "on" or "off" */
    FNL_OPTION_COUNT,      /**< uint32_t */
    FNL_OPTION_NUMBER,     /**< float */
    FNL_OPTION_NAME        /**< an enum: the name of a value */
} fnl_option_kind;

/** One option of a frame. All strings live as long as the program. */
typedef struct fnl_option {
    /** Such as "coarse.normal-degrees": the member of fnl_frame, with dashes for underscores. */
    const char *key;
    /** One line, without the range and the default. */
    const char *help;
    fnl_option_kind kind;
    /** FNL_OPTION_NAME: whose values the option takes. */
    fnl_enum names;
    /** FNL_OPTION_COUNT and FNL_OPTION_NUMBER: the least and the greatest value. */
    double low, high;
    /** FNL_OPTION_NUMBER: `low` itself is out of range. */
    bool above_low;
    /** Also takes "auto", stored in fnl_frame as INFINITY (FNL_OPTION_NUMBER) or 0 (FNL_OPTION_COUNT). */
    bool has_auto;
    /** FNL_OPTION_COUNT: the only values allowed; choice_count 0: all from low to high that the next two allow. */
    const uint32_t *choices;
    uint32_t choice_count;
    /** FNL_OPTION_COUNT: values are multiples of this; 1: any. */
    uint32_t multiple;
    /** FNL_OPTION_COUNT: values are powers of two. */
    bool power_of_two;
    /** All values give the same picture, to the bit. */
    bool exact;
    /** Such as "pixels"; "": none. */
    const char *unit;
    /** The shading paths that heed the option: bit 1 << fnl_shading. All bits: every one. */
    uint32_t shadings;
    /** The light lists that heed it: bit 1 << fnl_light_lists. All bits: it does not matter which. */
    uint32_t lists;
} fnl_option;

/** The option `index`, 0 and up, in the order of the headers; false beyond the last. */
FNL_API bool fnl_option_query(uint32_t index, fnl_option *out);
/** The option with a key; false where there is none, or `key` is NULL. `out` may be NULL. */
static inline bool fnl_option_find(const char *key, fnl_option *out) {
    fnl_option option;
    for (uint32_t i = 0; key && fnl_option_query(i, &option); i++) {
        if (strcmp(option.key, key) != 0) continue;
        if (out) *out = option;
        return true;
    }
    return false;
}

/**
 * Sets an option by its key: "4", "0.5", "on", "auto", or the name of a value. FNL_ERROR_INVALID, with a log line that names the key and what it
 * takes, where the key or the value is wrong; `frame` is then as it was. `host` NULL: the built-in log.
 */
FNL_API fnl_result fnl_frame_set(const fnl_host *host, struct fnl_frame *frame, const char *key, const char *value);
/** Writes an option's value in the words that fnl_frame_set takes, zero-terminated; returns the length it wants, 0 for an unknown key. */
FNL_API size_t fnl_frame_get(const struct fnl_frame *frame, const char *key, char *text, size_t capacity);

#ifdef __cplusplus
}
#endif
#endif
