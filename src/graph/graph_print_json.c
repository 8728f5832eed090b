/* SPDX-License-Identifier: MIT */
/** The plan as JSON, for programs; docs/frame-graph.md says what the members mean. What the text has is here too, in the same names. */
#include "fanal/values.h"
#include "graph/graph_print.h"

#define FORMAT(name) {VK_FORMAT_##name, #name}
static const struct {
    VkFormat format;
    const char *name;
} formats[] = {
    FORMAT(R8_UNORM),            FORMAT(R8_UINT),
    FORMAT(R8G8_UNORM),          FORMAT(R8G8_UINT),
    FORMAT(R8G8B8A8_UNORM),      FORMAT(R8G8B8A8_SNORM),
    FORMAT(R8G8B8A8_UINT),       FORMAT(R8G8B8A8_SRGB),
    FORMAT(B8G8R8A8_UNORM),      FORMAT(B8G8R8A8_SRGB),
    FORMAT(R16_UNORM),           FORMAT(R16_UINT),
    FORMAT(R16_SFLOAT),          FORMAT(R16G16_UNORM),
    FORMAT(R16G16_SNORM),        FORMAT(R16G16_UINT),
    FORMAT(R16G16_SFLOAT),       FORMAT(R16G16B16A16_UNORM),
    FORMAT(R16G16B16A16_SNORM),  FORMAT(R16G16B16A16_UINT),
    FORMAT(R16G16B16A16_SFLOAT), FORMAT(R32_UINT),
    FORMAT(R32_SINT),            FORMAT(R32_SFLOAT),
    FORMAT(R32G32_UINT),         FORMAT(R32G32_SINT),
    FORMAT(R32G32_SFLOAT),       FORMAT(R32G32B32A32_UINT),
    FORMAT(R32G32B32A32_SINT),   FORMAT(R32G32B32A32_SFLOAT),
    FORMAT(D16_UNORM),           FORMAT(X8_D24_UNORM_PACK32),
    FORMAT(D32_SFLOAT),          FORMAT(S8_UINT),
    FORMAT(D32_SFLOAT_S8_UINT),  FORMAT(D24_UNORM_S8_UINT),
    FORMAT(B10G11R11_UFLOAT_PACK32), FORMAT(A2B10G10R10_UNORM_PACK32),
    FORMAT(E5B9G9R9_UFLOAT_PACK32),  FORMAT(A2R10G10B10_UNORM_PACK32)};

/* ---- values ---- */

static void put_string(struct printer *p, const char *text) {
    print_put(p, "\"");
    for (; *text; text++) {
        const unsigned char c = (unsigned char)*text;
        if (c < 0x20)
            print_put(p, "\\u%04x", c);
        else
            print_put(p, c == '"' || c == '\\' ? "\\%c" : "%c", c);
    }
    print_put(p, "\"");
}

static void put_format(struct printer *p, VkFormat format) {
    for (size_t i = 0; i < COUNT_OF(formats); i++)
        if (formats[i].format == format) {
            print_put(p, "\"%s\"", formats[i].name);
            return;
        }
    print_put(p, "\"%d\"", (int)format);
}

static void put_scopes(struct printer *p, VkPipelineStageFlags2 from_stages, VkAccessFlags2 from_access, VkPipelineStageFlags2 to_stages,
                       VkAccessFlags2 to_access) {
    print_put(p, "\"from_stages\":\"");
    print_stages(p, from_stages);
    print_put(p, "\",\"from_access\":\"");
    print_access(p, from_access);
    print_put(p, "\",\"to_stages\":\"");
    print_stages(p, to_stages);
    print_put(p, "\",\"to_access\":\"");
    print_access(p, to_access);
    print_put(p, "\"");
}

/* ---- resources: those that live passes use, numbered in the order of their declaration ---- */

static uint32_t number_of(const struct graph *graph, uint32_t resource) {
    uint32_t number = 0;
    for (uint32_t i = 0; i < resource; i++) number += graph->resources.data[i].first_use != NULL;
    return number;
}

/* Those of a pool that lie over one another are a group; groups count through all pools. False: the resource shares its memory with none. */
static bool find_group(const struct graph *graph, const struct graph_resource *wanted, uint32_t *out) {
    uint32_t group = 0;
    for (uint32_t i = 0; i < graph->pools.count; i++) {
        for (uint32_t r = graph->pools.data[i].first_resource; r != GRAPH_NONE;) {
            uint64_t end = 0;
            uint32_t members = 0;
            bool is_in = false;
            for (; r != GRAPH_NONE; r = graph->resources.data[r].next_in_pool) {
                const struct graph_resource *resource = &graph->resources.data[r];
                if (members > 0 && resource->offset >= end) break;
                end = MAX(end, resource->offset + resource->size);
                is_in |= resource == wanted;
                members++;
            }
            *out = group;
            if (is_in) return members > 1;
            group += members > 1;
        }
    }
    return false;
}

