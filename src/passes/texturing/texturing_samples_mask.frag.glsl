#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Cutouts, several samples a pixel: a hole is cut from all of them.
#define TARGETS_STORED
#include "passes/texturing/texturing_write.glsl"

void main() {
    changes c = find_changes();
    material_array materials = push.geometry.scene.scene.materials;
    if (material_cut(materials, in_ids.x, material_base_color(materials, in_ids.x).a)) discard;
    write_targets(c);
}
