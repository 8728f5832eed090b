// SPDX-License-Identifier: MIT
// Materials with layers: the order in which light passes through them. From the top: a varnish (layers/coat.glsl), fibers (sheen.glsl), and the
// metallic-roughness base of brdf.glsl. Highlights of the base may be stretched (stretched.glsl) and colored by a thin film (film.glsl), and the base may let
// light through (through.glsl). The part of light from all around that a layer reflects, its albedo, does not get below the layer. Albedos come from the table
// that environments use (environment.glsl), so a white material in even light reflects all of it, with any layers.
#ifndef LAYERS_GLSL
#define LAYERS_GLSL

#include "energy.glsl"

// What does not change from light to light; only `base` where the surface has no layers.
struct layers_view {
    brdf_view base, coat;
    vec3 bitangent;
    vec2 alpha_along;   // of anisotropic highlights: along the tangent and the bitangent
    float below_coat, below_sheen; // the parts of the light that get there
    float n_v;
    vec3 film_dielectric, film_metal; // reflectance with the film
};

#include "layers/coat.glsl"
#include "layers/film.glsl"
#include "layers/sheen.glsl"
#include "layers/stretched.glsl"
#include "layers/through.glsl"

// The normal that says which light comes from behind: with a coat its own, which is nearer to the triangle's.
vec3 facing_normal(surface s) { return LIGHTING_LAYERS && s.layered && s.layers.clearcoat > 0.0 ? s.layers.clearcoat_normal : s.normal; }

// By which side of the surface shadows of a light are looked for.
vec3 lit_normal(surface s, vec3 to_light) {
    vec3 normal = facing_normal(s);
    return lets_through(s) && dot(normal, to_light) < 0.0 ? -normal : normal;
}

// Reflectances of the dielectric part and of the metal, along the normal and at grazing angles. The film's reflectance serves as both f0 and f90.
void filmed(surface s, layers_view b, out vec3 f0, out vec3 f90, out vec3 metal_f0, out vec3 metal_f90) {
    f0 = mix(s.dielectric_f0, b.film_dielectric, s.layers.film);
    f90 = mix(vec3(s.dielectric_f90), b.film_dielectric, s.layers.film);
    metal_f0 = mix(s.base_color, b.film_metal, s.layers.film);
    metal_f90 = mix(vec3(1.0), b.film_metal, s.layers.film);
}

// ---- lights ----

layers_view layers_prepare(surface s, view_block v, vec3 to_view) {
    layers_view b;
    if (!LIGHTING_LAYERS || !s.layered) {
        b.base = energy_view(s, v, to_view);
        return b;
    }
    b.base = brdf_prepare(s, to_view);
    b.n_v = clamp(dot(s.normal, to_view), 0.0, 1.0);
    b.coat = coat_view(s, to_view);
    b.below_coat = coat_below(s, v, to_view);
    b.below_sheen = sheen_below(s, v, b.n_v);
    film_reflectances(s, b.n_v, b.film_dielectric, b.film_metal);
    vec3 f0, f90, metal_f0, metal_f90;
    filmed(s, b, f0, f90, metal_f0, metal_f90);
    energy_prepare(s, v, b.n_v, f0, f90, metal_f0, metal_f90, b.base);
    stretched_prepare(s, to_view, b);
    return b;
}

// The base and the fibers over it. `n_l`: the cosine of `to_light`, for the fibers.
vec3 layered_base_of(surface s, layers_view b, brdf_lobes lobes, vec3 to_light, float n_l) {
    vec3 fresnel = mix(s.dielectric_f0 + (vec3(s.dielectric_f90) - s.dielectric_f0) * lobes.m5, b.film_dielectric, s.layers.film);
    vec3 taken = mix(s.dielectric_f0 + (vec3(s.dielectric_f90) - s.dielectric_f0) * lobes.m5_below, b.film_dielectric, s.layers.film);
    float below = LIGHTING_CONSERVING ? b.base.below : 1.0 - max_component(taken);
    vec3 metal = mix(s.base_color + (1.0 - s.base_color) * lobes.m5, b.film_metal, s.layers.film) * lobes.specular;
    vec3 dielectric = s.base_color * (below * (1.0 / PI) * opaque_part(s)) + fresnel * lobes.specular;
    vec3 base = mix(dielectric, metal, s.metallic);
    if (LIGHTING_CONSERVING) base += b.base.between * (1.0 / PI);
    base *= b.below_sheen;
    if (max_component(s.layers.sheen_color) > 0.0) base += sheen_brdf(s, b.base.to_view, to_light, n_l, b.n_v);
    return base * lobes.n_l;
}

