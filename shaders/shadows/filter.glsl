// SPDX-License-Identifier: MIT
// Filters of shadow maps: several texels round a point instead of one. maps.glsl has what they look up.
#ifndef SHADOWS_FILTER_GLSL
#define SHADOWS_FILTER_GLSL

#include "shadows/faces.glsl"
#include "shadows/sources.glsl"

const uint SHADOW_TAPS = 16u, SHADOW_TAPS_OUTER = 5u;
// Texels from the point to its farthest tap: with the four texels round that it stays within the border of the page.
const float SHADOW_REACH = float(SHADOW_BORDER) - 1.0;
const float SHADOW_PCF_REACH = 1.5, SHADOW_PCF_REACH_OBLONG = 1.0; // texels; oblong ones are 1.5 times as long on the screen
// Filtered lookups of this invocation, and how many of them ended after the outer taps.
uint shadows_filtered = 0u, shadows_settled = 0u;
// Blockers are sought down to this part of the way from the light to the point: penumbras of nearer ones are too narrow.
const float SHADOW_NEAREST_BLOCKER = 0.25;

// A lit point in a face.
struct shadow_receiver {
    vec2 ndc;
    float along;   // w of shadow_face_clip()
    float depth;
    vec2 slope;    // what depth grows by per unit of ndc on the plane of the surface
    vec2 side, up; // what a blocker hides moves by in ndc where the point of the source moves by 1, for each unit of depth between blocker and receiver
};

// What the depth of a lit plane grows by per unit of ndc. Planes that face the light by a cosine of less than `least` count as if they did by that.
vec2 shadow_plane_slope(gpu_shape shape, uint face, vec3 ray, vec3 normal, float least) {
    if (shape.kind == GPU_SHAPE_BOX) {
        vec3 up = cross(shape.side, shape.direction);
        float facing = min(dot(normal, shape.direction), -least);
        return vec2(dot(normal, shape.side) * shape.size.x, dot(normal, up) * shape.size.y) * (0.5 / (facing * shape.size.z));
    }
    uint axis = face >> 1u;
    return vec2(normal[(axis + 1u) % 3u], normal[(axis + 2u) % 3u]) * (SHADOW_NEAR / min(dot(normal, ray), -least * length(ray)));
}

shadow_receiver shadow_receiver_of(gpu_shape shape, uint face, vec4 clip, vec3 ray, vec3 normal) {
    shadow_receiver r;
    r.ndc = clip.xy / clip.w;
    r.along = clip.w;
    r.depth = clip.z / clip.w;
    r.slope = shadow_plane_slope(shape, face, ray, normal, 0.05);
    if (shape.kind == GPU_SHAPE_BOX) {
        r.side = vec2(2.0 * shape.size.z / shape.size.x, 0.0);
        r.up = vec2(0.0, 2.0 * shape.size.z / shape.size.y);
        return r;
    }
    uint axis = face >> 1u, x = (axis + 1u) % 3u, y = (axis + 2u) % 3u;
    float sign_ = (face & 1u) != 0u ? -1.0 : 1.0;
    vec3 side, up; // of the disk that faces the point; what lies before or behind the light moves with the ray
    source_axes(normalize(ray), side, up);
    r.side = (vec2(side[x], side[y]) - r.ndc * (sign_ * side[axis])) / SHADOW_NEAR;
    r.up = (vec2(up[x], up[y]) - r.ndc * (sign_ * up[axis])) / SHADOW_NEAR;
    return r;
}

// The finest level, from `level` on, in which a kernel of a radius in ndc reaches no farther than pages do.
uint shadow_level_within(uint level, float radius) {
    while (level + 1u < SHADOW_LEVELS && radius * 0.5 * shadow_width(level) > SHADOW_REACH) level++;
    return level;
}

// The radius in ndc, for a source of size 1, of what may hide it from a point.
float shadow_search_radius(gpu_shape shape, shadow_receiver r) {
    float span = shape.kind == GPU_SHAPE_BOX ? 1.0 - r.depth : r.depth * (1.0 / SHADOW_NEAREST_BLOCKER - 1.0);
    return span * max(length(r.side), length(r.up));
}

// The coarsest level in which a point is looked up whose pixel asks for `level`: that in which all possible blockers are within reach.
uint shadow_coarsest_level(lighting_block l, uint light, gpu_shape shape, uint face, vec4 clip, vec3 ray, uint level) {
    if (!LIGHTING_FILTERED || l.scope.view.view.frame.frame.shadow_filter != GPU_SHADOW_FILTER_PCSS) return level;
    float size = source_size(l, light, shape.kind == GPU_SHAPE_BOX);
    if (!(size > 0.0)) return level;
    return shadow_level_within(level, size * shadow_search_radius(shape, shadow_receiver_of(shape, face, clip, ray, -normalize(ray))));
}

// The depth of what is nearer to the light than a point of the face by so many metres.
float shadow_depth_before(gpu_shape shape, shadow_receiver r, float metres) {
    if (shape.kind == GPU_SHAPE_BOX) return r.depth + 0.5 * metres / shape.size.z;
    return SHADOW_NEAR / max(r.along - metres, SHADOW_NEAR);
}

