#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// The surface of a pixel, and every light that reaches it: one work group. Each thread walks the whole list and evaluates the lights whose index has its
// remainder, so that sums do not depend on what else is in the list.
#include "common.glsl"
#include "shade.glsl"
#include "passes/debug/shadow_lookup.glsl"
#include "passes/debug/inspect.glsl"

layout(local_size_x = int(INSPECT_GROUP)) in;
layout(push_constant, scalar) uniform push_block { gpu_inspect_push push; };

shared vec3 sums[INSPECT_GROUP];
shared uint total, reaching, contributing, told;
shared uint histogram[256];
shared uint left;      // lights that are still to be chosen
shared uvec2 threshold; // what is known of the key of the last that is chosen

vec4 target(uint i) { return texelFetch(textures[push.targets[i]], ivec2(push.pixel & 1u), 0); }
vec4 layer(uint i) { return texelFetch(textures[push.layers[i]], ivec2(push.pixel & 1u), 0); }

surface read_surface(uint flags) {
    surface s;
    s.position = target(0u).xyz;
    s.normal = target(1u).xyz;
    s.geometric = target(6u).xyz;
    s.base_color = target(2u).rgb;
    s.roughness = target(2u).a;
    s.dielectric_f0 = target(3u).rgb;
    s.dielectric_f90 = target(3u).a;
    s.emissive = target(4u).rgb;
    s.metallic = target(4u).a;
    s.occlusion = target(5u).x;
    s.alpha = 1.0;
    s.light_mask = uint(target(5u).z);
    s.layered = LIGHTING_LAYERS && (flags & INSPECT_LAYERED) != 0u;
    if (s.layered) {
        vec4 vectors[SURFACE_LAYERS_VECTORS];
        for (uint i = 0u; i < SURFACE_LAYERS_VECTORS; i++) vectors[i] = layer(i);
        s.layers = layers_unpack(vectors);
    }
    return s;
}

// Of the room that holds the point, as cubemap_visibility() asks.
bool is_outside(uint light, shadowed_point p, vec3 to_light) {
    if (p.probe >= p.probes.count) return false;
    if (light < push.lighting.scope.lights.directional_count) return true;
    gpu_probe probe = p.probes.probes.at[p.probe];
    return !probe_holds(probe, p.place + probe_turn(probe, to_light) * light_distance(lights_of(push.lighting), light, p.position, to_light));
}

// What a light gives; false: nothing, its volume does not hold the surface. `p.normal` says by which side shadows are looked for.
bool evaluate(surface s, layers_view b, uint light, inout shadowed_point p, out gpu_inspect_light g) {
    bool is_sun = light < push.lighting.scope.lights.directional_count;
    vec3 to_light, visible = vec3(1.0), illuminance = sun_reach(lights_of(push.lighting), light, s.light_mask, to_light);
    if (!is_sun) illuminance = light_reach(lights_of(push.lighting), light, s.position, s.light_mask, to_light);
    bool reaches = illuminance != vec3(0.0);
    g.light = light;
    g.shadow = INSPECT_SHADOW_NONE;
    g.listed = 1u;
    if (reaches && LIGHTING_SHADOWED && light_casts(lights_of(push.lighting), light)) {
        p = shadowed_towards(p, s, to_light);
        visible = light_visibility(push.lighting, light, p, to_light, is_sun);
        g.shadow = !light_may_face(lights_of(push.lighting), light, p.normal, to_light) ? INSPECT_SHADOW_BEHIND : LIGHTING_RAYS ? INSPECT_SHADOW_RAYS : INSPECT_SHADOW_NONE;
        if (LIGHTING_CUBEMAP && g.shadow == INSPECT_SHADOW_RAYS && is_outside(light, p, to_light)) g.shadow = INSPECT_SHADOW_CUBEMAP;
    }
    g.visibility = max_component(visible);
    precise vec3 radiance = illuminance * visible * (is_sun ? layers_cos(s, b, to_light) : light_lobes(lights_of(push.lighting), light, s, b, to_light));
    g.radiance = radiance;
    return reaches;
}

// Lights are ordered by it, descending: the most luminance first, and of equal ones the lowest index. No two have the same.
uvec2 key_of(gpu_inspect_light g) {
    float l = luminance(g.radiance);
    return uvec2(l > 0.0 ? floatBitsToUint(l) : 0u, ~g.light);
}

// Byte `i` of a key, the highest first.
uint key_byte(uvec2 key, uint i) { return (i < 4u ? key.x : key.y) >> 8u * (3u - i % 4u) & 0xffu; }
// The bytes before byte `i`, which may be 8.
uvec2 key_head(uvec2 key, uint i) {
    uint bits = 8u * (i % 4u), mask = bits == 0u ? 0u : 0xffffffffu << (32u - bits);
    return i >= 8u ? key : i >= 4u ? uvec2(key.x, key.y & mask) : uvec2(key.x & mask, 0u);
}

