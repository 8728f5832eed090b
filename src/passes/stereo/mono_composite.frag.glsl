#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// The mono view into an eye, where nothing nearer than the plane is seen: each pixel goes to the point that it would see at the depth found there.
#include "passes/stereo/mono.glsl"

layout(push_constant, scalar) uniform push_block { gpu_mono_push push; };

layout(location = 0) out vec4 out_radiance;

float depth_at(vec2 pixel) {
    return texelFetch(textures[push.depth], ivec2(clamp(pixel, vec2(0.0), vec2(push.mono.view.size) - 1.0)), 0).r;
}

void main() {
    view_block mono = push.mono;
    mono_ray ray = mono_ray_of(push.eye, mono, gl_FragCoord.xy);
    if (ray.direction.z > -1e-6) discard;
    float begin = 1.0 / push.distance, near = begin, last = begin; // on the plane at first, where this picture and the eye's own meet
    for (int i = 0; i < 4; i++) {
        last = near;
        near = depth_at(floor(mono_pixel(mono, ray, near))) / mono.view.near_distance;
    }
    near = max(near, last); // beside an edge they take turns: the eye looks past what is nearer
    vec2 at = mono_pixel(mono, ray, near) - 0.5, base = floor(at), part = at - base;
    vec3 sum = vec3(0.0);
    float weights = 0.0, found = 0.0;
    for (int i = 0; i < 4; i++) {
        vec2 step = vec2(i & 1, i >> 1), tap = clamp(base + step, vec2(0.0), vec2(mono.view.size) - 1.0), w = mix(1.0 - part, part, step);
        float depth = depth_at(tap), weight = depth > 0.0 ? w.x * w.y : 0.0;
        if (weight == 0.0) continue;
        sum += weight * texelFetch(textures[push.radiance], ivec2(tap), 0).rgb;
        weights += weight;
        found += weight * depth;
    }
    if (weights < 0.5) discard;
    out_radiance = vec4(sum / weights, 1.0);
    near = min(found / weights / mono.view.near_distance, begin);
    gl_FragDepth = push.eye.view.near_distance * mono_eye_near(ray, near);
}
