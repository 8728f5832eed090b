// SPDX-License-Identifier: MIT
// Lights behind all surfaces of a tile. Let N be an axis and a the widest angle between it and a normal of the tile. A light at p is
// behind a surface at x with any of those normals when N.(p - x) + sin(a) |p - x| <= 0. The left side is convex in x, so it holds
// for the whole piece of the view that the tile encloses once it holds for its eight corners. After Ishmukhametov (2013), chapter 4,
// who encloses the directions to the light in a second cone, which is looser, and compares angles.
#ifndef BACKFACE_GLSL
#define BACKFACE_GLSL

#include "passes/lights/cells.glsl"
#include "gbuffer.glsl"

layout(buffer_reference) buffer cone_array;
layout(buffer_reference) buffer axis_array;
layout(buffer_reference) buffer backface_block;

#include "passes/lights/backface_shared.h"

layout(buffer_reference, scalar, buffer_reference_align = 4) buffer cone_array { gpu_cone at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer axis_array { vec3 at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer backface_block { gpu_backface backface; };

// What is `extra` in gpu_cells_push here.
#define BACKFACE backface_block(push.extra).backface

// Where a light's rays come from: all points between two, or one direction.
struct light_source {
    vec3 first, last; // parallel: the direction to the light twice
    bool parallel;
    bool shines; // is a light: what is not is never behind
};

// `place` is one of the bounds.
light_source light_source_of(light_list_block l, uint place) {
    light_source s;
    s.shines = l.list.lights.set.entities.at[place].kind == GPU_ENTITY_LIGHT;
    s.first = s.last = vec3(0.0);
    s.parallel = false;
    if (!s.shines) return s;
    uint light = l.list.directional_count + l.list.lights.set.entities.at[place].user;
    s.first = s.last = l.list.lights.set.lights.at[light].shape.position;
    uint kind = l.list.lights.set.lights.at[light].shape.kind;
    if (shape_is_area(kind)) s.shines = false; // it stays in all lists
    s.parallel = kind == GPU_SHAPE_BOX;
    if (s.parallel) s.first = s.last = -l.list.lights.set.lights.at[light].shape.direction;
    if (kind == GPU_SHAPE_CAPSULE) {
        vec3 half_segment = l.list.lights.set.lights.at[light].shape.direction * l.list.lights.set.lights.at[light].shape.size.x;
        s.first -= half_segment;
        s.last += half_segment;
    }
    return s;
}

// Part of the distance, and metres per metre from the world's origin, that rounding in shading may be off by.
const float BACKFACE_SLACK = 1e-5;
const float BACKFACE_ROUNDING = 2e-6;

struct backface_tile {
    vec3 corners[8]; // world space
    vec3 axis;
    float sine2;     // widened
    float slack;     // metres
};

backface_tile backface_tile_of(view_block v, vec2 low, vec2 high, float near, float far, vec3 axis, float sine) {
    backface_tile t;
    float reach = 0.0;
    for (int i = 0; i < 8; i++) {
        vec2 ndc = vec2((i & 1) != 0 ? high.x : low.x, (i & 2) != 0 ? high.y : low.y);
        t.corners[i] = (v.view.view_to_world * vec4(view_position_of(v, ndc, (i & 4) != 0 ? far : near), 1.0)).xyz;
        reach = max(reach, length(t.corners[i]));
    }
    t.axis = axis;
    t.sine2 = (sine + BACKFACE_SLACK) * (sine + BACKFACE_SLACK);
    t.slack = BACKFACE_ROUNDING * (reach + length(v.view.eye));
    return t;
}

bool is_behind(vec3 axis, float sine2, float slack, vec3 ray) {
    float along = dot(axis, ray) + slack;
    return along < 0.0 && along * along >= sine2 * dot(ray, ray); // NaN is not
}

bool light_is_behind(backface_tile t, light_source s) {
    if (!s.shines) return false;
    if (s.parallel) return is_behind(t.axis, t.sine2, 0.0, s.first);
    float slack = t.slack + BACKFACE_ROUNDING * length(s.first);
    bool behind = true;
    for (int i = 0; i < 8; i++)
        behind = behind && is_behind(t.axis, t.sine2, slack, s.first - t.corners[i]) &&
                 is_behind(t.axis, t.sine2, slack, s.last - t.corners[i]);
    return behind;
}

// The tile of a cell with its bounds.
backface_tile backface_tile_at(view_block v, light_list_block l, gpu_cell_bounds bounds, uint cell, vec3 axis, float sine) {
    uvec2 first = uvec2(cell % l.list.tiles_x, cell / l.list.tiles_x) * l.list.tile_size, end = min(first + l.list.tile_size, v.view.size);
    vec2 a = ndc_of_pixel(v, vec2(first)), b = ndc_of_pixel(v, vec2(end));
    return backface_tile_of(v, vec2(a.x, b.y), vec2(b.x, a.y), -bounds.high.z, -bounds.low.z, axis, sine);
}

#endif
