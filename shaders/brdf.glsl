// SPDX-License-Identifier: MIT
// The metallic-roughness BRDF of glTF 2.0, appendix B: whole dielectric and metal lobes are mixed by metalness, Fresnel by
// Schlick, Trowbridge-Reitz distribution, separable Smith visibility. Index of refraction and specular follow KHR_materials_ior and
// KHR_materials_specular. With LIGHTING_CONSERVING, a white surface in uniform light reflects all of it (energy_prepare() of energy.glsl).
#ifndef BRDF_GLSL
#define BRDF_GLSL

#include "lighting/scopes.glsl"
#include "roughness.glsl"
#include "surface.glsl"

// 0: the surface is no metal in any part.
layout(constant_id = HAS_METAL_ID) const uint HAS_METAL = 1u;

// What does not change from light to light.
struct brdf_view {
    vec3 to_view;      // unit, away from the surface
    float alpha2;
    float masking;     // |n.v| + sqrt(alpha2 + (1 - alpha2) (n.v)^2), times pi
    float below;       // fraction of the light that enters the dielectric; only with LIGHTING_CONSERVING
    vec3 between;      // diffuse reflectance of multiple scattering between microfacets; only with LIGHTING_CONSERVING
    vec3 geometric;    // unit geometric normal on the viewer's side; the shading normal if unknown
    float rise;        // 2 / sine of the angle between both normals; scales the cosine in brdf_facing()
};

brdf_view brdf_prepare(surface s, vec3 to_view) {
    brdf_view b;
    precise float alpha = alpha_of(s.roughness);
    precise float alpha2 = alpha * alpha;
    precise float n_v = abs(dot(s.normal, to_view));
    b.to_view = to_view;
    b.alpha2 = alpha2;
    b.masking = PI * (n_v + sqrt(alpha2 + (1.0 - alpha2) * n_v * n_v));
    b.geometric = geometric_unit(s);
    // Shading normals, which stand in for unknown ones, may face away from the viewer.
    if (dot(b.geometric, to_view) < 0.0 && b.geometric != s.normal) b.geometric = -b.geometric;
    precise float lean = dot(b.geometric, s.normal), sine2 = 1.0 - lean * lean;
    b.rise = 2.0 * inversesqrt(max(sine2, 1e-8));
    return b;
}

// What of a light depends on the directions and on the roughness alone: the cosine, the specular lobe without Fresnel, and (1 - v.h)^5.
struct brdf_lobes {
    float n_l;      // cosine of the light; brdf_lobes_of() multiplies it by brdf_facing()
    float specular;
    float m5;
    float m5_below; // the same, for what gets below the surface: another one only for lights of some size (lights/area.glsl)
};

// Factor on a light for the geometric normal: 0 behind the triangle, 1 where both normals agree. Rises smoothly until
// the cosine above the triangle is half the sine of the angle between the normals, so bumps do not end in a hard line.
// Coarse triangles show only near the end of the light; with the factor of Chiang, Li and Burley 2019, "Taming the
// Shadow Terminator", they show in full light too.
float brdf_facing(brdf_view b, vec3 to_light) {
    precise float part = clamp(dot(b.geometric, to_light) * b.rise, 0.0, 1.0);
    precise float facing = part * part * (3.0 - 2.0 * part);
    return facing;
}

// Uses only the shading normal. False for light from behind (NaN too); `to_light` is unit and points away from the
// surface.
bool brdf_lobes_shaded(vec3 normal, brdf_view b, vec3 to_light, out brdf_lobes lobes) {
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

// Like brdf_lobes_shaded(), with `n_l` multiplied by brdf_facing().
bool brdf_lobes_of(vec3 normal, brdf_view b, vec3 to_light, out brdf_lobes lobes) {
    if (!brdf_lobes_shaded(normal, b, to_light, lobes)) return false;
    precise float facing = brdf_facing(b, to_light), n_l = lobes.n_l * facing;
    lobes.n_l = n_l;
    return n_l > 0.0;
}

// The part of a light that gets below the dielectric surface.
float brdf_below(surface s, brdf_view b, brdf_lobes lobes) {
    precise vec3 taken = s.dielectric_f0 + (vec3(s.dielectric_f90) - s.dielectric_f0) * lobes.m5_below;
    precise float below = 1.0 - max_component(taken);
    return LIGHTING_CONSERVING ? b.below : below;
}

// f(l, v) * cos, of a light's lobes.
vec3 brdf_cos_of(surface s, brdf_view b, brdf_lobes lobes) {
    precise vec3 fresnel = s.dielectric_f0 + (vec3(s.dielectric_f90) - s.dielectric_f0) * lobes.m5;
    precise vec3 dielectric = s.base_color * (brdf_below(s, b, lobes) * (1.0 / PI)) + fresnel * lobes.specular;
    precise vec3 result;
    if (HAS_METAL == 0u) { // what the blend below gives for metalness 0
        result = dielectric * lobes.n_l;
    } else {
        precise vec3 metal_fresnel = s.base_color + (1.0 - s.base_color) * lobes.m5;
        precise vec3 metal = metal_fresnel * lobes.specular;
        result = (dielectric + (metal - dielectric) * s.metallic) * lobes.n_l;
    }
    if (LIGHTING_CONSERVING) result += b.between * (lobes.n_l * (1.0 / PI));
    return result;
}

// The same by its direction. Exactly zero for light from behind.
vec3 brdf_cos(surface s, brdf_view b, vec3 to_light) {
    brdf_lobes lobes;
    if (!brdf_lobes_of(s.normal, b, to_light, lobes)) return vec3(0.0);
    return brdf_cos_of(s, b, lobes);
}

// Specular reflectance in uniform light, for the ambient term: f0 times x plus f90 times y. x + y is a fit of the reflectance of a white metal, within 0.02
// except at grazing angles; y is that of Karis 2014, "Physically Based Shading on Mobile".
vec2 environment_brdf(float roughness, float n_v) {
    precise float r = roughness, n = n_v;
    precise float lost = r * r * (1.8003 + n * (-1.9662 + n * (-1.3978 + n * 0.3372)) + r * (-3.8406 + n * (7.0593 + n * 0.6746) + r * (3.0845 - 4.405 * n - 0.6577 * r)));
    precise float all = 1.0 - clamp(lost, 0.0, 1.0), smoothness = 1.0 - r;
    precise float a = min(smoothness * smoothness, exp2(-9.28 * n)) * smoothness + 0.0425 - 0.0275 * r;
    precise float grazing = clamp(1.04 * a + 0.022 * r - 0.04, 0.0, all);
    return vec2(all - grazing, grazing);
}

#endif
