/* SPDX-License-Identifier: MIT */
/** Recording the plan on several threads, submitting it, and reading the timers. */
#include "graph/graph_internal.h"

#include "base/jobs.h"

enum { BARRIERS_AT_ONCE = 16, MAX_TIMERS = GPU_MAX_TIMESTAMPS / 2 };

/** A run of passes of one batch that goes into one command buffer. */
struct segment {
    uint32_t batch, first_step, step_count, chunk;
    bool starts_batch, ends_batch;
};

struct recorder {
    struct graph *graph;
    struct segment *segments;
    struct gpu_commands **commands; /* by segment */
    uint32_t segment_count;
    bool timers, poison;
};

/** What graph_get_image and graph_get_buffer find behind the context that a pass was given. */
struct recording {
    struct graph_context context; /* first */
    const struct graph_pass *pass;
};

/* ---- inside a pass ---- */

static const struct graph_resource *used_resource(const struct graph_context *context, uint32_t id, bool is_image) {
    const struct recording *recording = (const struct recording *)context;
    const struct graph *graph = context->graph;
    const struct graph_resource *resource = graph_find_resource(graph, id, is_image);
    const char *kind = is_image ? "image" : "buffer";
    if (!resource)
        log_error(&graph->host, "graph: pass '%s' asks for %s %#x, which is no handle of this frame", recording->pass->name,
                  kind, id);
    else {
        for (const struct graph_access *use = recording->pass->first_use; use; use = use->next)
            if (&graph->resources.data[use->resource] == graph_whole(graph, resource)) return resource;
        log_error(&graph->host, "graph: pass '%s' asks for '%s' without a declared use of it", recording->pass->name,
                  resource->name);
    }
    gpu_fail(context->device, FNL_ERROR_INVALID);
    return NULL;
}

const struct gpu_image *graph_get_image(const struct graph_context *context, graph_image image) {
    static const struct gpu_image none = {
        .sampled_index = GPU_NO_INDEX, .storage_index = GPU_NO_INDEX, .srgb_index = GPU_NO_INDEX};
    const struct graph_resource *resource = used_resource(context, image.id, true);
    return resource ? resource->image : &none;
}

const struct gpu_buffer *graph_get_buffer(const struct graph_context *context, graph_buffer buffer) {
    static const struct gpu_buffer none = {0};
    const struct graph_resource *resource = used_resource(context, buffer.id, false);
    return resource ? resource->buffer : &none;
}

/* ---- recording ---- */

static void record_barriers(const struct graph *graph, struct gpu_commands *commands,
                            const struct graph_barriers *barriers) {
    struct gpu_image_barrier images[BARRIERS_AT_ONCE];
    uint32_t count = 0;
    bool memory = barriers->from_stages != 0;
    for (const struct graph_barrier *barrier = barriers->first; barrier || count || memory;) {
        if (barrier && count < BARRIERS_AT_ONCE) {
            images[count++] = (struct gpu_image_barrier){graph->resources.data[barrier->resource].image,
                                                         barrier->from_stages,
                                                         barrier->to_stages,
                                                         barrier->from_access,
                                                         barrier->to_access,
                                                         barrier->from_layout,
                                                         barrier->to_layout};
            barrier = barrier->next;
            continue;
        }
        if (memory)
            gpu_barrier(commands, images, count, barriers->from_stages, barriers->from_access, barriers->to_stages,
                        barriers->to_access);
        else
            gpu_barrier(commands, images, count, 0, 0, 0, 0);
        memory = false;
        count = 0;
    }
}

static struct gpu_attachment attachment_of(const struct graph *graph, const struct graph_pass_attachment *declared,
                                           uint32_t step) {
    const struct graph_resource *resource = &graph->resources.data[declared->resource];
    struct gpu_attachment attachment = {.image = resource->image,
                                        .load = declared->load,
                                        .store = graph_store_op(graph, resource, declared->read_only, step),
                                        .clear = declared->clear,
                                        .read_only = declared->read_only};
    if (declared->resolve != GRAPH_NONE) attachment.resolve = graph->resources.data[declared->resolve].image;
    return attachment;
}

