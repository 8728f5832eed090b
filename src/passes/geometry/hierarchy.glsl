// SPDX-License-Identifier: MIT
// Hierarchical depth: for squares of 8, 16, 32 … pixels the farthest that is in them, as stored depth (0 is farthest). Levels follow one another,
// rows from the top; each has half of the one before along a side, rounded up, down to 1 x 1.
#ifndef HIERARCHY_GLSL
#define HIERARCHY_GLSL

#include "view.glsl"

#define HIERARCHY_TILE 8u

layout(buffer_reference, scalar, buffer_reference_align = 4) buffer hierarchy_array { float at[]; };

// Size of a level, the first of which has `size`, and where it begins.
uvec2 hierarchy_level(uvec2 size, uint level, out uint offset) {
    offset = 0u;
    for (uint i = 0u; i < level; i++) {
        offset += size.x * size.y;
        size = (size + 1u) / 2u;
    }
    return size;
}

// Pixels from the top left.
vec2 hierarchy_pixel(view_block v, vec2 ndc) { return (vec2(ndc.x, -ndc.y) * 0.5 + 0.5) * vec2(v.view.size); }

// The rectangle that a box round a point in view space covers, in pixels, with slack, and the stored depth that nothing in it is nearer than; false
// where it may reach before the near plane.
bool screen_rectangle(view_block v, vec3 center, vec3 extent, float slack, out vec2 low, out vec2 high, out float nearest_depth) {
    float z = -center.z, z0 = z - extent.z, z1 = z + extent.z;
    bool orthographic = v.view.orthographic > 0.5;
    low = high = vec2(0.0);
    nearest_depth = 1.0;
    if (!(z0 > v.view.near_distance * 1.001)) return false;
    vec2 a = center.xy - extent.xy, b = center.xy + extent.xy;
    if (!orthographic) {
        a = min(a / z0, a / z1);
        b = max(b / z0, b / z1);
    }
    vec2 p = hierarchy_pixel(v, (a - v.view.ndc_offset) / v.view.ndc_scale), q = hierarchy_pixel(v, (b - v.view.ndc_offset) / v.view.ndc_scale);
    low = min(p, q) - slack - 1e-5 * abs(p);
    high = max(p, q) + slack + 1e-5 * abs(q);
    vec4 clip = v.view.view_to_clip * vec4(0.0, 0.0, -z0, 1.0);
    nearest_depth = clip.z / clip.w;
    return true;
}

// Whether something within a rectangle of pixels, nowhere nearer than `depth`, lies behind all that is there. Comparisons keep NaNs.
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
