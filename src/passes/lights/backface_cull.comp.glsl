#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Finds the cone that holds the normals of a tile, and takes the lights behind all of its surfaces out of the tile's counts. Lights that are
// not even behind four pixels of the tile cannot be such; where hardly one is, its normals are not looked at.
#include "common.glsl"
#include "passes/lights/backface.glsl"

layout(local_size_x = 64) in; // one group a picked tile
layout(push_constant, scalar) uniform push_block { gpu_cells_push push; };

#include "passes/lights/cells_takes.glsl"
#include "passes/lights/cells_marks.glsl"

const uint PROBES = 4u, LISTED = 448u; // with more than 2048 bytes of shared memory fewer groups run at a time

shared uint taken_count, candidate_count, dropped_count, lowest;
shared uint taken[LISTED]; // numbers of lights in view, in any order: they are counted only
shared int sums[3];
shared vec3 sample_positions[PROBES], sample_normals[PROBES];

vec3 normal_at(uvec2 pixel) {
    return gbuffer_normal(BACKFACE.gbuffer, ivec2(pixel));
}

const bool KEPT = (FLAGS & CELLS_KEPT) != 0u;

// The lights of 32 in view that the tile takes; or those that cell_takes() has to be asked for.
uint tile_word(uint cell, uint w, uint visible) {
    return KEPT ? push.marks.at[cells_kept_at(cell, w)] : cells_marked(cells_marks_of(cell), w, visible);
}

// The light with this number of those in view.
light_source source_of(uint i) { return light_source_of(push.list, push.visible_ids.at[i]); }

// Whether it is behind the sampled pixels. Sky, whose normal is 0, has everything behind it.
bool is_candidate(uint i) {
    light_source s = source_of(i);
    bool candidate = true;
    for (uint k = 0u; k < PROBES; k++) {
        vec3 from = s.parallel ? vec3(0.0) : sample_positions[k];
        candidate = candidate && dot(sample_normals[k], s.first - from) <= 0.0 && dot(sample_normals[k], s.last - from) <= 0.0;
    }
    return candidate;
}

vec3 axis_of(uint cell, uvec2 first, uvec2 end, uint tile_size) {
    uint kind = BACKFACE.axis;
    if (kind == BACKFACE_AXIS_SAMPLES) {
        vec3 sum = vec3(0.0);
        for (uint k = 0u; k < PROBES; k++) sum += sample_normals[k];
        return sum;
    }
    if (kind == BACKFACE_AXIS_PYRAMID) return BACKFACE.axes.at[cell];
    // A sum in whole numbers does not depend on the order.
    uint thread = gl_LocalInvocationIndex;
    if (thread < 3u) sums[thread] = 0;
    barrier();
    ivec3 sum = ivec3(0);
    for (uint p = thread; p < tile_size * tile_size; p += 64u) {
        uvec2 pixel = first + uvec2(p % tile_size, p / tile_size);
        if (all(lessThan(pixel, end)) && texelFetch(textures[push.depth], ivec2(pixel), 0).r > 0.0)
            sum += ivec3(round(normal_at(pixel) * 256.0));
    }
    for (int k = 0; k < 3; k++) atomicAdd(sums[k], sum[k]);
    barrier();
    return vec3(sums[0], sums[1], sums[2]);
}