static bool begin_rendering(const struct graph *graph, struct gpu_commands *commands, const struct graph_pass *pass,
                            uint32_t step) {
    bool has_depth = pass->depth.resource != GRAPH_NONE;
    if (pass->color_count == 0 && !has_depth) return false;
    const struct graph_image_params *params =
        &graph->resources.data[has_depth ? pass->depth.resource : pass->colors[0].resource].params;
    struct gpu_rendering rendering = {.width = params->width,
                                      .height = params->height,
                                      .layers = params->layers,
                                      .view_mask = pass->view_mask,
                                      .color_count = pass->color_count};
    for (uint32_t i = 0; i < pass->color_count; i++) rendering.colors[i] = attachment_of(graph, &pass->colors[i], step);
    if (has_depth) rendering.depth = attachment_of(graph, &pass->depth, step);
    gpu_begin_rendering(commands, &rendering);
    return true;
}

static void execute(const struct recording *recording) {
    const struct graph_pass *pass = recording->pass;
    graph_patch_data(&recording->context, pass);
    if (pass->execute) pass->execute(&recording->context, pass->data);
}

/* The passes of a merged scope, a step each. */
static void record_scope(const struct graph *graph, struct gpu_commands *commands, const struct graph_merged *merged,
                         uint32_t step) {
    struct gpu_scope_params params;
    const struct gpu_image *images[GPU_MAX_SCOPE_ATTACHMENTS];
    VkClearValue clears[GPU_MAX_SCOPE_ATTACHMENTS];
    memset(&params, 0, sizeof params); /* hashed as bytes */
    params.attachment_count = merged->attachment_count;
    params.step_count = merged->part_count;
    for (uint32_t i = 0; i < merged->attachment_count; i++) {
        const struct graph_pass_attachment *attachment = &merged->attachments[i];
        const struct graph_resource *resource = &graph->resources.data[attachment->resource];
        params.attachments[i].format = resource->params.format;
        params.attachments[i].load = attachment->load;
        params.attachments[i].store = graph_store_op(graph, resource, attachment->read_only, step);
        images[i] = resource->image;
        clears[i] = attachment->clear;
    }
    for (uint32_t i = 0; i < merged->part_count; i++) {
        const struct graph_pass *part = merged->parts[i];
        struct gpu_scope_step *s = &params.steps[i];
        s->color_count = part->color_count;
        s->input_count = part->input_count;
        for (uint32_t k = 0; k < part->color_count; k++)
            s->colors[k] = graph_merged_attachment(merged, part->colors[k].resource);
        for (uint32_t k = 0; k < part->input_count; k++)
            s->inputs[k] = part->inputs[k] == GRAPH_NONE ? GPU_NO_INDEX : graph_merged_attachment(merged, part->inputs[k]);
        s->depth = part->depth.resource == GRAPH_NONE ? GPU_NO_INDEX : graph_merged_attachment(merged, part->depth.resource);
        s->depth_read_only = part->depth.read_only;
    }
    const struct gpu_scope *scope = gpu_scope_find(graph->device, &params);
    gpu_begin_scope(commands, scope, images, clears);
    for (uint32_t i = 0; i < merged->part_count && scope; i++) {
        const struct graph_pass *part = merged->parts[i];
        if (i) gpu_next_step(commands);
        gpu_begin_label(commands, part->name);
        struct recording recording = {{commands, graph->device, graph, scope, i, 0}, part};
        execute(&recording);
        gpu_end_label(commands);
    }
    gpu_end_scope(commands);
}

