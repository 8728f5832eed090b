/* SPDX-License-Identifier: MIT */
/* The declared 'min' and 'max' of accessors against their elements (glTF 2.0, 3.6.2.5). Nothing relies on them. */
#include "scene/gltf.h"

#define COMPONENTS_MAX 16

struct bounds {
    uint32_t count; /* of components */
    double low[COMPONENTS_MAX], high[COMPONENTS_MAX];
};

/** `bytes` NULL: zeros. Values that are not finite are complained of where they are used. */
static void add_element(struct bounds *bounds, const struct gltf_accessor *accessor, const unsigned char *bytes) {
    for (uint32_t k = 0; k < bounds->count; k++) {
        double value = bytes ? gltf_component_value(bytes + gltf_component_offset(accessor, k), accessor->component) : 0;
        if (!isfinite(value)) continue;
        bounds->low[k] = fmin(bounds->low[k], value);
        bounds->high[k] = fmax(bounds->high[k], value);
    }
}

/** False: the sparse indices are broken, which is complained of where they are used. */
static bool find_bounds(const struct gltf *g, const struct gltf_accessor *accessor, struct bounds *bounds) {
    const unsigned char *base = accessor->view == SCENE_NONE ? NULL : g->views[accessor->view].data + accessor->offset;
    uint32_t stride = gltf_accessor_stride(g, accessor), packed = gltf_packed_stride(accessor), next = 0;
    for (uint32_t i = 0; i < accessor->sparse.count; i++) {
        uint32_t index = gltf_sparse_index(g, accessor, i);
        if (index < next || index >= accessor->count) return false;
        for (; base && next < index; next++) add_element(bounds, accessor, base + (size_t)next * stride);
        add_element(bounds, accessor,
                    g->views[accessor->sparse.value_view].data + accessor->sparse.value_offset + (size_t)i * packed);
        next = index + 1;
    }
    for (; base && next < accessor->count; next++) add_element(bounds, accessor, base + (size_t)next * stride);
    if (!base && accessor->sparse.count < accessor->count) add_element(bounds, accessor, NULL);
    return true;
}

static void compare(struct gltf *g, json_t *object, const struct at *at, const char *key,
                    const struct gltf_accessor *accessor, const struct bounds *bounds, const double *actual) {
    if (!json_object_get(object, key)) return;
    const struct at *here = AT_KEY(at, key);
    json_t *array = gltf_array(g, object, at, key, false);
    if (!array) return;
    if (json_array_size(array) != bounds->count) {
        gltf_warn(g, here, "has %zu numbers for %u components; it is ignored", json_array_size(array), bounds->count);
        return;
    }
    for (uint32_t k = 0; k < bounds->count; k++) {
        json_t *value = json_array_get(array, k);
        if (!json_is_number(value)) {
            gltf_warn(g, AT_INDEX(here, k), "is not a finite number; it is ignored");
            continue;
        }
        double declared = json_number_value(value);
        /* Decimals of six digits are within this of the float that they stand for. */
        double size = fmax(fabs(bounds->low[k]), fabs(bounds->high[k]));
        double tolerance = accessor->component == GLTF_FLOAT ? 5e-6 * size : 0;
        if (bounds->low[k] <= bounds->high[k] && fabs(declared - actual[k]) > tolerance)
            gltf_warn(g, AT_INDEX(here, k), "is %.10g, but the elements' is %.10g, which is used", declared, actual[k]);
    }
}

void gltf_check_bounds(struct gltf *g, json_t *object, const struct at *at, const struct gltf_accessor *accessor) {
    if (!json_object_get(object, "min") && !json_object_get(object, "max")) return;
    bool readable = accessor->view == SCENE_NONE || g->views[accessor->view].data;
    if (accessor->sparse.count > 0)
        readable &= g->views[accessor->sparse.index_view].data && g->views[accessor->sparse.value_view].data;
    if (!readable) return;
    /* Any number of accessors may share bytes: comparing all of them must not take time out of proportion to the file. */
    uint32_t read = accessor->view == SCENE_NONE ? accessor->sparse.count : accessor->count;
    uint64_t cost = ((uint64_t)read + accessor->sparse.count) * gltf_packed_stride(accessor);
    if (cost > g->check_left) return;
    g->check_left -= cost;
    struct bounds bounds = {.count = gltf_type_components(accessor->type)};
    for (uint32_t k = 0; k < bounds.count; k++) {
        bounds.low[k] = INFINITY;
        bounds.high[k] = -INFINITY;
    }
    if (!find_bounds(g, accessor, &bounds)) return;
    compare(g, object, at, "min", accessor, &bounds, bounds.low);
    compare(g, object, at, "max", accessor, &bounds, bounds.high);
}
