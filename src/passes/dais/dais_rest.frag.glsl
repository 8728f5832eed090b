#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Forward shading of samples for which a pool had no room.
layout(early_fragment_tests) in;
#include "common.glsl"
#include "material.glsl"
#include "decals_raster.glsl"
#include "shade.glsl"
#include "passes/dais/dais_pixel.glsl"

layout(push_constant, scalar) uniform push_block { gpu_dais_rest_push push; };

layout(location = 0) out vec4 out_radiance;

void main() {
    uvec2 size = push.geometry.view.view.size;
    material_array materials = push.geometry.scene.scene.materials;
    surface s = material_surface(materials, in_ids.x);
    decals_on_surface(s, push.geometry.view, push.geometry.scene);
    dais_source from = dais_source(push.pool, push.heads, push.nodes, push.references, 0u, size);
    uint mask = rest_samples(dais_read(from, ivec2(min(uvec2(gl_FragCoord.xy), size - 1u))));
    if (mask == 0u) discard;
    vec3 view_position = (push.geometry.view.view.world_to_view * vec4(s.position, 1.0)).xyz;
    uvec2 pixel = SAMPLES > 1u ? pixel_of(push.geometry.view, view_position) : uvec2(gl_FragCoord.xy);
    vec3 radiance = shade_surface(s, push.geometry.view, push.geometry.lights, push.geometry.counters, pixel, -view_position.z, in_ids.y);
    out_radiance = vec4(min(radiance, vec3(push.geometry.view.view.frame.frame.hdr_max)), 1.0);
    gl_SampleMask[0] = int(mask);
}
