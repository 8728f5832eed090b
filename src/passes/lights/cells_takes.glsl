// SPDX-License-Identifier: MIT
// Whether a cell takes a light: what count and fill ask alike. Included after the push constants.
#ifndef CELLS_TAKES_GLSL
#define CELLS_TAKES_GLSL

// `i`: index among the lights in view.
bool cell_takes(gpu_cell_bounds bounds, uint i) {
    bool touches = (push.flags & CELLS_PLANES) != 0u      ? cell_touches_planes(bounds, push.bounds.at[i])
                   : (push.flags & CELLS_RECTANGLE) != 0u ? cell_touches_rectangle(bounds, push.bounds.at[i], push.reaches.at[i])
                                                          : cell_touches(bounds, push.bounds.at[i]);
    if (touches && (push.flags & CELLS_CONES) != 0u) touches = cell_touches_cone(bounds, push.reaches.at[i]);
    return touches;
}

#endif
