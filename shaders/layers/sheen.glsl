// SPDX-License-Identifier: MIT
// Fibers over the base (KHR_materials_sheen).
#ifndef LAYERS_SHEEN_GLSL
#define LAYERS_SHEEN_GLSL

#include "layers/sheen_lobe.glsl"

// The part of the light that gets below the fibers.
float sheen_below(surface s, view_block v, float n_v) {
    return 1.0 - max_component(s.layers.sheen_color) * environment_sheen(v, n_v, s.layers.sheen_roughness);
}

// f(l, v). `n_l`: the cosine of `to_light`.
vec3 sheen_brdf(surface s, vec3 to_view, vec3 to_light, float n_l, float n_v) {
    float n_h = clamp(dot(s.normal, normalize(to_light + to_view)), 0.0, 1.0);
    return s.layers.sheen_color * sheen_lobe(s.layers.sheen_roughness, n_l, n_v, n_h);
}

#endif
