#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Forward shading of items whose number of lights is known: FIXED_LIGHTS (iterate.glsl) unrolls the loop.
#include "passes/shade/regroup.glsl"

layout(location = 0) out vec4 out_radiance;

void main() {
    material_array materials = push.geometry.scene.scene.materials;
    bool hole;
    surface s = material_surface(materials, in_ids.x, hole);
    if (LIGHTING_MASKS) s.light_mask = item_light_mask(push.geometry.scene, in_ids.y);
    decals_on_surface(s, push.geometry.view, push.geometry.scene);
    if (!is_shown(materials, hole)) discard;
    vec3 radiance = shade_surface(s, push.geometry.view, push.geometry.lighting, push.geometry.counters, uvec2(gl_FragCoord.xy),
                                  view_depth_at(s.position), in_ids.y);
    out_radiance = vec4(min(radiance, vec3(push.geometry.view.view.frame.frame.hdr_max)) * s.alpha, s.alpha);
}
