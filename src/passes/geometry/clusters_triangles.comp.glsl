#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Each triangle of a cluster, a work group for each cluster.
#include "passes/geometry/clusters.glsl"

layout(local_size_x = CLUSTERS_GROUP) in;
layout(constant_id = 1) const uint MESHES = 0u;

shared uint kept[CLUSTERS_MASK_WORDS];
shared uint lost[CLUSTERS_REASONS];

uint reason_of(vec4 a, vec4 b, vec4 c, uint flags) {
    float slack = push.params.params.slack;
    vec2 margin = 1.0001 + 4.0 * slack * push.view.view.inverse_size;
    // Half spaces a little beyond the edges of the picture, in clip space: what three corners are out of, all between them is.
    vec2 wa = a.w * margin, wb = b.w * margin, wc = c.w * margin;
    if (a.x < -wa.x && b.x < -wb.x && c.x < -wc.x || a.x > wa.x && b.x > wb.x && c.x > wc.x || a.y < -wa.y && b.y < -wb.y && c.y < -wc.y ||
        a.y > wa.y && b.y > wb.y && c.y > wc.y)
        return CLUSTERS_OUTSIDE;
    // Before the near plane, where depths are above 1.
    if (a.z > a.w * 1.0001 && b.z > b.w * 1.0001 && c.z > c.w * 1.0001) return CLUSTERS_OUTSIDE;
    if (!(a.z <= a.w && b.z <= b.w && c.z <= c.w)) return CLUSTERS_DRAWN; // crosses it
    vec2 p = pixel_of_ndc(a.xy / a.w), q = pixel_of_ndc(b.xy / b.w), r = pixel_of_ndc(c.xy / c.w);
    vec2 low = min(min(p, q), r), high = max(max(p, q), r), error = vec2(slack) + 2e-6 * max(abs(low), abs(high));
    if ((flags & CLUSTERS_BUCKET_DOUBLE_SIDED) == 0u) {
        vec2 u = q - p, v = r - p;
        float twice = u.y * v.x - u.x * v.y; // of the area; positive where it runs counter-clockwise with y up
        float lu = length(u), lv = length(v), e = max(error.x, error.y);
        float doubt = 4.0 * e * (lu + lv) + 8.0 * e * e + 1e-5 * lu * lv;
        if ((flags & CLUSTERS_BUCKET_MIRRORED) != 0u ? twice > doubt : twice < -doubt) return CLUSTERS_BACK;
    }
    return misses_samples(low - error, high + error) ? CLUSTERS_SMALL : CLUSTERS_DRAWN;
}

void main() {
    uint slot = LINEAR_GROUP, thread = gl_LocalInvocationIndex;
    if (slot >= push.totals.totals.slots || push.counts.at[slot] == 0u) return; // the whole group
    if (thread < CLUSTERS_MASK_WORDS) kept[thread] = 0u;
    if (thread < CLUSTERS_REASONS) lost[thread] = 0u;
    barrier();
    uint item_index = push.slots.at[slot], first;
    uint flags = bucket_flags(item_index, first);
    gpu_item item = push.scene.scene.items.at[item_index];
    gpu_primitive primitive = push.scene.scene.primitives.at[item.primitive];
    gpu_instance instance = push.scene.scene.instances.at[item.instance];
    gpu_cluster cluster = push.scene.scene.clusters.at[primitive.first_cluster + slot - push.cluster_sums.at[item_index]];
    for (uint i = thread; i < cluster.triangle_count; i += CLUSTERS_GROUP) {
        uint corner = primitive.first_index + (cluster.first_triangle + i) * 3u;
        vec4 clip[3];
        for (uint k = 0u; k < 3u; k++) {
            int vertex = int(push.indices.at[corner + k]) + primitive.vertex_offset;
            // As geometry.vert.glsl does.
            precise vec3 position = transform_point(instance, push.scene.scene.positions.at[vertex]);
            precise vec4 at = push.view.view.world_to_clip * vec4(position, 1.0);
            clip[k] = at;
        }
        uint reason = reason_of(clip[0], clip[1], clip[2], flags);
        if (reason == CLUSTERS_DRAWN) atomicOr(kept[i >> 5], 1u << (i & 31u));
        else atomicAdd(lost[reason], 1u);
    }
    barrier();
    if (thread < CLUSTERS_MASK_WORDS) push.masks.at[slot * CLUSTERS_MASK_WORDS + thread] = kept[thread];
    if (thread > 0u && thread < CLUSTERS_REASONS) count_reason(thread, lost[thread]);
    if (thread == 0u) {
        uint count = 0u;
        for (uint i = 0u; i < CLUSTERS_MASK_WORDS; i++) count += bitCount(kept[i]);
        if (MESHES != 0u) count_reason(CLUSTERS_DRAWN, count);
        push.counts.at[slot] = MESHES != 0u ? min(count, 1u) : count;
    }
}
