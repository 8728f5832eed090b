#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Ambient occlusion from depth at a coarse rate: once for blocks that are alike. The estimator is that of McGuire, Mara and Luebke,
// "Scalable Ambient Obscurance" (2012); samples lie on one spiral for all pixels, so that blocks differ by nothing but their place.
#include "common.glsl"
#include "view.glsl"
#include "lights/iterate.glsl"
#include "passes/shade/coarse.glsl"

const uint SAMPLES = 16u;
const float GOLDEN_ANGLE = 2.39996323, LARGEST = 128.0; // radians; pixels

vec3 view_position_at(ivec2 pixel, float depth) {
    view_block v = push.gbuffer.view;
    return view_position_of(v, ndc_of_pixel(v, vec2(pixel) + 0.5), view_depth_of(v, depth));
}

shared uint found; // by the group
uint own_found = 0u;

// 1: nothing is near; 0: closed.
float openness(ivec2 pixel, float depth) {
    own_found++;
    view_block v = push.gbuffer.view;
    float radius = push.settings.settings.ao_radius, radius2 = radius * radius;
    vec3 position = view_position_at(pixel, depth);
    vec3 normal = mat3(v.view.world_to_view) * gbuffer_normal(push.gbuffer, pixel);
    float spread = v.view.orthographic > 0.5 ? 1.0 : -position.z;
    float reach = min(radius * float(v.view.size.y) / max(2.0 * abs(v.view.ndc_scale.y) * spread, 1e-6), LARGEST);
    float sum = 0.0, bias = 0.002 * -position.z + 0.01 * radius;
    for (uint i = 0u; i < SAMPLES; i++) {
        float along = (float(i) + 0.5) / float(SAMPLES), turn = float(i) * GOLDEN_ANGLE;
        ivec2 at = clamp(pixel + ivec2(round(reach * along * vec2(cos(turn), sin(turn)))), ivec2(0), coarse_last());
        float d = gbuffer_depth(push.gbuffer, at);
        vec3 to = view_position_at(at, d) - position;
        float distance2 = dot(to, to), rest = max(radius2 - distance2, 0.0) / radius2;
        if (d > 0.0) sum += rest * rest * rest * max(dot(to, normal) - bias, 0.0) / (distance2 + 0.01 * radius2);
    }
    return clamp(1.0 - 2.0 * radius / float(SAMPLES) * sum, 0.0, 1.0);
}

void main() {
    if (gl_LocalInvocationIndex == 0u) found = 0u;
    barrier();
    coarse_walk walk = coarse_begin();
    for (uint turn = 0u; turn < walk.turns; turn++) {
        ivec2 pixel;
        uint side;
        float depth = 0.0;
        if (coarse_work(walk, turn, pixel, side)) {
            pixel = coarse_standing(pixel, side);
            depth = gbuffer_depth(push.gbuffer, pixel);
        }
        if (depth > 0.0) {
            imageStore(images[push.target], pixel, vec4(openness(pixel, depth))); // of a block that is alike no other pixel is read
        }
    }
    if (own_found > 0u) atomicAdd(found, own_found);
    barrier();
    if (gl_LocalInvocationIndex == 0u && found > 0u) atomicAdd(push.counters.at[COARSE_COUNT_AO], found);
}
