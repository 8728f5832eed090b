/* SPDX-License-Identifier: MIT */
/*
 * The scene in the device's own acceleration structures, for shadow rays by ray queries: one for each primitive that some item shows, and one over the
 * items. Each is built once. What deforms is updated in frames in which it moves, and built anew every UPDATES times: boxes that are only
 * stretched come to overlap. What does not deform is measured once it stands, and compacted when its measure is known.
 */
#include "render/device/scene.h"

enum {
    UPDATES = 32,
    GAIN = 16, /* of a structure that is compacted only if that frees a sixteenth of it */
};

static uint32_t vertices_of(const struct device_scene *d, uint32_t source) { return d->primitive_places.data[source].vertex_count; }

/* What a structure is made of: others of the same numbers can be updated from it. */
static struct device_structure row_of(const struct device_scene *d, uint32_t row, uint32_t source, uint32_t node) {
    const struct gpu_primitive *g = (const struct gpu_primitive *)(const void *)d->primitives.sent.data + row;
    const struct device_primitive *place = &d->primitive_places.data[source];
    const uint32_t words[] = {source, place->shape_version, g->index_count, place->vertex_count, node,
                              node == SCENE_NONE ? 0 : d->nodes.data[node].generation};
    return (struct device_structure){
        .key = hash_bytes(words, sizeof words, 1),
        .share = node != SCENE_NONE && g->bind_offset == 0 ? source : row,
        .query = GPU_NO_INDEX,
        .input = {.count = g->corners == 3 ? g->index_count / 3 : 0, .vertex_count = vertices_of(d, source), .changes = g->bind_offset != 0}};
}

/* ---- outside of frames ---- */

static void destroy_row(struct device_scene *d, struct device_structure *row) {
    gpu_structure_destroy(d->device, &row->made);
    gpu_structure_destroy(d->device, &row->smaller);
}

static void drop_queries(struct device_structures *s, gpu_device *device) {
    gpu_structure_queries_destroy(device, &s->queries);
    for (uint32_t i = 0; i < s->rows.count; i++) s->rows.data[i].query = GPU_NO_INDEX;
}

/* Rows follow the primitives: those of the scene, then those of nodes that deform. */
static fnl_result list_rows(struct device_scene *d, device_structure_list *rows) {
    const fnl_scene *scene = d->scene;
    for (uint32_t i = 0; i < scene->primitives.count; i++)
        if (!array_push(&d->host, rows, row_of(d, i, i, SCENE_NONE))) return FNL_ERROR_MEMORY;
    for (uint32_t i = 0; i < d->deformed.count; i++) {
        const uint32_t node = d->deformed.data[i].node;
        const struct scene_mesh *mesh = &scene->meshes.data[scene->nodes.data[node].mesh];
        for (uint32_t k = 0; k < mesh->primitive_count; k++) {
            const struct device_structure row = row_of(d, rows->count, mesh->first_primitive + k, node);
            if (!array_push(&d->host, rows, row)) return FNL_ERROR_MEMORY;
        }
    }
    for (uint32_t i = 0; i < d->item_list.count; i++) rows->data[rows->data[d->item_list.data[i].primitive].share].wanted = true;
    return FNL_OK;
}

/* Takes over what stays as it was. Primitives of the scene keep their numbers; those of nodes that deform, of which there are few, their order. */
static void keep_rows(device_structure_list *before, uint32_t before_deformed, device_structure_list *rows, uint32_t deformed) {
    for (uint32_t i = 0, at = before_deformed; i < rows->count; i++) {
        struct device_structure *row = &rows->data[i];
        if (!row->wanted || row->share != i || row->input.count == 0) continue;
        uint32_t k = i < deformed ? i : at;
        while (i >= deformed && k < before->count && before->data[k].key != row->key) k++;
        if (k >= before->count || before->data[k].key != row->key) continue;
        struct device_structure *old = &before->data[k];
        row->made = old->made, row->smaller = old->smaller;
        row->build_scratch = old->build_scratch, row->update_scratch = old->update_scratch;
        row->built = old->built, row->measured = old->measured, row->updates = old->updates;
        old->made = old->smaller = (struct gpu_structure){0};
        if (i >= deformed) at = k + 1;
    }
}

static fnl_result make_rows(struct device_scene *d) {
    struct device_structures *s = &d->structures;
    device_structure_list rows = {0};
    const fnl_result result = list_rows(d, &rows);
    if (result == FNL_OK) {
        keep_rows(&s->rows, s->first_deformed, &rows, d->scene->primitives.count);
        s->first_deformed = d->scene->primitives.count;
        for (uint32_t i = 0; i < s->rows.count; i++) destroy_row(d, &s->rows.data[i]);
        array_free(&d->host, &s->rows);
        s->rows.data = rows.data, s->rows.count = rows.count, s->rows.capacity = rows.capacity;
        drop_queries(s, d->device);
    } else array_free(&d->host, &rows);
    return result;
}

