/* SPDX-License-Identifier: MIT */
/** Declaring a frame. */
#include "graph/graph_internal.h"

enum {
    INDEX_BITS = 20, /* of a handle; the rest is the frame, so that handles of earlier frames are recognised */
    INDEX_MASK = (1 << INDEX_BITS) - 1,
    ARENA_BLOCK = 64 << 10,
};

/* ---- uses ---- */

#define STAGE(name) VK_PIPELINE_STAGE_2_##name##_BIT
#define ACCESS(name) VK_ACCESS_2_##name##_BIT
#define BUILD_STAGE VK_PIPELINE_STAGE_2_ACCELERATION_STRUCTURE_BUILD_BIT_KHR
#define STRUCTURE_READ VK_ACCESS_2_ACCELERATION_STRUCTURE_READ_BIT_KHR
#define STRUCTURE_WRITE VK_ACCESS_2_ACCELERATION_STRUCTURE_WRITE_BIT_KHR

enum { FOR_IMAGES = 1, FOR_BUFFERS = 2, ON_ASYNC = 4 };
enum use_layout { LAYOUT_NONE, LAYOUT_SAMPLED, LAYOUT_GENERAL, LAYOUT_COPY_FROM, LAYOUT_COPY_TO };

static const struct use_kind {
    const char *name;
    VkPipelineStageFlags2 stages;
    VkAccessFlags2 access;
    VkImageUsageFlags usage;
    enum use_layout layout;
    bool reads, writes;
    uint32_t where;
} use_kinds[] = {
    [GRAPH_SAMPLE_COMPUTE] = {"GRAPH_SAMPLE_COMPUTE", STAGE(COMPUTE_SHADER), ACCESS(SHADER_SAMPLED_READ),
                              VK_IMAGE_USAGE_SAMPLED_BIT, LAYOUT_SAMPLED, true, false, FOR_IMAGES | ON_ASYNC},
    [GRAPH_SAMPLE_FRAGMENT] = {"GRAPH_SAMPLE_FRAGMENT", STAGE(FRAGMENT_SHADER), ACCESS(SHADER_SAMPLED_READ),
                               VK_IMAGE_USAGE_SAMPLED_BIT, LAYOUT_SAMPLED, true, false, FOR_IMAGES},
    [GRAPH_READ_COMPUTE] = {"GRAPH_READ_COMPUTE", STAGE(COMPUTE_SHADER), ACCESS(SHADER_STORAGE_READ),
                            VK_IMAGE_USAGE_STORAGE_BIT, LAYOUT_GENERAL, true, false, FOR_IMAGES | FOR_BUFFERS | ON_ASYNC},
    [GRAPH_WRITE_COMPUTE] = {"GRAPH_WRITE_COMPUTE", STAGE(COMPUTE_SHADER), ACCESS(SHADER_STORAGE_WRITE),
                             VK_IMAGE_USAGE_STORAGE_BIT, LAYOUT_GENERAL, false, true, FOR_IMAGES | FOR_BUFFERS | ON_ASYNC},
    [GRAPH_READ_WRITE_COMPUTE] = {"GRAPH_READ_WRITE_COMPUTE", STAGE(COMPUTE_SHADER),
                                  ACCESS(SHADER_STORAGE_READ) | ACCESS(SHADER_STORAGE_WRITE), VK_IMAGE_USAGE_STORAGE_BIT,
                                  LAYOUT_GENERAL, true, true, FOR_IMAGES | FOR_BUFFERS | ON_ASYNC},
    [GRAPH_READ_VERTEX] = {"GRAPH_READ_VERTEX", STAGE(VERTEX_SHADER), ACCESS(SHADER_STORAGE_READ), 0, LAYOUT_NONE, true,
                           false, FOR_BUFFERS},
    [GRAPH_READ_MESH] = {"GRAPH_READ_MESH", VK_PIPELINE_STAGE_2_MESH_SHADER_BIT_EXT, ACCESS(SHADER_STORAGE_READ), 0,
                         LAYOUT_NONE, true, false, FOR_BUFFERS},
    [GRAPH_READ_FRAGMENT] = {"GRAPH_READ_FRAGMENT", STAGE(FRAGMENT_SHADER), ACCESS(SHADER_STORAGE_READ),
                             VK_IMAGE_USAGE_STORAGE_BIT, LAYOUT_GENERAL, true, false, FOR_IMAGES | FOR_BUFFERS},
    [GRAPH_READ_GRAPHICS] = {"GRAPH_READ_GRAPHICS", STAGE(VERTEX_SHADER) | STAGE(FRAGMENT_SHADER),
                             ACCESS(SHADER_STORAGE_READ), 0, LAYOUT_NONE, true, false, FOR_BUFFERS},
    [GRAPH_WRITE_FRAGMENT] = {"GRAPH_WRITE_FRAGMENT", STAGE(FRAGMENT_SHADER), ACCESS(SHADER_STORAGE_WRITE), 0, LAYOUT_NONE,
                              false, true, FOR_BUFFERS},
    [GRAPH_READ_WRITE_FRAGMENT] = {"GRAPH_READ_WRITE_FRAGMENT", STAGE(FRAGMENT_SHADER),
                                   ACCESS(SHADER_STORAGE_READ) | ACCESS(SHADER_STORAGE_WRITE), VK_IMAGE_USAGE_STORAGE_BIT,
                                   LAYOUT_GENERAL, true, true, FOR_IMAGES | FOR_BUFFERS},
    [GRAPH_INDIRECT] = {"GRAPH_INDIRECT", STAGE(DRAW_INDIRECT), ACCESS(INDIRECT_COMMAND_READ), 0, LAYOUT_NONE, true, false,
                        FOR_BUFFERS | ON_ASYNC},
    [GRAPH_INDEX] = {"GRAPH_INDEX", STAGE(INDEX_INPUT), ACCESS(INDEX_READ), 0, LAYOUT_NONE, true, false, FOR_BUFFERS},
    [GRAPH_COPY_FROM] = {"GRAPH_COPY_FROM", STAGE(ALL_TRANSFER), ACCESS(TRANSFER_READ), VK_IMAGE_USAGE_TRANSFER_SRC_BIT,
                         LAYOUT_COPY_FROM, true, false, FOR_IMAGES | FOR_BUFFERS | ON_ASYNC},
    [GRAPH_COPY_TO] = {"GRAPH_COPY_TO", STAGE(ALL_TRANSFER), ACCESS(TRANSFER_WRITE), VK_IMAGE_USAGE_TRANSFER_DST_BIT,
                       LAYOUT_COPY_TO, false, true, FOR_IMAGES | FOR_BUFFERS | ON_ASYNC},
    [GRAPH_BUILD_INPUT] = {"GRAPH_BUILD_INPUT", BUILD_STAGE, VK_ACCESS_2_SHADER_READ_BIT, 0, LAYOUT_NONE, true, false, FOR_BUFFERS},
    [GRAPH_BUILD_SCRATCH] = {"GRAPH_BUILD_SCRATCH", BUILD_STAGE, STRUCTURE_READ | STRUCTURE_WRITE, 0, LAYOUT_NONE, false, true,
                             FOR_BUFFERS},
    [GRAPH_BUILD] = {"GRAPH_BUILD", BUILD_STAGE, STRUCTURE_READ | STRUCTURE_WRITE, 0, LAYOUT_NONE, true, true, FOR_BUFFERS},
    [GRAPH_BUILD_READ] = {"GRAPH_BUILD_READ", BUILD_STAGE, STRUCTURE_READ, 0, LAYOUT_NONE, true, false, FOR_BUFFERS},
    [GRAPH_TRACE_COMPUTE] = {"GRAPH_TRACE_COMPUTE", STAGE(COMPUTE_SHADER), STRUCTURE_READ, 0, LAYOUT_NONE, true, false, FOR_BUFFERS},
    [GRAPH_TRACE_FRAGMENT] = {"GRAPH_TRACE_FRAGMENT", STAGE(FRAGMENT_SHADER), STRUCTURE_READ, 0, LAYOUT_NONE, true, false, FOR_BUFFERS},
    [GRAPH_READ_HOST] = {"GRAPH_READ_HOST", 0, 0, 0, LAYOUT_NONE, true, false, FOR_BUFFERS | ON_ASYNC},
};