vec3 layered_base(surface s, layers_view b, vec3 to_light) {
    brdf_lobes lobes;
    if (!brdf_lobes_of(s.normal, b.base, to_light, lobes)) return vec3(0.0);
    float n_l = dot(s.normal, to_light);
    if (s.layers.anisotropy > 0.0) lobes.specular = stretched_lobe(s, b, to_light, n_l);
    return layered_base_of(s, b, lobes, to_light, n_l);
}

// f(l, v) times the cosine, as brdf_cos().
vec3 layers_cos(surface s, layers_view b, vec3 to_light) {
    if (!LIGHTING_LAYERS || !s.layered) return brdf_cos(s, b.base, to_light);
    vec3 sum = layered_base(s, b, to_light) * b.below_coat;
    if (lets_through(s) && dot(s.normal, to_light) < 0.0) sum += layered_behind(s, b, to_light) * b.below_coat;
    brdf_lobes coat;
    if (s.layers.clearcoat > 0.0 && brdf_lobes_of(s.layers.clearcoat_normal, b.coat, to_light, coat))
        sum += coat_cos(s, coat);
    return sum;
}

// layers_cos() of a rectangle. Highlights that are stretched along the tangent are a fan of round ones (see stretched_radiance()); fibres see the rectangle
// where most of its light comes from. All lobes are integrated in one loop, so that shaders hold its code once.
vec3 area_cos(light_set_block l, uint light, surface s, layers_view b) {
    const uint BASE = 0u, BEHIND = 1u, COAT = 2u, FAN = 3u, FAN_COUNT = 8u;
    bool layered = LIGHTING_LAYERS && s.layered, fans = layered && s.layers.anisotropy > 0.0;
    brdf_lobes base = brdf_lobes(0.0, 0.0, 0.0, 0.0);
    vec3 base_toward = s.normal, sum = vec3(0.0);
    float fan = 0.0, weights = 1e-6;
    for (uint lobe = BASE; lobe < (fans ? FAN + FAN_COUNT : layered ? FAN : BEHIND); lobe++) {
        vec3 normal = s.normal, toward;
        brdf_view view = b.base;
        float weight = 1.0;
        brdf_lobes lobes;
        if (LIGHTING_LAYERS && lobe == BEHIND) {
            if (!lets_through(s)) continue;
            view = behind_view(s, b);
        } else if (LIGHTING_LAYERS && lobe == COAT) {
            if (!(s.layers.clearcoat > 0.0)) continue;
            normal = s.layers.clearcoat_normal;
            view = b.coat;
        } else if (LIGHTING_LAYERS && lobe >= FAN) {
            view = stretched_part(s, b, lobe - FAN, FAN_COUNT, normal, weight);
        }
        weights += lobe >= FAN ? weight : 0.0;
        if (!area_lobes_of(l, light, s.position, normal, view, lobe == BEHIND, lobes, toward)) continue;
        if (lobe == BASE) {
            base = lobes;
            base_toward = toward;
        } else if (LIGHTING_LAYERS && lobe == BEHIND) {
            sum += layered_behind_of(s, b, lobes) * b.below_coat;
        } else if (LIGHTING_LAYERS && lobe == COAT) {
            sum += coat_cos(s, lobes);
        } else {
            fan += weight * lobes.specular * lobes.n_l;
        }
    }
    if (!(base.n_l > 0.0)) return sum;
    if (!layered) return brdf_cos_of(s, b.base, base);
    if (fans) base.specular = fan / (weights * base.n_l);
    return sum + layered_base_of(s, b, base, base_toward, max(dot(s.normal, base_toward), 1e-4)) * b.below_coat;
}

