// SPDX-License-Identifier: MIT
// Light from all around where reflection probes are (docs/techniques/reflection-probes.md): each holds what was seen from one point of a box. A ray is
// followed to the wall of the box, and looked up in the direction in which the point saw that place (Lagarde and Zanuttini 2012, "Local Image-based
// Lighting With Parallax-corrected Cubemap"). Probes of the highest priority come first; what they leave goes to the next, and in the end to the
// environment. Include after ambient_radiance() is there.
#ifndef REFLECTIONS_GLSL
#define REFLECTIONS_GLSL

#include "environment.glsl"
#include "lights/iterate.glsl"

layout(buffer_reference) buffer reflection_array;
layout(buffer_reference) buffer harmonics_array;

#include "reflections_shared.h"

layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer reflection_array { gpu_reflection at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer harmonics_array { gpu_environment at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer reflections_block { gpu_reflection_set set; };

// In the axes of the box, metres from its centre.
vec3 reflection_place(reflection_array from, uint index, vec3 position) {
    return vec3(dot(from.at[index].rows[0].xyz, position) + from.at[index].rows[0].w, dot(from.at[index].rows[1].xyz, position) + from.at[index].rows[1].w,
                dot(from.at[index].rows[2].xyz, position) + from.at[index].rows[2].w);
}

float reflection_weight(reflection_array from, uint index, vec3 place) {
    vec3 inside = from.at[index].half_size + from.at[index].reach - abs(place);
    return clamp(min(inside.x, min(inside.y, inside.z)) * from.at[index].inverse_blend, 0.0, 1.0);
}

// From where the probe saw what a ray from `position` meets. Of a place outside of the box, which leads on outwards: that place.
vec3 reflection_direction(reflection_array from, uint index, vec3 position, vec3 place, vec3 direction) {
    vec3 d = vec3(dot(from.at[index].rows[0].xyz, direction), dot(from.at[index].rows[1].xyz, direction), dot(from.at[index].rows[2].xyz, direction));
    vec3 ways = (from.at[index].half_size - sign(d) * place) / max(abs(d), vec3(1e-20));
    return position + direction * max(min(ways.x, min(ways.y, ways.z)), 0.0) - from.at[index].capture;
}

vec3 reflection_radiance(reflections_block r, uint index, vec3 position, vec3 place, vec3 direction, float lod) {
    reflection_array from = r.set.reflections;
    vec3 looked = r.set.parallax == 1u ? reflection_direction(from, index, position, place, direction) : direction;
    uint cube = from.at[index].cube, sampler_index = r.set.sampler_index;
    return textureLod(samplerCube(cubes[nonuniformEXT(cube)], samplers[sampler_index]), looked, lod * from.at[index].last_mip * r.set.mip_scale).rgb *
           r.set.diffuse.at[index].unit;
}

struct light_around {
    vec3 mirrored, coat; // by lobes aimed at two directions
    vec3 diffuse;        // what a white diffuse surface reflects
};

light_around light_sum(light_around a, light_around b, float scale) {
    return light_around(a.mirrored + b.mirrored * scale, a.coat + b.coat * scale, a.diffuse + b.diffuse * scale);
}

#ifdef REFLECTIONS_SHOWN // shaders that show probes say what each gives
light_around reflection_light(reflections_block r, uint index, vec3 position, vec3 place, vec3 normal, vec3 direction, float lod, vec3 coat, float coat_lod);
#else
light_around reflection_light(reflections_block r, uint index, vec3 position, vec3 place, vec3 normal, vec3 direction, float lod, vec3 coat, float coat_lod) {
    reflection_array from = r.set.reflections;
    light_around light = light_around(vec3(0.0), vec3(0.0), vec3(0.0));
    if (from.at[index].cube == GPU_REFLECTION_DARK) return light;
    light.mirrored = reflection_radiance(r, index, position, place, direction, lod);
    if (coat_lod >= 0.0) light.coat = reflection_radiance(r, index, position, place, coat, coat_lod);
    gpu_environment around = r.set.diffuse.at[index];
    light.diffuse = environment_harmonics(around, normal);
    return light_sum(light_around(vec3(0.0), vec3(0.0), vec3(0.0)), light, from.at[index].intensity);
}
#endif

light_around outside_light(view_block v, vec3 normal, vec3 direction, float lod, vec3 coat, float coat_lod) {
    if (LIGHTING_ENVIRONMENT)
        return light_around(environment_radiance(v, direction, lod), environment_radiance(v, coat, max(coat_lod, 0.0)), environment_diffuse(v, normal));
    return light_around(ambient_radiance(v, normalize(direction)), ambient_radiance(v, normalize(coat)), ambient_radiance(v, normal));
}

// The probes of a cell, or all of them: `direct`.
struct reflection_cursor {
    uint next, end;
    bool direct;
};

reflection_cursor reflections_begin(view_block v, reflections_block r, vec3 position) {
    light_list_block list = r.set.list;
    reflection_cursor all = reflection_cursor(0u, r.set.count, true);
    uvec2 pixel = uvec2(0u);
    vec3 seen = (v.view.world_to_view * vec4(position, 1.0)).xyz;
    if (uvec2(list) == uvec2(0u) || !seen_on(v, seen, pixel)) return all;
    uvec2 tile = tile_of(list, pixel);
    gpu_cell cell = list.list.cells.at[(slice_of(list, -seen.z) * list.list.tiles_y + tile.y) * list.list.tiles_x + tile.x];
    if (cell.count == GPU_CELL_ALL) return all;
    return reflection_cursor(cell.offset, cell.offset + cell.count, false);
}

// All light from around on a surface at `position` with this normal and light mask. `coat_lod` below 0: no second lobe is asked for.
light_around reflections_gather(view_block v, vec3 position, vec3 normal, uint mask, vec3 direction, float lod, vec3 coat, float coat_lod) {
    reflections_block r = reflections_block(v.view.reflections);
    reflection_array from = r.set.reflections;
    light_list_block list = r.set.list;
    reflection_cursor c = reflections_begin(v, r, position);
    light_around sum = light_around(vec3(0.0), vec3(0.0), vec3(0.0)), ranked = sum; // of the probes of one rank
    float left = 1.0, weights = 0.0;
    uint rank = 0u;
    for (; c.next <= c.end; c.next++) { // the last turn adds up
        bool more = c.next < c.end;
        uint index = 0u, next_rank = 0xffffffffu;
        float weight = 0.0;
        vec3 place = vec3(0.0);
        if (more) {
            index = c.direct ? c.next : list.list.ids.at[c.next];
            place = reflection_place(from, index, position);
            weight = reflection_weight(from, index, place);
            if (LIGHTING_MASKS && (from.at[index].mask & mask) == 0u) weight = 0.0;
            next_rank = from.at[index].rank;
        }
        if (weights > 0.0 && next_rank != rank) {
            float share = min(weights, 1.0);
            sum = light_sum(sum, ranked, left * share / weights);
            left *= 1.0 - share;
            ranked = light_around(vec3(0.0), vec3(0.0), vec3(0.0));
            weights = 0.0;
        }
        rank = next_rank;
        if (weight > 0.0) {
            ranked = light_sum(ranked, reflection_light(r, index, position, place, normal, direction, lod, coat, coat_lod), weight);
            weights += weight;
        }
    }
    if (left > 0.0) sum = light_sum(sum, outside_light(v, normal, direction, lod, coat, coat_lod), left);
    return sum;
}

#endif
