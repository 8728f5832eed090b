#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Lists what is to be shaded, pixel by pixel, with the keys that it is sorted by.
#include "common.glsl"
#include "scene.glsl"
#include "view.glsl"
#include "passes/visibility/visible.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform push_block { gpu_visible_push push; };

uint key_of(ivec2 pixel, uint at) {
    uvec2 id = visible_id(push.ids, push.ids_high, pixel, int(at));
    gpu_item item = push.scene.scene.items.at[visible_item(id, push.triangle_bits) - 1u];
    uint material = push.scene.scene.primitives.at[item.primitive].material;
    uint kind = push.scene.scene.materials.at[material].flags >> GPU_MATERIAL_CLASS_SHIFT & (GPU_CLASSES - 1u);
    return push.material_bits == 0u ? kind : kind << push.material_bits | material;
}

void main() {
    uint place = (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * 64u + gl_LocalInvocationIndex;
    uvec2 size = push.view.view.size, pixel = pixel_of_place(gl_WorkGroupID.xy, gl_LocalInvocationIndex);
    if (any(greaterThanEqual(pixel, size))) return;
    uint index = pixel.y * size.x + pixel.x, first = push.sums.at[place], count = push.sums.at[place + 1u] - first;
    uint word = SAMPLES > 1u && count > 0u ? push.words.at[index] : 0u;
    for (uint i = 0u; i < count; i++) {
        uint entry = index | i << VISIBLE_SURFACE_SHIFT;
        if (LISTED == VISIBLE_SORTED) {
            push.entries.at[(first + i) * 2u] = key_of(ivec2(pixel), SAMPLES > 1u ? uint(findLSB(surface_samples(word, i))) : 0u);
            push.entries.at[(first + i) * 2u + 1u] = entry;
        } else {
            push.entries.at[first + i] = entry;
        }
    }
}
