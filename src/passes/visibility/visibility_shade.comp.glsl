#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
// Shades what a visibility buffer shows: one thread a pixel, or for each of the triangles that its samples show.
#define MATERIAL_GRADIENTS
#include "common.glsl"
#include "shade.glsl"
#define MATERIAL_LAYERS LIGHTING_LAYERS
#include "material.glsl"
#include "decals_raster.glsl"
#include "passes/visibility/triangle.glsl"
#include "passes/visibility/visible.glsl"
#include "passes/visibility/visibility_shared.h"

layout(local_size_x = 64) in; // 8x8 pixels, or entries of a list
layout(push_constant, scalar) uniform push_block { gpu_visibility_push push; };

layout(constant_id = VISIBILITY_GRID_ID) const uint GRID = 0u; // 1: pixels are seen at the places of four samples to two by two pixels
layout(constant_id = STORED_WEIGHTS_ID) const uint STORED_WEIGHTS = 0u; // 1: the id pass has stored weights; one sample

vec3 unit(vec3 v) { return v * inversesqrt(max(dot(v, v), 1e-37)); }

// 0 or NaN, which means unknown, for lines and points and where positions were not fetched.
vec3 geometric_of_triangle(triangle t) {
    return geometric_of(t.positions[1] - t.positions[0], t.positions[2] - t.positions[0]);
}

// Fills what material.glsl reads, from weights of the three corners and how they change to the right and down.
void interpolate(triangle t, vec3 w, vec3 wx, vec3 wy) {
    in_position_dx = t.positions[0] * wx.x + t.positions[1] * wx.y + t.positions[2] * wx.z;
    in_position_dy = t.positions[0] * wy.x + t.positions[1] * wy.y + t.positions[2] * wy.z;
    in_bind = in_bind_dx = in_bind_dy = vec3(0.0);
    in_position = t.positions[0] * w.x + t.positions[1] * w.y + t.positions[2] * w.z;
    in_normal = vec3(0.0);
    in_tangent = in_uv = in_color = in_uv_dx = in_uv_dy = vec4(0.0);
    float mirror = 1.0;
    // Corner after corner, and first what needs the instance: with all of it in one go, twice the registers hold values that wait.
    uvec3 vertices = uvec3(t.vertices[0], t.vertices[1], t.vertices[2]);
    [[dont_unroll]] for (uint i = 0u; i < 3u; i++) {
        uint normal = push.scene.scene.attributes.at[vertices[i]].normal, packed = push.scene.scene.attributes.at[vertices[i]].tangent;
        in_normal += unit(transform_normal(t.instance, unpack_normal(normal), mirror)) * w[i];
        vec4 tangent = unpack_tangent(packed);
        in_tangent += vec4(unit(transform_direction(t.instance, tangent.xyz)), tangent.w * mirror) * w[i];
    }
    [[dont_unroll]] for (uint i = 0u; i < 3u; i++) {
        vec4 uv = vec4(push.scene.scene.attributes.at[vertices[i]].uv0, push.scene.scene.attributes.at[vertices[i]].uv1);
        in_uv += uv * w[i];
        in_uv_dx += uv * wx[i];
        in_uv_dy += uv * wy[i];
        if ((FEATURES & GPU_FEATURE_MESH_DECALS) != 0u) {
            vec3 bind = push.scene.scene.positions.at[int(vertices[i]) + t.primitive.bind_offset];
            in_bind += bind * w[i];
            in_bind_dx += bind * wx[i];
            in_bind_dy += bind * wy[i];
        }
        uvec2 color = push.scene.scene.attributes.at[vertices[i]].color;
        in_color += vec4(unpackUnorm2x16(color.x), unpackUnorm2x16(color.y)) * w[i];
    }
    in_ids = uvec3(t.primitive.material, t.item_index, uint(mirror < 0.0 && t.primitive.corners == 3u));
}

// As a square of four pixels interpolates, so that textures are filtered as in forward shading.
void interpolate_at(triangle t, vec2 pixel) {
    vec2 corner = floor(pixel * 0.5) * 2.0 + 0.5;
    vec3 first = triangle_weights(t, push.view, corner);
    vec3 wx = triangle_weights(t, push.view, corner + vec2(1.0, 0.0)) - first;
    vec3 wy = triangle_weights(t, push.view, corner + vec2(0.0, 1.0)) - first;
    in_front_facing = triangle_front_facing(t, push.view);
    interpolate(t, triangle_weights(t, push.view, pixel), wx, wy);
    in_geometric = geometric_of_triangle(t);
}

