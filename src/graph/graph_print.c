/* SPDX-License-Identifier: MIT */
/** The plan as text, see docs/frame-graph.md. */
#include "graph/graph_print.h"

void print_put(struct printer *printer, const char *format, ...) {
    size_t left = printer->length < printer->capacity ? printer->capacity - printer->length : 0;
    va_list arguments;
    va_start(arguments, format);
    int length = text_format_list(left ? printer->text + printer->length : NULL, left, format, arguments);
    va_end(arguments);
    if (length > 0) printer->length += (size_t)length;
}

struct flag_name {
    uint64_t flag;
    const char *name;
};

static const struct flag_name stage_names[] = {
    {VK_PIPELINE_STAGE_2_DRAW_INDIRECT_BIT, "DRAW_INDIRECT"},
    {VK_PIPELINE_STAGE_2_INDEX_INPUT_BIT, "INDEX_INPUT"},
    {VK_PIPELINE_STAGE_2_VERTEX_SHADER_BIT, "VERTEX_SHADER"},
    {VK_PIPELINE_STAGE_2_MESH_SHADER_BIT_EXT, "MESH_SHADER"},
    {VK_PIPELINE_STAGE_2_EARLY_FRAGMENT_TESTS_BIT, "EARLY_FRAGMENT_TESTS"},
    {VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT, "FRAGMENT_SHADER"},
    {VK_PIPELINE_STAGE_2_LATE_FRAGMENT_TESTS_BIT, "LATE_FRAGMENT_TESTS"},
    {VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT, "COLOR_ATTACHMENT_OUTPUT"},
    {VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, "COMPUTE_SHADER"},
    {VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, "ALL_TRANSFER"},
    {VK_PIPELINE_STAGE_2_ACCELERATION_STRUCTURE_BUILD_BIT_KHR, "ACCELERATION_STRUCTURE_BUILD"},
    {VK_PIPELINE_STAGE_2_HOST_BIT, "HOST"},
    {VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, "ALL_COMMANDS"},
};

static const struct flag_name access_names[] = {
    {VK_ACCESS_2_INDIRECT_COMMAND_READ_BIT, "INDIRECT_COMMAND_READ"},
    {VK_ACCESS_2_INDEX_READ_BIT, "INDEX_READ"},
    {VK_ACCESS_2_INPUT_ATTACHMENT_READ_BIT, "INPUT_ATTACHMENT_READ"},
    {VK_ACCESS_2_SHADER_READ_BIT, "SHADER_READ"},
    {VK_ACCESS_2_SHADER_SAMPLED_READ_BIT, "SHADER_SAMPLED_READ"},
    {VK_ACCESS_2_SHADER_STORAGE_READ_BIT, "SHADER_STORAGE_READ"},
    {VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT, "SHADER_STORAGE_WRITE"},
    {VK_ACCESS_2_COLOR_ATTACHMENT_READ_BIT, "COLOR_ATTACHMENT_READ"},
    {VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT, "COLOR_ATTACHMENT_WRITE"},
    {VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_READ_BIT, "DEPTH_ATTACHMENT_READ"},
    {VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT, "DEPTH_ATTACHMENT_WRITE"},
    {VK_ACCESS_2_TRANSFER_READ_BIT, "TRANSFER_READ"},
    {VK_ACCESS_2_TRANSFER_WRITE_BIT, "TRANSFER_WRITE"},
    {VK_ACCESS_2_ACCELERATION_STRUCTURE_READ_BIT_KHR, "ACCELERATION_STRUCTURE_READ"},
    {VK_ACCESS_2_ACCELERATION_STRUCTURE_WRITE_BIT_KHR, "ACCELERATION_STRUCTURE_WRITE"},
    {VK_ACCESS_2_HOST_READ_BIT, "HOST_READ"},
    {VK_ACCESS_2_MEMORY_READ_BIT, "MEMORY_READ"},
    {VK_ACCESS_2_MEMORY_WRITE_BIT, "MEMORY_WRITE"},
};

static void put_flags(struct printer *printer, uint64_t flags, const struct flag_name *names, uint32_t count) {
    const char *separator = "";
    for (uint32_t i = 0; i < count; i++) {
        if (!(flags & names[i].flag)) continue;
        print_put(printer, "%s%s", separator, names[i].name);
        separator = "|";
    }
    if (!flags) print_put(printer, "NONE");
}

void print_stages(struct printer *printer, VkPipelineStageFlags2 stages) {
    put_flags(printer, stages, stage_names, COUNT_OF(stage_names));
}

void print_access(struct printer *printer, VkAccessFlags2 access) { put_flags(printer, access, access_names, COUNT_OF(access_names)); }

