#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Shows fields of the G-buffer.
#include "common.glsl"
#include "gbuffer.glsl"
#include "passes/shade/gbuffer_view_shared.h"

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform push_block { gpu_gbuffer_view_push push; };

// Colours that differ for all small numbers: steps of the golden angle, in three brightnesses.
vec3 id_color(uint id) {
    vec3 hue = clamp(abs(fract(float(id) * 0.381966 + vec3(0.0, 0.667, 0.333)) * 6.0 - 3.0) - 1.0, 0.0, 1.0);
    return mix(vec3(1.0), hue, 0.75) * (1.0 - 0.25 * float(id % 3u));
}

vec3 seen(uint field, ivec2 pixel) {
    float depth = gbuffer_depth(push.gbuffer, pixel);
    if (depth <= 0.0) return vec3(0.0);
    uint form = gbuffer_form(push.gbuffer);
    vec3 position = gbuffer_position(push.gbuffer.view, pixel, view_depth_of(push.gbuffer.view, depth));
    surface s = gbuffer_surface(push.gbuffer, pixel, position, vec3(0.0));
    gbuffer g = gbuffer_stored(push.gbuffer, pixel, -1);
    switch (field) {
    case GBUFFER_SEEN_NORMAL: return s.normal * 0.5 + 0.5;
    case GBUFFER_SEEN_COLOR: return srgb_encode(clamp(s.base_color, 0.0, 1.0));
    case GBUFFER_SEEN_ROUGHNESS: return vec3(s.roughness);
    case GBUFFER_SEEN_METALLIC: return vec3(s.metallic);
    case GBUFFER_SEEN_OCCLUSION: return vec3(s.occlusion);
    case GBUFFER_SEEN_F0: return sqrt(s.dielectric_f0);
    case GBUFFER_SEEN_F90: return vec3(s.dielectric_f90);
    case GBUFFER_SEEN_MATERIAL: return id_color(gbuffer_unpack_material(form, g));
    case GBUFFER_SEEN_MOTION: return gbuffer_unpack_motion_of(form, g) * 0.5 + 0.5;
    case GBUFFER_SEEN_POSITION: return fract(g.targets[0].xyz);
    case GBUFFER_SEEN_DEPTH: return vec3(1.0 / (1.0 + 0.05 * g.targets[0].z));
    case GBUFFER_SEEN_COAT_NORMAL: return s.layered ? s.layers.clearcoat_normal * 0.5 + 0.5 : vec3(0.0);
    case GBUFFER_SEEN_FORWARD: return vec3(gbuffer_is_forward(push.gbuffer, pixel) ? 1.0 : 0.25);
    }
    return vec3(g.targets[push.from][field - GBUFFER_SEEN_CHANNEL(0u)]);
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = ivec2(push.gbuffer.view.view.size);
    if (any(greaterThanEqual(pixel, size))) return;
    ivec2 at = pixel, middle = (size + 1) / 2;
    uint field = 0u;
    if (push.field_count > 1u) {
        bvec2 far = greaterThanEqual(pixel, middle);
        field = uint(far.x) + 2u * uint(far.y);
        at = min((pixel - middle * ivec2(far)) * 2, size - 1);
    }
    vec3 color = field < push.field_count ? seen(push.fields >> 8u * field & 255u, at) : vec3(0.0);
    imageStore(images[push.target], pixel, push.swap == 1u ? vec4(color.bgr, 1.0) : vec4(color, 1.0));
}
