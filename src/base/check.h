/* SPDX-License-Identifier: MIT */
/**
 * Checks of what a program hands to public functions. What does not hold is logged in the words of the headers, such as
 * "fnl_scene_add_light: range is -3, must be above 0 metres", and comes back as FNL_ERROR_INVALID; public functions wrap them in TRY().
 * What only Fanal's own code can get wrong is checked by REQUIRE() of base.h instead.
 */
#ifndef FNL_BASE_CHECK_H
#define FNL_BASE_CHECK_H

#include "base/base.h"

#include <float.h>
#include <math.h>

/** The public function whose arguments are checked, and where that is logged. */
struct call {
    const fnl_host *host;
    const char *function;
    bool in_array;    /* what is checked is one of several that the call was given: messages begin with "element 3: " */
    uint32_t element; /* then: which */
};
/** In the public function itself; and for one of `count` elements. */
#define CALL(host_) (&(const struct call){.host = (host_), .function = __func__})
#define CALL_ELEMENT(host_, i, count) \
    (&(const struct call){.host = (host_), .function = __func__, .in_array = (count) > 1, .element = (i)})

/** Logs "FUNCTION: …"; returns FNL_ERROR_INVALID. */
fnl_result misuse(const struct call *call, const char *format, ...) __attribute__((format(printf, 2, 3)));

/** The same for what is valid, but not here: on this device, or together with something else. Returns FNL_ERROR_UNSUPPORTED. */
fnl_result unsupported(const struct call *call, const char *format, ...) __attribute__((format(printf, 2, 3)));

/** A handle, which brings its host: one that is NULL is logged by the built-in log. */
fnl_result check_handle(const char *function, const char *name, const void *handle);
fnl_result check_pointer(const struct call *call, const char *name, const void *pointer);
/** low .. high. */
fnl_result check_count(const struct call *call, const char *name, uint64_t value, uint64_t low, uint64_t high);
/** One of `count` values. */
fnl_result check_choice(const struct call *call, const char *name, uint32_t value, const uint32_t *choices, uint32_t count);
/** 0 .. count - 1; `type` is the enum. */
fnl_result check_enum(const struct call *call, const char *name, int64_t value, int64_t count, const char *type);
/** Below the number of `things`, a plural. */
fnl_result check_index(const struct call *call, const char *name, uint32_t index, uint32_t count, const char *things);
/** An id, of which it is known whether it is that of a living `thing`. */
fnl_result check_id(const struct call *call, const char *name, bool alive, uint32_t index, uint32_t generation,
                    const char *thing);

/** A float with as few digits as tell it from all others; NaN and infinities in words. */
const char *number_text(double value, char text[32]);
/** low <= value <= high; FLT_MAX: any finite number. NaN is in no range. `unit` follows the numbers, as in " metres"; "": none. */
fnl_result check_range(const struct call *call, const char *name, double value, double low, double high, const char *unit);
/** low < value <= high */
fnl_result check_above(const struct call *call, const char *name, double value, double low, double high, const char *unit);
/** Each of an array, by index. */
fnl_result check_floats(const struct call *call, const char *name, const float *values, uint64_t count, double low,
                        double high, const char *unit);
/** x, y and z. */
fnl_result check_vector(const struct call *call, const char *name, fnl_vec3 value, double low, double high, const char *unit);
/** Finite numbers. */
fnl_result check_finite(const struct call *call, const char *name, fnl_vec3 value);

#endif
