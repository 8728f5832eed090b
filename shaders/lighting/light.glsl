// SPDX-License-Identifier: MIT
// The contribution of one light to a surface, as a product of three factors: the light that arrives (reach.glsl), the fraction that is not in shadow
// (visibility.glsl), and the fraction that the surface sends to the viewer. Paths with a complete surface call light_at(). Paths that have only part of
// the surface, or choose lights by some of the factors, call the functions they need and multiply in this order, so all paths round identically.
#ifndef LIGHTING_LIGHT_GLSL
#define LIGHTING_LIGHT_GLSL

#include "lighting/visibility.glsl"
#include "layers.glsl"

// f(l, v) times the cosine of all lobes of the surface; `to_light` as light_reach() has it.
vec3 light_lobes(light_set_block l, uint light, surface s, layers_view b, vec3 to_light) {
    if (light_is_area(l, light, s.position)) return area_cos(l, light, s, b);
    return layers_cos(s, b, to_light);
}

// The point with the normal for shadows of one light: surfaces that transmit light are tested on the light's side.
shadowed_point shadowed_towards(shadowed_point p, surface s, vec3 to_light) {
    if (LIGHTING_LAYERS && LIGHTING_SHADOWED) p.normal = lit_normal(s, to_light);
    return p;
}

// Radiance towards the viewer, cd/m^2. `reaches`: whether the surface is inside the light's volume.
vec3 light_at(lighting_block l, uint light, surface s, layers_view b, shadowed_point p, out bool reaches) {
    vec3 to_light;
    vec3 arriving = light_reach(lights_of(l), light, s.position, s.light_mask, to_light);
    reaches = arriving != vec3(0.0);
    if (!reaches) return vec3(0.0);
    if (LIGHTING_SHADOWED) arriving *= light_visibility(l, light, shadowed_towards(p, s, to_light), to_light, false);
    precise vec3 radiance = arriving * light_lobes(lights_of(l), light, s, b, to_light);
    return radiance;
}

// The same, summed over all directional lights.
vec3 suns_at(lighting_block l, surface s, layers_view b, shadowed_point p) {
    precise vec3 sum = vec3(0.0);
    uint count = l.scope.lights.directional_count;
    for (uint i = 0u; i < count; i++) {
        vec3 to_sun;
        vec3 arriving = sun_reach(lights_of(l), i, s.light_mask, to_sun);
        if (LIGHTING_SHADOWED) arriving *= light_visibility(l, i, shadowed_towards(p, s, to_sun), to_sun, true);
        sum += arriving * layers_cos(s, b, to_sun);
    }
    return sum;
}

#endif
