/* SPDX-License-Identifier: MIT */
/** Transient memory: where each resource lies, and the heaps, images and buffers that make it real. */
#include "graph/graph_internal.h"

enum {
    HEAP_GRANULARITY = 64 << 10,
    MAX_KNOWN_REQUIREMENTS = 1024, /* windows that are resized all the time must not grow the cache for ever */
};

struct gpu_image_params graph_gpu_params(const struct graph_resource *resource) {
    const struct graph_image_params *params = &resource->params;
    return (struct gpu_image_params){.name = resource->name,
                                     .format = params->format,
                                     .width = params->width,
                                     .height = params->height,
                                     .layers = params->layers,
                                     .mips = params->mips,
                                     .samples = params->samples,
                                     .usage = resource->usage};
}

/* ---- sizes ---- */

/* The null back end's idea of an image's size: texels at 4 bytes. */
static struct gpu_requirements invent_requirements(const struct graph_resource *resource) {
    uint64_t size = resource->buffer_size;
    if (resource->is_image) {
        const struct graph_image_params *params = &resource->params;
        size = 0;
        for (uint32_t mip = 0; mip < params->mips; mip++)
            size += (uint64_t)MAX(params->width >> mip, 1u) * MAX(params->height >> mip, 1u) * params->layers *
                    params->samples * 4;
    }
    return (struct gpu_requirements){.size = size, .alignment = resource->is_image ? 1024 : 256, .memory_types = 1};
}

static uint64_t requirements_key(const struct graph_resource *resource) {
    struct {
        uint64_t size;
        uint32_t image[8];
    } key = {.size = resource->buffer_size};
    if (resource->is_image) {
        const struct graph_image_params *params = &resource->params;
        uint32_t image[8] = {1,
                             (uint32_t)params->format,
                             params->width,
                             params->height,
                             params->layers,
                             params->mips,
                             params->samples,
                             resource->usage};
        memcpy(key.image, image, sizeof image);
    }
    return hash_bytes(&key, sizeof key, HASH_SEED);
}

static bool find_requirements(struct graph *graph, const struct graph_resource *resource, struct gpu_requirements *out) {
    if (!graph->device) {
        *out = invent_requirements(resource);
        return true;
    }
    uint64_t key = requirements_key(resource);
    for (uint32_t i = 0; i < graph->requirements.count; i++) {
        if (graph->requirements.data[i].key != key) continue;
        *out = graph->requirements.data[i].requirements;
        return true;
    }
    struct gpu_image_params params = graph_gpu_params(resource);
    *out = resource->is_image ? gpu_image_requirements(graph->device, &params)
                              : gpu_buffer_requirements(graph->device, resource->buffer_size);
    if (out->size == 0 || out->memory_types == 0) {
        fnl_result status = gpu_status(graph->device);
        log_error(&graph->host, "graph: the device has no memory for '%s'", resource->name);
        graph_fail(graph, status != FNL_OK ? status : FNL_ERROR_UNSUPPORTED);
        return false;
    }
    if (graph->requirements.count == MAX_KNOWN_REQUIREMENTS) graph->requirements.count = 0;
    struct graph_requirements known = {key, *out};
    return array_push(&graph->host, &graph->requirements, known);
}

/* ---- places ---- */

static uint32_t find_pool(struct graph *graph, bool images, uint32_t memory_types) {
    for (uint32_t i = 0; i < graph->pools.count; i++)
        if (graph->pools.data[i].images == images && graph->pools.data[i].memory_types == memory_types) return i;
    struct graph_pool pool = {.images = images, .memory_types = memory_types, .first_resource = GRAPH_NONE};
    return array_push(&graph->host, &graph->pools, pool) ? graph->pools.count - 1 : GRAPH_NONE;
}

static bool alive_together(const struct graph_resource *a, const struct graph_resource *b) {
    return a->first_step <= b->last_step && b->first_step <= a->last_step;
}

bool graph_overlaps(const struct graph_resource *a, const struct graph_resource *b) {
    return a->pool == b->pool && a->pool != GRAPH_NONE && a->offset < b->offset + b->size && b->offset < a->offset + a->size;
}

