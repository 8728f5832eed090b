/* SPDX-License-Identifier: MIT */
/*
 * KHR_draco_mesh_compression. What a primitive's compressed mesh holds becomes plain buffer views and accessors behind those of the file, and
 * the primitive in the document is made to name them; the rest of the importer then reads it as any other.
 */
#include "scene/draco.h"
#include "scene/gltf.h"

#define EXTENSION "KHR_draco_mesh_compression"

static json_t *compressed(json_t *primitive) {
    json_t *extension = json_object_get(json_object_get(primitive, "extensions"), EXTENSION);
    return json_is_object(extension) ? extension : NULL;
}

static void mark(struct gltf *g, json_t *index) {
    json_int_t value = json_is_integer(index) ? json_integer_value(index) : -1;
    if (value >= 0 && (uint64_t)value < g->accessor_count) g->accessors[value].compressed = true;
}

void gltf_mark_compressed(struct gltf *g) {
    json_t *meshes = json_object_get(g->root, "meshes");
    for (size_t i = 0; i < json_array_size(meshes); i++) {
        json_t *primitives = json_object_get(json_array_get(meshes, i), "primitives");
        for (size_t k = 0; k < json_array_size(primitives); k++) {
            json_t *primitive = json_array_get(primitives, k), *extension = compressed(primitive), *value;
            const char *name;
            if (!extension) continue;
            json_object_foreach(json_object_get(extension, "attributes"), name, value)
                mark(g, json_object_get(json_object_get(primitive, "attributes"), name));
            mark(g, json_object_get(primitive, "indices"));
        }
    }
}

#ifdef FANAL_DRACO

/* ---- the head of the data (Draco Bitstream Specification 2.2, 3 to 6), which says how much decoding will take ---- */

struct bytes {
    const unsigned char *at;
    size_t left;
    bool ended;
};

static void skip(struct bytes *in, size_t count) {
    in->ended |= count > in->left;
    count = MIN(count, in->left);
    in->at += count;
    in->left -= count;
}

static uint32_t read_byte(struct bytes *in) {
    uint32_t value = in->left ? *in->at : 0;
    skip(in, 1);
    return value;
}

static uint32_t read_varint(struct bytes *in) {
    uint32_t value = 0;
    for (uint32_t shift = 0; shift < 35; shift += 7) {
        uint32_t byte = read_byte(in);
        value |= (byte & 0x7f) << shift;
        if (!(byte & 0x80)) return value;
    }
    in->ended = true;
    return 0;
}

/** Nested elements follow each other, the deepest first. */
static void skip_metadata_element(struct bytes *in) {
    uint64_t pending = 1;
    for (bool named = false; pending > 0 && !in->ended; named = true) {
        pending--;
        if (named) skip(in, read_byte(in));
        for (uint32_t entries = read_varint(in); entries > 0 && !in->ended; entries--) {
            skip(in, read_byte(in));
            skip(in, read_varint(in));
        }
        pending += read_varint(in);
    }
}

/** NULL: all is well, and the mesh says it has so many faces. */
static const char *read_head(const unsigned char *data, size_t size, uint32_t *faces) {
    struct bytes in = {data, size, false};
    if (size < 11 || memcmp(data, "DRACO", 5) != 0) return "does not begin with DRACO";
    if (data[7] != 1) return "is a point cloud, not a triangle mesh";
    if (data[5] != 2 || data[6] != 2) return "is not of version 2.2 of the bitstream, which the extension asks for";
    uint32_t method = data[8];
    if (method > 1) return "has an unknown encoding";
    skip(&in, 11);
    if (data[10] & 0x80) {
        for (uint32_t i = read_varint(&in); i > 0 && !in.ended; i--) {
            read_varint(&in);
            skip_metadata_element(&in);
        }
        skip_metadata_element(&in);
    }
    if (method == 1) {
        read_byte(&in);   /* traversal */
        read_varint(&in); /* vertices */
    }
    *faces = read_varint(&in);
    return in.ended ? "ends within its head" : NULL;
}

