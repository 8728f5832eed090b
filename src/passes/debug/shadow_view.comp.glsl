#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Debug views of shadow maps: the page that is looked up for the light that gives most to a pixel, and where maps and rays disagree.
#include "common.glsl"
#include "view.glsl"
#include "passes/debug/shadow_lookup.glsl"
#include "passes/debug/shadow_view_shared.h"
#include "passes/debug/legend.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform push_block { gpu_shadow_view_push push; };

const float SHOWN = 0.02; // part of a pixel's light that has to be wrong

uint mixed(uint x) { // PCG: M. O'Neill, 2014
    x = x * 747796405u + 2891336453u;
    x = ((x >> ((x >> 28u) + 4u)) ^ x) * 277803737u;
    return (x >> 22u) ^ x;
}

vec3 page_color(finding f, float grey) {
    uint number = mixed(f.row * SHADOW_ROW_WORDS * 32u + shadow_bit(f.page.face, f.page.level, f.page.at));
    vec3 hue = clamp(abs(fract(float(number & 0xffffu) / 65536.0 + vec3(0.0, 0.333, 0.667)) * 6.0 - 3.0) - 1.0, 0.0, 1.0);
    vec3 color = mix(vec3(grey), mix(vec3(1.0), hue, 0.5 + 0.5 * float(number >> 16u) / 65535.0), 0.65);
    float edge = min(min(f.inside.x, f.inside.y), float(shadow_page_texels(f.page.level)) - max(f.inside.x, f.inside.y));
    return edge * f.texel < 0.75 ? mix(color, vec3(1.0), 0.6) : color; // pixels
}

// Frames since the page was drawn: brightest in this one, darkest from AGE_MOST on.
const float AGE_MOST = 64.0;
vec3 age_color(gpu_shadow_maps maps, finding f) {
    uint bit = shadow_bit(f.page.face, f.page.level, f.page.at), word = f.row * SHADOW_ROW_WORDS + bit / 32u;
    uint below = uint(bitCount(maps.held.at[word] & (1u << (bit % 32u)) - 1u));
    uint age = maps.pages.at[maps.before.at[word] + below].flags >> SHADOW_AGE_SHIFT;
    return heat(1.0 - log2(float(age) + 1.0) / log2(AGE_MOST));
}

vec3 level_color(uint level) { return heat(1.0 - float(level) / float(SHADOW_LEVELS)); }

vec3 texel_color(float texel) {
    float steps = log2(texel);
    return steps <= 0.0 ? mix(DEBUG_TEXEL_PIXEL(vec3), DEBUG_TEXEL_QUARTER(vec3), min(-0.5 * steps, 1.0))
                        : mix(DEBUG_TEXEL_WIDER(vec3), DEBUG_TEXEL_8(vec3), min(steps / 3.0, 1.0));
}

// The legend of levels in the lower left corner.
bool legend(ivec2 pixel, out vec3 color) {
    ivec2 size = ivec2(push.view.view.size);
    int scale = max(1, size.y / 360), top = size.y - 14 * scale;
    ivec2 p = ivec2(pixel.x, pixel.y - top) / scale;
    if (pixel.y < top || p.x >= 8 * int(SHADOW_LEVELS)) return false;
    color = level_color(uint(p.x / 8));
    if (digit_pixel(uint(p.x / 8), ivec2(p.x % 8 - 3, p.y - 5))) color = luminance(color) > 0.4 ? vec3(0.0) : vec3(1.0);
    return true;
}

// The look-up for a light from outside; false: there is none.
bool look_at_wall(lighting_block l, uint light, shadowed_point p, out gpu_probe probe, out probe_lookup look) {
    if (!LIGHTING_CUBEMAP || p.probe >= p.probes.count) return false;
    probe = p.probes.probes.at[p.probe];
    bool endless = light < l.scope.lights.directional_count;
    vec3 to_light = -l.scope.lights.lights.at[light].shape.direction;
    if (!endless) light_reach(lights_of(l), light, p.position, LIGHT_MASK_ALL, to_light);
    float away = endless ? 1.0 : light_distance(lights_of(l), light, p.position, to_light);
    if (!(dot(p.normal, to_light) > 0.0) || !endless && probe_holds(probe, p.place + probe_turn(probe, to_light) * away)) return false;
    bool parallel = endless || l.scope.lights.lights.at[light].shape.kind == GPU_SHAPE_BOX;
    look = probe_look(probe, p.probes.flags, p.place, probe_turn(probe, to_light), 2.0 * source_size(l, light, parallel) / (parallel ? 1.0 : away), p.pixel);
    return true;
}

