#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// The first step: material into the targets; ambient light and glow, which later steps know nothing of, into the light.
#include "common.glsl"
#include "material.glsl"
#include "decals_raster.glsl"
#include "shade.glsl"
#include "passes/geometry/geometry_shared.h"
#include "passes/mobile/mobile.glsl"

layout(push_constant, scalar) uniform push_block { gpu_geometry_push push; };

layout(location = 0) out vec4 out_0;
layout(location = 1) out vec4 out_1;
layout(location = 2) out vec4 out_2;
layout(location = 3) out vec4 out_3;
#if MOBILE_TARGETS > 4
layout(location = 4) out vec4 out_4;
#endif
#if MOBILE_TARGETS > 5
layout(location = 5) out vec4 out_5;
layout(location = 6) out vec4 out_6;
layout(location = 7) out vec4 out_7;
#endif

void main() {
    material_array materials = push.scene.scene.materials;
    bool hole;
    surface s = material_surface(materials, in_ids.x, hole);
    decals_on_gbuffer(s, push.view, push.scene);
    if (hole) discard;
    vec3 rest = shade_rest(s, push.view, to_viewer(push.view, s.position), vec3(0.0));
    mobile_texel g = mobile_pack(s, gl_FragCoord.z, mobile_scaled(push.view, rest));
    mobile_mark(g, abs(dot(geometric_unit(s), s.normal)) < MOBILE_SAME);
    out_0 = g.t[0];
    out_1 = g.t[1];
    out_2 = g.t[2];
    out_3 = g.t[3];
#if MOBILE_TARGETS > 4
    out_4 = g.t[4];
#endif
#if MOBILE_TARGETS > 5
    out_5 = g.t[5];
    out_6 = g.t[6];
    out_7 = g.t[7];
#endif
}
