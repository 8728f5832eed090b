#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Ids with weights of cutouts.
#include "passes/visibility/weights.glsl"

void main() {
    material_array materials = push.scene.scene.materials;
    vec4 base = material_base_color(materials, in_ids.x);
    write_weights(); // derivatives before holes are cut
    if (material_cut(materials, in_ids.x, base.a)) discard;
}
