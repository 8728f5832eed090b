// SPDX-License-Identifier: MIT
// Hierarchical depth: for squares of 8, 16, 32 … pixels the farthest that is in them, as stored depth (0 is farthest). Levels follow one another,
// rows from the top; each has half of the one before along a side, rounded up, down to 1 x 1.
#ifndef HIERARCHY_GLSL
#define HIERARCHY_GLSL

#define HIERARCHY_TILE 8u

uvec2 hierarchy_level(uvec2 size, uint level, out uint offset) {
    offset = 0u;
    for (uint i = 0u; i < level; i++) {
        offset += size.x * size.y;
        size = (size + 1u) / 2u;
    }
    return size;
}

// Whether something within a rectangle of pixels, nowhere nearer than `depth`, lies behind all that is there.
bool hierarchy_hides(hierarchy_array hierarchy, uvec2 size, vec2 low, vec2 high, float depth, bool orthographic) {
    uvec2 first = uvec2(clamp(low / float(HIERARCHY_TILE), vec2(0.0), vec2(size - 1u)));
    uvec2 last = uvec2(clamp(high / float(HIERARCHY_TILE), vec2(0.0), vec2(size - 1u)));
    uint level = 0u;
    while (level < 16u && any(greaterThan(last - first, uvec2(3u)))) {
        first /= 2u;
        last /= 2u;
        level++;
    }
    uint offset, width = hierarchy_level(size, level, offset).x;
    float farthest = 1.0;
    for (uint y = first.y; y <= last.y; y++)
        for (uint x = first.x; x <= last.x; x++) farthest = min(farthest, hierarchy.at[offset + y * width + x]);
    return depth * 1.0001 + (orthographic ? 1e-5 : 0.0) < farthest;
}

#endif
