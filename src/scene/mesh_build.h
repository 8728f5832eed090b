/* SPDX-License-Identifier: MIT */
/** The parts of mesh_complete. */
#ifndef FNL_SCENE_MESH_BUILD_H
#define FNL_SCENE_MESH_BUILD_H

#include "scene/scene.h"

/** Replaces every attribute by one of `count` vertices, vertex i being the old source[i]; the indices stay. False: memory ran out. */
bool mesh_gather(struct arena *arena, struct scene_primitive *primitive, const uint32_t *source, uint32_t count);
/** Tangents of indexed triangles with normals, by `uv` (one per vertex). Splits vertices where corners differ. */
fnl_result mesh_make_tangents(struct arena *arena, struct scene_primitive *primitive, const vec2 *uv);

#endif
