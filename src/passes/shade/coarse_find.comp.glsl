#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Decides for each block whether its pixels are alike.
#include "common.glsl"
#include "view.glsl"
#include "lights/iterate.glsl"
#include "passes/shade/coarse.glsl"

layout(constant_id = COARSE_FIND_ID) const uint CRITERION = COARSE_CRITERION_Z;

// The least and greatest of a single-channel image over the block.
vec2 range_of(uint image, ivec2 first) {
    vec2 range = vec2(1e38, -1e38);
    if ((FLAGS & COARSE_SAMPLERS) != 0u) {
        for (uint i = 0u; i < SIZE * SIZE / 4u; i++) { // between four texels each
            ivec2 corner = first + 2 * ivec2(i % max(SIZE / 2u, 1u), i / max(SIZE / 2u, 1u)) + 1;
            vec2 at = vec2(min(corner, coarse_last() + 1)) * push.gbuffer.view.view.inverse_size;
            range.x = min(range.x, textureLod(sampler2D(textures[image], samplers[push.settings.settings.least]), at, 0.0).r);
            range.y = max(range.y, textureLod(sampler2D(textures[image], samplers[push.settings.settings.greatest]), at, 0.0).r);
        }
        return range;
    }
    for (uint i = 0u; i < SIZE * SIZE; i++) {
        float value = texelFetch(textures[image], min(first + ivec2(i % SIZE, i / SIZE), coarse_last()), 0).r;
        range = vec2(min(range.x, value), max(range.y, value));
    }
    return range;
}

// The same of depth, and the first pixel's; `pixels` and `quads` are how many of the picture show a surface.
vec2 depths_of(ivec2 first, out float depth, out uint pixels, out uint quads) {
    quads = 0u;
    if (SIZE == 1u) {
        depth = gbuffer_depth(push.gbuffer, first);
        pixels = uint(depth > 0.0);
        return vec2(depth);
    }
    vec2 range = vec2(1e38, -1e38);
    pixels = 0u;
    for (uint i = 0u; i < SIZE * SIZE / 4u; i++) { // four at once
        ivec2 corner = first + 2 * ivec2(i % max(SIZE / 2u, 1u), i / max(SIZE / 2u, 1u)) + 1;
        vec2 at = vec2(min(corner, coarse_last() + 1)) * push.gbuffer.view.view.inverse_size;
        vec4 d = textureGather(sampler2D(textures[push.gbuffer.depth], samplers[push.settings.settings.point]), at);
        if (i == 0u) depth = d.w;
        range = vec2(min(range.x, min(min(d.x, d.y), min(d.z, d.w))), max(range.y, max(max(d.x, d.y), max(d.z, d.w))));
        // The texels round the corner: left below it, right below, right above, left above.
        bvec4 shown = greaterThan(d, vec4(0.0));
        bvec2 far = lessThanEqual(corner, coarse_last()), near = lessThanEqual(corner - 1, coarse_last());
        uint inside = uint(shown.w && near.x && near.y) + uint(shown.z && far.x && near.y) + uint(shown.y && far.x && far.y) +
                      uint(shown.x && near.x && far.y);
        pixels += inside;
        quads += uint(inside > 0u);
    }
    return range;
}

// The greatest squared distance of two normals in a box of azimuth and height. With heights h and distances r from the axis,
// |a - b|^2 = (h_a - h_b)^2 + (r_a - r_b)^2 + 2 r_a r_b (1 - cos d), and 2 (1 - cos d) <= d^2.
float chord2_of(vec2 azimuth, vec2 height) {
    vec2 r = sqrt(max(1.0 - height * height, vec2(0.0)));
    float high = height.x * height.y <= 0.0 ? 1.0 : max(r.x, r.y), turn = (azimuth.y - azimuth.x) * high;
    float up = height.y - height.x, out_of = high - min(r.x, r.y);
    return up * up + out_of * out_of + turn * turn;
}

struct material_numbers {
    vec3 normal, color;
    vec4 f0;   // roots of F0, F90
    vec3 rest; // roughness, metalness, occlusion
};
material_numbers material_at(ivec2 pixel) {
    material_numbers m;
    vec4 stored = texelFetch(textures[push.gbuffer.targets[1]], pixel, 0);
    m.normal = octahedral_decode(stored.xy * 2.0 - 1.0);
    m.rest = vec3(stored.z, gbuffer_split(stored.w));
    m.color = vec3(0.0);
    if ((FLAGS & COARSE_ALBEDO) != 0u) m.color = color_at(pixel);
    m.f0 = texelFetch(textures[push.gbuffer.targets[2]], pixel, 0);
    return m;
}