const char *print_layout_name(VkImageLayout layout) {
    switch (layout) {
    case VK_IMAGE_LAYOUT_UNDEFINED:
        return "UNDEFINED";
    case VK_IMAGE_LAYOUT_GENERAL:
        return "GENERAL";
    case VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL:
        return "COLOR_ATTACHMENT_OPTIMAL";
    case VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL:
        return "DEPTH_ATTACHMENT_OPTIMAL";
    case VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL:
        return "DEPTH_STENCIL_ATTACHMENT_OPTIMAL";
    case VK_IMAGE_LAYOUT_STENCIL_ATTACHMENT_OPTIMAL:
        return "STENCIL_ATTACHMENT_OPTIMAL";
    case VK_IMAGE_LAYOUT_STENCIL_READ_ONLY_OPTIMAL:
        return "STENCIL_READ_ONLY_OPTIMAL";
    case VK_IMAGE_LAYOUT_DEPTH_READ_ONLY_OPTIMAL:
        return "DEPTH_READ_ONLY_OPTIMAL";
    case VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL:
        return "SHADER_READ_ONLY_OPTIMAL";
    case VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL:
        return "TRANSFER_SRC_OPTIMAL";
    case VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL:
        return "TRANSFER_DST_OPTIMAL";
    case VK_IMAGE_LAYOUT_PRESENT_SRC_KHR:
        return "PRESENT_SRC";
    default:
        return "OTHER";
    }
}

static void put_scope(struct printer *printer, VkPipelineStageFlags2 stages, VkAccessFlags2 access) {
    print_stages(printer, stages);
    print_put(printer, "/");
    print_access(printer, access);
}

static const char *role_suffix(const struct graph_resource *resource) {
    return resource->role == GRAPH_HISTORY_PREVIOUS ? " (previous)" : "";
}

static void put_barriers(struct printer *printer, const struct graph_barriers *barriers, const char *indent) {
    for (const struct graph_barrier *barrier = barriers->first; barrier; barrier = barrier->next) {
        const struct graph_resource *resource = &printer->graph->resources.data[barrier->resource];
        print_put(printer, "%sbarrier %s%s %s", indent, resource->name, role_suffix(resource), print_layout_name(barrier->from_layout));
        if (barrier->from_layout != barrier->to_layout) print_put(printer, "->%s", print_layout_name(barrier->to_layout));
        print_put(printer, " (");
        put_scope(printer, barrier->from_stages, barrier->from_access);
        print_put(printer, " -> ");
        put_scope(printer, barrier->to_stages, barrier->to_access);
        print_put(printer, ")\n");
    }
    if (!barriers->first_cause) return;
    print_put(printer, "%sbarrier memory of", indent);
    for (const struct graph_cause *cause = barriers->first_cause; cause; cause = cause->next)
        print_put(printer, "%s %s", cause == barriers->first_cause ? "" : ",",
            printer->graph->resources.data[cause->resource].name);
    print_put(printer, " (");
    put_scope(printer, barriers->from_stages, barriers->from_access);
    print_put(printer, " -> ");
    put_scope(printer, barriers->to_stages, barriers->to_access);
    print_put(printer, ")\n");
}

/* Those of an image with several, where a pass does not use them all. */
static void put_layers(struct printer *printer, const struct graph_resource *resource, uint64_t layers) {
    const uint32_t count = resource->params.layers;
    if (!resource->is_image || count > 64 || __builtin_popcountll(layers) == (int)count) return;
    const char *separator = " layer ";
    for (uint32_t i = 0; i < count; i++) {
        if (!(layers >> i & 1)) continue;
        print_put(printer, "%s%u", separator, i);
        separator = ",";
    }
}

static void put_step(struct printer *printer, uint32_t index) {
    const struct graph_step *step = &printer->graph->plan.steps[index];
    print_put(printer, "  pass %u '%s' %s", index, step->pass->name, step->queue == GPU_QUEUE_COMPUTE ? "compute" : "graphics");
    const struct graph_merged *merged = step->pass->merged;
    for (uint32_t i = 0; merged && i < merged->part_count; i++)
        print_put(printer, "%s'%s'", i ? ", " : ", one scope of ", merged->parts[i]->name);
    if (step->pass->view_mask) print_put(printer, ", views %#x at once", step->pass->view_mask);
    if (step->pass->vertex_layers) print_put(printer, ", %u layers at once", step->pass->vertex_layers);
    print_put(printer, ":\n");
    put_barriers(printer, &step->before, "    ");
    for (const struct graph_access *use = step->pass->first_use; use; use = use->next) {
        const struct graph_resource *resource = &printer->graph->resources.data[use->resource];
        print_put(printer, "    %s %s%s", use->writes ? (use->reads ? "reads, writes" : "writes") : "reads", resource->name,
            role_suffix(resource));
        put_layers(printer, resource, use->read_layers | use->written_layers);
        if (resource->is_image) print_put(printer, " in %s", print_layout_name(use->layout));
        print_put(printer, "\n");
    }
}