/* ---- one primitive ---- */

/** What was decoded last from a buffer view: primitives with the same data share it. */
struct decoded {
    json_t *extension, *attributes, *indices; /* as they stood */
    json_t *primitive;                        /* as it became */
};

static void forget(struct decoded *decoded) {
    json_decref(decoded->attributes);
    json_decref(decoded->indices);
    *decoded = (struct decoded){0};
}

static uint32_t add_accessor(struct gltf *g, const struct gltf_accessor *like, void *data, uint32_t count, enum gltf_component component) {
    uint64_t size = (uint64_t)count * gltf_component_size(component) * gltf_type_components(like->type);
    g->views[g->view_count] = (struct gltf_view){.data = data, .size = size, .valid = true, .attribute_accessor = SCENE_NONE};
    g->accessors[g->accessor_count] = (struct gltf_accessor){
        .valid = true, .normalized = like->normalized, .component = component, .type = like->type, .count = count, .view = g->view_count++};
    g->budget += 64 * size;
    return g->accessor_count++;
}

static bool read_attribute(struct gltf *g, const struct draco_geometry *geometry, json_t *value, const struct at *at, json_t *attributes,
                           const char *name) {
    if (!json_object_get(attributes, name)) {
        gltf_warn(g, at, "the primitive itself has no such attribute; it is ignored");
        return true;
    }
    const uint32_t index = gltf_index_value(g, json_object_get(attributes, name), at, g->accessor_count);
    const json_int_t id = json_is_integer(value) ? json_integer_value(value) : -1;
    struct draco_attribute attribute;
    if (index == SCENE_NONE) return false;
    const struct gltf_accessor accessor = g->accessors[index];
    if (id < 0 || id > UINT32_MAX || !draco_find_attribute(geometry, (uint32_t)id, &attribute)) {
        gltf_warn(g, at, "the compressed mesh has no attribute of this id");
        return false;
    }
    if (!accessor.valid && accessor.view != SCENE_NONE) {
        gltf_warn(g, at, "accessor %u is broken", index);
        return false;
    }
    const uint32_t points = draco_point_count(geometry);
    if (points != accessor.count) {
        gltf_warn(g, at, "accessor %u has %u elements, but the compressed mesh has %u points", index, accessor.count, points);
        return false;
    }
    if (attribute.component_count != gltf_type_components(accessor.type)) {
        gltf_warn(g, at, "accessor %u has %u components, but the compressed attribute has %u", index, gltf_type_components(accessor.type),
                  attribute.component_count);
        return false;
    }
    const uint64_t size = (uint64_t)points * attribute.component_count * gltf_component_size(accessor.component);
    if (!gltf_spend(g, at, size)) return false;
    unsigned char *data = gltf_keep(g, MAX(size, 1), 1);
    if (!data) return false;
    if (!draco_read_attribute(geometry, (uint32_t)id, accessor.component, data)) {
        char format[64];
        gltf_warn(g, at, "the compressed values are not what accessor %u has, %s", index, gltf_format_name(&accessor, format, sizeof format));
        return false;
    }
    json_object_set_new(attributes, name, json_integer(add_accessor(g, &accessor, data, points, accessor.component)));
    return true;
}

