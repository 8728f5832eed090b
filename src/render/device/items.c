/* SPDX-License-Identifier: MIT */
#include "render/device/scene.h"

static const struct scene_material *material_of(const fnl_scene *scene, const struct scene_primitive *p,
                                                const struct scene_material *standard) {
    return p->material == SCENE_NONE ? standard : &scene->materials.data[p->material];
}

/* A group of items: one primitive, one handedness. Ordered by bucket; the bucket's bits are its sort key. */
struct group_key {
    uint32_t bucket, primitive, mirrored, count, first;
};

enum { BUCKET_SORTED = 1 << 16, BUCKET_TOPOLOGY = 4, BUCKET_LAYOUTS = 6 };

static uint32_t bucket_bits(const struct scene_material *m, uint32_t forward_layouts, enum scene_topology topology,
                            bool mirrored) {
    bool blend = m->alpha_mode == FNL_ALPHA_BLEND, sorted = blend && topology == SCENE_TOPOLOGY_TRIANGLES;
    /* Blended triangles form one bucket at the end: they are drawn in one order over all states. */
    if (sorted) return BUCKET_SORTED;
    return (blend ? 0 : forward_layouts) << BUCKET_LAYOUTS | (uint32_t)topology << BUCKET_TOPOLOGY | (uint32_t)blend << 3 |
           (uint32_t)(m->alpha_mode == FNL_ALPHA_MASK) << 2 | (uint32_t)m->double_sided << 1 |
           (uint32_t)(mirrored && !m->double_sided);
}

static int compare_groups(const void *a, const void *b) {
    const struct group_key *x = a, *y = b;
    if (x->bucket != y->bucket) return x->bucket < y->bucket ? -1 : 1;
    if (x->primitive != y->primitive) return x->primitive < y->primitive ? -1 : 1;
    return (int)x->mirrored - (int)y->mirrored;
}

/* The primitives on the device: those of the scene, then those of deforming nodes, which start at first_primitive. */
struct item_walk {
    struct device_scene *d;
    const struct gpu_primitive *primitives;
    uint32_t key_count;              /* keys are primitive * 2 + mirrored */
    uint32_t *sources;               /* scene primitive of each key */
    struct group_key *keys;          /* by key while items are counted, then by group */
    uint32_t *groups;                /* group of each key */
    struct gpu_item *items;          /* NULL while items are counted */
};

/* Visits every item in the order of nodes; counts (items NULL) or places them. */
static void walk_items(struct item_walk *w) {
    const fnl_scene *scene = w->d->scene;
    for (uint32_t n = 0; n < scene->nodes.count; n++) {
        const struct scene_node *node = &scene->nodes.data[n];
        if (w->d->nodes.data[n].first_instance == SCENE_NONE) continue;
        const struct scene_mesh *mesh = &scene->meshes.data[node->mesh];
        uint32_t own = w->d->nodes.data[n].first_primitive;
        for (uint32_t i = 0; i < mesh->primitive_count; i++) {
            uint32_t primitive = own == SCENE_NONE ? mesh->first_primitive + i : own + i;
            if (w->primitives[primitive].index_count == 0) continue;
            for (uint32_t k = 0; k < node->instance_count; k++) {
                mat4 m = device_instance_matrix(node, k);
                uint32_t key = primitive * 2 + (mat4_determinant3(&m) < 0);
                if (!w->items) {
                    w->keys[key].count++;
                    continue;
                }
                struct group_key *group = &w->keys[w->groups[key]];
                w->items[group->first + group->count++] =
                    (struct gpu_item){w->d->nodes.data[n].first_instance + k, primitive, (uint8_t)~node->refuses};
            }
        }
    }
}

static VkPrimitiveTopology vulkan_topology(uint32_t topology) {
    return topology == SCENE_TOPOLOGY_LINES    ? VK_PRIMITIVE_TOPOLOGY_LINE_LIST
           : topology == SCENE_TOPOLOGY_POINTS ? VK_PRIMITIVE_TOPOLOGY_POINT_LIST
                                               : VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST;
}

