// SPDX-License-Identifier: MIT
// Light that passes through the base: diffuse light (KHR_materials_diffuse_transmission), and, in shaders of transmissive surfaces (TRANSMISSION), all light
// that the base does not reflect (_transmission, _volume, _dispersion).
#ifndef LAYERS_THROUGH_GLSL
#define LAYERS_THROUGH_GLSL

// The part of the light in the base that its own color reflects.
float opaque_part(surface s) {
    float part = 1.0 - s.layers.diffuse_transmission;
#ifdef TRANSMISSION
    part *= 1.0 - s.layers.transmission;
#endif
    return part;
}

// Whether lights behind the surface shine through.
bool lets_through(surface s) { return LIGHTING_LAYERS && s.layered && opaque_part(s) < 1.0; }

#ifdef TRANSMISSION
// Alpha of what is seen through: microfacets of a sheet turn light by twice their tilt, as mirrors do; each face of a plate with an index of refraction n
// turns it by n - 1 times that (refraction at small angles), and the two are independent.
float through_alpha(surface s) {
    return max(alpha_of(s.roughness) * (s.layers.thickness > 0.0 ? clamp((s.layers.ior - 1.0) * 0.7071, 0.0, 1.0) : 1.0), ALPHA_MIN);
}
// The part of the light that is left after `way` meters.
vec3 through_left(surface s, float way) { return exp(-s.layers.absorption * way); }

vec3 through_radiance(surface s, view_block v, vec3 to_view); // what is behind; each shader that draws defines it
#endif

// A light behind the surface: its mirror image in front determines what gets in and where the transmitted lobe lies.
brdf_view behind_view(surface s, layers_view b) {
    brdf_view view = b.base;
#ifdef TRANSMISSION
    surface sheet = s;
    sheet.roughness = sqrt(through_alpha(s));
    view = brdf_prepare(sheet, b.base.to_view);
#endif
    // The back side's geometric normal, mirrored by the shading normal.
    view.geometric = 2.0 * dot(b.base.geometric, s.normal) * s.normal - b.base.geometric;
    return view;
}

vec3 layered_behind_of(surface s, layers_view b, brdf_lobes lobes) {
    vec3 fresnel = mix(s.dielectric_f0 + (vec3(s.dielectric_f90) - s.dielectric_f0) * lobes.m5_below, b.film_dielectric, s.layers.film);
    vec3 through = s.layers.diffuse_transmission_color * (s.layers.diffuse_transmission * (1.0 / PI));
#ifdef TRANSMISSION
    through = mix(through, s.base_color * lobes.specular * through_left(s, s.layers.thickness), s.layers.transmission);
#endif
    float below = LIGHTING_CONSERVING ? b.base.below : 1.0 - max_component(fresnel);
    return through * (below * (1.0 - s.metallic) * b.below_sheen * lobes.n_l);
}

vec3 layered_behind(surface s, layers_view b, vec3 to_light) {
    vec3 image = to_light - 2.0 * dot(s.normal, to_light) * s.normal;
    brdf_lobes lobes;
    if (!brdf_lobes_of(s.normal, behind_view(s, b), image, lobes)) return vec3(0.0);
    return layered_behind_of(s, b, lobes);
}

#endif
