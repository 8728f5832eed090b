// SPDX-License-Identifier: MIT
// Fills surfaces from the targets of the geometry pass and shades them, one thread a pixel: what both entry points share.
#include "common.glsl"
#include "shade.glsl"
#include "material.glsl"
#include "decals_raster.glsl"
#include "passes/texturing/texturing.glsl"

layout(local_size_x = 64) in; // 8x8 pixels, in squares of four
layout(push_constant, scalar) uniform push_block { gpu_texturing_push push; };

uvec4 target(uint i, ivec2 pixel) { return texelFetch(textures_uint[push.targets[i]], pixel, 0); }

float depth_at(ivec2 pixel) { return texelFetch(textures[push.depth], pixel, 0).r; }

vec3 position_at(vec2 pixel, float depth) {
    vec3 seen = view_position_of(push.view, ndc_of_pixel(push.view, pixel), view_depth_of(push.view, depth));
    return (push.view.view.view_to_world * vec4(seen, 1.0)).xyz;
}

#ifdef MATERIAL_TEXEL
#include "passes/texturing/virtual_sample.glsl"
#else
#include "passes/texturing/texturing_derive.glsl"
#endif

// Fills what material.glsl and decals_raster.glsl read.
void fill(ivec2 pixel, float depth) {
    in_position = position_at(vec2(pixel) + 0.5, depth);
    uvec2 frame = target(TARGET_FRAME, pixel).xy;
#ifdef MATERIAL_TEXEL
    quaternion_unpack(frame.x, in_normal, in_tangent);
    in_front_facing = true;
    in_ids = uvec3(virtual_find(pixel), (FORM & TEXTURING_ITEMS) != 0u ? target(TARGET_ID, pixel).x : 0u, 0u);
#else
    bool front;
    frame_unpack(frame, in_normal, in_tangent, front);
    in_uv = uv_at(pixel);
    in_front_facing = front;
    uint id = target(TARGET_ID, pixel).x, material = id;
    if ((FORM & TEXTURING_ITEMS) != 0u) material = push.scene.scene.primitives.at[push.scene.scene.items.at[id].primitive].material;
    in_ids = uvec3(material, id, 0u);
#endif
    in_color = vec4(1.0);
    if ((FORM & TEXTURING_COLORS) != 0u) {
        uvec2 color = target(TARGET_COLORS, pixel).xy;
        in_color = vec4(unpackUnorm2x16(color.x), unpackUnorm2x16(color.y));
    }
    vec2 slopes = vec2(0.0);
    if ((FORM & TEXTURING_SLOPES) != 0u) slopes = unpackHalf2x16(target(TARGET_SLOPES, pixel).x);
#ifndef MATERIAL_TEXEL
    if ((FORM & TEXTURING_GRADIENTS) != 0u) {
        uvec4 g = target(TARGET_GRADIENTS, pixel);
        in_uv_dx = vec4(unpackHalf2x16(g.x), unpackHalf2x16(g.z));
        in_uv_dy = vec4(unpackHalf2x16(g.y), unpackHalf2x16(g.w));
    } else {
        derive_gradients(pixel, id, frame.y, depth, slopes);
    }
#endif
    in_pixel = uvec2(pixel);
    in_bind = in_bind_dx = in_bind_dy = in_position_dx = in_position_dy = vec3(0.0);
    if (FEATURES == 0u) return;
    // As a square of four pixels takes them.
    vec2 corner = vec2(pixel & ~1) + 0.5;
    vec2 back = corner - vec2(pixel) - 0.5;
    float at = depth * max(1.0 + dot(back, slopes), 0.01), right = max(at + depth * slopes.x, depth * 0.01),
          below = max(at + depth * slopes.y, depth * 0.01);
    vec3 first = position_at(corner, at);
    in_position_dx = position_at(corner + vec2(1.0, 0.0), right) - first;
    in_position_dy = position_at(corner + vec2(0.0, 1.0), below) - first;
    if ((FORM & TEXTURING_BIND) != 0u) {
        uvec4 a = target(TARGET_BIND, pixel);
        uvec2 b = target(TARGET_BIND + 1u, pixel).xy;
        vec2 z = unpackHalf2x16(a.w);
        in_bind = uintBitsToFloat(a.xyz);
        in_bind_dx = vec3(unpackHalf2x16(b.x), z.x);
        in_bind_dy = vec3(unpackHalf2x16(b.y), z.y);
    }
}

void main() {
    uint place = gl_LocalInvocationIndex, square = place >> 2;
    ivec2 pixel = ivec2(gl_WorkGroupID.xy * 8u + uvec2(square & 3u, square >> 2) * 2u + uvec2(place & 1u, place >> 1 & 1u));
    if (any(greaterThanEqual(uvec2(pixel), push.view.view.size))) return;
    float depth = depth_at(pixel);
    vec3 radiance = push.background;
    bool is_shaded = depth > 0.0;
#ifdef MATERIAL_TEXEL
    is_shaded = is_shaded && target(TARGET_UV, pixel).x != VIRTUAL_NOWHERE; // a forward pass lights those
#endif
    if (is_shaded) {
        fill(pixel, depth);
        material_array materials = push.scene.scene.materials;
        surface s = material_surface(materials, in_ids.x);
        decals_on_surface(s, push.view, push.scene);
        radiance =
            shade_surface(s, push.view, push.lights, push.counters, uvec2(pixel), view_depth_of(push.view, depth), LIGHT_NO_ITEM);
#ifdef MATERIAL_TEXEL
        if (SHOWS_LEVELS == 1u) radiance = vec3(atlas_level + float(VIRTUAL_STEP * atlas_tier), atlas_level, float(atlas_tier));
#endif
    }
    imageStore(images[push.radiance], pixel, vec4(min(radiance, vec3(push.view.view.hdr_max)), 1.0));
}
