#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Sorts the fragments of a pixel by their depth at one sample and blends them, the farthest first: premultiplied colour, and coverage for
// the blending with what is opaque.
#include "common.glsl"
#include "passes/transparency/linked.glsl"

layout(push_constant, scalar) uniform push_block { gpu_linked_composite_push push; };
layout(location = 0) out vec4 out_color;

const uint FEW = 16u; // insertion is quicker up to here

// Vulkan's standard sample locations, in pixels from its middle.
const vec2 offsets[16] = vec2[](vec2(0.0), vec2(0.0), // 1 sample
                                vec2(0.25, 0.25), vec2(-0.25, -0.25), // 2
                                vec2(-0.125, -0.375), vec2(0.375, -0.125), vec2(-0.375, 0.125), vec2(0.125, 0.375), // 4
                                vec2(0.0625, -0.1875), vec2(-0.0625, 0.1875), vec2(0.3125, 0.0625), vec2(-0.1875, -0.3125),
                                vec2(-0.3125, 0.3125), vec2(-0.4375, -0.0625), vec2(0.1875, 0.4375), vec2(0.4375, -0.4375));

float depth_of(uint fragment) {
    float depth = push.keys.at[fragment].depth;
    if (push.samples == 1u) return depth;
    return depth + dot(push.extents.at[fragment].slope, offsets[push.samples + push.sample_index]);
}

// Whether a is behind b. Fragments that are alike in all they are sorted by differ in nothing that shows.
bool before(uint a, uint b) {
    float depth_a = depth_of(a), depth_b = depth_of(b);
    if (depth_a != depth_b) return depth_a < depth_b;
    gpu_blend_key key_a = push.keys.at[a], key_b = push.keys.at[b];
    if (key_a.item != key_b.item) return key_a.item < key_b.item;
    if (key_a.corner != key_b.corner) return key_a.corner < key_b.corner;
    vec4 color_a = push.colors.at[a], color_b = push.colors.at[b];
    for (int k = 0; k < 4; k++)
        if (color_a[k] != color_b[k]) return color_a[k] < color_b[k];
    return false;
}

void insertion_sort(uint first, uint count) {
    for (uint i = 1u; i < count; i++) {
        uint moved = push.order.at[first + i], j = i;
        for (; j > 0u && before(moved, push.order.at[first + j - 1u]); j--) push.order.at[first + j] = push.order.at[first + j - 1u];
        push.order.at[first + j] = moved;
    }
}

// Puts `moved` into the heap below `root`, whose top is the nearest fragment.
void sift(uint first, uint root, uint count, uint moved) {
    for (uint child = 2u * root + 1u; child < count; child = 2u * root + 1u) {
        if (child + 1u < count && before(push.order.at[first + child], push.order.at[first + child + 1u])) child++;
        uint other = push.order.at[first + child];
        if (!before(moved, other)) break;
        push.order.at[first + root] = other;
        root = child;
    }
    push.order.at[first + root] = moved;
}

// Williams 1964: in place, never more than n log n.
void heap_sort(uint first, uint count) {
    for (uint i = count / 2u; i-- > 0u;) sift(first, i, count, push.order.at[first + i]);
    for (uint i = count - 1u; i > 0u; i--) {
        uint last = push.order.at[first + i];
        push.order.at[first + i] = push.order.at[first];
        sift(first, 0u, i, last);
    }
}

void main() {
    uvec2 pixel = min(uvec2(gl_FragCoord.xy), uvec2(push.width, push.height) - 1u); // helpers lie beside the picture too
    uint index = pixel.y * push.width + pixel.x;
    uint first = push.sums.at[index], end = push.sums.at[index + 1u];
    uint written = gl_HelperInvocation || end > push.capacity ? 0u : min(push.written.at[index], end - first);
    float opaque = 0.0;
    // What lies in the opaque surface itself is hidden, as it is for the depth test; depths by slopes have lost their last bits.
    if (push.samples > 1u) opaque = texelFetch(textures_multisampled[push.depth], ivec2(pixel), int(push.sample_index)).x * (1.0 + 1e-6);
    uint start = first * push.samples + (end - first) * push.sample_index, count = 0u;
    for (uint i = first; i < first + written; i++) {
        bool covers = push.samples == 1u || ((push.extents.at[i].mask >> push.sample_index & 1u) != 0u && depth_of(i) > opaque);
        if (covers) push.order.at[start + count++] = i;
    }
    if (count <= FEW)
        insertion_sort(start, count);
    else
        heap_sort(start, count);
    vec3 radiance = vec3(0.0);
    float open = 1.0;
    for (uint i = 0u; i < count; i++) {
        vec4 color = push.colors.at[push.order.at[start + i]];
        radiance = color.rgb + radiance * (1.0 - color.a);
        open *= 1.0 - color.a;
    }
    if (count == 0u) discard;
    out_color = vec4(radiance, 1.0 - open);
    gl_SampleMask[0] = int(1u << push.sample_index);
}
