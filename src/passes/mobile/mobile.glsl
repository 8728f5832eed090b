// SPDX-License-Identifier: MIT
// What the mobile order keeps at a pixel, in four layouts (Smith and Einig 2016, "Physically Based Deferred Shading on Mobile", 2.2). The build
// compiles variants: MOBILE_LAYOUT is one of GPU_MOBILE_…; MOBILE_LOCAL is defined where the targets are input attachments of a scope.
//
//   metallic 128   light RGB | depth | normal XYZ, roughness | colour RGB, metalness
//   specular 160   light RGB | depth | normal XYZ, roughness | diffuse RGB | F0 RGB
//   metallic 256   x | y | z | light RG | light B, normal X | normal YZ | roughness, metalness | colour RGB
//   specular 256   x | y | z | light RG | light B, roughness | normal XYZ | diffuse RGB | F0 RGB
//
// The lowest bit of the 32-bit x or depth is 1 where the shading normal leans from the triangle's: mobile_geometric().
// Light is radiance times the frame's light_scale, at most its light_max. Metallic layouts take every dielectric for one of F0 0.04; black that
// is all metal stands for a surface that reflects nothing.
#ifndef MOBILE_GLSL
#define MOBILE_GLSL

#include "view.glsl"
#include "surface.glsl"
#include "passes/mobile/mobile_shared.h"

layout(constant_id = GAMMA_ID) const uint GAMMA = GPU_MOBILE_SRGB;

#if MOBILE_LAYOUT == GPU_MOBILE_METALLIC_128
#define MOBILE_TARGETS 4
#elif MOBILE_LAYOUT == GPU_MOBILE_SPECULAR_160
#define MOBILE_TARGETS 5
#else
#define MOBILE_TARGETS 8
#define MOBILE_WIDE
#endif
#ifdef MOBILE_WIDE
#define MOBILE_PLACE(g) g.t[0].x // the first of the 32-bit targets
#else
#define MOBILE_PLACE(g) g.t[1].x
#endif
#if MOBILE_LAYOUT == GPU_MOBILE_METALLIC_128 || MOBILE_LAYOUT == GPU_MOBILE_METALLIC_256
#define MOBILE_METALLIC
#endif

const float MOBILE_F0 = 0.04;
const float MOBILE_FAR = 1e37; // positions beyond it are the sky
const float MOBILE_SAME = 0.999; // normals lean from each other below this cosine

struct mobile_texel {
    vec4 t[MOBILE_TARGETS];
};

vec3 mobile_encode(vec3 color) {
    if (GAMMA == GPU_MOBILE_SQRT) return sqrt(color);
    if (GAMMA == GPU_MOBILE_POWER) return pow(color, vec3(1.0 / 2.2));
    return color;
}

vec3 mobile_decode(vec3 color) {
    if (GAMMA == GPU_MOBILE_SQRT) return color * color;
    if (GAMMA == GPU_MOBILE_POWER) return pow(color, vec3(2.2));
    return color;
}

// Of radiance what the accumulator takes.
vec3 mobile_scaled(view_block v, vec3 radiance) { return min(radiance * v.view.frame.frame.light_scale, vec3(v.view.frame.frame.light_max)); }

vec3 mobile_light(mobile_texel g) {
#ifdef MOBILE_WIDE
    return vec3(g.t[3].xy, g.t[4].x);
#else
    return g.t[0].rgb;
#endif
}

