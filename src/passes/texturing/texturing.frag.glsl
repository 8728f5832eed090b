#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Writes what a surface's textures are to be read with. Reads none itself, but for the one that cuts holes (CUTS_HOLES, for cutouts; with
// several samples a pixel a hole is cut from all of them). TARGETS_STORED: the targets have several samples.
#include "common.glsl"
#include "view.glsl"
#include "lights/iterate.glsl"
#include "material.glsl"
#include "passes/geometry/geometry_shared.h"
#include "passes/texturing/texturing.glsl"
#include "passes/texturing/virtual_locate.glsl"

layout(push_constant, scalar) uniform push_block { gpu_texturing_geometry_push push; };

layout(location = 7) centroid in vec3 in_bind;

#ifdef TARGETS_STORED // few devices have several samples of integers
#define TARGET vec4
#define TARGET_VALUE(i) target_stored(i, targets[i])
#else
#define TARGET uvec4
#define TARGET_VALUE(i) targets[i]
#endif
layout(location = 0) out TARGET out_0;
layout(location = 1) out TARGET out_1;
layout(location = 2) out TARGET out_2;
layout(location = 3) out TARGET out_3;
layout(location = 4) out TARGET out_4;
layout(location = 5) out TARGET out_5;
layout(location = 6) out TARGET out_6;
layout(location = 7) out TARGET out_7;

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
    if (GRADIENT_TARGETS == 2u) targets[TARGET_GRADIENTS + 1u].xy = targets[TARGET_GRADIENTS].zw;
    if ((FORM & TEXTURING_SLOPES) != 0u) {
        if (HAS_SAMPLES)
            targets[TARGET_ID].y = pack_halves(c.depth);
        else
            targets[TARGET_SLOPES].x = pack_halves(c.depth);
    }
    if ((FORM & TEXTURING_COLORS) != 0u) targets[TARGET_COLORS].xy = uvec2(packUnorm2x16(in_color.xy), packUnorm2x16(in_color.zw));
    if ((FORM & TEXTURING_BIND) != 0u) {
        targets[TARGET_BIND] = uvec4(floatBitsToUint(in_bind), pack_halves(vec2(c.bind_dx.z, c.bind_dy.z)));
        targets[TARGET_BIND + 1u].xy = uvec2(pack_halves(c.bind_dx.xy), pack_halves(c.bind_dy.xy));
    }
    out_0 = TARGET_VALUE(0u);
    out_1 = TARGET_VALUE(1u);
    out_2 = TARGET_VALUE(2u);
    out_3 = TARGET_VALUE(3u);
    out_4 = TARGET_VALUE(4u);
    out_5 = TARGET_VALUE(5u);
    out_6 = TARGET_VALUE(6u);
    out_7 = TARGET_VALUE(7u);
}

#ifdef CUTS_HOLES
void main() {
    changes c = find_changes();
    material_array materials = push.geometry.scene.scene.materials;
    if (material_cut(materials, in_ids.x, material_base_color(materials, in_ids.x).a)) discard;
    write_targets(c);
}
#else
layout(early_fragment_tests) in;

void main() { write_targets(find_changes()); }
#endif