static VkImageLayout layout_of(enum use_layout layout, VkFormat format) {
    switch (layout) {
    case LAYOUT_NONE:
        break;
    case LAYOUT_SAMPLED:
        return graph_is_depth_format(format) ? VK_IMAGE_LAYOUT_DEPTH_READ_ONLY_OPTIMAL
                                             : VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL;
    case LAYOUT_GENERAL:
        return VK_IMAGE_LAYOUT_GENERAL;
    case LAYOUT_COPY_FROM:
        return VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL;
    case LAYOUT_COPY_TO:
        return VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL;
    }
    return VK_IMAGE_LAYOUT_UNDEFINED;
}

bool graph_is_depth_format(VkFormat format) {
    return (format >= VK_FORMAT_D16_UNORM && format <= VK_FORMAT_S8_UINT) || format == VK_FORMAT_D32_SFLOAT_S8_UINT;
}

static bool is_stencil(VkFormat format) { return format == VK_FORMAT_S8_UINT; }

/* ---- errors and handles ---- */

void graph_fail(struct graph *graph, fnl_result result) {
    if (graph->result == FNL_OK) graph->result = result;
}

void graph_misuse(struct graph *graph, const char *format, ...) {
    char text[512];
    va_list arguments;
    va_start(arguments, format);
    text_format_list(text, sizeof text, format, arguments);
    va_end(arguments);
    log_error(&graph->host, "graph: %s", text);
    graph_fail(graph, FNL_ERROR_INVALID);
}

