/* SPDX-License-Identifier: MIT */
/* Messages with JSON pointers, and typed reading of the document. */
#include "scene/gltf.h"

/* ---- pointers and messages ---- */

/** Puts one character before `*start`; false when the buffer is full. */
static bool prepend(char *out, size_t *start, char c) {
    if (*start == 0) return false;
    out[--*start] = c;
    return true;
}

static bool prepend_key(char *out, size_t *start, const char *key) {
    for (size_t i = strlen(key); i-- > 0;) {
        bool escaped = key[i] == '~' || key[i] == '/'; /* RFC 6901: ~0 and ~1 */
        if (escaped && !prepend(out, start, key[i] == '~' ? '0' : '1')) return false;
        if (!prepend(out, start, escaped ? '~' : key[i])) return false;
    }
    return prepend(out, start, '/');
}

void gltf_pointer(const struct at *at, char *out, size_t capacity) {
    size_t start = capacity - 1;
    out[start] = 0;
    for (; at->parent; at = at->parent) {
        char number[24];
        snprintf(number, sizeof number, "%zu", at->index);
        if (!prepend_key(out, &start, at->key ? at->key : number)) break;
    }
    if (start == capacity - 1) prepend(out, &start, '/');
    memmove(out, out + start, capacity - start);
}

struct message {
    char pointer[256], text[512];
};

static void compose(struct message *out, const struct at *at, const char *format, va_list arguments) {
    gltf_pointer(at, out->pointer, sizeof out->pointer);
    text_format_list(out->text, sizeof out->text, format, arguments);
}

void gltf_warn(struct gltf *g, const struct at *at, const char *format, ...) {
    struct message m;
    va_list arguments;
    va_start(arguments, format);
    compose(&m, at, format, arguments);
    va_end(arguments);
    scene_add_message(g->scene, "%s: %s: %s", g->name, m.pointer, m.text);
}

void gltf_fail(struct gltf *g, fnl_result result, const struct at *at, const char *format, ...) {
    struct message m;
    va_list arguments;
    va_start(arguments, format);
    compose(&m, at, format, arguments);
    va_end(arguments);
    log_error(g->host, "%s: %s: %s; the file is not loaded", g->name, m.pointer, m.text);
    if (g->result == FNL_OK) g->result = result;
}

void gltf_fail_memory(struct gltf *g) {
    if (g->result != FNL_OK) return;
    log_error(g->host, "%s: memory ran out; the file is not loaded", g->name);
    g->result = FNL_ERROR_MEMORY;
}

void gltf_refuse(struct gltf *g, fnl_result result, const struct at *at, const char *format, ...) {
    char text[512];
    va_list arguments;
    va_start(arguments, format);
    text_format_list(text, sizeof text, format, arguments);
    va_end(arguments);
    if (g->params.lenient)
        gltf_warn(g, at, "%s; it is ignored", text);
    else
        gltf_fail(g, result, at, "%s", text);
}

bool gltf_take_memory(struct gltf *g, const struct at *at, uint64_t bytes) {
    if (g->result != FNL_OK) return false;
    if (bytes <= g->memory_left) {
        g->memory_left -= bytes;
        return true;
    }
    gltf_fail(g, FNL_ERROR_MEMORY, at, "needs %llu bytes of memory; of the limit of %llu there are %llu left",
              (unsigned long long)bytes, (unsigned long long)g->params.max_memory, (unsigned long long)g->memory_left);
    return false;
}

bool gltf_spend(struct gltf *g, const struct at *at, uint64_t bytes) {
    if (!gltf_take_memory(g, at, bytes)) return false;
    if (bytes <= g->budget) {
        g->budget -= bytes;
        return true;
    }
    g->memory_left += bytes;
    gltf_warn(g, at, "needs %llu bytes of memory, which is out of all proportion to the size of the file; left out",
              (unsigned long long)bytes);
    return false;
}

void gltf_refund(struct gltf *g, uint64_t bytes) {
    g->memory_left += bytes;
    g->budget += bytes;
}

static void *take(struct gltf *g, struct arena *arena, uint64_t count, size_t size) {
    void *block = count > (SIZE_MAX >> 1) / size ? NULL : arena_allocate_zero(arena, (size_t)MAX(count, 1) * size);
    if (!block) gltf_fail_memory(g);
    return block;
}

void *gltf_scratch(struct gltf *g, uint64_t count, size_t size) { return take(g, &g->scratch, count, size); }
void *gltf_keep(struct gltf *g, uint64_t count, size_t size) { return take(g, &g->scene->arena, count, size); }

static void *quiet_reallocate(void *user, void *old, size_t old_size, size_t new_size) {
    const fnl_host *inner = ((struct gltf_quiet_host *)user)->inner;
    return inner->reallocate(inner->user, old, old_size, new_size);
}

static void quiet_log(void *user, fnl_log_level level, const char *line) {
    struct gltf_quiet_host *quiet = user;
    if (level >= FNL_LOG_WARNING) snprintf(quiet->line, sizeof quiet->line, "%s", line);
}

