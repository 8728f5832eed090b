/* SPDX-License-Identifier: MIT */
#include "render/device/clusters.h"

#include <float.h>
#include <math.h>
#include <meshoptimizer.h>

enum { PART_TRIANGLES = 1 << 18 }; /* that are cut at once: bounds the memory that it takes */

/* The smallest altitude of the triangles; those with two corners at one place show nothing whatever happens. */
static float thinnest(const vec3 *positions, const uint32_t *indices, uint32_t triangle_count) {
    float least = FLT_MAX;
    for (uint32_t t = 0; t < triangle_count; t++) {
        vec3 a = positions[indices[3 * t]], b = positions[indices[3 * t + 1]], c = positions[indices[3 * t + 2]];
        vec3 u = vec3_sub(b, a), v = vec3_sub(c, a), w = vec3_sub(c, b);
        float longest = fmaxf(vec3_length(u), fmaxf(vec3_length(v), vec3_length(w)));
        if (vec3_length(u) == 0 || vec3_length(v) == 0 || vec3_length(w) == 0) continue;
        float altitude = vec3_length(vec3_cross(u, v)) / longest;
        if (!(altitude >= least)) least = altitude;
    }
    return least;
}

struct part {
    struct meshopt_Meshlet *meshlets;
    unsigned int *vertices;
    unsigned char *corners;
};

/* The vertices of a cluster and the corners of its triangles. */
static bool push_words(const fnl_host *host, const struct meshopt_Meshlet *meshlet, const unsigned int *vertices,
                       const unsigned char *corners, gpu_word_list *words) {
    if (!array_reserve(host, words, (uint64_t)words->count + meshlet->vertex_count + meshlet->triangle_count)) return false;
    for (uint32_t i = 0; i < meshlet->vertex_count; i++) words->data[words->count++] = vertices[i];
    for (uint32_t i = 0; i < meshlet->triangle_count; i++, corners += 3)
        words->data[words->count++] = corners[0] | (uint32_t)corners[1] << 8 | (uint32_t)corners[2] << 16;
    return true;
}

static fnl_result build_part(const fnl_host *host, const struct scene_primitive *p, uint32_t first, uint32_t count,
                             const struct part *part, gpu_cluster_list *clusters, uint32_t *out_indices,
                             gpu_word_list *words) {
    const float *positions = &p->positions[0].x;
    size_t meshlet_count = meshopt_buildMeshlets(part->meshlets, part->vertices, part->corners, p->indices + first * 3ull,
                                                 count * 3ull, positions, p->vertex_count, sizeof(vec3),
                                                 CLUSTERS_MOST_VERTICES, CLUSTERS_MOST_TRIANGLES, 0.25f);
    for (size_t m = 0; m < meshlet_count; m++) {
        const struct meshopt_Meshlet *meshlet = &part->meshlets[m];
        const unsigned int *vertices = part->vertices + meshlet->vertex_offset;
        const unsigned char *corners = part->corners + meshlet->triangle_offset;
        struct meshopt_Bounds bounds = meshopt_computeMeshletBounds(vertices, corners, meshlet->triangle_count, positions,
                                                                    p->vertex_count, sizeof(vec3));
        uint32_t *indices = out_indices + first * 3ull;
        for (uint32_t i = 0; i < meshlet->triangle_count * 3; i++) indices[i] = vertices[corners[i]];
        struct gpu_cluster cluster = {.center = {bounds.center[0], bounds.center[1], bounds.center[2]},
                                      .cone_axis = {bounds.cone_axis[0], bounds.cone_axis[1], bounds.cone_axis[2]},
                                      .cone_cutoff = bounds.cone_cutoff,
                                      .thinnest = thinnest(p->positions, indices, meshlet->triangle_count),
                                      .first_triangle = first,
                                      .triangle_count = meshlet->triangle_count,
                                      .first_word = words ? words->count : 0,
                                      .vertex_count = meshlet->vertex_count};
        for (uint32_t i = 0; i < meshlet->vertex_count; i++) { /* as far as rounding has it */
            float distance = vec3_distance(cluster.center, p->positions[vertices[i]]);
            if (!(distance <= cluster.radius)) cluster.radius = distance;
        }
        if (words && !push_words(host, meshlet, vertices, corners, words)) return FNL_ERROR_MEMORY;
        first += meshlet->triangle_count;
        if (!array_push(host, clusters, cluster)) return FNL_ERROR_MEMORY;
    }
    return FNL_OK;
}

fnl_result device_clusters_build(const fnl_host *host, const struct scene_primitive *p, gpu_cluster_list *clusters,
                                 uint32_t *out_indices, gpu_word_list *words) {
    uint32_t triangle_count = p->index_count / 3, most = MIN(triangle_count, PART_TRIANGLES);
    size_t bound = meshopt_buildMeshletsBound(most * 3ull, CLUSTERS_MOST_VERTICES, CLUSTERS_MOST_TRIANGLES);
    size_t sizes[3] = {bound * sizeof(struct meshopt_Meshlet), bound * CLUSTERS_MOST_VERTICES * sizeof(unsigned int),
                       bound * CLUSTERS_MOST_TRIANGLES * 3};
    void *memory[3] = {0};
    fnl_result result = FNL_OK;
    for (int i = 0; i < 3; i++)
        if (!(memory[i] = host_allocate(host, MAX(sizes[i], 1u)))) result = FNL_ERROR_MEMORY;
    struct part part = {memory[0], memory[1], memory[2]};
    for (uint32_t first = 0; first < triangle_count && result == FNL_OK; first += PART_TRIANGLES)
        result =
            build_part(host, p, first, MIN(triangle_count - first, PART_TRIANGLES), &part, clusters, out_indices, words);
    for (int i = 0; i < 3; i++)
        if (memory[i]) host_free(host, memory[i], MAX(sizes[i], 1u));
    return result;
}
