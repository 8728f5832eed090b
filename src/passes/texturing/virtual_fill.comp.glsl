#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Fills pages that have become resident from the scene's images: one thread a texel of one of a page's levels.
#include "common.glsl"
#include "scene.glsl"
#include "passes/texturing/virtual_locate.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform push_block { gpu_virtual_push push; };

// Of a slot of the material, `level` below a texture of `size`; white where there is none.
vec4 source(material_array materials, uint material, int slot, vec2 t, float level, vec2 size) {
    gpu_texture s = materials.at[material].textures[slot];
    if (s.image == GPU_TEXTURE_NONE) return vec4(1.0);
    vec2 own = vec2(textureSize(textures[nonuniformEXT(s.image)], 0));
    float lod = max(level - log2(max(max(size.x / own.x, size.y / own.y), 1.0)), 0.0);
    return textureLod(sampler2D(textures[nonuniformEXT(s.image)], samplers[nonuniformEXT(s.sampler_index)]), t, lod);
}

void main() {
    uint place = push.pages.v.places.at[gl_WorkGroupID.y], block = gl_WorkGroupID.x;
    uint level = block < 256u ? 0u : block < 320u ? 1u : 2u;
    block -= level == 0u ? 0u : level == 1u ? 256u : 320u;
    uint side = VIRTUAL_PAGE >> level, across = side / 8u;
    uvec2 texel = uvec2(block % across, block / across) * 8u + gl_LocalInvocationID.xy;

    virtual_pages pages = push.pages.v.pages;
    virtual_materials held = push.pages.v.materials;
    gpu_virtual_page page = pages.at[push.pages.v.owners.at[place] - 1u];
    uint tier = page.place >> 28;
    uvec2 size = uvec2(held.at[page.material].width, held.at[page.material].height);
    vec2 at = vec2(page.place & 0x3fffu, page.place >> 14 & 0x3fffu) * float(VIRTUAL_INNER) +
              (vec2(texel) + 0.5) * exp2(float(level)) - float(VIRTUAL_BORDER);
    vec2 t = at / vec2(virtual_texels(size, tier));
    float lod = float(VIRTUAL_STEP * tier + level);

    material_array materials = push.pages.v.scene_materials;
    uint m = page.material;
    uint atlas = push.pages.v.across * VIRTUAL_PAGE;
    uvec2 origin = level == 0u ? uvec2(0u) : uvec2(atlas, level == 1u ? 0u : atlas / 2u);
    ivec2 target = ivec2(origin + uvec2(place % push.pages.v.across, place / push.pages.v.across) * side + texel);
    vec2 s = vec2(size);
    imageStore(images[push.pages.v.storage[VIRTUAL_BASE]], target, vec4(srgb_encode(source(materials, m, 0, t, lod, s).rgb), 1.0));
    imageStore(images[push.pages.v.storage[VIRTUAL_NORMAL]], target,
               vec4(source(materials, m, 2, t, lod, s).xyz, source(materials, m, 3, t, lod, s).r));
    vec4 params = source(materials, m, 1, t, lod, s);
    imageStore(images[push.pages.v.storage[VIRTUAL_PARAMS]], target, vec4(source(materials, m, 5, t, lod, s).a, params.gb, 1.0));
    if (push.pages.v.storage[VIRTUAL_EMISSIVE] != GPU_TEXTURE_NONE)
        imageStore(images[push.pages.v.storage[VIRTUAL_EMISSIVE]], target, vec4(srgb_encode(source(materials, m, 4, t, lod, s).rgb), 1.0));
    if (push.pages.v.storage[VIRTUAL_SPECULAR] != GPU_TEXTURE_NONE)
        imageStore(images[push.pages.v.storage[VIRTUAL_SPECULAR]], target, vec4(srgb_encode(source(materials, m, 6, t, lod, s).rgb), 1.0));
}
