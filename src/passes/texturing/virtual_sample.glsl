// SPDX-License-Identifier: MIT
// Reads the atlas at a pixel: how far coordinates go to the next one tells the level, as hardware would tell it.
#include "passes/texturing/virtual_locate.glsl"
#include "srgb.glsl"

layout(constant_id = SHOWS_LEVELS_ID) const uint SHOWS_LEVELS = 0u;

vec2 atlas_at;     // texels
uint atlas_tier;
float atlas_level; // 0 .. VIRTUAL_LEVELS - 1
float atlas_asked; // the same as neighbours tell it, before it is kept within the page

struct virtual_point {
    uint material, tier;
    vec2 at; // texels of the whole texture, at the tier's size
};

virtual_point virtual_point_of(uint packed) {
    uvec2 eighths = uvec2(packed & 0xffffu, packed >> 16), place = eighths / (8u * VIRTUAL_PAGE);
    uint owner = push.pages.v.owners.at[place.y * push.pages.v.across + place.x] - 1u;
    virtual_pages pages = push.pages.v.pages;
    uint where = pages.at[owner].place;
    vec2 page = vec2(where & 0x3fffu, where >> 14 & 0x3fffu) * float(VIRTUAL_INNER);
    vec2 inside = vec2(eighths - place * 8u * VIRTUAL_PAGE) * 0.125 - float(VIRTUAL_BORDER);
    return virtual_point(pages.at[owner].material, where >> 28, page + inside);
}

// Of the neighbours on either side of the same material the one with the nearest coordinates; whether one is near enough. A page's tier
// holds what changes by less than 4 texels a pixel, but for the one that is always resident and those below it.
bool virtual_change(ivec2 pixel, ivec2 side, virtual_point p, uvec2 size, vec2 period, bool is_whole, out float distance) {
    vec2 texels = vec2(virtual_texels(size, p.tier));
    distance = 1e30;
    for (int i = 0; i < 2 * SEEN_SAMPLES; i++) {
        int at = i % SEEN_SAMPLES;
        ivec2 other = pixel + side * (i < SEEN_SAMPLES ? -1 : 1);
        if (any(lessThan(other, ivec2(0))) || any(greaterThanEqual(uvec2(other), push.view.view.size))) continue;
        if (depth_at(other, at) <= 0.0) continue;
        uint packed = target(TARGET_UV, other, at).x;
        if (packed == VIRTUAL_NOWHERE) continue;
        virtual_point q = virtual_point_of(packed);
        if (q.material != p.material) continue;
        vec2 change = (q.tier == p.tier ? q.at : q.at / vec2(virtual_texels(size, q.tier)) * texels) - p.at;
        change -= period * round(change / max(period, vec2(1.0)));
        distance = min(distance, length(change));
    }
    return distance < (is_whole ? 1e30 : 8.0);
}

// Fills atlas_at and atlas_level; the material.
uint virtual_find(ivec2 pixel, int at) {
    uint packed = target(TARGET_UV, pixel, at).x;
    atlas_at = vec2(packed & 0xffffu, packed >> 16) * 0.125;
    virtual_point p = virtual_point_of(packed);
    atlas_tier = p.tier;
    virtual_materials materials = push.pages.v.materials;
    uint wrap = materials.at[p.material].wrap;
    bool is_whole = p.tier >= materials.at[p.material].whole;
    uvec2 size = uvec2(materials.at[p.material].width, materials.at[p.material].height), texels = virtual_texels(size, p.tier);
    // Nothing is taken off where coordinates do not repeat.
    vec2 period = vec2((wrap & 3u) == VIRTUAL_REPEAT ? texels.x : 0u, (wrap >> 2 & 3u) == VIRTUAL_REPEAT ? texels.y : 0u);
    period = mix(vec2(1e30), period, greaterThan(period, vec2(0.0)));
    float along, down;
    bool has_along = virtual_change(pixel, ivec2(1, 0), p, size, period, is_whole, along);
    bool has_down = virtual_change(pixel, ivec2(0, 1), p, size, period, is_whole, down);
    float longest = max(has_along ? along : 0.0, has_down ? down : 0.0);
    atlas_asked = has_along || has_down ? log2(max(longest, 1e-6)) : 1.0; // in the middle of what the tier holds
    atlas_level = clamp(atlas_asked, 0.0, float(VIRTUAL_LEVELS - 1u));
    return p.material;
}

// Where a level of the atlas begins in its image, texels: the two smaller ones stand beside the first.
vec2 atlas_origin(uint level) {
    float side = float(push.pages.v.across * VIRTUAL_PAGE);
    return level == 0u ? vec2(0.0) : vec2(side, level == 1u ? 0.0 : side * 0.5);
}


// Images that are written cannot be sRGB: colours are decoded before they are filtered.
vec4 atlas_color(uint layer, uint level) {
    vec2 at = atlas_origin(level) + atlas_at * exp2(-float(level)) - 0.5;
    ivec2 first = ivec2(floor(at));
    vec2 share = at - vec2(first);
    uint image = push.pages.v.sampled[layer];
    vec3 sum = vec3(0.0);
    for (int i = 0; i < 4; i++) {
        ivec2 step = ivec2(i & 1, i >> 1);
        vec2 weight = mix(1.0 - share, share, vec2(step));
        sum += srgb_decode(texelFetch(textures[image], first + step, 0).rgb) * weight.x * weight.y;
    }
    return vec4(sum, 1.0);
}

vec4 atlas_data(uint layer, uint level) {
    float side = float(push.pages.v.across * VIRTUAL_PAGE);
    vec2 at = (atlas_origin(level) + atlas_at * exp2(-float(level))) / vec2(side * 1.5, side);
    return textureLod(sampler2D(textures[push.pages.v.sampled[layer]], samplers[push.pages.v.sampler_index]), at, 0.0);
}

vec4 atlas_texel(uint layer) {
    bool is_color = layer == VIRTUAL_BASE || layer >= VIRTUAL_EMISSIVE;
    uint level = min(uint(atlas_level), VIRTUAL_LEVELS - 2u);
    float share = atlas_level - float(level);
    vec4 fine = is_color ? atlas_color(layer, level) : atlas_data(layer, level);
    if (share <= 0.0) return fine;
    return mix(fine, is_color ? atlas_color(layer, level + 1u) : atlas_data(layer, level + 1u), share);
}

#ifdef MATERIAL_TEXEL
vec4 material_texel(int slot) {
    if (slot == TEXTURE_BASE_COLOR) return atlas_texel(VIRTUAL_BASE);
    if (slot == TEXTURE_EMISSIVE) return atlas_texel(VIRTUAL_EMISSIVE);
    if (slot == TEXTURE_SPECULAR_COLOR) return atlas_texel(VIRTUAL_SPECULAR);
    if (slot == TEXTURE_NORMAL) return atlas_texel(VIRTUAL_NORMAL);
    if (slot == TEXTURE_OCCLUSION) return atlas_texel(VIRTUAL_NORMAL).aaaa;
    vec4 params = atlas_texel(VIRTUAL_PARAMS); // metalness and roughness, or strength
    return slot == TEXTURE_SPECULAR ? params.rrrr : params;
}
#endif
