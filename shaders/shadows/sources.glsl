// SPDX-License-Identifier: MIT
// What soft shadows share: how large the sources of light are, and points on them.
#ifndef SHADOWS_SOURCES_GLSL
#define SHADOWS_SOURCES_GLSL

#include "lights/iterate.glsl"

// Of the disk that stands for a source: its radius in metres, of parallel light (directional, boxes) the tangent of half the angle it fills; 0: a point.
float source_size(lighting_block l, uint light, bool parallel) {
    float own = l.scope.lights.lights.at[light].source;
    return own != 0.0 ? own : parallel ? l.scope.view.view.frame.frame.sun_tangent : l.scope.view.view.frame.frame.light_radius;
}

// Two unit vectors at right angles to a unit vector and each other.
void source_axes(vec3 axis, out vec3 side, out vec3 up) {
    side = normalize(abs(axis.x) < 0.7 ? vec3(0.0, -axis.z, axis.y) : vec3(-axis.z, 0.0, axis.x));
    up = cross(axis, side);
}

// 0 .. 1, by which each pixel, light and frame turns its points: interleaved gradient noise, far apart in neighbours (Jimenez 2014, "Next Generation
// Post Processing in Call of Duty: Advanced Warfare").
float source_turn(lighting_block l, uint light, vec3 position) {
    view_block v = l.scope.view;
    vec2 at = vec2(pixel_of(v, (v.view.world_to_view * vec4(position, 1.0)).xyz)) + 5.588238 * float(v.view.turn);
    return fract(52.9829189 * fract(dot(at, vec2(0.06711056, 0.00583715))) + 0.618034 * float(light & 1023u));
}

// Point k of `count` in the unit disk, evenly spread: a sunflower (Vogel 1979, "A better way to construct the sunflower head").
vec2 source_point(uint k, uint count, float turn) {
    float angle = 2.39996323 * float(k) + 6.28318531 * turn;
    return sqrt((float(k) + 0.5) / float(count)) * vec2(cos(angle), sin(angle));
}

// Point k of `count` in the unit square: a column for each, and rows by the golden ratio.
vec2 square_point(uint k, uint count, float turn) {
    return vec2((float(k) + fract(97.0 * turn)) / float(count), fract(turn + 0.618033989 * float(k)));
}

#endif
