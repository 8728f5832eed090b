// SPDX-License-Identifier: MIT
// Shadows of sources that have a size, by several rays.
#ifndef SHADOWS_SOFT_RAYS_GLSL
#define SHADOWS_SOFT_RAYS_GLSL

#include "lights/kinds.glsl"
#include "shadows/sources.glsl"
#include "shadows/ray_query.glsl"

// Shading that sends rays to some lights alone (shadows/sampled.glsl) sends each of them one: to one of its points that chance chooses, so that the mean over all
// seeds is what all points together show. It says so before.
bool one_point = false;
bool point_chosen = false; // it was so

// 0 < x < 1, another one in each frame.
float point_number(lighting_block l, float turn) {
    uint n = (uint(turn * 16777216.0) << 8) + l.scope.shadows.seed * 3242174889u;
    return (float(n >> 9) + 0.5) * (1.0 / 8388608.0);
}

// The part, 0 .. 1, of a source that is seen from the position: of rays to points of a disk that faces it, for capsules round any point of the segment.
// `to_light` is unit and leads to the middle (the nearest point of a capsule), which is `away` metres off; of directional lights 1 for any. What is nearer
// to the source than `margin` hides nothing. For area lights the rays go to points of the light. Points below the surface's horizon are not seen. A source
// without size gets one ray, as hard shadows do.
// `scope`: which items hide it, with LIGHTING_CUBEMAP.
float rays_visibility(lighting_block l, ray_scope scope, uint light, vec3 position, vec3 normal, vec3 to_light, float away, float margin, float slack) {
    uint kind = l.scope.lights.lights.at[light].shape.kind;
    bool endless = kind == GPU_SHAPE_NONE;
    float size = 0.0, turn = 0.0;
    uint count = 1u;
    vec3 side = vec3(0.0), up = vec3(0.0);
    if (LIGHTING_SOFT) {
        bool parallel = endless || kind == GPU_SHAPE_BOX;
        size = source_size(l, light, parallel) * (parallel ? away : 1.0);
        if (size > 0.0) {
            count = l.scope.view.view.frame.frame.shadow_samples;
            turn = source_turn(l, light, position);
            source_axes(to_light, side, up);
        }
    }
    // Points of an area light are weighted by the light they give to a matte surface. A single ray goes to the center, or to the highest point if the center is
    // below the horizon.
    bool area = LIGHTING_AREA_LIGHTS && shape_is_area(kind);
    gpu_shape shape;
    if (area) {
        shape = l.scope.lights.lights.at[light].shape;
        count = LIGHTING_SOFT ? l.scope.view.view.frame.frame.shadow_samples : 1u;
        turn = LIGHTING_SOFT ? source_turn(l, light, position) : 0.0;
    }
    bool one = LIGHTING_SOFT && LIGHTING_SAMPLED && one_point && !endless && count > 1u;
    uint first = 0u, end = count;
    float number = 0.0;
    vec4 chosen = vec4(0.0); // for an area light: direction and distance
    if (one) {
        number = point_number(l, turn);
        point_chosen = true;
        if (area) end = count + 1u; // for the chosen one
        else end = (first = min(uint(number * float(count)), count - 1u)) + 1u;
    }
    float open = 0.0, weights = 0.0;
    for (uint k = first; k < end; k++) {
        vec3 direction = to_light;
        float high = away;
        float weight = 1.0;
        if (area && one && k == count) {
            if (!(weights > 0.0)) break;
            direction = chosen.xyz;
            high = chosen.w;
        } else if (area) {
            vec3 ray = shape.position - position;
            if (LIGHTING_SOFT) ray += area_point(shape, square_point(k, count, turn));
            else if (!(dot(normal, ray) > 0.0)) ray += area_highest(shape, normal);
            high = length(ray);
            direction = ray / high;
            weight = dot(normal, direction) * abs(dot(shape.direction, direction)) / (high * high);
            if (!(weight > 0.0)) continue;
            weights += weight;
            if (one) { // chances in proportion to weights, by one number
                float chance = weight / weights;
                bool taken = number < chance;
                if (taken) chosen = vec4(direction, high);
                number = taken ? number / chance : (number - chance) / (1.0 - chance);
                continue;
            }
        } else if (LIGHTING_SOFT && size > 0.0) {
            vec2 at = source_point(k, count, turn) * size;
            vec3 ray = to_light * away;
            if (!LIGHTING_SIMPLE && kind == GPU_SHAPE_CAPSULE) { // R1, the golden ratio's sequence of another dimension
                float along = 2.0 * fract(turn + 0.7548777 * float(k)) - 1.0;
                ray = capsule_point(l.scope.lights.lights.at[light].shape, along) - position;
            }
            ray += side * at.x + up * at.y;
            high = length(ray);
            direction = ray / high;
            if (!(dot(normal, direction) > 0.0)) continue;
        }
        float stop = endless ? 1e30 : high - margin;
        float seen = LIGHTING_CUBEMAP ? ray_visibility_in(rays_block(l.scope.shadows.rays), scope, position, direction, stop, slack)
                                  : ray_visibility(rays_block(l.scope.shadows.rays), position, direction, stop, slack);
        open += area ? weight * seen : seen;
    }
    if (area && !one) return weights > 0.0 ? open / weights : 0.0;
    return open / float(one ? 1u : count);
}

#endif
