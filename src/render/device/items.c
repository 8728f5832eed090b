/* SPDX-License-Identifier: MIT */
#include "render/device/scene.h"

static const struct scene_material *material_of(const fnl_scene *scene, const struct scene_primitive *p,
                                                const struct scene_material *standard) {
    return p->material == SCENE_NONE ? standard : &scene->materials.data[p->material];
}

enum { BUCKET_SORTED = 1 << 20, BUCKET_TOPOLOGY = 4, BUCKET_LAYOUTS = 6 }; /* what is transmissive has the highest bit of the others: it comes behind them */
_Static_assert(BUCKET_LAYOUTS + GEOMETRY_TRANSMISSIVE < 20, "a bucket has bits for all layouts");

static uint32_t bucket_bits(const struct scene_material *m, uint32_t forward_layouts, enum scene_topology topology,
                            bool mirrored) {
    bool blend = m->alpha_mode == FNL_ALPHA_BLEND && !scene_material_transmissive(m), sorted = blend && topology == SCENE_TOPOLOGY_TRIANGLES;
    /* Blended triangles form one bucket at the end: they are drawn in one order over all states. */
    if (sorted) return BUCKET_SORTED;
    return (blend ? 0 : forward_layouts) << BUCKET_LAYOUTS | (uint32_t)topology << BUCKET_TOPOLOGY | (uint32_t)blend << 3 |
           (uint32_t)(m->alpha_mode == FNL_ALPHA_MASK) << 2 | (uint32_t)m->double_sided << 1 |
           (uint32_t)(mirrored && !m->double_sided);
}

static int compare_groups(const void *a, const void *b) {
    const struct device_group *x = a, *y = b;
    if (x->bucket != y->bucket) return x->bucket < y->bucket ? -1 : 1;
    if (x->primitive != y->primitive) return x->primitive < y->primitive ? -1 : 1;
    if (x->mirrored != y->mirrored) return (int)x->mirrored - (int)y->mirrored;
    return (int)x->masked - (int)y->masked;
}

/* Bits of geometry_bucket.forward_layouts of items with a light mask: what shades without knowing the item cannot shade them. */
enum { MASKED_LAYOUTS = ((1 << FNL_GBUFFER_COUNT) - 1) | 1 << GEOMETRY_LAYERED | 1 << GEOMETRY_MASKED };

static struct gpu_item item_of(const struct device_scene *d, uint32_t instance, uint32_t primitive, uint32_t node) {
    const struct scene_node *n = &d->scene->nodes.data[node];
    return (struct gpu_item){instance, primitive, (255u & ~n->refuses) | (255u & ~n->unlit) << GPU_ITEM_LIGHTS_SHIFT | (255u & ~n->unseen) << GPU_ITEM_VIEWS_SHIFT};
}

/* The primitives on the device: those of the scene, then those of deforming nodes, which start at first_primitive. */
static const struct gpu_primitive *primitives_of(const struct device_scene *d) {
    return (const struct gpu_primitive *)(const void *)d->primitives.sent.data;
}

/* What draws a primitive, of which `source` is the scene's. */
static struct device_group group_of(const struct device_scene *d, uint32_t primitive, uint32_t source, bool mirrored, bool masked) {
    const struct scene_material standard = scene_material_default();
    const struct scene_primitive *p = &d->scene->primitives.data[source];
    const struct scene_material *material = material_of(d->scene, p, &standard);
    uint32_t id = p->material == SCENE_NONE ? d->scene->materials.count : p->material;
    const uint32_t forward = device_material_forward_layouts(d, material, id) | (masked ? MASKED_LAYOUTS : 0);
    return (struct device_group){
        .bucket = bucket_bits(material, forward, p->topology, mirrored), .primitive = primitive, .mirrored = mirrored, .masked = masked};
}

enum { KEYS = 4 }; /* of a primitive */

/* Sorts all items: by group, and within a group in the order of nodes and their instances. */
struct item_walk {
    struct device_scene *d;
    uint32_t key_count;  /* keys are primitive * KEYS + masked * 2 + mirrored */
    uint32_t *sources;   /* scene primitive of each primitive */
    uint32_t *counts;    /* of each key; then where its next item goes */
    bool counts_only;
};