static const char *kind_of(const struct graph_resource *resource) {
    return resource->imported                           ? "imported"
           : resource->role == GRAPH_HISTORY_CURRENT    ? "history"
           : resource->role == GRAPH_HISTORY_PREVIOUS   ? "history of the last frame"
                                                        : "transient";
}

static void put_resource(struct printer *p, const struct graph_resource *resource) {
    const struct graph_image_params *params = &resource->params;
    uint32_t group = 0;
    print_put(p, "{\"name\":");
    put_string(p, resource->name);
    print_put(p, ",\"kind\":\"%s\",\"lifetime\":\"%s\",", resource->is_image ? "image" : "buffer", kind_of(resource));
    if (resource->is_image) {
        print_put(p, "\"format\":");
        put_format(p, params->format);
        print_put(p, ",\"width\":%u,\"height\":%u,\"layers\":%u,\"mips\":%u,\"samples\":%u,", params->width, params->height, params->layers, params->mips,
                  params->samples);
    }
    print_put(p, "\"bytes\":%llu,\"first_pass\":%u,\"last_pass\":%u,",
              (unsigned long long)(resource->is_image ? graph_image_bytes(resource) : resource->buffer_size), resource->first_use->step,
              resource->last_use->step);
    if (resource->pool == GRAPH_NONE)
        print_put(p, "\"memory\":null,\"alias_group\":null}");
    else {
        print_put(p, "\"memory\":{\"pool\":%u,\"offset\":%llu,\"bytes\":%llu,\"first_pass\":%u,\"last_pass\":%u},\"alias_group\":", resource->pool,
                  (unsigned long long)resource->offset, (unsigned long long)resource->size, resource->first_step, resource->last_step);
        const bool shares = find_group(p->graph, resource, &group);
        print_put(p, shares ? "%u}" : "null}", group);
    }
}

/* ---- passes ---- */

static void put_barriers(struct printer *p, const struct graph_barriers *barriers) {
    const char *separator = "";
    print_put(p, "[");
    for (const struct graph_barrier *barrier = barriers->first; barrier; barrier = barrier->next) {
        print_put(p, "%s{\"resources\":[%u],\"from_layout\":\"%s\",\"to_layout\":\"%s\",", separator, number_of(p->graph, barrier->resource),
                  print_layout_name(barrier->from_layout), print_layout_name(barrier->to_layout));
        put_scopes(p, barrier->from_stages, barrier->from_access, barrier->to_stages, barrier->to_access);
        print_put(p, "}");
        separator = ",";
    }
    if (barriers->first_cause) {
        print_put(p, "%s{\"resources\":[", separator);
        for (const struct graph_cause *cause = barriers->first_cause; cause; cause = cause->next)
            print_put(p, "%s%u", cause == barriers->first_cause ? "" : ",", number_of(p->graph, cause->resource));
        print_put(p, "],\"from_layout\":null,\"to_layout\":null,");
        put_scopes(p, barriers->from_stages, barriers->from_access, barriers->to_stages, barriers->to_access);
        print_put(p, "}");
    }
    print_put(p, "]");
}

/* The attachment of the pass that a resource is, or NULL. */
static const struct graph_pass_attachment *attachment_of(const struct graph_pass *pass, uint32_t resource) {
    for (uint32_t i = 0; pass->merged && i < pass->merged->attachment_count; i++)
        if (pass->merged->attachments[i].resource == resource) return &pass->merged->attachments[i];
    for (uint32_t i = 0; i < pass->color_count; i++)
        if (pass->colors[i].resource == resource) return &pass->colors[i];
    return pass->depth.resource == resource ? &pass->depth : NULL;
}

