/* SPDX-License-Identifier: MIT */
#include "base/check.h"

static void say(const struct call *call, const char *format, va_list arguments) {
    char text[1500];
    text_format_list(text, sizeof text, format, arguments);
    if (call->in_array)
        log_error(call->host, "%s: element %u: %s", call->function, call->element, text);
    else
        log_error(call->host, "%s: %s", call->function, text);
}

fnl_result misuse(const struct call *call, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    say(call, format, arguments);
    va_end(arguments);
    return FNL_ERROR_INVALID;
}

fnl_result unsupported(const struct call *call, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    say(call, format, arguments);
    va_end(arguments);
    return FNL_ERROR_UNSUPPORTED;
}

fnl_result check_pointer(const struct call *call, const char *name, const void *pointer) {
    return pointer ? FNL_OK : misuse(call, "%s is NULL", name);
}

fnl_result check_handle(const char *function, const char *name, const void *handle) {
    if (handle) return FNL_OK;
    fnl_host host = fnl_host_default();
    return check_pointer(&(struct call){.host = &host, .function = function}, name, NULL);
}

/* ---- whole numbers ---- */

fnl_result check_count(const struct call *call, const char *name, uint64_t value, uint64_t low, uint64_t high) {
    if (value >= low && value <= high) return FNL_OK;
    return misuse(call, "%s is %llu, must be %llu .. %llu", name, (unsigned long long)value, (unsigned long long)low,
                  (unsigned long long)high);
}

fnl_result check_choice(const struct call *call, const char *name, uint32_t value, const uint32_t *choices, uint32_t count) {
    char list[200] = "";
    for (uint32_t i = 0; i < count; i++) {
        if (value == choices[i]) return FNL_OK;
        size_t length = strlen(list);
        snprintf(list + length, sizeof list - length, "%s%u", i == 0 ? "" : i + 1 < count ? ", " : " or ", choices[i]);
    }
    return misuse(call, "%s is %u, must be %s", name, value, list);
}

fnl_result check_enum(const struct call *call, const char *name, int64_t value, int64_t count, const char *type) {
    if (value >= 0 && value < count) return FNL_OK;
    return misuse(call, "%s is %lld, must be a value of %s, 0 .. %lld", name, (long long)value, type, (long long)count - 1);
}

fnl_result check_index(const struct call *call, const char *name, uint32_t index, uint32_t count, const char *things) {
    if (index < count) return FNL_OK;
    if (count == 0) return misuse(call, "%s is %u, but there are no %s", name, index, things);
    return misuse(call, "%s is %u, must be 0 .. %u: there are %u %s", name, index, count - 1, count, things);
}

fnl_result check_id(const struct call *call, const char *name, bool alive, uint32_t index, uint32_t generation,
                    const char *thing) {
    if (alive) return FNL_OK;
    if (index == 0 && generation == 0) return misuse(call, "%s is the empty id, must be that of %s of the scene", name, thing);
    return misuse(call, "%s (index %u, generation %u) must be the id of %s that is in the scene", name, index, generation,
                  thing);
}

/* ---- real numbers ---- */

const char *number_text(double value, char text[32]) {
    if (isnan(value)) return "NaN";
    if (isinf(value)) return value > 0 ? "infinity" : "-infinity";
    for (int digits = 6; digits <= 9; digits++) {
        text_format(text, 32, "%.*g", digits, value);
        if ((float)number_read(text, NULL) == (float)value) break;
    }
    return text;
}

static fnl_result refuse_number(const struct call *call, const char *name, double value, bool above, double low, double high,
                                const char *unit) {
    char text[32];
    const char *given = number_text(value, text);
    if (low <= -FLT_MAX) return misuse(call, "%s is %s, must be finite", name, given);
    if (high >= FLT_MAX)
        return misuse(call, "%s is %s, must be %s %g%s%s", name, given, above ? "above" : "at least", low, unit,
                      isinf(high) ? "" : " and finite");
    if (above) return misuse(call, "%s is %s, must be above %g and at most %g%s", name, given, low, high, unit);
    return misuse(call, "%s is %s, must be %g .. %g%s", name, given, low, high, unit);
}

fnl_result check_range(const struct call *call, const char *name, double value, double low, double high, const char *unit) {
    return value >= low && value <= high ? FNL_OK : refuse_number(call, name, value, false, low, high, unit);
}

fnl_result check_above(const struct call *call, const char *name, double value, double low, double high, const char *unit) {
    return value > low && value <= high ? FNL_OK : refuse_number(call, name, value, true, low, high, unit);
}

fnl_result check_floats(const struct call *call, const char *name, const float *values, uint64_t count, double low,
                        double high, const char *unit) {
    for (uint64_t i = 0; i < count; i++) {
        if ((double)values[i] >= low && (double)values[i] <= high) continue;
        char element[100];
        snprintf(element, sizeof element, "%s[%llu]", name, (unsigned long long)i);
        return refuse_number(call, element, (double)values[i], false, low, high, unit);
    }
    return FNL_OK;
}

fnl_result check_vector(const struct call *call, const char *name, fnl_vec3 value, double low, double high,
                        const char *unit) {
    const float values[3] = {value.x, value.y, value.z};
    for (int i = 0; i < 3; i++) {
        if ((double)values[i] >= low && (double)values[i] <= high) continue;
        char element[100];
        snprintf(element, sizeof element, "%s.%c", name, "xyz"[i]);
        return refuse_number(call, element, (double)values[i], false, low, high, unit);
    }
    return FNL_OK;
}

fnl_result check_finite(const struct call *call, const char *name, fnl_vec3 value) {
    return check_vector(call, name, value, -(double)FLT_MAX, (double)FLT_MAX, "");
}
