#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Cutouts: the holes are found here, by the one texture that this pass reads.
#include "passes/texturing/texturing_write.glsl"

void main() {
    changes c = find_changes();
    material_array materials = push.geometry.scene.scene.materials;
    if (material_cut(materials, in_ids.x, material_base_color(materials, in_ids.x).a)) discard;
    write_targets(c);
}
