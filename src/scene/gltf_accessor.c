/* SPDX-License-Identifier: MIT */
/* Accessors: typed, strided, sparse views of buffers (glTF 2.0, 3.6.2). */
#include "scene/gltf.h"

/** A count without bytes behind it (zeros, sparse) is only a number in the file; no vertex array needs more. */
#define ZERO_COUNT_MAX (1u << 24)

uint32_t gltf_component_size(enum gltf_component component) {
    switch (component) {
    case GLTF_BYTE:
    case GLTF_UNSIGNED_BYTE:
        return 1;
    case GLTF_SHORT:
    case GLTF_UNSIGNED_SHORT:
        return 2;
    case GLTF_UNSIGNED_INT:
    case GLTF_FLOAT:
        return 4;
    }
    return 0;
}

uint32_t gltf_type_components(enum gltf_type type) {
    static const uint8_t counts[] = {1, 2, 3, 4, 4, 9, 16};
    return counts[type];
}

static const char *const type_names[] = {"SCALAR", "VEC2", "VEC3", "VEC4", "MAT2", "MAT3", "MAT4"};

const char *gltf_format_name(const struct gltf_accessor *accessor, char *out, size_t capacity) {
    static const char *const names[] = {"BYTE", "UNSIGNED_BYTE", "SHORT", "UNSIGNED_SHORT", "", "UNSIGNED_INT", "FLOAT"};
    snprintf(out, capacity, "%s of %s%s", type_names[accessor->type], accessor->normalized ? "normalized " : "",
             names[accessor->component - GLTF_BYTE]);
    return out;
}

static uint32_t matrix_rows(enum gltf_type type) {
    return type == GLTF_MAT2 ? 2 : type == GLTF_MAT3 ? 3 : type == GLTF_MAT4 ? 4 : 0;
}

/* Matrix columns start at multiples of 4 bytes (3.6.2.4). */
uint32_t gltf_component_offset(const struct gltf_accessor *accessor, uint32_t component) {
    uint32_t size = gltf_component_size(accessor->component), rows = matrix_rows(accessor->type);
    if (rows == 0) return component * size;
    return component / rows * (uint32_t)align_up(rows * size, 4) + component % rows * size;
}

/** Bytes up to the end of the last component, and from one tightly packed element to the next. */
static uint32_t element_size(const struct gltf_accessor *accessor) {
    return gltf_component_offset(accessor, gltf_type_components(accessor->type) - 1) + gltf_component_size(accessor->component);
}
uint32_t gltf_packed_stride(const struct gltf_accessor *accessor) {
    uint32_t size = element_size(accessor);
    return matrix_rows(accessor->type) ? (uint32_t)align_up(size, 4) : size;
}

uint32_t gltf_accessor_stride(const struct gltf *g, const struct gltf_accessor *accessor) {
    uint32_t stride = accessor->view == SCENE_NONE ? 0 : g->views[accessor->view].stride;
    return stride ? stride : gltf_packed_stride(accessor);
}

static bool read_component(struct gltf *g, json_t *object, const struct at *at, enum gltf_component *out) {
    uint64_t value;
    if (!gltf_uint(g, object, at, "componentType", true, GLTF_BYTE, GLTF_FLOAT, &value)) return false;
    if (value == GLTF_UNSIGNED_INT - 1) {
        gltf_warn(g, AT_KEY(at, "componentType"), "is 5124, which glTF does not have; the accessor is ignored");
        return false;
    }
    *out = (enum gltf_component)value;
    return true;
}

/** Whether `count` elements of `size` bytes, `stride` apart from `offset` on, lie in the view. */
static bool fits(const struct gltf_view *view, uint64_t offset, uint64_t count, uint64_t stride, uint64_t size) {
    return offset <= view->size && size <= view->size - offset && (count - 1) <= (view->size - offset - size) / stride;
}

