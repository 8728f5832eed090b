// SPDX-License-Identifier: MIT
// Shadows that the walls of a room cast into it from lights outside: cubemap_shared.h.
#ifndef SHADOWS_CUBEMAP_GLSL
#define SHADOWS_CUBEMAP_GLSL

#include "shadows/cube.glsl"
#include "shadows/sources.glsl"

layout(buffer_reference) buffer probe_array;
#include "shadows/cubemap_shared.h"
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer probe_array { gpu_probe at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer probes_block { gpu_probes probes; };

vec3 probe_place(gpu_probe p, vec3 position) {
    vec4 h = vec4(position, 1.0);
    return vec3(dot(p.rows[0], h), dot(p.rows[1], h), dot(p.rows[2], h));
}

vec3 probe_turn(gpu_probe p, vec3 d) { return vec3(dot(p.rows[0].xyz, d), dot(p.rows[1].xyz, d), dot(p.rows[2].xyz, d)); }

bool probe_holds(gpu_probe p, vec3 place) { return all(lessThanEqual(abs(place), p.half_size + p.wall)); }

// The first probe from `k` on in whose box, or in whose walls, a point is; or the number of probes.
uint probe_find(gpu_probes all_probes, uint k, vec3 position) {
    while (k < all_probes.count && !probe_holds(all_probes.probes.at[k], probe_place(all_probes.probes.at[k], position))) k++;
    return k;
}

// What counts of a probe at a point that it holds, beside that of another one: it falls to next to nothing where the walls end. Faces that both share leave
// the ratio alone.
float probe_weight(gpu_probe p, vec3 place) {
    vec3 depth = max(p.half_size + p.wall - abs(place), 1e-4); // metres; on faces it is rounded
    return depth.x * depth.y * depth.z;
}

// One look-up.
struct probe_lookup {
    vec3 direction;
    float distance; // metres to where the ray leaves the box
    float lod;
};

// Of a point `from` of the box, in its space; `along` is unit. `spread`: by how many metres for each metre of distance the light's disk moves what it shines
// through, its diameter over its distance; `pixel`: width of a pixel there, metres.
//
// Blur of level n and the filter between its texels have a variance of (4^n - 1) / 4 + 4^n / 6 texels squared (cubemap_mip.comp.glsl), a disk of diameter w
// one of w^2 / 16: the level is where both are equal.
probe_lookup probe_look(gpu_probe p, uint flags, vec3 from, vec3 along, float spread, float pixel) {
    probe_lookup look;
    vec3 inside = clamp(from, -p.half_size, p.half_size);
    look.distance = max(box_exit(inside, along, p.half_size), 0.0);
    look.direction = inside + along * look.distance - p.capture;
    float texel = 2.0 * max_component(abs(look.direction)) / float(p.side);
    if ((flags & PROBES_CORRECT) == 0u) look.direction = along;
    float width = spread * look.distance / texel;
    look.lod = (flags & PROBES_PHYSICAL) != 0u ? 0.5 * log2(0.15 * width * width + 0.6) : look.distance * p.softness;
    look.lod = max(look.lod, log2(pixel / texel));
    look.lod = clamp(look.lod, 0.0, log2(float(p.side)));
    return look;
}

// What comes in.
vec3 probe_light(gpu_probes all_probes, gpu_probe p, probe_lookup look) {
    vec4 open = textureLod(samplerCube(cubes[nonuniformEXT(p.image)], samplers[all_probes.smooth_sampler]), look.direction, look.lod);
    return (all_probes.flags & PROBES_TINT) != 0u ? open.rgb : open.aaa;
}

#endif
