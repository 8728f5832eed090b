// SPDX-License-Identifier: MIT
// Sums of light that know nothing of the material, or next to nothing, and what a material makes of them. The BRDF of brdf.glsl is a sum of
// products: with m = (1 - v.h)^5 the dielectric's diffuse part takes (1 - F0) - (F90 - F0) m of its albedo, F0 and F90 being those of the
// channel that reflects most, and either lobe reflects F0 + (F90 - F0) m. So four sums over the lights, of E cos / pi, E cos m / pi,
// E cos lobe and E cos lobe m, are all that any material needs.
#ifndef LIGHT_PREPASS_GLSL
#define LIGHT_PREPASS_GLSL

#include "shade.glsl"
#include "scene.glsl"
#include "gbuffer_layouts.glsl"
#include "passes/shade/light_prepass_shared.h"

layout(constant_id = LIGHT_BUFFER_ID) const uint LIGHT_BUFFER = LIGHT_BUFFER_TWO;

// LIGHT_BUFFER_FOUR: the four sums. TWO: at[0] diffuse light less what is reflected, at[1] reflected light. RGBA: at[0] diffuse light,
// with the luminance of the specular lobe in its alpha.
// NARROW: at[0] diffuse light less what a dielectric of F0 = 0.04 reflects, at[1] reflected light over F0, both where the switch is on; elsewhere
// neither knows of Fresnel.
struct light_sums {
    vec4 at[LIGHT_BUFFER_TARGETS];
};

// What stands for a pixel in the light passes.
struct light_surface {
    vec3 position;
    vec3 normal;
    vec3 geometric; // as surface.geometric
    float roughness;
    float greatest_f0, dielectric_f90; // LIGHT_BUFFER_TWO and LIGHT_BUFFER_NARROW, as the next
    vec3 f0;                           // of both lobes together
    float f90;
};

light_sums light_sums_none() {
    light_sums sums;
    for (uint i = 0u; i < LIGHT_BUFFER_TARGETS; i++) sums.at[i] = vec4(0.0);
    return sums;
}

// Adds one light by its lobes; `light` is its illuminance at right angles to the ray.
void light_sums_add(inout light_sums sums, light_surface s, brdf_lobes lobes, vec3 light) {
    precise vec3 diffuse = light * (lobes.n_l * (1.0 / PI)), specular = light * (lobes.n_l * lobes.specular);
    if (LIGHT_BUFFER == LIGHT_BUFFER_RGBA) {
        precise vec4 sum = sums.at[0] + vec4(diffuse, luminance(specular));
        sums.at[0] = sum;
    } else if (LIGHT_BUFFER == LIGHT_BUFFER_TWO || LIGHT_BUFFER == LIGHT_BUFFER_NARROW) {
        precise float reflected = s.greatest_f0 + (s.dielectric_f90 - s.greatest_f0) * lobes.m5_below;
        precise vec3 kept = sums.at[0].rgb + diffuse * (LIGHTING_CONSERVING ? 1.0 : 1.0 - reflected);
        precise vec3 mirrored = sums.at[1].rgb + specular * (s.f0 + (vec3(s.f90) - s.f0) * lobes.m5);
        sums.at[0].rgb = kept;
        sums.at[1].rgb = mirrored;
    } else {
        precise vec3 a = sums.at[0].rgb + diffuse, c = sums.at[2].rgb + specular;
        precise vec3 b5 = sums.at[1].rgb + diffuse * lobes.m5_below, d5 = sums.at[3].rgb + specular * lobes.m5;
        sums.at[0].rgb = a;
        sums.at[1].rgb = b5;
        sums.at[2].rgb = c;
        sums.at[3].rgb = d5;
    }
}

brdf_view light_surface_view(light_surface s, view_block v) {
    surface shape;
    shape.normal = s.normal;
    shape.geometric = s.geometric;
    shape.roughness = s.roughness;
    return brdf_prepare(shape, to_viewer(v, s.position));
}

