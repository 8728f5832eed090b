/* SPDX-License-Identifier: MIT */
/**
 * From declarations to a plan: checks, culling, lifetimes, batches and barriers. Passes keep their order of declaration.
 *
 * A frame begins where the last one left each resource: its first uses wait for the last uses of that resource, or of the memory that it
 * takes over, and for nothing else. Other plans may come in between; what outlives frames is known by its handle (gpu_last_use). With a
 * compute queue, batch 0 holds nothing; the first compute batch waits for it, and so for the last frame, and the last graphics batch waits
 * for all compute.
 */
#include "graph/graph_internal.h"

static const VkAccessFlags2 WRITE_ACCESS = VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT | VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT |
                                           VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT | VK_ACCESS_2_TRANSFER_WRITE_BIT |
                                           VK_ACCESS_2_ACCELERATION_STRUCTURE_WRITE_BIT_KHR;

/* ---- checks ---- */

static void check_attachments(struct graph *graph, const struct graph_pass *pass) {
    const struct graph_resource *first = NULL;
    for (uint32_t i = 0; i <= pass->color_count; i++) {
        const struct graph_pass_attachment *attachment = i < pass->color_count ? &pass->colors[i] : &pass->depth;
        if (attachment->resource == GRAPH_NONE) continue;
        const struct graph_resource *resource = &graph->resources.data[attachment->resource];
        const struct graph_resource *resolve =
            attachment->resolve == GRAPH_NONE ? NULL : &graph->resources.data[attachment->resolve];
        if (!first) first = resource;
        const struct graph_image_params *a = &first->params, *b = &resource->params;
        if (a->width != b->width || a->height != b->height || a->layers != b->layers || a->samples != b->samples)
            graph_misuse(graph,
                         "pass '%s' has attachments of different sizes: '%s' is %ux%u, %u layers, %u samples, '%s' is "
                         "%ux%u, %u layers, "
                         "%u samples",
                         pass->name, first->name, a->width, a->height, a->layers, a->samples, resource->name, b->width,
                         b->height, b->layers, b->samples);
        if (resolve && (resolve->params.width != a->width || resolve->params.height != a->height ||
                        resolve->params.layers != a->layers))
            graph_misuse(graph, "pass '%s' resolves '%s' into '%s', which is of another size", pass->name, resource->name,
                         resolve->name);
    }
    if (pass->vertex_layers && (!first || pass->scope || pass->view_mask || pass->vertex_layers > MAX(first->params.layers, 1u)))
        graph_misuse(graph, "pass '%s' draws into %u layers, but %s", pass->name, pass->vertex_layers,
                     !first            ? "has no attachments"
                     : pass->scope     ? "is in a scope"
                     : pass->view_mask ? "has a view mask"
                                       : "its attachments have fewer");
    if (!pass->view_mask) return;
    const uint32_t most = graph->device ? gpu_info(graph->device)->max_views : 32;
    if (!first || pass->scope)
        graph_misuse(graph, "pass '%s' draws several views, but %s", pass->name, first ? "is in a scope" : "has no attachments");
    else if (first->params.layers < 32 && pass->view_mask >> first->params.layers)
        graph_misuse(graph, "pass '%s' draws views %#x, but '%s' has %u layers", pass->name, pass->view_mask, first->name,
                     first->params.layers);
    else if (most < 32 && pass->view_mask >> most)
        graph_misuse(graph, "pass '%s' draws views %#x, but the device takes %u", pass->name, pass->view_mask, most);
}

static void check(struct graph *graph) {
    graph_check_names(graph);
    uint64_t *written = ARENA_ARRAY(&graph->arena, uint64_t, graph->resources.count); /* layers */
    if (!written) {
        graph_fail(graph, FNL_ERROR_MEMORY);
        return;
    }
    for (uint32_t i = 0; i < graph->passes.count; i++) {
        const struct graph_pass *pass = graph->passes.data[i];
        check_attachments(graph, pass);
        for (const struct graph_access *use = pass->first_use; use; use = use->next) {
            const struct graph_resource *resource = &graph->resources.data[use->resource];
            if (!resource->has_contents && (use->read_layers & ~written[use->resource]))
                graph_misuse(graph, "pass '%s' reads '%s', which nobody wrote before", pass->name, resource->name);
        }
        for (const struct graph_access *use = pass->first_use; use; use = use->next)
            written[use->resource] |= use->written_layers;
    }
}

