// SPDX-License-Identifier: MIT
// Boxes: parallel light within a box.
#ifndef LIGHTS_KINDS_BOX_GLSL
#define LIGHTS_KINDS_BOX_GLSL

float box_strength(light_set_block l, uint light, vec3 ray, out vec3 to_light) {
    vec3 size = l.set.lights.at[light].shape.size;
    float scale = l.set.lights.at[light].shape.spot_scale;
    precise vec3 at = light_axes(l, light, ray);
    to_light = -l.set.lights.at[light].shape.direction;
    precise vec3 part = abs(at) / size;
    precise float edge = light_edge(part.x, scale) * light_edge(part.y, scale) * light_edge(part.z, scale);
    precise float strength = edge * edge;
    return strength;
}

// The distance to the face where the light enters.
float box_distance(light_set_block l, uint light, vec3 ray) {
    return l.set.lights.at[light].shape.size.z - dot(ray, l.set.lights.at[light].shape.direction);
}

#endif
