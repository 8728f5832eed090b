/* SPDX-License-Identifier: MIT */
/* URIs, buffers and buffer views. Sections are those of the glTF 2.0 specification. */
#include "scene/gltf.h"

/* ---- URIs (2.8, RFC 2397, RFC 3986) ---- */

/** What a file may decode to grows with the bytes that it has. */
static void add_budget(struct gltf *g, uint64_t bytes) { g->budget += 64 * bytes; }

static int base64_digit(unsigned char c) {
    if (c >= 'A' && c <= 'Z') return c - 'A';
    if (c >= 'a' && c <= 'z') return c - 'a' + 26;
    if (c >= '0' && c <= '9') return c - '0' + 52;
    if (c == '+' || c == '-') return 62;
    if (c == '/' || c == '_') return 63;
    return -1;
}

static bool read_base64(struct gltf *g, const struct at *at, const char *text, const unsigned char **data, uint64_t *size) {
    size_t length = strlen(text);
    while (length > 0 && text[length - 1] == '=') length--;
    unsigned char *bytes = arena_allocate(&g->scene->arena, length / 4 * 3 + 3);
    if (!bytes) {
        gltf_fail_memory(g);
        return false;
    }
    uint32_t bits = 0, bit_count = 0;
    size_t used = 0;
    for (size_t i = 0; i < length; i++) {
        int digit = base64_digit((unsigned char)text[i]);
        if (digit < 0) {
            gltf_warn(g, at, "is not base64 at character %zu of its data; its data is ignored", i);
            return false;
        }
        bits = bits << 6 | (uint32_t)digit;
        bit_count += 6;
        if (bit_count >= 8) {
            bit_count -= 8;
            bytes[used++] = (unsigned char)(bits >> bit_count);
        }
    }
    *data = bytes;
    *size = used;
    add_budget(g, used);
    return true;
}

static int hex_digit(char c) {
    if (c >= '0' && c <= '9') return c - '0';
    if (c >= 'a' && c <= 'f') return c - 'a' + 10;
    if (c >= 'A' && c <= 'F') return c - 'A' + 10;
    return -1;
}

/** Whether a URI begins with a scheme such as "http:". */
static bool has_scheme(const char *uri) {
    size_t i = 0;
    while ((uri[i] >= 'a' && uri[i] <= 'z') || (uri[i] >= 'A' && uri[i] <= 'Z') ||
           (i > 0 && uri[i] && strchr("0123456789+-.", uri[i])))
        i++;
    return i > 1 && uri[i] == ':';
}

/** A file is read once, however often a small document names it. */
static bool find_loaded(const fnl_scene *scene, const char *path, struct file_view *out) {
    struct file_identity wanted;
    if (!file_identify(path, &wanted)) return false;
    for (uint32_t i = 0; i < scene->files.count; i++) {
        *out = scene->files.data[i];
        if (out->identity.device == wanted.device && out->identity.node == wanted.node) return true;
    }
    return false;
}

static bool load_file(struct gltf *g, const struct at *at, const char *path, struct file_view *out) {
    struct gltf_quiet_host quiet;
    gltf_quiet_host_init(&quiet, g->host);
    fnl_result result = file_load(&quiet.host, path, out);
    if (result == FNL_ERROR_MEMORY) {
        log_error(g->host, "%s: %s", path, quiet.line);
        gltf_fail_memory(g);
        return false;
    }
    if (result != FNL_OK) {
        gltf_warn(g, at, "%s; its data is ignored", quiet.line);
        return false;
    }
    if (!array_push(g->host, &g->scene->files, *out)) {
        file_free(g->host, out);
        gltf_fail_memory(g);
        return false;
    }
    add_budget(g, out->size);
    return true;
}

static bool read_file(struct gltf *g, const struct at *at, const char *uri, const unsigned char **data, uint64_t *size) {
    size_t folder_length = uri[0] == '/' ? 0 : strlen(g->folder), length = folder_length;
    char path[4096];
    if (folder_length < sizeof path) memcpy(path, g->folder, folder_length);
    for (const char *c = uri; *c; c++) {
        int high = *c == '%' ? hex_digit(c[1]) : -1, low = high >= 0 ? hex_digit(c[2]) : -1;
        if (length >= sizeof path - 1 || (low >= 0 && high * 16 + low == 0)) {
            gltf_warn(g, at, "is no path of a file; its data is ignored");
            return false;
        }
        path[length++] = low >= 0 ? (char)(high * 16 + low) : *c;
        if (low >= 0) c += 2;
    }
    if (length >= sizeof path || length == 0) {
        gltf_warn(g, at, "is no path of a file; its data is ignored");
        return false;
    }
    path[length] = 0;
    struct file_view file;
    if (!find_loaded(g->scene, path, &file) && !load_file(g, at, path, &file)) return false;
    *data = file.data;
    *size = file.size;
    return true;
}

