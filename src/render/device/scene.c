/* SPDX-License-Identifier: MIT */
#include "render/device/scene.h"

void device_scene_init(struct device_scene *d, gpu_device *device, fnl_scene *scene) {
    *d = (struct device_scene){.device = device,
                               .host = *gpu_host(device),
                               .scene = scene,
                               .structure_version = UINT64_MAX,
                               .material_version = UINT64_MAX,
                               .sent = {UINT64_MAX, UINT64_MAX, UINT64_MAX, UINT64_MAX, UINT64_MAX, UINT64_MAX, UINT64_MAX,
                                        UINT64_MAX, UINT64_MAX, UINT64_MAX, 0, false},
                               .environment_version = UINT64_MAX,
                               .ray_structure = UINT64_MAX,
                               .structures = {.structure = UINT64_MAX},
                               .decals = {.version = UINT64_MAX}};
}

fnl_result device_upload_array(struct device_scene *d, enum gpu_use use, const char *name, struct gpu_buffer *buffer, const void *data,
                               uint64_t size) {
    TRY(gpu_buffer_create_for(d->device, use, name, MAX(size, 16u), GPU_MEMORY_DEVICE, buffer));
    return size ? gpu_upload_buffer(d->device, buffer, 0, data, size) : FNL_OK;
}

fnl_result device_upload(struct device_scene *d, const struct gpu_buffer *buffer, uint64_t offset, const void *data,
                         uint64_t size) {
    d->bytes_uploaded += size;
    return gpu_upload_buffer(d->device, buffer, offset, data, size);
}

fnl_result device_buffer_reserve(struct device_scene *d, enum gpu_use use, const char *name, struct gpu_buffer *buffer, uint64_t used,
                                 uint64_t needed) {
    if (buffer->handle && buffer->size >= needed) return FNL_OK;
    uint64_t size = buffer->handle ? MAX(needed, buffer->size + buffer->size / 2) : MAX(needed, 16u);
    return gpu_grow_buffer(d->device, use, name, buffer, MIN(used, buffer->size), size);
}

fnl_result device_array_set(struct device_scene *d, enum gpu_use use, const char *name, struct device_array *array, const void *data,
                            uint64_t count, uint32_t stride) {
    enum { BLOCK = 256, APART = 64 }; /* elements compared at once; bytes from which on two copies pay */
    uint64_t size = count * stride, common = MIN(size, array->sent.count);
    TRY(device_buffer_reserve(d, use, name, &array->buffer, array->sent.count, size));
    if (!array_reserve(&d->host, &array->sent, size)) return FNL_ERROR_MEMORY;
    const char *bytes = data;
    char *sent = array->sent.data;
    for (uint64_t at = 0; at < size;) {
        uint64_t block = MIN((uint64_t)BLOCK * stride, common > at ? common - at : 0);
        if (block && memcmp(sent + at, bytes + at, block) == 0) {
            at += block;
            continue;
        }
        while (at < common && memcmp(sent + at, bytes + at, stride) == 0) at += stride;
        uint64_t end = at; /* of what differs */
        for (uint64_t i = at; i < size && i < end + MAX(APART, stride); i += stride)
            if (i >= common || memcmp(sent + i, bytes + i, stride) != 0) end = i + stride;
        TRY(device_upload(d, &array->buffer, at, bytes + at, end - at));
        memcpy(sent + at, bytes + at, end - at);
        at = end;
    }
    array->sent.count = (uint32_t)size;
    return FNL_OK;
}

static void free_structure(struct device_scene *d) {
    struct gpu_buffer *buffers[] = {&d->positions, &d->attributes, &d->indices,  &d->influences,   &d->morphs,
                                    &d->instances, &d->clusters,   &d->cluster_words};
    for (uint32_t i = 0; i < COUNT_OF(buffers); i++) gpu_buffer_destroy(d->device, buffers[i]);
    struct device_array *arrays[] = {&d->primitives, &d->materials, &d->layers, &d->profiles, &d->material_entries, &d->items,
                                     &d->groups,     &d->table,     &d->deforms, &d->lobes};
    for (uint32_t i = 0; i < COUNT_OF(arrays); i++) {
        gpu_buffer_destroy(d->device, &arrays[i]->buffer);
        array_free(&d->host, &arrays[i]->sent);
    }
    struct ranges *ranges[] = {&d->vertices_taken, &d->indices_taken, &d->instances_taken, &d->clusters_taken, &d->words_taken, &d->influences_taken, &d->morphs_taken};
    for (uint32_t i = 0; i < COUNT_OF(ranges); i++) ranges_finish(&d->host, ranges[i]);
    device_users_lose(d);
    device_users_trim(d);
    d->group_list.count = d->item_list.count = d->item_nodes.count = 0;
    d->primitive_places.count = d->nodes.count = d->buckets.count = d->deformed.count = d->deform_vertex_counts.count = 0;
    d->ray_structure = UINT64_MAX;
    d->ray_key = 0;
    device_structures_forget(d);
    d->leaning = false;
    d->color_bits = d->index_count = d->influence_count = d->morph_count = d->pool_triangles = 0;
}