static fnl_result create_rows(struct device_scene *d) {
    struct device_structures *s = &d->structures;
    s->unbuilt = s->unmeasured = 0;
    for (uint32_t i = 0; i < s->rows.count; i++) {
        struct device_structure *row = &s->rows.data[i];
        if (!row->wanted || row->share != i || row->input.count == 0) continue;
        if (!row->made.handle) {
            const struct gpu_structure_sizes sizes = gpu_structure_sizes(d->device, &row->input);
            TRY(gpu_structure_create(d->device, "ray structure", false, sizes.size, &row->made));
            row->build_scratch = sizes.build_scratch, row->update_scratch = sizes.update_scratch;
            row->updates = i % UPDATES; /* so that not all are built anew in one frame */
        }
        s->unbuilt += !row->built;
        s->unmeasured += !row->measured && !row->input.changes;
    }
    return FNL_OK;
}

static fnl_result create_top(struct device_scene *d) {
    struct device_structures *s = &d->structures;
    if (!s->bottoms.handle) TRY(gpu_buffer_create_for(d->device, GPU_USE_GEOMETRY, "ray structures", 16, GPU_MEMORY_DEVICE, &s->bottoms));
    if (s->top.handle && s->top_capacity >= d->item_count) return FNL_OK;
    d->sent.ray_instances = UINT64_MAX;
    gpu_structure_destroy(d->device, &s->top);
    gpu_buffer_destroy(d->device, &s->instances);
    s->top_capacity = d->item_count + d->item_count / 2;
    const struct gpu_structure_input input = {.count = s->top_capacity, .of_instances = true};
    const struct gpu_structure_sizes sizes = gpu_structure_sizes(d->device, &input);
    s->top_scratch = sizes.build_scratch;
    TRY(gpu_buffer_create_for(d->device, GPU_USE_GEOMETRY, "ray instances", ray_query_instance_bytes(s->top_capacity), GPU_MEMORY_DEVICE, &s->instances));
    return gpu_structure_create(d->device, "ray top", true, sizes.size, &s->top);
}

/* The sizes that a frame has measured, once it is over: makes room for what gets smaller. */
static fnl_result read_sizes(struct device_scene *d) {
    struct device_structures *s = &d->structures;
    if (!s->queries.handle || !s->asked || gpu_frame_number(d->device) < s->asked_frame + GPU_FRAMES_IN_FLIGHT) return FNL_OK;
    const size_t bytes = s->queries.count * sizeof(uint64_t);
    uint64_t *sizes = host_allocate(&d->host, bytes);
    if (!sizes) return FNL_ERROR_MEMORY;
    const bool known = gpu_structure_queries_read(d->device, &s->queries, sizes);
    fnl_result result = FNL_OK;
    for (uint32_t i = 0; i < s->rows.count && result == FNL_OK; i++) {
        struct device_structure *row = &s->rows.data[i];
        if (row->query == GPU_NO_INDEX) continue;
        row->measured = true;
        s->unmeasured--;
        if (!known || sizes[row->query] + row->made.buffer.size / GAIN > row->made.buffer.size) continue;
        result = gpu_structure_create(d->device, "ray structure", false, sizes[row->query], &row->smaller);
        s->copies++;
    }
    host_free(&d->host, sizes, bytes);
    drop_queries(s, d->device);
    return result;
}

/* Queries for all that stands and was not measured. */
static fnl_result ask_sizes(struct device_scene *d) {
    struct device_structures *s = &d->structures;
    uint32_t count = 0;
    if (s->queries.handle || s->unmeasured == 0 || s->unbuilt > 0) return FNL_OK;
    for (uint32_t i = 0; i < s->rows.count; i++) {
        struct device_structure *row = &s->rows.data[i];
        if (row->built && !row->measured && !row->input.changes) row->query = count++;
    }
    s->asked = false;
    return count ? gpu_structure_queries_create(d->device, count, &s->queries) : FNL_OK;
}

/* What the items' primitives are found by. */
static fnl_result send_addresses(struct device_scene *d) {
    struct device_structures *s = &d->structures;
    const size_t bytes = MAX(s->rows.count, 1u) * sizeof(VkDeviceAddress);
    VkDeviceAddress *addresses = host_allocate_zero(&d->host, bytes);
    if (!addresses) return FNL_ERROR_MEMORY;
    for (uint32_t i = 0; i < s->rows.count; i++) {
        const struct device_structure *row = &s->rows.data[s->rows.data[i].share];
        addresses[i] = row->smaller.handle ? row->smaller.address : row->made.address;
    }
    const fnl_result result = device_array_set(d, GPU_USE_GEOMETRY, "ray structure addresses", &s->addresses, addresses, s->rows.count, sizeof *addresses);
    host_free(&d->host, addresses, bytes);
    return result;
}

fnl_result device_structures_prepare(struct device_scene *d) {
    struct device_structures *s = &d->structures;
    const uint32_t copies = s->copies;
    const bool changed = s->structure != d->structure_version;
    if (changed) {
        s->structure = UINT64_MAX;
        d->sent.ray_instances = UINT64_MAX;
        TRY(make_rows(d));
        TRY(create_rows(d));
    }
    TRY(create_top(d));
    TRY(read_sizes(d));
    TRY(ask_sizes(d));
    if (changed || s->copies != copies) TRY(send_addresses(d));
    s->structure = d->structure_version;
    return FNL_OK;
}