// The same from what the id pass has stored. Fetches positions only for decals and leaning normals. False if the id pass
// stored nothing.
bool interpolate_stored(inout triangle t, uint number, ivec2 pixel) {
    vec2 stored = texelFetch(textures[push.weights], pixel, 0).xy;
    if (stored.y < -1.0) return false;
    vec4 gradients = texelFetch(textures[push.gradients], pixel, 0);
    vec2 w = vec2(abs(stored.x), stored.y);
    triangle_fetch_vertices(t, push.scene, push.indices, number);
    if (FEATURES != 0u) triangle_fetch_positions(t, push.scene, push.view);
    vec3 wx = vec3(-gradients.x - gradients.y, gradients.xy), wy = vec3(-gradients.z - gradients.w, gradients.zw);
    interpolate(t, vec3(1.0 - w.x - w.y, w), wx, wy);
    float view_depth = view_depth_of(push.view, texelFetch(textures[push.depth], pixel, 0).r);
    vec3 seen = view_position_of(push.view, ndc_of_pixel(push.view, vec2(pixel) + 0.5), view_depth);
    in_position = (push.view.view.view_to_world * vec4(seen, 1.0)).xyz;
    in_geometric = geometric_of_triangle(t);
    in_front_facing = (floatBitsToUint(stored.x) & 0x80000000u) == 0u;
    return true;
}

vec3 shade(ivec2 pixel, vec2 point, uvec2 id) {
    triangle t = triangle_of_item(push.scene, visible_item(id, push.triangle_bits) - 1u);
    uint number = visible_triangle(id, push.triangle_bits);
    if (STORED_WEIGHTS == 0u || !interpolate_stored(t, number, pixel)) {
        triangle_fetch_vertices(t, push.scene, push.indices, number);
        triangle_fetch_positions(t, push.scene, push.view);
        interpolate_at(t, point);
    }
    material_array materials = push.scene.scene.materials;
    surface s = material_surface(materials, in_ids.x);
    if (LIGHTING_MASKS) s.light_mask = item_light_mask(push.scene, in_ids.y);
    in_pixel = uvec2(pixel);
    decals_on_surface(s, push.view, push.scene);
    float view_depth = -(push.view.view.world_to_view * vec4(s.position, 1.0)).z;
    return shade_surface(s, push.view, push.lighting, push.counters, uvec2(pixel), view_depth, in_ids.y);
}

// The samples of a triangle are shaded at their middle, which lies in the part that is seen.
vec2 middle_of(uint samples) {
    vec2 sum = vec2(0.0);
    for (uint i = 0u; i < SAMPLES; i++)
        if ((samples >> i & 1u) == 1u) sum += sample_place(i);
    return sum / float(bitCount(samples));
}

// Where visibility_grid_add sees a pixel: the places of samples in a pixel of twice the size.
vec2 grid_place(ivec2 pixel) {
    const vec2 places[4] = vec2[](vec2(0.75, 0.25), vec2(0.75, 0.75), vec2(0.25, 0.25), vec2(0.25, 0.75));
    return vec2(pixel) + places[(pixel.y & 1) * 2 + (pixel.x & 1)];
}

void main() {
    ivec2 pixel = ivec2(pixel_of_place(gl_WorkGroupID.xy, gl_LocalInvocationIndex)), size = ivec2(push.view.view.size);
    uint surface_index = 0u;
    if (LISTED != VISIBLE_GRID) {
        uint at = push.range.at[0] + LINEAR_INVOCATION;
        if (at >= push.range.at[1]) return;
        uint entry = push.entries.at[LISTED == VISIBLE_SORTED ? at * 2u + 1u : at], index = entry & VISIBLE_PIXEL_MASK;
        pixel = ivec2(index % uint(size.x), index / uint(size.x));
        surface_index = entry >> VISIBLE_SURFACE_SHIFT;
    } else if (any(greaterThanEqual(pixel, size))) {
        return;
    }
    uint samples = SAMPLES > 1u ? surface_samples(push.words.at[pixel.y * size.x + pixel.x], surface_index) : 1u;
    uvec2 id = visible_id(push.ids, push.ids_high, pixel, findLSB(samples));
    vec2 point = SAMPLES > 1u ? vec2(pixel) + middle_of(samples) : GRID == 1u ? grid_place(pixel) : vec2(pixel) + 0.5;
    vec4 radiance = vec4(push.background, 0.0);
    // In one place: compilers put a copy of all that it calls wherever it is called.
    if (LISTED != VISIBLE_GRID || visible_item(id, push.triangle_bits) != 0u) radiance = vec4(shade(pixel, point, id), 1.0);
    radiance.rgb = min(radiance.rgb, vec3(push.view.view.frame.frame.hdr_max));
    if (SAMPLES == 1u) {
        imageStore(images[push.radiance], pixel, radiance);
        return;
    }
    store_result(push.results, push.sums.at[place_of_pixel(uvec2(pixel), uvec2(size))] + surface_index, radiance.rgb);
    if (COUNT_LIGHTS == 1u) atomicAdd(push.counts.at[EDGES_SHADED], 1u);
}