/* Of a frame that was declared and not submitted. */
static void take_back(struct device_scene *d) {
    if (d->declared) d->sent = d->sent_before;
    d->declared = d->structures.declared = false;
}

void device_scene_finish(struct device_scene *d) {
    take_back(d);
    free_structure(d);
    device_images_free(d);
    device_decals_finish(d);
    device_lights_finish(d);
    device_rays_finish(d);
    device_environment_finish(d);
    array_free(&d->host, &d->images);
    array_free(&d->host, &d->buckets);
    array_free(&d->host, &d->group_list);
    array_free(&d->host, &d->item_list);
    array_free(&d->host, &d->item_nodes);
    array_free(&d->host, &d->primitive_places);
    array_free(&d->host, &d->nodes);
    array_free(&d->host, &d->arrived);
    array_free(&d->host, &d->deformed);
    array_free(&d->host, &d->deform_vertex_counts);
}

void device_scene_forget(struct device_scene *d) {
    take_back(d);
    d->structure_version = d->decals.version = d->environment_version = d->sent.lights = d->sent.decals = UINT64_MAX;
}

/* Nodes that moved since the device was last told: those of the scene's list, or any when a step was missed. */
static bool moved_nodes_listed(const struct device_scene *d) { return d->sent.transforms >= d->scene->moved_since; }

/* Draws are sorted by handedness: they are made anew when a node begins or ceases to mirror. */
static bool handedness_changed(const struct device_scene *d) {
    const fnl_scene *scene = d->scene;
    if (d->sent.transforms == scene->transform_version) return false;
    bool listed = moved_nodes_listed(d);
    uint32_t count = listed ? scene->moved.count : scene->nodes.count;
    for (uint32_t i = 0; i < count; i++) {
        uint32_t n = listed ? scene->moved.data[i] : i;
        if (n >= d->nodes.count) continue; /* has come since */
        const struct device_node *place = &d->nodes.data[n];
        if (place->first_instance != SCENE_NONE && device_node_mirrors(scene, &scene->nodes.data[n]) != place->mirrored) return true;
    }
    for (uint32_t i = 0; i < d->deformed.count; i++) { /* by joints, which need not be listed */
        const uint32_t n = d->deformed.data[i].node;
        if (n < scene->nodes.count && d->nodes.data[n].first_instance != SCENE_NONE && scene->nodes.data[n].generation == d->nodes.data[n].generation &&
            device_node_mirrors(scene, &scene->nodes.data[n]) != d->nodes.data[n].mirrored)
            return true;
    }
    return false;
}

/* Since `before`; UINT64_MAX: nothing is there. */
static fnl_result prepare_structure(struct device_scene *d, uint64_t before, bool mirrors) {
    const fnl_scene *scene = d->scene;
    bool done = false;
    if (before == UINT64_MAX) {
        free_structure(d);
        device_images_free(d);
        d->material_version = UINT64_MAX;
    }
    if (before != UINT64_MAX && before >= scene->edited_since && !mirrors) TRY(device_nodes_edit(d, before, &done));
    if (!done) {
        if (d->material_version != scene->material_version) {
            bool regroup; /* everything is sorted below */
            TRY(device_images_upload(d));
            TRY(device_materials_upload(d, &regroup));
            d->texture_version++;
        }
        TRY(device_geometry_upload(d));
        if (before == UINT64_MAX) d->sent.transforms = scene->transform_version; /* all instances came as they stand */
        d->bounds = scene_bounds(scene);
        d->bounds_edits = 0;
    }
    d->upload_count++;
    d->material_version = scene->material_version;
    d->structure_version = scene->structure_version;
    return FNL_OK;
}

