// SPDX-License-Identifier: MIT
// Light on a surface: the one function that every shading order calls.
#ifndef SHADE_GLSL
#define SHADE_GLSL

#include "view.glsl"
#include "brdf.glsl"
#include "energy.glsl"
#include "environment.glsl"
#include "lighting/visibility.glsl"
#include "lights/area.glsl"
#include "shadows/sampled.glsl"

// Counts are written where this is 1: two per pixel, lights visited and lights that reach the surface; behind them, points that no cell of
// their list served, shadow rays, and those of them that passed.
layout(constant_id = COUNT_LIGHTS_ID) const uint COUNT_LIGHTS = 0u;

// Variants for pixels that need less: 0 where no list holds a light; HAS_METAL of brdf.glsl.
layout(constant_id = HAS_LIGHTS_ID) const uint HAS_LIGHTS = 1u;

vec3 ambient_radiance(view_block v, vec3 direction) {
    return mix(v.view.frame.frame.ambient_ground, v.view.frame.frame.ambient_sky, direction.y * 0.5 + 0.5);
}

#include "reflections.glsl"

// What a white diffuse surface reflects of light from all around, where no reflection probe is.
vec3 ambient_diffuse(view_block v, vec3 normal) { return LIGHTING_ENVIRONMENT ? environment_diffuse(v, normal) : ambient_radiance(v, normal); }

// Shaders that know that already say so before they include this.
#ifndef AMBIENT_DIFFUSE
#define AMBIENT_DIFFUSE(v, normal) ambient_diffuse(v, normal)
#endif

// Light from the environment on a lobe. `mirrored`: radiance from the lobe's direction; `around`: radiance that a white diffuse surface reflects.
vec3 environment_lobe(energy_lobe lobe, vec3 mirrored, vec3 around) {
    precise vec3 light = lobe.once * mirrored + lobe.again * around;
    return light;
}

vec3 radiance_from(view_block v, vec3 direction, float lod) {
    return LIGHTING_ENVIRONMENT ? environment_radiance(v, direction, lod) : ambient_radiance(v, normalize(direction));
}

// Where most of what a surface mirrors comes from: masked and shadowed microfacets bend a wide lobe towards the normal (Lagarde and de Rousiers 2014,
// "Moving Frostbite to Physically Based Rendering").
vec3 lobe_direction(surface s, vec3 to_view) {
    precise float alpha = s.roughness * s.roughness, smoothness = 1.0 - alpha;
    precise vec3 bent = mix(s.normal, reflect(-to_view, s.normal), smoothness * (sqrt(smoothness) + alpha));
    return bent;
}

vec3 environment_light(surface s, view_block v, vec3 to_view, float n_v) {
    vec3 table = environment_reflectance(v, n_v, s.roughness);
    vec2 reflectance = table.xy;
    vec3 mirrored, around;
    if (LIGHTING_REFLECTIONS) {
        light_around light = reflections_gather(v, s.position, s.normal, s.light_mask, lobe_direction(s, to_view), table.z, s.normal, -1.0);
        mirrored = light.mirrored;
        around = light.diffuse;
    } else {
        mirrored = radiance_from(v, lobe_direction(s, to_view), table.z);
        around = AMBIENT_DIFFUSE(v, s.normal);
    }
    energy_lobe lobe = energy_lobe_of(s.dielectric_f0, vec3(s.dielectric_f90), reflectance);
    precise vec3 dielectric = environment_lobe(lobe, mirrored, around);
    precise vec3 below = s.base_color * energy_below(s.dielectric_f0, vec3(s.dielectric_f90), lobe, n_v) * around;
    precise vec3 light = dielectric + below;
    if (HAS_METAL == 0u) return light;
    precise vec3 metal = environment_lobe(energy_lobe_of(s.base_color, vec3(1.0), reflectance), mirrored, around);
    precise vec3 mixed = mix(light, metal, s.metallic);
    return mixed;
}

#include "layers.glsl"
#include "lighting/light.glsl"

