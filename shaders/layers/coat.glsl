// SPDX-License-Identifier: MIT
// Varnish over all other layers (KHR_materials_clearcoat), with an index of refraction of 1.5.
#ifndef LAYERS_COAT_GLSL
#define LAYERS_COAT_GLSL

const vec3 COAT_F0 = vec3(0.04);

brdf_view coat_view(surface s, vec3 to_view) {
    surface coat;
    coat.normal = s.layers.clearcoat_normal;
    coat.geometric = s.geometric;
    coat.roughness = s.layers.clearcoat_roughness;
    return brdf_prepare(coat, to_view);
}

// The part of the light that gets below the coat.
float coat_below(surface s, view_block v, vec3 to_view) {
    vec3 albedo = environment_reflectance(v, clamp(dot(s.layers.clearcoat_normal, to_view), 0.0, 1.0), s.layers.clearcoat_roughness).xyz;
    return 1.0 - s.layers.clearcoat * (COAT_F0.x * albedo.x + albedo.y);
}

// f(l, v) times the cosine.
vec3 coat_cos(surface s, brdf_lobes lobes) {
    return s.layers.clearcoat * (COAT_F0 + (1.0 - COAT_F0) * lobes.m5) * (lobes.specular * lobes.n_l);
}

#endif
