#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Fills surfaces from the targets of the geometry pass and shades them, one thread a pixel, or with SHADES_SAMPLES
// one for each surface of its samples. Textures are read through the bindless set, or with MATERIAL_TEXEL from the atlas.
#define MATERIAL_GRADIENTS
#include "common.glsl"
#include "shade.glsl"
#ifndef MATERIAL_TEXEL
#define MATERIAL_LAYERS LIGHTING_LAYERS
#endif
#include "material.glsl"
#include "decals_raster.glsl"
#include "passes/texturing/texturing.glsl"

layout(local_size_x = 64) in; // 8x8 pixels, in squares of four
#ifdef SHADES_SAMPLES
#include "passes/visibility/visible.glsl"
layout(push_constant, scalar) uniform push_block { gpu_texturing_samples_push push; };
const int SEEN_SAMPLES = int(SAMPLES);

uvec4 target(uint i, ivec2 pixel, int at) { return target_bits(i, texelFetch(textures_multisampled[push.targets[i]], pixel, at)); }
float depth_at(ivec2 pixel, int at) { return texelFetch(textures_multisampled[push.depth], pixel, at).r; }
vec2 seen_place(int at) { return sample_place(uint(at)); }
#else
layout(push_constant, scalar) uniform push_block { gpu_texturing_push push; };
const int SEEN_SAMPLES = 1;

uvec4 target(uint i, ivec2 pixel, int at) { return texelFetch(textures_uint[push.targets[i]], pixel, 0); }
float depth_at(ivec2 pixel, int at) { return texelFetch(textures[push.depth], pixel, 0).r; }
vec2 seen_place(int at) { return vec2(0.5); }
#endif

vec3 position_at(vec2 point, float depth) {
    vec3 seen = view_position_of(push.view, ndc_of_pixel(push.view, point), view_depth_of(push.view, depth));
    return (push.view.view.view_to_world * vec4(seen, 1.0)).xyz;
}

#ifdef MATERIAL_TEXEL
#include "passes/texturing/virtual_sample.glsl"
#else
#include "passes/texturing/texturing_derive.glsl"
#endif

// By the slopes of depth in the triangle, where the geometry pass has stored them.
vec3 geometric_at(vec2 point, float depth, vec2 slopes) {
    const float STEP = 0.125; // of a pixel: there depth is still positive
    if ((FORM & TEXTURING_SLOPES) == 0u) return vec3(0.0); // shading normals are those of the triangles
    vec2 there = depth * max(1.0 + slopes * STEP, 0.01);
    vec3 right = position_at(point + vec2(STEP, 0.0), there.x), below = position_at(point + vec2(0.0, STEP), there.y);
    return geometric_of(right - in_position, below - in_position);
}

// Fills what material.glsl and decals_raster.glsl read, of a sample of a pixel; the surface is lit at `point`.
void fill(ivec2 pixel, int at, vec2 point, float depth) {
    in_position = position_at(point, depth);
    uvec2 frame = target(TARGET_FRAME, pixel, at).xy;
#ifdef MATERIAL_TEXEL
    quaternion_unpack(frame.x, in_normal, in_tangent);
    in_front_facing = true;
    in_ids = uvec3(virtual_find(pixel, at), (FORM & TEXTURING_ITEMS) != 0u ? target(TARGET_ID, pixel, at).x : 0u, 0u);
#else
    bool front;
    frame_unpack(frame, in_normal, in_tangent, front);
    in_uv = uv_at(pixel, at);
    in_front_facing = front;
    uint id = target(TARGET_ID, pixel, at).x, material = id;
    if ((FORM & TEXTURING_ITEMS) != 0u) material = push.scene.scene.primitives.at[push.scene.scene.items.at[id].primitive].material;
    in_ids = uvec3(material, id, 0u);
#endif
    in_color = vec4(1.0);
    if ((FORM & TEXTURING_COLORS) != 0u) {
        uvec2 color = target(TARGET_COLORS, pixel, at).xy;
        in_color = vec4(unpackUnorm2x16(color.x), unpackUnorm2x16(color.y));
    }
    vec2 slopes = vec2(0.0);
    if ((FORM & TEXTURING_SLOPES) != 0u) slopes = unpackHalf2x16(HAS_SAMPLES ? target(TARGET_ID, pixel, at).y
                                                                             : target(TARGET_SLOPES, pixel, at).x);
    in_geometric = geometric_at(point, depth, slopes);
#ifndef MATERIAL_TEXEL
    if ((FORM & TEXTURING_GRADIENTS) != 0u) {
        uvec4 g = target(TARGET_GRADIENTS, pixel, at);
        if (GRADIENT_TARGETS == 2u) g.zw = target(TARGET_GRADIENTS + 1u, pixel, at).xy;
        in_uv_dx = vec4(unpackHalf2x16(g.x), unpackHalf2x16(g.z));
        in_uv_dy = vec4(unpackHalf2x16(g.y), unpackHalf2x16(g.w));
    } else {
        derive_gradients(pixel, point, id, frame.y, depth, slopes);
    }
#endif
    in_pixel = uvec2(pixel);
    in_bind = in_bind_dx = in_bind_dy = in_position_dx = in_position_dy = vec3(0.0);
    if ((FEATURES & GPU_FEATURES_DECALS) == 0u) return;
    // As a square of four pixels takes them.
    vec2 corner = vec2(pixel & ~1) + 0.5;
    vec2 back = corner - point;
    float there = depth * max(1.0 + dot(back, slopes), 0.01), right = max(there + depth * slopes.x, depth * 0.01),
          below = max(there + depth * slopes.y, depth * 0.01);
    vec3 first = position_at(corner, there);
    in_position_dx = position_at(corner + vec2(1.0, 0.0), right) - first;
    in_position_dy = position_at(corner + vec2(0.0, 1.0), below) - first;
    if ((FORM & TEXTURING_BIND) != 0u) {
        uvec4 a = target(TARGET_BIND, pixel, at);
        uvec2 b = target(TARGET_BIND + 1u, pixel, at).xy;
        vec2 z = unpackHalf2x16(a.w);
        in_bind = uintBitsToFloat(a.xyz);
        in_bind_dx = vec3(unpackHalf2x16(b.x), z.x);
        in_bind_dy = vec3(unpackHalf2x16(b.y), z.y);
    }
}

