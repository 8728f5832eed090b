#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// A picture and its depth, seen from where the eye is now. Each pixel looks for the point of the picture that has moved to it, beginning with where that is if
// it is far, and takes the difference off again and again (a fixed point; moves between frames are small). Where that leads nowhere, because what is to be
// seen was hidden, the first guess stays.
#include "common.glsl"
#include "passes/stereo/reproject_shared.h"

layout(push_constant, scalar) uniform push_block { gpu_reproject_push push; };
layout(location = 0) out vec4 out_color;

const int STEPS = 8;
const float FAR = 1e5; // of what has no surface

vec2 span() { return vec2(push.rendered.y - push.rendered.x, push.rendered.z - push.rendered.w); }
vec2 place_of(vec2 tangents) { return (tangents - push.rendered.xw) / span(); }

float depth_at(vec2 place) {
    ivec2 texel = clamp(ivec2(floor(place * push.size)), ivec2(0), ivec2(push.size) - 1);
    float depth = texelFetch(textures[push.depth], texel, 0).r;
    return depth > 0.0 ? depth : FAR;
}

void main() {
    vec2 wanted = push.rendered.xw + gl_FragCoord.xy / push.size * span();
    vec3 turned = transpose(mat3(push.to_new)) * vec3(wanted, -1.0);
    vec2 guess = turned.xy / -turned.z, found = guess, off = vec2(1.0);
    for (int i = 0; i < STEPS; i++) {
        vec3 moved = (push.to_new * vec4(vec3(found, -1.0) * depth_at(place_of(found)), 1.0)).xyz;
        off = moved.z < 0.0 ? moved.xy / -moved.z - wanted : vec2(1.0);
        if (i + 1 < STEPS) found -= off;
    }
    vec2 place = place_of(turned.z < 0.0 && length(off / span() * push.size) < 1.0 ? found : guess);
    bool inside = turned.z < 0.0 && all(greaterThanEqual(place, vec2(0.0))) && all(lessThanEqual(place, vec2(1.0)));
    out_color = inside ? vec4(textureLod(sampler2D(textures[push.picture], samplers[push.sampler_index]), place, 0.0).rgb, 1.0) : vec4(0.0, 0.0, 0.0, 1.0);
}