/* ---- culling and lifetimes ---- */

static bool outlives_frame(const struct graph_resource *resource) {
    return resource->imported || resource->role != GRAPH_HISTORY_NONE;
}

static bool cull(struct graph *graph) {
    bool *needed = ARENA_ARRAY(&graph->arena, bool, graph->resources.count);
    if (!needed) return false;
    for (uint32_t i = graph->passes.count; i-- > 0;) {
        struct graph_pass *pass = graph->passes.data[i];
        pass->live = pass->keep;
        for (const struct graph_access *use = pass->first_use; use; use = use->next)
            pass->live |= use->writes && (needed[use->resource] || outlives_frame(&graph->resources.data[use->resource]));
        if (!pass->live) continue;
        for (const struct graph_access *use = pass->first_use; use; use = use->next) {
            if (use->reads)
                needed[use->resource] = true;
            else if (use->discards)
                needed[use->resource] = false;
        }
    }
    return true;
}

static bool list_steps(struct graph *graph) {
    struct graph_plan *plan = &graph->plan;
    plan->steps = ARENA_ARRAY(&graph->arena, struct graph_step, graph->passes.count);
    if (!plan->steps) return false;
    for (uint32_t i = 0, next; i < graph->passes.count; i = next) {
        struct graph_pass *pass = graph->passes.data[i];
        next = i + 1;
        if (!pass->live) {
            plan->culled_count++;
            continue;
        }
        if (pass->scope && pass->scope->merged) {
            pass = graph_merge(graph, i, &next);
            if (!pass) return graph->result != FNL_OK; /* what went wrong is known */
        }
        bool on_async = plan->async && pass->queue == GRAPH_QUEUE_ASYNC;
        plan->steps[plan->step_count++] =
            (struct graph_step){.pass = pass, .queue = on_async ? GPU_QUEUE_COMPUTE : GPU_QUEUE_GRAPHICS};
    }
    return true;
}

static void link_uses(struct graph *graph) {
    const struct graph_plan *plan = &graph->plan;
    for (uint32_t i = 0; i < graph->resources.count; i++) {
        struct graph_resource *resource = &graph->resources.data[i];
        resource->first_use = resource->last_use = NULL;
        resource->usage = 0;
        resource->on_async = false;
    }
    for (uint32_t step = 0; step < plan->step_count; step++) {
        for (struct graph_access *use = plan->steps[step].pass->first_use; use; use = use->next) {
            struct graph_resource *resource = &graph->resources.data[use->resource];
            use->step = step;
            use->next_of_resource = NULL;
            use->previous_of_resource = resource->last_use;
            if (resource->last_use)
                resource->last_use->next_of_resource = use;
            else {
                resource->first_use = use;
                resource->first_step = step;
            }
            resource->last_use = use;
            resource->last_step = step;
            resource->usage |= use->usage;
            resource->on_async |= plan->steps[step].queue == GPU_QUEUE_COMPUTE;
        }
    }
    for (uint32_t i = 0; i < graph->resources.count; i++) {
        struct graph_resource *resource = &graph->resources.data[i];
        const VkImageUsageFlags attachment = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT |
                                             VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT |
                                             VK_IMAGE_USAGE_INPUT_ATTACHMENT_BIT;
        if (resource->first_use && resource->first_use == resource->last_use && !resource->first_use->reads &&
            !outlives_frame(resource) && resource->usage && !(resource->usage & ~attachment))
            resource->usage |= VK_IMAGE_USAGE_TRANSIENT_ATTACHMENT_BIT; /* never seen outside of one pass */
    }
    /* Work of two queues has no order between their meeting points, so what the compute queue touches keeps its memory for
       the whole frame. */
    for (uint32_t i = 0; i < graph->resources.count; i++) {
        struct graph_resource *resource = &graph->resources.data[i];
        if (!resource->on_async) continue;
        resource->first_step = 0;
        resource->last_step = plan->step_count - 1;
    }
}