static bool read_indices(struct gltf *g, const struct draco_geometry *geometry, const struct at *at, json_t *primitive, bool strip) {
    const struct at *here = AT_KEY(at, "indices");
    const uint64_t corners = (uint64_t)draco_face_count(geometry) * 3;
    if (json_object_get(primitive, "indices")) {
        const uint32_t index = gltf_index_value(g, json_object_get(primitive, "indices"), here, g->accessor_count);
        if (index == SCENE_NONE) return false;
        const struct gltf_accessor *accessor = &g->accessors[index];
        /* A strip of so many indices has two triangles fewer, and some of those have no area. */
        if (strip ? corners > (uint64_t)accessor->count * 3 : corners != accessor->count) {
            gltf_warn(g, here, "accessor %u has %u indices, but the compressed mesh has %llu", index, accessor->count, (unsigned long long)corners);
            return false;
        }
        const uint64_t most = accessor->component == GLTF_UNSIGNED_BYTE ? 1u << 8 : accessor->component == GLTF_UNSIGNED_SHORT ? 1u << 16 : UINT32_MAX;
        if (draco_point_count(geometry) > most) {
            gltf_warn(g, here, "the %u points of the compressed mesh are too many for the component type of accessor %u", draco_point_count(geometry), index);
            return false;
        }
    }
    if (corners == 0) {
        gltf_warn(g, at, "the compressed mesh has no triangles");
        return false;
    }
    if (!gltf_spend(g, here, corners * sizeof(uint32_t))) return false;
    uint32_t *data = gltf_keep(g, corners, sizeof *data);
    if (!data) return false;
    if (!draco_read_faces(geometry, data)) {
        gltf_warn(g, at, "the compressed triangles name points that there are not");
        return false;
    }
    const struct gltf_accessor like = {.type = GLTF_SCALAR};
    json_object_set_new(primitive, "indices", json_integer(add_accessor(g, &like, data, (uint32_t)corners, GLTF_UNSIGNED_INT)));
    json_object_set_new(primitive, "mode", json_integer(4));
    return true;
}

/** False (warned): the compressed mesh cannot be used. */
static bool decode(struct gltf *g, json_t *primitive, json_t *extension, const struct at *primitive_at, const struct at *at, struct decoded *last) {
    const uint32_t view_index = gltf_index(g, extension, at, "bufferView", true, g->view_count);
    json_t *names = gltf_object(g, extension, at, "attributes", true), *attributes = json_object_get(primitive, "attributes"), *value;
    const char *name;
    uint64_t mode = 4;
    if (json_object_get(primitive, "mode") && (!gltf_uint(g, primitive, primitive_at, "mode", false, 0, 6, &mode) || (mode != 4 && mode != 5))) {
        gltf_warn(g, AT_KEY(primitive_at, "mode"), "only triangles and triangle strips can be compressed");
        return false;
    }
    if (view_index == SCENE_NONE || !names || !json_is_object(attributes)) return false;
    struct decoded *same = &last[view_index];
    if (same->primitive && json_equal(same->extension, extension) && json_equal(same->attributes, attributes) &&
        (same->indices ? json_equal(same->indices, json_object_get(primitive, "indices")) : !json_object_get(primitive, "indices"))) {
        json_object_update(attributes, json_object_get(same->primitive, "attributes"));
        json_object_set(primitive, "indices", json_object_get(same->primitive, "indices"));
        json_object_set_new(primitive, "mode", json_integer(4));
        return true;
    }
    const struct gltf_view view = g->views[view_index];
    uint32_t faces = 0;
    if (!view.valid || !view.data) {
        gltf_warn(g, AT_KEY(at, "bufferView"), "the bytes of buffer view %u are missing", view_index);
        return false;
    }
    const char *fault = read_head(view.data, view.size, &faces);
    if (fault) {
        gltf_warn(g, at, "the compressed data %s", fault);
        return false;
    }
    /* What the library takes for a while. Edgebreaker writes at least a third of a bit for a face, plus what its values take. */
    const uint64_t passing = (uint64_t)faces * 48;
    if (faces / 64 > view.size + 1024) {
        gltf_warn(g, at, "%llu compressed bytes cannot hold %u triangles", (unsigned long long)view.size, faces);
        return false;
    }
    if (!gltf_spend(g, at, passing)) return false;
    char message[200] = "";
    struct draco_geometry *geometry = draco_decode(view.data, view.size, message, sizeof message);
    if (!geometry) {
        gltf_warn(g, at, "the compressed data is broken: %s", message);
        return false;
    }
    forget(same);
    *same = (struct decoded){.extension = extension, .attributes = json_deep_copy(attributes), .indices = json_incref(json_object_get(primitive, "indices"))};
    const struct at *names_at = AT_KEY(at, "attributes");
    bool good = read_indices(g, geometry, primitive_at, primitive, mode == 5);
    json_object_foreach(names, name, value) good = good && read_attribute(g, geometry, value, AT_KEY(names_at, name), attributes, name);
    draco_free(geometry);
    if (good) {
        gltf_refund(g, passing);
        same->primitive = primitive;
    } else { /* what stood there may be plain data for those who cannot decompress */
        json_object_update(attributes, same->attributes);
        if (same->indices)
            json_object_set(primitive, "indices", same->indices);
        else
            json_object_del(primitive, "indices");
        json_object_set_new(primitive, "mode", json_integer((json_int_t)mode));
        forget(same);
    }
    return good;
}

