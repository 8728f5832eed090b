#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Shades each triangle that a pixel refers to, once: one thread for each pixel and slot.
#include "passes/dais/dais_surface.glsl"
#include "passes/dais/dais_pixel.glsl"
#include "passes/dais/log_luv.glsl"
bool ambient_known;
vec3 ambient_light;
#define AMBIENT_DIFFUSE(v, normal) (ambient_known ? ambient_light : ambient_radiance(v, normal))
#include "shade.glsl"

layout(constant_id = 14) const uint PROBE = DAIS_SHOW_RADIANCE;

layout(local_size_x = 64) in; // 8x8 pixels, in squares of four
layout(push_constant, scalar) uniform push_block { gpu_dais_shade_push push; };

vec3 probe(float view_depth, ivec2 pixel) {
    if (PROBE == DAIS_SHOW_POSITION) return in_position;
    if (PROBE == DAIS_SHOW_NORMAL) return in_normal;
    if (PROBE == DAIS_SHOW_UV) {
        float longer = max(length(in_uv_dx.xy), length(in_uv_dy.xy)) * 1024.0;
        return vec3(in_uv.xy, max(log2(max(longer, 1e-20)), 0.0));
    }
    float other = view_depth_of(push.view, texelFetch(textures[push.depth], pixel, 0).r);
    return vec3(view_depth, other, abs(view_depth - other) / other);
}

void main() {
    uint place = gl_LocalInvocationIndex, square = place >> 2;
    ivec2 pixel = ivec2(gl_WorkGroupID.xy * 8u + uvec2(square & 3u, square >> 2) * 2u + uvec2(place & 1u, place >> 1 & 1u));
    uvec2 size = push.view.view.size;
    if (any(greaterThanEqual(uvec2(pixel), size))) return;
    dais_source from = dais_source(push.pool, push.heads, push.nodes, push.references, push.shared_samples, size);
    dais_pixel p = dais_read(from, pixel);
    uint slot = gl_WorkGroupID.z, mask = slot_samples(from, p, slot);
    vec3 radiance = push.background;
    if (mask != 0u) {
        uint first = uint(findLSB(mask));
        float view_depth = dais_interpolate(push.view, push.pool, p.references[first], vec2(pixel) + shading_place(mask));
        material_array materials = push.scene.scene.materials;
        surface s = material_surface(materials, in_ids.x);
        decals_on_surface(s, push.view, push.scene);
        ambient_known = false;
        ambient_light = vec3(0.0);
        if (SHARED_SAMPLES == 1u && p.shading[first] != 0u) {
            ambient_known = true;
            ambient_light = log_luv_decode(push.samples.at[2u * p.shading[first]]);
        }
        radiance = shade_surface(s, push.view, push.lights, push.counters, uvec2(pixel), view_depth, in_ids.y);
        radiance = min(radiance, vec3(push.view.view.hdr_max));
        if (PROBE != DAIS_SHOW_RADIANCE) radiance = probe(view_depth, pixel);
        if (COUNT_LIGHTS == 1u) atomicAdd(push.counts.at[DAIS_SHADED], 1u);
        if (SAMPLES > 1u) store_result(push.results, slot * size.x * size.y + uint(pixel.y) * size.x + uint(pixel.x), radiance);
    }
    if (SAMPLES == 1u) imageStore(images[push.target], pixel, vec4(radiance, 1.0));
}
