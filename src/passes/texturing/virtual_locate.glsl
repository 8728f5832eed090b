// SPDX-License-Identifier: MIT
// From texture coordinates to a place in the atlas.
#ifndef VIRTUAL_LOCATE_GLSL
#define VIRTUAL_LOCATE_GLSL

#include "scene.glsl"
#include "passes/texturing/virtual_shared.h"

float virtual_wrap(float t, uint wrap) {
    if (wrap == VIRTUAL_REPEAT) t -= floor(t);
    if (wrap == VIRTUAL_MIRROR) t = 1.0 - abs(t - 2.0 * floor(t * 0.5) - 1.0);
    return t > 0.0 ? min(t, 1.0) : 0.0; // NaN: 0
}

// Of a texture of `size`, at a tier.
uvec2 virtual_texels(uvec2 size, uint tier) { return max(size >> VIRTUAL_STEP * tier, uvec2(1u)); }

// Place and remainder in eighths of texels: x | y << 16. Of the page that shows the level of detail which the hardware would take, or,
// where that is not resident, of the next that is; all those are wanted in the next frame. Of a level below what the page holds that is always
// resident: that page while its own is not.
uint virtual_locate(virtual_block block, uint material, vec4 uvs, vec4 dx, vec4 dy) {
    virtual_materials materials = block.v.materials;
    uint tiers = materials.at[material].tiers, wrap = materials.at[material].wrap;
    if (tiers == 0u) return VIRTUAL_NOWHERE;
    bool first = materials.at[material].uv_set == 0u;
    mat2 turn = mat2(materials.at[material].transform[0], materials.at[material].transform[3], materials.at[material].transform[1],
                     materials.at[material].transform[4]);
    vec2 shift = vec2(materials.at[material].transform[2], materials.at[material].transform[5]);
    vec2 t = turn * (first ? uvs.xy : uvs.zw) + shift;
    uvec2 size = uvec2(materials.at[material].width, materials.at[material].height);
    vec2 along = turn * (first ? dx.xy : dx.zw) * vec2(size), down = turn * (first ? dy.xy : dy.zw) * vec2(size);
    float level = log2(max(max(length(along), length(down)), 1.0));
    t = vec2(virtual_wrap(t.x, wrap & 3u), virtual_wrap(t.y, wrap >> 2 & 3u));
    uint result = VIRTUAL_NOWHERE, whole = materials.at[material].whole;
    uint finest = min(uint(min(level, 30.0)) / VIRTUAL_STEP, tiers - 1u), count = max(finest, whole) - min(finest, whole) + 1u;
    for (uint i = 0u; i < count; i++) {
        // On to coarser ones up to the whole one; from what is coarser still straight to it.
        uint tier = finest <= whole ? finest + i : i == 0u ? finest : whole;
        uvec2 texels = virtual_texels(size, tier), pages = (texels + VIRTUAL_INNER - 1u) / VIRTUAL_INNER;
        vec2 at = t * vec2(texels);
        uvec2 page = min(uvec2(at) / VIRTUAL_INNER, pages - 1u);
        uint number = materials.at[material].first_page[tier] + page.y * pages.x + page.x;
        block.v.wanted.at[number] = 1u;
        uint place = block.v.table.at[number];
        if (result != VIRTUAL_NOWHERE || place == 0u) continue;
        vec2 corner = vec2((place - 1u) % block.v.across, (place - 1u) / block.v.across) * float(VIRTUAL_PAGE);
        uvec2 eighths = uvec2(round((corner + at - vec2(page * VIRTUAL_INNER) + float(VIRTUAL_BORDER)) * 8.0));
        result = eighths.x | eighths.y << 16;
    }
    return result;
}

#endif