static void put_use(struct printer *p, uint32_t index, const struct graph_access *use) {
    const struct graph_step *step = &p->graph->plan.steps[index];
    const struct graph_resource *resource = &p->graph->resources.data[use->resource];
    const struct graph_pass_attachment *attachment = attachment_of(step->pass, use->resource);
    const uint64_t layers = use->read_layers | use->written_layers;
    const uint32_t layer_count = resource->params.layers;
    print_put(p, "{\"resource\":%u,\"reads\":%s,\"writes\":%s,\"stages\":\"", number_of(p->graph, use->resource), use->reads ? "true" : "false",
              use->writes ? "true" : "false");
    print_stages(p, use->stages);
    print_put(p, "\",\"access\":\"");
    print_access(p, use->access);
    print_put(p, "\"");
    if (resource->is_image) print_put(p, ",\"layout\":\"%s\"", print_layout_name(use->layout));
    if (resource->is_image && layer_count <= 64 && __builtin_popcountll(layers) != (int)layer_count) {
        const char *separator = ",\"layers\":[";
        for (uint32_t i = 0; i < layer_count; i++) {
            if (!(layers >> i & 1)) continue;
            print_put(p, "%s%u", separator, i);
            separator = ",";
        }
        print_put(p, "]");
    }
    if (attachment) {
        const VkAttachmentStoreOp store = graph_store_op(p->graph, resource, attachment->read_only, index);
        print_put(p, ",\"load\":\"%s\",\"store\":\"%s\"",
                  attachment->load == VK_ATTACHMENT_LOAD_OP_LOAD    ? "load"
                  : attachment->load == VK_ATTACHMENT_LOAD_OP_CLEAR ? "clear"
                                                                    : "discard",
                  store == VK_ATTACHMENT_STORE_OP_STORE  ? "store"
                  : store == VK_ATTACHMENT_STORE_OP_NONE ? "none"
                                                         : "discard");
    }
    print_put(p, "}");
}

static void put_step(struct printer *p, uint32_t index) {
    const struct graph_step *step = &p->graph->plan.steps[index];
    const struct graph_merged *merged = step->pass->merged;
    print_put(p, "{\"name\":");
    put_string(p, step->pass->name);
    print_put(p, ",\"queue\":\"%s\",\"role\":\"%s\",\"batch\":%u,\"parts\":[", step->queue == GPU_QUEUE_COMPUTE ? "compute" : "graphics",
              fnl_value_name(FNL_ENUM_PASS_ROLE, (uint32_t)graph_pass_role(step->pass->role)), step->batch);
    for (uint32_t i = 0; merged && i < merged->part_count; i++) {
        if (i) print_put(p, ",");
        put_string(p, merged->parts[i]->name);
    }
    print_put(p, "],\"view_mask\":%u,\"barriers\":", step->pass->view_mask);
    put_barriers(p, &step->before);
    print_put(p, ",\"uses\":[");
    for (const struct graph_access *use = step->pass->first_use; use; use = use->next) {
        put_use(p, index, use);
        if (use->next) print_put(p, ",");
    }
    print_put(p, "]}");
}

size_t graph_print_json(const struct graph *graph, char *text, size_t capacity) {
    struct printer printer = {.graph = graph, .text = text, .capacity = capacity}, *p = &printer;
    const struct graph_plan *plan = &graph->plan;
    if (capacity) text[0] = 0;
    if (!plan->compiled) {
        print_put(p, "null\n");
        return p->length;
    }
    print_put(p, "{\"culled_passes\":%u,\"barriers\":%u,\"transient_bytes\":%llu,\"unaliased_bytes\":%llu,\n\"passes\":[", plan->culled_count,
              plan->barrier_count, (unsigned long long)plan->transient_bytes, (unsigned long long)plan->unaliased_bytes);
    for (uint32_t i = 0; i < plan->step_count; i++) {
        print_put(p, i ? ",\n" : "\n");
        put_step(p, i);
    }
    print_put(p, "],\n\"batches\":[");
    for (uint32_t i = 0; i < plan->batch_count; i++) {
        const struct graph_batch *batch = &plan->batches[i];
        print_put(p, "%s{\"queue\":\"%s\",\"waits_for\":", i ? ",\n" : "\n", batch->queue == GPU_QUEUE_COMPUTE ? "compute" : "graphics");
        print_put(p, batch->wait == GRAPH_NONE ? "null" : "%u", batch->wait);
        print_put(p, ",\"barriers_after\":");
        put_barriers(p, &batch->after);
        print_put(p, "}");
    }
    print_put(p, "],\n\"resources\":[");
    const char *separator = "\n";
    for (uint32_t i = 0; i < graph->resources.count; i++) {
        if (!graph->resources.data[i].first_use) continue;
        print_put(p, "%s", separator);
        put_resource(p, &graph->resources.data[i]);
        separator = ",\n";
    }
    print_put(p, "]}\n");
    return p->length;
}