/* At the lowest offset where nothing lies that lives at the same time. */
static void place(struct graph *graph, struct graph_resource *resource, uint64_t alignment) {
    struct graph_pool *pool = &graph->pools.data[resource->pool];
    uint64_t offset = 0;
    uint32_t *link = &pool->first_resource;
    for (uint32_t i = pool->first_resource; i != GRAPH_NONE; i = graph->resources.data[i].next_in_pool) {
        const struct graph_resource *other = &graph->resources.data[i];
        if (!alive_together(resource, other)) continue;
        if (offset + resource->size <= other->offset) break;
        offset = MAX(offset, align_up(other->offset + other->size, alignment));
    }
    resource->offset = offset;
    while (*link != GRAPH_NONE && graph->resources.data[*link].offset <= offset)
        link = &graph->resources.data[*link].next_in_pool;
    resource->next_in_pool = *link;
    *link = (uint32_t)(resource - graph->resources.data);
    pool->needed = MAX(pool->needed, offset + resource->size);
}

struct candidate {
    uint32_t resource, first_step;
    uint64_t size, alignment;
};

static bool goes_before(const struct candidate *a, const struct candidate *b) {
    if (a->size != b->size) return a->size > b->size;
    if (a->first_step != b->first_step) return a->first_step < b->first_step;
    return a->resource < b->resource;
}

/* Heap sort: no memory of its own, unlike qsort of some C libraries. */
static void sort_candidates(struct candidate *items, uint32_t count) {
    for (uint32_t start = count / 2, end = count; end > 1;) {
        if (start > 0)
            start--;
        else {
            end--;
            struct candidate last = items[end];
            items[end] = items[0];
            items[0] = last;
        }
        for (uint32_t parent = start, child; (child = 2 * parent + 1) < end; parent = child) {
            if (child + 1 < end && goes_before(&items[child], &items[child + 1])) child++;
            if (!goes_before(&items[parent], &items[child])) break;
            struct candidate moved = items[parent];
            items[parent] = items[child];
            items[child] = moved;
        }
    }
}

bool graph_place_resources(struct graph *graph) {
    struct candidate *candidates = ARENA_ARRAY(&graph->arena, struct candidate, graph->resources.count);
    if (!candidates) return false;
    for (uint32_t i = 0; i < graph->pools.count; i++) {
        graph->pools.data[i].needed = 0;
        graph->pools.data[i].first_resource = GRAPH_NONE;
    }
    uint32_t count = 0;
    for (uint32_t i = 0; i < graph->resources.count; i++) {
        struct graph_resource *resource = &graph->resources.data[i];
        resource->pool = resource->physical = GRAPH_NONE;
        if (resource->imported || resource->role != GRAPH_HISTORY_NONE || !resource->first_use) continue;
        struct gpu_requirements requirements;
        if (!find_requirements(graph, resource, &requirements)) return false;
        resource->size = requirements.size;
        resource->pool = find_pool(graph, resource->is_image, requirements.memory_types);
        if (resource->pool == GRAPH_NONE) return false;
        candidates[count++] =
            (struct candidate){i, resource->first_step, requirements.size, MAX(requirements.alignment, 1u)};
        graph->plan.unaliased_bytes += align_up(requirements.size, MAX(requirements.alignment, 1u));
    }
    sort_candidates(candidates, count);
    for (uint32_t i = 0; i < count; i++)
        place(graph, &graph->resources.data[candidates[i].resource], candidates[i].alignment);
    for (uint32_t i = 0; i < graph->pools.count; i++) {
        struct graph_pool *pool = &graph->pools.data[i];
        graph->plan.transient_bytes += pool->needed;
        if (pool->images && !array_reserve(&graph->host, &pool->tenants, count)) return false;
    }
    return true;
}

/* ---- making it real ---- */

static void destroy_physical(struct graph *graph, uint32_t index) {
    struct graph_physical *physical = &graph->physicals.data[index];
    if (physical->is_image)
        gpu_image_destroy(graph->device, &physical->image);
    else
        gpu_buffer_destroy(graph->device, &physical->buffer);
    *physical = graph->physicals.data[--graph->physicals.count];
}

static void destroy_heap(struct graph *graph, uint32_t pool_index, uint32_t which) {
    for (uint32_t i = graph->physicals.count; i-- > 0;)
        if (graph->physicals.data[i].pool == pool_index && graph->physicals.data[i].heap == which)
            destroy_physical(graph, i);
    struct graph_heap *heap = &graph->pools.data[pool_index].heaps[which];
    if (heap->memory.size) gpu_heap_destroy(graph->device, &heap->memory);
    *heap = (struct graph_heap){0};
}

