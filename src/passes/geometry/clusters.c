/* SPDX-License-Identifier: MIT */
#include "passes/geometry/clusters.h"

#include "passes/geometry/occlusion.h"
#include "passes/geometry/prefix_sum.h"
#include "shaders.h"

#include <math.h>

/* The buffers of all steps. */
struct step_data {
    graph_buffer visible_sums, cluster_sums, slots, counts, masks, draw_sums, draws, totals, indices, triangles, hierarchy,
        hidden;
};

/* A step reads, writes and changes some of the buffers; those that are not there it does without. */
#define READS(field) graph_row_if(d.field.id, graph_reads(&push.field, d.field))
#define WRITES(field) graph_row_if(d.field.id, graph_writes(&push.field, d.field))
#define CHANGES(field) graph_row_if(d.field.id, graph_changes(&push.field, d.field))
#define THREADS(count) .groups = {DIVIDE_UP(count, 64u)}
#define ADD_STEP(name_, shader_, constant_count_, size_, ...)                                                               \
    graph_dispatch(graph,                                                                                                   \
                   &(struct graph_dispatch){.name = name_,                                                                  \
                                            .pipeline = {&shader_, constant_count_, {params->by_triangle, params->meshes}}, \
                                            size_,                                                                          \
                                            GRAPH_PUSH(push),                                                               \
                                            GRAPH_ROWS(__VA_ARGS__)})

/* The standard sample locations (Vulkan 1.3, 27.4). */
static uint32_t sample_locations(uint32_t samples, vec2 *out) {
    static const uint8_t sixteenths[][2] = {{8, 8},  {12, 12}, {4, 4}, {6, 2},  {14, 6}, {2, 10},  {10, 14}, {9, 5},
                                            {7, 11}, {13, 9},  {5, 3}, {3, 13}, {1, 7},  {11, 15}, {15, 1}};
    for (uint32_t i = 0; i < samples; i++) /* those of 1, of 2, of 4 and of 8 samples in a row */
        out[i] = (vec2){sixteenths[samples - 1 + i][0] / 16.0f, sixteenths[samples - 1 + i][1] / 16.0f};
    return samples;
}

static struct gpu_cluster_params make_params(gpu_device *device, const struct geometry_scene *scene,
                                             const struct gpu_view *camera, const struct clusters_params *params) {
    struct gpu_cluster_params p = {.item_count = scene->item_count,
                                   .bucket_count = scene->bucket_count,
                                   .cluster_capacity = params->cluster_capacity,
                                   .triangle_capacity = scene->pool_triangles,
                                   .first_pool_index = scene->index_count + params->pool * scene->pool_triangles * 3};
    /* A vertex moves by less than a step of the grid; a pixel of a coarser raster is at most eight of these. */
    p.slack = (params->full_raster ? 1.0f : 8.0f) / (float)(1u << MIN(gpu_subpixel_bits(device), 16u));
    p.pixels_per_slope =
        0.5f * fminf(fabsf((float)camera->size.x / camera->ndc_scale.x), fabsf((float)camera->size.y / camera->ndc_scale.y));
    if (params->occluders) {
        p.hierarchy_width = params->occluders->width;
        p.hierarchy_height = params->occluders->height;
    }
    if (params->meshes) {
        p.mesh_row = params->mesh_row;
        p.mesh_rows = params->mesh_rows;
        p.mesh_draws = (uint32_t)DIVIDE_UP(MAX(scene->cluster_count, 1u), (uint64_t)p.mesh_row * p.mesh_rows);
    }
    if (params->full_raster && (params->samples == 1 || gpu_standard_samples(device))) {
        p.sample_count = sample_locations(params->samples, p.samples);
        if (params->centers && params->samples > 1) p.samples[p.sample_count++] = (vec2){0.5f, 0.5f};
    }
    return p;
}