static fnl_result upload_groups(struct item_walk *w) {
    struct device_scene *d = w->d;
    struct group_key *keys = w->keys;
    const fnl_scene *scene = d->scene;
    struct scene_material standard = scene_material_default();
    walk_items(w);

    /* What each key draws, from the scene primitive it came from. */
    uint32_t group_count = 0;
    uint64_t item_count = 0;
    for (uint32_t key = 0; key < w->key_count; key++) {
        if (keys[key].count == 0) continue;
        struct group_key group = {.primitive = key / 2, .mirrored = key & 1, .count = keys[key].count};
        keys[key].count = 0;
        const struct scene_primitive *source = &scene->primitives.data[w->sources[key]];
        const struct scene_material *material = material_of(scene, source, &standard);
        uint32_t id = source->material == SCENE_NONE ? scene->materials.count : source->material;
        group.bucket =
            bucket_bits(material, device_material_forward_layouts(d, material, id), source->topology, group.mirrored);
        item_count += group.count;
        const struct gpu_primitive *primitive = &w->primitives[group.primitive];
        d->most_triangles = MAX(d->most_triangles, primitive->index_count / primitive->corners);
        keys[group_count++] = group; /* never overtakes `key` */
    }
    if (item_count > UINT32_MAX - 1) {
        log_error(&d->host, "%s: has %llu instances of primitives, more than 32 bits can count", d->scene->source,
                  (unsigned long long)item_count);
        return FNL_ERROR_UNSUPPORTED;
    }
    qsort(keys, group_count, sizeof *keys, compare_groups);

    struct gpu_group *groups = host_allocate_zero(&d->host, MAX(group_count, 1u) * sizeof *groups);
    struct gpu_item *items = host_allocate_zero(&d->host, MAX(item_count, 1u) * sizeof *items);
    fnl_result result = groups && items ? FNL_OK : FNL_ERROR_MEMORY;
    uint32_t first = 0;
    d->blend_item_count = 0;
    for (uint32_t i = 0; i < group_count && result == FNL_OK; i++) {
        struct group_key *key = &keys[i];
        w->groups[key->primitive * 2 + key->mirrored] = i;
        key->first = first;
        groups[i] = (struct gpu_group){.first_item = first, .item_count = key->count, .primitive = key->primitive};
        struct geometry_bucket *last = d->buckets.count ? &d->buckets.data[d->buckets.count - 1] : NULL;
        if (i == 0 || keys[i - 1].bucket != key->bucket) {
            bool sorted = key->bucket == BUCKET_SORTED;
            struct geometry_bucket bucket = {.topology = sorted ? VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST
                                                                : vulkan_topology(key->bucket >> BUCKET_TOPOLOGY & 3),
                                             .blend = sorted || key->bucket & 8,
                                             .mask = !sorted && key->bucket & 4,
                                             .double_sided = !sorted && key->bucket & 2,
                                             .mirrored = !sorted && key->bucket & 1,
                                             .forward_layouts = sorted ? 0 : key->bucket >> BUCKET_LAYOUTS,
                                             .first_item = first,
                                             .first_group = i};
            if (!array_push(&d->host, &d->buckets, bucket)) {
                result = FNL_ERROR_MEMORY;
                break;
            }
            last = &d->buckets.data[d->buckets.count - 1];
            if (sorted) d->blend_first_item = first;
        }
        if (geometry_bucket_clustered(last)) {
            const struct gpu_primitive *primitive = &w->primitives[key->primitive];
            d->cluster_count += (uint64_t)key->count * primitive->cluster_count;
            d->triangle_count += (uint64_t)key->count * (primitive->index_count / 3);
        }
        last->item_count += key->count;
        last->group_count++;
        if (key->bucket == BUCKET_SORTED) d->blend_item_count += key->count;
        first += key->count;
        key->count = 0;
    }
    if (result == FNL_OK) {
        w->items = items;
        walk_items(w);
        d->item_count = (uint32_t)item_count;
        d->group_count = group_count;
        result = device_array_set(d, "items", &d->items, items, item_count, sizeof *items);
        if (result == FNL_OK) result = device_array_set(d, "groups", &d->groups, groups, group_count, sizeof *groups);
    }
    if (groups) host_free(&d->host, groups, MAX(group_count, 1u) * sizeof *groups);
    if (items) host_free(&d->host, items, MAX(item_count, 1u) * sizeof *items);
    return result;
}

static void map_sources(struct item_walk *w) {
    const fnl_scene *scene = w->d->scene;
    for (uint32_t i = 0; i < scene->primitives.count; i++) w->sources[i * 2] = w->sources[i * 2 + 1] = i;
    for (uint32_t n = 0; n < scene->nodes.count; n++) {
        uint32_t own = w->d->nodes.data[n].first_primitive;
        if (own == SCENE_NONE) continue;
        const struct scene_mesh *mesh = &scene->meshes.data[scene->nodes.data[n].mesh];
        for (uint32_t i = 0; i < mesh->primitive_count; i++) {
            uint32_t key = (own + i) * 2;
            w->sources[key] = w->sources[key + 1] = mesh->first_primitive + i;
        }
    }
}

fnl_result device_items_upload(struct device_scene *d, const struct gpu_primitive *primitives, uint32_t primitive_count) {
    struct item_walk walk = {.d = d, .primitives = primitives, .key_count = primitive_count * 2};
    d->buckets.count = d->item_count = d->group_count = d->most_triangles = d->blend_item_count = 0;
    d->cluster_count = d->triangle_count = 0;
    size_t keys_size = MAX(walk.key_count, 1u) * sizeof *walk.keys, map_size = MAX(walk.key_count, 1u) * sizeof(uint32_t);
    walk.keys = host_allocate_zero(&d->host, keys_size);
    walk.sources = host_allocate_zero(&d->host, map_size);
    walk.groups = host_allocate_zero(&d->host, map_size);
    fnl_result result = FNL_ERROR_MEMORY;
    if (walk.keys && walk.sources && walk.groups) {
        map_sources(&walk);
        result = upload_groups(&walk);
    }
    host_free(&d->host, walk.keys, keys_size);
    host_free(&d->host, walk.sources, map_size);
    host_free(&d->host, walk.groups, map_size);
    return result;
}
