/* SPDX-License-Identifier: MIT */
#include "tests/draco_encode.h"

#include <draco/compression/encode.h>
#include <draco/metadata/geometry_metadata.h>

#include <cstring>
#include <memory>

static draco::DataType type_of(uint32_t component) {
    static const draco::DataType types[] = {draco::DT_INT8,  draco::DT_UINT8,  draco::DT_INT16,  draco::DT_UINT16,
                                            draco::DT_INT32, draco::DT_UINT32, draco::DT_FLOAT32};
    return types[component - 5120];
}

static draco::GeometryAttribute::Type kind_of(char kind) {
    return kind == 'p'   ? draco::GeometryAttribute::POSITION
           : kind == 'n' ? draco::GeometryAttribute::NORMAL
           : kind == 't' ? draco::GeometryAttribute::TEX_COORD
           : kind == 'c' ? draco::GeometryAttribute::COLOR
                         : draco::GeometryAttribute::GENERIC;
}

size_t draco_encode(const struct draco_encode_mesh *in, void *out, size_t capacity) {
    draco::Mesh mesh;
    mesh.set_num_points(in->point_count);
    mesh.SetNumFaces(in->face_count);
    for (uint32_t i = 0; i < in->face_count; i++) {
        draco::Mesh::Face face;
        for (uint32_t k = 0; k < 3; k++) face[k] = in->indices[i * 3 + k];
        mesh.SetFace(draco::FaceIndex(i), face);
    }
    for (uint32_t a = 0; a < in->attribute_count; a++) {
        const struct draco_encode_attribute *source = &in->attributes[a];
        const size_t size = static_cast<size_t>(draco::DataTypeLength(type_of(source->component))) * source->component_count;
        draco::GeometryAttribute attribute;
        attribute.Init(kind_of(source->kind), nullptr, static_cast<uint8_t>(source->component_count), type_of(source->component), false,
                       static_cast<int64_t>(size), 0);
        const int id = mesh.AddAttribute(attribute, true, in->point_count);
        for (uint32_t i = 0; i < in->point_count; i++)
            mesh.attribute(id)->SetAttributeValue(draco::AttributeValueIndex(i), static_cast<const char *>(source->values) + i * size);
        mesh.attribute(id)->set_unique_id(source->id);
    }
    if (in->metadata) {
        std::unique_ptr<draco::GeometryMetadata> metadata(new draco::GeometryMetadata());
        metadata->AddEntryString("made", "for a test");
        std::unique_ptr<draco::Metadata> inner(new draco::Metadata());
        inner->AddEntryInt("depth", 1);
        std::unique_ptr<draco::Metadata> innermost(new draco::Metadata());
        innermost->AddEntryInt("depth", 2);
        inner->AddSubMetadata("deeper", std::move(innermost));
        metadata->AddSubMetadata("deep", std::move(inner));
        mesh.AddMetadata(std::move(metadata));
    }
    draco::Encoder encoder;
    encoder.SetEncodingMethod(in->sequential ? draco::MESH_SEQUENTIAL_ENCODING : draco::MESH_EDGEBREAKER_ENCODING);
    if (in->quantization) encoder.SetAttributeQuantization(draco::GeometryAttribute::POSITION, in->quantization);
    draco::EncoderBuffer buffer;
    const draco::Status status =
        in->face_count ? encoder.EncodeMeshToBuffer(mesh, &buffer) : encoder.EncodePointCloudToBuffer(mesh, &buffer);
    if (!status.ok() || buffer.size() > capacity) return 0;
    std::memcpy(out, buffer.data(), buffer.size());
    return buffer.size();
}
