/* SPDX-License-Identifier: MIT */
/* What URIs stand for (glTF 2.0, 2.8; RFC 2397, RFC 3986), and which of it may be read. */
#include "scene/gltf.h"

#include <errno.h>
#include <strings.h>

#define PATH_SIZE 4096

/** What cannot be had: an error where the file is of no use without it, else a warning. */
static void complain(struct gltf *g, const struct at *at, bool needed, fnl_result result, const char *format, ...)
    __attribute__((format(printf, 5, 6)));
static void complain(struct gltf *g, const struct at *at, bool needed, fnl_result result, const char *format, ...) {
    char text[512];
    va_list arguments;
    va_start(arguments, format);
    text_format_list(text, sizeof text, format, arguments);
    va_end(arguments);
    if (needed)
        gltf_refuse(g, result, at, "%s", text);
    else
        gltf_warn(g, at, "%s; its data is ignored", text);
}

/* ---- data URIs ---- */

static int hex_digit(char c) {
    if (c >= '0' && c <= '9') return c - '0';
    if (c >= 'a' && c <= 'f') return c - 'a' + 10;
    if (c >= 'A' && c <= 'F') return c - 'A' + 10;
    return -1;
}

static int base64_digit(unsigned char c) {
    if (c >= 'A' && c <= 'Z') return c - 'A';
    if (c >= 'a' && c <= 'z') return c - 'a' + 26;
    if (c >= '0' && c <= '9') return c - '0' + 52;
    if (c == '+' || c == '-') return 62;
    if (c == '/' || c == '_') return 63;
    return -1;
}

/** The next octet of escaped text (RFC 3986, 2.1); -1: a '%' without two digits. */
static int next_octet(const char **text) {
    const char *c = *text;
    if (*c != '%') {
        *text = c + 1;
        return (unsigned char)*c;
    }
    const int high = hex_digit(c[1]), low = high >= 0 ? hex_digit(c[2]) : -1;
    *text = c + 3;
    return low >= 0 ? high * 16 + low : -1;
}

bool gltf_is_data_uri(const char *uri) { return strncasecmp(uri, "data:", 5) == 0; }

/** data:[<mediatype>][;base64],<data> (RFC 2397) */
static bool read_data(struct gltf *g, const struct at *at, const char *uri, bool needed, const unsigned char **data, uint64_t *size) {
    const char *comma = strchr(uri, ',');
    if (!comma) {
        complain(g, at, needed, FNL_ERROR_FORMAT, "is a data URI without a comma before its data");
        return false;
    }
    const bool base64 = comma - uri >= 5 + 7 && strncasecmp(comma - 7, ";base64", 7) == 0;
    size_t count = 0, length = 0;
    for (const char *c = comma + 1; *c;) {
        const int octet = next_octet(&c);
        if (octet < 0) {
            complain(g, at, needed, FNL_ERROR_FORMAT, "has a '%%' without two hexadecimal digits at octet %zu of its data", count);
            return false;
        }
        count++;
        if (!base64 || octet != '=') length = count; /* base64 ends before its padding */
    }
    const size_t most = base64 ? length / 4 * 3 + 3 : MAX(length, 1);
    if (!gltf_take_memory(g, at, most)) return false;
    unsigned char *bytes = scene_keep_bytes(g->scene, most);
    if (!bytes) {
        gltf_fail_memory(g);
        return false;
    }
    uint32_t bits = 0, bit_count = 0;
    size_t used = 0;
    const char *c = comma + 1;
    for (size_t i = 0; i < length; i++) {
        const int octet = next_octet(&c), digit = base64 ? base64_digit((unsigned char)octet) : 0;
        if (digit < 0) {
            complain(g, at, needed, FNL_ERROR_FORMAT, "is not base64 at character %zu of its data", i);
            return false;
        }
        if (!base64) bytes[used++] = (unsigned char)octet;
        bits = bits << 6 | (uint32_t)digit;
        bit_count += base64 ? 6 : 0;
        if (bit_count >= 8) {
            bit_count -= 8;
            bytes[used++] = (unsigned char)(bits >> bit_count);
        }
    }
    *data = bytes;
    *size = used;
    return true;
}

