#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Morph targets, then skinning, of one primitive's vertices: once a frame, into the vertex buffer that every pass reads.
#define POSITION_ACCESS
#include "common.glsl"
#include "scene.glsl"

layout(buffer_reference) buffer deform_array;
layout(buffer_reference) buffer influence_array;
layout(buffer_reference) buffer float_array;
layout(buffer_reference) buffer matrix_array;

#include "passes/geometry/skin_shared.h"

layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer deform_array { gpu_deform at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer influence_array { gpu_influence at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer float_array { float at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer matrix_array { mat4 at[]; };

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform push_block { gpu_skin_push push; };

vec3 morph_vector(uint first) { return vec3(push.morphs.at[first], push.morphs.at[first + 1u], push.morphs.at[first + 2u]); }

vec3 safe_normalize(vec3 v) {
    float length2 = dot(v, v);
    return length2 > 1e-30 ? v * inversesqrt(length2) : vec3(0.0, 0.0, 1.0);
}

void main() {
    gpu_deform d = push.deforms.at[push.deform];
    uint vertex = LINEAR_INVOCATION;
    if (vertex >= d.count) return;

    vec3 position = push.positions.at[d.source + vertex];
    gpu_attributes a = push.attributes.at[d.source + vertex];
    vec3 normal = unpack_normal(a.normal);
    vec4 tangent = unpack_tangent(a.tangent);

    for (uint target = 0u; target < d.morph_count; target++) {
        float weight = push.weights.at[d.first_weight + target];
        if (weight == 0.0) continue;
        uint first = d.first_morph + (target * d.count + vertex) * 9u;
        position += weight * morph_vector(first);
        normal += weight * morph_vector(first + 3u);
        tangent.xyz += weight * morph_vector(first + 6u);
    }
    if (d.joint_count > 0u) {
        mat4 skin = mat4(0.0);
        uint first = d.first_influence + vertex * d.joint_count;
        for (uint i = 0u; i < d.joint_count; i++) {
            gpu_influence influence = push.influences.at[first + i];
            if (influence.weight != 0.0) skin += influence.weight * push.matrices.at[d.first_matrix + influence.joint];
        }
        position = (skin * vec4(position, 1.0)).xyz;
        mat3 linear = mat3(skin);
        mat3 cofactor = mat3(cross(linear[1], linear[2]), cross(linear[2], linear[0]), cross(linear[0], linear[1]));
        float mirror = dot(linear[0], cofactor[0]) < 0.0 ? -1.0 : 1.0;
        normal = cofactor * normal * mirror;
        tangent = vec4(linear * tangent.xyz, tangent.w * mirror);
    }
    a.normal = pack_normal(safe_normalize(normal));
    a.tangent = pack_tangent(safe_normalize(tangent.xyz), tangent.w < 0.0);
    push.positions.at[d.target + vertex] = position;
    push.attributes.at[d.target + vertex] = a;
}
