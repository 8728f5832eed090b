// SPDX-License-Identifier: MIT
// Which lights touch the view at all.
#ifndef IN_VIEW_GLSL
#define IN_VIEW_GLSL

#include "passes/lights/cells.glsl"

// Sphere against the five planes of the view, widened so that rounding never loses a light. NaN counts as in view.
bool light_in_view(view_block v, vec3 center, float radius) {
    float slack = radius * (1.0 + CELL_SLACK) + CELL_SLACK * (1e-2 + distance(center, v.view.eye) * 1e-2) +
                  float(BOUND_ROUNDING) * (length(center) + length(v.view.eye));
    bool visible = true;
    for (int i = 0; i < 5; i++) {
        vec4 plane = v.view.planes[i];
        visible = visible && !(dot(plane.xyz, center) + plane.w < -slack);
    }
    return visible;
}

#endif
