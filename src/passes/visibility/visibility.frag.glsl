#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Ids of surfaces. CUTS_HOLES: for cutouts, whose holes are found here; with several samples a pixel (ID_BYTES) a hole is cut from all of them.
#include "passes/visibility/visibility.glsl"

#ifdef CUTS_HOLES
void main() {
    material_array materials = push.scene.scene.materials;
    if (material_cut(materials, in_ids.x, material_base_color(materials, in_ids.x).a)) discard;
    write_id();
}
#else
layout(early_fragment_tests) in;

void main() { write_id(); }
#endif
