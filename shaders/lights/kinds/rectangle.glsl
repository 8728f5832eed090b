// SPDX-License-Identifier: MIT
// Rectangles, with the functions that kinds.glsl needs for area lights: spot_scale is half the width, abs(spot_offset) half the height.
#ifndef LIGHTS_KINDS_RECTANGLE_GLSL
#define LIGHTS_KINDS_RECTANGLE_GLSL

float rectangle_area(light_set_block l, uint light) {
    precise float area = 4.0 * l.set.lights.at[light].shape.spot_scale * abs(l.set.lights.at[light].shape.spot_offset);
    return area;
}

float rectangle_beside2(light_set_block l, uint light, vec2 at) {
    precise vec2 beside = max(abs(at) - vec2(l.set.lights.at[light].shape.spot_scale, abs(l.set.lights.at[light].shape.spot_offset)), vec2(0.0));
    precise float beside2 = dot(beside, beside);
    return beside2;
}

vec3 rectangle_at(gpu_shape s, vec2 at) {
    vec3 side = s.side * s.spot_scale, up = cross(s.side, s.direction) * abs(s.spot_offset);
    return side * at.x + up * at.y;
}

vec3 rectangle_point(gpu_shape s, vec2 at) { return rectangle_at(s, 2.0 * at - 1.0); }

vec3 rectangle_highest(gpu_shape s, vec3 normal) {
    vec3 up = cross(s.side, s.direction);
    return rectangle_at(s, vec2(dot(normal, s.side) > 0.0 ? 0.999 : -0.999, dot(normal, up) > 0.0 ? 0.999 : -0.999));
}

area_polygon rectangle_polygon(light_set_block l, uint light, vec3 position, mat3 to_frame) {
    precise vec3 ray = l.set.lights.at[light].shape.position - position;
    vec3 direction = l.set.lights.at[light].shape.direction, side = l.set.lights.at[light].shape.side;
    precise vec3 up = cross(side, direction);
    precise vec3 x = side * l.set.lights.at[light].shape.spot_scale, y = up * abs(l.set.lights.at[light].shape.spot_offset);
    precise vec3 middle = to_frame * ray, right = to_frame * x, above = to_frame * y;
    area_polygon p;
    p.count = 4u;
    p.corners[0] = middle - right - above;
    p.corners[1] = middle + right - above;
    p.corners[2] = middle + right + above;
    p.corners[3] = middle - right + above;
    p.edges[0] = right * 2.0;
    p.edges[1] = above * 2.0;
    p.edges[2] = right * -2.0;
    p.edges[3] = above * -2.0;
    return p;
}

#endif