void main() {
    uint thread = gl_LocalInvocationIndex, pick = gl_WorkGroupID.y * BACKFACE_ROW + gl_WorkGroupID.x;
    if (pick >= BACKFACE.picks.at[3]) return;
    uint cell = BACKFACE.picks.at[4u + pick], first_sum = cell * push.chunk_count, tile_size = push.list.list.tile_size;
    uvec2 first = uvec2(cell % push.list.list.tiles_x, cell / push.list.list.tiles_x) * tile_size;
    uvec2 end = min(first + tile_size, push.view.view.size);
    uint visible = push.visible_sums.at[push.list.list.local_count];
    if (thread == 0u) {
        taken_count = candidate_count = dropped_count = 0u;
        lowest = floatBitsToUint(1.0);
    }
    if (thread < PROBES) {
        uvec2 pixel = min(first + uvec2((thread & 1u) * 2u + 1u, (thread >> 1) * 2u + 1u) * tile_size / 4u, end - 1u);
        float depth = texelFetch(textures[push.depth], ivec2(pixel), 0).r;
        sample_normals[thread] = depth > 0.0 ? normal_at(pixel) : vec3(0.0);
        vec3 seen = view_position_of(push.view, ndc_of_pixel(push.view, vec2(pixel) + 0.5), view_depth_of(push.view, depth));
        sample_positions[thread] = depth > 0.0 ? (push.view.view.view_to_world * vec4(seen, 1.0)).xyz : vec3(0.0);
    }
    barrier();

    gpu_cell_bounds bounds = push.cells.at[cell];
    uint end_word = cell_is_empty(bounds) ? 0u : cells_end_word(visible);
    for (uint w = thread; w < end_word; w += 64u)
        for (uint bits = tile_word(cell, w, visible); bits != 0u; bits &= bits - 1u) {
            uint i = w * 32u + uint(findLSB(bits));
            if (!KEPT && !cell_takes(bounds, i)) continue;
            uint slot = atomicAdd(taken_count, 1u);
            if (slot < LISTED) taken[slot] = i;
        }
    barrier();
    bool listed = taken_count <= LISTED;
    uint past = listed ? taken_count : end_word; // the end of what is looked at again: lights, or words of them
    uint candidates = 0u;
    for (uint n = thread; n < past; n += 64u)
        for (uint bits = listed ? 1u : tile_word(cell, n, visible); bits != 0u; bits &= bits - 1u) {
            uint i = listed ? taken[n] : n * 32u + uint(findLSB(bits));
            if ((listed || KEPT || cell_takes(bounds, i)) && is_candidate(i)) candidates++;
        }
    if (candidates != 0u) atomicAdd(candidate_count, candidates);
    barrier();
    bool drops = taken_count >= BACKFACE.least && 3u * candidate_count >= BACKFACE.least;
    if (!drops && BACKFACE.every_tile == 0u) return;

    gpu_cone cone = gpu_cone(vec3(0.0), BACKFACE_WIDE, 0u, drops ? 0u : 1u);
    cone.axis = axis_of(cell, first, end, tile_size);
    float axis2 = dot(cone.axis, cone.axis);
    cone.axis = axis2 > 0.0 ? cone.axis * inversesqrt(axis2) : vec3(0.0);

    // The widest angle. Cosines below 0 make a cone that nothing is behind of: they count as 0, and as such order like their bits.
    uint low = floatBitsToUint(1.0);
    for (uint p = thread; p < tile_size * tile_size; p += 64u) {
        uvec2 pixel = first + uvec2(p % tile_size, p / tile_size);
        if (all(lessThan(pixel, end)) && texelFetch(textures[push.depth], ivec2(pixel), 0).r > 0.0) {
            float cosine = dot(cone.axis, normal_at(pixel));
            low = min(low, cosine > 0.0 ? floatBitsToUint(cosine) : 0u); // NaN is 0
        }
    }
    atomicMin(lowest, low);
    barrier();
    float cosine = uintBitsToFloat(lowest) - 4e-7;
    cone.sine = cosine > 0.0 ? sqrt(max(1.0 - cosine * cosine, 0.0)) : BACKFACE_WIDE;

    if (cone.sine < 1.0) {
        backface_tile tile = backface_tile_at(push.view, push.list, bounds, cell, cone.axis, cone.sine);
        for (uint n = thread; n < past; n += 64u)
            for (uint bits = listed ? 1u : tile_word(cell, n, visible); bits != 0u; bits &= bits - 1u) {
                uint i = listed ? taken[n] : n * 32u + uint(findLSB(bits));
                if (!listed && !KEPT && !cell_takes(bounds, i)) continue;
                if (!light_is_behind(tile, source_of(i)) || !drops) continue;
                atomicAdd(push.sums.at[first_sum + i / push.chunk_size], 0xffffffffu); // one less
                atomicAdd(dropped_count, 1u);
            }
        barrier();
        cone.dropped = dropped_count;
    }
    if (thread == 0u) BACKFACE.cones.at[cell] = cone;
}
