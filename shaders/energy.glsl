// SPDX-License-Identifier: MIT
// Multiple scattering between microfacets, and the light that enters a dielectric. Follows appendix B of glTF 2.0; with LIGHTING_CONSERVING, conserves energy
// (fnl_frame.energy). The same model holds for lights, the environment and probes.
#ifndef ENERGY_GLSL
#define ENERGY_GLSL

#include "brdf.glsl"
#include "environment.glsl"

// Reflectance of a specular lobe in uniform light, by single and by multiple scattering. Multiply scattered light takes the color of the lobe each time and leaves
// as diffuse light (Fdez-Agüera 2019, "A Multiple-Scattering Microfacet Model for Real-Time Image-based Lighting").
struct energy_lobe {
    vec3 once, again;
};

// `reflectance`: from environment_reflectance().
energy_lobe energy_lobe_of(vec3 f0, vec3 f90, vec2 reflectance) {
    precise vec3 once = f0 * reflectance.x + f90 * reflectance.y;
    precise float rest = 1.0 - reflectance.x - reflectance.y;
    precise vec3 mean = f0 + (f90 - f0) * (1.0 / 21.0);
    precise vec3 again = once * mean * rest / (1.0 - mean * rest);
    if (!LIGHTING_CONSERVING) again = vec3(0.0);
    return energy_lobe(once, again);
}

// Fraction of uniform light that enters a dielectric with this lobe. For appendix B, the mean of 1 - F over all directions; `grazing` is a fit of the mean of
// (1 - v.h)^5, within 0.0003.
float energy_below(vec3 f0, vec3 f90, energy_lobe lobe, float n_v) {
    precise float grazing = exp2(-5.1593 - n_v * (3.8194 + 2.4681 * n_v));
    precise vec3 taken = f0 + (f90 - f0) * grazing;
    if (LIGHTING_CONSERVING) taken = lobe.once + lobe.again;
    return 1.0 - max_component(taken);
}

// Sets `below` and `between` with LIGHTING_CONSERVING. f0, f90: dielectric part; metal_f0, metal_f90: metal.
void energy_prepare(surface s, view_block v, float n_v, vec3 f0, vec3 f90, vec3 metal_f0, vec3 metal_f90, inout brdf_view b) {
    if (!LIGHTING_CONSERVING) return;
    vec2 reflectance = environment_reflectance(v, n_v, s.roughness).xy;
    energy_lobe dielectric = energy_lobe_of(f0, f90, reflectance), metal = energy_lobe_of(metal_f0, metal_f90, reflectance);
    b.below = energy_below(f0, f90, dielectric, n_v);
    precise vec3 between = mix(dielectric.again, metal.again, s.metallic);
    b.between = between;
}

// The BRDF of a surface without coats.
brdf_view energy_view(surface s, view_block v, vec3 to_view) {
    brdf_view b = brdf_prepare(s, to_view);
    energy_prepare(s, v, clamp(dot(s.normal, to_view), 0.0, 1.0), s.dielectric_f0, vec3(s.dielectric_f90), s.base_color, vec3(1.0), b);
    return b;
}

#endif
