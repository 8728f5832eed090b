// SPDX-License-Identifier: MIT
// The default G-buffer: 16 bytes a pixel beside depth and the radiance target, which takes the emission.
//   0  RGBA8 sRGB     base colour; 1
//   1  RGBA16 UNORM   octahedral normal; roughness; metalness (8 bits) and occlusion (8 bits)
//   2  RGBA8 UNORM    square root of the dielectric F0; F90
#ifndef GBUFFER_GLSL
#define GBUFFER_GLSL

#include "common.glsl"
#include "surface.glsl"

struct gbuffer {
    vec4 color;
    vec4 normal;
    vec4 dielectric;
};

gbuffer gbuffer_pack(surface s) {
    gbuffer g;
    g.color = vec4(s.base_color, 1.0);
    float packed = round(clamp(s.metallic, 0.0, 1.0) * 255.0) * 256.0 + round(clamp(s.occlusion, 0.0, 1.0) * 255.0);
    g.normal = vec4(octahedral_encode(s.normal) * 0.5 + 0.5, s.roughness, packed / 65535.0);
    g.dielectric = vec4(sqrt(s.dielectric_f0), s.dielectric_f90);
    return g;
}

surface gbuffer_unpack(gbuffer g, vec3 position, vec3 emissive) {
    surface s;
    uint packed = uint(round(g.normal.w * 65535.0));
    s.position = position;
    s.normal = octahedral_decode(g.normal.xy * 2.0 - 1.0);
    s.base_color = g.color.rgb;
    s.alpha = 1.0;
    s.roughness = g.normal.z;
    s.metallic = float(packed >> 8) / 255.0;
    s.occlusion = float(packed & 255u) / 255.0;
    s.emissive = emissive;
    s.dielectric_f0 = g.dielectric.rgb * g.dielectric.rgb;
    s.dielectric_f90 = g.dielectric.a;
    return s;
}

#endif