void tell(gpu_inspect_light g, shadowed_point p) {
    uint slot = atomicAdd(told, 1u);
    if (slot >= INSPECT_LIGHTS) return;
    g.face = g.level = g.place = 0u;
    g.page = uvec2(0u);
    if (LIGHTING_MAPS && g.shadow != INSPECT_SHADOW_BEHIND && light_casts(lights_of(push.lighting), g.light)) {
        finding f = look_up(push.lighting, g.light, p);
        if (f.found) {
            g.shadow = INSPECT_SHADOW_MAP;
            g.face = f.page.face;
            g.level = f.page.level;
            g.page = f.page.at;
            g.place = f.place;
        }
    }
    push.out_pixel.lights[slot] = g;
}

void store(surface s, uint flags, uint visited, vec3 rest) {
    vec3 lit = vec3(0.0);
    for (uint i = 0u; i < INSPECT_GROUP; i++) lit += sums[i];
    inspected_block o = push.out_pixel;
    o.pixel.position = s.position;
    o.pixel.view_depth = target(1u).w;
    o.pixel.normal = s.normal;
    o.pixel.roughness = s.roughness;
    o.pixel.base_color = s.base_color;
    o.pixel.metallic = s.metallic;
    o.pixel.emission = s.emissive;
    o.pixel.flags = flags;
    o.pixel.lit = lit;
    o.pixel.item = uint(target(0u).w) - 1u;
    o.pixel.rest = rest;
    o.pixel.cell = INSPECT_NONE;
    o.pixel.cell_place = uvec3(0u);
    o.pixel.visited = visited;
    o.pixel.reaching = reaching;
    o.pixel.listed_reaching = 0u;
    o.pixel.contributing = contributing;
    o.pixel.total = total;
    o.pixel.told = min(told, INSPECT_LIGHTS);
}

void main() {
    uint lane = gl_LocalInvocationIndex;
    bool hit = target(0u).w > 0.0;
    if (!hit) {
        if (lane == 0u) push.out_pixel.pixel.flags = 0u;
        return;
    }
    uint flags = INSPECT_HIT | uint(target(5u).y);
    surface s = read_surface(flags);
    vec3 to_view = to_viewer(push.view, s.position);
    layers_view b = layers_prepare(s, push.view, to_view);
    light_point point = light_point(push.pixel, target(1u).w, s.position, s.normal, uint(target(0u).w) - 1u);
    shadowed_point shadowed = shadowed_point_of(push.lighting, s.position, facing_normal(s));
    const uint ALL = 0u, CHOSEN = 9u; // rounds; those between find the threshold, a byte each
    uint visited = 0u, suns = push.lighting.scope.lights.directional_count;
    bool done = false;
    if (lane == 0u) total = reaching = contributing = 0u;
    // Where there is no room for all, lights are counted by the first byte of their keys, then by the next one among those with the byte in which the
    // last that is chosen lies, and so on.
    for (uint round = ALL; round <= CHOSEN && !done; round++) {
        for (uint i = lane; i < 256u; i += INSPECT_GROUP) histogram[i] = 0u;
        if (lane == 0u) told = 0u;
        barrier();
        light_cursor cursor = lights_begin(list_of(push.lighting), point);
        vec3 sum = vec3(0.0);
        bool more = true;
        for (uint turn = 0u; more; turn++) {
            uint light = turn;
            if (turn >= suns) more = lights_next(list_of(push.lighting), cursor, light);
            if (more && round == ALL && turn >= suns) visited++;
            gpu_inspect_light g;
            if (more && light % INSPECT_GROUP == lane && evaluate(s, b, light, shadowed, g)) {
                uvec2 key = key_of(g);
                if (round == ALL) {
                    sum += g.radiance;
                    atomicAdd(total, 1u);
                    if (turn >= suns) atomicAdd(reaching, 1u);
                    if (key.x != 0u) atomicAdd(contributing, 1u);
                    tell(g, shadowed);
                } else if (round == CHOSEN) {
                    if (key.x > threshold.x || key.x == threshold.x && key.y >= threshold.y) tell(g, shadowed);
                } else if (key_head(key, round - 1u) == key_head(threshold, round - 1u)) {
                    atomicAdd(histogram[key_byte(key, round - 1u)], 1u);
                }
            }
        }
        if (round == ALL) sums[lane] = sum;
        barrier();
        done = round == ALL && total <= INSPECT_LIGHTS;
        if (lane == 0u && round == ALL) {
            left = INSPECT_LIGHTS;
            threshold = uvec2(0u);
        }
        if (lane == 0u && round > ALL && round < CHOSEN) {
            uint chosen = 255u;
            for (; chosen > 0u && histogram[chosen] < left; chosen--) left -= histogram[chosen];
            uint shift = 8u * (3u - (round - 1u) % 4u);
            if (round <= 4u) threshold.x |= chosen << shift;
            else threshold.y |= chosen << shift;
        }
        barrier();
    }
    if (lane != 0u) return;
    if (push.counter_stride != 0u) visited = push.counters.at[(push.pixel.y * push.view.view.size.x + push.pixel.x) * push.counter_stride];
    store(s, flags, visited, shade_rest(s, push.view, to_view, vec3(0.0)));
}
