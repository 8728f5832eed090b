#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#extension GL_EXT_buffer_reference_uvec2 : require
// Irradiance as spherical harmonics (environment_maps_shared.h). One work group; sums are added in a fixed order.
#include "passes/ambient/environment_texels.glsl"

layout(local_size_x = ENVIRONMENT_LIGHT_THREADS) in;
layout(push_constant, scalar) uniform push_block { gpu_environment_light_push push; };

shared vec4 parts[ENVIRONMENT_LIGHT_THREADS]; // w: solid angle

void basis(vec3 n, out float values[9]) {
    values = float[9](1.0, n.y, n.z, n.x, n.x * n.y, n.y * n.z, 3.0 * n.z * n.z - 1.0, n.x * n.z, n.x * n.x - n.y * n.y);
}

void main() {
    // The squares of the functions' norms, times what the cosine lobe leaves of each band (1, 2/3, 1/4): radiance that a white surface reflects.
    const float scales[9] = float[9](0.25 / PI, 0.5 / PI, 0.5 / PI, 0.5 / PI, 0.9375 / PI, 0.9375 / PI, 0.078125 / PI, 0.9375 / PI, 0.234375 / PI);
    vec3 sums[9];
    float angle = 0.0;
    for (uint b = 0u; b < 9u; b++) sums[b] = vec3(0.0);
    for (uint index = gl_LocalInvocationIndex; index < 6u * push.side * push.side; index += ENVIRONMENT_LIGHT_THREADS) {
        uint face;
        uvec2 at;
        texel_place(index, push.side, face, at);
        vec2 place = (vec2(at) + 0.5) / float(push.side) * 2.0 - 1.0;
        vec3 point = face_point(face, place.x, place.y);
        float length2 = dot(point, point), solid = 1.0 / (length2 * sqrt(length2)), values[9];
        basis(point * inversesqrt(length2), values);
        vec3 color = texel_unpack(push.texels.at[push.first + index]) * solid;
        for (uint b = 0u; b < 9u; b++) sums[b] += color * values[b];
        angle += solid;
    }
    float unit = uvec2(push.peak) == uvec2(0u) ? 1.0 : texel_unit(push.peak.at[0]);
    if (gl_LocalInvocationIndex == 0u) push.light.light.unit = unit;
    /* Unrolled, these loops have 81 barriers, and CPU drivers take seconds to compile them. */
    [[dont_unroll]] for (uint b = 0u; b < 9u; b++) {
        parts[gl_LocalInvocationIndex] = vec4(sums[b], angle);
        [[dont_unroll]] for (uint half_count = ENVIRONMENT_LIGHT_THREADS / 2u; half_count > 0u; half_count /= 2u) {
            barrier();
            if (gl_LocalInvocationIndex < half_count) parts[gl_LocalInvocationIndex] += parts[gl_LocalInvocationIndex + half_count];
        }
        if (gl_LocalInvocationIndex == 0u) push.light.light.diffuse[b] = parts[0].rgb * (scales[b] * 4.0 * PI / parts[0].w) * unit;
        barrier();
    }
}
