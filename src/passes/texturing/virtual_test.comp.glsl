#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Packs what the geometry pass of virtual texturing writes, and unpacks frames again.
#include "common.glsl"
#include "view.glsl"
#include "lights/iterate.glsl"
#include "scene.glsl"
#include "passes/texturing/texturing.glsl"
#include "passes/texturing/virtual_locate.glsl"
#include "passes/texturing/virtual_test_shared.h"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform push_block { gpu_virtual_test_push push; };

void main() {
    uint i = LINEAR_INVOCATION;
    if (i >= push.count) return;
    virtual_cases cases = push.cases;
    gpu_virtual_case c = cases.at[i];
    gpu_virtual_result r;
    r.packed = virtual_locate(push.pages, c.material, vec4(c.uv, 0.0, 0.0), vec4(c.change, 0.0, 0.0, 0.0), vec4(0.0));
    r.frame = quaternion_pack(c.normal.xyz, c.tangent);
    vec3 normal;
    quaternion_unpack(r.frame, normal, r.tangent);
    r.normal = vec4(normal, 0.0);
    push.results.at[i] = r;
}
