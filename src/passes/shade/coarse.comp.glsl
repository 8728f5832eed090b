#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Deferred shading at a coarse rate: blocks of pixels that are alike are lit once, and other pixels each. The variant FOVEATED: where the viewer looks
// decides; a thread then lights several blocks or quads, so that it writes each at once.
#include "common.glsl"
#include "shade.glsl"
#ifndef FOVEATED
#define UNFOVEATED
#endif
#include "passes/shade/coarse.glsl"

layout(constant_id = COARSE_SPLIT_ID) const uint SPLIT = COARSE_SPLIT_NONE;

// What lighting makes of a base colour c: c * by_color + rest. `rest` alone where nothing is split by the base colour.
struct coarse_light {
    vec3 by_color;
    vec3 rest;
};

// Parts of the light: what blocks share, what each pixel has of its own.
const uint PART_SLOW = 1u, PART_PIXEL = 2u;

// The base colour of a block: filtered where it was sampled, or the mean of its pixels. `pixel` stands for those from `first` on.
vec3 shared_color(ivec2 first, ivec2 pixel, uint side, vec3 own) {
    if (COARSE_IS_FOVEA && (side < SIZE || (FLAGS & COARSE_MEAN) != 0u)) { // there may be background between them
        vec4 sum = vec4(0.0);
        for (uint i = 0u; i < side * side; i++) {
            ivec2 at = first + ivec2(i % side, i / side);
            if (coarse_inside(at) && gbuffer_depth(push.gbuffer, at) > 0.0) sum += vec4(color_at(at), 1.0);
        }
        return sum.rgb / max(sum.a, 1.0);
    }
    if ((FLAGS & COARSE_COLOR) != 0u) return gbuffer_decode_color(texelFetch(textures[push.color], pixel, 0).rgb);
    if ((FLAGS & COARSE_MEAN) == 0u) return own;
    for (uint i = 1u; i < SIZE * SIZE; i++)
        own += color_at(min(first + ivec2(i % SIZE, i / SIZE), coarse_last()));
    return own * (1.0 / float(SIZE * SIZE));
}

surface surface_at(ivec2 pixel, float view_depth, bool is_shared, ivec2 first, uint side) {
    view_block v = push.gbuffer.view;
    surface s = gbuffer_surface(push.gbuffer, pixel, gbuffer_position(v, pixel, view_depth), vec3(0.0));
    if ((FLAGS & (COARSE_COLOR | COARSE_MEAN)) != 0u && is_shared) s.base_color = shared_color(first, pixel, side, s.base_color);
    if ((FLAGS & COARSE_AO) != 0u) s.occlusion *= texelFetch(textures[push.ao], pixel, 0).r;
    return s;
}

// ---- parts of the light ----

// The BRDF of brdf.glsl, by base colour and rest; both are linear in it.
coarse_light brdf_parts(surface s, brdf_view b, brdf_lobes lobes) {
    coarse_light f = coarse_light(vec3(0.0), vec3(0.0));
    vec3 fresnel = s.dielectric_f0 + (vec3(s.dielectric_f90) - s.dielectric_f0) * lobes.m5;
    float diffuse = brdf_below(s, b, lobes) * (1.0 / PI) * (1.0 - s.metallic);
    float metal = s.metallic * lobes.specular;
    if (SPLIT == COARSE_SPLIT_ALBEDO) {
        f.by_color = vec3((diffuse + metal * (1.0 - lobes.m5)) * lobes.n_l);
        f.rest = (fresnel * (lobes.specular * (1.0 - s.metallic)) + metal * lobes.m5) * lobes.n_l;
    } else { // by_color: the diffuse light; rest: highlights, with the colour in both
        f.by_color = s.base_color * (diffuse * lobes.n_l);
        f.rest = (fresnel * (lobes.specular * (1.0 - s.metallic)) + (s.base_color + (1.0 - s.base_color) * lobes.m5) * metal) * lobes.n_l;
    }
    if (LIGHTING_CONSERVING) f.rest += b.between * (lobes.n_l * (1.0 / PI));
    return f;
}

