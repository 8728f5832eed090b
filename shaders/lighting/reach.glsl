// SPDX-License-Identifier: MIT
// What a light gives to a point: KHR_lights_punctual to the letter, and the same falloff for the shapes that it lacks. Lights are read
// piece by piece: most that a list names are out of range of the very point, and then their position and range are all that is fetched.
//
// One function, light_strength(), decides whether a light's volume holds a point and how strongly; lists that ask for themselves call
// light_reaches() and get the answer that shading gets, to the bit.
#ifndef LIGHTING_REACH_GLSL
#define LIGHTING_REACH_GLSL

#extension GL_EXT_buffer_reference_uvec2 : require

#include "lights/iterate.glsl"
#include "lights/profile.glsl"

// Which part of the light is left at `part` of the way from the axis to the edge (0 .. 1).
float light_edge(float part, float scale) {
    precise float rest = clamp((1.0 - part) * scale, 0.0, 1.0);
    return rest;
}

// Capsules, wedges and boxes. `ray` leads from the point to the light's position.
float light_shape_strength(light_set_block l, uint light, uint kind, vec3 ray, out vec3 to_light) {
    precise float strength = 0.0;
    vec3 direction = l.set.lights.at[light].shape.direction;
    vec3 size = l.set.lights.at[light].shape.size;
    to_light = -direction;
    if (kind == GPU_SHAPE_CAPSULE) {
        precise float along = clamp(-dot(ray, direction), -size.x, size.x);
        precise vec3 nearest = ray + direction * along;
        precise float distance2 = max(dot(nearest, nearest), 1e-8);
        precise float ratio2 = distance2 / (size.y * size.y);
        if (ratio2 >= 1.0) return 0.0;
        to_light = nearest * inversesqrt(distance2);
        strength = (1.0 - ratio2 * ratio2) / distance2;
        return strength;
    }
    vec3 side = l.set.lights.at[light].shape.side;
    precise vec3 up = cross(side, direction);
    precise vec3 at = vec3(-dot(ray, side), -dot(ray, up), -dot(ray, direction));
    float scale = l.set.lights.at[light].shape.spot_scale;
    if (kind == GPU_SHAPE_WEDGE) {
        if (at.z <= 0.0) return 0.0;
        precise vec2 limit = max(size.xy * at.z, vec2(1e-20));
        precise float edge = light_edge(abs(at.x) / limit.x, scale) * light_edge(abs(at.y) / limit.y, scale);
        float range = l.set.lights.at[light].shape.range;
        precise float distance2 = max(dot(ray, ray), 1e-8);
        precise float ratio2 = distance2 / (range * range);
        to_light = ray * inversesqrt(distance2);
        strength = (1.0 - ratio2 * ratio2) / distance2 * (edge * edge);
        return strength;
    }
    precise vec3 part = abs(at) / size;
    precise float edge = light_edge(part.x, scale) * light_edge(part.y, scale) * light_edge(part.z, scale);
    strength = edge * edge;
    return strength;
}

// Square metres.
float light_rectangle_area(light_set_block l, uint light) {
    precise float area = 4.0 * l.set.lights.at[light].shape.spot_scale * abs(l.set.lights.at[light].shape.spot_offset);
    return area;
}

// The steradians of a rectangle, roughly: of a distant one in full, and never 0 in its volume.
float light_rectangle_share(light_set_block l, uint light, vec3 position) {
    precise vec3 ray = l.set.lights.at[light].shape.position - position;
    precise float area = light_rectangle_area(l, light), distance2 = max(dot(ray, ray), 1e-8);
    precise float along = max(abs(dot(ray, l.set.lights.at[light].shape.direction)), 1e-12);
    precise float share = area * along * inversesqrt(distance2) / (distance2 + area * (1.0 / PI));
    return share;
}

// The falloff of capsules, from the nearest point of the rectangle. Times light_reach()'s share, which layers of shading divide by again (lights/area.glsl).
float light_rectangle_strength(light_set_block l, uint light, vec3 position, vec3 ray, out vec3 to_light) {
    vec3 direction = l.set.lights.at[light].shape.direction, side = l.set.lights.at[light].shape.side;
    precise vec3 up = cross(side, direction);
    precise vec3 at = vec3(-dot(ray, side), -dot(ray, up), -dot(ray, direction));
    float across = l.set.lights.at[light].shape.spot_scale, height = l.set.lights.at[light].shape.spot_offset;
    float range = l.set.lights.at[light].shape.size.z;
    to_light = vec3(0.0);
    if (height > 0.0 ? !(at.z > 0.0) : at.z == 0.0) return 0.0; // behind, or in its plane
    precise vec2 beside = max(abs(at.xy) - vec2(across, abs(height)), vec2(0.0));
    precise float distance2 = dot(beside, beside) + at.z * at.z;
    precise float ratio2 = distance2 / (range * range);
    if (ratio2 >= 1.0) return 0.0;
    to_light = ray * inversesqrt(max(dot(ray, ray), 1e-20));
    precise float strength = (1.0 - ratio2 * ratio2) * light_rectangle_share(l, light, position) / light_rectangle_area(l, light);
    return strength;
}