static uint32_t heap_index(const struct graph *graph, const struct graph_pool *pool) {
    return pool->images ? 0 : gpu_frame_slot(graph->device);
}

void graph_release_memory(struct graph *graph) {
    if (!graph->device) return;
    for (uint32_t i = 0; i < graph->pools.count; i++)
        for (uint32_t k = 0; k < GPU_FRAMES_IN_FLIGHT; k++) destroy_heap(graph, i, k);
}

/* Heaps grow at once, and shrink when less than half was needed for some frames. */
static fnl_result realise_heap(struct graph *graph, uint32_t index) {
    struct graph_pool *pool = &graph->pools.data[index];
    const uint32_t which = heap_index(graph, pool);
    struct graph_heap *heap = &pool->heaps[which];
    const uint64_t wanted = align_up(pool->needed, HEAP_GRANULARITY);
    bool fits = wanted <= heap->memory.size;
    heap->oversized_frames = fits && wanted < heap->memory.size / 2 ? heap->oversized_frames + 1 : 0;
    if (fits && heap->oversized_frames <= GRAPH_KEEP_FRAMES) return FNL_OK;
    destroy_heap(graph, index, which);
    if (pool->needed == 0) return FNL_OK;
    return gpu_heap_create(graph->device, pool->images ? "transient images" : "transient buffers",
                           wanted, pool->memory_types, &heap->memory);
}

static fnl_result realise_transient(struct graph *graph, struct graph_resource *resource) {
    /* Two resources of one description at one place share the image, but not under two names. */
    const struct graph_pool *pool = &graph->pools.data[resource->pool];
    const uint32_t which = heap_index(graph, pool);
    uint64_t place[4] = {resource->pool, resource->offset, (uintptr_t)resource->name, which};
    uint64_t key = hash_bytes(place, sizeof place, requirements_key(resource));
    uint32_t index = 0;
    while (index < graph->physicals.count && graph->physicals.data[index].key != key) index++;
    if (index == graph->physicals.count) {
        const struct gpu_heap *heap = &pool->heaps[which].memory;
        struct graph_physical physical = {
            .key = key, .pool = resource->pool, .heap = which, .is_image = resource->is_image};
        if (!array_reserve(&graph->host, &graph->physicals, (uint64_t)index + 1)) return FNL_ERROR_MEMORY;
        struct gpu_image_params params = graph_gpu_params(resource);
        TRY(resource->is_image ? gpu_image_create_in(graph->device, heap, resource->offset, &params, &physical.image)
                               : gpu_buffer_create_in(graph->device, heap, resource->offset, resource->name,
                                                      resource->buffer_size, &physical.buffer));
        graph->physicals.data[graph->physicals.count++] = physical;
    }
    graph->physicals.data[index].last_frame = graph->frame;
    resource->physical = index;
    return FNL_OK;
}

/* Histories outlive the frame that first asks for them, so they get every usage that the format allows. */
static VkImageUsageFlags history_usage(const struct graph *graph, const struct graph_history_entry *entry) {
    const struct graph_image_params *params = &entry->params;
    bool depth = graph_is_depth_format(params->format);
    VkFormatFeatureFlags2 attachment =
        depth ? VK_FORMAT_FEATURE_2_DEPTH_STENCIL_ATTACHMENT_BIT : VK_FORMAT_FEATURE_2_COLOR_ATTACHMENT_BIT;
    VkImageUsageFlags usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT;
    if (gpu_format_supports(graph->device, params->format, attachment))
        usage |= depth ? VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT : VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT;
    if (params->samples == 1 && !depth &&
        gpu_format_supports(graph->device, params->format, VK_FORMAT_FEATURE_2_STORAGE_IMAGE_BIT))
        usage |= VK_IMAGE_USAGE_STORAGE_BIT;
    return usage;
}

static fnl_result realise_history(struct graph *graph, struct graph_resource *resource) {
    struct graph_history_entry *entry = &graph->histories.data[resource->history];
    struct gpu_image *image = &entry->images[resource->role == GRAPH_HISTORY_CURRENT ? entry->current : entry->current ^ 1];
    if (!image->handle) {
        struct gpu_image_params params = graph_gpu_params(resource);
        params.usage = resource->usage | history_usage(graph, entry);
        params.use = GPU_USE_HISTORY;
        TRY(gpu_image_create(graph->device, &params, image));
    }
    resource->image = image;
    return FNL_OK;
}