/* Each read learns of the reads that follow it, so that one barrier serves them all. */
static void find_runs(const struct graph *graph, struct graph_resource *resource) {
    VkPipelineStageFlags2 stages[2] = {0, 0};
    VkAccessFlags2 access[2] = {0, 0};
    for (struct graph_access *use = resource->last_use; use; use = use->previous_of_resource) {
        const struct graph_access *next = use->next_of_resource;
        if (use->writes || (next && (next->writes || next->layout != use->layout))) {
            memset(stages, 0, sizeof stages);
            memset(access, 0, sizeof access);
        }
        enum gpu_queue queue = graph->plan.steps[use->step].queue;
        use->run_stages = stages[queue] |= use->stages;
        use->run_access = access[queue] |= use->access;
    }
}

/* ---- barriers ---- */

static void add_memory(struct graph *graph, struct graph_barriers *barriers, uint32_t resource,
                       VkPipelineStageFlags2 from_stages, VkAccessFlags2 from_access, VkPipelineStageFlags2 to_stages,
                       VkAccessFlags2 to_access) {
    struct graph_cause *cause = arena_allocate(&graph->arena, sizeof *cause);
    if (!cause) {
        graph_fail(graph, FNL_ERROR_MEMORY);
        return;
    }
    *cause = (struct graph_cause){NULL, resource};
    if (barriers->last_cause)
        barriers->last_cause->next = cause;
    else {
        barriers->first_cause = cause;
        graph->plan.barrier_count++;
    }
    barriers->last_cause = cause;
    barriers->from_stages |= from_stages;
    barriers->from_access |= from_access;
    barriers->to_stages |= to_stages;
    barriers->to_access |= to_access;
}

static void add_image(struct graph *graph, struct graph_barriers *barriers, const struct graph_barrier *wanted) {
    struct graph_barrier *barrier = arena_allocate(&graph->arena, sizeof *barrier);
    if (!barrier) {
        graph_fail(graph, FNL_ERROR_MEMORY);
        return;
    }
    *barrier = *wanted;
    barrier->next = NULL;
    if (barriers->last)
        barriers->last->next = barrier;
    else
        barriers->first = barrier;
    barriers->last = barrier;
    graph->plan.barrier_count++;
}

static bool is_attachment_layout(VkImageLayout layout) {
    return layout == VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL || layout == VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL ||
           layout == VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL ||
           layout == VK_IMAGE_LAYOUT_STENCIL_ATTACHMENT_OPTIMAL;
}

static bool modifies(const struct graph_resource *resource, const struct graph_access *use) {
    return use->writes || (resource->is_image && resource->state.layout != use->layout);
}

/* Batch of the other queue that must be over before this use; -1: none. */
static int64_t batch_to_wait_for(const struct graph_resource *resource, const struct graph_access *use,
                                 enum gpu_queue queue) {
    const struct graph_state *state = &resource->state;
    enum gpu_queue other = queue == GPU_QUEUE_GRAPHICS ? GPU_QUEUE_COMPUTE : GPU_QUEUE_GRAPHICS;
    int64_t batch = state->write_queue == other ? (int64_t)state->write_batch : -1;
    if (modifies(resource, use) && state->read_stages[other]) batch = MAX(batch, (int64_t)state->read_batch[other]);
    return batch;
}

/* What the earlier users of the resource's memory did with it. They all ran on the graphics queue, see link_uses. */
static void find_former_tenants(const struct graph *graph, const struct graph_resource *resource,
                                VkPipelineStageFlags2 *stages, VkAccessFlags2 *access) {
    for (uint32_t i = graph->pools.data[resource->pool].first_resource; i != GRAPH_NONE;
         i = graph->resources.data[i].next_in_pool) {
        const struct graph_resource *former = &graph->resources.data[i];
        if (former->offset >= resource->offset + resource->size) break;
        if (former == resource || former->last_step >= resource->first_step || !graph_overlaps(former, resource)) continue;
        *stages |= former->state.write_stages | former->state.read_stages[GPU_QUEUE_GRAPHICS];
        *access |= former->state.write_access;
    }
}

/* The same of those that had it in the last frame. */
static void find_last_tenants(const struct graph *graph, const struct graph_resource *resource,
                              VkPipelineStageFlags2 *stages, VkAccessFlags2 *access) {
    const struct graph_pool *pool = &graph->pools.data[resource->pool];
    for (uint32_t i = 0; i < pool->tenants.count; i++) {
        const struct graph_tenant *tenant = &pool->tenants.data[i];
        if (tenant->offset >= resource->offset + resource->size || resource->offset >= tenant->offset + tenant->size) continue;
        *stages |= tenant->stages;
        *access |= tenant->access;
    }
}