// Whether the light's hull holds a point; `ray` leads from the point to the light's position.
bool light_hull_holds(light_set_block l, uint light, uint count, vec3 ray) {
    plane_array planes = l.set.planes;
    uint first = l.set.lights.at[light].shape.hull_first;
    for (uint i = 0u; i < count; i++) {
        precise float from_light = -dot(planes.at[first + i].xyz, ray);
        if (from_light >= planes.at[first + i].w) return false;
    }
    return true;
}

// Illuminance perpendicular to the ray from a light of color 1, in lux; `to_light` is a unit vector. Exactly zero outside the light's volume. `light` is
// an index into the light array, not of a directional light. For a rectangle: an approximation, from its center; light_lobes() corrects it.
float light_strength(light_set_block l, uint light, vec3 position, out vec3 to_light) {
    precise vec3 ray = l.set.lights.at[light].shape.position - position;
    precise float distance2 = max(dot(ray, ray), 1e-8);
    float range = l.set.lights.at[light].shape.range;
    precise float ratio2 = distance2 / (range * range);
    to_light = vec3(0.0);
    if (ratio2 >= 1.0) return 0.0;
    uint kind = l.set.lights.at[light].shape.kind;
    precise float attenuation;
    if (LIGHTING_SIMPLE || kind <= GPU_SHAPE_CONE) {
        precise float inverse_distance = inversesqrt(distance2);
        to_light = ray * inverse_distance;
        attenuation = (1.0 - ratio2 * ratio2) / distance2;
        if (kind == GPU_SHAPE_CONE) {
            precise float angular = clamp(dot(l.set.lights.at[light].shape.direction, -to_light) * l.set.lights.at[light].shape.spot_scale +
                                              l.set.lights.at[light].shape.spot_offset, 0.0, 1.0);
            attenuation *= angular * angular;
        }
        if (LIGHTING_PROFILES) attenuation *= light_profile(l, light, to_light);
    } else {
        if (LIGHTING_RECTANGLES && kind == GPU_SHAPE_RECTANGLE) attenuation = light_rectangle_strength(l, light, position, ray, to_light);
        else attenuation = light_shape_strength(l, light, kind, ray, to_light);
    }
    uint hull_count = LIGHTING_SIMPLE ? 0u : l.set.lights.at[light].shape.hull_count;
    if (hull_count != 0u && !light_hull_holds(l, light, hull_count, ray)) return 0.0;
    return attenuation;
}

// Whether a light affects surfaces with this light mask.
bool light_meets(light_set_block l, uint light, uint mask) { return !LIGHTING_MASKS || (l.set.masks.at[light] & mask) != 0u; }

// light_strength() times the color; zero if the light does not meet the mask. Directional lights: sun_reach().
vec3 light_reach(light_set_block l, uint light, vec3 position, uint mask, out vec3 to_light) {
    to_light = vec3(0.0);
    if (!light_meets(l, light, mask)) return vec3(0.0);
    precise float strength = light_strength(l, light, position, to_light);
    if (strength == 0.0) return vec3(0.0);
    precise vec3 result = l.set.lights.at[light].color * strength;
    return result;
}

vec3 sun_reach(light_set_block l, uint light, uint mask, out vec3 to_light) {
    to_light = -l.set.lights.at[light].shape.direction;
    if (!light_meets(l, light, mask)) return vec3(0.0);
    return l.set.lights.at[light].color;
}

// Metres from a position to where light comes from: the light, the nearest point of a capsule, the face of a box.
float light_distance(light_set_block l, uint light, vec3 position, vec3 to_light) {
    vec3 ray = l.set.lights.at[light].shape.position - position;
    uint kind = l.set.lights.at[light].shape.kind;
    if (LIGHTING_SIMPLE || kind <= GPU_SHAPE_CONE || kind == GPU_SHAPE_WEDGE || LIGHTING_RECTANGLES && kind == GPU_SHAPE_RECTANGLE) return length(ray);
    vec3 direction = l.set.lights.at[light].shape.direction, size = l.set.lights.at[light].shape.size;
    if (kind == GPU_SHAPE_BOX) return size.z - dot(ray, direction);
    return length(ray + direction * clamp(-dot(ray, direction), -size.x, size.x));
}

bool light_casts(light_set_block l, uint light) { return l.set.lights.at[light].source >= 0.0; }

// Whether the light's volume holds the position: true wherever light_reach() is not zero. Broken positions are held by all lights.
bool light_reaches(light_set_block l, uint light, vec3 position) {
    vec3 to_light;
    float strength = light_strength(l, light, position, to_light);
    return !(strength <= 0.0) && any(greaterThan(l.set.lights.at[light].color, vec3(0.0)));
}

#endif