/* The physical of one layer lives as long as that of its image. */
static fnl_result realise_layer(struct graph *graph, struct graph_resource *resource) {
    const struct graph_resource *whole = graph_whole(graph, resource);
    if (whole->pool == GRAPH_NONE) return FNL_OK; /* no pass needs it */
    const uint32_t layer = resource->layer;
    const uint64_t key = hash_bytes(&layer, sizeof layer, graph->physicals.data[whole->physical].key);
    uint32_t index = 0;
    while (index < graph->physicals.count && graph->physicals.data[index].key != key) index++;
    if (index == graph->physicals.count) {
        if (!array_reserve(&graph->host, &graph->physicals, (uint64_t)index + 1)) return FNL_ERROR_MEMORY;
        const struct graph_physical *of = &graph->physicals.data[whole->physical];
        struct graph_physical physical = {.key = key, .pool = of->pool, .heap = of->heap, .is_image = true};
        TRY(gpu_image_layer(graph->device, &of->image, layer, &physical.image));
        graph->physicals.data[graph->physicals.count++] = physical;
    }
    graph->physicals.data[index].last_frame = graph->frame;
    resource->physical = index;
    return FNL_OK;
}

fnl_result graph_realise(struct graph *graph) {
    for (uint32_t i = 0; i < graph->pools.count; i++) TRY(realise_heap(graph, i));
    for (uint32_t i = 0; i < graph->resources.count; i++) {
        struct graph_resource *resource = &graph->resources.data[i];
        if (resource->pool != GRAPH_NONE)
            TRY(realise_transient(graph, resource));
        else if (resource->role != GRAPH_HISTORY_NONE && resource->first_use)
            TRY(realise_history(graph, resource));
        else if (resource->whole) /* its image comes before it */
            TRY(realise_layer(graph, resource));
    }
    /* Removal moves the last physical down, so resources look for theirs afterwards. */
    for (uint32_t i = graph->physicals.count; i-- > 0;) {
        if (graph->frame - graph->physicals.data[i].last_frame <= GRAPH_KEEP_FRAMES) continue;
        uint32_t moved = graph->physicals.count - 1;
        destroy_physical(graph, i);
        for (uint32_t r = 0; r < graph->resources.count; r++)
            if (graph->resources.data[r].physical == moved) graph->resources.data[r].physical = i;
    }
    for (uint32_t i = 0; i < graph->resources.count; i++) {
        struct graph_resource *resource = &graph->resources.data[i];
        if (resource->physical == GRAPH_NONE) continue;
        const struct graph_physical *physical = &graph->physicals.data[resource->physical];
        if (resource->is_image)
            resource->image = &physical->image;
        else
            resource->buffer = &physical->buffer;
    }
    return FNL_OK;
}

/* ---- from frame to frame ---- */

/* Whether it is one that lives outside of the graph; `out` then says that there is nothing to wait for. */
static bool last_use_of(const struct graph_resource *resource, struct gpu_last_use *out) {
    if (!resource->imported) return false;
    uint64_t handle = resource->is_image ? (uint64_t)resource->image->handle : (uint64_t)resource->buffer->handle;
    if (!handle) handle = resource->is_image ? (uintptr_t)resource->image : (uintptr_t)resource->buffer; /* the null back end */
    *out = (struct gpu_last_use){
        .handle = handle, .is_image = resource->is_image, .visible_stages = ~0ull, .visible_access = ~0ull};
    return true;
}

bool graph_first_state(struct graph *graph, const struct graph_resource *resource, struct graph_state *out) {
    const VkImageLayout layout = resource->has_contents ? resource->initial_layout : VK_IMAGE_LAYOUT_UNDEFINED;
    struct gpu_last_use last;
    *out = (struct graph_state){
        .layout = layout, .write_queue = GPU_QUEUE_GRAPHICS, .visible_stages = ~0ull, .visible_access = ~0ull};
    if (resource->role != GRAPH_HISTORY_NONE) {
        const struct graph_history_entry *entry = &graph->histories.data[resource->history];
        const struct graph_state *state =
            &entry->states[resource->role == GRAPH_HISTORY_CURRENT ? entry->current : entry->current ^ 1];
        if (!state->visible_stages && !state->write_stages) return true; /* never used */
        *out = *state;
        out->layout = layout;
        return true;
    }
    if (!last_use_of(resource, &last)) return true;
    if (resource->is_image) {
        /* Whoever had it before: a frame that imported it otherwise, or its owner. */
        last.write_stages = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
        last.write_access = VK_ACCESS_2_MEMORY_WRITE_BIT;
        last.visible_stages = last.visible_access = 0;
    }
    if (!gpu_last_use_find(graph->last_uses, &graph->host, &last)) return false;
    out->write_stages = last.write_stages;
    out->write_access = last.write_access;
    out->visible_stages = last.visible_stages;
    out->visible_access = last.visible_access;
    out->read_stages[GPU_QUEUE_GRAPHICS] = last.read_stages;
    return true;
}

