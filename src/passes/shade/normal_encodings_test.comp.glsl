#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// For the test: sends normals through an encoding and a UNORM target.
#include "normal_encodings.glsl"

layout(buffer_reference) buffer normal_array;

#include "passes/shade/normal_encodings_test_shared.h"

layout(buffer_reference, scalar, buffer_reference_align = 4) buffer normal_array { vec3 at[]; };

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform push_block { gpu_encodings_push push; };

void main() {
    uint index = LINEAR_INVOCATION;
    if (index >= push.count) return;
    vec3 n = push.normals.at[index], e = vec3(0.0), d = vec3(0.0);
    uint kind = push.encoding;
    if (kind == ENCODING_XY) e.xy = normal_encode_xy(n);
    if (kind == ENCODING_SPHERICAL) e.xy = normal_encode_spherical(n);
    if (kind == ENCODING_SPHERE_MAP) e.xy = normal_encode_sphere_map(n);
    if (kind == ENCODING_STEREOGRAPHIC) e.xy = normal_encode_stereographic(n);
    if (kind == ENCODING_OCTAHEDRAL) e.xy = octahedral_encode(n) * 0.5 + 0.5;
    if (kind == ENCODING_VIEW) e.xy = normal_encode_view(n, push.to_view);
    if (kind == ENCODING_BEST_FIT) e = normal_encode_best_fit(n);
    if (kind == ENCODING_XYZ) e = normal_encode_xyz(n);
    e = round(clamp(e, 0.0, 1.0) * float(push.most)) / float(push.most);
    push.stored.at[index] = e;
    if (kind == ENCODING_XY) d = normal_decode_xy(e.xy);
    if (kind == ENCODING_SPHERICAL) d = normal_decode_spherical(e.xy);
    if (kind == ENCODING_SPHERE_MAP) d = normal_decode_sphere_map(e.xy);
    if (kind == ENCODING_STEREOGRAPHIC) d = normal_decode_stereographic(e.xy);
    if (kind == ENCODING_OCTAHEDRAL) d = octahedral_decode(e.xy * 2.0 - 1.0);
    if (kind == ENCODING_VIEW) d = normal_decode_view(e.xy, push.to_view);
    if (kind == ENCODING_BEST_FIT) d = normal_decode_best_fit(e);
    if (kind == ENCODING_XYZ) d = normal_decode_xyz(e);
    push.decoded.at[index] = d;
}