/* Everything before `use` may happen; the other queue has been waited for. */
static void add_barriers(struct graph *graph, struct graph_step *step, struct graph_access *use) {
    struct graph_resource *resource = &graph->resources.data[use->resource];
    struct graph_state *state = &resource->state;
    const VkPipelineStageFlags2 to_stages = use->writes ? use->stages : use->run_stages;
    const VkAccessFlags2 to_access = use->writes ? use->access : use->run_access;
    const VkImageLayout from_layout = use->discards && !resource->has_contents ? VK_IMAGE_LAYOUT_UNDEFINED : state->layout;
    bool transition = resource->is_image && state->layout != use->layout;

    if (transition && step->queue == GPU_QUEUE_COMPUTE && is_attachment_layout(state->layout)) {
        /* A compute queue may not know how to leave an attachment's layout: the graphics queue does, at its batch's end. */
        struct graph_barriers *after = &graph->plan.batches[state->write_batch].after;
        /* Later reads of the graphics queue need nothing more. */
        const VkPipelineStageFlags2 all = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
        const VkPipelineStageFlags2 write_or_read = state->write_stages | state->read_stages[GPU_QUEUE_GRAPHICS];
        add_image(graph, after,
                  &(struct graph_barrier){NULL, use->resource, write_or_read ? write_or_read : all, all,
                                          state->write_access, VK_ACCESS_2_MEMORY_READ_BIT, from_layout, use->layout});
        state->visible_stages = ~0ull;
        state->visible_access = ~WRITE_ACCESS;
        state->write_stages = all;
        state->write_access = 0;
        state->layout = use->layout;
        transition = false;
    }

    VkPipelineStageFlags2 from_stages = 0;
    VkAccessFlags2 from_access = 0;
    if (use->writes || transition) {
        if (state->read_stages[step->queue])
            from_stages = state->read_stages[step->queue]; /* they have waited for the write */
        else if (state->write_queue == step->queue) {
            from_stages = state->write_stages;
            from_access = state->write_access;
        }
    } else if (state->write_queue == step->queue &&
               ((use->stages & ~state->visible_stages) || (use->access & ~state->visible_access))) {
        from_stages = state->write_stages;
        from_access = state->write_access;
        state->visible_stages = to_stages;
        state->visible_access = to_access;
    }
    /* The compute queue has waited for the last frame as a whole. */
    if (resource->pool != GRAPH_NONE && use == resource->first_use && step->queue == GPU_QUEUE_GRAPHICS) {
        VkPipelineStageFlags2 former_stages = 0;
        VkAccessFlags2 former_access = 0;
        if (!resource->on_async) find_former_tenants(graph, resource, &former_stages, &former_access);
        find_last_tenants(graph, resource, &former_stages, &former_access);
        from_stages |= former_stages;
        from_access |= former_access;
        /* An image barrier flushes the new image only; the former tenant's writes need a global one. */
        if (resource->is_image && former_access)
            add_memory(graph, &step->before, use->resource, former_stages, former_access, to_stages, to_access);
    }

    if (resource->is_image && (transition || from_stages)) {
        /* With no work of this queue to wait for, a change of layout follows the semaphore, if there was one, through the stages that
           wait for it. */
        add_image(graph, &step->before,
                  &(struct graph_barrier){NULL, use->resource, from_stages ? from_stages : to_stages, to_stages, from_access,
                                          to_access, transition ? from_layout : state->layout, use->layout});
    } else if (from_stages)
        add_memory(graph, &step->before, use->resource, from_stages, from_access, to_stages, to_access);

    if (use->writes || transition) {
        state->layout = use->layout;
        state->write_queue = step->queue;
        state->write_batch = step->batch;
        state->write_stages = to_stages;
        state->write_access = use->writes ? use->access & WRITE_ACCESS : 0;
        state->visible_stages = use->writes ? 0 : to_stages;
        state->visible_access = use->writes ? 0 : to_access;
        memset(state->read_stages, 0, sizeof state->read_stages);
    }
    if (!use->writes) {
        state->read_stages[step->queue] |= use->stages;
        state->read_batch[step->queue] = step->batch;
    }
}

