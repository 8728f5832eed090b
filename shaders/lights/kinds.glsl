// SPDX-License-Identifier: MIT
// The strength of each kind of light at a point, where its light comes from, and the polygons of area lights. Each kind has a file; the functions here choose
// between kinds. Everything else about lights is the same for all kinds (lighting/reach.glsl). Lights are read member by member: most lights of a list are out
// of range of the point, and of these only the position and range are fetched.
#ifndef LIGHTS_KINDS_GLSL
#define LIGHTS_KINDS_GLSL

#include "lights/iterate.glsl"
#include "lights/profile.glsl"

// An area light, or what one clipping plane leaves of it, seen from the surface. Edges are stored too: differences of corners would round for small lights.
struct area_polygon {
    vec3 corners[6];
    vec3 edges[6]; // to the next corner
    uint count;    // at most 4 before clipping
};

// Which part of the light is left at `part` of the way from the axis to the edge (0 .. 1).
float light_edge(float part, float scale) {
    precise float rest = clamp((1.0 - part) * scale, 0.0, 1.0);
    return rest;
}

// The point from which `ray` leads to the light's position, in the light's axes: across, up, along.
vec3 light_axes(light_set_block l, uint light, vec3 ray) {
    vec3 direction = l.set.lights.at[light].shape.direction, side = l.set.lights.at[light].shape.side;
    precise vec3 up = cross(side, direction);
    precise vec3 at = vec3(-dot(ray, side), -dot(ray, up), -dot(ray, direction));
    return at;
}

#include "lights/kinds/punctual.glsl"
#include "lights/kinds/capsule.glsl"
#include "lights/kinds/wedge.glsl"
#include "lights/kinds/box.glsl"
#include "lights/kinds/rectangle.glsl"

// ---- area lights: flat, with GPU_LIGHTING_AREA_LIGHTS ----

// In square meters.
float area_of(light_set_block l, uint light) { return rectangle_area(l, light); }

// The squared distance of a point in the light's plane from the light; `at`: across and up, from the light's center.
float area_beside2(light_set_block l, uint light, vec2 at) { return rectangle_beside2(l, light, at); }

// A point of the light, relative to its center; uniform if `at` is uniform over the unit square.
vec3 area_point(gpu_shape s, vec2 at) { return rectangle_point(s, at); }

// The point just inside the border that is highest above a surface.
vec3 area_highest(gpu_shape s, vec3 normal) { return rectangle_highest(s, normal); }

// The light as seen from a point, in the axes of `to_frame`.
area_polygon area_polygon_of(light_set_block l, uint light, vec3 position, mat3 to_frame) { return rectangle_polygon(l, light, position, to_frame); }

// The approximate solid angle of an area light, steradians: exact for a distant light, never 0 within its volume.
float area_share(light_set_block l, uint light, vec3 position) {
    precise vec3 ray = l.set.lights.at[light].shape.position - position;
    precise float area = area_of(l, light), distance2 = max(dot(ray, ray), 1e-8);
    precise float along = max(abs(dot(ray, l.set.lights.at[light].shape.direction)), 1e-12);
    precise float share = area * along * inversesqrt(distance2) / (distance2 + area * (1.0 / PI));
    return share;
}

// Falloff from the nearest point of the light, as for capsules, times area_share(); area_lobes_of() divides by area_share() again (lights/area.glsl).
float area_strength(light_set_block l, uint light, vec3 position, vec3 ray, out vec3 to_light) {
    precise vec3 at = light_axes(l, light, ray);
    float range = l.set.lights.at[light].shape.size.z;
    to_light = vec3(0.0);
    if (l.set.lights.at[light].shape.spot_offset > 0.0 ? !(at.z > 0.0) : at.z == 0.0) return 0.0; // behind, or in its plane
    precise float distance2 = area_beside2(l, light, at.xy) + at.z * at.z;
    precise float ratio2 = distance2 / (range * range);
    if (ratio2 >= 1.0) return 0.0;
    to_light = ray * inversesqrt(max(dot(ray, ray), 1e-20));
    precise float strength = (1.0 - ratio2 * ratio2) * area_share(l, light, position) / area_of(l, light);
    return strength;
}

// ---- all kinds ----

// light_strength() within the light's range; `ray` leads from the position to the light, `ratio2` is the square of its length in ranges.
float kind_strength(light_set_block l, uint light, vec3 position, vec3 ray, float distance2, float ratio2, out vec3 to_light) {
    uint kind = l.set.lights.at[light].shape.kind;
    if (LIGHTING_SIMPLE || kind <= GPU_SHAPE_CONE) return punctual_strength(l, light, kind, ray, distance2, ratio2, to_light);
    if (LIGHTING_AREA_LIGHTS && shape_is_area(kind)) return area_strength(l, light, position, ray, to_light);
    if (kind == GPU_SHAPE_CAPSULE) return capsule_strength(l, light, ray, to_light);
    if (kind == GPU_SHAPE_WEDGE) return wedge_strength(l, light, ray, to_light);
    return box_strength(l, light, ray, to_light);
}

// Meters from a position to where the light comes from: the light, the nearest point of a capsule, the face of a box.
float light_distance(light_set_block l, uint light, vec3 position, vec3 to_light) {
    vec3 ray = l.set.lights.at[light].shape.position - position;
    uint kind = l.set.lights.at[light].shape.kind;
    if (!LIGHTING_SIMPLE && kind == GPU_SHAPE_CAPSULE) return capsule_distance(l, light, ray);
    if (!LIGHTING_SIMPLE && kind == GPU_SHAPE_BOX) return box_distance(l, light, ray);
    return length(ray);
}

#endif
