#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// One light at a time, added up in the target: the terms of shade_surface(), in its order, so that float targets hold the very sum.
#include "passes/shade/regroup.glsl"

layout(constant_id = MULTIPASS_STEP_ID) const uint STEP = MULTIPASS_LIGHT;

layout(location = 0) out vec4 out_radiance;

void main() {
    material_array materials = push.geometry.scene.scene.materials;
    bool hole;
    surface s = material_surface(materials, in_ids.x, hole);
    if (LIGHTING_MASKS) s.light_mask = item_light_mask(push.geometry.scene, in_ids.y);
    decals_on_surface(s, push.geometry.view, push.geometry.scene);
    if (!is_shown(materials, hole)) discard;
    view_block v = push.geometry.view;
    lighting_block l = push.geometry.lighting;
    vec3 to_view = to_viewer(v, s.position);
    if (STEP == MULTIPASS_REST) {
        vec3 sum = texelFetch(textures[push.sum], ivec2(gl_FragCoord.xy), 0).rgb;
        vec3 radiance = shade_rest(s, v, to_view, sum);
        out_radiance = vec4(min(radiance, vec3(v.view.frame.frame.hdr_max)) * s.alpha, s.alpha);
        return;
    }
    layers_view b = layers_prepare(s, v, to_view);
    vec3 sum;
    shadowed_point shadowed = shadowed_point_of(l, s.position, facing_normal(s));
    if (STEP == MULTIPASS_DIRECTIONAL) {
        sum = suns_at(l, s, b, shadowed);
    } else {
        bool reaches;
        sum = light_at(l, push.light, s, b, shadowed, reaches);
        if (COUNT_LIGHTS == 1u) {
            uint at = (uint(gl_FragCoord.y) * v.view.size.x + uint(gl_FragCoord.x)) * 2u;
            atomicAdd(push.geometry.counters.at[at], 1u);
            atomicAdd(push.geometry.counters.at[at + 1u], reaches ? 1u : 0u);
        }
    }
    count_shadows(v, push.geometry.counters);
    out_radiance = vec4(sum, 0.0);
}
