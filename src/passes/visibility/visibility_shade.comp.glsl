#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Shades what a visibility buffer shows: one thread a pixel.
#define MATERIAL_GRADIENTS
#include "common.glsl"
#include "shade.glsl"
#include "material.glsl"
#include "decals_raster.glsl"
#include "passes/visibility/triangle.glsl"
#include "passes/visibility/visibility_shared.h"

layout(local_size_x = 64) in; // 8x8 pixels, in squares of four
layout(push_constant, scalar) uniform push_block { gpu_visibility_push push; };

vec3 unit(vec3 v) { return v * inversesqrt(max(dot(v, v), 1e-37)); }

// Fills what material.glsl reads.
void interpolate(triangle t, vec2 pixel) {
    vec3 w = triangle_weights(t, push.view, pixel);
    // The differences that a square of four pixels takes, so that textures are filtered as in forward shading.
    vec2 corner = floor(pixel * 0.5) * 2.0 + 0.5;
    vec3 first = triangle_weights(t, push.view, corner);
    vec3 wx = triangle_weights(t, push.view, corner + vec2(1.0, 0.0)) - first;
    vec3 wy = triangle_weights(t, push.view, corner + vec2(0.0, 1.0)) - first;
    in_position_dx = t.positions[0] * wx.x + t.positions[1] * wx.y + t.positions[2] * wx.z;
    in_position_dy = t.positions[0] * wy.x + t.positions[1] * wy.y + t.positions[2] * wy.z;
    in_bind = in_bind_dx = in_bind_dy = vec3(0.0);
    in_position = t.positions[0] * w.x + t.positions[1] * w.y + t.positions[2] * w.z;
    in_normal = vec3(0.0);
    in_tangent = in_uv = in_color = in_uv_dx = in_uv_dy = vec4(0.0);
    float mirror = 1.0, handedness = 1.0;
    for (uint i = 0u; i < 3u; i++) {
        gpu_attributes a = push.scene.scene.attributes.at[t.vertices[i]];
        in_normal += unit(transform_normal(t.instance, unpack_normal(a.normal), mirror)) * w[i];
        vec4 tangent = unpack_tangent(a.tangent);
        in_tangent += vec4(unit(transform_direction(t.instance, tangent.xyz)), tangent.w * mirror) * w[i];
        vec4 uv = vec4(a.uv0, a.uv1);
        in_uv += uv * w[i];
        in_uv_dx += uv * wx[i];
        in_uv_dy += uv * wy[i];
        if ((FEATURES & GPU_FEATURE_MESH_DECALS) != 0u) {
            vec3 bind = push.scene.scene.positions.at[int(t.vertices[i]) + t.primitive.bind_offset];
            in_bind += bind * w[i];
            in_bind_dx += bind * wx[i];
            in_bind_dy += bind * wy[i];
        }
        in_color += vec4(unpackUnorm2x16(a.color.x), unpackUnorm2x16(a.color.y)) * w[i];
    }
    in_ids = uvec3(t.primitive.material, t.item_index, uint(mirror < 0.0 && t.primitive.corners == 3u));
    in_front_facing = triangle_front_facing(t, push.view);
}

void main() {
    uint place = gl_LocalInvocationIndex, square = place >> 2;
    ivec2 pixel = ivec2(gl_WorkGroupID.xy * 8u + uvec2(square & 3u, square >> 2) * 2u + uvec2(place & 1u, place >> 1 & 1u));
    if (any(greaterThanEqual(uvec2(pixel), push.view.view.size))) return;
    uint id = texelFetch(textures_uint[push.ids], pixel, 0).r;
    uint high = push.ids_high == GPU_TEXTURE_NONE ? 0u : texelFetch(textures_uint[push.ids_high], pixel, 0).r;
    uint bits = push.triangle_bits;
    uint item = id >> bits | (bits == 0u ? 0u : high << (32u - bits));
    vec3 radiance = push.background;
    if (item != 0u) {
        triangle t = triangle_fetch(push.scene, push.indices, push.view, item - 1u, id & ((1u << bits) - 1u));
        interpolate(t, vec2(pixel) + 0.5);
        material_array materials = push.scene.scene.materials;
        surface s = material_surface(materials, in_ids.x);
        in_pixel = uvec2(pixel);
        decals_on_surface(s, push.view, push.scene);
        float view_depth = -(push.view.view.world_to_view * vec4(s.position, 1.0)).z;
        radiance = shade_surface(s, push.view, push.lights, push.counters, uvec2(pixel), view_depth, in_ids.y);
    }
    imageStore(images[push.radiance], pixel, vec4(min(radiance, vec3(push.view.view.hdr_max)), 1.0));
}