// All lights of a point, by the frame's lists.
light_sums light_sums_of(light_surface s, view_block v, lighting_block l, uint_array counters, uvec2 pixel, float view_depth) {
    brdf_view b = light_surface_view(s, v);
    light_sums sums = light_sums_none();
    shadowed_point shadowed = shadowed_point_of(l, s.position, s.normal);
    uint directional_count = l.scope.lights.directional_count;
    brdf_lobes lobes;
    for (uint i = 0u; i < directional_count; i++) {
        vec3 to_sun, illuminance = sun_reach(lights_of(l), i, LIGHT_MASK_ALL, to_sun);
        if (!brdf_lobes_of(s.normal, b, to_sun, lobes)) continue;
        if (LIGHTING_SHADOWED) illuminance *= light_visibility(l, i, shadowed, to_sun, true);
        light_sums_add(sums, s, lobes, illuminance);
    }
    light_cursor cursor = lights_begin(list_of(l), light_point(pixel, view_depth, s.position, s.normal, LIGHT_NO_ITEM));
    uint visited = 0u, useful = 0u;
    FOR_EACH_LIGHT(list_of(l), cursor, light) {
        vec3 to_light;
        vec3 illuminance = light_reach(lights_of(l), light, s.position, LIGHT_MASK_ALL, to_light);
        if (COUNT_LIGHTS == 1u) visited++;
        if (illuminance != vec3(0.0)) {
            if (LIGHTING_SHADOWED) illuminance *= light_visibility(l, light, shadowed, to_light, false);
            if (light_brdf_lobes(lights_of(l), light, s.position, s.normal, b, to_light, lobes)) light_sums_add(sums, s, lobes, illuminance);
            if (COUNT_LIGHTS == 1u) useful++;
        }
    }
    if (COUNT_LIGHTS == 1u) {
        atomicAdd(counters.at[(pixel.y * v.view.size.x + pixel.x) * 2u], visited);
        atomicAdd(counters.at[(pixel.y * v.view.size.x + pixel.x) * 2u + 1u], useful);
    }
    count_shadows(v, counters);
    return sums;
}

// LIGHT_BUFFER_NARROW: whether reflectance rises at grazing angles as that of a common dielectric does. One bit must do for all materials.
bool narrow_fresnel(surface s) { return s.metallic < 0.5 && s.dielectric_f90 > 0.9 && abs(max_component(s.dielectric_f0) - 0.04) < 0.02; }

void narrow_reflectance(inout light_surface s, bool fresnel) {
    s.greatest_f0 = fresnel ? 0.04 : 0.0;
    s.dielectric_f90 = fresnel ? 1.0 : 0.0;
    s.f0 = vec3(1.0);
    s.f90 = fresnel ? 1.0 / 0.04 : 1.0;
}

// What a material makes of it. RGBA knows neither the half vectors nor the colours of highlights: reflectance is that of normal
// incidence, and highlights take the hue of the diffuse light. Right for reflectances without Fresnel's rise (F90 = F0) under white
// lights.
vec3 light_sums_reflect(surface s, view_block v, light_sums sums) {
    float greatest = max_component(s.dielectric_f0);
    vec3 albedo = s.base_color * (1.0 - s.metallic);
    brdf_view b;
    if (LIGHTING_CONSERVING) b = energy_view(s, v, to_viewer(v, s.position));
    vec3 f0 = mix(s.dielectric_f0, s.base_color, s.metallic);
    if (LIGHT_BUFFER == LIGHT_BUFFER_RGBA) {
        vec3 diffuse = sums.at[0].rgb;
        vec3 hue = diffuse / max(luminance(diffuse), 1e-20);
        if (LIGHTING_CONSERVING) return (albedo * b.below + b.between) * diffuse + f0 * hue * sums.at[0].a;
        return albedo * (1.0 - greatest) * diffuse + f0 * hue * sums.at[0].a;
    }
    if (LIGHT_BUFFER == LIGHT_BUFFER_NARROW) {
        vec3 diffuse = sums.at[0].rgb * (LIGHTING_CONSERVING || narrow_fresnel(s) ? 1.0 : 1.0 - greatest);
        return (LIGHTING_CONSERVING ? albedo * b.below + b.between : albedo) * diffuse + f0 * sums.at[1].rgb;
    }
    if (LIGHT_BUFFER == LIGHT_BUFFER_TWO && LIGHTING_CONSERVING) return (albedo * b.below + b.between) * sums.at[0].rgb + sums.at[1].rgb;
    if (LIGHT_BUFFER == LIGHT_BUFFER_TWO) return albedo * sums.at[0].rgb + sums.at[1].rgb;
    vec3 rise = mix(vec3(s.dielectric_f90), vec3(1.0), s.metallic) - f0;
    vec3 diffuse = sums.at[0].rgb * (1.0 - greatest) - sums.at[1].rgb * (s.dielectric_f90 - greatest);
    if (LIGHTING_CONSERVING) return (albedo * b.below + b.between) * sums.at[0].rgb + max(f0 * sums.at[2].rgb + rise * sums.at[3].rgb, vec3(0.0));
    return albedo * max(diffuse, vec3(0.0)) + max(f0 * sums.at[2].rgb + rise * sums.at[3].rgb, vec3(0.0));
}

