// SPDX-License-Identifier: MIT
// The metallic-roughness BRDF of glTF 2.0, appendix B: whole dielectric and metal lobes are mixed by metalness, Fresnel by
// Schlick, Trowbridge-Reitz distribution, separable Smith visibility. Index of refraction and specular follow KHR_materials_ior and
// KHR_materials_specular.
#ifndef BRDF_GLSL
#define BRDF_GLSL

#include "surface.glsl"

// 0: the surface is no metal in any part.
layout(constant_id = HAS_METAL_ID) const uint HAS_METAL = 1u;

// Smallest squared roughness: a perfect mirror would show a point light nowhere.
const float ALPHA_MIN = 1e-3;

float alpha_of(float roughness) { return max(roughness * roughness, ALPHA_MIN); }

// What does not change from light to light.
struct brdf_view {
    vec3 to_view;      // unit, away from the surface
    float alpha2;
    float masking;     // |n.v| + sqrt(alpha2 + (1 - alpha2) (n.v)^2), times pi
};

brdf_view brdf_prepare(surface s, vec3 to_view) {
    brdf_view b;
    precise float alpha = alpha_of(s.roughness);
    precise float alpha2 = alpha * alpha;
    precise float n_v = abs(dot(s.normal, to_view));
    b.to_view = to_view;
    b.alpha2 = alpha2;
    b.masking = PI * (n_v + sqrt(alpha2 + (1.0 - alpha2) * n_v * n_v));
    return b;
}

// What of a light depends on the directions and on the roughness alone: the cosine, the specular lobe without Fresnel, and (1 - v.h)^5.
struct brdf_lobes {
    float n_l;
    float specular;
    float m5;
    float m5_below; // the same, for what gets below the surface: another one only for lights of some size (lights/area.glsl)
};

// False for light from behind (NaN too); `to_light` is unit and points away from the surface.
bool brdf_lobes_of(vec3 normal, brdf_view b, vec3 to_light, out brdf_lobes lobes) {
    precise float n_l = dot(normal, to_light);
    lobes = brdf_lobes(0.0, 0.0, 0.0, 0.0);
    if (!(n_l > 0.0)) return false;
    precise vec3 sum = to_light + b.to_view;
    precise vec3 half_vector = sum * inversesqrt(max(dot(sum, sum), 1e-20));
    precise float n_h = dot(normal, half_vector);
    precise float v_h = clamp(dot(b.to_view, half_vector), 0.0, 1.0);

    // Distribution alpha2 / (pi d^2), d = n_h^2 (alpha2 - 1) + 1, which loses all digits near n_h = 1; |n x h|^2 keeps them. Visibility
    // 1 / ((n_l + ...) (n_v + ...)).
    precise vec3 n_x_h = cross(normal, half_vector);
    precise float d = b.alpha2 * n_h * n_h + dot(n_x_h, n_x_h);
    precise float shadowing = n_l + sqrt(b.alpha2 + (1.0 - b.alpha2) * n_l * n_l);
    precise float specular = n_h > 0.0 ? b.alpha2 / (d * d * shadowing * b.masking) : 0.0;

    precise float m = 1.0 - v_h;
    precise float m2 = m * m;
    precise float m5 = m2 * m2 * m;
    lobes = brdf_lobes(n_l, specular, m5, m5);
    return true;
}

// f(l, v) * cos, of a light's lobes.
vec3 brdf_cos_of(surface s, brdf_lobes lobes) {
    precise vec3 fresnel = s.dielectric_f0 + (vec3(s.dielectric_f90) - s.dielectric_f0) * lobes.m5;
    precise vec3 taken = s.dielectric_f0 + (vec3(s.dielectric_f90) - s.dielectric_f0) * lobes.m5_below;
    if (HAS_METAL == 0u) { // what the blend below gives for metalness 0
        precise vec3 plain = (s.base_color * ((1.0 - max_component(taken)) * (1.0 / PI)) + fresnel * lobes.specular) * lobes.n_l;
        return plain;
    }
    precise vec3 metal_fresnel = s.base_color + (1.0 - s.base_color) * lobes.m5;
    precise vec3 dielectric = s.base_color * ((1.0 - max_component(taken)) * (1.0 / PI)) + fresnel * lobes.specular;
    precise vec3 metal = metal_fresnel * lobes.specular;
    precise vec3 result = (dielectric + (metal - dielectric) * s.metallic) * lobes.n_l;
    return result;
}

// The same by its direction. Exactly zero for light from behind.
vec3 brdf_cos(surface s, brdf_view b, vec3 to_light) {
    brdf_lobes lobes;
    if (!brdf_lobes_of(s.normal, b, to_light, lobes)) return vec3(0.0);
    return brdf_cos_of(s, lobes);
}

// Reflection of light from all around, for the ambient term: analytic fit of the split-sum integral (Karis 2014,
// "Physically Based Shading on Mobile").
vec2 environment_brdf(float roughness, float n_v) {
    precise vec4 r = roughness * vec4(-1.0, -0.0275, -0.572, 0.022) + vec4(1.0, 0.0425, 1.04, -0.04);
    precise float a = min(r.x * r.x, exp2(-9.28 * n_v)) * r.x + r.y;
    precise vec2 fit = max(vec2(-1.04, 1.04) * a + r.zw, vec2(0.0)); // it goes below zero for rough surfaces
    return vec2(fit.x, min(fit.y, 1.0 - fit.x));             // and above one for smooth ones at grazing angles
}

#endif
