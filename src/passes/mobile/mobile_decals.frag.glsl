#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// A step between geometry and lights: reads a pixel's targets, lets the decals that hold its point change the surface, and rewrites what
// they changed; the rest keeps its bits. The light, which has ambient light and glow in it, gains what the new surface has more of those.
#include "common.glsl"
#include "shade.glsl"
#include "decals.glsl"
#define MOBILE_READS 2
#include "passes/mobile/mobile.glsl"

layout(push_constant, scalar) uniform push_block { gpu_mobile_push push; };

layout(location = 0) out vec4 out_0;
layout(location = 1) out vec4 out_1;
layout(location = 2) out vec4 out_2;
layout(location = 3) out vec4 out_3;
#if MOBILE_TARGETS > 4
layout(location = 4) out vec4 out_4;
#endif
#ifdef MOBILE_WIDE
layout(location = 5) out vec4 out_5;
#endif

// From a surface to where its plane is seen at the middle of another pixel: gradients that no silhouette disturbs. At most some pixels.
vec3 step_on_plane(surface s, vec2 pixel, float view_depth) {
    view_block v = push.view;
    vec3 near = (v.view.view_to_world * vec4(view_position_of(v, ndc_of_pixel(v, pixel), 1.0), 1.0)).xyz;
    bool parallel = v.view.orthographic > 0.5;
    vec3 ray = parallel ? -v.view.back : near - v.view.eye, from = parallel ? near : v.view.eye;
    float slope = dot(s.normal, ray);
    if (abs(slope) < 1e-4) slope = slope < 0.0 ? -1e-4 : 1e-4;
    vec3 way = from + ray * (dot(s.normal, s.position - from) / slope) - s.position;
    float widest = 256.0 * max(abs(v.view.ndc_scale.x) * v.view.inverse_size.x, abs(v.view.ndc_scale.y) * v.view.inverse_size.y) *
                   (parallel ? 1.0 : view_depth);
    float length2 = dot(way, way);
    return length2 > widest * widest ? way * (widest * inversesqrt(length2)) : way;
}

void main() {
    mobile_texel g;
    MOBILE_LOAD_ALL(g)
    if (!mobile_is_sky(g)) {
        ivec2 pixel = ivec2(gl_FragCoord.xy);
        float view_depth;
        surface s = mobile_surface(g, push.view, pixel, view_depth);
        s.occlusion = 1.0;
        surface before = s;
        decal_point p;
        p.position = s.position;
        p.dx = step_on_plane(s, vec2(pixel) + vec2(1.5, 0.5), view_depth);
        p.dy = step_on_plane(s, vec2(pixel) + vec2(0.5, 1.5), view_depth);
        p.facing = dot(s.normal, to_viewer(push.view, s.position)) < 0.0 ? -s.normal : s.normal;
        p.receivers = 255u;
        decals_apply(s, decals_of(push.view), uvec2(pixel), view_depth, p);
        vec3 to_view = to_viewer(push.view, s.position), light = mobile_light(g);
        bool bent = s.normal != before.normal, rough = s.roughness != before.roughness, tinted = s.base_color != before.base_color;
        bool metal = s.metallic != before.metallic || s.dielectric_f0 != before.dielectric_f0;
        bool was_black = before.dielectric_f90 == 0.0; // for which metalness stands in
        if (bent || rough || tinted || metal || s.emissive != before.emissive) {
            vec3 more = shade_rest(s, push.view, to_view, vec3(0.0)) - shade_rest(before, push.view, to_view, vec3(0.0));
            light = clamp(light + more * push.view.view.frame.frame.light_scale, vec3(0.0), vec3(push.view.view.frame.frame.light_max));
        }
        mobile_texel n = mobile_pack(s, g.t[1].x, light);
        mobile_mark(g, mobile_leans(g) || dot(s.normal, before.normal) < MOBILE_SAME);
        // What is read and written again may lose its last bit: normals are made unit vectors in between.
#ifdef MOBILE_WIDE
        g.t[3] = n.t[3];
#ifdef MOBILE_METALLIC
        g.t[4] = vec4(n.t[4].x, bent ? n.t[4].y : g.t[4].y, 0.0, 0.0);
        if (bent) g.t[5] = n.t[5];
        g.t[6] = vec4(rough ? n.t[6].x : g.t[6].x, metal || was_black ? n.t[6].y : g.t[6].y, 0.0, 0.0);
        if (tinted) g.t[7] = n.t[7];
#else
        g.t[4] = vec4(n.t[4].x, rough ? n.t[4].y : g.t[4].y, 0.0, 0.0);
        if (bent) g.t[5] = n.t[5];
        if (tinted || metal) g.t[6] = n.t[6];
        if (tinted || metal) g.t[7] = n.t[7];
#endif
#else
        g.t[0] = n.t[0];
        g.t[2] = vec4(bent ? n.t[2].xyz : g.t[2].xyz, rough ? n.t[2].w : g.t[2].w);
#if MOBILE_TARGETS > 4
        if (tinted || metal) g.t[3] = n.t[3];
        if (tinted || metal) g.t[4] = n.t[4];
#else
        g.t[3] = vec4(tinted ? n.t[3].rgb : g.t[3].rgb, metal || was_black ? n.t[3].a : g.t[3].a);
#endif
#endif
    }
    out_0 = g.t[0];
#ifdef MOBILE_WIDE
    out_1 = g.t[3];
    out_2 = g.t[4];
    out_3 = g.t[5];
    out_4 = g.t[6];
    out_5 = g.t[7];
#else
    out_1 = g.t[1];
    out_2 = g.t[2];
    out_3 = g.t[3];
#if MOBILE_TARGETS > 4
    out_4 = g.t[4];
#endif
#endif
}
