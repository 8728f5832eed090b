#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// The second pass over the geometry: materials meet the light that was summed up.
#include "common.glsl"
#include "material.glsl"
#include "decals_raster.glsl"
#include "gbuffer.glsl"
#include "passes/shade/light_prepass.glsl"
#include "passes/shade/light_samples.glsl"
#include "passes/shade/light_scale.glsl"

layout(constant_id = LIGHT_SCALE_ID) const uint LIGHT_SCALE = 1u;

layout(early_fragment_tests) in;
layout(push_constant, scalar) uniform push_block { gpu_light_material_push push; };

layout(location = 0) out vec4 out_radiance;

uint target_count() { return LIGHT_BUFFER == LIGHT_BUFFER_RGBA ? 1u : LIGHT_BUFFER == LIGHT_BUFFER_TWO || LIGHT_BUFFER == LIGHT_BUFFER_NARROW ? 2u : 4u; }

// A pixel of the surfaces as the light passes see it; false for the sky.
bool surface_at(ivec2 pixel, out light_surface s, out float view_depth) {
    float depth = light_scale_depth(push.surfaces.depth, pixel);
    view_depth = view_depth_of(push.geometry.view, depth);
    s = light_surface_of(push.surfaces, pixel, LIGHT_SCALE_SAMPLE, light_scale_position(push.geometry.view, pixel, view_depth));
    return depth > 0.0;
}

// How well light that was found at another pixel suits this one: both must lie on either's plane, look the same way and shine alike.
float likeness(light_surface a, light_surface b, float allowed) {
    vec3 between = b.position - a.position;
    float off = max(abs(dot(a.normal, between)), abs(dot(b.normal, between)));
    float turned = clamp(dot(a.normal, b.normal), 0.0, 1.0);
    float t2 = turned * turned, t4 = t2 * t2, t8 = t4 * t4;
    return clamp(1.5 - off / allowed, 0.0, 1.0) * t8 * t8 * clamp(1.5 - 8.0 * abs(a.roughness - b.roughness), 0.0, 1.0);
}

// Bilinear between the four samples around, as far as they suit the pixel; where hardly any does, the pixel is lit for itself.
light_sums sums_around(ivec2 pixel, surface s) {
    view_block v = push.geometry.view;
    light_surface own, other;
    float view_depth, unused;
    uvec2 cell = uvec2(pixel);
    if (SAMPLES > 1u) { // the fragment's own surface, wherever in the pixel that is
        vec3 view_position = (v.view.world_to_view * vec4(s.position, 1.0)).xyz;
        own = light_surface_from(s);
        cell = pixel_of(v, view_position);
        view_depth = -view_position.z;
    } else {
        surface_at(pixel, own, view_depth);
    }
    ivec2 size = (ivec2(v.view.size) + int(LIGHT_SCALE) - 1) / int(LIGHT_SCALE);
    vec2 at = vec2(pixel - light_sample_plain(int(LIGHT_SCALE))) / float(LIGHT_SCALE);
    ivec2 base = ivec2(floor(at));
    vec2 part = at - vec2(base);
    float spread = v.view.orthographic > 0.5 ? 1.0 : view_depth;
    float allowed = 2.0 * abs(v.view.ndc_scale.y) * v.view.inverse_size.y * spread * float(LIGHT_SCALE);
    light_sums sums = light_sums_none();
    float suits = 0.0;
    for (int i = 0; i < 4; i++) {
        ivec2 step = ivec2(i & 1, i >> 1), texel = base + step;
        if (any(lessThan(texel, ivec2(0))) || any(greaterThanEqual(texel, size))) continue;
        int inside = int(texelFetch(textures_uint[push.samples], texel, 0).r);
        ivec2 lit = texel * int(LIGHT_SCALE) + ivec2(inside % int(LIGHT_SCALE), inside / int(LIGHT_SCALE));
        if (!surface_at(lit, other, unused)) continue;
        vec2 share = mix(1.0 - part, part, vec2(step));
        float weight = share.x * share.y * likeness(own, other, allowed);
        for (uint k = 0u; k < target_count(); k++) sums.at[k] += weight * texelFetch(textures[push.targets[k]], texel, 0);
        suits += weight;
    }
    if (suits < 0.3) return light_sums_of(own, v, push.geometry.lighting, push.geometry.counters, cell, view_depth);
    for (uint k = 0u; k < target_count(); k++) sums.at[k] /= suits;
    return sums;
}

void main() {
    material_array materials = push.geometry.scene.scene.materials;
    bool hole;
    surface s = material_surface(materials, in_ids.x, hole);
    decals_on_surface(s, push.geometry.view, push.geometry.scene);
    // With several samples a pixel what is left of a cutout at its depth is no hole (forward.frag.glsl).
    if (material_culled(materials, in_ids.x) || SAMPLES <= 1u && hole) discard;
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    light_sums sums = light_sums_none();
    if (LIGHT_SCALE > 1u) {
        sums = sums_around(pixel, s);
    } else if (SAMPLES > 1u) {
        view_block v = push.geometry.view;
        uint word = push.words.at[uint(pixel.y) * v.view.size.x + uint(pixel.x)];
        uint k = light_samples_choose(v, push.surfaces, word, pixel, uint(gl_SampleMaskIn[0]), s);
        for (uint i = 0u; i < target_count(); i++)
            sums.at[i] = texelFetch(textures[nonuniformEXT(push.layers.at[k * LIGHT_BUFFER_TARGETS + i])], pixel, 0);
    } else
        for (uint i = 0u; i < target_count(); i++) sums.at[i] = texelFetch(textures[push.targets[i]], pixel, 0);
    view_block v = push.geometry.view;
    vec3 radiance = shade_rest(s, v, to_viewer(v, s.position), light_sums_reflect(s, v, sums));
    out_radiance = vec4(min(radiance, vec3(v.view.frame.frame.hdr_max)), 1.0);
}