fnl_result device_scene_reserve_triangles(struct device_scene_user *user, uint32_t count, uint32_t views) {
    struct device_scene *d = user->scene;
    user->pool_triangles = count;
    count *= views;
    if (count <= d->pool_triangles) return FNL_OK;
    uint64_t used = d->index_count * 4ull, needed = used + count * 12ull;
    if (d->indices.size < needed) TRY(gpu_grow_buffer(d->device, GPU_USE_GEOMETRY, "indices", &d->indices, used, needed));
    d->pool_triangles = count;
    return gpu_upload_submit(d->device);
}

static fnl_result prepare(struct device_scene *d) {
    const bool mirrors = handedness_changed(d); /* sorts all */
    if (d->structure_version != d->scene->structure_version || mirrors) {
        const uint64_t before = d->structure_version;
        d->structure_version = UINT64_MAX; /* until it is whole */
        TRY(prepare_structure(d, before, mirrors));
    }
    TRY(device_images_take(d));
    TRY(device_decals_prepare(d));
    TRY(device_users_prepare(d));
    TRY(device_lights_prepare(d));
    TRY(device_environment_prepare(d));
    return gpu_upload_submit(d->device);
}

fnl_result device_scene_prepare(struct device_scene *d) {
    take_back(d);
    const fnl_result result = prepare(d);
    if (result != FNL_OK || gpu_status(d->device) != FNL_OK) device_scene_forget(d);
    return result;
}

/* ---- updates inside a frame ---- */

struct move_data {
    struct device_scene *d;
    const uint32_t *nodes;
    uint32_t node_count;
    struct gpu_slice slice;
};

static void execute_move(const struct graph_context *context, const void *data) {
    const struct move_data *m = data;
    uint64_t offset = m->slice.offset;
    for (uint32_t i = 0; i < m->node_count; i++) {
        uint32_t first = m->d->nodes.data[m->nodes[i]].first_instance;
        uint64_t size = m->d->scene->nodes.data[m->nodes[i]].instance_count * sizeof(struct gpu_instance);
        gpu_copy_buffer(context->commands, m->slice.buffer, offset, &m->d->instances, first * sizeof(struct gpu_instance),
                        size);
        offset += size;
    }
}

/* Sends the instances of nodes that moved since the last frame. */
static fnl_result add_moves(struct device_scene *d, struct graph *graph, graph_buffer vertices) {
    const fnl_scene *scene = d->scene;
    if (d->sent.transforms == scene->transform_version) return FNL_OK;
    bool listed = moved_nodes_listed(d);
    uint32_t candidate_count = listed ? scene->moved.count : scene->nodes.count;
    uint64_t size = 0;
    uint32_t count = 0;
    struct gpu_slice nodes = gpu_frame_allocate(d->device, MAX(candidate_count, 1u) * sizeof(uint32_t));
    if (!nodes.data) return gpu_status(d->device);
    for (uint32_t i = 0; i < candidate_count; i++) {
        uint32_t n = listed ? scene->moved.data[i] : i;
        if (scene->nodes.data[n].moved_version <= d->sent.transforms) continue;
        if (d->nodes.data[n].first_instance == SCENE_NONE || scene->nodes.data[n].skin != SCENE_NONE) continue;
        ((uint32_t *)nodes.data)[count++] = n;
        size += scene->nodes.data[n].instance_count * sizeof(struct gpu_instance);
    }
    if (d->sent.transforms < scene->origin_version) d->bounds = scene_bounds(scene); /* not grown by the move */
    d->sent.transforms = scene->transform_version;
    if (count == 0) return FNL_OK;
    struct move_data move = {.d = d, .nodes = nodes.data, .node_count = count, .slice = gpu_frame_allocate(d->device, size)};
    if (!move.slice.data) return gpu_status(d->device);
    struct gpu_instance *out = move.slice.data;
    for (uint32_t i = 0; i < count; i++) {
        const struct scene_node *node = &scene->nodes.data[move.nodes[i]];
        device_scene_node_instances(scene, node, out);
        for (uint32_t k = 0; k < node->instance_count; k++) {
            mat4 matrix = device_instance_matrix(scene, node, k);
            struct box box = box_transform(&scene->meshes.data[node->mesh].bounds, &matrix);
            if (!box_is_empty(&box)) box_add_box(&d->bounds, &box);
        }
        out += node->instance_count;
    }
    struct graph_pass *pass =
        graph_add_pass(graph, "update instances", GRAPH_QUEUE_GRAPHICS, execute_move, &move, sizeof move);
    graph_use_buffer(pass, vertices, GRAPH_COPY_TO);
    return FNL_OK;
}