static bool load_sparse(struct gltf *g, json_t *object, const struct at *at, struct gltf_accessor *accessor) {
    uint64_t count = 0;
    json_t *indices = gltf_object(g, object, at, "indices", true), *values = gltf_object(g, object, at, "values", true);
    if (!gltf_uint(g, object, at, "count", true, 1, accessor->count, &count) || !indices || !values) return false;
    const struct at *index_at = AT_KEY(at, "indices"), *value_at = AT_KEY(at, "values");
    accessor->sparse.index_view = gltf_index(g, indices, index_at, "bufferView", true, g->view_count);
    accessor->sparse.value_view = gltf_index(g, values, value_at, "bufferView", true, g->view_count);
    bool good = accessor->sparse.index_view != SCENE_NONE && accessor->sparse.value_view != SCENE_NONE;
    good &= read_component(g, indices, index_at, &accessor->sparse.index_component);
    if (json_object_get(indices, "byteOffset"))
        good &= gltf_uint(g, indices, index_at, "byteOffset", false, 0, UINT64_MAX, &accessor->sparse.index_offset);
    if (json_object_get(values, "byteOffset"))
        good &= gltf_uint(g, values, value_at, "byteOffset", false, 0, UINT64_MAX, &accessor->sparse.value_offset);
    if (!good) return false;
    enum gltf_component type = accessor->sparse.index_component;
    if (type != GLTF_UNSIGNED_BYTE && type != GLTF_UNSIGNED_SHORT && type != GLTF_UNSIGNED_INT) {
        gltf_warn(g, AT_KEY(index_at, "componentType"), "must be an unsigned integer type; the accessor is ignored");
        return false;
    }
    const struct gltf_view *index_view = &g->views[accessor->sparse.index_view],
                           *value_view = &g->views[accessor->sparse.value_view];
    uint32_t index_size = gltf_component_size(type);
    if (!index_view->valid || !value_view->valid) return false;
    if (!fits(index_view, accessor->sparse.index_offset, count, index_size, index_size)) {
        gltf_warn(g, index_at, "%llu indices do not fit their buffer view; the accessor is ignored",
                  (unsigned long long)count);
        return false;
    }
    if (!fits(value_view, accessor->sparse.value_offset, count, gltf_packed_stride(accessor), element_size(accessor))) {
        gltf_warn(g, value_at, "%llu values do not fit their buffer view; the accessor is ignored",
                  (unsigned long long)count);
        return false;
    }
    accessor->sparse.count = (uint32_t)count;
    return true;
}

static bool check_view(struct gltf *g, json_t *object, const struct at *at, const struct gltf_accessor *accessor) {
    const struct gltf_view *view = &g->views[accessor->view];
    uint32_t component_size = gltf_component_size(accessor->component);
    json_t *view_object = json_array_get(json_object_get(g->root, "bufferViews"), accessor->view);
    uint64_t view_offset = (uint64_t)json_integer_value(json_object_get(view_object, "byteOffset"));
    if (accessor->offset % component_size != 0)
        gltf_warn(g, AT_KEY(at, "byteOffset"),
                  "is %llu, not a multiple of the component's %u bytes; it is used all the same",
                  (unsigned long long)accessor->offset, component_size);
    if ((accessor->offset + view_offset) % component_size != 0)
        gltf_warn(
            g, at,
            "begins in the buffer at a byte that is not a multiple of the component's %u bytes; it is used all the same",
            component_size);
    if (!view->valid) {
        gltf_warn(g, at, "uses buffer view %u, which is broken; it is ignored", accessor->view);
        return false;
    }
    uint64_t stride = gltf_accessor_stride(g, accessor);
    if (stride < element_size(accessor)) {
        gltf_warn(g, AT_KEY(at, "bufferView"),
                  "its byteStride of %u is less than the element's %u bytes; the accessor is ignored", view->stride,
                  element_size(accessor));
        return false;
    }
    if (!fits(view, accessor->offset, accessor->count, stride, element_size(accessor))) {
        gltf_warn(g, json_object_get(object, "byteOffset") ? AT_KEY(at, "byteOffset") : at,
                  "%u elements, %llu bytes apart from byte %llu on, do not fit buffer view %u of %llu bytes; the accessor "
                  "is ignored",
                  accessor->count, (unsigned long long)stride, (unsigned long long)accessor->offset, accessor->view,
                  (unsigned long long)view->size);
        return false;
    }
    return true;
}

