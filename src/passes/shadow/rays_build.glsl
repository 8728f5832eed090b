// SPDX-License-Identifier: MIT
// What the shaders that build the trees share.
#ifndef RAYS_BUILD_GLSL
#define RAYS_BUILD_GLSL

#define RAY_NODE_ACCESS coherent
#include "shadows/rays.glsl"

layout(buffer_reference) buffer coherent_counter_array;
layout(buffer_reference) buffer ray_instance_array;
layout(buffer_reference) buffer structure_array;

#include "passes/shadow/rays_build_shared.h"

layout(buffer_reference, scalar, buffer_reference_align = 4) coherent buffer coherent_counter_array { uint at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer ray_instance_array { gpu_ray_instance at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer structure_array { uvec2 at[]; };

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

// A transform that flattens has no inverse: what it flattens gets a thickness that is nothing beside its size.
mat3 invertible(mat3 m) {
    float size = max(max(length(m[0]), length(m[1])), max(length(m[2]), 1e-20));
    if (abs(determinant(m / size)) > 1e-12) return m;
    for (int k = 0; k < 3; k++) {
        vec3 a = m[(k + 1) % 3] / size, b = m[(k + 2) % 3] / size, normal = cross(a, b);
        if (dot(normal, normal) < 1e-12) continue;
        m[k] += normalize(normal) * (1e-6 * size);
        break;
    }
    return m;
}

mat3 instance_matrix(gpu_instance instance) {
    return invertible(transpose(mat3(instance.rows[0].xyz, instance.rows[1].xyz, instance.rows[2].xyz)));
}

// The way from the world to the object.
gpu_ray_item ray_item_of(mat3 m, vec3 origin, uint primitive) {
    mat3 inverted = inverse(m);
    vec3 moved = -(inverted * origin);
    gpu_ray_item placed;
    mat3 rows = transpose(inverted);
    for (int k = 0; k < 3; k++) placed.rows[k] = vec4(rows[k], moved[k]);
    placed.primitive = primitive;
    return placed;
}

gpu_ray_box ray_box_widened(vec3 low, vec3 high) {
    vec3 slack = 1e-6 * max(abs(low), abs(high));
    return gpu_ray_box(low - slack, high + slack);
}

#endif