void clusters_add(struct graph *graph, gpu_device *device, const struct geometry_scene *scene, const struct gpu_view *camera,
                  VkDeviceAddress view, const struct clusters_params *params, struct geometry_draws *draws) {
    uint32_t items = scene->item_count, buckets = scene->bucket_count, capacity = params->cluster_capacity;
    if (items == 0 || scene->cluster_count == 0) return;
    uint64_t params_size = sizeof(struct gpu_cluster_params);
    struct gpu_slice slice = gpu_frame_allocate(device, params_size + buckets * sizeof(struct gpu_cull_bucket));
    if (!slice.data) return; /* the error sticks to the device */
    struct gpu_cluster_params p = make_params(device, scene, camera, params);
    memcpy(slice.data, &p, sizeof p);
    struct gpu_cull_bucket *table = (struct gpu_cull_bucket *)((char *)slice.data + params_size);
    for (uint32_t i = 0; i < buckets; i++) {
        const struct geometry_bucket *b = &scene->buckets[i];
        table[i] = (struct gpu_cull_bucket){b->first_item, (geometry_bucket_clustered(b) ? CLUSTERS_BUCKET_CULLED : 0) |
                                                               (b->double_sided ? CLUSTERS_BUCKET_DOUBLE_SIDED : 0) |
                                                               (b->mirrored ? CLUSTERS_BUCKET_MIRRORED : 0)};
    }
    const struct gpu_cluster_push push = {
        .view = view, .scene = scene->scene, .params = slice.address, .buckets = slice.address + params_size};
    struct step_data d = {
        .visible_sums = draws->sums,
        .cluster_sums = graph_create_buffer(graph, "cluster sums", (items + 1) * 4ull),
        .slots = graph_create_buffer(graph, "cluster slots", MAX(capacity, 1u) * 4ull),
        .counts = graph_create_buffer(graph, "cluster counts", (capacity + 1) * 4ull),
        .totals = graph_create_buffer(graph, "cluster totals", sizeof(struct gpu_cluster_totals) + buckets * 4ull),
        .indices = graph_import_buffer(graph, "indices", scene->indices),
        .hierarchy = params->occluders ? params->occluders->levels : (graph_buffer){0},
        .hidden = params->occluders ? draws->hidden : (graph_buffer){0}};
    if (params->meshes) {
        d.draw_sums = graph_create_buffer(graph, "mesh list", MAX(capacity, 1u) * 4ull);
        d.draws = graph_create_buffer(graph, "mesh draws", (uint64_t)buckets * p.mesh_draws * sizeof(struct gpu_mesh_draw));
    } else {
        d.draw_sums = graph_create_buffer(graph, "item draw sums", (items + 1) * 4ull);
        d.draws = graph_create_buffer(graph, "item draws", items * sizeof(struct gpu_draw));
        d.triangles = graph_create_buffer(graph, "kept triangles", (items + (uint64_t)scene->pool_triangles) * 4);
    }
    if (params->by_triangle)
        d.masks = graph_create_buffer(graph, "cluster masks", MAX(capacity, 1u) * (uint64_t)CLUSTERS_MASK_WORDS * 4);
    graph_buffer vertices = scene->vertices;
    graph_add_clear(graph, "cull clusters clear", GRAPH_QUEUE_GRAPHICS, (struct graph_clear){.buffers = {d.totals}});
    const uint32_t mesh_constants = params->meshes ? 2 : 0;
    ADD_STEP("cull clusters items", shader_clusters_items_comp, 0, THREADS(items + 1), READS(visible_sums),
             WRITES(cluster_sums), CHANGES(totals), READS(hidden));
    prefix_sum_add(graph, "cull item clusters", GRAPH_QUEUE_GRAPHICS, d.cluster_sums, items + 1);
    ADD_STEP("cull clusters slots", shader_clusters_slots_comp, 0, THREADS(1), READS(cluster_sums), CHANGES(totals));
    ADD_STEP("cull clusters cull", shader_clusters_cull_comp, mesh_constants, THREADS(MAX(capacity, 1u)),
             READS(cluster_sums), WRITES(slots), WRITES(counts), CHANGES(totals), READS(hierarchy),
             graph_reads(NULL, vertices));
    if (params->by_triangle)
        ADD_STEP("cull clusters triangles", shader_clusters_triangles_comp, mesh_constants, .indirect = d.totals,
                 READS(cluster_sums), READS(slots), CHANGES(counts), WRITES(masks), CHANGES(totals), READS(indices),
                 graph_reads(NULL, vertices));
    prefix_sum_add(graph, "cull triangles", GRAPH_QUEUE_GRAPHICS, d.counts, capacity + 1);
    draws->totals = d.totals;
    if (params->meshes) {
        ADD_STEP("cull clusters meshes", shader_clusters_meshes_comp, mesh_constants,
                 THREADS(MAX(MAX(items, capacity), buckets * p.mesh_draws)), READS(cluster_sums), READS(counts),
                 READS(slots), READS(masks), WRITES(draw_sums), WRITES(draws), CHANGES(totals));
        draws->mesh_draws = d.draws;
        draws->mesh_list = d.draw_sums;
        draws->mesh_slots = d.slots;
        draws->mesh_sums = d.cluster_sums;
        draws->mesh_masks = d.masks;
        draws->mesh_draw_count = p.mesh_draws;
        return;
    }
    ADD_STEP("cull clusters mark", shader_clusters_mark_comp, 0, THREADS(items + 1), READS(cluster_sums), READS(counts),
             WRITES(draw_sums), CHANGES(totals));
    prefix_sum_add(graph, "cull item draws", GRAPH_QUEUE_GRAPHICS, d.draw_sums, items + 1);
    ADD_STEP("cull clusters draws", shader_clusters_draws_comp, 0, THREADS(MAX(items, buckets)), READS(visible_sums),
             READS(cluster_sums), READS(counts), READS(draw_sums), WRITES(draws), WRITES(triangles), CHANGES(totals));
    ADD_STEP("cull clusters fill", shader_clusters_fill_comp, 1, .indirect = d.totals, READS(cluster_sums), READS(slots),
             READS(counts), READS(masks), CHANGES(indices), WRITES(triangles), CHANGES(totals));
    draws->item_draws = d.draws;
    draws->triangles = d.triangles;
    draws->indices = d.indices;
}