bool gltf_read_uri(struct gltf *g, const struct at *at, const char *uri, const unsigned char **data, uint64_t *size) {
    if (strncmp(uri, "data:", 5) == 0) {
        const char *comma = strchr(uri, ',');
        if (comma && comma - uri >= 7 && strncmp(comma - 7, ";base64", 7) == 0)
            return read_base64(g, at, comma + 1, data, size);
        gltf_warn(g, at, "is not a base64 data URI; its data is ignored");
        return false;
    }
    if (has_scheme(uri)) {
        gltf_warn(g, at, "'%.100s' is neither a file nor a data URI; its data is ignored", uri);
        return false;
    }
    if (!g->folder) {
        gltf_warn(g, at, "'%.100s' refers to a file, but this glTF is read from memory; its data is ignored", uri);
        return false;
    }
    return read_file(g, at, uri, data, size);
}

/* ---- buffers (3.6.1) ---- */

static bool buffer_is_fallback(json_t *object) {
    json_t *extension = json_object_get(json_object_get(object, "extensions"), "EXT_meshopt_compression");
    return json_is_true(json_object_get(extension, "fallback"));
}

static void load_buffer(struct gltf *g, json_t *object, const struct at *at, uint32_t index) {
    struct gltf_buffer *buffer = &g->buffers[index];
    uint64_t available = 0;
    buffer->valid = gltf_uint(g, object, at, "byteLength", true, 1, UINT64_MAX, &buffer->size);
    const char *uri = gltf_string(g, object, at, "uri", false);
    if (uri) {
        if (!gltf_read_uri(g, AT_KEY(at, "uri"), uri, &buffer->data, &available)) buffer->data = NULL;
        if (!buffer->data) return;
    } else if (g->is_glb && index == 0) {
        buffer->data = g->binary;
        available = g->binary_size;
        add_budget(g, available);
        if (!buffer->data) {
            gltf_warn(g, at, "has no 'uri', and the GLB has no BIN chunk; it is ignored");
            return;
        }
    } else {
        if (!buffer_is_fallback(object)) gltf_warn(g, at, "has no 'uri', so there is nothing to read");
        return;
    }
    if (buffer->valid && available < buffer->size) {
        gltf_fail(g, FNL_ERROR_FORMAT, at, "says byteLength %llu, but there are only %llu bytes: the data is truncated",
                  (unsigned long long)buffer->size, (unsigned long long)available);
        buffer->valid = false;
    }
}

/* ---- buffer views (3.6.1) ---- */

static void load_view(struct gltf *g, json_t *object, const struct at *at, struct gltf_view *view) {
    uint64_t offset = 0, size = 0, stride = 0;
    view->attribute_accessor = SCENE_NONE;
    uint32_t buffer_index = gltf_index(g, object, at, "buffer", true, g->buffer_count);
    bool good = buffer_index != SCENE_NONE;
    if (json_object_get(object, "byteOffset")) good &= gltf_uint(g, object, at, "byteOffset", false, 0, UINT64_MAX, &offset);
    good &= gltf_uint(g, object, at, "byteLength", true, 1, UINT64_MAX, &size);
    if (gltf_uint(g, object, at, "byteStride", false, 4, 252, &stride)) {
        view->stride = (uint32_t)stride;
        if (stride % 4 != 0)
            gltf_warn(g, AT_KEY(at, "byteStride"), "is %u, not a multiple of 4; it is used all the same", view->stride);
    }
    struct gltf_extension_place place;
    json_t *meshopt = gltf_extension(object, at, "EXT_meshopt_compression", &place);
    view->size = size;
    if (meshopt) {
        view->valid = good && gltf_decode_meshopt(g, meshopt, &place.extension, view);
        return;
    }
    if (!good || !g->buffers[buffer_index].valid) return;
    const struct gltf_buffer *buffer = &g->buffers[buffer_index];
    if (offset >= buffer->size || size > buffer->size - offset) {
        gltf_warn(g, AT_KEY(at, offset >= buffer->size ? "byteOffset" : "byteLength"),
                  "bytes %llu to %llu are not all in buffer %u, which has %llu; the view is ignored",
                  (unsigned long long)offset, (unsigned long long)(offset + size), buffer_index,
                  (unsigned long long)buffer->size);
        return;
    }
    view->data = buffer->data ? buffer->data + offset : NULL;
    view->valid = true;
}

void gltf_load_buffers(struct gltf *g) {
    /* What a file may decode to: generous for honest files, and no invitation to fill the memory from a small one. */
    g->budget = (uint64_t)256 << 20;
    json_t *buffers = gltf_array(g, g->root, &g->top, "buffers", false);
    g->buffer_count = gltf_count(buffers);
    g->buffers = gltf_scratch(g, g->buffer_count, sizeof *g->buffers);
    for (uint32_t i = 0; i < g->buffer_count && g->buffers && g->result != FNL_ERROR_MEMORY; i++) {
        const struct at *at = AT_KEY(&g->top, "buffers");
        json_t *object = gltf_element(g, buffers, at, i);
        if (object) load_buffer(g, object, AT_INDEX(at, i), i);
    }
    json_t *views = gltf_array(g, g->root, &g->top, "bufferViews", false);
    g->view_count = gltf_count(views);
    if (g->result == FNL_OK) g->views = gltf_scratch(g, g->view_count, sizeof *g->views);
    for (uint32_t i = 0; i < g->view_count && g->result == FNL_OK; i++) {
        const struct at *at = AT_KEY(&g->top, "bufferViews");
        json_t *object = gltf_element(g, views, at, i);
        if (object) load_view(g, object, AT_INDEX(at, i), &g->views[i]);
    }
}
