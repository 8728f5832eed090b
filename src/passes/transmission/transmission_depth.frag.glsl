#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Leaves out the holes of cutouts, and what lies in a nearer layer: with EACH_SAMPLE (of targets with several) at each by itself.
#include "common.glsl"
#include "view.glsl"
#include "lights/iterate.glsl"
#include "material.glsl"
#include "passes/transmission/transmission_shared.h"

layout(push_constant, scalar) uniform push_block { gpu_transmission_depth_push push; };

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    material_array materials = push.geometry.scene.scene.materials;
    bool cut = (materials.at[in_ids.x].flags & GPU_MATERIAL_MASK) != 0u && material_cut(materials, in_ids.x, material_base_color(materials, in_ids.x).a);
#ifdef EACH_SAMPLE
    float nearer = texelFetch(textures_multisampled[push.nearer], pixel, gl_SampleID).r;
#else
    float nearer = texelFetch(textures[push.nearer], pixel, 0).r;
#endif
    if (cut || gl_FragCoord.z >= nearer) discard;
}
