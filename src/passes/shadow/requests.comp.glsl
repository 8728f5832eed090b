#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// The pages that opaque surfaces need, from their depth. Pixels that are neighbours mostly need the same pages. So a work group takes the lights of its
// 8x8 pixels, then each of those with each quad of 2x2 pixels; at either step it leaves out what does not reach, and what has been asked for
// whatever page of it the pixels need. Single pixels ask for the rest.
#include "passes/shadow/requests_box.glsl"
#include "passes/shadow/requests_shared.h"

layout(local_size_x = 64) in;
layout(constant_id = 1) const uint SAMPLES = 1u;
layout(push_constant, scalar) uniform push_block { gpu_shadow_requests_push push; };

#define POINTS_KEPT
#include "passes/shadow/requests_group.glsl"

const uint SHARE = 16u; // lights whose quads are taken at once
shared uint lights[GROUP], light_count;       // that are left of a batch
shared uint pairs[SHARE * QUADS], pair_count; // of them with a quad: light * QUADS + quad

bool is_reached(uint light, request_box box) {
    return light_casts(lights_of(push.lighting), light) && shadow_has_map(request_shape(push.lighting, light)) &&
           request_box_reached(box, push.lighting.scope.lights.lights.at[light].shape);
}

bool is_missing(uint light, request_box box) {
    // What filters look up besides is not known of boxes.
    return LIGHTING_FILTERED && push.lighting.scope.view.view.frame.frame.shadow_filter == GPU_SHADOW_FILTER_PCSS ||
           !request_box_made(push.wanted, request_row(push.lighting, light), request_shape(push.lighting, light), box);
}

// Pixels of the group that a light may reach, by quads.
void weigh(uint light) {
    uint pixels = 0u;
    for (uint quad = 0u; quad < QUADS; quad++) {
        request_box box = box_of_quad(quad);
        if (!is_empty(box) && request_box_reached(box, push.lighting.scope.lights.lights.at[light].shape)) pixels += 4u;
    }
    request_weigh(push.lighting, push.wanted, request_row(push.lighting, light), pixels);
}

// `box`: that of the only quad whose pairs the thread finds.
void find_pairs(uint first, request_box box) {
    uint count = is_empty(box) ? 0u : min(SHARE, light_count - first) * QUADS;
    for (uint i = gl_LocalInvocationIndex; i < count; i += GROUP) {
        uint light = lights[first + i / QUADS];
        if (is_reached(light, box) && is_missing(light, box)) pairs[atomicAdd(pair_count, 1u)] = light * QUADS + i % QUADS;
    }
}

// Of a single pixel of a quad.
void ask(uint light, uint quad, uint k) {
#ifdef COUNT // for the test: how often, behind the last row
    atomicAdd(push.wanted.at[push.lighting.scope.list.list.local_count * SHADOW_ROW_WORDS], 1u);
#endif
    if (SAMPLES == 1u) {
        vec4 point = pixel_points[quad * 4u + k];
        if (point.w > 0.0) request_of_light(push.lighting, push.wanted, light, point.xyz, point.w);
        return;
    }
    uvec2 pixel = pixel_of_quad(quad, k);
    uint samples = samples_of(pixel);
    float last = 0.0;
    for (uint s = 0u; s < samples; s++) {
        vec3 position;
        if (sample_position(pixel, s, last, position)) request_of_light(push.lighting, push.wanted, light, position, shadow_slack(push.lighting, position));
    }
}

void ask_suns(uvec2 pixel) {
    uint samples = push.lighting.scope.lights.directional_count > 0u ? samples_of(pixel) : 0u;
    float last = 0.0;
    for (uint s = 0u; s < samples; s++) {
        vec3 position;
        if (sample_position(pixel, s, last, position)) request_suns(push.lighting, push.wanted, position, shadow_slack(push.lighting, position));
    }
}

void main() {
    lighting_block l = push.lighting;
    uint thread = gl_LocalInvocationIndex;
    ask_suns(pixel_of_quad(thread / 4u, thread % 4u));
    find_boxes();
    request_box whole = box_of(group_parts);
    if (is_empty(whole)) return;
    request_box own = box_of_quad(thread % QUADS); // GROUP is a multiple of QUADS
    uint next = 0u, end = l.scope.list.list.local_count;
    bool is_direct = true;
    if (LIST_KIND == GPU_LIST_TILES) {
        uvec2 tile = tile_of(list_of(l), gl_WorkGroupID.xy * 8u);
        gpu_cell cell = l.scope.list.list.cells.at[tile.y * l.scope.list.list.tiles_x + tile.x];
        is_direct = cell.count == GPU_CELL_ALL;
        if (!is_direct) {
            next = cell.offset;
            end = next + cell.count;
        }
    }
    for (; next < end; next += GROUP) {
        if (thread == 0u) light_count = 0u;
        barrier();
        if (next + thread < end) {
            uint light = l.scope.lights.directional_count + (is_direct ? next + thread : l.scope.list.list.ids.at[next + thread]);
            if (is_reached(light, whole)) {
                if (SHADOW_WEIGHS != 0u) weigh(light);
                if (is_missing(light, whole)) lights[atomicAdd(light_count, 1u)] = light;
            }
        }
        barrier();
        for (uint first = 0u; first < light_count; first += SHARE) {
            if (thread == 0u) pair_count = 0u;
            barrier();
            find_pairs(first, own);
            barrier();
            for (uint i = thread; i < pair_count * 4u; i += GROUP) {
                uint pair = pairs[i / 4u];
                ask(pair / QUADS, pair % QUADS, i % 4u);
            }
            barrier();
        }
        barrier();
    }
}
