// SPDX-License-Identifier: MIT
// Whether a cell takes a light, with the masks and ranges of the kinds of tiles that have such. Included after the push constants.
#ifndef CELLS_ENTRY_GLSL
#define CELLS_ENTRY_GLSL

#include "passes/lights/cells_depths.glsl"
#include "passes/lights/cells_takes.glsl"

// `i`: index among the lights in view. `range`: of CELLS_RANGES.
bool cell_takes_entry(gpu_cell_bounds bounds, uint cell, uint i, out uint range) {
    range = 0u;
    if ((FLAGS & CELLS_MASKS) != 0u && (push.extra.at[cell] & cell_light_mask(bounds, push.bounds.at[i])) == 0u) return false;
    if (!cell_takes(bounds, i)) return false;
    if ((FLAGS & CELLS_RANGES) == 0u) return true;
    vec2 depths;
    if (!cell_sphere_depths(bounds, push.bounds.at[i], depths)) return false;
    if ((FLAGS & CELLS_CONES) != 0u && !cone_depths(push.reaches.at[i], depths)) return false;
    range = depth_range(depths.x, depths.y);
    return true;
}

#endif