void device_structures_forget(struct device_scene *d) {
    struct device_structures *s = &d->structures;
    for (uint32_t i = 0; i < s->rows.count; i++) destroy_row(d, &s->rows.data[i]);
    gpu_structure_queries_destroy(d->device, &s->queries);
    s->rows.count = s->unbuilt = s->unmeasured = s->copies = 0;
    s->structure = UINT64_MAX;
    s->declared = false;
}

void device_structures_finish(struct device_scene *d) {
    struct device_structures *s = &d->structures;
    device_structures_forget(d);
    gpu_structure_destroy(d->device, &s->top);
    gpu_buffer_destroy(d->device, &s->bottoms);
    gpu_buffer_destroy(d->device, &s->instances);
    gpu_buffer_destroy(d->device, &s->addresses.buffer);
    array_free(&d->host, &s->addresses.sent);
    array_free(&d->host, &s->rows);
    array_free(&d->host, &s->builds);
    array_free(&d->host, &s->changed);
    array_free(&d->host, &s->moves);
    array_free(&d->host, &s->measured);
}

/* ---- in a frame ---- */

/* A row to build or to update. */
static bool add_build(struct device_scene *d, uint32_t index) {
    struct device_structures *s = &d->structures;
    const struct device_structure *row = &s->rows.data[index];
    const struct gpu_primitive *g = (const struct gpu_primitive *)(const void *)d->primitives.sent.data + index;
    struct gpu_structure_build build = {.input = row->input,
                                        .to = &row->made,
                                        .update = row->built && row->updates < UPDATES,
                                        .scratch = row->built && row->updates < UPDATES ? row->update_scratch : row->build_scratch};
    build.input.positions = d->positions.address + (uint64_t)(uint32_t)g->vertex_offset * 12;
    build.input.indices = d->indices.address + g->first_index * 4ull;
    if (build.update)
        s->frame.updated++;
    else
        s->frame.built++;
    return array_push(&d->host, &s->builds, build) && array_push(&d->host, &s->changed, index);
}

static bool list_work(struct device_scene *d, bool moved) {
    struct device_structures *s = &d->structures;
    s->builds.count = s->changed.count = s->moves.count = s->measured.count = 0;
    s->frame = (struct device_structure_work){0};
    const bool all = s->unbuilt > 0 || s->copies > 0 || (s->queries.handle && !s->asked);
    for (uint32_t i = all ? 0 : d->scene->primitives.count; i < s->rows.count; i++) {
        const struct device_structure *row = &s->rows.data[i];
        if (!row->made.handle) continue;
        if ((!row->built || (moved && row->input.changes)) && !add_build(d, i)) return false;
        if (row->smaller.handle && !array_push(&d->host, &s->moves, ((struct ray_query_copy){row->made, row->smaller}))) return false;
        if (row->query != GPU_NO_INDEX && !s->asked && !array_push(&d->host, &s->measured, row->made)) return false;
    }
    s->frame.compacted = s->moves.count;
    return true;
}

fnl_result device_structures_add(struct device_scene *d, struct ray_query_input *out) {
    struct device_structures *s = &d->structures;
    const uint64_t now = d->scene->transform_version;
    if (!list_work(d, d->sent.ray_poses != now)) return FNL_ERROR_MEMORY;
    *out = (struct ray_query_input){.bottoms = &s->bottoms,
                                    .top = &s->top,
                                    .instances = &s->instances,
                                    .structures = s->addresses.buffer.address,
                                    .builds = s->builds.data,
                                    .build_count = s->builds.count,
                                    .copies = s->moves.data,
                                    .copy_count = s->moves.count,
                                    .queries = &s->queries,
                                    .measured = s->measured.data,
                                    .measured_count = s->measured.count,
                                    .top_scratch = s->top_scratch,
                                    .place = s->builds.count > 0 || s->moves.count > 0 || d->sent.ray_instances != now};
    s->frame.instances = d->item_count;
    s->frame.placed = out->place;
    d->sent.ray_poses = d->sent.ray_instances = now;
    s->declared = true;
    return FNL_OK;
}

void device_structures_submitted(struct device_scene *d) {
    struct device_structures *s = &d->structures;
    if (!s->declared) return;
    s->declared = false;
    for (uint32_t i = 0; i < s->changed.count; i++) {
        struct device_structure *row = &s->rows.data[s->changed.data[i]];
        row->updates = s->builds.data[i].update ? row->updates + 1 : row->built ? 0 : row->updates;
        s->unbuilt -= !row->built;
        row->built = true;
    }
    for (uint32_t i = 0; i < s->rows.count && s->moves.count > 0; i++) {
        struct device_structure *row = &s->rows.data[i];
        if (!row->smaller.handle) continue;
        gpu_structure_destroy(d->device, &row->made);
        row->made = row->smaller;
        row->smaller = (struct gpu_structure){0};
        s->copies--;
    }
    if (s->measured.count > 0) {
        s->asked = true;
        s->asked_frame = gpu_frame_number(d->device);
    }
}
