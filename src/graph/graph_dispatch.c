/* SPDX-License-Identifier: MIT */
/** Rows: a use of a resource together with the place of its address. And passes that are dispatches. */
#include "graph/graph_internal.h"

/* ---- rows ---- */

/* Where a row's member stands in the copy of the pass's data, or NULL after a logged error. */
static void *place_of(struct graph_pass *pass, const struct graph_row *row, size_t size) {
    uintptr_t first = (uintptr_t)pass->original, member = (uintptr_t)row->member;
    if (member - first <= pass->original_size && pass->original_size - (member - first) >= size)
        return (char *)pass->copy + (member - first);
    const struct graph_resource *resource = graph_find_resource(pass->graph, row->id, row->is_image);
    graph_misuse(pass->graph, "pass '%s' has a row for '%s' whose member is outside of its %zu bytes", pass->name,
                 resource ? resource->name : "no resource", pass->original_size);
    return NULL;
}

void graph_add_row(struct graph_pass *pass, struct graph_row row) {
    if (!pass || row.is_absent) return;
    if (row.is_image)
        graph_use_image(pass, (graph_image){row.id}, row.use);
    else
        graph_use_buffer(pass, (graph_buffer){row.id}, row.use);
    if (!row.member || pass->graph->result != FNL_OK) return;
    void *place = place_of(pass, &row, row.is_image ? sizeof(uint32_t) : sizeof(uint64_t));
    struct graph_patch *patch = place ? arena_allocate(&pass->graph->arena, sizeof *patch) : NULL;
    if (!patch) {
        graph_fail(pass->graph, FNL_ERROR_MEMORY); /* unless it failed already */
        return;
    }
    *patch = (struct graph_patch){.next = pass->patches, .row = row, .place = place};
    pass->patches = patch;
}

void graph_patch_data(const struct graph_context *context, const struct graph_pass *pass) {
    for (const struct graph_patch *patch = pass->patches; patch; patch = patch->next) {
        const struct graph_row *row = &patch->row;
        if (!row->is_image) {
            uint64_t address = graph_address(context, (graph_buffer){row->id}) + row->offset;
            memcpy(patch->place, &address, sizeof address);
            continue;
        }
        bool sampled = row->use == GRAPH_SAMPLE_COMPUTE || row->use == GRAPH_SAMPLE_FRAGMENT;
        const graph_image image = {row->id};
        uint32_t index = sampled ? graph_sampled(context, image) : graph_storage(context, image);
        memcpy(patch->place, &index, sizeof index);
    }
}

/* ---- dispatches ---- */

struct dispatch_data {
    struct dispatch_data *next; /* of the same pass */
    struct gpu_compute_params pipeline;
    uint32_t groups[3];
    graph_buffer indirect;
    uint64_t indirect_offset;
    uint32_t push_size;
    _Alignas(16) char push[GPU_PUSH_BYTES];
};

static void execute_dispatches(const struct graph_context *context, const void *data) {
    const struct gpu_pipeline *bound = NULL;
    for (const struct dispatch_data *d = data; d; d = d->next) {
        if (!d->indirect.id && d->groups[0] == 0) continue;
        const struct gpu_pipeline *pipeline = gpu_compute_pipeline(context->device, &d->pipeline);
        if (pipeline != bound || !pipeline) gpu_bind(context->commands, bound = pipeline);
        if (d->push_size) gpu_push(context->commands, d->push, d->push_size);
        if (d->indirect.id)
            gpu_dispatch_indirect(context->commands, graph_get_buffer(context, d->indirect), d->indirect_offset);
        else if (d->groups[1])
            gpu_dispatch(context->commands, d->groups[0], d->groups[1], MAX(d->groups[2], 1u));
        else
            gpu_dispatch_linear(context->commands, d->groups[0]);
    }
}

