#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Applies a pixel's decals to what a copy of the G-buffer holds, and packs it anew.
#include "common.glsl"
#include "decals.glsl"
#include "gbuffer.glsl"
#include "passes/decals/decals_pass_shared.h"
#include "passes/decals/receivers.glsl"

layout(constant_id = 1) const uint EMITS = 0u; // the first attachment is the radiance target

layout(push_constant, scalar) uniform push_block { gpu_decals_merge_push push; };

layout(location = 0) out vec4 out_0;
layout(location = 1) out vec4 out_1;
layout(location = 2) out vec4 out_2;
layout(location = 3) out vec4 out_3;
layout(location = 4) out vec4 out_4;
layout(location = 5) out vec4 out_5;

// From a surface to where the plane of its face is seen at another pixel: gradients that no silhouette disturbs.
vec3 step_on_plane(view_block v, vec3 view_position, vec3 view_face, vec2 pixel) {
    vec2 along = ndc_of_pixel(v, pixel) * v.view.ndc_scale + v.view.ndc_offset;
    vec3 to;
    if (v.view.orthographic > 0.5) {
        float steep = abs(view_face.z) > 1e-3 ? view_face.z : 1e-3;
        to = vec3(along, view_position.z - dot(view_face.xy, along - view_position.xy) / steep);
    } else {
        vec3 ray = vec3(along, -1.0);
        float slope = dot(view_face, ray);
        if (abs(slope) < 1e-4) slope = slope < 0.0 ? -1e-4 : 1e-4;
        to = ray * (dot(view_face, view_position) / slope);
    }
    vec3 way = to - view_position;
    // Seen edge-on the plane runs away; there is no more to be lost than the smallest mip.
    float footprint = 256.0 * max(abs(v.view.ndc_scale.x) * v.view.inverse_size.x, abs(v.view.ndc_scale.y) * v.view.inverse_size.y) *
                      (v.view.orthographic > 0.5 ? 1.0 : -view_position.z);
    float length2 = dot(way, way);
    return length2 > footprint * footprint ? way * (footprint * inversesqrt(length2)) : way;
}

void main() {
    view_block v = push.gbuffer.view;
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    uint tile = uint(pixel.y) / DECAL_TILE * push.tiles_x + uint(pixel.x) / DECAL_TILE;
    float depth = gbuffer_depth(push.gbuffer, pixel), view_depth = view_depth_of(v, max(depth, 1e-30));
    decal_point p;
    p.position = gbuffer_position(v, pixel, view_depth);
    p.dx = dFdx(p.position);
    p.dy = dFdy(p.position);
    uint first = push.sums.at[tile], end = push.sums.at[tile + 1u];
    if (depth <= 0.0 || first == end) discard;

    uvec2 packed = texelFetch(textures_uint[push.receivers], pixel, 0).xy;
    p.receivers = receivers_bits(packed);
    p.facing = receivers_normal(packed);
    if (push.mip_fix == 1u) {
        mat3 to_world = mat3(v.view.view_to_world);
        vec3 view_face = receivers_face(packed) * to_world; // the inverse of a rotation
        vec3 view_position = (v.view.world_to_view * vec4(p.position, 1.0)).xyz;
        p.dx = to_world * step_on_plane(v, view_position, view_face, vec2(pixel) + vec2(1.5, 0.5));
        p.dy = to_world * step_on_plane(v, view_position, view_face, vec2(pixel) + vec2(0.5, 1.5));
    }

    uint form = gbuffer_form(push.gbuffer);
    vec3 emissive = EMITS == 1u ? texelFetch(textures[push.radiance], pixel, 0).rgb : vec3(0.0);
    surface s = gbuffer_surface(push.gbuffer, pixel, p.position, emissive);
    bool any = false;
    if (end > push.capacity) {
        uint count = push.set.set.count;
        for (uint i = 0u; i < count; i++) any = decal_at_point(s, push.set, i, p) || any;
        atomicAdd(push.totals.at[1], 1u);
    } else {
        uint last = 0xffffffffu;
        for (uint i = first; i < end; i++) {
            uint id = push.entries.at[i];
            if (id != last) any = decal_at_point(s, push.set, id, p) || any;
            last = id;
        }
    }
    if (!any) discard; // keeps its bits

    uint id = 0u;
    gpu_material_entry entry;
    if (gbuffer_has_id(form)) {
        id = gbuffer_material(push.gbuffer, pixel);
        entry = push.gbuffer.entries.at[id];
    }
    gbuffer g = gbuffer_pack(form, s, gbuffer_place_at(v, p.position), id, entry, vec3(0.0), pixel);
    if (EMITS == 1u) {
        out_0 = vec4(min(s.emissive, vec3(v.view.frame.frame.hdr_max)), 1.0);
        out_1 = g.targets[0];
        out_2 = g.targets[1];
        out_3 = g.targets[2];
        out_4 = g.targets[3];
        out_5 = g.targets[4];
    } else {
        out_0 = g.targets[0];
        out_1 = g.targets[1];
        out_2 = g.targets[2];
        out_3 = g.targets[3];
        out_4 = g.targets[4];
    }
}
