// SPDX-License-Identifier: MIT
// Light at a point from one light: by the light's kind (lights/kinds.glsl), within its range and hull, on surfaces that share a bit with its mask.
//
// One function, light_strength(), decides whether a light's volume holds a point and how strongly; lists that ask for themselves call
// light_reaches() and get the answer that shading gets, to the bit.
#ifndef LIGHTING_REACH_GLSL
#define LIGHTING_REACH_GLSL

#extension GL_EXT_buffer_reference_uvec2 : require

#include "lights/kinds.glsl"

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
// an index into the light array, not of a directional light. For an area light: an approximation, from its center; light_lobes() corrects it.
float light_strength(light_set_block l, uint light, vec3 position, out vec3 to_light) {
    precise vec3 ray = l.set.lights.at[light].shape.position - position;
    precise float distance2 = max(dot(ray, ray), 1e-8);
    float range = l.set.lights.at[light].shape.range;
    precise float ratio2 = distance2 / (range * range);
    to_light = vec3(0.0);
    if (ratio2 >= 1.0) return 0.0;
    precise float attenuation = kind_strength(l, light, position, ray, distance2, ratio2, to_light);
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

bool light_casts(light_set_block l, uint light) { return l.set.lights.at[light].source >= 0.0; }

// Whether the light's volume holds the position: true wherever light_reach() is not zero. Broken positions are held by all lights.
bool light_reaches(light_set_block l, uint light, vec3 position) {
    vec3 to_light;
    float strength = light_strength(l, light, position, to_light);
    return !(strength <= 0.0) && any(greaterThan(l.set.lights.at[light].color, vec3(0.0)));
}

#endif