static uint32_t handle_frame(const struct graph *graph) {
    return (uint32_t)(graph->frame & ((1u << (32 - INDEX_BITS)) - 1));
}

static uint32_t handle_make(const struct graph *graph, uint32_t index) {
    return handle_frame(graph) << INDEX_BITS | (index + 1);
}

struct graph_resource *graph_find_resource(const struct graph *graph, uint32_t id, bool is_image) {
    uint32_t index = (id & INDEX_MASK) - 1;
    if (id == 0 || id >> INDEX_BITS != handle_frame(graph) || index >= graph->resources.count) return NULL;
    struct graph_resource *resource = &graph->resources.data[index];
    return resource->is_image == is_image ? resource : NULL;
}

/* The resource that a pass names, or NULL after a logged error. */
static struct graph_resource *resource_of(struct graph_pass *pass, uint32_t id, bool is_image) {
    struct graph *graph = pass->graph;
    const char *kind = is_image ? "image" : "buffer";
    struct graph_resource *resource = graph_find_resource(graph, id, is_image);
    if (resource) return resource;
    if (id == 0)
        graph_misuse(graph, "pass '%s' is given no %s (its handle is 0)", pass->name, kind);
    else if (id >> INDEX_BITS != handle_frame(graph))
        graph_misuse(graph, "pass '%s' is given %s handle %#x of an earlier frame", pass->name, kind, id);
    else
        graph_misuse(graph, "pass '%s' is given %#x, which is no %s handle", pass->name, id, kind);
    return NULL;
}

/* ---- life ---- */

fnl_result graph_create(const fnl_host *host, gpu_device *device, struct graph **out) {
    *out = NULL;
    fnl_host resolved = host_resolve(host ? host : device ? gpu_host(device) : NULL);
    struct graph *graph = host_allocate_zero(&resolved, sizeof *graph);
    if (!graph) return FNL_ERROR_MEMORY;
    graph->host = resolved;
    graph->device = device;
    pthread_mutex_init(&graph->own_uses.mutex, NULL);
    graph->last_uses = device ? gpu_last_uses(device) : &graph->own_uses;
    arena_init(&graph->arena, &graph->host, ARENA_BLOCK);
    graph_names_init(graph);
    *out = graph;
    return FNL_OK;
}

void graph_destroy(struct graph **handle) {
    struct graph *graph = *handle;
    if (!graph) return;
    fnl_host host = graph->host;
    while (graph->histories.count) graph_drop_history(graph, graph->histories.count - 1);
    graph_release_memory(graph);
    array_free(&host, &graph->resources);
    array_free(&host, &graph->passes);
    for (uint32_t i = 0; i < graph->pools.count; i++) array_free(&host, &graph->pools.data[i].tenants);
    array_free(&host, &graph->pools);
    array_free(&host, &graph->own_uses.items);
    pthread_mutex_destroy(&graph->own_uses.mutex);
    array_free(&host, &graph->physicals);
    array_free(&host, &graph->histories);
    array_free(&host, &graph->requirements);
    for (uint32_t i = 0; i < GPU_FRAMES_IN_FLIGHT; i++) {
        array_free(&host, &graph->timer_slots[i].names);
        array_free(&host, &graph->timer_slots[i].results);
    }
    graph_names_finish(graph);
    arena_finish(&graph->arena);
    host_free(&host, graph, sizeof *graph);
    *handle = NULL;
}

void graph_begin(struct graph *graph) {
    if (!graph->device && graph->plan.compiled) graph_commit(graph); /* nothing executes, so compiled is as good */
    graph->frame++;
    graph->result = FNL_OK;
    graph->executed = false;
    graph->resources.count = graph->passes.count = 0;
    graph->scope = NULL;
    graph->role = GRAPH_ROLE_REST;
    graph->puts = NULL;
    graph->names.depth = graph->names.lost = 0;
    memset(&graph->plan, 0, sizeof graph->plan);
    arena_reset(&graph->arena);
    for (uint32_t i = graph->histories.count; i-- > 0;)
        if (graph->frame - graph->histories.data[i].last_frame > GRAPH_KEEP_FRAMES) graph_drop_history(graph, i);
}

/* ---- resources ---- */