// ---- light from all around ----

// `through`: the part of what is behind that shows through the base.
vec3 layers_environment(surface s, layers_view b, view_block v, out vec3 through) {
    vec3 table = environment_reflectance(v, b.n_v, s.roughness), mirrored, around;
    surface bent = s, coat = s;
    if (s.layers.anisotropy > 0.0) bent.normal = stretched_normal(s, b);
    coat.normal = s.layers.clearcoat_normal;
    coat.roughness = s.layers.clearcoat_roughness;
    light_around light_from;
    if (LIGHTING_REFLECTIONS) {
        float lod = s.layers.clearcoat > 0.0 ? environment_reflectance(v, 1.0, coat.roughness).z : -1.0;
        light_from = reflections_gather(v, s.position, s.normal, s.light_mask, lobe_direction(bent, b.base.to_view), table.z, lobe_direction(coat, b.base.to_view), lod);
        mirrored = s.layers.anisotropy > 0.0 ? stretched_radiance(s, b, v) : light_from.mirrored;
        around = light_from.diffuse;
    } else {
        mirrored = LIGHTING_ENVIRONMENT && s.layers.anisotropy > 0.0 ? stretched_radiance(s, b, v)
                                                                 : radiance_from(v, lobe_direction(bent, b.base.to_view), table.z);
        around = AMBIENT_DIFFUSE(v, s.normal);
    }
    vec3 f0, f90, metal_f0, metal_f90;
    filmed(s, b, f0, f90, metal_f0, metal_f90);
    energy_lobe lobe = energy_lobe_of(f0, f90, table.xy);
    vec3 light = environment_lobe(lobe, mirrored, around);
    vec3 below = s.base_color * around;
    if (s.layers.diffuse_transmission > 0.0) {
        vec3 behind = LIGHTING_REFLECTIONS ? reflections_gather(v, s.position, -s.normal, s.light_mask, -s.normal, 0.0, s.normal, -1.0).diffuse : AMBIENT_DIFFUSE(v, -s.normal);
        below = mix(below, s.layers.diffuse_transmission_color * behind, s.layers.diffuse_transmission);
    }
    through = vec3(0.0);
#ifdef TRANSMISSION
    below *= 1.0 - s.layers.transmission;
    through = s.base_color * ((1.0 - max_component(lobe.once + lobe.again)) * (1.0 - s.metallic) * s.layers.transmission * b.below_sheen * b.below_coat);
#endif
    light += below * energy_below(f0, f90, lobe, b.n_v);
    light = mix(light, environment_lobe(energy_lobe_of(metal_f0, metal_f90, table.xy), mirrored, around), s.metallic) * b.below_sheen;
    light += s.layers.sheen_color * environment_sheen(v, b.n_v, s.layers.sheen_roughness) * around;
    if (s.layers.clearcoat <= 0.0) return light;
    table = environment_reflectance(v, clamp(dot(coat.normal, b.base.to_view), 0.0, 1.0), coat.roughness);
    vec3 coat_light = LIGHTING_REFLECTIONS ? light_from.coat : radiance_from(v, lobe_direction(coat, b.base.to_view), table.z);
    return light * b.below_coat + s.layers.clearcoat * (COAT_F0 * table.x + table.y) * coat_light;
}

vec3 layers_rest(surface s, view_block v, vec3 to_view, vec3 sum) {
    layers_view b = layers_prepare(s, v, to_view);
    vec3 through, around = layers_environment(s, b, v, through) * s.occlusion;
#ifdef TRANSMISSION
    if (max_component(through) > 0.0) sum += through * through_radiance(s, v, to_view);
#endif
    return sum + around + s.emissive * b.below_coat;
}

#endif