/* The data of one more dispatch in a pass, or NULL after an error. */
static struct dispatch_data *append(struct graph_pass *pass, const struct dispatch_data *data) {
    if (pass->execute != execute_dispatches) {
        graph_misuse(pass->graph, "pass '%s' is given one more dispatch, but graph_dispatch did not add it", pass->name);
        return NULL;
    }
    struct dispatch_data *copy = arena_allocate(&pass->graph->arena, sizeof *copy);
    if (!copy) {
        graph_fail(pass->graph, FNL_ERROR_MEMORY);
        return NULL;
    }
    memcpy(copy, data, sizeof *copy);
    struct dispatch_data *last = (struct dispatch_data *)((char *)pass->copy - offsetof(struct dispatch_data, push));
    return last->next = copy;
}

struct graph_pass *graph_dispatch(struct graph *graph, const struct graph_dispatch *dispatch) {
    struct graph_pass *pass = dispatch->pass;
    struct dispatch_data data, *copy;
    memset(&data, 0, sizeof data); /* pipelines are hashed as bytes */
    data.pipeline.shader = dispatch->pipeline.shader;
    data.pipeline.constant_count = dispatch->pipeline.constant_count;
    memcpy(data.pipeline.constants, dispatch->pipeline.constants, dispatch->pipeline.constant_count * sizeof(uint32_t));
    data.indirect = dispatch->indirect;
    data.indirect_offset = dispatch->indirect_offset;
    data.push_size = (uint32_t)dispatch->push_size;
    memcpy(data.groups, dispatch->groups, sizeof data.groups);
    if (dispatch->push_size > sizeof data.push) {
        graph_misuse(graph, "pass '%s' has %zu bytes of push constants, which is more than %zu",
                     pass ? pass->name : dispatch->name, dispatch->push_size, sizeof data.push);
        return pass;
    }
    if (dispatch->push_size) memcpy(data.push, dispatch->push, dispatch->push_size);
    if (pass) {
        copy = append(pass, &data);
        if (!copy) return pass;
    } else {
        pass = graph_add_pass(graph, dispatch->name, dispatch->queue, execute_dispatches, &data, sizeof data);
        if (!pass) return NULL;
        copy = pass->data;
    }
    /* Rows point into the caller's push constants. */
    pass->original = dispatch->push;
    pass->original_size = dispatch->push_size;
    pass->copy = copy->push;
    for (uint32_t i = 0; i < dispatch->row_count; i++) graph_add_row(pass, dispatch->rows[i]);
    if (dispatch->indirect.id) graph_use_buffer(pass, dispatch->indirect, GRAPH_INDIRECT);
    return pass;
}

/* ---- addresses outside of passes ---- */

static void put(struct graph *graph, void *place, uint32_t id, bool is_image, uint64_t offset) {
    const struct graph_resource *resource = graph_find_resource(graph, id, is_image);
    if (!resource) {
        graph_misuse(graph, "an address is asked for of %#x, which is no %s handle of this frame", id,
                     is_image ? "image" : "buffer");
        return;
    }
    struct graph_put *added = arena_allocate(&graph->arena, sizeof *added);
    if (!added) {
        graph_fail(graph, FNL_ERROR_MEMORY);
        return;
    }
    *added = (struct graph_put){graph->puts, place, (uint32_t)(resource - graph->resources.data), offset};
    graph->puts = added;
}

void graph_put_address(struct graph *graph, uint64_t *place, graph_buffer buffer) {
    graph_put_address_at(graph, place, buffer, 0);
}
void graph_put_address_at(struct graph *graph, uint64_t *place, graph_buffer buffer, uint64_t offset) {
    put(graph, place, buffer.id, false, offset);
}
void graph_put_sampled(struct graph *graph, uint32_t *place, graph_image image) { put(graph, place, image.id, true, 0); }

void graph_put_addresses(struct graph *graph) {
    for (const struct graph_put *put = graph->puts; put; put = put->next) {
        const struct graph_resource *resource = &graph->resources.data[put->resource];
        uint64_t address = resource->buffer ? resource->buffer->address + put->offset : 0;
        uint32_t index = resource->image ? resource->image->sampled_index : GPU_NO_INDEX;
        if (resource->is_image)
            memcpy(put->place, &index, sizeof index);
        else
            memcpy(put->place, &address, sizeof address);
    }
}