/* Whether vertices that deform are not those of the present transforms and weights. */
static bool must_deform(const struct device_scene *d) {
    return d->deformed.count > 0 && d->sent.poses != d->scene->transform_version;
}

static fnl_result add_deforms(struct device_scene *d, struct graph *graph, graph_buffer vertices) {
    if (!must_deform(d)) return FNL_OK;
    const fnl_scene *scene = d->scene;
    struct gpu_slice matrices = gpu_frame_allocate(d->device, MAX(d->matrix_count, 1u) * sizeof(mat4));
    struct gpu_slice weights = gpu_frame_allocate(d->device, MAX(d->weight_count, 1u) * sizeof(float));
    if (!matrices.data || !weights.data) return gpu_status(d->device);
    for (uint32_t i = 0; i < d->deformed.count; i++) {
        const struct device_deform *deform = &d->deformed.data[i];
        const struct scene_node *node = &scene->nodes.data[deform->node];
        const float *values = node->morph_weights ? node->morph_weights : scene->meshes.data[node->mesh].morph_weights;
        for (uint32_t w = 0; w < deform->weight_count; w++)
            ((float *)weights.data)[deform->first_weight + w] = values ? values[w] : 0;
        if (deform->matrix_count)
            skin_instance_matrices(scene, deform->skin, d->nodes.data[deform->node].mirrored, (mat4 *)matrices.data + deform->first_matrix);
    }
    struct skin_input input = {.vertices = vertices,
                               .positions = d->positions.address,
                               .attributes = d->attributes.address,
                               .deforms = d->deforms.buffer.address,
                               .influences = d->influences.address,
                               .morphs = d->morphs.address,
                               .weights = weights.address,
                               .matrices = matrices.address,
                               .vertex_counts = d->deform_vertex_counts.data,
                               .deform_count = d->deform_vertex_counts.count};
    skin_add(graph, &input);
    d->sent.poses = scene->transform_version;
    return FNL_OK;
}

fnl_result device_scene_add(struct device_scene_user *user, struct graph *graph, struct device_scene_frame *out) {
    struct device_scene *d = user->scene;
    take_back(d);
    d->declared = true;
    d->sent_before = d->sent;
    d->overwrites = d->sent.transforms != d->scene->transform_version || must_deform(d);
    graph_buffer vertices = graph_import_buffer(graph, "scene vertices", &d->positions);
    graph_buffer lights = graph_import_buffer(graph, "lights", &d->lights);
    TRY(device_lights_add(d, graph, lights));
    TRY(device_users_add(user, graph, vertices, out));
    TRY(add_moves(d, graph, vertices));
    TRY(add_deforms(d, graph, vertices));
    out->geometry = (struct geometry_scene){.scene = d->table.buffer.address,
                                            .material_entries = d->material_entries.buffer.address,
                                            .indices = &d->indices,
                                            .vertices = vertices,
                                            .buckets = d->buckets.data,
                                            .bucket_count = d->buckets.count,
                                            .item_count = d->item_count,
                                            .attributes = d->color_bits | d->texture_bits,
                                            .most_triangles = d->most_triangles,
                                            .material_count = d->material_count,
                                            .material_classes = d->material_classes,
                                            .features = (d->scene->has_light_masks ? GPU_FEATURE_LIGHT_MASKS : 0) |
                                                        (d->leaning || d->mapped ? GPU_FEATURE_LEANING : 0),
                                            .gradient_taps = gpu_isotropic_gradients(d->device) ? d->scene->anisotropy : 1,
                                            .group_count = d->group_count,
                                            .unit_count = d->unit_count,
                                            .blend_first_item = d->blend_first_item,
                                            .blend_item_count = d->blend_item_count,
                                            .caster_count = d->caster_count,
                                            .cluster_count = d->cluster_count,
                                            .triangle_count = d->triangle_count,
                                            .index_count = d->index_count,
                                            .pool_triangles = user->pool_triangles};
    out->lights = device_lights_set(d, lights);
    out->environment = device_environment_add(d, graph);
    out->layered = device_has_layers(d);
    return FNL_OK;
}