/* What is left to wait for on the graphics queue, which has waited for all that the compute queue did. */
static struct graph_state left_to_wait_for(const struct graph_state *state) {
    struct graph_state left = {.layout = state->layout,
                               .write_queue = GPU_QUEUE_GRAPHICS,
                               .visible_stages = ~0ull,
                               .visible_access = ~0ull,
                               .read_stages = {[GPU_QUEUE_GRAPHICS] = state->read_stages[GPU_QUEUE_GRAPHICS]}};
    if (state->write_queue == GPU_QUEUE_COMPUTE) return left;
    left.write_stages = state->write_stages;
    left.write_access = state->write_access;
    left.visible_stages = state->visible_stages;
    left.visible_access = state->visible_access;
    return left;
}

static void commit_tenant(struct graph *graph, const struct graph_resource *resource) {
    struct graph_pool *pool = &graph->pools.data[resource->pool];
    const struct graph_state state = left_to_wait_for(&resource->state);
    const VkPipelineStageFlags2 reads = state.read_stages[GPU_QUEUE_GRAPHICS];
    /* Reads have waited for the write. */
    const struct graph_tenant tenant = {resource->offset, resource->size, reads ? reads : state.write_stages,
                                        reads ? 0 : state.write_access};
    if (pool->images && tenant.stages) pool->tenants.data[pool->tenants.count++] = tenant;
}

static void commit_uses(struct graph *graph) {
    for (uint32_t i = 0; i < graph->pools.count; i++) graph->pools.data[i].tenants.count = 0;
    for (uint32_t i = 0; i < graph->resources.count; i++) {
        const struct graph_resource *resource = &graph->resources.data[i];
        struct gpu_last_use last;
        if (resource->pool != GRAPH_NONE) commit_tenant(graph, resource);
        if (!last_use_of(resource, &last)) continue;
        const struct graph_state state = left_to_wait_for(&resource->state);
        last.write_stages = state.write_stages;
        last.write_access = state.write_access;
        last.visible_stages = state.visible_stages;
        last.visible_access = state.visible_access;
        last.read_stages = state.read_stages[GPU_QUEUE_GRAPHICS];
        gpu_last_use_set(graph->last_uses, &last);
    }
}

static void commit_histories(struct graph *graph) {
    for (uint32_t i = 0; i < graph->histories.count; i++) {
        struct graph_history_entry *entry = &graph->histories.data[i];
        if (entry->last_frame != graph->frame) continue;
        const struct graph_resource *current = graph_find_resource(graph, entry->handles.current.id, true);
        const struct graph_resource *previous = graph_find_resource(graph, entry->handles.previous.id, true);
        if (!current) continue;
        entry->valid = false;
        for (const struct graph_access *use = current->first_use; use; use = use->next_of_resource)
            entry->valid |= use->writes;
        entry->layouts[entry->current] = current->state.layout;
        entry->states[entry->current] = left_to_wait_for(&current->state);
        if (previous) entry->layouts[entry->current ^ 1] = previous->state.layout;
        if (previous) entry->states[entry->current ^ 1] = left_to_wait_for(&previous->state);
        entry->current ^= 1;
    }
}

void graph_commit(struct graph *graph) {
    commit_uses(graph);
    commit_histories(graph);
}

void graph_drop_history(struct graph *graph, uint32_t index) {
    struct graph_history_entry *entry = &graph->histories.data[index];
    for (uint32_t i = 0; i < 2; i++)
        if (graph->device) gpu_image_destroy(graph->device, &entry->images[i]);
    *entry = graph->histories.data[--graph->histories.count];
}
