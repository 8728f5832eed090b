/* SPDX-License-Identifier: MIT */
/** Meshes that enclose lights: unit ones for cones and boxes, and ones made for a single light. */
#ifndef FNL_PASSES_RASTER_MESH_H
#define FNL_PASSES_RASTER_MESH_H

#include "base/base.h"
#include "passes/lights/raster_shared.h"

/** The tables of struct gpu_raster. */
void raster_mesh_tables(vec3 vertices[GPU_CONE_VERTICES], uint32_t triangles[GPU_RASTER_TRIANGLES]);

/** The world-space mesh that the builder draws round a shape that is no sphere: `corners` has room for GPU_CONE_TRIANGLES, three corners each.
    Returns their number. */
uint32_t light_mesh(const struct gpu_shape *shape, const struct gpu_entity_bounds *bounds, vec3 *corners);

/**
 * A volume for a spot from what its shadow map sees (M. Drobot, "Improved Culling for Tiled and Clustered Rendering", SIGGRAPH 2017; ES-63). `depth` are `size` x
 * `size` distances along the spot's axis of the nearest surfaces, as a square perspective view from its apex along its direction
 * sees them: columns run along `side`, rows against up = side x direction, and the edges of the view touch the cone (outer angle below 90 degrees; infinite:
 * nothing in the way). Of each of `blocks` x `blocks` blocks the greatest depth ends a frustum that begins at the apex. Every point that the
 * light reaches, and that no surface hides by more than the texel's depth, is in one of them. Returns the number of triangles; `corners` has room for
 * 12 * blocks * blocks, three corners each. `blocks` divides `size`. 0: the light is no spot, or too wide.
 */
uint32_t light_mesh_from_depth(const struct gpu_shape *light, const float *depth, uint32_t size, uint32_t blocks,
                               vec3 *corners);

/** The convex hull between planes (bounds_shared.h, seen from `position`): room for 4 * count * count triangles. Returns their number, 0 if it is empty
    or reaches farther than `extent` from the position. */
uint32_t light_mesh_from_planes(vec3 position, const vec4 *planes, uint32_t count, float extent, vec3 *corners);

#endif