/* Visits every item in the order of nodes; counts or places them. */
static void walk_items(struct item_walk *w) {
    struct device_scene *d = w->d;
    const fnl_scene *scene = d->scene;
    const struct gpu_primitive *primitives = primitives_of(d);
    for (uint32_t n = 0; n < scene->nodes.count; n++) {
        const struct scene_node *node = &scene->nodes.data[n];
        if (d->nodes.data[n].first_instance == SCENE_NONE) continue;
        const struct scene_mesh *mesh = &scene->meshes.data[node->mesh];
        uint32_t own = d->nodes.data[n].first_primitive;
        const bool masked = d->nodes.data[n].masked;
        for (uint32_t k = 0; k < node->instance_count; k++) {
            mat4 m = device_instance_matrix(scene, node, k);
            bool mirrored = mat4_determinant3(&m) < 0;
            for (uint32_t i = 0; i < mesh->primitive_count; i++) {
                uint32_t primitive = own == SCENE_NONE ? mesh->first_primitive + i : own + i;
                if (primitives[primitive].index_count == 0) continue;
                uint32_t *at = &w->counts[primitive * KEYS + masked * 2 + mirrored];
                if (!w->counts_only) {
                    d->item_list.data[*at] = item_of(d, d->nodes.data[n].first_instance + k, primitive, n);
                    d->item_nodes.data[*at] = n;
                }
                ++*at;
            }
        }
    }
}

static VkPrimitiveTopology vulkan_topology(uint32_t topology) {
    return topology == SCENE_TOPOLOGY_LINES    ? VK_PRIMITIVE_TOPOLOGY_LINE_LIST
           : topology == SCENE_TOPOLOGY_POINTS ? VK_PRIMITIVE_TOPOLOGY_POINT_LIST
                                               : VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST;
}

/* Appends a group to the buckets; groups of one bucket are adjacent. */
static fnl_result add_to_bucket(struct device_scene *d, uint32_t index) {
    const struct device_group *group = &d->group_list.data[index];
    const bool sorted = group->bucket == BUCKET_SORTED;
    if (index == 0 || d->group_list.data[index - 1].bucket != group->bucket) {
        const struct geometry_bucket bucket = {.topology = sorted ? VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST
                                                                  : vulkan_topology(group->bucket >> BUCKET_TOPOLOGY & 3),
                                               .blend = sorted || group->bucket & 8,
                                               .mask = !sorted && group->bucket & 4,
                                               .double_sided = !sorted && group->bucket & 2,
                                               .mirrored = !sorted && group->bucket & 1,
                                               .forward_layouts = sorted ? 0 : group->bucket >> BUCKET_LAYOUTS,
                                               .first_item = group->first,
                                               .first_group = index};
        if (!array_push(&d->host, &d->buckets, bucket)) return FNL_ERROR_MEMORY;
        if (sorted) d->blend_first_item = group->first;
    }
    struct geometry_bucket *bucket = &d->buckets.data[d->buckets.count - 1];
    const struct gpu_primitive *primitive = &primitives_of(d)[group->primitive];
    if (geometry_bucket_clustered(bucket)) {
        d->cluster_count += (uint64_t)group->count * primitive->cluster_count;
        d->triangle_count += (uint64_t)group->count * (primitive->index_count / 3);
    }
    d->most_triangles = MAX(d->most_triangles, primitive->index_count / primitive->corners);
    bucket->item_count += group->count;
    bucket->group_count++;
    if (sorted) d->blend_item_count += group->count;
    if (!sorted) d->caster_count = group->first + group->count;
    return FNL_OK;
}

/* What pages of shadow maps draw of a primitive (struct gpu_group): all of it or single clusters, unless there is one alone or their bounds change. */
static uint32_t units_of(const struct gpu_primitive *p) {
    return p->cluster_count > 1 && p->bind_offset == 0 ? 1 + p->cluster_count : 1;
}

/* What follows from the lists: buckets, sums, and what the device has. */
fnl_result device_items_send(struct device_scene *d) {
    d->buckets.count = d->most_triangles = d->blend_item_count = d->caster_count = 0;
    d->cluster_count = d->triangle_count = 0;
    d->unit_count = 0;
    d->group_count = d->group_list.count;
    d->item_count = d->item_list.count;
    size_t size = MAX(d->group_count, 1u) * sizeof(struct gpu_group);
    struct gpu_group *groups = host_allocate_zero(&d->host, size);
    fnl_result result = groups ? FNL_OK : FNL_ERROR_MEMORY;
    for (uint32_t i = 0; i < d->group_count && result == FNL_OK; i++) {
        const struct device_group *group = &d->group_list.data[i];
        groups[i] = (struct gpu_group){
            .first_item = group->first, .item_count = group->count, .primitive = group->primitive, .first_unit = d->unit_count};
        d->unit_count += units_of(&primitives_of(d)[group->primitive]);
        result = add_to_bucket(d, i);
    }
    if (result == FNL_OK)
        result = device_array_set(d, GPU_USE_GEOMETRY, "items", &d->items, d->item_list.data, d->item_count, sizeof(struct gpu_item));
    if (result == FNL_OK) result = device_array_set(d, GPU_USE_GEOMETRY, "groups", &d->groups, groups, d->group_count, sizeof *groups);
    if (groups) host_free(&d->host, groups, size);
    return result;
}