vec3 shade(ivec2 pixel, int at, vec2 point, float depth) {
    fill(pixel, at, point, depth);
    material_array materials = push.scene.scene.materials;
    surface s = material_surface(materials, in_ids.x);
    decals_on_surface(s, push.view, push.scene);
    vec3 radiance =
        shade_surface(s, push.view, push.lighting, push.counters, uvec2(pixel), view_depth_of(push.view, depth), LIGHT_NO_ITEM);
#ifdef MATERIAL_TEXEL
    if (SHOWS_LEVELS == 1u) radiance = vec3(atlas_level + float(VIRTUAL_STEP * atlas_tier), atlas_level, float(atlas_tier));
#endif
    return min(radiance, vec3(push.view.view.frame.frame.hdr_max));
}

#ifdef SHADES_SAMPLES

// At the middle of the samples that show a surface, as depth is linear in the picture.
void main() {
    uvec2 size = push.view.view.size, blocks = (size + 7u) >> 3;
    uint i = LINEAR_INVOCATION;
    if (i >= push.sums.at[blocks.x * blocks.y * 64u]) return;
    uint entry = push.entries.at[i], index = entry & VISIBLE_PIXEL_MASK;
    ivec2 pixel = ivec2(index % size.x, index / size.x);
    uint samples = surface_samples(push.words.at[index], entry >> VISIBLE_SURFACE_SHIFT);
    float part = 1.0 / float(bitCount(samples)), depth = 0.0;
    vec2 point = vec2(0.0);
    for (uint k = 0u; k < SAMPLES; k++) {
        if ((samples >> k & 1u) == 0u) continue;
        point += sample_place(k);
        depth += depth_at(pixel, int(k));
    }
    store_result(push.results, i, shade(pixel, findLSB(samples), vec2(pixel) + point * part, depth * part));
    if (COUNT_LIGHTS == 1u) atomicAdd(push.counts.at[EDGES_SHADED], 1u);
}

#else

void main() {
    uint place = gl_LocalInvocationIndex, square = place >> 2;
    ivec2 pixel = ivec2(gl_WorkGroupID.xy * 8u + uvec2(square & 3u, square >> 2) * 2u + uvec2(place & 1u, place >> 1 & 1u));
    if (any(greaterThanEqual(uvec2(pixel), push.view.view.size))) return;
    float depth = depth_at(pixel, 0);
    vec3 radiance = push.background;
    bool is_shaded = depth > 0.0;
#ifdef MATERIAL_TEXEL
    is_shaded = is_shaded && target(TARGET_UV, pixel, 0).x != VIRTUAL_NOWHERE; // a forward pass lights those
#endif
    if (is_shaded) radiance = shade(pixel, 0, vec2(pixel) + 0.5, depth);
    imageStore(images[push.radiance], pixel, vec4(min(radiance, vec3(push.view.view.frame.frame.hdr_max)), depth > 0.0 ? 1.0 : 0.0));
}

#endif