static uint32_t add_resource(struct graph *graph, const struct graph_resource *resource) {
    if (graph->resources.count >= INDEX_MASK - 1) {
        graph_misuse(graph, "more than %d resources in a frame", INDEX_MASK - 1);
        return 0;
    }
    if (!array_push(&graph->host, &graph->resources, *resource)) {
        graph_fail(graph, FNL_ERROR_MEMORY);
        return 0;
    }
    struct graph_resource *added = &graph->resources.data[graph->resources.count - 1];
    if (!added->name) added->name = added->is_image ? "image" : "buffer";
    return handle_make(graph, graph->resources.count - 1);
}

static bool normalise_params(struct graph *graph, struct graph_image_params *params) {
    params->layers = MAX(params->layers, 1u);
    params->mips = MAX(params->mips, 1u);
    params->samples = MAX(params->samples, 1u);
    if (params->width == 0 || params->height == 0 || params->format == VK_FORMAT_UNDEFINED) {
        graph_misuse(graph, "image '%s' is %ux%u with format %d", params->name ? params->name : "image", params->width,
                     params->height, (int)params->format);
        return false;
    }
    return true;
}

static graph_image create_image(struct graph *graph, const char *full_name, const struct graph_image_params *params) {
    struct graph_resource resource = {.name = full_name, .is_image = true, .params = *params};
    if (!normalise_params(graph, &resource.params)) return (graph_image){0};
    return (graph_image){add_resource(graph, &resource)};
}

graph_image graph_create_image(struct graph *graph, const struct graph_image_params *params) {
    return create_image(graph, graph_scoped_name(graph, params->name), params);
}

graph_image graph_image_layer(struct graph *graph, graph_image image, uint32_t layer) {
    const struct graph_resource *whole = graph_find_resource(graph, image.id, true);
    if (!whole || whole->whole || whole->imported || whole->role != GRAPH_HISTORY_NONE || whole->params.layers > 64 ||
        layer >= whole->params.layers) {
        graph_misuse(graph, "layer %u is asked for of %#x, which is no image of this frame with such a layer", layer, image.id);
        return (graph_image){0};
    }
    if (whole->params.layers == 1) return image;
    uint32_t index = (uint32_t)(whole - graph->resources.data);
    for (uint32_t i = index + 1; i < graph->resources.count; i++) {
        const struct graph_resource *known = &graph->resources.data[i];
        if (known->whole == index + 1 && known->layer == layer) return (graph_image){handle_make(graph, i)};
    }
    struct graph_resource resource = {
        .name = whole->name, .is_image = true, .whole = index + 1, .layer = layer, .params = whole->params};
    resource.params.layers = 1;
    return (graph_image){add_resource(graph, &resource)};
}

graph_buffer graph_create_buffer(struct graph *graph, const char *name, uint64_t size) {
    struct graph_resource resource = {.name = graph_scoped_name(graph, name), .buffer_size = MAX(size, 16u)};
    return (graph_buffer){add_resource(graph, &resource)};
}

graph_image graph_import_image(struct graph *graph, const struct gpu_image *image, VkImageLayout initial_layout,
                               VkImageLayout final_layout) {
    for (uint32_t i = 0; i < graph->resources.count; i++) {
        struct graph_resource *known = &graph->resources.data[i];
        if (!known->imported || !known->is_image) continue;
        if (known->image != image && (!image->handle || known->image->handle != image->handle)) continue;
        if (known->initial_layout != initial_layout || known->final_layout != final_layout)
            graph_misuse(graph, "image '%s' is imported twice with different layouts", known->name);
        return (graph_image){handle_make(graph, i)};
    }
    struct graph_resource resource = {
        .name = image->params.name,
        .is_image = true,
        .imported = true,
        .image = image,
        .initial_layout = initial_layout,
        .final_layout = final_layout,
        .has_contents = initial_layout != VK_IMAGE_LAYOUT_UNDEFINED,
        .params = {image->params.name, image->params.format, image->params.width, image->params.height, image->params.layers,
                   image->params.mips, image->params.samples},
    };
    if (!normalise_params(graph, &resource.params)) return (graph_image){0};
    return (graph_image){add_resource(graph, &resource)};
}

graph_buffer graph_import_buffer(struct graph *graph, const char *name, const struct gpu_buffer *buffer) {
    for (uint32_t i = 0; i < graph->resources.count; i++) {
        const struct graph_resource *known = &graph->resources.data[i];
        if (!known->imported || known->is_image) continue;
        if (known->buffer == buffer || (buffer->handle && known->buffer->handle == buffer->handle))
            return (graph_buffer){handle_make(graph, i)};
    }
    struct graph_resource resource = {
        .name = name, .imported = true, .buffer = buffer, .buffer_size = buffer->size, .has_contents = true};
    return (graph_buffer){add_resource(graph, &resource)};
}

