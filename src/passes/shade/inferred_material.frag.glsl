#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Materials at full resolution: light comes from the texels around that belong to the same item and lie on the same surface (the
// discontinuity-sensitive filter). Blended surfaces look at the texels of their own place in the stipple pattern.
#include "common.glsl"
#include "material.glsl"
#include "decals_raster.glsl"
#include "gbuffer.glsl"
#include "passes/shade/light_prepass.glsl"
#include "passes/shade/inferred_shared.h"

layout(constant_id = SAMPLES_ID) const uint SAMPLES = 1u;
layout(constant_id = STIPPLED_ID) const uint STIPPLED = 0u;

layout(early_fragment_tests) in;
layout(push_constant, scalar) uniform push_block { gpu_inferred_material_push push; };

layout(location = 0) out vec4 out_radiance;

const uint TARGETS = LIGHT_BUFFER == LIGHT_BUFFER_RGBA ? 1u : 4u;

// How well the light of a texel suits the surface; 0 where it must be of the same item and is not.
float likeness(light_surface own, ivec2 texel, bool of_item, float allowed) {
    float depth = texelFetch(textures[push.surfaces.depth], texel, 0).r;
    if (depth <= 0.0 || of_item && texelFetch(textures_uint[push.items], texel, 0).r != in_ids.y + 1u) return 0.0;
    light_surface other = light_surface_of(push.surfaces, texel, gbuffer_position(push.low, texel, view_depth_of(push.low, depth)));
    vec3 between = other.position - own.position;
    float off = max(abs(dot(own.normal, between)), abs(dot(other.normal, between)));
    float turned = clamp(dot(own.normal, other.normal), 0.0, 1.0), t2 = turned * turned, t4 = t2 * t2;
    return clamp(1.5 - off / allowed, 0.0, 1.0) * t4 * t4 * t4 * t4;
}

void main() {
    material_array materials = push.geometry.scene.scene.materials;
    bool hole;
    surface s = material_surface(materials, in_ids.x, hole);
    decals_on_surface(s, push.geometry.view, push.geometry.scene);
    // With several samples a pixel what is left of a cutout at its depth is no hole (forward.frag.glsl).
    if (material_culled(materials, in_ids.x) || SAMPLES <= 1u && hole) discard;
    view_block v = push.geometry.view, low = push.low;
    ivec2 size = ivec2(low.view.size);
    light_surface own;
    own.position = s.position;
    own.normal = s.normal;
    own.geometric = s.geometric;
    own.roughness = s.roughness;
    float view_depth = -(v.view.world_to_view * vec4(s.position, 1.0)).z;
    float spread = v.view.orthographic > 0.5 ? 1.0 : view_depth;
    int step = STIPPLED == 1u ? 2 : 1;
    ivec2 origin = ivec2(0);
    if (STIPPLED == 1u) origin = ivec2(INFERRED_PLACE(in_ids.y) & 1u, INFERRED_PLACE(in_ids.y) >> 1);
    float allowed = 2.0 * abs(low.view.ndc_scale.y) * low.view.inverse_size.y * spread * float(step);
    // Among the texels of the pattern; those of the item around the pixel; where none suits, those around these too, of
    // whatever lies on the same surface.
    vec2 at = (gl_FragCoord.xy * v.view.inverse_size * vec2(size) - 0.5 - vec2(origin)) / float(step);
    ivec2 base = ivec2(floor(at));
    vec2 part = at - vec2(base);
    light_sums sums = light_sums_none();
    float suits = 0.0;
    for (int ring = 0; ring < 2 && suits < 0.3; ring++)
        for (int y = -ring; y < 2 + ring; y++)
            for (int x = -ring; x < 2 + ring; x++) {
                ivec2 texel = (base + ivec2(x, y)) * step + origin;
                if (any(lessThan(texel, ivec2(0))) || any(greaterThanEqual(texel, size))) continue;
                vec2 share = ring == 0 ? mix(1.0 - part, part, vec2(x, y)) + 0.01 : 1.0 / (1.0 + abs(vec2(x, y) - part));
                float weight = share.x * share.y * likeness(own, texel, ring == 0, allowed);
                if (weight <= 0.0) continue;
                for (uint k = 0u; k < TARGETS; k++) sums.at[k] += weight * texelFetch(textures[push.targets[k]], texel, 0);
                suits += weight;
            }
    if (suits < 0.3) { // too thin for any texel, or hidden behind another of its pattern: all lights
        ivec2 pixel = ivec2(gl_FragCoord.xy);
        sums = light_sums_of(own, v, push.geometry.lighting, push.geometry.counters, uvec2(pixel), view_depth);
    } else {
        for (uint k = 0u; k < TARGETS; k++) sums.at[k] /= suits;
    }
    vec3 radiance = shade_rest(s, v, to_viewer(v, s.position), light_sums_reflect(s, v, sums));
    out_radiance = vec4(min(radiance, vec3(v.view.frame.frame.hdr_max)) * s.alpha, s.alpha);
}
