/* SPDX-License-Identifier: MIT */
/* Where the instances of nodes are on the device, and the vertices of those that deform. */
#include "render/device/scene.h"

static struct gpu_instance device_instance(const mat4 *m) {
    struct gpu_instance r;
    for (int row = 0; row < 3; row++) r.rows[row] = (vec4){m->m[row], m->m[4 + row], m->m[8 + row], m->m[12 + row]};
    return r;
}

mat4 device_instance_matrix(const fnl_scene *scene, const struct scene_node *node, uint32_t k) {
    if (node->skin != SCENE_NONE) return skin_instance(skin_mirrors(scene, node)); /* the joints carry it (glTF 2.0, 3.7.3.1) */
    return scene_instance_world(scene, node, k);
}

void device_scene_node_instances(const fnl_scene *scene, const struct scene_node *node, struct gpu_instance *out) {
    for (uint32_t k = 0; k < node->instance_count; k++) {
        mat4 m = device_instance_matrix(scene, node, k);
        out[k] = device_instance(&m);
    }
}

bool device_node_mirrors(const fnl_scene *scene, const struct scene_node *node) {
    return node->skin == SCENE_NONE ? mat4_determinant3(&node->world) < 0 : skin_mirrors(scene, node);
}

bool device_node_deforms(const struct scene_node *node, const struct scene_primitive *p) {
    return (node->skin != SCENE_NONE && p->joint_count > 0) || p->morph_target_count > 0;
}

/* Vertices that a node has for its own. */
static uint64_t own_vertices(const fnl_scene *scene, const struct scene_node *node) {
    const struct scene_mesh *mesh = &scene->meshes.data[node->mesh];
    uint64_t count = 0;
    for (uint32_t i = 0; i < mesh->primitive_count; i++) {
        const struct scene_primitive *p = &scene->primitives.data[mesh->first_primitive + i];
        if (device_node_deforms(node, p)) count += p->vertex_count;
    }
    return count;
}

fnl_result device_too_many_vertices(const struct device_scene *d) {
    log_error(&d->host, "%s: has more vertices or indices than 32-bit draws can address", d->scene->source);
    return FNL_ERROR_UNSUPPORTED;
}

/* Frees the place of a node that was removed or hidden, or that shows something else. */
static void give_place(struct device_scene *d, uint32_t n) {
    const struct scene_node *node = &d->scene->nodes.data[n];
    struct device_node *place = &d->nodes.data[n];
    if (place->first_instance == SCENE_NONE) return;
    if (device_node_draws(node) && place->generation == node->generation && place->mesh == node->mesh &&
        place->skin == node->skin && place->instance_count == MAX(node->instance_count, 1u))
        return;
    ranges_give(&d->host, &d->instances_taken, place->first_instance, place->instance_count);
    ranges_give(&d->host, &d->vertices_taken, place->first_vertex, place->vertex_count);
    *place = (struct device_node){.first_instance = SCENE_NONE, .first_primitive = SCENE_NONE};
}

static fnl_result take_place(struct device_scene *d, uint32_t n) {
    const struct scene_node *node = &d->scene->nodes.data[n];
    struct device_node *place = &d->nodes.data[n];
    uint64_t vertices = own_vertices(d->scene, node);
    if (vertices > INT32_MAX) return device_too_many_vertices(d);
    *place = (struct device_node){.generation = node->generation,
                                  .mesh = node->mesh,
                                  .skin = node->skin,
                                  .first_instance = ranges_take(&d->instances_taken, MAX(node->instance_count, 1u)),
                                  .instance_count = MAX(node->instance_count, 1u),
                                  .first_primitive = SCENE_NONE,
                                  .fresh = true};
    if (place->first_instance == RANGES_NONE || d->instances_taken.end > UINT32_MAX / sizeof(struct gpu_instance)) {
        log_error(&d->host, "%s: has more instances than a buffer of 4 GiB holds", d->scene->source);
        return FNL_ERROR_UNSUPPORTED;
    }
    if (vertices == 0) return FNL_OK;
    place->first_vertex = ranges_take(&d->vertices_taken, (uint32_t)vertices);
    place->vertex_count = (uint32_t)vertices;
    return place->first_vertex == RANGES_NONE || d->vertices_taken.end > INT32_MAX ? device_too_many_vertices(d) : FNL_OK;
}

static fnl_result send_instances(struct device_scene *d, uint32_t n) {
    const struct scene_node *node = &d->scene->nodes.data[n];
    struct gpu_instance chunk[256];
    for (uint32_t k = 0; k < node->instance_count;) {
        uint32_t part = MIN(node->instance_count - k, COUNT_OF(chunk));
        for (uint32_t i = 0; i < part; i++) {
            mat4 m = device_instance_matrix(d->scene, node, k + i);
            chunk[i] = device_instance(&m);
        }
        uint64_t first = (uint64_t)d->nodes.data[n].first_instance + k;
        TRY(device_upload(d, &d->instances, first * sizeof *chunk, chunk, part * sizeof *chunk));
        k += part;
    }
    return FNL_OK;
}