// Ambient light by base colour and rest: shade_rest() is linear in it too.
coarse_light ambient_parts(surface s, vec3 to_view) {
    surface black = s, white = s;
    black.base_color = vec3(0.0);
    white.base_color = vec3(1.0);
    coarse_light light;
    light.rest = shade_rest(black, push.gbuffer.view, to_view, vec3(0.0));
    light.by_color = shade_rest(white, push.gbuffer.view, to_view, vec3(0.0)) - light.rest;
    return light;
}

// Lights whose illuminance ends at an edge that shows: cones, wedges, boxes. That of points and capsules fades out to nothing.
bool has_edge(uint light) {
    uint kind = push.lighting.scope.lights.lights.at[light].shape.kind;
    return kind != GPU_SHAPE_SPHERE && kind != GPU_SHAPE_CAPSULE || push.lighting.scope.lights.lights.at[light].shape.hull_count != 0u;
}

// `parts` of the light at a pixel's surface. The sum of the parts is what shade_surface() gives but for the order of its additions.
coarse_light light_parts(surface s, uvec2 pixel, float view_depth, uint parts) {
    view_block v = push.gbuffer.view;
    vec3 to_view = to_viewer(v, s.position);
    brdf_view b = energy_view(s, v, to_view);
    coarse_light sum = coarse_light(vec3(0.0), vec3(0.0));
    float diffuse_weight = SPLIT == COARSE_SPLIT_HIGHLIGHTS ? float(parts & PART_SLOW) : 1.0;
    float rest_weight = SPLIT == COARSE_SPLIT_HIGHLIGHTS ? float(parts >> 1u & 1u) : 1.0;
    bool is_slow = (parts & PART_SLOW) != 0u;
    shadowed_point shadowed = shadowed_point_of(push.lighting, s.position, s.normal);
    brdf_lobes lobes;
    uint directional_count = SPLIT == COARSE_SPLIT_SHARP && !is_slow ? 0u : push.lighting.scope.lights.directional_count;
    for (uint i = 0u; i < directional_count; i++) {
        vec3 to_sun, color = sun_reach(lights_of(push.lighting), i, LIGHT_MASK_ALL, to_sun);
        if (!brdf_lobes_of(s.normal, b, to_sun, lobes)) continue;
        coarse_light f = brdf_parts(s, b, lobes);
        if (LIGHTING_SHADOWED) color *= light_visibility(push.lighting, i, shadowed, to_sun, true);
        sum.by_color += color * f.by_color * diffuse_weight;
        sum.rest += color * f.rest * rest_weight;
    }
    light_cursor cursor = lights_begin(list_of(push.lighting), light_point(pixel, view_depth, s.position, s.normal, LIGHT_NO_ITEM));
    uint visited = 0u, useful = 0u;
    FOR_EACH_LIGHT(list_of(push.lighting), cursor, light) {
        bool wanted = SPLIT != COARSE_SPLIT_SHARP || (parts & (has_edge(light) ? PART_PIXEL : PART_SLOW)) != 0u;
        vec3 to_light, illuminance = vec3(0.0);
        if (wanted) illuminance = light_reach(lights_of(push.lighting), light, s.position, LIGHT_MASK_ALL, to_light);
        if (COUNT_LIGHTS == 1u) visited++;
        if (illuminance != vec3(0.0)) {
            if (LIGHTING_SHADOWED) illuminance *= light_visibility(push.lighting, light, shadowed, to_light, false);
            if (COUNT_LIGHTS == 1u) useful++;
            if (!light_brdf_lobes(lights_of(push.lighting), light, s.position, s.normal, b, to_light, lobes)) continue;
            coarse_light f = brdf_parts(s, b, lobes);
            sum.by_color += illuminance * f.by_color * diffuse_weight;
            sum.rest += illuminance * f.rest * rest_weight;
        }
    }
    if (COUNT_LIGHTS == 1u) {
        atomicAdd(push.counters.at[(pixel.y * v.view.size.x + pixel.x) * 2u], visited);
        atomicAdd(push.counters.at[(pixel.y * v.view.size.x + pixel.x) * 2u + 1u], useful);
    }
    count_shadows(v, push.counters);
    if (!is_slow) return sum;
    if (v.view.frame.frame.shade_cost > 0u) sum.rest += shade_cost(v, s.roughness);
    coarse_light ambient = ambient_parts(s, to_view);
    if (SPLIT == COARSE_SPLIT_ALBEDO)
        sum.by_color += ambient.by_color;
    else
        sum.by_color += ambient.by_color * s.base_color;
    sum.rest += ambient.rest;
    return sum;
}