static bool has_fallback(const struct gltf *g, json_t *primitive) {
    json_t *position = json_object_get(json_object_get(primitive, "attributes"), "POSITION");
    const json_int_t index = json_is_integer(position) ? json_integer_value(position) : -1;
    return index >= 0 && (uint64_t)index < g->accessor_count && g->accessors[index].valid;
}

/** Room for what all compressed primitives hold at most. */
static bool reserve(struct gltf *g, json_t *meshes) {
    uint64_t more = 0;
    for (size_t i = 0; i < json_array_size(meshes); i++) {
        json_t *primitives = json_object_get(json_array_get(meshes, i), "primitives");
        for (size_t k = 0; k < json_array_size(primitives); k++) {
            json_t *extension = compressed(json_array_get(primitives, k));
            if (extension) more += 1 + json_object_size(json_object_get(extension, "attributes"));
        }
    }
    if (more == 0 || more + g->view_count >= UINT32_MAX || more + g->accessor_count >= UINT32_MAX) return false;
    struct gltf_view *views = gltf_scratch(g, g->view_count + more, sizeof *views);
    struct gltf_accessor *accessors = gltf_scratch(g, g->accessor_count + more, sizeof *accessors);
    if (!views || !accessors) return false;
    if (g->view_count) memcpy(views, g->views, sizeof *views * g->view_count);
    if (g->accessor_count) memcpy(accessors, g->accessors, sizeof *accessors * g->accessor_count);
    g->views = views;
    g->accessors = accessors;
    return true;
}

void gltf_load_compressed(struct gltf *g) {
    json_t *meshes = json_object_get(g->root, "meshes");
    const struct at *meshes_at = AT_KEY(&g->top, "meshes");
    const uint32_t view_count = g->view_count;
    if (!json_is_array(meshes) || !reserve(g, meshes)) return;
    struct decoded *last = gltf_scratch(g, MAX(view_count, 1), sizeof *last);
    for (size_t i = 0; last && i < json_array_size(meshes); i++) {
        const struct at *mesh_at = AT_INDEX(meshes_at, i), *primitives_at = AT_KEY(mesh_at, "primitives");
        json_t *primitives = json_object_get(json_array_get(meshes, i), "primitives");
        for (size_t k = 0; k < json_array_size(primitives) && g->result == FNL_OK; k++) {
            json_t *primitive = json_array_get(primitives, k), *extension = compressed(primitive);
            const struct at *at = AT_INDEX(primitives_at, k), *extensions_at = AT_KEY(at, "extensions"), *here = AT_KEY(extensions_at, EXTENSION);
            if (!extension || decode(g, primitive, extension, at, here, last)) continue;
            gltf_warn(g, here, has_fallback(g, primitive) ? "the primitive's plain data is used" : "the primitive has no other data");
        }
    }
    for (uint32_t i = 0; last && i < view_count; i++) forget(&last[i]);
}

#else

void gltf_load_compressed(struct gltf *g) { UNUSED(g); }

#endif
