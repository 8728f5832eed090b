#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Tells the surfaces of each pixel apart by what its samples store: one thread a pixel. Most compare all samples with the first and are
// done.
#include "common.glsl"
#include "gbuffer.glsl"
#include "passes/shade/edges.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform push_block { gpu_edges_push push; };

shared uint group_counts[EDGES_SHADED];

// Points of one surface lie within so many pixel widths of its plane: with the shading normal for the plane's, a bent normal must not
// make an edge of every steep slope.
const float PLANE_WIDTHS = 2.0;

vec3 stored_emission(ivec2 pixel, uint at) { return texelFetch(textures_multisampled[push.radiance], pixel, int(at)).rgb; }

struct sampled {
    surface s; // position in view space
    vec3 normal; // view space
    float width; // of a pixel there
};

sampled sample_at(ivec2 pixel, uint at) {
    sampled d;
    float view_depth;
    vec3 position = surface_point(push.view, push.gbuffer, pixel, 1u << at, view_depth);
    d.s = gbuffer_surface(push.gbuffer, pixel, int(at), position, stored_emission(pixel, at));
    d.normal = mat3(push.view.view.world_to_view) * d.s.normal;
    d.width = pixel_width(push.view, view_depth);
    return d;
}

bool equal_bits(ivec2 pixel, uint a, uint b) {
    gbuffer at_a = gbuffer_stored(push.gbuffer, pixel, int(a)), at_b = gbuffer_stored(push.gbuffer, pixel, int(b));
    for (uint i = 0u; i < GBUFFER_TARGETS; i++)
        if (at_a.targets[i] != at_b.targets[i]) return false;
    return stored_emission(pixel, a) == stored_emission(pixel, b);
}

bool like_layers(surface a, surface b) {
    if (!a.layered && !b.layered) return true;
    if (a.layered != b.layered) return false;
    vec3 off = abs(vec3(a.layers.clearcoat - b.layers.clearcoat, a.layers.clearcoat_roughness - b.layers.clearcoat_roughness, a.layers.anisotropy - b.layers.anisotropy));
    float near = 1.0 - 0.5 * push.tolerance * push.tolerance;
    return max_component(off) <= push.tolerance && (a.layers.clearcoat == 0.0 || dot(a.layers.clearcoat_normal, b.layers.clearcoat_normal) >= near) &&
           (a.layers.anisotropy == 0.0 || abs(dot(a.layers.tangent, b.layers.tangent)) >= near);
}

bool like_colors(sampled a, sampled b) {
    vec3 brighter = max(a.s.emissive, b.s.emissive);
    vec3 others = abs(vec3(a.s.roughness - b.s.roughness, a.s.metallic - b.s.metallic, a.s.occlusion - b.s.occlusion));
    return max(max_component(abs(a.s.base_color - b.s.base_color)), max_component(others)) <= push.tolerance &&
           max_component(abs(a.s.dielectric_f0 - b.s.dielectric_f0)) <= push.tolerance &&
           abs(a.s.dielectric_f90 - b.s.dielectric_f90) <= push.tolerance &&
           all(lessThanEqual(abs(a.s.emissive - b.s.emissive), brighter * push.tolerance)) && dot(a.normal, b.normal) > 0.0 &&
           dot(a.normal, b.normal) >= 1.0 - 0.5 * push.tolerance * push.tolerance;
}

// Whether two samples that are not sky show one surface.
bool same_surface(ivec2 pixel, uint a, uint b) {
    bool equal = equal_bits(pixel, a, b);
    if (!equal && push.tolerance == 0.0) return false;
    sampled at_a = sample_at(pixel, a), at_b = sample_at(pixel, b);
    if (!equal && !(like_colors(at_a, at_b) && like_layers(at_a.s, at_b.s))) return false;
    return abs(dot(at_a.normal, at_b.s.position - at_a.s.position)) <= PLANE_WIDTHS * at_a.width;
}

// How unlike two surfaces are, for merging: by what shading would make of them.
float unlike(sampled a, sampled b) {
    vec3 apart = b.s.position - a.s.position;
    float steps = (abs(dot(a.normal, apart)) + abs(dot(b.normal, apart))) / (2.0 * PLANE_WIDTHS * a.width);
    vec3 others = abs(vec3(a.s.roughness - b.s.roughness, a.s.metallic - b.s.metallic, 0.0));
    return 1.0 - dot(a.normal, b.normal) + min(steps, 2.0) + max_component(abs(a.s.base_color - b.s.base_color)) + max_component(others) +
           (a.s.emissive == b.s.emissive ? 0.0 : 1.0);
}