vec3 put_together(coarse_light light, vec3 base_color) {
    return SPLIT == COARSE_SPLIT_ALBEDO ? light.by_color * base_color + light.rest : light.by_color + light.rest;
}

// ---- pixels ----

void store(ivec2 pixel, vec3 light) {
    vec3 emissive = imageLoad(images[push.target], pixel).rgb;
    imageStore(images[push.target], pixel, vec4(min(light + emissive, vec3(push.gbuffer.view.view.frame.frame.hdr_max)), 1.0));
}

// Writes what a block shares to its pixels, with what each has of its own.
void spread(ivec2 first, uint side, coarse_light light) {
    for (uint i = 0u; i < side * side; i++) {
        ivec2 pixel = first + ivec2(i % side, i / side);
        if (!coarse_inside(pixel)) continue;
        if (COARSE_IS_FOVEA && gbuffer_depth(push.gbuffer, pixel) <= 0.0) continue;
        coarse_light own = light;
        vec3 color = vec3(0.0);
        if (SPLIT == COARSE_SPLIT_ALBEDO) color = color_at(pixel);
        if (SPLIT == COARSE_SPLIT_HIGHLIGHTS || SPLIT == COARSE_SPLIT_SHARP) {
            float view_depth = view_depth_of(push.gbuffer.view, gbuffer_depth(push.gbuffer, pixel));
            coarse_light more = light_parts(surface_at(pixel, view_depth, false, pixel, 1u), uvec2(pixel), view_depth, PART_PIXEL);
            own.by_color += more.by_color;
            own.rest += more.rest;
        }
        store(pixel, put_together(own, color));
    }
}

void main() {
    coarse_walk walk = coarse_begin();
#ifndef FOVEATED
    coarse_light kept;
    bool keeps = walk.kind == COARSE_SHARED && (FLAGS & COARSE_GATHER) != 0u;
#endif
    for (uint turn = 0u; turn < walk.turns; turn++) {
        ivec2 first;
        uint side;
        ivec2 pixel;
        float depth = 0.0;
        if (coarse_work(walk, turn, first, side)) {
            pixel = coarse_standing(first, side);
            depth = gbuffer_depth(push.gbuffer, pixel);
        }
        if (depth > 0.0) {
            bool is_shared = COARSE_IS_FOVEA ? side > 1u : turn == 0u && walk.kind == COARSE_SHARED;
            float view_depth = view_depth_of(push.gbuffer.view, depth);
            surface s = surface_at(pixel, view_depth, is_shared, first, side);
            coarse_light light;
            if (SPLIT == COARSE_SPLIT_NONE)
                light = coarse_light(vec3(0.0), shade_surface(s, push.gbuffer.view, push.lighting, push.counters, uvec2(pixel), view_depth,
                                                              LIGHT_NO_ITEM));
            else
                light = light_parts(s, uvec2(pixel), view_depth, is_shared ? PART_SLOW : PART_SLOW | PART_PIXEL);
            if (is_shared) {
#ifdef FOVEATED
                spread(first, side, light);
#else
                kept = light;
                keeps = true;
#endif
            } else {
                store(pixel, put_together(light, s.base_color));
            }
        }
    }
#ifndef FOVEATED
    if (keeps) spread(walk.first, SIZE, kept); // one call, as it is inlined
#endif
}