vec3 lookup_color(gpu_probe probe, probe_lookup look) {
    vec2 at;
    uint face = cube_face(look.direction, at);
    float side = exp2(floor(log2(float(probe.side)) - look.lod + 0.5));
    uvec2 texel = uvec2((at * 0.5 + 0.5) * side);
    vec3 hue = clamp(abs(fract(float(face) / 6.0 + vec3(0.0, 0.333, 0.667)) * 6.0 - 3.0) - 1.0, 0.0, 1.0);
    return mix(vec3(1.0), hue, 0.75) * (((texel.x ^ texel.y) & 1u) == 0u ? 1.0 : 0.6);
}

// What the lights of a pixel give, in lux.
struct tally {
    float most;           // the one that gives most
    uint brightest;
    float all;            // lights that have maps
    float extra, missing; // of it, what only maps let through, and what only rays do
};

// `high`: metres to the light.
void add_light(inout tally t, lighting_block l, uint light, float lux, shadowed_point p, vec3 to_light, float high) {
    if (push.mode == GPU_DEBUG_SHADOW_RAYS) {
        if (light < l.scope.lights.directional_count || light_reaches(lights_of(l), light, p.position)) light_visibility(l, light, p, to_light, light < l.scope.lights.directional_count);
        return;
    }
    if (!light_casts(lights_of(l), light)) return;
    if (lux > t.most) {
        t.most = lux;
        t.brightest = light;
    }
    if (!(LIGHTING_MAPS || LIGHTING_CUBEMAP) || !LIGHTING_RAYS || !(lux > 0.0)) return;
    t.all += lux;
    float map;
    if (LIGHTING_CUBEMAP)
        map = max_component(light_visibility(l, light, p, to_light, light < l.scope.lights.directional_count));
    else
        map = light < l.scope.lights.directional_count ? sun_map_visibility(l, light, p) : map_visibility(l, light, p);
    if (map < 0.0) return; // rays answer
    float margin = max(p.slack, 1e-6 * length(l.scope.lights.lights.at[light].shape.position));
    float wrong = map - ray_visibility(rays_block(l.scope.shadows.rays), p.position, to_light, high - margin, p.slack);
    t.extra += lux * max(wrong, 0.0);
    t.missing += lux * max(-wrong, 0.0);
}

float surface_grey(vec3 albedo, float up) { return 0.12 + 0.88 * luminance(albedo) * (0.6 + 0.4 * up); }