static bool same_image(const struct graph_image_params *a, const struct graph_image_params *b) {
    return a->format == b->format && a->width == b->width && a->height == b->height && a->layers == b->layers &&
           a->mips == b->mips && a->samples == b->samples;
}

struct graph_history graph_history(struct graph *graph, const struct graph_image_params *params) {
    const struct graph_history none = {{0}, {0}};
    struct graph_image_params wanted = *params;
    if (!wanted.name) {
        graph_misuse(graph, "a history image has no name");
        return none;
    }
    if (!normalise_params(graph, &wanted)) return none;
    const char *name = graph_scoped_name(graph, wanted.name);
    uint32_t index = 0;
    while (index < graph->histories.count && strcmp(graph->histories.data[index].name, name) != 0) index++;
    if (index == graph->histories.count) {
        struct graph_history_entry fresh = {.name = name, .params = wanted};
        if (!array_push(&graph->host, &graph->histories, fresh)) {
            graph_fail(graph, FNL_ERROR_MEMORY);
            return none;
        }
    }
    struct graph_history_entry *entry = &graph->histories.data[index];
    if (entry->last_frame == graph->frame) {
        if (!same_image(&entry->params, &wanted))
            graph_misuse(graph, "history '%s' is declared twice with different sizes", wanted.name);
        return entry->handles;
    }
    /* Contents are those of the very last frame, or none. */
    bool valid = entry->valid && entry->last_frame + 1 == graph->frame && same_image(&entry->params, &wanted);
    if (!same_image(&entry->params, &wanted)) {
        for (uint32_t i = 0; i < 2; i++)
            if (graph->device) gpu_image_destroy(graph->device, &entry->images[i]);
        *entry = (struct graph_history_entry){.name = name, .params = wanted};
    }
    entry->valid = false;
    entry->last_frame = graph->frame;
    struct graph_resource current = {
        .name = entry->name, .is_image = true, .role = GRAPH_HISTORY_CURRENT, .history = index, .params = wanted};
    entry->handles = none;
    entry->handles.current.id = add_resource(graph, &current);
    if (valid) {
        struct graph_resource previous = current;
        previous.role = GRAPH_HISTORY_PREVIOUS;
        previous.has_contents = true;
        previous.initial_layout = entry->layouts[entry->current ^ 1];
        entry->handles.previous.id = add_resource(graph, &previous);
    }
    return entry->handles;
}

struct graph_image_params graph_image_info(const struct graph *graph, graph_image image) {
    const struct graph_resource *resource = graph_find_resource(graph, image.id, true);
    if (resource) return resource->params;
    log_error(&graph->host, "graph: %#x is no image handle of this frame", image.id);
    return (struct graph_image_params){0};
}

uint64_t graph_buffer_size(const struct graph *graph, graph_buffer buffer) {
    const struct graph_resource *resource = graph_find_resource(graph, buffer.id, false);
    if (resource) return resource->buffer_size;
    log_error(&graph->host, "graph: %#x is no buffer handle of this frame", buffer.id);
    return 0;
}

/* ---- passes ---- */

fnl_pass_role graph_pass_role(enum graph_role role) {
    switch (role) {
    case GRAPH_ROLE_GEOMETRY: return FNL_PASS_GEOMETRY;
    case GRAPH_ROLE_LISTS: return FNL_PASS_LISTS;
    case GRAPH_ROLE_SHADOWS:
    case GRAPH_ROLE_SHADOW_FILL:
    case GRAPH_ROLE_SHADOW_PROBE: return FNL_PASS_SHADOWS;
    case GRAPH_ROLE_SHADING: return FNL_PASS_SHADING;
    case GRAPH_ROLE_READ: return FNL_PASS_READ;
    case GRAPH_ROLE_REST: break;
    }
    return FNL_PASS_REST;
}

enum graph_role graph_set_role(struct graph *graph, enum graph_role role) {
    const enum graph_role before = graph->role;
    graph->role = role;
    return before;
}

struct graph_pass *graph_add_pass(struct graph *graph, const char *name, enum graph_queue queue, graph_execute *execute,
                                  const void *data, size_t data_size) {
    struct graph_pass *pass = arena_allocate_zero(&graph->arena, sizeof *pass);
    void *copy = data && data_size ? arena_copy(&graph->arena, data, data_size) : NULL;
    if (!pass || (data && data_size && !copy) || !array_push(&graph->host, &graph->passes, pass)) {
        graph_fail(graph, FNL_ERROR_MEMORY);
        return NULL;
    }
    *pass = (struct graph_pass){
        .graph = graph, .name = graph_scoped_name(graph, name), .queue = queue, .execute = execute, .data = copy, .scope = graph->scope, .role = graph->role};
    pass->original = data;
    pass->original_size = copy ? data_size : 0;
    pass->copy = copy;
    pass->depth.resource = pass->depth.resolve = GRAPH_NONE;
    return pass;
}

