/* SPDX-License-Identifier: MIT */
/** For tests: meshes compressed by libdraco's encoder. */
#ifndef FNL_TESTS_DRACO_ENCODE_H
#define FNL_TESTS_DRACO_ENCODE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

struct draco_encode_attribute {
    char kind;              /* 'p'osition, 'n'ormal, 't'exture coordinates, 'c'olour, 'g'eneric */
    uint32_t id, component; /* componentType of glTF */
    uint32_t component_count;
    const void *values; /* packed */
};

struct draco_encode_mesh {
    const struct draco_encode_attribute *attributes;
    const uint32_t *indices;
    uint32_t attribute_count, point_count, face_count; /* no faces: a point cloud */
    bool sequential, metadata;
    int quantization; /* bits of positions; 0: exact */
};

/** Bytes written; 0: the encoder would not, or `capacity` does not do. */
size_t draco_encode(const struct draco_encode_mesh *mesh, void *out, size_t capacity);

#ifdef __cplusplus
}
#endif

#endif
