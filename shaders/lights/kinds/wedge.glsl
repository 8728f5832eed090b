// SPDX-License-Identifier: MIT
// Wedges: the falloff of points, within a pyramid.
#ifndef LIGHTS_KINDS_WEDGE_GLSL
#define LIGHTS_KINDS_WEDGE_GLSL

float wedge_strength(light_set_block l, uint light, vec3 ray, out vec3 to_light) {
    vec3 size = l.set.lights.at[light].shape.size;
    precise vec3 at = light_axes(l, light, ray);
    to_light = -l.set.lights.at[light].shape.direction;
    if (at.z <= 0.0) return 0.0;
    float scale = l.set.lights.at[light].shape.spot_scale;
    precise vec2 limit = max(size.xy * at.z, vec2(1e-20));
    precise float edge = light_edge(abs(at.x) / limit.x, scale) * light_edge(abs(at.y) / limit.y, scale);
    float range = l.set.lights.at[light].shape.range;
    precise float distance2 = max(dot(ray, ray), 1e-8);
    precise float ratio2 = distance2 / (range * range);
    to_light = ray * inversesqrt(distance2);
    precise float strength = (1.0 - ratio2 * ratio2) / distance2 * (edge * edge);
    return strength;
}

#endif