float greatest_of(vec4 v) { return max(max(v.x, v.y), max(v.z, v.w)); }

// What rounding makes of the view depths of one plane that faces the viewer.
float precision_of(float view_depth) {
    return 5e-7 * (push.gbuffer.view.view.orthographic > 0.5 ? push.gbuffer.view.view.depth_decode.x : view_depth);
}

// Whether depths, or triangles, say that the block shows one surface.
bool is_one_surface(ivec2 first, float depth, vec2 depths) {
    view_block v = push.gbuffer.view;
    bool same = depths.x > 0.0;
    if (CRITERION == COARSE_CRITERION_ID) {
        uvec2 id = texelFetch(textures_uint[push.geometry], first, 0).rg;
        for (uint i = 1u; i < SIZE * SIZE; i++)
            same = same && texelFetch(textures_uint[push.geometry], min(first + ivec2(i % SIZE, i / SIZE), coarse_last()), 0).rg == id;
        return same;
    }
    float view_depth = view_depth_of(v, depth);
    float gradient = imageLoad(images[push.target], first).a * view_depth; // as the G-buffer pass left it
    float bound = push.settings.settings.depth_bound * gradient + precision_of(view_depth);
    if (CRITERION == COARSE_CRITERION_MINMAX) depths = range_of(push.gbuffer.depth, first);
    float nearest = view_depth_of(v, depths.y), farthest = view_depth_of(v, depths.x); // depth is reversed
    float away = CRITERION == COARSE_CRITERION_MINMAX ? farthest - nearest : max(farthest - view_depth, view_depth - nearest);
    return same && away <= bound;
}

// By the angle between the block's middle and where the viewer looks.
uint kind_by_angle(ivec2 first) {
    vec3 to = view_position_of(push.gbuffer.view, ndc_of_pixel(push.gbuffer.view, vec2(first) + 0.5 * float(SIZE)), 1.0);
    float cosine = dot(normalize(to), push.settings.settings.gaze);
    if (cosine >= push.settings.settings.fovea) return COARSE_EACH;
    return SIZE == 4u && cosine >= push.settings.settings.fovea_far ? COARSE_HALF : COARSE_SHARED;
}

// Pixels beyond the edge of the picture are those at its edge: the same block's. `pixels` and `quads` are how many show a surface.
uint kind_of(ivec2 first, out uint pixels, out uint quads) {
    gpu_coarse_settings settings = push.settings.settings;
    float depth;
    vec2 depths = depths_of(first, depth, pixels, quads);
    if (pixels == 0u) return COARSE_NOTHING;
    if (SIZE == 1u) return COARSE_SHARED;
    if (COARSE_IS_FOVEA) return kind_by_angle(first);
    if (!is_one_surface(first, depth, depths)) return COARSE_DEPTH;
    material_numbers reference = material_at(first);
    float chord2 = 0.0, color = 0.0, other = 0.0;
    for (uint i = 1u; i < SIZE * SIZE; i++) {
        material_numbers m = material_at(min(first + ivec2(i % SIZE, i / SIZE), coarse_last()));
        vec3 turn = m.normal - reference.normal;
        chord2 = max(chord2, dot(turn, turn));
        color = max(color, max_component(abs(m.color - reference.color)));
        other = max(other, max(greatest_of(abs(m.f0 - reference.f0)), max_component(abs(m.rest - reference.rest))));
    }
    if (CRITERION == COARSE_CRITERION_MINMAX) chord2 = chord2_of(range_of(push.azimuth, first), range_of(push.height, first));
    if (!(chord2 <= settings.normal_chord * settings.normal_chord)) return COARSE_NORMAL;
    if (!(color <= settings.albedo_tolerance) || !(other <= settings.tolerance)) return COARSE_OTHER;
    return COARSE_SHARED;
}

void main() {
    uint pixels = 0u, quads = 0u, kind = COARSE_NOTHING;
    ivec2 first = coarse_first(gl_LocalInvocationIndex);
    if (coarse_inside(first)) kind = kind_of(first, pixels, quads);
    push.blocks.at[coarse_base() + gl_LocalInvocationIndex] = kind | pixels << COARSE_WORD_PIXELS_SHIFT | max(quads, 1u) - 1u << COARSE_WORD_QUADS_SHIFT;
    if ((FLAGS & COARSE_WORDS) != 0u && kind != COARSE_NOTHING)
        for (uint i = 0u; i < SIZE * SIZE; i++) {
            ivec2 at = first + ivec2(i % SIZE, i / SIZE);
            if (coarse_inside(at) && gbuffer_depth(push.gbuffer, at) > 0.0)
                push.words.at[uint(at.y) * push.gbuffer.view.view.size.x + uint(at.x)] = kind;
        }
}
