#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Views for people of what the samples of a pixel refer to: the mean of a colour for each, or one for the pixel.
#include "passes/dais/dais_pixel.glsl"
#include "passes/debug/colors_shared.h"

layout(constant_id = DAIS_SHOW_ID) const uint WHICH = DAIS_VIEW_ADDRESSES;

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform push_block { gpu_dais_shade_push push; };

vec3 hash_color(uint word) {
    uint h = word * 0x9e3779b1u;
    h = (h ^ h >> 15) * 0x85ebca6bu;
    h ^= h >> 13;
    return 0.15 + 0.85 * vec3(h & 255u, h >> 8 & 255u, h >> 16 & 255u) / 255.0;
}

vec3 seen(uint reference) {
    if (reference == 0u) return vec3(0.0);
    if (reference == DAIS_NO_ROOM) return vec3(1.0);
    if (WHICH == DAIS_VIEW_ADDRESSES) return hash_color(reference);
    return (push.pool.at[reference + 2u] & DAIS_REDUNDANT) != 0u ? vec3(1.0, 0.1, 0.1) : vec3(0.15);
}

void main() {
    uvec2 pixel = gl_GlobalInvocationID.xy, size = push.view.view.size;
    if (any(greaterThanEqual(pixel, size))) return;
    dais_source from = dais_source(push.pool, push.heads, push.nodes, push.references, push.shared_samples, size);
    dais_pixel p = dais_read(from, ivec2(pixel));
    vec3 color = vec3(0.0);
    if (WHICH == DAIS_VIEW_TRIANGLES) {
        uint count = 0u, left = shaded_samples(p);
        for (uint slot = 0u; slot < SAMPLES; slot++) {
            if (left != 0u) count++;
            left &= ~first_triangle(from, p, left);
        }
        const vec3 colors[5] = vec3[](vec3(0.0), DEBUG_DAIS_1(vec3), DEBUG_DAIS_2(vec3), DEBUG_DAIS_3(vec3), DEBUG_DAIS_4(vec3));
        color = colors[min(count, 4u)];
    } else {
        for (uint i = 0u; i < SAMPLES; i++) color += seen(p.references[i]) / float(SAMPLES);
    }
    imageStore(images[push.target], ivec2(pixel), push.sample_capacity == 1u ? vec4(color.bgr, 1.0) : vec4(color, 1.0));
}
