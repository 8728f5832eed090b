#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Gives each sample the radiance of its surface: one fragment for each slot of a pixel, to those of its samples that the slot is for.
#include "passes/shade/deferred_msaa.glsl"

layout(push_constant, scalar) uniform push_block { gpu_deferred_msaa_push push; };
layout(location = 0) flat in uint in_slot;
layout(location = 0) out vec4 out_radiance;

surface surface_of_samples(ivec2 pixel, uint samples, out float view_depth) {
    vec3 point = surface_point(push.view, push.gbuffer, pixel, samples, view_depth);
    return gbuffer_surface(push.gbuffer, pixel, findLSB(samples), (push.view.view.view_to_world * vec4(point, 1.0)).xyz, vec3(0.0));
}

// Of the surfaces shaded here and around, the one that is most like one that this pixel has not shaded: by the chord of the normals, the
// distance from the plane in pixels and the difference of colours, added up.
uint borrowed(ivec2 pixel, uint samples) {
    ivec2 size = ivec2(push.view.view.size);
    float view_depth, best = 1e30;
    surface s = surface_of_samples(pixel, samples, view_depth);
    float width = pixel_width(push.view, view_depth);
    uint found = uint(pixel.y * size.x + pixel.x);
    for (int i = 0; i < 9; i++) {
        ivec2 there = pixel + ivec2(i % 3, i / 3) - 1;
        if (any(lessThan(there, ivec2(0))) || any(greaterThanEqual(there, size))) continue;
        uint index = uint(there.y * size.x + there.x), word = push.surfaces.at[index];
        uint shown = surface_samples(word, widest_surface(word));
        if (shown == 0u) continue;
        float their_depth;
        surface t = surface_of_samples(there, shown, their_depth);
        float unlike = distance(s.normal, t.normal) + abs(dot(s.normal, t.position - s.position)) / (2.0 * width) +
                       length(s.base_color - t.base_color);
        if (!(unlike < best)) continue;
        best = unlike;
        found = index;
    }
    return found;
}

void main() {
    // Helpers beyond the edge of the picture load too, and addresses have no bounds.
    uvec2 size = push.view.view.size, at = min(uvec2(gl_FragCoord.xy), size - 1u);
    uint pixels = size.x * size.y, index = at.y * size.x + at.x;
    uint word = push.surfaces.at[index], samples, result = index + in_slot * pixels;
    if (METHOD == MSAA_COMPACT || METHOD == MSAA_AGGREGATE || METHOD == MSAA_COVERAGE) {
        samples = surface_samples(word, in_slot);
        if (METHOD != MSAA_COVERAGE && in_slot > 0u) result = pixels + push.sums.at[index] + in_slot - 1u;
    } else if (METHOD == MSAA_ALL || surface_is_edge(word)) {
        samples = surface_of(word, in_slot) == SURFACE_NONE ? 0u : 1u << in_slot;
    } else {
        samples = in_slot == 0u && surface_of(word, 0u) != SURFACE_NONE ? EVERY_SAMPLE : 0u;
    }
    if (samples == 0u) result = index;
    if (METHOD == MSAA_COVERAGE) result = samples == 0u || in_slot == widest_surface(word) ? index : borrowed(ivec2(at), samples);
    gl_SampleMask[0] = int(samples); // none: sky keeps the background, or the slot is not this pixel's
    out_radiance = vec4(result_at(push.results, result), 1.0);
}
