/* SPDX-License-Identifier: MIT */
/* Buffers and buffer views. Sections are those of the glTF 2.0 specification. */
#include "scene/gltf.h"

/* ---- buffers (3.6.1) ---- */

static bool buffer_is_fallback(json_t *object) {
    json_t *extensions = json_object_get(object, "extensions");
    return json_is_true(json_object_get(json_object_get(extensions, "KHR_meshopt_compression"), "fallback")) ||
           json_is_true(json_object_get(json_object_get(extensions, "EXT_meshopt_compression"), "fallback"));
}

/** 3.6.1.1: a data URI of a buffer has one of two media types. */
static void check_media_type(struct gltf *g, const struct at *at, const char *uri) {
    char type[64];
    if (!gltf_is_data_uri(uri)) return;
    bool good = gltf_uri_media_type(uri, type, sizeof type) &&
                (strcmp(type, "application/octet-stream") == 0 || strcmp(type, "application/gltf-buffer") == 0);
    if (!good)
        gltf_warn(g, at, "has not the media type application/octet-stream or application/gltf-buffer; it is read all the same");
}

/** Whether an earlier buffer has the same bytes: a file that is named again raises no budget again. */
static bool is_read_already(const struct gltf *g, uint32_t index) {
    for (uint32_t i = 0; i < index; i++)
        if (g->buffers[i].data == g->buffers[index].data) return true;
    return false;
}

static void load_buffer(struct gltf *g, json_t *object, const struct at *at, uint32_t index) {
    struct gltf_buffer *buffer = &g->buffers[index];
    uint64_t available = 0;
    buffer->valid = gltf_uint(g, object, at, "byteLength", true, 1, UINT64_MAX, &buffer->size);
    if (buffer_is_fallback(object)) return; /* for those who cannot decompress: its data is not read, and may be missing */
    const char *uri = gltf_string(g, object, at, "uri", false);
    if (uri) {
        check_media_type(g, AT_KEY(at, "uri"), uri);
        if (!gltf_read_uri(g, AT_KEY(at, "uri"), uri, true, &buffer->data, &available)) buffer->data = NULL;
        if (!buffer->data) return;
    } else if (g->is_glb && index == 0) {
        buffer->data = g->binary;
        available = g->binary_size;
        if (!buffer->data) {
            gltf_refuse(g, FNL_ERROR_FORMAT, at, "has no 'uri', and the GLB has no BIN chunk");
            return;
        }
    } else {
        return; /* a placeholder: whatever reads from it is refused */
    }
    if (!is_read_already(g, index)) {
        g->budget += 64 * available;
        g->check_left += 4 * available;
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
    json_t *meshopt = gltf_extension(object, at, "KHR_meshopt_compression", &place);
    if (!meshopt) meshopt = gltf_extension(object, at, "EXT_meshopt_compression", &place);
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
    g->check_left = (uint64_t)64 << 20;
    json_t *buffers = gltf_array(g, g->root, &g->top, "buffers", false);
    g->buffer_count = gltf_count(buffers);
    g->buffers = gltf_scratch(g, g->buffer_count, sizeof *g->buffers);
    for (uint32_t i = 0; i < g->buffer_count && g->buffers && g->result != FNL_ERROR_MEMORY && g->result != FNL_ERROR_CANCELLED;
         i++) {
        const struct at *at = AT_KEY(&g->top, "buffers");
        json_t *object = gltf_element(g, buffers, at, i);
        if (object) load_buffer(g, object, AT_INDEX(at, i), i);
        gltf_step(g);
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
