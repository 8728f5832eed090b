// SPDX-License-Identifier: MIT
// The faces, levels and pages of shadow maps: where a point lies in them, and what of them a page shows. maps_shared.h says what they are.
#ifndef SHADOWS_FACES_GLSL
#define SHADOWS_FACES_GLSL

#include "common.glsl"
#include "lights/bounds_shared.h"

layout(buffer_reference) buffer shadow_page_array;
layout(buffer_reference) buffer const_shadow_shape_array;
layout(buffer_reference) buffer const_shadow_sun_array;
#include "shadows/maps_shared.h"
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer shadow_page_array { gpu_shadow_page at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer const_shadow_shape_array { gpu_shape at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer const_shadow_sun_array { gpu_shadow_sun at[]; };

// Pages on a side of a level, and the texels of one without its borders.
uint shadow_side(uint level) { return max(16u >> level, 1u); }
uint shadow_page_size(uint level) { return min(SHADOW_PAGE << (SHADOW_SQUARE_LEVELS - 1u) >> level, SHADOW_PAGE); }
uint shadow_page_texels(uint level) { return shadow_page_size(level) - 2u * SHADOW_BORDER; }
// Texels across a face.
float shadow_width(uint level) { return float(level < SHADOW_SQUARE_LEVELS ? uint(SHADOW_BLOCK_TEXELS) >> level : shadow_page_texels(level)); }

// Bits of a face before those of a level: 0, 256, 320, 336, 340, 341, 342, 343.
uint shadow_first_bit(uint level) {
    uint square = min(level, SHADOW_SQUARE_LEVELS), below = 2u * (SHADOW_SQUARE_LEVELS - square);
    return (341u >> below << below) + (level - square); // 341: 101010101, a bit for each square level
}
uint shadow_bit(uint face, uint level, uvec2 at) {
    return face * SHADOW_FACE_WORDS * 32u + shadow_first_bit(level) + at.y * shadow_side(level) + at.x;
}

struct shadow_page {
    uint face, level;
    uvec2 at; // which of the level's pages
};
shadow_page shadow_page_of(uint bit) {
    shadow_page p;
    p.face = bit / (SHADOW_FACE_WORDS * 32u);
    bit %= SHADOW_FACE_WORDS * 32u;
    p.level = 0u;
    while (p.level + 1u < SHADOW_LEVELS && bit >= shadow_first_bit(p.level + 1u)) p.level++;
    bit -= shadow_first_bit(p.level);
    p.at = uvec2(bit % shadow_side(p.level), bit / shadow_side(p.level));
    return p;
}

// The face that a point is seen in; `ray` leads from the light's position to it.
uint shadow_face_of(uint kind, vec3 ray) {
    if (kind == GPU_SHAPE_BOX) return 0u;
    vec3 size = abs(ray);
    bool is_x = size.x >= size.y && size.x >= size.z, is_y = size.y >= size.z;
    float along = is_x ? ray.x : is_y ? ray.y : ray.z;
    return (is_x ? 0u : is_y ? 2u : 4u) + (along < 0.0 ? 1u : 0u);
}

// A point in the space of a face: xy / w is -1 .. 1 across it, z / w the depth, 1 (nearest) .. 0; w is the distance along the axis in metres, of box
// lights 1.
vec4 shadow_face_clip(gpu_shape shape, uint face, vec3 ray) {
    if (shape.kind == GPU_SHAPE_BOX) {
        vec3 up = cross(shape.side, shape.direction);
        return vec4(dot(ray, shape.side) / shape.size.x, dot(ray, up) / shape.size.y, 0.5 - 0.5 * dot(ray, shape.direction) / shape.size.z, 1.0);
    }
    vec3 turned = face < 2u ? ray.yzx : face < 4u ? ray.zxy : ray; // the axis of the face last
    return vec4(turned.xy, SHADOW_NEAR, (face & 1u) != 0u ? -turned.z : turned.z);
}

// The coarsest level whose texels are no wider than a pixel, or the one that is `widest` texels across; `across`: how many pixels wide the face
// is where the point lies.
uint shadow_level_for(float across, float widest) {
    across = min(across, widest);
    uint finer = uint(across > 8.0) + uint(across > 24.0) + uint(across > 56.0) + uint(across > 120.0); // no branches
    return SHADOW_LEVELS - 1u - (finer + uint(across > 240.0) + uint(across > 480.0) + uint(across > 960.0));
}

// As uvec2(), of numbers from 0 to 2^23 - 1. CPU drivers convert to integers one lane after the other, as they must heed numbers that do not fit.
uvec2 shadow_whole(vec2 x) { return floatBitsToUint(floor(x) + 8388608.0) & 0x7fffffu; }

// The page of a level that holds a point of a face.
uvec2 shadow_page_at(uint level, vec2 ndc) {
    float side = float(shadow_side(level));
    return shadow_whole(clamp((ndc * 0.5 + 0.5) * side, vec2(0.0), vec2(side - 1.0)));
}

// Bits of the pages of a level that hold the square of half size `slack` (in faces' widths of 2) round a point of the face: its least and greatest page.
void shadow_pages_round(uint level, vec2 ndc, float slack, out uvec2 low, out uvec2 high) {
    float side = float(shadow_side(level));
    vec2 at = ndc * 0.5 + 0.5;
    low = shadow_whole(clamp((at - slack * 0.5) * side, vec2(0.0), vec2(side - 1.0)));
    high = shadow_whole(clamp((at + slack * 0.5) * side, vec2(0.0), vec2(side - 1.0)));
}

// The texel of a page's memory, counted from its least corner with the border, on which a point of its face lies; not rounded.
vec2 shadow_page_texel(shadow_page p, vec2 ndc) {
    float texels = float(shadow_page_texels(p.level)), width = shadow_width(p.level);
    return (ndc * 0.5 + 0.5) * width - vec2(p.at) * texels + float(SHADOW_BORDER);
}

#endif
