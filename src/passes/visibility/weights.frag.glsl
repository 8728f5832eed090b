#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Writes the id of what a pixel shows, the weights of the second and third corner there, and how they change over the square of four
// pixels. CUTS_HOLES: for cutouts.
#define ID_TARGETS 2
#include "passes/visibility/visibility.glsl"

layout(location = 8) in vec2 in_weights;

layout(location = 0) out vec2 out_weights; // the sign of the first: the back is seen; the second below -1: not known
layout(location = 1) out vec4 out_gradients;

void write_weights() {
    out_gradients = clamp(vec4(dFdx(in_weights), dFdy(in_weights)), -HALF_MAX, HALF_MAX);
    uint bits = floatBitsToUint(max(in_weights.x, 0.0)) | (gl_FrontFacing ? 0u : 0x80000000u);
    out_weights = vec2(uintBitsToFloat(bits), in_weights.y);
    write_id();
}

#ifdef CUTS_HOLES
void main() {
    material_array materials = push.scene.scene.materials;
    vec4 base = material_base_color(materials, in_ids.x);
    write_weights(); // derivatives before holes are cut
    if (material_cut(materials, in_ids.x, base.a)) discard;
}
#else
layout(early_fragment_tests) in;

void main() { write_weights(); }
#endif