/* The layers that a use of it touches. */
static uint64_t layers_of(const struct graph_resource *resource) {
    if (resource->whole) return 1ull << resource->layer;
    return resource->is_image && resource->params.layers < 64 ? (1ull << resource->params.layers) - 1 : ~0ull;
}

static void add_use(struct graph_pass *pass, struct graph_resource *resource, const struct graph_access *wanted) {
    struct graph *graph = pass->graph;
    const uint32_t index = resource->whole ? resource->whole - 1 : (uint32_t)(resource - graph->resources.data);
    const uint64_t layers = layers_of(resource);
    if (wanted->writes && resource->role == GRAPH_HISTORY_PREVIOUS)
        graph_misuse(graph, "pass '%s' writes the previous frame's '%s'", pass->name, resource->name);
    struct graph_access *use = pass->first_use;
    while (use && use->resource != index) use = use->next;
    if (use) {
        if (use->layout != wanted->layout)
            graph_misuse(graph, "pass '%s' uses '%s' in two layouts at once", pass->name, resource->name);
        use->stages |= wanted->stages;
        use->access |= wanted->access;
        use->usage |= wanted->usage;
        use->discards = use->discards && wanted->discards && !resource->whole;
        use->reads |= wanted->reads;
        use->writes |= wanted->writes;
        use->read_layers |= wanted->reads ? layers : 0;
        use->written_layers |= wanted->writes ? layers : 0;
        return;
    }
    use = arena_allocate(&graph->arena, sizeof *use);
    if (!use) {
        graph_fail(graph, FNL_ERROR_MEMORY);
        return;
    }
    *use = *wanted;
    use->resource = index;
    use->discards &= !resource->whole;
    use->read_layers = use->reads ? layers : 0;
    use->written_layers = use->writes ? layers : 0;
    use->next = NULL;
    if (pass->last_use)
        pass->last_use->next = use;
    else
        pass->first_use = use;
    pass->last_use = use;
}

static void add_kind(struct graph_pass *pass, uint32_t id, bool is_image, enum graph_use kind) {
    if (!pass) return;
    struct graph_resource *resource = resource_of(pass, id, is_image);
    if (!resource) return;
    struct graph *graph = pass->graph;
    if ((uint32_t)kind >= COUNT_OF(use_kinds)) {
        graph_misuse(graph, "pass '%s' uses '%s' as %d, which is no use", pass->name, resource->name, (int)kind);
        return;
    }
    const struct use_kind *info = &use_kinds[kind];
    if (!(info->where & (is_image ? FOR_IMAGES : FOR_BUFFERS))) {
        graph_misuse(graph, "pass '%s' uses '%s' as %s, which is not for %s", pass->name, resource->name, info->name,
                     is_image ? "images" : "buffers");
        return;
    }
    if (pass->queue == GRAPH_QUEUE_ASYNC && !(info->where & ON_ASYNC)) {
        graph_misuse(graph, "pass '%s' uses '%s' as %s, which a compute queue cannot do", pass->name, resource->name,
                     info->name);
        return;
    }
    if (kind == GRAPH_READ_HOST) {
        if (!resource->imported)
            graph_misuse(graph, "pass '%s': the host cannot read '%s', which is not imported", pass->name, resource->name);
        resource->host_read = true;
        pass->keep = true;
        return;
    }
    add_use(pass, resource,
            &(struct graph_access){.stages = info->stages,
                                   .access = info->access,
                                   .usage = is_image ? info->usage : 0,
                                   .layout = is_image ? layout_of(info->layout, resource->params.format)
                                                      : VK_IMAGE_LAYOUT_UNDEFINED,
                                   .reads = info->reads,
                                   .writes = info->writes});
}

void graph_use_image(struct graph_pass *pass, graph_image image, enum graph_use use) { add_kind(pass, image.id, true, use); }
void graph_use_buffer(struct graph_pass *pass, graph_buffer buffer, enum graph_use use) {
    add_kind(pass, buffer.id, false, use);
}

void graph_keep(struct graph_pass *pass) {
    if (pass) pass->keep = true;
}

/* ---- attachments ---- */

