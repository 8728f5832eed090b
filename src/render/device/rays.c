/* SPDX-License-Identifier: MIT */
/* The scene for shadow rays: kept in step as long as some user's frames trace any. */
#include "render/device/scene.h"

/* A row for each primitive on the device: those of the scene, then those of nodes that deform. */
static struct gpu_ray_mesh mesh_of(const struct scene_primitive *p, uint32_t first) {
    const vec3 size = vec3_sub(p->bounds.high, p->bounds.low);
    const bool solid = p->topology == SCENE_TOPOLOGY_TRIANGLES;
    return (struct gpu_ray_mesh){
        .first = first,
        .count = solid ? p->index_count / 3 : 0,
        .low = p->bounds.low,
        .scale = {size.x > 0 ? 1 / size.x : 0, size.y > 0 ? 1 / size.y : 0, size.z > 0 ? 1 / size.z : 0}};
}

static fnl_result send_table(struct device_scene *d) {
    const fnl_scene *scene = d->scene;
    ARRAY(struct gpu_ray_mesh) table = {0};
    uint32_t count = scene->primitives.count, triangles = 0;
    for (uint32_t i = 0; i < d->deformed.count; i++)
        count += scene->meshes.data[scene->nodes.data[d->deformed.data[i].node].mesh].primitive_count;
    if (!array_reserve(&d->host, &table, MAX(count, 1u))) return FNL_ERROR_MEMORY;
    for (uint32_t i = 0; i < scene->primitives.count; i++) {
        table.data[i] = mesh_of(&scene->primitives.data[i], triangles);
        triangles += table.data[i].count;
    }
    table.count = scene->primitives.count;
    for (uint32_t i = 0; i < d->deformed.count; i++) {
        const struct scene_mesh *mesh = &scene->meshes.data[scene->nodes.data[d->deformed.data[i].node].mesh];
        for (uint32_t k = 0; k < mesh->primitive_count; k++) {
            const struct gpu_ray_mesh row = mesh_of(&scene->primitives.data[mesh->first_primitive + k], triangles);
            table.data[table.count++] = row;
            triangles += row.count;
        }
    }
    d->ray_primitives = count;
    d->ray_triangles = triangles;
    uint64_t key = hash_bytes(table.data, count * sizeof *table.data, 1);
    for (uint32_t i = 0; i < scene->primitives.count; i++) {
        const struct device_primitive *place = &d->primitive_places.data[i];
        const uint32_t words[] = {place->shape_version, place->first_vertex, place->first_index};
        key = hash_bytes(words, sizeof words, key);
    }
    for (uint32_t i = 0; i < d->deformed.count; i++) {
        const uint32_t node = d->deformed.data[i].node, words[] = {node, d->nodes.data[node].first_vertex};
        key = hash_bytes(words, sizeof words, key);
    }
    if (d->ray_key != key) d->sent.ray_meshes = UINT64_MAX;
    d->ray_key = key;
    fnl_result result = device_array_set(d, GPU_USE_GEOMETRY, "ray meshes", &d->ray_table, table.data, count, sizeof *table.data);
    array_free(&d->host, &table);
    return result;
}

static fnl_result keep(struct device_scene *d, const char *name, struct gpu_buffer *buffer, uint64_t size) {
    if (buffer->handle && buffer->size >= size) return FNL_OK;
    gpu_buffer_destroy(d->device, buffer);
    d->sent.ray_meshes = d->sent.ray_items = d->sent.ray_instances = UINT64_MAX;
    return gpu_buffer_create_for(d->device, GPU_USE_GEOMETRY, name, size + size / 2, GPU_MEMORY_DEVICE, buffer);
}

fnl_result device_rays_prepare(struct device_scene *d, struct device_rays_use use) {
    if (d->ray_structure != d->structure_version) {
        d->ray_structure = UINT64_MAX;
        TRY(send_table(d));
        d->ray_structure = d->structure_version;
        d->sent.ray_items = UINT64_MAX;
    }
    if (use.trees) TRY(keep(d, "ray meshes", &d->ray_meshes, rays_mesh_bytes(d->ray_triangles, d->ray_primitives)));
    TRY(keep(d, "ray items", &d->ray_items, rays_item_bytes(d->item_count, d->ray_primitives)));
    if (use.query) TRY(device_structures_prepare(d));
    return gpu_upload_submit(d->device);
}

struct rays device_rays_add(struct device_scene *d, struct graph *graph, const struct geometry_scene *geometry, struct device_rays_use use) {
    const uint64_t now = d->scene->transform_version;
    const bool makes =
        use.trees && (d->sent.ray_meshes == UINT64_MAX || (d->deformed.count > 0 && d->sent.ray_meshes != now));
    struct ray_query_input query;
    if (use.query && device_structures_add(d, &query) != FNL_OK) {
        gpu_fail(d->device, FNL_ERROR_MEMORY);
        return (struct rays){0};
    }
    const bool items = use.items || !use.query;
    struct rays rays = rays_add(graph, d->device,
                                &(struct rays_input){.vertices = geometry->vertices,
                                                     .scene = geometry->scene,
                                                     .indices = d->indices.address,
                                                     .mesh_table = d->ray_table.buffer.address,
                                                     .primitive_count = d->ray_primitives,
                                                     .triangle_count = d->ray_triangles,
                                                     .item_count = d->item_count,
                                                     .low = d->bounds.low,
                                                     .high = d->bounds.high,
                                                     .meshes = use.trees ? &d->ray_meshes : NULL,
                                                     .items = &d->ray_items,
                                                     .query = use.query ? &query : NULL,
                                                     .make_meshes = makes,
                                                     .place = items && (makes || d->sent.ray_items != now)});
    if (use.trees) d->sent.ray_meshes = now;
    if (items) d->sent.ray_items = now;
    return rays;
}

void device_rays_finish(struct device_scene *d) {
    gpu_buffer_destroy(d->device, &d->ray_meshes);
    gpu_buffer_destroy(d->device, &d->ray_items);
    gpu_buffer_destroy(d->device, &d->ray_table.buffer);
    array_free(&d->host, &d->ray_table.sent);
    d->ray_structure = UINT64_MAX;
    device_structures_finish(d);
}