void gltf_quiet_host_init(struct gltf_quiet_host *quiet, const fnl_host *inner) {
    *quiet = (struct gltf_quiet_host){.inner = inner};
    quiet->host = (fnl_host){.user = quiet, .reallocate = quiet_reallocate, .log = quiet_log};
}

/* ---- reading ---- */

static const char *type_name(const json_t *value) {
    switch (json_typeof(value)) {
    case JSON_OBJECT:
        return "an object";
    case JSON_ARRAY:
        return "an array";
    case JSON_STRING:
        return "a string";
    case JSON_INTEGER:
    case JSON_REAL:
        return "a number";
    case JSON_TRUE:
    case JSON_FALSE:
        return "a boolean";
    case JSON_NULL:
        break;
    }
    return "null, or a number too large to represent";
}

static json_t *member(struct gltf *g, json_t *object, const struct at *at, const char *key, bool required) {
    json_t *value = json_object_get(object, key);
    if (!value && required) gltf_warn(g, at, "has no '%s'; it is ignored", key);
    return value;
}

json_t *gltf_object(struct gltf *g, json_t *object, const struct at *at, const char *key, bool required) {
    json_t *value = member(g, object, at, key, required);
    if (!value || json_is_object(value)) return value;
    gltf_warn(g, AT_KEY(at, key), "is %s, not an object; it is ignored", type_name(value));
    return NULL;
}

json_t *gltf_array(struct gltf *g, json_t *object, const struct at *at, const char *key, bool required) {
    json_t *value = member(g, object, at, key, required);
    if (!value) return NULL;
    if (!json_is_array(value)) {
        gltf_warn(g, AT_KEY(at, key), "is %s, not an array; it is ignored", type_name(value));
        return NULL;
    }
    if (json_array_size(value) == 0) gltf_warn(g, AT_KEY(at, key), "is empty; it is ignored");
    return value;
}

json_t *gltf_element(struct gltf *g, json_t *array, const struct at *at, size_t index) {
    json_t *value = json_array_get(array, index);
    if (json_is_object(value)) return value;
    gltf_warn(g, AT_INDEX(at, index), "is %s, not an object; it is ignored", type_name(value));
    return NULL;
}

uint32_t gltf_count(json_t *array) { return (uint32_t)MIN(json_array_size(array), (size_t)UINT32_MAX - 1); }

const char *gltf_string(struct gltf *g, json_t *object, const struct at *at, const char *key, bool required) {
    json_t *value = member(g, object, at, key, required);
    if (!value || json_is_string(value)) return json_string_value(value);
    gltf_warn(g, AT_KEY(at, key), "is %s, not a string; it is ignored", type_name(value));
    return NULL;
}

const char *gltf_name(struct gltf *g, json_t *object, const struct at *at) {
    const char *name = gltf_string(g, object, at, "name", false);
    if (!name || !*name) return "";
    const char *copy = arena_string(&g->scene->arena, name);
    if (!copy) gltf_fail_memory(g);
    return copy ? copy : "";
}

const char *gltf_extras(struct gltf *g, json_t *object) {
    json_t *extras = json_object_get(object, "extras");
    if (!extras) return NULL;
    char *text = json_dumps(extras, JSON_COMPACT | JSON_ENCODE_ANY);
    const char *copy = text ? arena_string(&g->scene->arena, text) : NULL;
    free(text);
    if (!copy) gltf_fail_memory(g);
    return copy;
}

bool gltf_bool(struct gltf *g, json_t *object, const struct at *at, const char *key, bool fallback) {
    json_t *value = json_object_get(object, key);
    if (!value) return fallback;
    if (json_is_boolean(value)) return json_is_true(value);
    gltf_warn(g, AT_KEY(at, key), "is %s, not a boolean; it is ignored", type_name(value));
    return fallback;
}

/** Reads a whole number; 3.0 counts as one. */
static bool whole_number(const json_t *value, uint64_t *out) {
    if (json_is_integer(value) && json_integer_value(value) >= 0) {
        *out = (uint64_t)json_integer_value(value);
        return true;
    }
    double real = json_is_real(value) ? json_real_value(value) : -1;
    if (!(real >= 0 && real < 0x1p53) || floor(real) < real) return false;
    *out = (uint64_t)real;
    return true;
}

bool gltf_uint(struct gltf *g, json_t *object, const struct at *at, const char *key, bool required, uint64_t low,
               uint64_t high, uint64_t *out) {
    json_t *value = member(g, object, at, key, required);
    if (!value) return false;
    uint64_t number;
    if (!whole_number(value, &number)) {
        gltf_warn(g, AT_KEY(at, key), "is not a whole number of at least 0; it is ignored");
        return false;
    }
    if (number < low || number > high) {
        gltf_warn(g, AT_KEY(at, key), "is %llu, not in %llu to %llu; it is ignored", (unsigned long long)number,
                  (unsigned long long)low, (unsigned long long)high);
        return false;
    }
    *out = number;
    return true;
}

static json_t *find_place(json_t *root, const struct at *at) {
    if (!at->parent) return root;
    json_t *up = find_place(root, at->parent);
    return at->key ? json_object_get(up, at->key) : json_array_get(up, at->index);
}

