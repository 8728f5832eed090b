#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Ids of cutouts, several samples a pixel: a hole is cut from all of them.
#define ID_BYTES
#include "passes/visibility/visibility.glsl"

void main() {
    material_array materials = push.scene.scene.materials;
    if (material_cut(materials, in_ids.x, material_base_color(materials, in_ids.x).a)) discard;
    write_id();
}
