// SPDX-License-Identifier: MIT
// What a light gives to a point: KHR_lights_punctual to the letter. Lights are read piece by piece: most that a list names are out of
// range of the very point, and then their position and range are all that is fetched.
#ifndef LIGHTS_ILLUMINATE_GLSL
#define LIGHTS_ILLUMINATE_GLSL

#include "lights/iterate.glsl"

// Illuminance at right angles to the ray, in lux, with colour; `to_light` is unit. Exactly zero from the range on and outside of the
// cone. `light` is the index of a point or spot light.
vec3 illuminate(light_list_block l, uint light, vec3 position, out vec3 to_light) {
    precise vec3 ray = l.list.lights.at[light].position - position;
    precise float distance2 = max(dot(ray, ray), 1e-8);
    float range = l.list.lights.at[light].range;
    precise float ratio2 = distance2 / (range * range);
    to_light = vec3(0.0);
    if (ratio2 >= 1.0) return vec3(0.0);
    precise float inverse_distance = inversesqrt(distance2);
    to_light = ray * inverse_distance;
    precise float attenuation = (1.0 - ratio2 * ratio2) / distance2;
    if (l.list.lights.at[light].kind == GPU_LIGHT_SPOT) {
        precise float angular = clamp(dot(l.list.lights.at[light].direction, -to_light) * l.list.lights.at[light].spot_scale + l.list.lights.at[light].spot_offset, 0.0, 1.0);
        attenuation *= angular * angular;
    }
    precise vec3 result = l.list.lights.at[light].color * attenuation;
    return result;
}

#endif