mobile_texel mobile_pack(surface s, float depth, vec3 light) {
    mobile_texel g;
    vec3 base = clamp(s.base_color, 0.0, 1.0);
    bool black = s.dielectric_f90 == 0.0 && s.metallic == 0.0 && base == vec3(0.0);
#ifdef MOBILE_METALLIC
    vec3 color = base;
    float metallic = black ? 1.0 : s.metallic;
#else
    vec3 color = base * (1.0 - s.metallic);
    vec3 f0 = black ? vec3(0.0) : mix(s.dielectric_f0, base, s.metallic);
#endif
#ifdef MOBILE_WIDE
    g.t[0] = vec4(s.position.x);
    g.t[1] = vec4(s.position.y);
    g.t[2] = vec4(s.position.z);
    g.t[3] = vec4(light.rg, 0.0, 0.0);
#ifdef MOBILE_METALLIC
    g.t[4] = vec4(light.b, s.normal.x, 0.0, 0.0);
    g.t[5] = vec4(s.normal.yz, 0.0, 0.0);
    g.t[6] = vec4(s.roughness, metallic, 0.0, 0.0);
    g.t[7] = vec4(color, 0.0);
#else
    g.t[4] = vec4(light.b, s.roughness, 0.0, 0.0);
    g.t[5] = vec4(s.normal * 0.5 + 0.5, 0.0);
    g.t[6] = vec4(color, 0.0);
    g.t[7] = vec4(f0, 0.0);
#endif
#else
    g.t[0] = vec4(light, 0.0);
    g.t[1] = vec4(depth);
    g.t[2] = vec4(s.normal * 0.5 + 0.5, s.roughness);
#ifdef MOBILE_METALLIC
    g.t[3] = vec4(mobile_encode(color), metallic);
#else
    g.t[3] = vec4(mobile_encode(color), 0.0);
    g.t[4] = vec4(mobile_encode(f0), 0.0);
#endif
#endif
    return g;
}

bool mobile_is_sky(mobile_texel g) {
#ifdef MOBILE_WIDE
    return MOBILE_PLACE(g) > MOBILE_FAR;
#else
    return MOBILE_PLACE(g) <= 0.0;
#endif
}

void mobile_mark(inout mobile_texel g, bool leaning) {
    MOBILE_PLACE(g) = uintBitsToFloat(floatBitsToUint(MOBILE_PLACE(g)) & ~1u | uint(leaning));
}

bool mobile_leans(mobile_texel g) { return (floatBitsToUint(MOBILE_PLACE(g)) & 1u) != 0u; }

// World space.
vec3 mobile_position(mobile_texel g, view_block v, ivec2 pixel) {
#ifdef MOBILE_WIDE
    return vec3(g.t[0].x, g.t[1].x, g.t[2].x);
#else
    vec2 ndc = ndc_of_pixel(v, vec2(pixel) + 0.5);
    return (v.view.view_to_world * vec4(view_position_of(v, ndc, view_depth_of(v, g.t[1].x)), 1.0)).xyz;
#endif
}

// The surface of a pixel that shows one, without its glow, which is in the light already.
surface mobile_surface(mobile_texel g, view_block v, ivec2 pixel, out float view_depth) {
    surface s;
    s.light_mask = LIGHT_MASK_ALL;
    s.layered = false;
    s.geometric = vec3(0.0); // mobile_geometric() finds it
    s.position = mobile_position(g, v, pixel);
    vec3 color, normal, f0 = vec3(MOBILE_F0);
    float metallic = 0.0;
#ifdef MOBILE_WIDE
    view_depth = -(v.view.world_to_view * vec4(s.position, 1.0)).z;
#ifdef MOBILE_METALLIC
    normal = vec3(g.t[4].y, g.t[5].xy);
    s.roughness = g.t[6].x;
    metallic = g.t[6].y;
    color = g.t[7].rgb;
#else
    normal = g.t[5].rgb * 2.0 - 1.0;
    s.roughness = g.t[4].y;
    color = g.t[6].rgb;
    f0 = g.t[7].rgb;
#endif
#else
    view_depth = view_depth_of(v, g.t[1].x);
    normal = g.t[2].xyz * 2.0 - 1.0;
    s.roughness = g.t[2].w;
    color = mobile_decode(g.t[3].rgb);
#ifdef MOBILE_METALLIC
    metallic = g.t[3].w;
#else
    f0 = mobile_decode(g.t[4].rgb);
#endif
#endif
    s.normal = normal * inversesqrt(max(dot(normal, normal), 1e-20));
    s.base_color = color;
    s.alpha = 1.0;
    s.occlusion = 0.0;
    s.emissive = vec3(0.0);
#ifdef MOBILE_METALLIC
    bool black = metallic == 1.0 && color == vec3(0.0);
    s.metallic = black ? 0.0 : metallic;
    s.dielectric_f0 = black ? vec3(0.0) : f0;
    s.dielectric_f90 = black ? 0.0 : 1.0;
#else
    s.metallic = 0.0;
    s.dielectric_f0 = f0;
    s.dielectric_f90 = min(max(f0.r, max(f0.g, f0.b)) * 50.0, 1.0); // what reflects less than any matter does reflects nothing
#endif
    return s;
}