static fnl_result sort_items(struct item_walk *w) {
    struct device_scene *d = w->d;
    w->counts_only = true;
    walk_items(w);
    uint64_t item_count = 0;
    d->group_list.count = 0;
    for (uint32_t key = 0; key < w->key_count; key++) {
        if (w->counts[key] == 0) continue;
        struct device_group group = group_of(d, key / KEYS, w->sources[key / KEYS], key & 1, key & 2);
        group.count = w->counts[key];
        item_count += group.count;
        if (!array_push(&d->host, &d->group_list, group)) return FNL_ERROR_MEMORY;
    }
    if (item_count > UINT32_MAX - 1) {
        log_error(&d->host, "%s: has %llu instances of primitives, more than 32 bits can count", d->scene->source,
                  (unsigned long long)item_count);
        return FNL_ERROR_UNSUPPORTED;
    }
    if (!array_reserve(&d->host, &d->item_list, item_count) || !array_reserve(&d->host, &d->item_nodes, item_count))
        return FNL_ERROR_MEMORY;
    if (d->group_list.count) qsort(d->group_list.data, d->group_list.count, sizeof *d->group_list.data, compare_groups);
    d->item_list.count = d->item_nodes.count = 0;
    for (uint32_t i = 0; i < d->group_list.count; i++) {
        struct device_group *group = &d->group_list.data[i];
        group->first = d->item_list.count;
        w->counts[group->primitive * KEYS + group->masked * 2 + group->mirrored] = group->first;
        d->item_list.count += group->count;
    }
    d->item_nodes.count = d->item_list.count;
    w->counts_only = false;
    walk_items(w);
    return device_items_send(d);
}

static void map_sources(struct item_walk *w) {
    const fnl_scene *scene = w->d->scene;
    for (uint32_t i = 0; i < scene->primitives.count; i++) w->sources[i] = i;
    for (uint32_t n = 0; n < scene->nodes.count; n++) {
        uint32_t own = w->d->nodes.data[n].first_primitive;
        if (own == SCENE_NONE) continue;
        const struct scene_mesh *mesh = &scene->meshes.data[scene->nodes.data[n].mesh];
        for (uint32_t i = 0; i < mesh->primitive_count; i++) w->sources[own + i] = mesh->first_primitive + i;
    }
}

fnl_result device_items_upload(struct device_scene *d) {
    const uint32_t primitive_count = d->primitives.sent.count / (uint32_t)sizeof(struct gpu_primitive);
    struct item_walk walk = {.d = d, .key_count = primitive_count * KEYS};
    size_t size = MAX(walk.key_count, 1u) * sizeof(uint32_t);
    walk.sources = host_allocate_zero(&d->host, size);
    walk.counts = host_allocate_zero(&d->host, size);
    fnl_result result = FNL_ERROR_MEMORY;
    if (walk.sources && walk.counts) {
        map_sources(&walk);
        result = sort_items(&walk);
    }
    host_free(&d->host, walk.sources, size);
    host_free(&d->host, walk.counts, size);
    d->sort_count++;
    return result;
}

/* ---- edits of a few nodes: their items are taken out of the lists, and put where sorting all would have them ---- */