// Whether a tap shows something before the receiver; `blocker`: its depth. `depth` is that of the receiver's plane at the tap, `bias` what casts no shadow
// before it, `own` the depth of the receiver; `back` leads from the tap to it, in texels. Shading normals lean away from the plane of the surface, so a
// tap also shows the receiver where the plane through its four texels, continued, meets the receiver.
bool shadow_tap_hides(gpu_shadow_maps maps, uint place, shadow_page at, vec2 texel, vec2 back, float depth, float bias, float own,
                      out float blocker) {
    shadow_quad q = shadow_quad_at(maps, place, at, texel);
    depth += bias;
    blocker = q.nearest;
    if (blocker <= depth) return false;
    vec2 limits = shadow_quad_range(q);
    float least = limits.x, range = limits.y - least, here = shadow_quad_depth(q);
    vec4 d = q.depths;
    vec2 slope = vec2(d.y + d.z - d.x - d.w, d.x + d.y - d.z - d.w);
    float there = here + 0.5 * dot(slope, back);
    bool beyond = abs(there - own) > 0.25 * range + bias;
    return least > depth ? beyond : here > depth + 0.25 * range && (beyond || range > 4.0 * bias); // the step at an edge is no plane
}

// Looks at a disk of the face; `radius` is in the units of `side` and `up`. x: the number of taps that show something before the receiver; y: the sum of
// its depths. The outer taps, which surround the disk, come first. With `settles` the rest are skipped if the outer taps and the center, `hidden`, agree;
// then there are no depths.
vec2 shadow_taps(gpu_shadow_maps maps, uint place, shadow_page at, gpu_shape shape, shadow_receiver r, float radius, float turn, float slack,
                 bool settles, bool hidden) {
    float scale = 0.5 * shadow_width(at.level), texel = (shape.kind == GPU_SHAPE_BOX ? max(shape.size.x, shape.size.y) : r.along) / scale;
    vec2 sum = vec2(0.0);
    uint k = 0u;
    for (; k < SHADOW_TAPS; k++) {
        if (settles && k == SHADOW_TAPS_OUTER && sum.x == (hidden ? float(SHADOW_TAPS_OUTER) : 0.0)) break;
        vec2 p = source_point(SHADOW_TAPS - 1u - k, SHADOW_TAPS, turn) * radius, beside = r.side * p.x + r.up * p.y, texels = beside * scale;
        float before = slack + (0.5 + 0.5 * length(texels)) * texel, blocker;
        float depth = r.depth + dot(r.slope, beside), bias = shadow_depth_before(shape, r, before) - r.depth;
        if (shadow_tap_hides(maps, place, at, shadow_page_texel(at, r.ndc + beside), -texels, depth, bias, r.depth, blocker)) sum += vec2(1.0, blocker);
    }
    if (k == SHADOW_TAPS) return sum;
    shadows_settled++;
    return vec2(hidden ? float(SHADOW_TAPS) : 0.0, 0.0);
}

// The part of the light, 0 .. 1, that reaches the point. `at` and `place`: the page that its pixel asked for; `hidden`: what that page says without a filter.
//
// Percentage-closer filtering (Reeves et al. 1987) looks at a small disk of texels, which smooths their steps. Percentage-closer soft shadows (Fernando
// 2005) first look where there may be blockers, and make the disk as large as the penumbra of their mean. Disks reach three texels; where the penumbra is
// wider, coarser levels are looked up, whose texels are larger. Where no blocker is found the page itself decides: it may show a contact that coarse
// texels miss.
float shadow_filtered(lighting_block l, uint light, shadowed_point p, uint row, gpu_shape shape, shadow_page at, uint place, shadow_receiver r,
                      bool hidden) {
    float open = hidden ? 0.0 : 1.0;
    bool is_oblong = light < l.scope.lights.directional_count && row % SHADOW_SUN_ROWS >= SHADOW_SUN_SQUARES;
    bool is_soft = l.scope.view.view.frame.frame.shadow_filter == GPU_SHADOW_FILTER_PCSS;
    float size = is_soft ? source_size(l, light, shape.kind == GPU_SHAPE_BOX) : 0.0, radius = is_oblong ? SHADOW_PCF_REACH_OBLONG : SHADOW_PCF_REACH, reach = 1.0, turn = 0.0;
    uint wanted = at.level;
    if (is_soft) {
        if (!(size > 0.0)) return open;
        reach = max(length(r.side), length(r.up));
        turn = source_turn(l, light, p.position);
        radius = shadow_search_radius(shape, r) / reach * size;
        at.level = shadow_level_within(wanted, radius * reach);
        if (!shadow_find_from(p.maps, row, r.ndc, at, place)) return open;
        radius = min(radius, SHADOW_REACH / (0.5 * shadow_width(at.level) * reach));
    } else {
        r.side = vec2(2.0 / shadow_width(at.level), 0.0);
        r.up = r.side.yx;
    }
    vec2 taps = vec2(0.0);
    shadows_filtered++;
    for (uint step = is_soft ? 0u : 1u; step < 2u; step++) { // blockers first: one loop, so that shaders hold its code once
        taps = shadow_taps(p.maps, place, at, shape, r, radius, turn, p.slack, !is_soft, hidden);
        if (step == 1u) break;
        if (taps.x == 0.0) return open;
        radius = min(radius, size * max(taps.y / taps.x - r.depth, 0.0));
        at.level = shadow_level_within(wanted, radius * reach);
        if (!shadow_find_from(p.maps, row, r.ndc, at, place)) return open;
    }
    return 1.0 - taps.x / float(SHADOW_TAPS);
}

#endif
