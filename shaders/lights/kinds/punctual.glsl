// SPDX-License-Identifier: MIT
// Points and spots: KHR_lights_punctual to the letter.
#ifndef LIGHTS_KINDS_PUNCTUAL_GLSL
#define LIGHTS_KINDS_PUNCTUAL_GLSL

// `distance2`: squared length of `ray`; `ratio2`: the same in ranges, below 1.
float punctual_strength(light_set_block l, uint light, uint kind, vec3 ray, float distance2, float ratio2, out vec3 to_light) {
    precise float inverse_distance = inversesqrt(distance2);
    to_light = ray * inverse_distance;
    precise float attenuation = (1.0 - ratio2 * ratio2) / distance2;
    if (kind == GPU_SHAPE_CONE) {
        precise float angular = clamp(dot(l.set.lights.at[light].shape.direction, -to_light) * l.set.lights.at[light].shape.spot_scale +
                                          l.set.lights.at[light].shape.spot_offset, 0.0, 1.0);
        attenuation *= angular * angular;
    }
    if (LIGHTING_PROFILES) attenuation *= light_profile(l, light, to_light);
    return attenuation;
}

#endif