/* ---- the surfaces of the first pass ---- */

vec4 light_surface_pack(surface s, out vec4 reflectance) {
    if (LIGHT_BUFFER == LIGHT_BUFFER_NARROW) {
        reflectance = vec4(0.0);
        float roughness = 1.0 + round(s.roughness * 126.0); // never 0: it has a sign
        return (vec4(round(s.normal * 127.0), narrow_fresnel(s) ? roughness : -roughness) + 128.0) / 255.0;
    }
    float packed = round(sqrt(max_component(s.dielectric_f0)) * 255.0) * 256.0 + round(s.dielectric_f90 * 255.0);
    reflectance = vec4(sqrt(mix(s.dielectric_f0, s.base_color, s.metallic)), mix(s.dielectric_f90, 1.0, s.metallic));
    return vec4(octahedral_encode(s.normal) * 0.5 + 0.5, s.roughness, packed / 65535.0);
}

// `at`: a sample of the pixel, or -1 where it has but one.
vec4 light_surface_texel(uint image, ivec2 pixel, int at) {
    return at < 0 ? texelFetch(textures[image], pixel, 0) : texelFetch(textures_multisampled[image], pixel, at);
}

light_surface light_surface_of(gpu_light_surfaces from, ivec2 pixel, int at, vec3 position) {
    light_surface s;
    vec4 normal = light_surface_texel(from.normal, pixel, at);
    s.position = position;
    vec4 narrow = round(normal * 255.0) - 128.0;
    s.normal = LIGHT_BUFFER == LIGHT_BUFFER_NARROW ? normalize(narrow.xyz) : octahedral_decode(normal.xy * 2.0 - 1.0);
    s.geometric = vec3(0.0);
    if (from.geometric != GPU_TEXTURE_NONE)
        s.geometric = geometric_decode(light_surface_texel(from.geometric, pixel, at).xy);
    s.roughness = LIGHT_BUFFER == LIGHT_BUFFER_NARROW ? (abs(narrow.w) - 1.0) / 126.0 : normal.z;
    s.greatest_f0 = s.dielectric_f90 = s.f90 = 0.0;
    s.f0 = vec3(0.0);
    if (LIGHT_BUFFER == LIGHT_BUFFER_TWO) {
        vec4 reflectance = light_surface_texel(from.reflectance, pixel, at);
        uint packed = uint(round(normal.w * 65535.0));
        float root = float(packed >> 8) / 255.0;
        s.greatest_f0 = root * root;
        s.dielectric_f90 = float(packed & 255u) / 255.0;
        s.f0 = reflectance.rgb * reflectance.rgb;
        s.f90 = reflectance.a;
    }
    if (LIGHT_BUFFER == LIGHT_BUFFER_NARROW) narrow_reflectance(s, narrow.w > 0.0);
    return s;
}
// A surface as the first pass would have stored it, but for rounding.
light_surface light_surface_from(surface m) {
    light_surface s;
    s.position = m.position;
    s.normal = m.normal;
    s.geometric = m.geometric;
    s.roughness = m.roughness;
    s.greatest_f0 = max_component(m.dielectric_f0);
    s.dielectric_f90 = m.dielectric_f90;
    s.f0 = mix(m.dielectric_f0, m.base_color, m.metallic);
    s.f90 = mix(m.dielectric_f90, 1.0, m.metallic);
    if (LIGHT_BUFFER == LIGHT_BUFFER_NARROW) narrow_reflectance(s, narrow_fresnel(m));
    return s;
}

light_surface light_surface_of(gpu_light_surfaces from, ivec2 pixel, vec3 position) { return light_surface_of(from, pixel, -1, position); }

#endif
