/* SPDX-License-Identifier: MIT */
/* KHR_meshopt_compression and its forerunner EXT_meshopt_compression: compressed buffer views. */
#include "scene/gltf.h"
#include "scene/meshcode.h"

enum mode { MODE_NONE, MODE_ATTRIBUTES, MODE_TRIANGLES, MODE_INDICES };
enum filter { FILTER_UNKNOWN, FILTER_NONE, FILTER_OCTAHEDRAL, FILTER_QUATERNION, FILTER_EXPONENTIAL, FILTER_COLOR };

static enum mode mode_from_name(const char *name) {
    if (name && strcmp(name, "ATTRIBUTES") == 0) return MODE_ATTRIBUTES;
    if (name && strcmp(name, "TRIANGLES") == 0) return MODE_TRIANGLES;
    if (name && strcmp(name, "INDICES") == 0) return MODE_INDICES;
    return MODE_NONE;
}

static enum filter filter_from_name(const char *name) {
    if (!name || strcmp(name, "NONE") == 0) return FILTER_NONE;
    if (strcmp(name, "OCTAHEDRAL") == 0) return FILTER_OCTAHEDRAL;
    if (strcmp(name, "QUATERNION") == 0) return FILTER_QUATERNION;
    if (strcmp(name, "EXPONENTIAL") == 0) return FILTER_EXPONENTIAL;
    if (strcmp(name, "COLOR") == 0) return FILTER_COLOR;
    return FILTER_UNKNOWN;
}

/** What the extension demands of mode, filter, stride and count. NULL when all is well. */
static const char *find_fault(enum mode mode, enum filter filter, uint64_t stride, uint64_t count) {
    if (mode == MODE_NONE) return "has an unknown 'mode'";
    if (filter == FILTER_UNKNOWN) return "has an unknown 'filter'";
    if (mode == MODE_ATTRIBUTES && stride % 4 != 0) return "has a 'byteStride' that is no multiple of 4";
    if (mode != MODE_ATTRIBUTES && stride != 2 && stride != 4) return "has indices with a 'byteStride' other than 2 and 4";
    if (mode != MODE_ATTRIBUTES && filter != FILTER_NONE) return "has a 'filter' on indices";
    if (mode == MODE_TRIANGLES && count % 3 != 0) return "has triangles with a 'count' that is no multiple of 3";
    if (filter == FILTER_OCTAHEDRAL && stride != 4 && stride != 8)
        return "has an octahedral filter on a 'byteStride' other than 4 and 8";
    if (filter == FILTER_COLOR && stride != 4 && stride != 8) return "has a colour filter on a 'byteStride' other than 4 and 8";
    if (filter == FILTER_QUATERNION && stride != 8) return "has a quaternion filter on a 'byteStride' other than 8";
    return NULL;
}

static bool decode(enum mode mode, void *out, size_t count, size_t stride, const unsigned char *data, size_t size) {
    switch (mode) {
    case MODE_ATTRIBUTES:
        return meshcode_attributes(out, count, stride, data, size);
    case MODE_TRIANGLES:
        return meshcode_triangles(out, count, stride, data, size);
    case MODE_INDICES:
        return meshcode_indices(out, count, stride, data, size);
    case MODE_NONE:
        break;
    }
    return false;
}

static void apply_filter(enum filter filter, void *data, size_t count, size_t stride) {
    switch (filter) {
    case FILTER_OCTAHEDRAL:
        meshcode_filter_octahedral(data, count, stride);
        break;
    case FILTER_QUATERNION:
        meshcode_filter_quaternion(data, count);
        break;
    case FILTER_EXPONENTIAL:
        meshcode_filter_exponential(data, count, stride);
        break;
    case FILTER_COLOR:
        meshcode_filter_color(data, count, stride);
        break;
    case FILTER_NONE:
    case FILTER_UNKNOWN:
        break;
    }
}

/** What only the later of the two extensions has. */
static void check_vintage(struct gltf *g, const struct at *at, enum mode mode, enum filter filter, unsigned char head) {
    if (!at->key || strcmp(at->key, "EXT_meshopt_compression") != 0) return;
    if (filter == FILTER_COLOR) gltf_warn(g, at, "has the filter COLOR of KHR_meshopt_compression; it is used all the same");
    if (mode == MODE_ATTRIBUTES && head == 0xa1) gltf_warn(g, at, "has data of version 1, as KHR_meshopt_compression; it is used all the same");
}

bool gltf_decode_meshopt(struct gltf *g, json_t *extension, const struct at *at, struct gltf_view *view) {
    uint64_t offset = 0, size = 0, stride = 0, count = 0;
    uint32_t buffer_index = gltf_index(g, extension, at, "buffer", true, g->buffer_count);
    bool good = buffer_index != SCENE_NONE;
    if (json_object_get(extension, "byteOffset"))
        good &= gltf_uint(g, extension, at, "byteOffset", false, 0, UINT64_MAX, &offset);
    good &= gltf_uint(g, extension, at, "byteLength", true, 1, UINT64_MAX, &size);
    good &= gltf_uint(g, extension, at, "byteStride", true, 1, 256, &stride);
    good &= gltf_uint(g, extension, at, "count", true, 1, UINT32_MAX, &count);
    if (!good || !g->buffers[buffer_index].valid) return false;
    const struct gltf_buffer *buffer = &g->buffers[buffer_index];
    if (!buffer->data || offset >= buffer->size || size > buffer->size - offset) {
        gltf_warn(g, AT_KEY(at, "byteLength"), "the compressed bytes are not all in buffer %u; the view is ignored",
                  buffer_index);
        return false;
    }
    enum mode mode = mode_from_name(gltf_string(g, extension, at, "mode", true));
    enum filter filter = filter_from_name(gltf_string(g, extension, at, "filter", false));
    const char *fault = find_fault(mode, filter, stride, count);
    if (fault) {
        gltf_warn(g, at, "%s; the view is ignored", fault);
        return false;
    }
    uint64_t decoded_size = count * stride;
    if (decoded_size < view->size) {
        gltf_warn(g, at, "decodes to %llu bytes, fewer than the view's byteLength; the view is ignored",
                  (unsigned long long)decoded_size);
        return false;
    }
    /* The densest code, attributes of version 1 that do not change, spends a byte on 1024; more than that is a lie in the header. */
    if (decoded_size / 1024 > size + 64) {
        gltf_warn(g, at, "%llu compressed bytes cannot hold %llu; the view is ignored", (unsigned long long)size,
                  (unsigned long long)decoded_size);
        return false;
    }
    if (!gltf_spend(g, at, decoded_size)) return false;
    unsigned char *data = gltf_keep(g, count, (size_t)stride);
    if (!data) return false;
    check_vintage(g, at, mode, filter, buffer->data[offset]);
    if (!decode(mode, data, (size_t)count, (size_t)stride, buffer->data + offset, (size_t)size)) {
        gltf_warn(g, at, "the compressed data is broken; the view is ignored");
        return false;
    }
    apply_filter(filter, data, (size_t)count, (size_t)stride);
    view->data = data;
    view->size = decoded_size;
    g->budget += 64 * decoded_size;
    g->check_left += 4 * decoded_size;
    return true;
}