/* ---- batches ---- */

struct schedule {
    uint32_t open[2];  /* batch that takes passes, by queue */
    int64_t waited[2]; /* latest batch of the other queue that the queue has waited for */
};

static uint32_t add_batch(struct graph_plan *plan, enum gpu_queue queue, int64_t wait) {
    plan->batches[plan->batch_count] = (struct graph_batch){
        .queue = queue, .wait = wait < 0 ? GRAPH_NONE : (uint32_t)wait, .first_step = GRAPH_NONE, .last_step = GRAPH_NONE};
    return plan->batch_count++;
}

static void put_in_batch(struct graph *graph, struct schedule *schedule, uint32_t index) {
    struct graph_plan *plan = &graph->plan;
    struct graph_step *step = &plan->steps[index];
    enum gpu_queue queue = step->queue, other = queue == GPU_QUEUE_GRAPHICS ? GPU_QUEUE_COMPUTE : GPU_QUEUE_GRAPHICS;
    int64_t wait = queue == GPU_QUEUE_COMPUTE ? 0 : -1;
    for (const struct graph_access *use = step->pass->first_use; use; use = use->next)
        wait = MAX(wait, batch_to_wait_for(&graph->resources.data[use->resource], use, queue));
    if (wait > schedule->waited[queue]) {
        if (schedule->open[other] == wait) schedule->open[other] = GRAPH_NONE; /* a batch signals when it is complete */
        schedule->open[queue] = add_batch(plan, queue, wait);
        schedule->waited[queue] = wait;
    } else if (schedule->open[queue] == GRAPH_NONE)
        schedule->open[queue] = add_batch(plan, queue, -1);
    step->batch = schedule->open[queue];
    step->next_in_batch = GRAPH_NONE;
    struct graph_batch *batch = &plan->batches[step->batch];
    if (batch->last_step == GRAPH_NONE)
        batch->first_step = index;
    else
        plan->steps[batch->last_step].next_in_batch = index;
    batch->last_step = index;
    batch->step_count++;
}

/* The last batch is on the graphics queue and after everything else; it leaves imports as their owners want them. */
static void finish_frame(struct graph *graph, struct schedule *schedule) {
    struct graph_plan *plan = &graph->plan;
    int64_t last_compute = -1;
    for (uint32_t i = 0; i < plan->batch_count; i++)
        if (plan->batches[i].queue == GPU_QUEUE_COMPUTE) last_compute = i;
    if (last_compute > schedule->waited[GPU_QUEUE_GRAPHICS]) add_batch(plan, GPU_QUEUE_GRAPHICS, last_compute);
    struct graph_barriers *after = &plan->batches[plan->batch_count - 1].after;
    const VkPipelineStageFlags2 all = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
    for (uint32_t i = 0; i < graph->resources.count; i++) {
        struct graph_resource *resource = &graph->resources.data[i];
        struct graph_state *state = &resource->state;
        VkPipelineStageFlags2 from =
            state->read_stages[GPU_QUEUE_GRAPHICS] ? state->read_stages[GPU_QUEUE_GRAPHICS] : state->write_stages;
        VkAccessFlags2 access = state->write_access;
        if (!from || state->write_queue == GPU_QUEUE_COMPUTE || state->read_stages[GPU_QUEUE_COMPUTE]) {
            from = all;
            access = access ? VK_ACCESS_2_MEMORY_WRITE_BIT : 0;
        }
        if (resource->host_read)
            add_memory(graph, after, i, from | state->write_stages, access, VK_PIPELINE_STAGE_2_HOST_BIT,
                       VK_ACCESS_2_HOST_READ_BIT);
        if (!resource->is_image || !resource->imported || resource->final_layout == VK_IMAGE_LAYOUT_UNDEFINED ||
            resource->final_layout == state->layout)
            continue;
        if (from == state->read_stages[GPU_QUEUE_GRAPHICS]) access = 0; /* they have waited for the write */
        add_image(graph, after,
                  &(struct graph_barrier){NULL, i, from, all, access,
                                          VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT, state->layout,
                                          resource->final_layout});
        state->layout = resource->final_layout;
        state->write_queue = GPU_QUEUE_GRAPHICS;
        state->write_stages = all;
        state->write_access = 0;
        state->visible_stages = ~0ull;
        state->visible_access = ~0ull;
        memset(state->read_stages, 0, sizeof state->read_stages);
    }
}

