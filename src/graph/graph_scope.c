/* SPDX-License-Identifier: MIT */
/** Merged scopes: one pass made of several. And what passes move between images and memory. */
#include "graph/graph_internal.h"

/* ---- merging ---- */

uint32_t graph_merged_attachment(const struct graph_merged *merged, uint32_t resource) {
    for (uint32_t i = 0; i < merged->attachment_count; i++)
        if (merged->attachments[i].resource == resource) return i;
    return GRAPH_NONE;
}

static bool add_attachment(struct graph *graph, struct graph_merged *merged, const struct graph_pass *pass,
                           const struct graph_pass_attachment *attachment) {
    const struct graph_resource *resource = &graph->resources.data[attachment->resource];
    uint32_t known = graph_merged_attachment(merged, attachment->resource);
    if (known != GRAPH_NONE) {
        if (attachment->load == VK_ATTACHMENT_LOAD_OP_CLEAR) {
            graph_misuse(graph, "pass '%s' clears '%s', which scope '%s' has drawn into", pass->name, resource->name,
                         pass->scope->name);
            return false;
        }
        merged->attachments[known].read_only &= attachment->read_only;
        return true;
    }
    if (merged->attachment_count == GPU_MAX_SCOPE_ATTACHMENTS) {
        graph_misuse(graph, "scope '%s' has more than %d attachments", pass->scope->name, GPU_MAX_SCOPE_ATTACHMENTS);
        return false;
    }
    if (attachment->resolve != GRAPH_NONE || resource->params.samples != 1) {
        graph_misuse(graph, "pass '%s' has the multisampled attachment '%s' in scope '%s'", pass->name, resource->name,
                     pass->scope->name);
        return false;
    }
    if (merged->attachment_count) {
        const struct graph_resource *first = &graph->resources.data[merged->attachments[0].resource];
        const struct graph_image_params *a = &first->params, *b = &resource->params;
        if (a->width != b->width || a->height != b->height || a->layers != b->layers) {
            graph_misuse(graph,
                         "scope '%s' has attachments of different sizes: '%s' is %ux%u, %u layers, '%s' is %ux%u, %u layers",
                         pass->scope->name, first->name, a->width, a->height, a->layers, resource->name, b->width, b->height,
                         b->layers);
            return false;
        }
    }
    merged->attachments[merged->attachment_count++] = *attachment;
    return true;
}

static bool add_attachments(struct graph *graph, struct graph_merged *merged, const struct graph_pass *pass) {
    if (pass->color_count == 0 && pass->depth.resource == GRAPH_NONE) {
        graph_misuse(graph, "pass '%s' draws nothing in scope '%s'", pass->name, pass->scope->name);
        return false;
    }
    for (uint32_t i = 0; i < pass->input_count; i++) {
        const struct graph_pass_attachment input = {
            .resource = pass->inputs[i], .resolve = GRAPH_NONE, .load = VK_ATTACHMENT_LOAD_OP_LOAD, .read_only = true};
        if (pass->inputs[i] != GRAPH_NONE && !add_attachment(graph, merged, pass, &input)) return false;
    }
    for (uint32_t i = 0; i < pass->color_count; i++)
        if (!add_attachment(graph, merged, pass, &pass->colors[i])) return false;
    return pass->depth.resource == GRAPH_NONE || add_attachment(graph, merged, pass, &pass->depth);
}

/* Between the passes of a scope there is an order at each pixel, and for fragment shaders only. */
static bool goes_together(struct graph *graph, const struct graph_pass *pass, const struct graph_access *a,
                          const struct graph_access *b) {
    const struct graph_resource *resource = &graph->resources.data[a->resource];
    if (resource->is_image && a->layout != b->layout) {
        graph_misuse(graph, "pass '%s' uses '%s' in another layout than an earlier pass of scope '%s'", pass->name,
                     resource->name, pass->scope->name);
        return false;
    }
    const VkPipelineStageFlags2 others = VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT;
    if (!resource->is_image && (a->writes || b->writes) && ((a->stages | b->stages) & ~others)) {
        graph_misuse(graph, "passes of scope '%s' write and use '%s' beyond their own pixel", pass->scope->name,
                     resource->name);
        return false;
    }
    return true;
}

