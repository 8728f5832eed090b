/* SPDX-License-Identifier: MIT */
/* The shim over libdraco: draco.h. */
#include "scene/draco.h"

#include <draco/compression/decode.h>

#include <cstdio>
#include <cstring>
#include <exception>
#include <limits>
#include <memory>
#include <type_traits>

struct draco_geometry {
    std::unique_ptr<draco::Mesh> mesh;
};

namespace {

enum { BYTE = 5120, UNSIGNED_BYTE, SHORT, UNSIGNED_SHORT, UNSIGNED_INT = 5125, FLOAT }; /* componentType of glTF */

uint32_t component_of(draco::DataType type) {
    switch (type) {
    case draco::DT_INT8: return BYTE;
    case draco::DT_UINT8: return UNSIGNED_BYTE;
    case draco::DT_INT16: return SHORT;
    case draco::DT_UINT16: return UNSIGNED_SHORT;
    case draco::DT_UINT32: return UNSIGNED_INT;
    case draco::DT_FLOAT32: return FLOAT;
    default: return 0;
    }
}

template <typename From, typename To> bool convert(From value, To *out) {
    if (std::is_floating_point<From>::value != std::is_floating_point<To>::value) return false;
    *out = static_cast<To>(value);
    if (std::is_floating_point<To>::value) return true;
    return static_cast<int64_t>(value) >= static_cast<int64_t>(std::numeric_limits<To>::min()) &&
           static_cast<int64_t>(value) <= static_cast<int64_t>(std::numeric_limits<To>::max());
}

template <typename From, typename To>
bool read(const draco::PointAttribute &attribute, uint32_t points, To *out) {
    const uint32_t count = attribute.num_components();
    const int64_t size = attribute.buffer() ? static_cast<int64_t>(attribute.buffer()->data_size()) : 0;
    for (uint32_t i = 0; i < points; i++) {
        const uint32_t index = attribute.mapped_index(draco::PointIndex(i)).value();
        const int64_t start = attribute.byte_offset() + attribute.byte_stride() * static_cast<int64_t>(index);
        if (index >= attribute.size() || start < 0 || start > size - static_cast<int64_t>(count * sizeof(From))) return false;
        for (uint32_t k = 0; k < count; k++) {
            From value;
            std::memcpy(&value, attribute.buffer()->data() + start + k * sizeof(From), sizeof value);
            if (!convert(value, out + static_cast<size_t>(i) * count + k)) return false;
        }
    }
    return true;
}

template <typename To> bool read_any(const draco::PointAttribute &attribute, uint32_t points, To *out) {
    switch (attribute.data_type()) {
    case draco::DT_INT8: return read<int8_t>(attribute, points, out);
    case draco::DT_UINT8: return read<uint8_t>(attribute, points, out);
    case draco::DT_INT16: return read<int16_t>(attribute, points, out);
    case draco::DT_UINT16: return read<uint16_t>(attribute, points, out);
    case draco::DT_INT32: return read<int32_t>(attribute, points, out);
    case draco::DT_UINT32: return read<uint32_t>(attribute, points, out);
    case draco::DT_FLOAT32: return read<float>(attribute, points, out);
    default: return false;
    }
}

} // namespace

struct draco_geometry *draco_decode(const void *data, size_t size, char *message, size_t capacity) {
    try {
        draco::DecoderBuffer buffer;
        buffer.Init(static_cast<const char *>(data), size);
        draco::Decoder decoder;
        auto decoded = decoder.DecodeMeshFromBuffer(&buffer);
        if (decoded.ok()) return new draco_geometry{std::move(decoded).value()};
        std::snprintf(message, capacity, "%s", decoded.status().error_msg());
    } catch (const std::exception &e) {
        std::snprintf(message, capacity, "%s", e.what());
    } catch (...) {
        std::snprintf(message, capacity, "unknown exception");
    }
    return nullptr;
}

void draco_free(struct draco_geometry *geometry) { delete geometry; }

uint32_t draco_point_count(const struct draco_geometry *geometry) { return geometry->mesh->num_points(); }

uint32_t draco_face_count(const struct draco_geometry *geometry) { return geometry->mesh->num_faces(); }

bool draco_find_attribute(const struct draco_geometry *geometry, uint32_t id, struct draco_attribute *out) {
    const draco::PointAttribute *attribute = geometry->mesh->GetAttributeByUniqueId(id);
    if (!attribute) return false;
    out->component_count = attribute->num_components();
    out->component = component_of(attribute->data_type());
    return true;
}

bool draco_read_attribute(const struct draco_geometry *geometry, uint32_t id, uint32_t component, void *out) {
    const draco::PointAttribute *attribute = geometry->mesh->GetAttributeByUniqueId(id);
    const uint32_t points = geometry->mesh->num_points();
    if (!attribute) return false;
    switch (component) {
    case BYTE: return read_any(*attribute, points, static_cast<int8_t *>(out));
    case UNSIGNED_BYTE: return read_any(*attribute, points, static_cast<uint8_t *>(out));
    case SHORT: return read_any(*attribute, points, static_cast<int16_t *>(out));
    case UNSIGNED_SHORT: return read_any(*attribute, points, static_cast<uint16_t *>(out));
    case UNSIGNED_INT: return read_any(*attribute, points, static_cast<uint32_t *>(out));
    case FLOAT: return read_any(*attribute, points, static_cast<float *>(out));
    default: return false;
    }
}

bool draco_read_faces(const struct draco_geometry *geometry, uint32_t *out) {
    const uint32_t points = geometry->mesh->num_points(), faces = geometry->mesh->num_faces();
    for (uint32_t i = 0; i < faces; i++) {
        const draco::Mesh::Face &face = geometry->mesh->face(draco::FaceIndex(i));
        for (int k = 0; k < 3; k++) {
            out[static_cast<size_t>(i) * 3 + k] = face[k].value();
            if (face[k].value() >= points) return false;
        }
    }
    return true;
}
