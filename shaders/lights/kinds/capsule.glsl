// SPDX-License-Identifier: MIT
// Capsules: the falloff of points, from the nearest point of a segment.
#ifndef LIGHTS_KINDS_CAPSULE_GLSL
#define LIGHTS_KINDS_CAPSULE_GLSL

float capsule_strength(light_set_block l, uint light, vec3 ray, out vec3 to_light) {
    vec3 direction = l.set.lights.at[light].shape.direction;
    vec3 size = l.set.lights.at[light].shape.size;
    to_light = -direction;
    precise float along = clamp(-dot(ray, direction), -size.x, size.x);
    precise vec3 nearest = ray + direction * along;
    precise float distance2 = max(dot(nearest, nearest), 1e-8);
    precise float ratio2 = distance2 / (size.y * size.y);
    if (ratio2 >= 1.0) return 0.0;
    to_light = nearest * inversesqrt(distance2);
    precise float strength = (1.0 - ratio2 * ratio2) / distance2;
    return strength;
}

float capsule_distance(light_set_block l, uint light, vec3 ray) {
    vec3 direction = l.set.lights.at[light].shape.direction, size = l.set.lights.at[light].shape.size;
    return length(ray + direction * clamp(-dot(ray, direction), -size.x, size.x));
}

// `along`: -1 .. 1.
vec3 capsule_point(gpu_shape s, float along) { return s.position + s.direction * (along * s.size.x); }

#endif