static struct graph_resource *attachment_of(struct graph_pass *pass, graph_image image, bool depth) {
    if (!pass) return NULL;
    struct graph_resource *resource = resource_of(pass, image.id, true);
    if (!resource) return NULL;
    if (graph_is_depth_format(resource->params.format) != depth) {
        graph_misuse(pass->graph, "pass '%s' takes '%s' as a %s attachment, but its format is %d", pass->name,
                     resource->name, depth ? "depth" : "colour", (int)resource->params.format);
        return NULL;
    }
    if (pass->queue == GRAPH_QUEUE_ASYNC) {
        graph_misuse(pass->graph, "pass '%s' has the attachment '%s', but a compute queue cannot draw", pass->name,
                     resource->name);
        return NULL;
    }
    if (pass->scope && pass->scope->merged && resource->whole) {
        graph_misuse(pass->graph, "pass '%s' of scope '%s' has a layer of '%s' as an attachment", pass->name, pass->scope->name,
                     resource->name);
        return NULL;
    }
    return resource;
}

/* A clear replaces mip 0 only. */
static bool load_discards(const struct graph_resource *resource, VkAttachmentLoadOp load) {
    return load != VK_ATTACHMENT_LOAD_OP_LOAD && resource->params.mips == 1;
}

void graph_color(struct graph_pass *pass, graph_image image, VkAttachmentLoadOp load, const float clear[4]) {
    struct graph_resource *resource = attachment_of(pass, image, false);
    if (!resource) return;
    if (pass->color_count == GPU_MAX_COLORS) {
        graph_misuse(pass->graph, "pass '%s' has more than %d colour attachments", pass->name, GPU_MAX_COLORS);
        return;
    }
    struct graph_pass_attachment *color = &pass->colors[pass->color_count++];
    *color = (struct graph_pass_attachment){
        .resource = (uint32_t)(resource - pass->graph->resources.data), .resolve = GRAPH_NONE, .load = load};
    if (clear) memcpy(color->clear.color.float32, clear, sizeof color->clear.color.float32);
    add_use(pass, resource,
            &(struct graph_access){.stages = STAGE(COLOR_ATTACHMENT_OUTPUT),
                                   .access = ACCESS(COLOR_ATTACHMENT_READ) | ACCESS(COLOR_ATTACHMENT_WRITE),
                                   .usage = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT,
                                   .layout = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL,
                                   .reads = load == VK_ATTACHMENT_LOAD_OP_LOAD,
                                   .writes = true,
                                   .discards = load_discards(resource, load)});
}

void graph_resolve(struct graph_pass *pass, uint32_t index, graph_image image) {
    struct graph_resource *resource = attachment_of(pass, image, false);
    if (!resource) return;
    if (index >= pass->color_count || pass->colors[index].resolve != GRAPH_NONE) {
        graph_misuse(pass->graph,
                     "pass '%s' resolves colour attachment %u into '%s', but it has %u of them, each resolved once",
                     pass->name, index, resource->name, pass->color_count);
        return;
    }
    const struct graph_resource *source = &pass->graph->resources.data[pass->colors[index].resource];
    if (source->params.samples < 2 || resource->params.samples != 1 || source->params.format != resource->params.format) {
        graph_misuse(pass->graph, "pass '%s' cannot resolve '%s' (%u samples, format %d) into '%s' (%u samples, format %d)",
                     pass->name, source->name, source->params.samples, (int)source->params.format, resource->name,
                     resource->params.samples, (int)resource->params.format);
        return;
    }
    pass->colors[index].resolve = (uint32_t)(resource - pass->graph->resources.data);
    add_use(pass, resource,
            &(struct graph_access){.stages = STAGE(COLOR_ATTACHMENT_OUTPUT),
                                   .access = ACCESS(COLOR_ATTACHMENT_READ) | ACCESS(COLOR_ATTACHMENT_WRITE),
                                   .usage = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT,
                                   .layout = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL,
                                   .writes = true,
                                   .discards = resource->params.mips == 1});
}