static bool make_schedule(struct graph *graph) {
    struct graph_plan *plan = &graph->plan;
    plan->batches = ARENA_ARRAY(&graph->arena, struct graph_batch, plan->step_count + 3);
    if (!plan->batches) return false;
    for (uint32_t i = 0; i < graph->resources.count; i++) {
        struct graph_resource *resource = &graph->resources.data[i];
        if (!graph_first_state(graph, resource, &resource->state)) return false;
        find_runs(graph, resource);
    }
    struct schedule schedule = {.open = {add_batch(plan, GPU_QUEUE_GRAPHICS, -1), GRAPH_NONE}, .waited = {-1, -1}};
    if (plan->async) schedule.open[GPU_QUEUE_GRAPHICS] = GRAPH_NONE;
    for (uint32_t i = 0; i < plan->step_count; i++) {
        put_in_batch(graph, &schedule, i);
        for (struct graph_access *use = plan->steps[i].pass->first_use; use; use = use->next)
            add_barriers(graph, &plan->steps[i], use);
    }
    finish_frame(graph, &schedule);
    return true;
}

/* ---- traffic ---- */

static void count_traffic(struct graph *graph) {
    struct graph_plan *plan = &graph->plan;
    struct graph_traffic rows[64];
    uint32_t count;
    for (uint32_t step = 0; step < plan->step_count; step++) {
        count = graph_step_traffic(graph, step, rows, COUNT_OF(rows));
        for (uint32_t i = 0; i < MIN(count, (uint32_t)COUNT_OF(rows)); i++) {
            plan->bytes_read += rows[i].bytes_read;
            plan->bytes_written += rows[i].bytes_written;
        }
    }
    for (uint32_t i = 0; i < graph->resources.count; i++)
        if (graph->resources.data[i].first_use && (graph->resources.data[i].usage & VK_IMAGE_USAGE_TRANSIENT_ATTACHMENT_BIT))
            plan->tile_bytes += graph_image_bytes(&graph->resources.data[i]);
}

/* ---- the whole ---- */

fnl_result graph_compile_for(struct graph *graph, bool async) {
    double start = time_now();
    struct graph_plan *plan = &graph->plan;
    memset(plan, 0, sizeof *plan);
    if (graph->result == FNL_OK) check(graph);
    if (graph->result != FNL_OK) return graph->result;
    if (!cull(graph)) graph_fail(graph, FNL_ERROR_MEMORY);
    for (uint32_t i = 0; i < graph->passes.count; i++)
        plan->async |= async && graph->passes.data[i]->live && graph->passes.data[i]->queue == GRAPH_QUEUE_ASYNC;
    if (graph->result == FNL_OK && !list_steps(graph)) graph_fail(graph, FNL_ERROR_MEMORY);
    if (graph->result != FNL_OK) return graph->result;
    link_uses(graph);
    count_traffic(graph);
    if (!graph_place_resources(graph))
        graph_fail(graph, FNL_ERROR_MEMORY);
    else if (!make_schedule(graph))
        graph_fail(graph, FNL_ERROR_MEMORY);
    plan->compiled = graph->result == FNL_OK;
    plan->compile_milliseconds = (time_now() - start) * 1e3;
    return graph->result;
}

fnl_result graph_compile(struct graph *graph) {
    return graph_compile_for(graph, graph->device ? gpu_info(graph->device)->async_compute : true);
}

struct graph_stats graph_query_stats(const struct graph *graph) {
    const struct graph_plan *plan = &graph->plan;
    return (struct graph_stats){.pass_count = plan->step_count,
                                .culled_pass_count = plan->culled_count,
                                .barrier_count = plan->barrier_count,
                                .batch_count = plan->batch_count,
                                .transient_bytes = plan->transient_bytes,
                                .transient_bytes_unaliased = plan->unaliased_bytes,
                                .image_bytes_read = plan->bytes_read,
                                .image_bytes_written = plan->bytes_written,
                                .tile_bytes = plan->tile_bytes,
                                .compile_milliseconds = plan->compile_milliseconds,
                                .place_milliseconds = graph->place_milliseconds,
                                .record_milliseconds = graph->record_milliseconds,
                                .submit_milliseconds = graph->submit_milliseconds};
}