static bool load_accessor(struct gltf *g, json_t *object, const struct at *at, struct gltf_accessor *accessor) {
    uint64_t count = 0;
    accessor->view = SCENE_NONE;
    bool good = read_component(g, object, at, &accessor->component);
    good &= gltf_uint(g, object, at, "count", true, 1, UINT32_MAX - 1, &count);
    const char *type = gltf_string(g, object, at, "type", true);
    uint32_t type_index = 0;
    while (type && type_index < COUNT_OF(type_names) && strcmp(type_names[type_index], type) != 0) type_index++;
    if (type && type_index == COUNT_OF(type_names)) gltf_warn(g, AT_KEY(at, "type"), "is unknown; the accessor is ignored");
    if (!good || !type || type_index == COUNT_OF(type_names)) return false;
    accessor->type = (enum gltf_type)type_index;
    accessor->count = (uint32_t)count;
    accessor->normalized = gltf_bool(g, object, at, "normalized", false);
    if (accessor->normalized && (accessor->component == GLTF_FLOAT || accessor->component == GLTF_UNSIGNED_INT)) {
        gltf_warn(g, AT_KEY(at, "normalized"), "is not possible for this component type; it is ignored");
        accessor->normalized = false;
    }
    if (json_object_get(object, "byteOffset") &&
        !gltf_uint(g, object, at, "byteOffset", false, 0, UINT64_MAX / 2, &accessor->offset))
        return false;
    if (json_object_get(object, "bufferView")) {
        accessor->view = gltf_index(g, object, at, "bufferView", false, g->view_count);
        if (accessor->view == SCENE_NONE || !check_view(g, object, at, accessor)) return false;
    } else if (accessor->count > ZERO_COUNT_MAX && !accessor->compressed) {
        gltf_warn(g, AT_KEY(at, "count"),
                  "is %u, but no buffer view holds the elements, and more than %u zeros are not made; "
                  "the accessor is ignored",
                  accessor->count, ZERO_COUNT_MAX);
        return false;
    }
    json_t *sparse = gltf_object(g, object, at, "sparse", false);
    return !sparse || load_sparse(g, sparse, AT_KEY(at, "sparse"), accessor);
}

void gltf_load_accessors(struct gltf *g) {
    json_t *array = gltf_array(g, g->root, &g->top, "accessors", false);
    const struct at *at = AT_KEY(&g->top, "accessors");
    g->accessor_count = gltf_count(array);
    g->accessors = gltf_scratch(g, g->accessor_count, sizeof *g->accessors);
    if (g->accessors) gltf_mark_compressed(g);
    for (uint32_t i = 0; i < g->accessor_count && g->result == FNL_OK; i++) {
        json_t *object = gltf_element(g, array, at, i);
        if (!object) continue;
        g->accessors[i].valid = load_accessor(g, object, AT_INDEX(at, i), &g->accessors[i]);
        if (g->accessors[i].compressed && g->accessors[i].view == SCENE_NONE) g->accessors[i].valid = false;
        if (g->accessors[i].valid) gltf_check_bounds(g, object, AT_INDEX(at, i), &g->accessors[i]);
    }
}

/* ---- reading ---- */

double gltf_component_value(const unsigned char *bytes, enum gltf_component component) {
    int8_t i8;
    int16_t i16;
    uint16_t u16;
    uint32_t u32;
    float value;
    switch (component) {
    case GLTF_BYTE:
        memcpy(&i8, bytes, 1);
        return i8;
    case GLTF_UNSIGNED_BYTE:
        return *bytes;
    case GLTF_SHORT:
        memcpy(&i16, bytes, 2);
        return i16;
    case GLTF_UNSIGNED_SHORT:
        memcpy(&u16, bytes, 2);
        return u16;
    case GLTF_UNSIGNED_INT:
        memcpy(&u32, bytes, 4);
        return u32;
    case GLTF_FLOAT:
        memcpy(&value, bytes, 4);
        return (double)value;
    }
    return 0;
}

static float decode_float(const unsigned char *bytes, enum gltf_component component, bool normalized) {
    float value = (float)gltf_component_value(bytes, component);
    if (!normalized) return value;
    static const float most[] = {[GLTF_BYTE - GLTF_BYTE] = 127, [GLTF_UNSIGNED_BYTE - GLTF_BYTE] = 255,
                                 [GLTF_SHORT - GLTF_BYTE] = 32767, [GLTF_UNSIGNED_SHORT - GLTF_BYTE] = 65535};
    return fmaxf(value / most[component - GLTF_BYTE], -1); /* others are never normalized */
}