static void add_depth(struct graph_pass *pass, graph_image image, VkAttachmentLoadOp load, float clear_depth,
                      bool read_only) {
    struct graph_resource *resource = attachment_of(pass, image, true);
    if (!resource) return;
    if (pass->depth.resource != GRAPH_NONE) {
        graph_misuse(pass->graph, "pass '%s' has two depth attachments", pass->name);
        return;
    }
    pass->depth = (struct graph_pass_attachment){.resource = (uint32_t)(resource - pass->graph->resources.data),
                                                 .resolve = GRAPH_NONE,
                                                 .load = load,
                                                 .read_only = read_only};
    bool stencil = is_stencil(resource->params.format);
    if (stencil)
        pass->depth.clear.depthStencil.stencil = (uint32_t)clear_depth;
    else
        pass->depth.clear.depthStencil.depth = clear_depth;
    VkImageLayout writing = stencil ? VK_IMAGE_LAYOUT_STENCIL_ATTACHMENT_OPTIMAL : VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL;
    VkImageLayout reading = stencil ? VK_IMAGE_LAYOUT_STENCIL_READ_ONLY_OPTIMAL : VK_IMAGE_LAYOUT_DEPTH_READ_ONLY_OPTIMAL;
    if (resource->params.format == VK_FORMAT_D32_SFLOAT_S8_UINT) {
        writing = VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL;
        reading = VK_IMAGE_LAYOUT_DEPTH_STENCIL_READ_ONLY_OPTIMAL;
    }
    VkAccessFlags2 write = read_only ? 0 : ACCESS(DEPTH_STENCIL_ATTACHMENT_WRITE);
    add_use(pass, resource,
            &(struct graph_access){.stages = STAGE(EARLY_FRAGMENT_TESTS) | STAGE(LATE_FRAGMENT_TESTS),
                                   .access = ACCESS(DEPTH_STENCIL_ATTACHMENT_READ) | write,
                                   .usage = VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT,
                                   .layout = read_only ? reading : writing,
                                   .reads = load == VK_ATTACHMENT_LOAD_OP_LOAD,
                                   .writes = !read_only,
                                   .discards = load_discards(resource, load)});
}

void graph_depth(struct graph_pass *pass, graph_image image, VkAttachmentLoadOp load, float clear_depth) {
    add_depth(pass, image, load, clear_depth, false);
}

void graph_depth_read_only(struct graph_pass *pass, graph_image image) {
    add_depth(pass, image, VK_ATTACHMENT_LOAD_OP_LOAD, 0, true);
}

void graph_view_mask(struct graph_pass *pass, uint32_t mask) {
    if (pass) pass->view_mask = mask;
}

void graph_vertex_layers(struct graph_pass *pass, uint32_t count) {
    if (pass) pass->vertex_layers = count;
}

/* ---- scopes ---- */

bool graph_begin_scope(struct graph *graph, const struct graph_scope_params *params) {
    if (graph->scope) {
        graph_misuse(graph, "scope '%s' begins inside scope '%s'", params->name, graph->scope->name);
        return false;
    }
    struct graph_scope *scope = arena_allocate(&graph->arena, sizeof *scope);
    if (!scope) {
        graph_fail(graph, FNL_ERROR_MEMORY);
        return false;
    }
    bool fits = graph->device ? gpu_scope_supports(graph->device, params->most_colors, params->most_inputs)
                              : params->most_colors <= GPU_MAX_COLORS && params->most_inputs <= GPU_MAX_INPUTS;
    *scope = (struct graph_scope){.name = graph_scoped_name(graph, params->name), .merged = fits && !params->separate};
    graph->scope = scope;
    return scope->merged;
}

void graph_end_scope(struct graph *graph) {
    if (!graph->scope) graph_misuse(graph, "a scope ends that was not begun");
    graph->scope = NULL;
}

void graph_local_read(struct graph_pass *pass, uint32_t input, graph_image image) {
    struct graph_resource *resource = attachment_of(pass, image, false);
    if (!resource) return;
    if (!pass->scope || input >= GPU_MAX_INPUTS) {
        graph_misuse(pass->graph, "pass '%s' reads '%s' as local input %u, but %s", pass->name, resource->name, input,
                     pass->scope ? "there are fewer" : "is in no scope");
        return;
    }
    while (pass->input_count <= input) pass->inputs[pass->input_count++] = GRAPH_NONE;
    pass->inputs[input] = (uint32_t)(resource - pass->graph->resources.data);
    if (!pass->scope->merged) {
        add_kind(pass, image.id, true, GRAPH_SAMPLE_FRAGMENT);
        return;
    }
    add_use(pass, resource,
            &(struct graph_access){.stages = STAGE(FRAGMENT_SHADER),
                                   .access = ACCESS(INPUT_ATTACHMENT_READ),
                                   .usage = VK_IMAGE_USAGE_INPUT_ATTACHMENT_BIT,
                                   .layout = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL,
                                   .reads = true});
}

graph_image graph_local_rewrite(struct graph_pass *pass, uint32_t input, graph_image image) {
    graph_local_read(pass, input, image);
    if (!pass) return image;
    bool merged = pass->scope && pass->scope->merged;
    graph_image target = image;
    if (!merged) {
        const struct graph_resource *resource = graph_find_resource(pass->graph, image.id, true);
        if (!resource) return image;
        target = create_image(pass->graph, resource->name, &resource->params);
    }
    graph_color(pass, target, merged ? VK_ATTACHMENT_LOAD_OP_LOAD : VK_ATTACHMENT_LOAD_OP_DONT_CARE, NULL);
    return target;
}
