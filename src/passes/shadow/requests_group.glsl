// SPDX-License-Identifier: MIT
// The boxes round the surfaces that depth shows in a work group's 8x8 pixels, and in each of its quads of 2x2 pixels. The shader's push constants
// have a `list`, of whose view the depth is, and `depth`, a sampled index.
#ifndef SHADOW_REQUESTS_GROUP_GLSL
#define SHADOW_REQUESTS_GROUP_GLSL

#include "passes/shadow/requests_box.glsl"

const uint GROUP = 64u, QUADS = 16u;
// Boxes as numbers of which the least is taken: low, -high, -near, fine, -wide.
const uint PARTS = 9u;
const float NOTHING = 3e38;
shared float quad_parts[QUADS * PARTS], group_parts[PARTS];
#ifdef POINTS_KEPT
shared vec4 pixel_points[GROUP]; // with one sample, by quads: the point that a pixel shows, and its shadow_slack(); 0: sky
#endif

void keep_point(uint place, vec3 position, float near) {
#ifdef POINTS_KEPT
    if (SAMPLES == 1u) pixel_points[place] = vec4(position, near);
#endif
}

request_box box_of(float p[PARTS]) {
    request_box box;
    box.near = -p[6];
    box.low = vec3(p[0], p[1], p[2]) - 0.1 * box.near; // well above what positions are rounded by
    box.high = -vec3(p[3], p[4], p[5]) + 0.1 * box.near;
    box.fine = p[7] * 0.9999;
    box.wide = -p[8] * 1.0001;
    box.widest = shadow_maps_block(push.lighting.scope.shadows.maps).maps.widest;
    return box;
}
bool is_empty(request_box box) { return !(box.near > 0.0); }

request_box box_of_quad(uint quad) {
    float p[PARTS];
    for (uint i = 0u; i < PARTS; i++) p[i] = quad_parts[quad * PARTS + i];
    return box_of(p);
}

uvec2 pixel_of_quad(uint quad, uint k) { return gl_WorkGroupID.xy * 8u + uvec2(quad % 4u, quad / 4u) * 2u + uvec2(k & 1u, k >> 1u); }

uint samples_of(uvec2 pixel) { return all(lessThan(pixel, push.lighting.scope.view.view.size)) ? SAMPLES : 0u; }

// False: sky, or the depth of the last sample.
bool sample_position(uvec2 pixel, uint s, inout float last, out vec3 position) {
    view_block v = push.lighting.scope.view;
    float depth = SAMPLES > 1u ? texelFetch(textures_multisampled[push.depth], ivec2(pixel), int(s)).r
                               : texelFetch(textures[push.depth], ivec2(pixel), 0).r;
    position = vec3(0.0);
    if (!(depth > 0.0) || depth == last) return false;
    last = depth;
    vec3 seen = view_position_of(v, ndc_of_pixel(v, vec2(pixel) + 0.5), view_depth_of(v, depth));
    position = (v.view.view_to_world * vec4(seen, 1.0)).xyz;
    return true;
}

// Of quads, then of the group.
void find_boxes() {
    view_block v = push.lighting.scope.view;
    uint thread = gl_LocalInvocationIndex;
    if (thread < QUADS) {
        float p[PARTS];
        for (uint i = 0u; i < PARTS; i++) p[i] = NOTHING;
        for (uint k = 0u; k < 4u; k++) {
            uvec2 pixel = pixel_of_quad(thread, k);
            uint samples = samples_of(pixel);
            float last = 0.0;
            keep_point(thread * 4u + k, vec3(0.0), 0.0);
            for (uint s = 0u; s < samples; s++) {
                vec3 position;
                if (!sample_position(pixel, s, last, position)) continue;
                float width = pixel_width(v, length(v.view.eye - position)), near = shadow_slack(push.lighting, position);
                keep_point(thread * 4u + k, position, near);
                for (int i = 0; i < 3; i++) {
                    p[i] = min(p[i], position[i]);
                    p[3 + i] = min(p[3 + i], -position[i]);
                }
                p[6] = min(p[6], -near);
                p[7] = min(p[7], width);
                p[8] = min(p[8], -width);
            }
        }
        for (uint i = 0u; i < PARTS; i++) quad_parts[thread * PARTS + i] = p[i];
    }
    barrier();
    if (thread < PARTS) {
        float least = NOTHING;
        for (uint i = 0u; i < QUADS; i++) least = min(least, quad_parts[i * PARTS + thread]);
        group_parts[thread] = least;
    }
    barrier();
}

#endif