bool gltf_uri_media_type(const char *uri, char *out, size_t capacity) {
    if (!gltf_is_data_uri(uri)) return false;
    size_t length = strcspn(uri + 5, ";,");
    if (length == 0 || length >= capacity) return false;
    for (size_t i = 0; i < length; i++) {
        const char c = uri[5 + i];
        out[i] = (char)(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c);
    }
    out[length] = 0;
    return true;
}

/* ---- files ---- */

/** Decodes %XX. False: the result does not fit, or has a zero byte. */
static bool decode_percent(const char *uri, char *out, size_t capacity) {
    size_t length = 0;
    while (*uri) {
        const char *next = uri;
        int octet = next_octet(&next);
        if (octet < 0) { /* the name of a file may have a '%' */
            octet = '%';
            next = uri + 1;
        }
        if (length + 1 >= capacity || !octet) return false;
        out[length++] = (char)octet;
        uri = next;
    }
    out[length] = 0;
    return length > 0;
}

/** RFC 3986, 5.2.4, of a relative path: "a/../b" is "b", whether there is an "a" or not. What leads out of the folder stays in front. */
static void remove_dot_segments(char *path) {
    char *out = path, *fixed = path; /* nothing before `fixed` can be taken back */
    for (const char *in = path; *in;) {
        const size_t length = strcspn(in, "/"), whole = length + (in[length] == '/');
        if (length == 2 && in[0] == '.' && in[1] == '.' && out > fixed) {
            for (out--; out > fixed && out[-1] != '/';) out--;
        } else if (!(length == 1 && in[0] == '.') && !(length == 0 && out == path)) {
            memmove(out, in, whole);
            out += whole;
            if (length == 2 && in[0] == '.' && in[1] == '.') fixed = out;
        }
        in += whole;
    }
    *out = 0;
}

/** Whether a URI begins with a scheme such as "http:". */
static bool has_scheme(const char *uri) {
    size_t i = 0;
    while ((uri[i] >= 'a' && uri[i] <= 'z') || (uri[i] >= 'A' && uri[i] <= 'Z') ||
           (i > 0 && uri[i] && strchr("0123456789+-.", uri[i])))
        i++;
    return i > 1 && uri[i] == ':';
}

/** Whether a real path is in or below a real folder. */
static bool is_inside(const char *path, const char *folder) {
    size_t length = strlen(folder);
    if (length > 0 && folder[length - 1] == '/') length--; /* the root */
    return strncmp(path, folder, length) == 0 && path[length] == '/';
}

/** Finds the file that a relative path means, and decides whether it may be read; `real` is then what is to be opened. */
static bool find_file(struct gltf *g, const struct at *at, const char *relative, bool needed, char real[PATH_SIZE]) {
    char path[PATH_SIZE], folder[PATH_SIZE];
    if (snprintf(path, sizeof path, "%s%s", g->folder, relative) >= PATH_SIZE) {
        complain(g, at, needed, FNL_ERROR_FILE, "is too long a path");
        return false;
    }
    if (!path_real(path, real, PATH_SIZE) || !path_real(*g->folder ? g->folder : ".", folder, sizeof folder)) {
        complain(g, at, needed, FNL_ERROR_FILE, "%s: cannot be opened: %s", path, strerror(errno));
        return false;
    }
    if (is_inside(real, folder)) return true;
    if (g->params.confine) {
        gltf_refuse(g, FNL_ERROR_FILE, at, "'%.100s' is outside of the file's folder, to which loading is confined",
                    relative);
        return false;
    }
    gltf_warn(g, at, "'%.100s' is outside of the file's folder; it is read all the same", relative);
    return true;
}

/** A file is read once, however often a small document names it. */
static bool find_loaded(const fnl_scene *scene, const struct file_identity *wanted, struct file_view *out) {
    for (uint32_t i = 0; i < scene->files.count; i++) {
        *out = scene->files.data[i];
        if (out->identity.device == wanted->device && out->identity.node == wanted->node) return true;
    }
    return false;
}

