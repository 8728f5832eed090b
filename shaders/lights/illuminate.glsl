// SPDX-License-Identifier: MIT
// What a light gives to a point: KHR_lights_punctual to the letter.
#ifndef LIGHTS_ILLUMINATE_GLSL
#define LIGHTS_ILLUMINATE_GLSL

#include "lights/iterate.glsl"

// Illuminance at right angles to the ray, in lux, with colour; `to_light` is unit. Exactly zero from the range on and outside of the
// cone.
vec3 illuminate(gpu_light light, vec3 position, out vec3 to_light) {
    if (light.kind == GPU_LIGHT_DIRECTIONAL) {
        to_light = -light.direction;
        return light.color;
    }
    precise vec3 ray = light.position - position;
    precise float distance2 = max(dot(ray, ray), 1e-8);
    precise float inverse_distance = inversesqrt(distance2);
    to_light = ray * inverse_distance;
    precise float ratio2 = distance2 / (light.range * light.range);
    precise float window = clamp(1.0 - ratio2 * ratio2, 0.0, 1.0);
    precise float attenuation = window / distance2;
    if (light.kind == GPU_LIGHT_SPOT) {
        precise float angular = clamp(dot(light.direction, -to_light) * light.spot_scale + light.spot_offset, 0.0, 1.0);
        attenuation *= angular * angular;
    }
    precise vec3 result = light.color * attenuation;
    return result;
}

#endif
