/* SPDX-License-Identifier: MIT */
/** How large the pools are that overflow into something slower. */
#include "render/renderer_internal.h"

enum { CLUSTER_POOL_START = 1 << 14, TRIANGLE_POOL_START = 1 << 18 };
enum { POOL_START = 1 << 18, POOL_LIMIT = 1 << 28, PAIR_START = 1 << 19 };

void pools_init(fnl_renderer *r) {
    r->pool_capacity = POOL_START;
    r->decal_capacity = DECAL_POOL_START;
    r->shadow_pairs = PAIR_START;
    r->dais_capacity = DAIS_POOL_START;
    r->dais_node_capacity = DAIS_NODE_START;
}

static uint64_t pool_limit(const fnl_renderer *r) {
    return MAX(MIN(gpu_info(r->device)->memory_bytes / 32, (uint64_t)POOL_LIMIT), (uint64_t)POOL_START);
}

/* After an overflow the pool takes what the frame needed and a quarter more, but never so much that the device could run out: cells
 * beyond that go on using all lights. */
static void grow_pool(fnl_renderer *r, const struct frame_counts *counts) {
    uint64_t needed = MAX(MAX(counts->lights.entries, counts->blend_lights.entries), counts->surface_lights.entries);
    if (needed > r->pool_capacity) r->pool_capacity = (uint32_t)MIN(needed + needed / 4, pool_limit(r));
}

uint32_t pools_list_limit(const fnl_renderer *r) { return renderer_tests(r).fixed_pools ? r->pool_capacity : (uint32_t)pool_limit(r); }

/* So does what holds decals: entries of their list, or fragments of the G-buffer's way. */
static void grow_decal_pool(fnl_renderer *r, const struct frame_counts *counts) {
    uint64_t needed = MAX(counts->decals.entries, counts->gbuffer_decals.entries);
    uint64_t limit = MIN(gpu_info(r->device)->memory_bytes / 32, (uint64_t)POOL_LIMIT);
    if (needed > r->decal_capacity)
        r->decal_capacity = (uint32_t)MIN(needed + needed / 4, MAX(limit, (uint64_t)DECAL_POOL_START));
}

/* So do the pools of culling, as far as the scene can fill them. */
void pools_grow_clusters(fnl_renderer *r, const struct frame_counts *counts) {
    const struct device_scene *d = r->device_scene;
    if (renderer_tests(r).cluster_limit) return;
    uint64_t limit = MAX(gpu_info(r->device)->memory_bytes / 128, (uint64_t)CLUSTER_POOL_START);
    uint64_t clusters = MIN(MAX(CLUSTER_POOL_START, counts->clusters.clusters + counts->clusters.clusters / 4ull), limit);
    uint64_t triangles =
        MIN(MAX(TRIANGLE_POOL_START, counts->clusters.triangles + counts->clusters.triangles / 4ull), limit);
    triangles = MIN(triangles, (UINT32_MAX - (uint64_t)d->index_count) / 3);
    r->cluster_capacity = (uint32_t)MAX(MIN(clusters, d->cluster_count), (uint64_t)r->cluster_capacity);
    r->triangle_capacity = (uint32_t)MAX(MIN(triangles, d->triangle_count), (uint64_t)r->triangle_capacity);
}

/* The lists of blended fragments start with one per pixel and grow in the same way. */
static uint32_t blend_capacity(const fnl_renderer *r, uint64_t wanted) {
    uint64_t limit = gpu_info(r->device)->memory_bytes / 16 / linked_bytes(8);
    return (uint32_t)MIN(MAX(wanted, (uint64_t)BLEND_POOL_START),
                         MIN(MAX(limit, (uint64_t)BLEND_POOL_START), LINKED_CAPACITY_MAX));
}

static void grow_blend_pool(fnl_renderer *r, const struct frame_counts *counts) {
    uint64_t needed = MAX(counts->blend.fragments, counts->blend_behind.fragments);
    if (counts->blend.overflow_pixels > 0 || counts->blend_behind.overflow_pixels > 0)
        r->blend_capacity = MAX(r->blend_capacity, blend_capacity(r, needed + needed / 4));
}

/* Each layer is a few passes: frames begin with one. */
static void grow_transmission(fnl_renderer *r, const struct frame_counts *counts) {
    r->transmission_layers = MAX(r->transmission_layers, MIN(counts->transmission.longest, (uint32_t)TRANSMISSION_LAYERS_MAX));
}

static void grow_dais_pools(fnl_renderer *r, const struct frame_counts *counts) {
    uint64_t limit = gpu_info(r->device)->memory_bytes / 8 / 4;
    if (counts->dais[DAIS_OVERFLOW] == 0) return;
    /* How much more the others want is not known: those that find no room take none. */
    if (counts->dais[DAIS_WORDS] + DAIS_RECORD_MAX > r->dais_capacity)
        r->dais_capacity =
            (uint32_t)MIN(MAX(2ull * r->dais_capacity, (uint64_t)DAIS_POOL_START), MIN(limit, DAIS_POOL_LIMIT));
    uint64_t nodes = counts->dais[DAIS_NODES] + 2ull;
    if (nodes > r->dais_node_capacity)
        r->dais_node_capacity = (uint32_t)MIN(nodes + nodes / 4, MIN(limit, DAIS_POOL_LIMIT) / 4);
}

/* Pages of shadow maps that found no room wait for the next frame. */
static void grow_shadow_pairs(fnl_renderer *r, const struct frame_counts *counts) {
    const uint64_t needed = counts->shadows.pairs, limit = MAX(gpu_info(r->device)->memory_bytes / 64 / 20, (uint64_t)PAIR_START);
    if (needed > r->shadow_pairs) r->shadow_pairs = (uint32_t)MIN(needed + needed / 4, MIN(limit, (uint64_t)POOL_LIMIT));
}

void pools_prepare(fnl_renderer *r, uint64_t pixels) {
    if (!r->blend_capacity) r->blend_capacity = blend_capacity(r, pixels);
}

void pools_grow(fnl_renderer *r, const struct frame_counts *counts) {
    grow_pool(r, counts);
    grow_blend_pool(r, counts);
    grow_decal_pool(r, counts);
    grow_transmission(r, counts);
    pools_grow_clusters(r, counts);
    grow_dais_pools(r, counts);
    grow_shadow_pairs(r, counts);
}