static void record_step(const struct recorder *recorder, struct gpu_commands *commands, uint32_t index) {
    const struct graph *graph = recorder->graph;
    const struct graph_step *step = &graph->plan.steps[index];
    const struct graph_pass *pass = step->pass;
    bool timed = recorder->timers && index < MAX_TIMERS;
    record_barriers(graph, commands, &step->before);
    gpu_begin_label(commands, pass->name);
    if (timed) gpu_timestamp(commands, 2 * index);
    if (pass->merged) {
        record_scope(graph, commands, pass->merged, index);
    } else {
        bool rendering = begin_rendering(graph, commands, pass, index);
        struct recording recording = {{commands, graph->device, graph, NULL, 0, pass->view_mask}, pass};
        execute(&recording);
        if (rendering) gpu_end_rendering(commands);
    }
    if (timed) gpu_timestamp(commands, 2 * index + 1);
    gpu_end_label(commands);
}

static void poison_buffers(const struct graph *graph, struct gpu_commands *commands) {
    const VkPipelineStageFlags2 all = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
    for (uint32_t i = 0; i < graph->resources.count; i++) {
        const struct graph_resource *resource = &graph->resources.data[i];
        if (resource->is_image || resource->imported || !resource->buffer) continue;
        gpu_fill_buffer(commands, resource->buffer, 0, resource->buffer->size / 4 * 4, 0xa5a5a5a5u);
        gpu_barrier(commands, NULL, 0, all, VK_ACCESS_2_MEMORY_WRITE_BIT, all, /* they may share memory */
                    VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT);
    }
}

static void record_chunk(void *context, uint32_t chunk) {
    struct recorder *recorder = context;
    const struct graph_plan *plan = &recorder->graph->plan;
    for (uint32_t i = 0; i < recorder->segment_count; i++) {
        const struct segment *segment = &recorder->segments[i];
        if (segment->chunk != chunk) continue;
        const struct graph_batch *batch = &plan->batches[segment->batch];
        struct gpu_commands *commands = gpu_commands_begin(recorder->graph->device, batch->queue, chunk);
        recorder->commands[i] = commands;
        if (recorder->poison && segment->batch == 0 && segment->starts_batch) poison_buffers(recorder->graph, commands);
        uint32_t step = segment->first_step;
        for (uint32_t n = 0; n < segment->step_count; n++, step = plan->steps[step].next_in_batch)
            record_step(recorder, commands, step);
        if (segment->ends_batch) record_barriers(recorder->graph, commands, &batch->after);
        gpu_commands_end(commands);
    }
}

/* Cuts the passes, in order of submission, into `chunks` equal runs, and these where batches end. */
static bool make_segments(struct recorder *recorder, uint32_t chunks) {
    struct arena *arena = &recorder->graph->arena;
    const struct graph_plan *plan = &recorder->graph->plan;
    uint32_t capacity = plan->batch_count + chunks;
    recorder->segments = ARENA_ARRAY(arena, struct segment, capacity);
    recorder->commands = ARENA_ARRAY(arena, struct gpu_commands *, capacity);
    if (!recorder->segments || !recorder->commands) return false;
    uint32_t done = 0, chunk = 0;
    for (uint32_t b = 0; b < plan->batch_count; b++) {
        const struct graph_batch *batch = &plan->batches[b];
        uint32_t step = batch->first_step, left = batch->step_count;
        bool starts = true;
        do {
            while (chunk + 1 < chunks && done >= (uint64_t)plan->step_count * (chunk + 1) / chunks) chunk++;
            uint32_t end = (uint32_t)((uint64_t)plan->step_count * (chunk + 1) / chunks);
            uint32_t count = MIN(left, end - done);
            recorder->segments[recorder->segment_count++] = (struct segment){b, step, count, chunk, starts, count == left};
            for (uint32_t n = 0; n < count; n++) step = plan->steps[step].next_in_batch;
            done += count;
            left -= count;
            starts = false;
        } while (left);
    }
    return true;
}