// What is left when all lights are summed up: ambient light (diffuse by the normal, specular by the mirror direction, both dimmed by
// occlusion) and the surface's own glow. Precise, so that variants of a shader that know some of its input round alike.
vec3 shade_rest(surface s, view_block v, vec3 to_view, vec3 sum) {
    if (LIGHTING_LAYERS && s.layered) return layers_rest(s, v, to_view, sum);
    float n_v = clamp(dot(s.normal, to_view), 0.0, 1.0);
    if (LIGHTING_ENVIRONMENT || LIGHTING_REFLECTIONS || LIGHTING_CONSERVING) {
        precise vec3 lit = sum + environment_light(s, v, to_view, n_v) * s.occlusion + s.emissive;
        return lit;
    }
    precise vec2 environment = environment_brdf(s.roughness, n_v);
    precise vec3 f0 = mix(s.dielectric_f0, s.base_color, s.metallic);
    precise float f90 = mix(s.dielectric_f90, 1.0, s.metallic);
    // What the dielectric's surface reflects from all around does not get below it.
    precise vec3 diffuse = s.base_color * (1.0 - s.metallic) * energy_below(s.dielectric_f0, vec3(s.dielectric_f90), energy_lobe(vec3(0.0), vec3(0.0)), n_v);
    precise vec3 ambient = diffuse * AMBIENT_DIFFUSE(v, s.normal) +
                           (f0 * environment.x + f90 * environment.y) * ambient_radiance(v, reflect(-to_view, s.normal));
    precise vec3 result = sum + ambient * s.occlusion + s.emissive;
    return result;
}

// What stands for dearer shading where methods are compared (fnl_frame.shade_cost): a chain that no compiler can shorten, of which nothing is
// left. `seed` is any number.
float shade_cost(view_block v, float seed) {
    float burn = clamp(seed, -1.0, 1.0);
    for (uint i = 0u; i < v.view.frame.frame.shade_cost; i++) burn = sin(burn * 1.7 + 0.3);
    return burn * v.view.frame.frame.nothing;
}

// If COUNT_LIGHTS is 1: counts the rays and the filtered lookups since the last call.
void count_shadows(view_block v, uint_array counters) {
    if (COUNT_LIGHTS != 1u) return;
    uint at = v.view.size.x * v.view.size.y * 2u;
    if (LIGHTING_RAYS) {
        atomicAdd(counters.at[at + 1u], rays_sent);
        atomicAdd(counters.at[at + 2u], rays_passed);
        rays_sent = rays_passed = 0u;
    }
    if (LIGHTING_FILTERED) {
        atomicAdd(counters.at[at + 3u], shadows_filtered);
        atomicAdd(counters.at[at + 4u], shadows_settled);
        shadows_filtered = shadows_settled = 0u;
    }
}

// With LIGHTING_DENOISED shade_surface() leaves here what it did not add to the radiance.
struct light_apart {
    vec3 open;   // what all local lights give without shadows, cd/m^2: exact
    vec3 drawn;  // the same, estimated by the chosen ones; where guides choose them unevenly, the same
    vec3 seen;   // what is left of that by their shadows
    vec4 field;  // lux: sum over the lights of the direction to it, and of 1, each times its luminance; it knows nothing of the surface
    float noise; // variance of seen over drawn, as a part of what is possible for its mean; 0: nothing was left to chance
};
light_apart apart;

