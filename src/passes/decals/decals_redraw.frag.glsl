#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// A decal as a surface of its own.
#include "common.glsl"
#include "scene.glsl"
#include "decals.glsl"
#include "shade.glsl"
#include "passes/decals/redraw.glsl"

layout(early_fragment_tests) in;

layout(location = 0) centroid in vec4 in_place; // material.glsl says why four
layout(location = 1) centroid in vec3 in_normal;
layout(location = 2) centroid in vec3 in_bind;
layout(location = 3) flat in uint in_decal;
layout(location = 4) flat in float in_mirror;
layout(location = 5) flat in uint in_light_mask;

layout(location = 0) out vec4 out_radiance;

void main() {
    vec3 in_position = in_place.xyz / in_place.w;
    vec3 bind_dx = dFdx(in_bind), bind_dy = dFdy(in_bind);
    float length2 = dot(in_normal, in_normal);
    decal_point p;
    p.position = in_position;
    p.dx = dFdx(in_position);
    p.dy = dFdy(in_position);
    p.facing = length2 > 1e-30 && length2 < 1e30 ? in_normal * inversesqrt(length2) : vec3(0.0, 1.0, 0.0);
    if (dot(p.facing, to_viewer(push.view, in_position)) < 0.0) p.facing = -p.facing;
    p.receivers = 255u;

    decal_array decals = push.set.set.decals;
    vec3 q = decal_cube(decals, in_decal, in_bind);
    if (!decal_holds(q)) discard;
    decal_place place = decal_place_on_mesh(decals, in_decal, q, p, bind_dx, bind_dy, in_mirror);
    float fade = decal_fade(decals, in_decal, place);
    if (fade <= 0.0) discard;
    uint sampler_index = push.set.set.sampler_index;
    vec4 color = decal_color(decals, in_decal, sampler_index, place, fade);
    if (color.a <= 0.0) discard;

    surface s;
    s.light_mask = in_light_mask;
    s.layered = false;
    s.position = in_position;
    s.geometric = geometric_of(p.dx, p.dy);
    s.normal = decal_normal(decals, in_decal, sampler_index, place, p, p.facing);
    s.base_color = color.rgb / color.a;
    s.alpha = color.a;
    vec2 look = decal_roughness_metallic(decals, in_decal, sampler_index, place);
    s.roughness = look.x;
    s.metallic = look.y;
    s.occlusion = 1.0;
    s.emissive = vec3(0.0);
    if ((decals.at[in_decal].flags & GPU_DECAL_EMISSION) != 0u) s.emissive = decal_emissive(decals, in_decal, sampler_index, place);
    s.dielectric_f0 = vec3(0.04);
    s.dielectric_f90 = 1.0;
    vec3 view_position = (push.view.view.world_to_view * vec4(in_position, 1.0)).xyz;
    uvec2 pixel = push.view.view.samples > 1u ? pixel_of(push.view, view_position) : uvec2(gl_FragCoord.xy);
    vec3 radiance = shade_surface(s, push.view, push.lighting, push.counters, pixel, -view_position.z, LIGHT_NO_ITEM);
    out_radiance = vec4(min(radiance, vec3(push.view.view.frame.frame.hdr_max)) * s.alpha, s.alpha);
}
