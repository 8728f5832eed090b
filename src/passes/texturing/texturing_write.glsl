// SPDX-License-Identifier: MIT
// Writes what a surface's textures are to be read with: what both entry points share. Reads none itself.
#include "common.glsl"
#include "view.glsl"
#include "lights/iterate.glsl"
#include "material.glsl"
#include "passes/geometry/geometry_shared.h"
#include "passes/texturing/texturing.glsl"
#include "passes/texturing/virtual_locate.glsl"

layout(push_constant, scalar) uniform push_block { gpu_texturing_geometry_push push; };

layout(location = 7) centroid in vec3 in_bind;

layout(location = 0) out uvec4 out_0;
layout(location = 1) out uvec4 out_1;
layout(location = 2) out uvec4 out_2;
layout(location = 3) out uvec4 out_3;
layout(location = 4) out uvec4 out_4;
layout(location = 5) out uvec4 out_5;
layout(location = 6) out uvec4 out_6;
layout(location = 7) out uvec4 out_7;

struct changes {
    vec4 uv_dx, uv_dy;
    vec2 depth;
    vec3 bind_dx, bind_dy;
};

// Call where control flow is uniform.
changes find_changes() {
    changes c;
    c.uv_dx = dFdx(in_uv);
    c.uv_dy = dFdy(in_uv);
    c.depth = vec2(dFdx(gl_FragCoord.z), dFdy(gl_FragCoord.z)) / max(gl_FragCoord.z, 1e-30);
    c.bind_dx = dFdx(in_bind);
    c.bind_dy = dFdy(in_bind);
    return c;
}

void write_targets(changes c) {
    uvec4 targets[TEXTURING_TARGETS];
    for (uint i = 0u; i < TEXTURING_TARGETS; i++) targets[i] = uvec4(0u);
    if ((FORM & TEXTURING_VIRTUAL) != 0u) {
        // The back of a double-sided surface is its front turned round: what a normal map shows is turned round with it.
        float side = material_front_facing() ? 1.0 : -1.0;
        targets[TARGET_FRAME].x = quaternion_pack(in_normal * side, in_tangent * side);
        targets[TARGET_UV].x = virtual_locate(push.pages, in_ids.x, in_uv, c.uv_dx, c.uv_dy);
        if ((FORM & TEXTURING_ITEMS) != 0u) targets[TARGET_ID].x = in_ids.y;
    } else {
        targets[TARGET_FRAME].xy = frame_pack(in_normal, in_tangent, material_front_facing());
        targets[TARGET_UV] = floatBitsToUint(in_uv);
        targets[TARGET_ID].x = (FORM & TEXTURING_ITEMS) != 0u ? in_ids.y : in_ids.x;
    }
    if ((FORM & TEXTURING_GRADIENTS) != 0u)
        targets[TARGET_GRADIENTS] =
            uvec4(pack_halves(c.uv_dx.xy), pack_halves(c.uv_dy.xy), pack_halves(c.uv_dx.zw), pack_halves(c.uv_dy.zw));
    if ((FORM & TEXTURING_SLOPES) != 0u) targets[TARGET_SLOPES].x = pack_halves(c.depth);
    if ((FORM & TEXTURING_COLORS) != 0u) targets[TARGET_COLORS].xy = uvec2(packUnorm2x16(in_color.xy), packUnorm2x16(in_color.zw));
    if ((FORM & TEXTURING_BIND) != 0u) {
        targets[TARGET_BIND] = uvec4(floatBitsToUint(in_bind), pack_halves(vec2(c.bind_dx.z, c.bind_dy.z)));
        targets[TARGET_BIND + 1u].xy = uvec2(pack_halves(c.bind_dx.xy), pack_halves(c.bind_dy.xy));
    }
    out_0 = targets[0];
    out_1 = targets[1];
    out_2 = targets[2];
    out_3 = targets[3];
    out_4 = targets[4];
    out_5 = targets[5];
    out_6 = targets[6];
    out_7 = targets[7];
}
