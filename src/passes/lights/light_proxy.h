/* SPDX-License-Identifier: MIT */
/**
 * A convex solid with eight corners round each shape: a box whose far four corners may be spread wider than the near four, down to a
 * pyramid whose near four meet in the apex (M. Mikkelsen, "Fine Pruned Tiled Light Lists", GPU Pro 7, 2.1). Narrow spots and wedges fit
 * it many times better than their bounding sphere. shaders/lights/proxy.glsl is the same on the GPU.
 */
#ifndef FNL_PASSES_LIGHT_PROXY_H
#define FNL_PASSES_LIGHT_PROXY_H

#include "lights/bounds_shared.h"

/**
 * Corners in world space. Bit 0 of the index: across (side), bit 1: up, bit 2: along the direction, far when set. They hold all of the
 * shape (of one with a hull, at least what lies in the hull). `bounds` are those of the shape. Each of the six sides is flat:
 * corners 0 1 3 2, 4 5 7 6, 0 1 5 4, 2 3 7 6, 0 2 6 4, 1 3 7 5.
 */
void shape_corners(const struct gpu_shape *shape, const struct gpu_entity_bounds *bounds, vec3 corners[8]);

#endif