static bool add_uses(struct graph *graph, struct graph_pass *whole, const struct graph_pass *pass) {
    for (const struct graph_access *use = pass->first_use; use; use = use->next) {
        struct graph_access wanted = *use;
        const struct graph_resource *resource = &graph->resources.data[use->resource];
        if (graph_merged_attachment(whole->merged, use->resource) != GRAPH_NONE &&
            graph_is_depth_format(resource->params.format)) {
            /* The render pass changes the layout and changes it back, which counts as writing. */
            wanted.layout = VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL;
            wanted.access |= VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT;
            wanted.writes = true;
        } else if (use->layout == VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL) {
            /* So do local reads. */
            wanted.stages |= VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT;
            wanted.access |= VK_ACCESS_2_COLOR_ATTACHMENT_READ_BIT | VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT;
            wanted.writes = true;
        }
        struct graph_access *known = whole->first_use;
        while (known && known->resource != use->resource) known = known->next;
        if (known) {
            if (!goes_together(graph, pass, known, &wanted)) return false;
            known->stages |= wanted.stages;
            known->access |= wanted.access;
            known->usage |= wanted.usage;
            known->writes |= wanted.writes; /* reads and discards: as the first does */
            known->read_layers |= wanted.read_layers;
            known->written_layers |= wanted.written_layers;
            continue;
        }
        known = arena_allocate(&graph->arena, sizeof *known);
        if (!known) {
            graph_fail(graph, FNL_ERROR_MEMORY);
            return false;
        }
        *known = wanted;
        known->next = NULL;
        if (whole->last_use)
            whole->last_use->next = known;
        else
            whole->first_use = known;
        whole->last_use = known;
    }
    return true;
}

struct graph_pass *graph_merge(struct graph *graph, uint32_t first, uint32_t *next) {
    const struct graph_scope *scope = graph->passes.data[first]->scope;
    struct graph_pass *whole = arena_allocate_zero(&graph->arena, sizeof *whole);
    struct graph_merged *merged = arena_allocate_zero(&graph->arena, sizeof *merged);
    if (!whole || !merged) {
        graph_fail(graph, FNL_ERROR_MEMORY);
        return NULL;
    }
    *whole = (struct graph_pass){.graph = graph, .name = scope->name, .role = graph->passes.data[first]->role, .scope = scope, .merged = merged, .live = true};
    whole->depth.resource = whole->depth.resolve = GRAPH_NONE;
    uint32_t i = first;
    for (; i < graph->passes.count && graph->passes.data[i]->scope == scope; i++) {
        struct graph_pass *pass = graph->passes.data[i];
        if (!pass->live) {
            graph->plan.culled_count++;
            continue;
        }
        if (merged->part_count == GPU_MAX_SCOPE_STEPS) {
            graph_misuse(graph, "scope '%s' has more than %d passes", scope->name, GPU_MAX_SCOPE_STEPS);
            return NULL;
        }
        merged->parts[merged->part_count++] = pass;
        if (!add_attachments(graph, merged, pass) || !add_uses(graph, whole, pass)) return NULL;
    }
    *next = i;
    return whole;
}

/* ---- traffic ---- */

uint64_t graph_image_bytes(const struct graph_resource *resource) {
    const struct graph_image_params *params = &resource->params;
    uint64_t texels = 0;
    for (uint32_t mip = 0; mip < params->mips; mip++)
        texels += (uint64_t)MAX(params->width >> mip, 1u) * MAX(params->height >> mip, 1u);
    return texels * params->layers * params->samples * gpu_texel_bytes(params->format);
}

VkAttachmentStoreOp graph_store_op(const struct graph *graph, const struct graph_resource *resource, bool read_only,
                                   uint32_t step) {
    if (read_only) return VK_ATTACHMENT_STORE_OP_NONE;
    bool last = !resource->imported && resource->role == GRAPH_HISTORY_NONE &&
                graph_whole(graph, resource)->last_use->step == step;
    return last ? VK_ATTACHMENT_STORE_OP_DONT_CARE : VK_ATTACHMENT_STORE_OP_STORE;
}

/* The first mip alone is drawn into. */
static uint64_t attachment_bytes(const struct graph_resource *resource) {
    const struct graph_image_params *params = &resource->params;
    return (uint64_t)params->width * params->height * params->layers * params->samples * gpu_texel_bytes(params->format);
}

