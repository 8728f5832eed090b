// SPDX-License-Identifier: MIT
// What the shaders that build the trees share.
#ifndef RAYS_BUILD_GLSL
#define RAYS_BUILD_GLSL

#define RAY_NODE_ACCESS coherent
#include "shadows/rays.glsl"

layout(buffer_reference) buffer coherent_counter_array;

#include "passes/shadow/rays_build_shared.h"

layout(buffer_reference, scalar, buffer_reference_align = 4) coherent buffer coherent_counter_array { uint at[]; };

const float RAY_FAR = 3e38;

// The lower ten bits, two zeros between any two.
uint spread_bits(uint x) {
    x = (x | x << 16) & 0x030000ffu;
    x = (x | x << 8) & 0x0300f00fu;
    x = (x | x << 4) & 0x030c30c3u;
    return (x | x << 2) & 0x09249249u;
}

// Place on a Morton curve of `bits` an axis through the cube 0 .. 1; NaN: at its beginning.
uint morton_code(vec3 part, uint bits) {
    uint code = 0u;
    for (int k = 0; k < 3; k++)
        code |= spread_bits(part[k] > 0.0 ? min(uint(min(part[k], 1.0) * float(1u << bits)), (1u << bits) - 1u) : 0u) << k;
    return code;
}

// The primitive of a triangle of the table: the last that begins no later, and is not empty.
uint primitive_of(ray_mesh_array table, uint count, uint triangle) {
    uint low = 0u, high = count;
    while (high - low > 1u) {
        uint middle = (low + high) / 2u;
        if (table.at[middle].first <= triangle)
            low = middle;
        else
            high = middle;
    }
    return low;
}

gpu_ray_box ray_box_widened(vec3 low, vec3 high) {
    vec3 slack = 1e-6 * max(abs(low), abs(high));
    return gpu_ray_box(low - slack, high + slack);
}

#endif
