/* SPDX-License-Identifier: MIT */
/** libdraco, a C++ library, as C sees it. draco.cpp is the only C++ of the library; no exception leaves it. */
#ifndef FNL_SCENE_DRACO_H
#define FNL_SCENE_DRACO_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

struct draco_geometry;

struct draco_attribute {
    uint32_t component_count;
    uint32_t component; /* componentType of glTF; 0: none that glTF has */
};

/**
 * Decodes a triangle mesh; free it with draco_free(). NULL: `message` has the library's words. Nothing here limits what it allocates: look at
 * the counts in the header first.
 */
struct draco_geometry *draco_decode(const void *data, size_t size, char *message, size_t capacity);
void draco_free(struct draco_geometry *geometry);
uint32_t draco_point_count(const struct draco_geometry *geometry);
uint32_t draco_face_count(const struct draco_geometry *geometry);
/** The attribute of a unique id. False: there is none. */
bool draco_find_attribute(const struct draco_geometry *geometry, uint32_t id, struct draco_attribute *out);
/**
 * Its values at all points, tightly packed, as glTF's type `component`. Integers may change their type as long as every value fits. False: one
 * does not, or integers and floats would mix.
 */
bool draco_read_attribute(const struct draco_geometry *geometry, uint32_t id, uint32_t component, void *out);
/** Three corners per face. False: one of them names no point. */
bool draco_read_faces(const struct draco_geometry *geometry, uint32_t *out);

#ifdef __cplusplus
}
#endif

#endif