struct rows {
    const struct graph *graph;
    struct graph_traffic *out;
    uint32_t capacity, count, step;
};

static void put_row(struct rows *rows, const struct graph_resource *resource, const struct graph_traffic *row) {
    if (rows->count < rows->capacity) {
        struct graph_traffic *out = &rows->out[rows->count];
        *out = *row;
        out->pass = rows->graph->plan.steps[rows->step].pass->name;
        out->image = resource->name;
        out->format = resource->params.format;
        out->transient = graph_whole(rows->graph, resource)->usage & VK_IMAGE_USAGE_TRANSIENT_ATTACHMENT_BIT;
    }
    rows->count++;
}

static void put_attachment(struct rows *rows, const struct graph_pass_attachment *attachment) {
    if (attachment->resource == GRAPH_NONE) return;
    const struct graph_resource *resource = &rows->graph->resources.data[attachment->resource];
    struct graph_traffic row = {.attachment = true,
                                .load = attachment->load,
                                .store = graph_store_op(rows->graph, resource, attachment->read_only, rows->step)};
    if (row.load == VK_ATTACHMENT_LOAD_OP_LOAD) row.bytes_read = attachment_bytes(resource);
    if (row.store == VK_ATTACHMENT_STORE_OP_STORE) row.bytes_written = attachment_bytes(resource);
    put_row(rows, resource, &row);
    if (attachment->resolve == GRAPH_NONE) return;
    resource = &rows->graph->resources.data[attachment->resolve];
    put_row(rows, resource,
            &(struct graph_traffic){
                .attachment = true, .load = VK_ATTACHMENT_LOAD_OP_DONT_CARE, .bytes_written = attachment_bytes(resource)});
}

static uint32_t layer_count(const struct graph_resource *resource, uint64_t layers) {
    return resource->params.layers > 64 ? resource->params.layers : (uint32_t)__builtin_popcountll(layers);
}

uint32_t graph_step_traffic(const struct graph *graph, uint32_t step, struct graph_traffic *out, uint32_t capacity) {
    const struct graph_pass *pass = graph->plan.steps[step].pass;
    struct rows rows = {graph, out, capacity, 0, step};
    if (pass->merged)
        for (uint32_t i = 0; i < pass->merged->attachment_count; i++) put_attachment(&rows, &pass->merged->attachments[i]);
    for (uint32_t i = 0; i < pass->color_count; i++) put_attachment(&rows, &pass->colors[i]);
    put_attachment(&rows, &pass->depth);
    const VkAccessFlags2 reads = VK_ACCESS_2_SHADER_SAMPLED_READ_BIT | VK_ACCESS_2_SHADER_STORAGE_READ_BIT;
    for (const struct graph_access *use = pass->first_use; use; use = use->next) {
        const struct graph_resource *resource = &graph->resources.data[use->resource];
        if (!resource->is_image || !(use->access & (reads | VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT))) continue;
        struct graph_traffic row = {0};
        const uint64_t layer_bytes = graph_image_bytes(resource) / resource->params.layers;
        if (use->access & reads) row.bytes_read = layer_bytes * layer_count(resource, use->read_layers);
        if (use->access & VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT)
            row.bytes_written = layer_bytes * layer_count(resource, use->written_layers);
        put_row(&rows, resource, &row);
    }
    return rows.count;
}

uint32_t graph_query_traffic(const struct graph *graph, struct graph_traffic *out, uint32_t capacity) {
    uint32_t count = 0;
    for (uint32_t i = 0; i < graph->plan.step_count; i++)
        count +=
            graph_step_traffic(graph, i, count < capacity ? out + count : NULL, count < capacity ? capacity - count : 0);
    return count;
}

struct graph_lazy_memory graph_query_lazy_memory(struct graph *graph) {
    struct graph_lazy_memory memory = {0, 0};
    for (uint32_t i = 0; i < graph->pools.count; i++) {
        const struct gpu_heap *heap = &graph->pools.data[i].heaps[0].memory; /* images' */
        if (!heap->size || !heap->lazy) continue;
        memory.reserved_bytes += heap->size;
        memory.committed_bytes += gpu_heap_committed(graph->device, heap);
    }
    return memory;
}