static uint32_t decode_uint(const unsigned char *bytes, enum gltf_component component) {
    bool is_unsigned = component == GLTF_UNSIGNED_BYTE || component == GLTF_UNSIGNED_SHORT || component == GLTF_UNSIGNED_INT;
    return is_unsigned ? (uint32_t)gltf_component_value(bytes, component) : 0;
}

/** Decodes one element as floats or, when `uints` is there, as integers. */
static void decode_element(const struct gltf_accessor *accessor, const unsigned char *bytes, float *floats,
                           uint32_t *uints) {
    uint32_t count = gltf_type_components(accessor->type);
    for (uint32_t i = 0; i < count; i++) {
        const unsigned char *component = bytes + gltf_component_offset(accessor, i);
        if (uints)
            uints[i] = decode_uint(component, accessor->component);
        else
            floats[i] = decode_float(component, accessor->component, accessor->normalized);
    }
}

bool gltf_accessor_readable(struct gltf *g, uint32_t index, const struct at *at) {
    const struct gltf_accessor *accessor = &g->accessors[index];
    if (!accessor->valid) {
        gltf_warn(g, at, "accessor %u is broken", index);
        return false;
    }
    bool missing = accessor->view != SCENE_NONE && !g->views[accessor->view].data;
    if (accessor->sparse.count > 0)
        missing |= !g->views[accessor->sparse.index_view].data || !g->views[accessor->sparse.value_view].data;
    if (missing) gltf_refuse(g, FNL_ERROR_FILE, at, "the data of accessor %u is missing", index);
    return !missing;
}

uint32_t gltf_sparse_index(const struct gltf *g, const struct gltf_accessor *accessor, uint32_t index) {
    const unsigned char *indices = g->views[accessor->sparse.index_view].data + accessor->sparse.index_offset;
    return decode_uint(indices + (size_t)index * gltf_component_size(accessor->sparse.index_component),
                       accessor->sparse.index_component);
}

static bool apply_sparse(struct gltf *g, const struct gltf_accessor *accessor, const struct at *at, float *floats,
                         uint32_t *uints) {
    uint32_t components = gltf_type_components(accessor->type);
    const unsigned char *values = g->views[accessor->sparse.value_view].data + accessor->sparse.value_offset;
    uint64_t next = 0;
    for (uint32_t i = 0; i < accessor->sparse.count; i++) {
        uint32_t index = gltf_sparse_index(g, accessor, i);
        if (index < next || index >= accessor->count) {
            gltf_warn(g, at, "accessor %u: sparse index %u is %u, %s", (uint32_t)(accessor - g->accessors), i, index,
                      index >= accessor->count ? "beyond the accessor's count" : "not greater than the one before");
            return false;
        }
        next = (uint64_t)index + 1;
        size_t to = (size_t)index * components;
        decode_element(accessor, values + (size_t)i * gltf_packed_stride(accessor), floats ? floats + to : NULL,
                       uints ? uints + to : NULL);
    }
    return true;
}

static bool read_all(struct gltf *g, uint32_t index, const struct at *at, float *floats, uint32_t *uints) {
    const struct gltf_accessor *accessor = &g->accessors[index];
    if (!gltf_accessor_readable(g, index, at)) return false;
    uint32_t components = gltf_type_components(accessor->type);
    size_t total = (size_t)accessor->count * components;
    if (accessor->view == SCENE_NONE) {
        if (floats) memset(floats, 0, total * sizeof *floats);
        if (uints) memset(uints, 0, total * sizeof *uints);
    } else {
        const struct gltf_view *view = &g->views[accessor->view];
        const unsigned char *bytes = view->data + accessor->offset;
        size_t stride = gltf_accessor_stride(g, accessor);
        if (floats && accessor->component == GLTF_FLOAT && stride == sizeof *floats * components) {
            memcpy(floats, bytes, total * sizeof *floats);
        } else {
            for (size_t i = 0; i < accessor->count; i++)
                decode_element(accessor, bytes + i * stride, floats ? floats + i * components : NULL,
                               uints ? uints + i * components : NULL);
        }
    }
    return accessor->sparse.count == 0 || apply_sparse(g, accessor, at, floats, uints);
}

bool gltf_read_floats(struct gltf *g, uint32_t accessor, const struct at *at, float *out) {
    return read_all(g, accessor, at, out, NULL);
}

bool gltf_read_uints(struct gltf *g, uint32_t accessor, const struct at *at, uint32_t *out) {
    return read_all(g, accessor, at, NULL, out);
}