static fnl_result submit(const struct recorder *recorder, const struct gpu_external_semaphores *external) {
    const struct graph *graph = recorder->graph;
    const struct graph_plan *plan = &graph->plan;
    struct gpu_batch *batches = ARENA_ARRAY(&recorder->graph->arena, struct gpu_batch, plan->batch_count);
    if (!batches) return FNL_ERROR_MEMORY;
    for (uint32_t i = 0, segment = 0; i < plan->batch_count; i++) {
        const struct graph_batch *batch = &plan->batches[i];
        batches[i] = (struct gpu_batch){.queue = batch->queue,
                                        .commands = &recorder->commands[segment],
                                        .wait_batch = batch->wait == GRAPH_NONE ? GPU_NO_INDEX : batch->wait};
        while (segment < recorder->segment_count && recorder->segments[segment].batch == i)
            segment++, batches[i].command_count++;
    }
    return gpu_frame_end(graph->device, batches, plan->batch_count, external);
}

/* ---- timers of the frame ---- */

/* The frame of the slot is over. */
static void read_timers(struct graph *graph, uint32_t index) {
    struct graph_timer_slot *slot = &graph->timer_slots[index];
    uint64_t times[GPU_MAX_TIMESTAMPS];
    uint32_t count = slot->names.count;
    slot->results_frame = slot->frame_number;
    slot->results.count = 0;
    /* Another graph of the device may have used the slot since. */
    if (gpu_frame_number(graph->device) > slot->frame_number + GPU_FRAMES_IN_FLIGHT) return;
    if (count == 0 || !gpu_frame_timestamps(graph->device, index, 2 * count, times)) return;
    if (!array_reserve(&graph->host, &slot->results, count)) return;
    for (uint32_t i = 0; i < count; i++) {
        const struct graph_timed *timed = &slot->names.data[i];
        double nanoseconds = times[2 * i + 1] > times[2 * i] ? (double)(times[2 * i + 1] - times[2 * i]) : 0;
        slot->results.data[i] = (struct graph_timer){timed->name, (double)times[2 * i] * 1e-6, nanoseconds * 1e-6, timed->queue, timed->role};
    }
    slot->results.count = count;
}

/* The slot's last frame is over since this one began: its results are kept before they are overwritten. */
static bool name_timers(struct graph *graph, bool timers) {
    uint32_t index = gpu_frame_slot(graph->device);
    struct graph_timer_slot *slot = &graph->timer_slots[index];
    if (slot->results_frame != slot->frame_number) read_timers(graph, index);
    slot->frame_number = gpu_frame_number(graph->device);
    slot->names.count = 0;
    if (!timers) return true;
    uint32_t count = MIN(graph->plan.step_count, (uint32_t)MAX_TIMERS);
    if (!array_reserve(&graph->host, &slot->names, count)) return false;
    for (uint32_t i = 0; i < count; i++)
        slot->names.data[i] = (struct graph_timed){graph->plan.steps[i].pass->name, graph->plan.steps[i].queue, graph->plan.steps[i].pass->role};
    slot->names.count = count;
    return true;
}

/* ---- executing ---- */

/* Nothing is submitted, but the frame must end for the next one to begin. */
static fnl_result give_up(struct graph *graph, const struct gpu_external_semaphores *external, fnl_result result) {
    fnl_result ended = gpu_frame_end(graph->device, NULL, 0, external);
    return result != FNL_OK ? result : ended;
}