sampled surface_at(ivec2 pixel, uint word, uint surface_index) {
    return sample_at(pixel, uint(findLSB(surface_samples(word, surface_index))));
}

// Leaves at most push.limit surfaces: the two that are least alike stay, then the one least like those, and so on; each of the others
// joins the one that it is most alike. What samples store is read again for each comparison: an array of it would not fit into registers.
uint merged(ivec2 pixel, uint word, uint count) {
    uint kept = 0u;
    float widest = -1.0;
    for (uint i = 1u; i < count; i++) {
        sampled at_i = surface_at(pixel, word, i);
        for (uint j = 0u; j < i; j++) {
            float d = unlike(at_i, surface_at(pixel, word, j));
            if (!(d > widest)) continue;
            widest = d;
            kept = 1u << i | 1u << j;
        }
    }
    while (uint(bitCount(kept)) < push.limit) {
        uint next = 0u;
        widest = -1.0;
        for (uint i = 0u; i < count; i++) {
            if ((kept >> i & 1u) == 1u) continue;
            float nearest = 1e30;
            sampled at_i = surface_at(pixel, word, i);
            for (uint rest = kept; rest != 0u; rest &= rest - 1u) nearest = min(nearest, unlike(at_i, surface_at(pixel, word, uint(findLSB(rest)))));
            if (nearest > widest) {
                widest = nearest;
                next = i;
            }
        }
        kept |= 1u << next;
    }
    uint joined = 0u; // by surface, four bits each: what it becomes
    for (uint i = 0u; i < count; i++) {
        uint to = i;
        float nearest = 1e30;
        if ((kept >> i & 1u) == 0u) {
            sampled at_i = surface_at(pixel, word, i);
            for (uint rest = kept; rest != 0u; rest &= rest - 1u) {
                float d = unlike(at_i, surface_at(pixel, word, uint(findLSB(rest))));
                if (!(d < nearest)) continue;
                nearest = d;
                to = uint(findLSB(rest));
            }
        }
        joined |= to << (4u * i);
    }
    // Numbered anew by their first samples.
    uint result = 0xffffffffu, names = 0xffffffffu, found = 0u;
    for (uint s = 0u; s < SAMPLES; s++) {
        uint old = surface_of(word, s);
        if (old == SURFACE_NONE) continue;
        uint root = joined >> (4u * old) & 15u, name = names >> (4u * root) & 15u;
        if (name == 15u) {
            name = found++;
            names ^= (15u ^ name) << (4u * root);
        }
        result ^= (SURFACE_NONE ^ name) << (SURFACE_BITS * s);
    }
    return result;
}

uint surfaces_of(ivec2 pixel) {
    uint word = 0xffffffffu, count = 0u;
    for (uint s = 0u; s < SAMPLES; s++) {
        if (!(gbuffer_depth(push.gbuffer, pixel, int(s)) > 0.0) || gbuffer_is_forward(push.gbuffer, pixel, int(s))) continue;
        uint found = count;
        for (uint k = 0u; k < count && found == count; k++)
            if (same_surface(pixel, uint(findLSB(surface_samples(word, k))), s)) found = k;
        count = max(count, found + 1u);
        word ^= (SURFACE_NONE ^ found) << (SURFACE_BITS * s);
    }
    return count > push.limit ? merged(pixel, word, count) : word;
}

void main() {
    uvec2 pixel = gl_GlobalInvocationID.xy;
    if (gl_LocalInvocationIndex < EDGES_SHADED) group_counts[gl_LocalInvocationIndex] = 0u;
    barrier();
    if (all(lessThan(pixel, push.view.view.size))) {
        uint index = pixel.y * push.view.view.size.x + pixel.x;
        uint word = surfaces_of(ivec2(pixel)), count = surface_count(word);
        push.surfaces.at[index] = word;
        if (push.lists == 1u) push.sums.at[index] = max(count, 1u) - 1u;
        if (count > 0u) atomicAdd(group_counts[EDGES_PIXELS], 1u);
        if (surface_is_edge(word)) atomicAdd(group_counts[EDGES_MIXED], 1u);
        if (count > 0u) atomicAdd(group_counts[EDGES_SURFACES], count);
        atomicAdd(group_counts[EDGES_SAMPLES], SAMPLES - uint(bitCount(surface_samples(word, SURFACE_NONE))));
    }
    barrier();
    uint counter = gl_LocalInvocationIndex;
    if (counter < EDGES_SHADED && group_counts[counter] != 0u) atomicAdd(push.counts.at[counter], group_counts[counter]);
}
