// SPDX-License-Identifier: MIT
// Whether a cell takes a light: what count and fill ask alike. Included after the push constants.
#ifndef CELLS_TAKES_GLSL
#define CELLS_TAKES_GLSL

// Constants, so that there is no code for the tests that are not asked for: branches may cost as much as what is in them.
layout(constant_id = CELLS_FLAGS_ID) const uint FLAGS = 0u;

// `i`: index among the lights in view.
bool cell_takes(gpu_cell_bounds bounds, uint i) {
    bool touches = (FLAGS & CELLS_PLANES) != 0u      ? cell_touches_planes(bounds, push.bounds.at[i])
                   : (FLAGS & CELLS_RECTANGLE) != 0u ? cell_touches_rectangle(bounds, push.bounds.at[i], push.reaches.at[i])
                                                          : cell_touches(bounds, push.bounds.at[i]);
    if (touches && (FLAGS & CELLS_CONES) != 0u) touches = cell_touches_cone(bounds, push.reaches.at[i]);
    return touches;
}

#endif