fnl_result graph_execute_frame(struct graph *graph, const struct graph_execute_params *params) {
    const struct graph_execute_params defaults = {0};
    if (!params) params = &defaults;
    REQUIRE(&graph->host, graph->device != NULL);
    if (params->force_async_on_graphics && graph->plan.compiled && !graph->plan.async) graph_compile_for(graph, true);
    if (!graph->plan.compiled || graph->executed) {
        if (graph->result == FNL_OK)
            log_error(&graph->host, "graph: a frame is executed that is not compiled, or for a second time");
        return give_up(graph, params->external, graph->result != FNL_OK ? graph->result : FNL_ERROR_INVALID);
    }
    const double begun = time_now();
    fnl_result result = graph_realise(graph);
    if (result != FNL_OK) return give_up(graph, params->external, result);
    graph_put_addresses(graph);
    const double placed = time_now();

    struct jobs *jobs = gpu_jobs(graph->device);
    uint32_t threads = params->record_threads ? params->record_threads : jobs_thread_count(jobs);
    uint32_t chunks = CLAMP(threads, 1u, MAX(1u, MIN((uint32_t)GPU_MAX_CHUNKS, graph->plan.step_count)));
    struct recorder recorder = {.graph = graph, .timers = params->timers, .poison = params->poison};
    if (!make_segments(&recorder, chunks) || !name_timers(graph, params->timers))
        return give_up(graph, params->external, FNL_ERROR_MEMORY);
    jobs_parallel_for(jobs, chunks, record_chunk, &recorder);
    graph->executed = true;
    const double recorded = time_now();
    result = submit(&recorder, params->external);
    graph->place_milliseconds = (placed - begun) * 1e3;
    graph->record_milliseconds = (recorded - placed) * 1e3;
    graph->submit_milliseconds = (time_now() - recorded) * 1e3;
    if (result == FNL_OK)
        graph_commit(graph);
    else
        graph->timer_slots[gpu_frame_slot(graph->device)].names.count = 0;
    return result;
}

/* ---- asking for pipelines ---- */

/* Places without memory, for passes to find what they declared. */
static bool stand_in(struct graph *graph) {
    for (uint32_t i = 0; i < graph->resources.count; i++) {
        struct graph_resource *resource = &graph->resources.data[i];
        if (resource->imported) continue;
        if (resource->is_image) {
            struct gpu_image *image = ARENA_ARRAY(&graph->arena, struct gpu_image, 1);
            if (!image) return false;
            image->params = graph_gpu_params(resource);
            image->sampled_index = image->storage_index = image->srgb_index = GPU_NO_INDEX;
            resource->image = image;
        } else {
            struct gpu_buffer *buffer = ARENA_ARRAY(&graph->arena, struct gpu_buffer, 1);
            if (!buffer) return false;
            buffer->size = resource->buffer_size;
            resource->buffer = buffer;
        }
    }
    return true;
}

fnl_result graph_ask_pipelines(struct graph *graph, uint64_t *out_ticket) {
    *out_ticket = 0;
    REQUIRE(&graph->host, graph->device != NULL);
    REQUIRE(&graph->host, graph->plan.compiled && !graph->executed);
    if (!stand_in(graph)) return FNL_ERROR_MEMORY;
    graph->executed = true;
    const struct recorder recorder = {.graph = graph};
    struct gpu_commands *commands = gpu_ask_begin(graph->device);
    for (uint32_t i = 0; i < graph->plan.step_count; i++) record_step(&recorder, commands, i);
    *out_ticket = gpu_ask_end(graph->device);
    return FNL_OK;
}

/* ---- timers ---- */

bool graph_query_timers(struct graph *graph, uint64_t frame_number, const struct graph_timer **out, uint32_t *out_count) {
    *out = NULL;
    *out_count = 0;
    for (uint32_t i = 0; i < GPU_FRAMES_IN_FLIGHT && graph->device; i++) {
        struct graph_timer_slot *slot = &graph->timer_slots[i];
        if (slot->frame_number == frame_number && slot->results_frame != frame_number && slot->names.count) {
            if (gpu_frame_number(graph->device) >= frame_number + GPU_FRAMES_IN_FLIGHT)
                return false; /* overwritten by another graph */
            if (gpu_frame_wait(graph->device, frame_number) != FNL_OK) return false;
            read_timers(graph, i);
        }
        if (slot->results_frame != frame_number || slot->results.count == 0) continue;
        *out = slot->results.data;
        *out_count = slot->results.count;
        return true;
    }
    return false;
}