// The lights of a tile, which is the work group's: those that left its list, and of the others those that give no pixel light, some, and all.
shared uint lit, unlit;
vec3 classes_color(lighting_block l, shadowed_point p, bool is_surface, float grey) {
    uint tile = gl_WorkGroupID.y * l.scope.list.list.tiles_x + gl_WorkGroupID.x;
    uint all = push.classes.at[2u * tile], left = push.classes.at[2u * tile + 1u];
    gpu_cell cell = l.scope.list.list.cells.at[tile];
    uvec3 kinds = uvec3(0u); // dark, some, all
    for (uint i = 0u; i < all - left; i++) {
        if (gl_LocalInvocationIndex == 0u) lit = unlit = 0u;
        barrier();
        if (is_surface) {
            uint light = l.scope.lights.directional_count + l.scope.list.list.ids.at[cell.offset + i];
            vec3 to_light;
            bool open = light_reach(lights_of(l), light, p.position, LIGHT_MASK_ALL, to_light) != vec3(0.0) && light_may_face(lights_of(l), light, p.normal, to_light);
            if (open && light_casts(lights_of(l), light)) open = map_visibility(l, light, p) != 0.0; // -1: rays answer
            if (open) atomicOr(lit, 1u);
            else atomicOr(unlit, 1u);
        }
        barrier();
        if (lit == 0u) kinds.x++;
        else if (unlit != 0u) kinds.y++;
        else kinds.z++;
        barrier();
    }
    if (all == 0u || !is_surface) return vec3(grey * 0.5);
    vec3 sum = float(left) * DEBUG_CLASS_LEFT(vec3) + float(kinds.x) * DEBUG_CLASS_DARK(vec3) + float(kinds.y) * DEBUG_CLASS_SOME(vec3) + float(kinds.z) * DEBUG_CLASS_ALL(vec3);
    return mix(vec3(grey), sum / float(all), 0.8);
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (push.mode == GPU_DEBUG_SHADOW_CLASSES) { // every invocation takes part
        bool inside = all(lessThan(uvec2(pixel), push.view.view.size));
        ivec2 at = min(pixel, ivec2(push.view.view.size) - 1);
        vec4 normal = texelFetch(textures[push.normal], at, 0), position = texelFetch(textures[push.position], at, 0);
        bool is_surface = inside && normal.w > 0.0;
        float grey = is_surface ? surface_grey(texelFetch(textures[push.albedo], at, 0).rgb, normal.y) : 0.0;
        vec3 color = classes_color(push.lighting, shadowed_point_of(push.lighting, position.xyz, normal.xyz), is_surface, grey);
        if (inside) imageStore(images[push.target], pixel, push.swap == 1u ? vec4(color.bgr, 1.0) : vec4(color, 1.0));
        return;
    }
    if (any(greaterThanEqual(uvec2(pixel), push.view.view.size))) return;
    vec4 albedo = texelFetch(textures[push.albedo], pixel, 0), normal = texelFetch(textures[push.normal], pixel, 0),
         position = texelFetch(textures[push.position], pixel, 0);
    bool sky = normal.w <= 0.0;
    float grey = sky ? 0.0 : surface_grey(albedo.rgb, normal.y);
    lighting_block l = push.lighting;
    light_point point = light_point(uvec2(pixel), sky ? 1.0 : normal.w, position.xyz, normal.xyz, uint(position.w) - 1u);
    shadowed_point shadowed = shadowed_point_of(l, position.xyz, normal.xyz);
    tally t = tally(0.0, 0u, 0.0, 0.0, 0.0);
    for (uint i = 0u; i < l.scope.lights.directional_count && !sky; i++) {
        vec3 to_light = -l.scope.lights.lights.at[i].shape.direction;
        add_light(t, l, i, luminance(l.scope.lights.lights.at[i].color) * max(dot(normal.xyz, to_light), 0.0), shadowed, to_light, 1e30);
    }
    light_cursor cursor = lights_begin(list_of(l), point);
    FOR_EACH_LIGHT(list_of(l), cursor, light) {
        vec3 to_light;
        if (sky) break;
        float lux = luminance(light_reach(lights_of(l), light, position.xyz, LIGHT_MASK_ALL, to_light)) * max(dot(normal.xyz, to_light), 0.0);
        add_light(t, l, light, lux, shadowed, to_light, light_distance(lights_of(l), light, position.xyz, to_light));
    }
    vec3 color = vec3(grey * 0.5);
    if (push.mode == GPU_DEBUG_SHADOW_RAYS) {
        if (rays_sent > 0u) color = mix(vec3(grey), heat(count_level(rays_sent)), 0.8);
    } else if (push.mode == GPU_DEBUG_SHADOW_ERRORS) {
        if (t.extra > SHOWN * t.all) color = mix(color, DEBUG_SHADOW_EXTRA(vec3), 0.4 + 0.6 * t.extra / t.all);
        if (t.missing > SHOWN * t.all && t.missing > t.extra) color = mix(vec3(grey * 0.5), DEBUG_SHADOW_MISSING(vec3), 0.4 + 0.6 * t.missing / t.all);
    } else if (push.mode == GPU_DEBUG_PROBE_LOOKUP || push.mode == GPU_DEBUG_PROBE_LEVELS) {
        gpu_probe probe;
        probe_lookup look;
        if (t.most > 0.0 && look_at_wall(l, t.brightest, shadowed, probe, look))
            color = mix(vec3(grey), push.mode == GPU_DEBUG_PROBE_LOOKUP ? lookup_color(probe, look) : heat(1.0 - look.lod / float(SHADOW_LEVELS)), 0.8);
    } else if (t.most > 0.0) {
        finding f = look_up(l, t.brightest, shadowed);
        color = DEBUG_SHADOW_RAYS(vec3);
        if (f.found && push.mode == GPU_DEBUG_SHADOW_PAGES) color = page_color(f, grey);
        if (f.found && push.mode == GPU_DEBUG_SHADOW_LEVELS) color = mix(vec3(grey), level_color(f.page.level), 0.8);
        if (f.found && push.mode == GPU_DEBUG_SHADOW_AGE) {
            color = mix(vec3(grey), age_color(shadowed.maps, f), 0.8);
            if (!f.asked && ((pixel.x + pixel.y) & 7) < 2) color = DEBUG_SHADOW_RAYS(vec3);
        }
        if (f.found && push.mode == GPU_DEBUG_SHADOW_TEXELS) color = mix(vec3(grey), texel_color(f.texel), 0.8);
    }
    vec3 key;
    if (push.mode == GPU_DEBUG_SHADOW_RAYS && count_legend(pixel, ivec2(push.view.view.size), key)) color = key;
    if ((push.mode == GPU_DEBUG_SHADOW_LEVELS || push.mode == GPU_DEBUG_PROBE_LEVELS) && legend(pixel, key)) color = key;
    imageStore(images[push.target], pixel, push.swap == 1u ? vec4(color.bgr, 1.0) : vec4(color, 1.0));
}
