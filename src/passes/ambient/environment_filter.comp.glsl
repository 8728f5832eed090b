#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// What a surface of one roughness reflects, seen from the front: the GGX lobe is sampled where it is strong, and each sample reads the mip whose
// texels are as large as its share of the lobe (Krivanek and Colbert 2008, "Real-time shading with filtered importance sampling").
#include "passes/ambient/environment_texels.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform push_block { gpu_environment_filter_push push; };

void main() {
    uint face, index = LINEAR_INVOCATION;
    uvec2 at;
    if (!texel_place(index, push.side, face, at)) return;
    vec2 place = (vec2(at) + 0.5) / float(push.side) * 2.0 - 1.0;
    vec3 axis = normalize(face_point(face, place.x, place.y));
    vec3 side = normalize(cross(abs(axis.y) < 0.9 ? vec3(0.0, 1.0, 0.0) : vec3(1.0, 0.0, 0.0), axis)), up = cross(axis, side);
    float alpha2 = push.alpha * push.alpha, texel = 4.0 * PI / (6.0 * float(push.cube_side * push.cube_side));
    vec3 sum = vec3(0.0);
    float weight = 0.0;
    for (uint i = 0u; i < push.samples; i++) {
        vec2 point = even_point(i, push.samples);
        float cosine2 = (1.0 - point.y) / (1.0 + (alpha2 - 1.0) * point.y), cosine = sqrt(cosine2), sine = sqrt(max(1.0 - cosine2, 0.0));
        float n_l = 2.0 * cosine2 - 1.0; // mirrored at the half vector
        if (n_l <= 0.0) continue;
        vec3 direction = (side * cos(2.0 * PI * point.x) + up * sin(2.0 * PI * point.x)) * (2.0 * cosine * sine) + axis * n_l;
        float d = cosine2 * (alpha2 - 1.0) + 1.0, density = alpha2 / (4.0 * PI * d * d); // of the direction
        float lod = 0.5 * log2(1.0 / (float(push.samples) * density * texel)) + 0.0;     // overlapping shares are smoother
        sum += n_l * textureLod(samplerCube(cubes[push.cube], samplers[push.sampler_index]), direction, max(lod, 0.0)).rgb;
        weight += n_l;
    }
    push.texels.at[push.first + index] = texel_pack(sum / weight);
}