/* The first group that is not before `wanted`. */
static uint32_t find_group(const struct device_scene *d, const struct device_group *wanted) {
    uint32_t low = 0;
    for (uint32_t high = d->group_list.count; low < high;) {
        uint32_t middle = low + (high - low) / 2;
        if (compare_groups(&d->group_list.data[middle], wanted) < 0)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

/* The first item of a group that is of this node, or of one behind it. */
static uint32_t find_item(const struct device_scene *d, const struct device_group *group, uint32_t node) {
    uint32_t low = group->first;
    for (uint32_t high = group->first + group->count; low < high;) {
        uint32_t middle = low + (high - low) / 2;
        if (d->item_nodes.data[middle] < node)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

/* Makes room for an element at a place with `by` 1, and takes out the one that is there with -1. */
#define SHIFT(array, at, by)                                                                                                \
    do {                                                                                                                    \
        uint32_t from_ = (by) > 0 ? (at) : (at) + 1, behind_ = (array).count - from_;                                       \
        if (behind_) memmove((array).data + from_ + (by), (array).data + from_, behind_ * sizeof *(array).data);            \
        (array).count += (uint32_t)(by);                                                                                    \
    } while (0)

static void shift_groups(struct device_scene *d, uint32_t first, int by) {
    for (uint32_t i = first; i < d->group_list.count; i++) d->group_list.data[i].first += (uint32_t)by;
}

static void remove_item(struct device_scene *d, const struct device_group *wanted, uint32_t node) {
    uint32_t g = find_group(d, wanted), at = find_item(d, &d->group_list.data[g], node);
    SHIFT(d->item_list, at, -1);
    SHIFT(d->item_nodes, at, -1);
    shift_groups(d, g + 1, -1);
    if (--d->group_list.data[g].count == 0) SHIFT(d->group_list, g, -1);
}

/* There is room for an item and a group more. */
static void insert_item(struct device_scene *d, const struct device_group *wanted, uint32_t node, struct gpu_item item) {
    uint32_t g = find_group(d, wanted);
    if (g == d->group_list.count || compare_groups(&d->group_list.data[g], wanted) != 0) {
        uint32_t first = g < d->group_list.count ? d->group_list.data[g].first : d->item_list.count;
        SHIFT(d->group_list, g, 1);
        d->group_list.data[g] = *wanted;
        d->group_list.data[g].first = first;
        d->group_list.data[g].count = 0;
    }
    uint32_t at = find_item(d, &d->group_list.data[g], node);
    SHIFT(d->item_list, at, 1);
    SHIFT(d->item_nodes, at, 1);
    d->item_list.data[at] = item;
    d->item_nodes.data[at] = node;
    d->group_list.data[g].count++;
    shift_groups(d, g + 1, 1);
}

void device_items_remove(struct device_scene *d, uint32_t node) {
    const struct device_node *place = &d->nodes.data[node];
    const struct scene_mesh *mesh = &d->scene->meshes.data[place->mesh];
    for (uint32_t i = mesh->first_primitive; i < mesh->first_primitive + mesh->primitive_count; i++) {
        const struct device_group group = group_of(d, i, i, place->mirrored, place->masked);
        if (primitives_of(d)[i].index_count) remove_item(d, &group, node);
    }
}

fnl_result device_items_insert(struct device_scene *d, uint32_t node) {
    const struct device_node *place = &d->nodes.data[node];
    const struct scene_mesh *mesh = &d->scene->meshes.data[place->mesh];
    const uint64_t items = (uint64_t)d->item_list.count + mesh->primitive_count;
    if (!array_reserve(&d->host, &d->item_list, items) || !array_reserve(&d->host, &d->item_nodes, items) ||
        !array_reserve(&d->host, &d->group_list, (uint64_t)d->group_list.count + mesh->primitive_count))
        return FNL_ERROR_MEMORY;
    for (uint32_t i = mesh->first_primitive; i < mesh->first_primitive + mesh->primitive_count; i++) {
        if (primitives_of(d)[i].index_count == 0) continue;
        const struct device_group group = group_of(d, i, i, place->mirrored, place->masked);
        insert_item(d, &group, node, item_of(d, place->first_instance, i, node));
    }
    return FNL_OK;
}

/* ---- what they show ---- */

/* The index of each node among those that are there; NULL: no node is removed, or there is no memory. */
static uint32_t *find_indices(const struct device_scene *d, size_t *size) {
    const fnl_scene *scene = d->scene;
    *size = MAX(scene->nodes.count, 1u) * sizeof(uint32_t);
    uint32_t *indices = host_allocate(&d->host, *size), index = 0;
    for (uint32_t n = 0; indices && n < scene->nodes.count; n++) {
        indices[n] = index;
        index += !scene->nodes.data[n].removed;
    }
    return indices;
}

fnl_result device_items_name(const struct device_scene *d, struct device_object *out) {
    const fnl_scene *scene = d->scene;
    size_t size = 0;
    uint32_t *indices = NULL;
    if (scene_entity_count(scene, FNL_ENTITY_INSTANCE) != scene->nodes.count && !(indices = find_indices(d, &size))) return FNL_ERROR_MEMORY;
    for (uint32_t i = 0; i < d->item_count; i++) {
        const uint32_t n = d->item_nodes.data[i], own = d->nodes.data[n].first_primitive, first = scene->meshes.data[d->nodes.data[n].mesh].first_primitive,
                       primitive = d->item_list.data[i].primitive - (own == SCENE_NONE ? first : own),
                       material = scene->primitives.data[first + primitive].material;
        const bool after = scene->stage.material != SCENE_NONE && material > scene->stage.material; /* that is no material of the scene */
        out[i] = (struct device_object){(indices ? indices[n] : n) + 1, primitive, material == SCENE_NONE ? -1 : (int32_t)(material - after)};
        if (scene->nodes.data[n].staged) out[i] = (struct device_object){0};
    }
    if (indices) host_free(&d->host, indices, size);
    return FNL_OK;
}
