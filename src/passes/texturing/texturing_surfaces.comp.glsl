#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Tells the surfaces of each pixel apart: one thread a pixel. The fragment of a triangle gives all samples that it covers the same
// bits, and those of two triangles differ unless they show the same point; but where nothing tells them apart, as without
// coordinates, a pole may stand before a wall of its own material: samples of one surface lie in one plane, too.
#include "common.glsl"
#include "scene.glsl"
#include "view.glsl"
#include "lights/iterate.glsl"
#include "passes/texturing/texturing.glsl"
#include "passes/visibility/visible.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform push_block { gpu_texturing_surfaces_push push; };

// The plane is that of the shading normal, which bends: so many pixel widths off it are allowed.
const float PLANE_WIDTHS = 2.0;

shared uint group_counts[EDGES_SHADED];

float depth_at(uvec2 pixel, uint at) { return texelFetch(textures_multisampled[push.depth], ivec2(pixel), int(at)).r; }

vec4 stored(uint i, uvec2 pixel, uint at) { return texelFetch(textures_multisampled[push.targets[i]], ivec2(pixel), int(at)); }

bool equal_bits(uvec2 pixel, uint a, uint b) {
    bool equal = true;
    for (uint i = 0u; i < push.target_count; i++) equal = equal && stored(i, pixel, a) == stored(i, pixel, b);
    return equal;
}

vec3 place_of(uvec2 pixel, uint at) {
    return view_position_of(push.view, ndc_of_pixel(push.view, vec2(pixel) + sample_place(at)),
                            view_depth_of(push.view, depth_at(pixel, at)));
}

vec3 normal_of(uvec2 pixel, uint at) {
    vec3 normal;
    vec4 tangent;
    bool front;
    uvec2 frame = target_bits(TARGET_FRAME, stored(TARGET_FRAME, pixel, at)).xy;
    if ((FORM & TEXTURING_VIRTUAL) != 0u)
        quaternion_unpack(frame.x, normal, tangent);
    else
        frame_unpack(frame, normal, tangent, front);
    return mat3(push.view.view.world_to_view) * normal;
}

bool same_surface(uvec2 pixel, uint a, uint b) {
    if (!equal_bits(pixel, a, b)) return false;
    float width = pixel_width(push.view, view_depth_of(push.view, depth_at(pixel, a)));
    return abs(dot(normal_of(pixel, a), place_of(pixel, b) - place_of(pixel, a))) <= PLANE_WIDTHS * width;
}

bool is_shown(uvec2 pixel, uint at) {
    if (depth_at(pixel, at) <= 0.0) return false;
    return (FORM & TEXTURING_VIRTUAL) == 0u || target_bits(TARGET_UV, stored(TARGET_UV, pixel, at)).x != VIRTUAL_NOWHERE;
}

uint surfaces_of(uvec2 pixel, out uint word) {
    uint firsts[8], count = 0u;
    word = 0xffffffffu;
    for (uint i = 0u; i < SAMPLES; i++) {
        if (!is_shown(pixel, i)) continue;
        uint found = count;
        for (uint k = 0u; k < count; k++)
            if (found == count && same_surface(pixel, firsts[k], i)) found = k;
        if (found == count) firsts[count++] = i;
        word ^= (SURFACE_NONE ^ found) << (SURFACE_BITS * i);
    }
    return count;
}

void main() {
    uint place = (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * 64u + gl_LocalInvocationIndex, count = 0u, word;
    uvec2 size = push.view.view.size, pixel = pixel_of_place(gl_WorkGroupID.xy, gl_LocalInvocationIndex);
    bool inside = all(lessThan(pixel, size));
    if (inside) count = surfaces_of(pixel, word);
    push.sums.at[place] = count;
    if (gl_LocalInvocationIndex < EDGES_SHADED) group_counts[gl_LocalInvocationIndex] = 0u;
    barrier();
    if (inside) {
        push.words.at[pixel.y * size.x + pixel.x] = word;
        if (count > 0u) atomicAdd(group_counts[EDGES_PIXELS], 1u);
        if (surface_is_edge(word)) atomicAdd(group_counts[EDGES_MIXED], 1u);
        if (count > 0u) atomicAdd(group_counts[EDGES_SURFACES], count);
        atomicAdd(group_counts[EDGES_SAMPLES], SAMPLES - uint(bitCount(surface_samples(word, SURFACE_NONE))));
    }
    barrier();
    uint counter = gl_LocalInvocationIndex;
    if (counter < EDGES_SHADED && group_counts[counter] != 0u) atomicAdd(push.counts.at[counter], group_counts[counter]);
}
