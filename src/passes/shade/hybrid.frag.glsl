#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Lights what the G-buffer's mask marks from its material, where it is nearest. Hidden fragments are not shaded, and so not counted.
#include "common.glsl"
#include "lights/iterate.glsl"
#define MATERIAL_LAYERS LIGHTING_LAYERS
#include "material.glsl"
#include "decals_raster.glsl"
#include "shade.glsl"
#include "gbuffer.glsl"
#include "passes/shade/hybrid_shared.h"

layout(constant_id = SAMPLES_ID) const uint SAMPLES = 1u;

layout(early_fragment_tests) in;
layout(push_constant, scalar) uniform push_block { gpu_hybrid_push push; };

layout(location = 0) out vec4 out_radiance;

// Those of a pixel's samples where the item is seen.
uint owned_samples(ivec2 pixel) {
    uint owned = 0u;
    for (uint i = 0u; i < SAMPLES; i++)
        if (gbuffer_is_owner(push.gbuffer, pixel, int(i), in_ids.y)) owned |= 1u << i;
    return owned & uint(gl_SampleMaskIn[0]);
}

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    material_array materials = push.geometry.scene.scene.materials;
    surface s = material_surface(materials, in_ids.x);
    if (LIGHTING_MASKS) s.light_mask = item_light_mask(push.geometry.scene, in_ids.y);
    decals_on_surface(s, push.geometry.view, push.geometry.scene);
    uvec2 cell = uvec2(pixel);
    float view_depth;
    if (SAMPLES > 1u) {
        // Lists know no normals then, and the point is that of forward shading: in the middle of what the triangle covers.
        uint owned = owned_samples(pixel);
        if (owned == 0u) discard;
        gl_SampleMask[0] = int(owned);
        vec3 view_position = (push.geometry.view.view.world_to_view * vec4(s.position, 1.0)).xyz;
        cell = pixel_of(push.geometry.view, view_position);
        view_depth = -view_position.z;
    } else {
        // A surface at the same depth, drawn later, may have taken the pixel.
        if (!gbuffer_is_owner(push.gbuffer, pixel, in_ids.y)) discard;
        gl_SampleMask[0] = gl_SampleMaskIn[0];
        // A list may have been made from what the G-buffer says; it then holds for that alone.
        view_depth = view_depth_of(push.geometry.view, gbuffer_depth(push.gbuffer, pixel));
        s.position = gbuffer_position(push.geometry.view, pixel, view_depth);
        s.normal = gbuffer_normal(push.gbuffer, pixel);
    }
    vec3 radiance = shade_surface(s, push.geometry.view, push.geometry.lighting, push.geometry.counters, cell, view_depth, LIGHT_NO_ITEM);
    out_radiance = vec4(min(radiance, vec3(push.geometry.view.view.frame.frame.hdr_max)), 1.0);
}
