#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// A layer of surfaces that show what is behind them. Where its light comes from is found in the picture so far: a sheet is looked straight through, a
// volume at the point where the refracted ray leaves it, `thickness` farther on (the model of KHR_materials_volume for rasterisers). Rough surfaces
// take several directions of their lobe, each from the mip that is as coarse as the gaps between them at the distance of what is behind, so that
// frosted glass shows what touches it sharply and blurs what is far.
#define TRANSMISSION
#include "passes/shade/forward.glsl"
#include "passes/transmission/transmission_shared.h"

layout(early_fragment_tests) in;
layout(push_constant, scalar) uniform push_block { gpu_transmission_push push; };
layout(location = 0) out vec4 out_color;

vec4 behind_at(vec2 uv, float lod) { return textureLod(sampler2D(textures[push.behind], samplers[push.geometry.view.view.frame.frame.environment_sampler]), uv, lod); }

// Where a point of the world is seen; false behind the viewer.
bool screen_of(view_block v, vec3 position, out vec2 uv) {
    vec4 clip = v.view.world_to_clip * vec4(position, 1.0);
    uv = vec2(clip.x, -clip.y) / clip.w * 0.5 + 0.5;
    return clip.w > 0.0;
}

// The way through a volume, or none.
vec3 way_through(surface s, vec3 to_view, float ior) {
    if (!(s.layers.thickness > 0.0)) return vec3(0.0);
    vec3 inside = refract(-to_view, s.normal, 1.0 / ior);
    return inside * s.layers.thickness;
}

// What is seen along the ray from the viewer through `leaves`, blurred by the surface.
vec3 seen_behind(surface s, view_block v, vec3 to_view, vec3 leaves) {
    vec2 uv;
    if (!screen_of(v, leaves, uv)) return vec3(0.0);
    float alpha = through_alpha(s);
    if (alpha <= 2.0 * ALPHA_MIN) return behind_at(uv, 0.0).rgb;
    vec3 ahead = -to_viewer(v, leaves);
    // How far what is behind is: a guess by what is straight behind, then the mean over what the lobe covers.
    float own_depth = -(v.view.world_to_view * vec4(leaves, 1.0)).z, away = 0.0, lod = 0.0; // along the view axis
    for (int i = 0; i < 2; i++) {
        float depth = 1.0 / max(behind_at(uv, lod).a, 1e-5);
        away = max(depth - own_depth, 0.0);
        lod = clamp(log2(max(2.0 * alpha * away / pixel_width(v, depth), 1e-6)), 0.0, push.last_mip);
    }
    // Half vectors of the lobe, evenly by its distribution: what is mirrored by them is turned to the other side.
    const float COUNT = 16.0, TURN = 2.39996323;
    vec3 side = normalize(abs(s.normal.y) < 0.9 ? cross(s.normal, vec3(0.0, 1.0, 0.0)) : cross(s.normal, vec3(1.0, 0.0, 0.0))), up = cross(s.normal, side);
    vec3 viewer = -ahead, sum = vec3(0.0);
    float n_v = dot(s.normal, viewer), weights = 0.0;
    vec3 straight = viewer;
    if (n_v < 1e-3) straight = normalize(viewer + s.normal * (1e-3 - n_v)); // bumps may lean away from the viewer
    for (float i = 0.5; i < COUNT; i += 1.0) {
        float u = i / COUNT, slope = alpha * sqrt(u / (1.0 - u)), angle = i * TURN;
        vec3 h = normalize(s.normal + slope * (cos(angle) * side + sin(angle) * up));
        float v_h = dot(straight, h);
        vec3 l = reflect(-straight, h);
        float n_l = dot(s.normal, l);
        if (v_h <= 0.0 || n_l <= 0.0) continue;
        l -= 2.0 * n_l * s.normal; // through
        vec2 at;
        float way = away / max(-dot(v.view.back, l), 0.1);
        vec3 point = leaves + l * way;
        // As much as the viewer sees of them (their slopes are chosen by what lies flat), and as others leave open of their light.
        float weight = v_h / dot(s.normal, h) * n_l / (n_l + sqrt(alpha * alpha + (1.0 - alpha * alpha) * n_l * n_l));
        if (!screen_of(v, point, at)) continue;
        float n_h = dot(s.normal, h), d = n_h * n_h * (alpha * alpha - 1.0) + 1.0, density = alpha * alpha * n_h / (PI * d * d) / (4.0 * v_h);
        float depth = -(v.view.world_to_view * vec4(point, 1.0)).z, wide = way * inversesqrt(COUNT * density) / pixel_width(v, max(depth, 1e-6));
        sum += weight * behind_at(at, clamp(log2(max(wide, 1e-6)), 0.0, push.last_mip)).rgb;
        weights += weight;
    }
    return weights > 0.0 ? sum / weights : vec3(0.0);
}

vec3 through_radiance(surface s, view_block v, vec3 to_view) {
    vec3 way = way_through(s, to_view, s.layers.ior), left = through_left(s, length(way));
    if (s.layers.dispersion <= 0.0 || !(s.layers.thickness > 0.0)) return left * seen_behind(s, v, to_view, s.position + way);
    // Red is refracted least: the indices at both ends of the spectrum are half their spread from the middle (KHR_materials_dispersion).
    float spread = (s.layers.ior - 1.0) * 0.025 * s.layers.dispersion;
    vec3 sum;
    for (int c = 0; c < 3; c++) {
        float ior = max(s.layers.ior + spread * float(c - 1), 1.0);
        sum[c] = seen_behind(s, v, to_view, s.position + way_through(s, to_view, ior))[c];
    }
    return left * sum;
}

void main() {
    float view_depth;
    vec4 color = forward_shade(push.geometry, view_depth);
    if (color.a < 1.0) { // coverage besides: what is behind shows as it is
        vec2 uv;
        screen_of(push.geometry.view, in_position, uv);
        color.rgb += (1.0 - color.a) * behind_at(uv, 0.0).rgb;
    }
    out_color = vec4(color.rgb, 1.0);
}