// Outgoing radiance in cd/m^2. `counters` holds two uints per pixel; it is touched only where COUNT_LIGHTS is 1. `item` is the draw item,
// or LIGHT_NO_ITEM.
vec3 shade_surface(surface s, view_block v, lighting_block l, uint_array counters, uvec2 pixel, float view_depth, uint item) {
    vec3 to_view = to_viewer(v, s.position);
    layers_view b = layers_prepare(s, v, to_view);
    shadowed_point shadowed = shadowed_point_of(l, s.position, facing_normal(s));
    precise vec3 sum = suns_at(l, s, b, shadowed);

    light_point point = light_point(pixel, view_depth, s.position, s.normal, item);
    light_cursor cursor = lights_begin(list_of(l), point);
    uint visited = 0u, useful = 0u;
    // With LIGHTING_SAMPLED a first walk sums up what the lights give without shadows, and a second one chooses some of them by it (shadows/sampled.glsl).
    // Both are one loop, so that shaders hold its code once.
    light_draw draw;
    float weights = 0.0;
    uint weighed = 0u;
    float expected = 0.0; // with LIGHTING_GUIDED: of what the lights give, what is likely to be seen
    bool even = true;     // and guides say nothing
    if (LIGHTING_SAMPLED) one_point = true;
    if (LIGHTING_DENOISED) apart = light_apart(vec3(0.0), vec3(0.0), vec3(0.0), vec4(0.0), 0.0);
    for (uint walk = LIGHTING_SAMPLED ? 0u : 1u; walk < 2u && HAS_LIGHTS == 1u; walk++) {
        if (LIGHTING_SAMPLED && walk == 1u) {
            draw = light_draw_begin(l, pixel, weights, weighed);
            if (LIGHTING_DENOISED && draw.scale != 0.0) apart.noise = 1.0 / float(l.scope.shadows.ray_count);
            if (LIGHTING_DENOISED && LIGHTING_GUIDED) apart.noise *= guided_noise(weights, expected, luminance(apart.open));
            cursor = lights_begin(list_of(l), point);
        }
        FOR_EACH_LIGHT(list_of(l), cursor, light) {
            vec3 to_light;
            vec3 arriving = light_reach(lights_of(l), light, s.position, s.light_mask, to_light);
            if (COUNT_LIGHTS == 1u) visited++;
            if (arriving != vec3(0.0)) {
                if (COUNT_LIGHTS == 1u && walk == 1u) useful++;
                vec3 lobes = light_lobes(lights_of(l), light, s, b, to_light);
                if (LIGHTING_SAMPLED) {
                    precise float weight = luminance(arriving * lobes);
                    if (!(weight > 0.0)) continue;
                    if (LIGHTING_GUIDED) {
                        float by = guide_weight(light);
                        weight *= by;
                        even = even && by == 1.0;
                        if (LIGHTING_DENOISED && walk == 0u) expected += weight * by;
                    }
                    if (walk == 0u) {
                        if (LIGHTING_DENOISED) {
                            apart.open += arriving * lobes;
                            apart.field += luminance(arriving) * vec4(to_light, 1.0);
                        }
                        precise float more = weights + weight;
                        weights = more;
                        weighed++;
                        continue;
                    }
                    float share = light_draw_next(draw, weight);
                    if (share == 0.0) continue;
                    arriving *= share;
                }
                if (LIGHTING_DENOISED) apart.drawn += arriving * lobes;
                if (LIGHTING_SHADOWED) {
                    vec3 open = light_visibility(l, light, shadowed_towards(shadowed, s, to_light), to_light, false);
                    if (LIGHTING_GUIDED) guide_note(light, open.x);
                    arriving *= open;
                }
                if (LIGHTING_DENOISED) apart.seen += arriving * lobes;
                else sum += arriving * lobes;
                if (LIGHTING_SAMPLED && light_draw_done(draw)) break;
            }
        }
    }
    if (LIGHTING_DENOISED && LIGHTING_GUIDED && !even) apart.drawn = apart.open;
    if (LIGHTING_DENOISED && LIGHTING_SOFT && point_chosen && apart.noise == 0.0) apart.noise = 1.0 / float(weighed);
    if (COUNT_LIGHTS == 1u) {
        atomicAdd(counters.at[(pixel.y * v.view.size.x + pixel.x) * 2u], visited);
        atomicAdd(counters.at[(pixel.y * v.view.size.x + pixel.x) * 2u + 1u], useful);
        if (cursor.unserved) atomicAdd(counters.at[v.view.size.x * v.view.size.y * 2u], 1u);
    }
    count_shadows(v, counters);

    if (v.view.frame.frame.shade_cost > 0u) sum += shade_cost(v, s.roughness);
    return shade_rest(s, v, to_view, sum);
}

#endif