#ifdef MOBILE_READS
// Geometric normal from derivatives of the position in a quad, because tile targets can only be read at their own pixel.
// 0 (unknown) where the quad reaches beyond the view, or if a derivative is much longer than the shading normal's plane
// allows: its other end then lies on another surface.
vec3 mobile_geometric(mobile_texel g, vec3 right, vec3 down, surface s, view_block v, ivec2 pixel) {
    const float LONGEST = 4.0;
    if (!mobile_leans(g)) return vec3(0.0);
    vec3 to_view = to_viewer(v, s.position);
    vec2 leave = vec2(dot(right, s.normal), dot(down, s.normal)) / dot(to_view, s.normal);
    vec3 plane_right = right - to_view * leave.x, plane_down = down - to_view * leave.y;
    vec2 far = vec2(dot(right, right), dot(down, down)), near = vec2(dot(plane_right, plane_right), dot(plane_down, plane_down));
    bool inside = all(lessThan(pixel ^ 1, ivec2(v.view.size)));
    return inside && all(lessThan(far, LONGEST * LONGEST * near)) ? geometric_of(right, down) : vec3(0.0);
}

// The targets at this pixel. MOBILE_READS: 1, light and place alone; 2, all.
#ifdef MOBILE_LOCAL
layout(input_attachment_index = 0, set = 1, binding = 0) uniform subpassInput target_0;
#if MOBILE_READS == 2 || !defined(MOBILE_WIDE)
layout(input_attachment_index = 1, set = 1, binding = 1) uniform subpassInput target_1;
#endif
#if MOBILE_READS == 2
layout(input_attachment_index = 2, set = 1, binding = 2) uniform subpassInput target_2;
#endif
#if MOBILE_READS == 2 || defined(MOBILE_WIDE)
layout(input_attachment_index = 3, set = 1, binding = 3) uniform subpassInput target_3;
#endif
#if (MOBILE_READS == 2 && MOBILE_TARGETS > 4) || defined(MOBILE_WIDE)
layout(input_attachment_index = 4, set = 1, binding = 4) uniform subpassInput target_4;
#endif
#if MOBILE_READS == 2 && defined(MOBILE_WIDE)
layout(input_attachment_index = 5, set = 1, binding = 5) uniform subpassInput target_5;
layout(input_attachment_index = 6, set = 1, binding = 6) uniform subpassInput target_6;
layout(input_attachment_index = 7, set = 1, binding = 7) uniform subpassInput target_7;
#endif
#define MOBILE_LOAD(i) subpassLoad(target_##i)
#else
#define MOBILE_LOAD(i) texelFetch(textures[push.images[i]], ivec2(gl_FragCoord.xy), 0)
#endif

#define MOBILE_LOAD_ALL(g)                                                                                                                 \
    MOBILE_LOAD_LIGHT(g)                                                                                                                   \
    MOBILE_LOAD_REST(g)
#ifdef MOBILE_WIDE
#define MOBILE_LOAD_LIGHT(g) g.t[3] = MOBILE_LOAD(3); g.t[4] = MOBILE_LOAD(4);
#define MOBILE_LOAD_PLACE(g) g.t[0] = MOBILE_LOAD(0);
#define MOBILE_LOAD_REST(g)                                                                                                                \
    g.t[0] = MOBILE_LOAD(0); g.t[1] = MOBILE_LOAD(1); g.t[2] = MOBILE_LOAD(2);                                                             \
    g.t[5] = MOBILE_LOAD(5); g.t[6] = MOBILE_LOAD(6); g.t[7] = MOBILE_LOAD(7);
#else
#define MOBILE_LOAD_LIGHT(g) g.t[0] = MOBILE_LOAD(0);
#define MOBILE_LOAD_PLACE(g) g.t[1] = MOBILE_LOAD(1);
#if MOBILE_TARGETS > 4
#define MOBILE_LOAD_REST(g) g.t[1] = MOBILE_LOAD(1); g.t[2] = MOBILE_LOAD(2); g.t[3] = MOBILE_LOAD(3); g.t[4] = MOBILE_LOAD(4);
#else
#define MOBILE_LOAD_REST(g) g.t[1] = MOBILE_LOAD(1); g.t[2] = MOBILE_LOAD(2); g.t[3] = MOBILE_LOAD(3);
#endif
#endif
#endif

#endif
