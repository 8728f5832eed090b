// SPDX-License-Identifier: MIT
// Between an eye and the view from the middle of the head (mono.h).
#ifndef MONO_GLSL
#define MONO_GLSL

#include "common.glsl"
#include "view.glsl"

layout(buffer_reference) buffer mono_counts;
#include "passes/stereo/mono_shared.h"
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer mono_counts { uint at[]; };

// What a pixel of an eye looks along, in the space of the mono view: origin + s * direction has the view depth s in the eye.
struct mono_ray {
    vec3 origin, direction;
};

mono_ray mono_ray_of(view_block eye, view_block mono, vec2 pixel) {
    precise vec3 toward = mat3(eye.view.view_to_world) * view_position_of(eye, ndc_of_pixel(eye, pixel), 1.0);
    precise vec3 direction = mat3(mono.view.world_to_view) * toward;
    precise vec3 origin = mat3(mono.view.world_to_view) * (eye.view.eye - mono.view.eye);
    return mono_ray(origin, direction);
}

// `near`: 1 / depth in the mono view; 0: infinitely far. Returns 1 / depth in the eye.
float mono_eye_near(mono_ray ray, float near) { return near * -ray.direction.z / max(1.0 + ray.origin.z * near, 1e-6); }

// Depth, as the eye stores it, of the plane at `distance`; 0 where the eye does not see it.
float mono_plane_depth(view_block eye, view_block mono, vec2 pixel, float distance) {
    mono_ray ray = mono_ray_of(eye, mono, pixel);
    precise float along = (distance + ray.origin.z) / max(-ray.direction.z, 1e-6);
    precise float depth = eye.view.near_distance / max(along, 1e-6);
    return ray.direction.z < 0.0 ? min(depth, 1.0) : 0.0;
}

// Where the mono view has the point at 1 / near on the ray, pixels.
vec2 mono_pixel(view_block mono, mono_ray ray, float near) {
    vec2 tangent = ray.origin.xy * near + ray.direction.xy * ((1.0 + ray.origin.z * near) / max(-ray.direction.z, 1e-6));
    vec2 ndc = (tangent - mono.view.ndc_offset) / mono.view.ndc_scale;
    return (vec2(ndc.x, -ndc.y) * 0.5 + 0.5) * vec2(mono.view.size);
}

#endif