static void put_memory(struct printer *printer) {
    const struct graph *graph = printer->graph;
    for (uint32_t i = 0; i < graph->pools.count; i++) {
        const struct graph_pool *pool = &graph->pools.data[i];
        if (pool->first_resource == GRAPH_NONE) continue;
        print_put(printer, "memory of %s, types %#x: %llu bytes\n", pool->images ? "images" : "buffers", pool->memory_types,
            (unsigned long long)pool->needed);
        for (uint32_t r = pool->first_resource; r != GRAPH_NONE; r = graph->resources.data[r].next_in_pool) {
            const struct graph_resource *resource = &graph->resources.data[r];
            print_put(printer, "  at %llu, %llu bytes, passes %u to %u: %s\n", (unsigned long long)resource->offset,
                (unsigned long long)resource->size, resource->first_step, resource->last_step, resource->name);
        }
    }
}

size_t graph_print(const struct graph *graph, char *text, size_t capacity) {
    struct printer printer = {.graph = graph, .text = text, .capacity = capacity};
    if (capacity) text[0] = 0;
    const struct graph_plan *plan = &graph->plan;
    if (!plan->compiled) {
        print_put(&printer, "no plan: the graph is not compiled\n");
        return printer.length;
    }
    print_put(&printer, "%u passes, %u culled, %u barriers, %u batches, %llu bytes (%llu without aliasing)\n", plan->step_count,
        plan->culled_count, plan->barrier_count, plan->batch_count, (unsigned long long)plan->transient_bytes,
        (unsigned long long)plan->unaliased_bytes);
    for (uint32_t i = 0; i < plan->batch_count; i++) {
        const struct graph_batch *batch = &plan->batches[i];
        print_put(&printer, "batch %u %s", i, batch->queue == GPU_QUEUE_COMPUTE ? "compute" : "graphics");
        if (batch->wait != GRAPH_NONE) print_put(&printer, ", waits for batch %u", batch->wait);
        print_put(&printer, ":\n");
        for (uint32_t step = batch->first_step; step != GRAPH_NONE; step = plan->steps[step].next_in_batch)
            put_step(&printer, step);
        put_barriers(&printer, &batch->after, "  at the end: ");
    }
    put_memory(&printer);
    return printer.length;
}

static const char *load_name(const struct graph_traffic *row) {
    if (!row->attachment) return row->bytes_read ? "shader" : "-";
    return row->load == VK_ATTACHMENT_LOAD_OP_LOAD ? "load" : row->load == VK_ATTACHMENT_LOAD_OP_CLEAR ? "clear" : "-";
}

static const char *store_name(const struct graph_traffic *row) {
    if (!row->attachment) return row->bytes_written ? "shader" : "-";
    return row->store == VK_ATTACHMENT_STORE_OP_STORE ? "store" : row->store == VK_ATTACHMENT_STORE_OP_NONE ? "none" : "-";
}

size_t graph_print_traffic(const struct graph *graph, char *text, size_t capacity) {
    struct printer printer = {.graph = graph, .text = text, .capacity = capacity};
    if (capacity) text[0] = 0;
    if (!graph->plan.compiled) {
        print_put(&printer, "no plan: the graph is not compiled\n");
        return printer.length;
    }
    print_put(&printer, "%-24s %-24s %-7s %-7s %12s %12s\n", "pass", "image", "load", "store", "bytes read", "written");
    struct graph_traffic rows[64];
    for (uint32_t step = 0; step < graph->plan.step_count; step++) {
        uint32_t count = MIN(graph_step_traffic(graph, step, rows, COUNT_OF(rows)), (uint32_t)COUNT_OF(rows));
        for (uint32_t i = 0; i < count; i++)
            print_put(&printer, "%-24s %-24s %-7s %-7s %12llu %12llu%s\n", i ? "" : rows[i].pass, rows[i].image,
                load_name(&rows[i]), store_name(&rows[i]), (unsigned long long)rows[i].bytes_read,
                (unsigned long long)rows[i].bytes_written, rows[i].transient ? " in tiles" : "");
    }
    print_put(&printer, "%-24s %-24s %-7s %-7s %12llu %12llu\n", "all", "", "", "", (unsigned long long)graph->plan.bytes_read,
        (unsigned long long)graph->plan.bytes_written);
    return printer.length;
}