/** Remembers what a URI stood for, or would have. */
static void note_source(struct gltf *g, const char *uri, const char *path, const unsigned char *data, uint64_t size) {
    const struct scene_source source = {arena_string(&g->scene->arena, uri), path ? arena_string(&g->scene->arena, path) : NULL, data, size};
    if (!source.uri || (path && !source.path) || !array_push(g->host, &g->scene->sources, source)) gltf_fail_memory(g);
}

static bool read_file(struct gltf *g, const struct at *at, const char *uri, const char *relative, bool needed, const unsigned char **data,
                      uint64_t *size) {
    char real[PATH_SIZE];
    if (!find_file(g, at, relative, needed, real)) {
        char path[PATH_SIZE];
        if (snprintf(path, sizeof path, "%s%s", g->folder, relative) < PATH_SIZE) note_source(g, uri, path, NULL, 0);
        return false;
    }
    struct gltf_quiet_host quiet;
    gltf_quiet_host_init(&quiet, g->host);
    struct file_view file;
    fnl_result result = FNL_OK;
    struct file_identity wanted = {0};
    bool known = file_identify(real, &wanted) && find_loaded(g->scene, &wanted, &file);
    if (!known && !gltf_take_memory(g, at, wanted.size)) return false;
    if (!known) result = file_load(&quiet.host, real, &file);
    if (result == FNL_ERROR_MEMORY) {
        log_error(g->host, "%s: %s", real, quiet.line);
        gltf_fail_memory(g);
        return false;
    }
    if (result != FNL_OK) {
        complain(g, at, needed, FNL_ERROR_FILE, "%s", quiet.line);
        note_source(g, uri, real, NULL, 0);
        return false;
    }
    if (!known && !array_push(g->host, &g->scene->files, file)) {
        file_free(g->host, &file);
        gltf_fail_memory(g);
        return false;
    }
    *data = file.data;
    *size = file.size;
    note_source(g, uri, real, file.data, file.size);
    return g->result != FNL_ERROR_MEMORY;
}

/* ---- the caller's resolver ---- */

static bool resolve(struct gltf *g, const struct at *at, const char *uri, bool needed, const unsigned char **data,
                    uint64_t *size) {
    /* Room first: what was handed over must not get lost. */
    if (!array_reserve(g->host, &g->scene->resources, (uint64_t)g->scene->resources.count + 1)) {
        gltf_fail_memory(g);
        return false;
    }
    fnl_resource resource = {0};
    fnl_result result = g->params.resolve(g->params.user, uri, &resource);
    if (result == FNL_OK) {
        g->scene->resources.data[g->scene->resources.count++] = resource;
        *data = resource.data;
        *size = resource.data ? resource.size : 0;
        note_source(g, uri, NULL, *data, *size);
        return g->result != FNL_ERROR_MEMORY;
    }
    if (result == FNL_ERROR_MEMORY)
        gltf_fail(g, result, at, "the resolver has no memory for '%.100s'", uri);
    else
        complain(g, at, needed, FNL_ERROR_FILE, "the resolver does not give '%.100s': %s", uri, fnl_result_name(result));
    return false;
}

bool gltf_read_uri(struct gltf *g, const struct at *at, const char *uri, bool needed, const unsigned char **data,
                   uint64_t *size) {
    if (gltf_is_data_uri(uri)) return read_data(g, at, uri, needed, data, size);
    if (g->params.resolve) return resolve(g, at, uri, needed, data, size);
    char path[PATH_SIZE];
    if (!decode_percent(uri, path, sizeof path)) {
        complain(g, at, needed, FNL_ERROR_FILE, "is no path of a file");
        return false;
    }
    if (path[0] == '/' || strncasecmp(path, "file:", 5) == 0) {
        gltf_refuse(g, FNL_ERROR_FILE, at, "'%.100s' is an absolute path, which glTF files may not refer to", path);
        return false;
    }
    if (has_scheme(uri)) {
        complain(g, at, needed, FNL_ERROR_FILE, "'%.100s' is neither a file nor a data URI", uri);
        return false;
    }
    if (!g->folder) {
        gltf_refuse(g, FNL_ERROR_FILE, at,
                    "'%.100s' is another file, but this glTF is loaded from memory without a resolver", uri);
        return false;
    }
    remove_dot_segments(path);
    return read_file(g, at, uri, path, needed, data, size);
}
