// SPDX-License-Identifier: MIT
// The default G-buffer: 16 bytes a pixel beside depth and the radiance target, which takes the emission.
//   0  RGBA8 sRGB     base colour; 1
//   1  RGBA16 UNORM   octahedral normal; roughness; metalness (8 bits) and occlusion (8 bits)
//   2  RGBA8 UNORM    square root of the dielectric F0; F90
#ifndef GBUFFER_GLSL
#define GBUFFER_GLSL

#include "view.glsl"
#include "surface.glsl"
#include "gbuffer_shared.h"

struct gbuffer {
    vec4 targets[GBUFFER_TARGETS];
};

gbuffer gbuffer_pack(surface s) {
    gbuffer g;
    g.targets[0] = vec4(s.base_color, 1.0);
    float packed = round(clamp(s.metallic, 0.0, 1.0) * 255.0) * 256.0 + round(clamp(s.occlusion, 0.0, 1.0) * 255.0);
    g.targets[1] = vec4(octahedral_encode(s.normal) * 0.5 + 0.5, s.roughness, packed / 65535.0);
    g.targets[2] = vec4(sqrt(s.dielectric_f0), s.dielectric_f90);
    return g;
}

surface gbuffer_unpack(gbuffer g, vec3 position, vec3 emissive) {
    surface s;
    uint packed = uint(round(g.targets[1].w * 65535.0));
    s.position = position;
    s.normal = octahedral_decode(g.targets[1].xy * 2.0 - 1.0);
    s.base_color = g.targets[0].rgb;
    s.alpha = 1.0;
    s.roughness = g.targets[1].z;
    s.metallic = float(packed >> 8) / 255.0;
    s.occlusion = float(packed & 255u) / 255.0;
    s.emissive = emissive;
    s.dielectric_f0 = g.targets[2].rgb * g.targets[2].rgb;
    s.dielectric_f90 = g.targets[2].a;
    return s;
}

float gbuffer_depth(gpu_gbuffer from, ivec2 pixel) { return texelFetch(textures[from.depth], pixel, 0).r; }

// The world-space normal alone.
vec3 gbuffer_normal(gpu_gbuffer from, ivec2 pixel) {
    return octahedral_decode(texelFetch(textures[from.targets[1]], pixel, 0).xy * 2.0 - 1.0);
}

// The surface at a pixel whose depth is not that of the sky.
surface gbuffer_surface(gpu_gbuffer from, ivec2 pixel, vec3 position, vec3 emissive) {
    gbuffer g;
    for (uint i = 0u; i < 3u; i++) g.targets[i] = texelFetch(textures[from.targets[i]], pixel, 0);
    return gbuffer_unpack(g, position, emissive);
}

// The same of one sample, where the G-buffer is multisampled.
float gbuffer_depth(gpu_gbuffer from, ivec2 pixel, int at) { return texelFetch(textures_multisampled[from.depth], pixel, at).r; }

// What is stored, as it is stored: equal values are equal bits. Targets that there are not are zero.
gbuffer gbuffer_stored(gpu_gbuffer from, ivec2 pixel, int at) {
    gbuffer g;
    for (uint i = 0u; i < GBUFFER_TARGETS; i++)
        g.targets[i] = i < 3u ? texelFetch(textures_multisampled[from.targets[i]], pixel, at) : vec4(0.0);
    return g;
}

surface gbuffer_surface(gpu_gbuffer from, ivec2 pixel, int at, vec3 position, vec3 emissive) {
    return gbuffer_unpack(gbuffer_stored(from, pixel, at), position, emissive);
}

// World-space position of what a pixel's centre shows.
vec3 gbuffer_position(view_block v, ivec2 pixel, float view_depth) {
    return (v.view.view_to_world * vec4(view_position_of(v, ndc_of_pixel(v, vec2(pixel) + 0.5), view_depth), 1.0)).xyz;
}

#endif
