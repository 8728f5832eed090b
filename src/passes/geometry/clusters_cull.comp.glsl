#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Bounding sphere and normal cone of each cluster against the view.
#include "passes/geometry/clusters.glsl"
#include "passes/geometry/stretch.glsl"

layout(local_size_x = 64) in;
layout(constant_id = 0) const uint BY_TRIANGLE = 0u;
layout(constant_id = 1) const uint MESHES = 0u;

// Whether all triangles face away. Rasterisers move vertices a little, which may turn a triangle that is thinner than that: clusters with one
// such are kept (their triangles can be looked at one by one), so the cone is narrowed by SINE and the thinnest triangle must measure more.
bool faces_away(gpu_cluster cluster, gpu_instance instance) {
    const float SINE = 0.1, COSINE = 0.99498744;
    vec3 x = vec3(instance.rows[0].x, instance.rows[1].x, instance.rows[2].x), y = vec3(instance.rows[0].y, instance.rows[1].y, instance.rows[2].y),
         z = vec3(instance.rows[0].z, instance.rows[1].z, instance.rows[2].z), t = vec3(instance.rows[0].w, instance.rows[1].w, instance.rows[2].w);
    float scale2 = dot(x, x), tolerance = scale2 * 1e-3;
    // Angles keep under similarities alone.
    if (!(abs(dot(y, y) - scale2) < tolerance && abs(dot(z, z) - scale2) < tolerance && abs(dot(x, y)) < tolerance && abs(dot(y, z)) < tolerance &&
          abs(dot(z, x)) < tolerance))
        return false;
    float cutoff = cluster.cone_cutoff * COSINE + sqrt(max(1.0 - cluster.cone_cutoff * cluster.cone_cutoff, 0.0)) * SINE;
    float scale = sqrt(scale2), side = push.view.view.ndc_scale.x * push.view.view.ndc_scale.y > 0.0 ? 1.0 : -1.0;
    vec3 center = transform_point(instance, cluster.center);
    float reach; // pixels that a unit across the line of sight takes at least
    bool away;
    if (push.view.view.orthographic > 0.5) {
        vec3 d = -push.view.view.back;
        vec3 local = vec3(dot(x, d), dot(y, d), dot(z, d)) / scale; // the inverse of a similarity, but for its length
        away = dot(local, cluster.cone_axis) * side >= cutoff;
        reach = push.params.params.pixels_per_slope;
    } else {
        vec3 d = push.view.view.eye - t;
        vec3 eye = vec3(dot(x, d), dot(y, d), dot(z, d)) / scale2;
        vec3 to = cluster.center - eye;
        away = dot(to, cluster.cone_axis) * side >= cutoff * length(to) + cluster.radius * 1.001;
        reach = push.params.params.pixels_per_slope / (distance(center, push.view.view.eye) + cluster.radius * scale);
    }
    return away && cluster.thinnest * scale * reach * SINE > 8.0 * push.params.params.slack;
}

uint reason_of(gpu_item item, gpu_primitive primitive, gpu_cluster cluster, uint flags) {
    if (primitive.bind_offset != 0) return CLUSTERS_DRAWN; // deformed: the bounds are those of another pose
    gpu_instance instance = push.scene.scene.instances.at[item.instance];
    vec3 center = transform_point(instance, cluster.center);
    float radius = cluster.radius * stretch(instance);
    for (int i = 0; i < 5; i++) {
        vec4 plane = push.view.view.planes[i];
        if (dot(plane.xyz, center) + plane.w < -radius * 1.0001 - 1e-6 * abs(plane.w)) return CLUSTERS_OUTSIDE;
    }
    if ((flags & CLUSTERS_BUCKET_DOUBLE_SIDED) == 0u && faces_away(cluster, instance)) return CLUSTERS_BACK;
    vec2 low, high;
    float depth;
    vec3 seen = (push.view.view.world_to_view * vec4(center, 1.0)).xyz;
    if (screen_rectangle(push.view, seen, vec3(radius * 1.0001 + 1e-6 * length(seen)), push.params.params.slack, low, high, depth)) {
        if (misses_samples(low, high)) return CLUSTERS_SMALL;
        if (push.params.params.hierarchy_width > 0u &&
            hierarchy_hides(push.hierarchy, uvec2(push.params.params.hierarchy_width, push.params.params.hierarchy_height), low, high, depth,
                            push.view.view.orthographic > 0.5))
            return CLUSTERS_OCCLUDED;
    }
    return CLUSTERS_DRAWN;
}

void main() {
    uint slot = LINEAR_INVOCATION;
    if (slot >= push.totals.totals.slots) return;
    // The item whose clusters hold this one.
    uint low = 0u, high = push.params.params.item_count;
    while (high - low > 1u) {
        uint middle = (low + high) / 2u;
        if (push.cluster_sums.at[middle] <= slot) low = middle;
        else high = middle;
    }
    push.slots.at[slot] = low;
    uint count = 0u;
    if (push.cluster_sums.at[low + 1u] <= push.params.params.cluster_capacity) { // else the item is drawn whole
        gpu_item item = push.scene.scene.items.at[low];
        gpu_primitive primitive = push.scene.scene.primitives.at[item.primitive];
        gpu_cluster cluster = push.scene.scene.clusters.at[primitive.first_cluster + slot - push.cluster_sums.at[low]];
        uint first;
        uint reason = reason_of(item, primitive, cluster, bucket_flags(low, first));
        if (reason == CLUSTERS_DRAWN) count = cluster.triangle_count;
        else count_reason(reason, cluster.triangle_count);
        if (MESHES != 0u && count > 0u) {
            if (BY_TRIANGLE == 0u) count_reason(CLUSTERS_DRAWN, count);
            count = 1u;
        }
    }
    push.counts.at[slot] = count;
}
