#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Shades each triangle that a pixel refers to, once. Where pixels show several, the threads of a tile share what there is to do. In a frame
// whose pools overflowed it shades nothing: which references found room is a race, and the forward pass draws all of the frame.
#define MATERIAL_LAYERS LIGHTING_LAYERS
#include "passes/dais/dais_surface.glsl"
#include "passes/dais/dais_pixel.glsl"
#include "passes/dais/log_luv.glsl"
bool ambient_known;
vec3 ambient_light;
#define AMBIENT_DIFFUSE(v, normal) (ambient_known ? ambient_light : ambient_diffuse(v, normal))
#include "shade.glsl"

layout(constant_id = DAIS_SHOW_ID) const uint PROBE = DAIS_SHOW_RADIANCE;

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

// What threads have to shade besides the first triangle of their pixels: place | slot << 6 | samples << 9, reference, shading sample.
const uint MORE = SAMPLES > 1u ? 64u * (SAMPLES - 1u) : 1u;
shared uint more[MORE], more_references[MORE], more_shading[MORE];
shared uint more_count;

ivec2 pixel_at(uint place) {
    uint square = place >> 2;
    return ivec2(gl_WorkGroupID.xy * 8u + uvec2(square & 3u, square >> 2) * 2u + uvec2(place & 1u, place >> 1 & 1u));
}

vec3 shade(ivec2 pixel, uint mask, uint reference, uint shading) {
    float view_depth = dais_interpolate(push.view, push.pool, reference, vec2(pixel) + shading_place(mask));
    material_array materials = push.scene.scene.materials;
    surface s = material_surface(materials, in_ids.x);
    if (LIGHTING_MASKS) s.light_mask = item_light_mask(push.scene, in_ids.y);
    decals_on_surface(s, push.view, push.scene);
    // All shading samples or none: which of them found room is a race.
    ambient_known = SHARED_SAMPLES == 1u && shading != 0u && push.counts.at[DAIS_SAMPLES] < push.sample_capacity;
    ambient_light = vec3(0.0);
    if (ambient_known) ambient_light = log_luv_decode(push.samples.at[2u * shading]);
    vec3 radiance = shade_surface(s, push.view, push.lighting, push.counters, uvec2(pixel), view_depth, in_ids.y);
    if (PROBE != DAIS_SHOW_RADIANCE) return probe(view_depth, pixel);
    return min(radiance, vec3(push.view.view.frame.frame.hdr_max));
}

void main() {
    uint place = gl_LocalInvocationIndex, total = 64u;
    uvec2 size = push.view.view.size;
    bool inside = all(lessThan(uvec2(pixel_at(place)), size));
    if (SAMPLES > 1u) {
        if (place == 0u) more_count = 0u;
        barrier();
    }
    uint mask = 0u, reference = 0u, shading = 0u;
    if (inside) {
        ivec2 pixel = pixel_at(place);
        dais_source from = dais_source(push.pool, push.heads, push.nodes, push.references, push.shared_samples, size);
        dais_pixel p = dais_read(from, pixel);
        uint word = 0xffffffffu, left = push.counts.at[DAIS_OVERFLOW] != 0u ? 0u : shaded_samples(p);
        for (uint slot = 0u; slot < SAMPLES; slot++) {
            uint found = first_triangle(from, p, left), first = uint(findLSB(found));
            if (found == 0u) continue;
            left &= ~found;
            for (uint i = 0u; i < SAMPLES; i++)
                if ((found >> i & 1u) != 0u) word ^= (SURFACE_NONE ^ slot) << SURFACE_BITS * i;
            if (slot == 0u) {
                mask = found;
                reference = p.references[first];
                shading = p.shading[first];
            } else {
                uint at = atomicAdd(more_count, 1u);
                more[at] = place | slot << 6 | found << 9;
                more_references[at] = p.references[first];
                more_shading[at] = p.shading[first];
            }
        }
        if (SAMPLES > 1u) push.slots.at[uint(pixel.y) * size.x + uint(pixel.x)] = word;
        if (SAMPLES == 1u && mask == 0u) imageStore(images[push.target], pixel, vec4(push.background, 0.0));
    }
    if (SAMPLES > 1u) {
        barrier();
        total += more_count;
    }
    // Each thread the first triangle of its pixel; then all together those that are left, wherever in the tile.
    for (uint base = 0u; base < total; base += 64u) {
        uint slot = 0u;
        if (base > 0u) {
            uint at = base - 64u + gl_LocalInvocationIndex;
            mask = 0u;
            if (at < total - 64u) {
                place = more[at] & 63u;
                slot = more[at] >> 6 & 7u;
                mask = more[at] >> 9;
                reference = more_references[at];
                shading = more_shading[at];
            }
        }
        if (mask != 0u) {
            ivec2 pixel = pixel_at(place);
            vec3 radiance = shade(pixel, mask, reference, shading);
            if (COUNT_LIGHTS == 1u) atomicAdd(push.counts.at[DAIS_SHADED], 1u);
            if (SAMPLES > 1u)
                store_result(push.results, slot * size.x * size.y + uint(pixel.y) * size.x + uint(pixel.x), radiance);
            else
                imageStore(images[push.target], pixel, vec4(radiance, 1.0));
        }
    }
}