/* What the document that is saved refers to in vain must not be what it gets when it is saved. */
static void keep_dangling(struct gltf *g, const struct at *at) {
    json_t *value = g->document ? find_place(g->document, at) : NULL;
    if (json_is_integer(value)) json_integer_set(value, INT32_MAX);
    if (json_is_real(value)) json_real_set(value, INT32_MAX);
}

uint32_t gltf_index_value(struct gltf *g, json_t *value, const struct at *at, uint32_t count) {
    uint64_t number;
    if (!whole_number(value, &number)) {
        gltf_warn(g, at, "is not an index; it is ignored");
        return SCENE_NONE;
    }
    if (number >= count) {
        gltf_warn(g, at, "refers to number %llu, but there are %u; it is ignored", (unsigned long long)number, count);
        keep_dangling(g, at);
        return SCENE_NONE;
    }
    return (uint32_t)number;
}

uint32_t gltf_index(struct gltf *g, json_t *object, const struct at *at, const char *key, bool required, uint32_t count) {
    json_t *value = member(g, object, at, key, required);
    return value ? gltf_index_value(g, value, AT_KEY(at, key), count) : SCENE_NONE;
}

static bool number_value(struct gltf *g, json_t *value, const struct at *at, float low, float high, double *out) {
    if (!json_is_number(value)) {
        gltf_warn(g, at, "is %s, not a finite number; it is ignored", type_name(value));
        return false;
    }
    double number = json_number_value(value);
    if (!(number >= (double)low && number <= (double)high)) {
        float clamped = number < (double)low ? low : high;
        gltf_warn(g, at, "is %g, not in %g to %g; %g is used", number, (double)low, (double)high, (double)clamped);
        number = (double)clamped;
    }
    *out = number;
    return true;
}

bool gltf_float(struct gltf *g, json_t *object, const struct at *at, const char *key, bool required, float low, float high,
                float *out) {
    json_t *value = member(g, object, at, key, required);
    double number;
    if (!value || !number_value(g, value, AT_KEY(at, key), low, high, &number)) return false;
    *out = (float)number;
    return true;
}

bool gltf_doubles(struct gltf *g, json_t *object, const struct at *at, const char *key, uint32_t count, float low, float high,
                  double *out) {
    json_t *array = json_object_get(object, key);
    if (!array) return false;
    const struct at *here = AT_KEY(at, key);
    if (!json_is_array(array) || json_array_size(array) != count) {
        gltf_warn(g, here, "is not an array of %u numbers; it is ignored", count);
        return false;
    }
    double values[16];
    bool good = count <= COUNT_OF(values);
    for (uint32_t i = 0; i < count && i < COUNT_OF(values); i++)
        good &= number_value(g, json_array_get(array, i), AT_INDEX(here, i), low, high, &values[i]);
    if (good) memcpy(out, values, sizeof *values * count);
    return good;
}

bool gltf_floats(struct gltf *g, json_t *object, const struct at *at, const char *key, uint32_t count, float low, float high,
                 float *out) {
    double values[16];
    if (!gltf_doubles(g, object, at, key, count, low, high, values)) return false;
    for (uint32_t i = 0; i < count; i++) out[i] = (float)values[i];
    return true;
}

bool gltf_exact_rotation(struct gltf *g, json_t *object, const struct at *at, const char *key, double out[4]) {
    double v[4], square = 0;
    if (!gltf_doubles(g, object, at, key, 4, -FLT_MAX, FLT_MAX, v)) return false;
    for (int i = 0; i < 4; i++) square += v[i] * v[i];
    if (fabs(sqrt(square) - 1) > 5e-3) gltf_warn(g, AT_KEY(at, key), "is not of unit length; it is %s", square > 0 ? "normalized" : "ignored");
    for (int i = 0; i < 4 && square > 0; i++) out[i] = v[i] / sqrt(square);
    return square > 0;
}

bool gltf_rotation(struct gltf *g, json_t *object, const struct at *at, const char *key, quat *out) {
    double v[4];
    if (!gltf_exact_rotation(g, object, at, key, v)) return false;
    *out = (quat){(float)v[0], (float)v[1], (float)v[2], (float)v[3]};
    return true;
}

json_t *gltf_extension(json_t *object, const struct at *at, const char *name, struct gltf_extension_place *place) {
    json_t *extension = json_object_get(json_object_get(object, "extensions"), name);
    if (!json_is_object(extension)) return NULL; /* gltf_load_extensions has complained */
    place->extensions = (struct at){.parent = at, .key = "extensions"};
    place->extension = (struct at){.parent = &place->extensions, .key = name};
    return extension;
}

bool gltf_uses(const struct gltf *g, const char *extension) {
    json_t *used = json_object_get(g->root, "extensionsUsed");
    for (size_t i = 0; i < json_array_size(used) && i < 256; i++) {
        const char *name = json_string_value(json_array_get(used, i));
        if (name && strcmp(name, extension) == 0) return true;
    }
    return false;
}