/* For the next frame of each user. From `first` on none has been drawn. */
static bool note_arrival(struct device_scene *d, const struct device_node *place, uint32_t first) {
    struct range *last = d->arrived.count > first ? &d->arrived.data[d->arrived.count - 1] : NULL;
    if (last && last->first + last->count == place->first_instance) {
        last->count += place->instance_count;
        return true;
    }
    const struct range range = {place->first_instance, place->instance_count};
    return array_push(&d->host, &d->arrived, range);
}

static fnl_result reserve_nodes(struct device_scene *d) {
    const fnl_scene *scene = d->scene;
    if (!array_reserve(&d->host, &d->nodes, scene->nodes.count)) return FNL_ERROR_MEMORY;
    while (d->nodes.count < scene->nodes.count)
        d->nodes.data[d->nodes.count++] =
            (struct device_node){.first_instance = SCENE_NONE, .first_primitive = SCENE_NONE};
    return FNL_OK;
}

fnl_result device_nodes_place(struct device_scene *d, const uint32_t *nodes, uint32_t count) {
    const fnl_scene *scene = d->scene;
    device_users_trim(d);
    const uint32_t first_arrived = d->arrived.count;
    TRY(reserve_nodes(d));
    for (uint32_t i = 0; i < count; i++) give_place(d, nodes ? nodes[i] : i);
    uint64_t before = d->instances.size;
    for (uint32_t i = 0; i < count; i++) {
        const uint32_t n = nodes ? nodes[i] : i;
        const struct scene_node *node = &scene->nodes.data[n];
        if (d->nodes.data[n].first_instance == SCENE_NONE && device_node_draws(node)) TRY(take_place(d, n));
        const bool mirrors = device_node_mirrors(scene, node);
        if (node->skin != SCENE_NONE && mirrors != d->nodes.data[n].mirrored && d->nodes.data[n].first_instance != SCENE_NONE)
            d->nodes.data[n].fresh = true; /* it has another instance */
        d->nodes.data[n].mirrored = mirrors;
        d->nodes.data[n].masked = scene->has_light_masks && node->unlit;
    }
    TRY(device_buffer_reserve(d, GPU_USE_GEOMETRY, "instances", &d->instances, before,
                              (uint64_t)d->instances_taken.end * sizeof(struct gpu_instance)));
    for (uint32_t i = 0; i < count; i++) {
        const uint32_t n = nodes ? nodes[i] : i;
        if (!d->nodes.data[n].fresh) continue;
        d->nodes.data[n].fresh = false;
        TRY(send_instances(d, n));
        if (!note_arrival(d, &d->nodes.data[n], first_arrived)) return FNL_ERROR_MEMORY;
    }
    return FNL_OK;
}

/* ---- edits of a few nodes ---- */

/* Whether a node is an instance that only comes or goes: one matrix, and no vertices of its own. */
static bool is_plain(const struct device_scene *d, uint32_t n) {
    const struct scene_node *node = &d->scene->nodes.data[n];
    const struct device_node *place = &d->nodes.data[n];
    if (place->first_instance != SCENE_NONE && (place->vertex_count || place->instance_count != 1)) return false;
    return !device_node_draws(node) || (!node->instances && node->instance_count == 1 && own_vertices(d->scene, node) == 0);
}

static void grow_bounds(struct device_scene *d, const struct scene_node *node) {
    mat4 matrix = device_instance_matrix(d->scene, node, 0);
    struct box box = box_transform(&d->scene->meshes.data[node->mesh].bounds, &matrix);
    if (!box_is_empty(&box)) box_add_box(&d->bounds, &box);
}

fnl_result device_nodes_edit(struct device_scene *d, uint64_t since, bool *done) {
    enum { MOST = 64 }; /* beyond this, sorting all items is cheaper than moving parts of the list so many times */
    const fnl_scene *scene = d->scene;
    uint32_t edited[MOST] = {0}, count = 0;
    *done = false;
    TRY(reserve_nodes(d));
    for (uint32_t i = 0; i < scene->edited.count; i++) {
        uint32_t n = scene->edited.data[i];
        if (scene->nodes.data[n].edited_version <= since) continue;
        if (count == MOST || !is_plain(d, n)) return FNL_OK;
        edited[count++] = n;
    }
    for (uint32_t i = 0; i < count; i++)
        if (d->nodes.data[edited[i]].first_instance != SCENE_NONE) device_items_remove(d, edited[i]);
    TRY(device_nodes_place(d, edited, count));
    for (uint32_t i = 0; i < count; i++) {
        if (d->nodes.data[edited[i]].first_instance == SCENE_NONE) continue;
        TRY(device_items_insert(d, edited[i]));
        grow_bounds(d, &scene->nodes.data[edited[i]]);
    }
    TRY(device_items_send(d));
    TRY(device_table_send(d));
    d->bounds_edits += count;
    if (d->bounds_edits > scene->nodes.count) { /* what went makes them smaller, once in a while */
        d->bounds = scene_bounds(scene);
        d->bounds_edits = 0;
    }
    *done = true;
    return FNL_OK;
}
