/* SPDX-License-Identifier: MIT */
#include "gpu/gpu_internal.h"

static fnl_result create_queries(gpu_device *device, const VkQueryPoolCreateInfo *info, const char *name, VkQueryPool *out) {
    TRY(gpu_check(device, device->vk.CreateQueryPool(device->handle, info, NULL, out), "vkCreateQueryPool"));
    gpu_name(device, VK_OBJECT_TYPE_QUERY_POOL, (uint64_t)*out, name);
    return FNL_OK;
}

fnl_result gpu_frames_init(gpu_device *device) {
    const VkQueryPoolCreateInfo counts = {.sType = VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO,
                                          .queryType = VK_QUERY_TYPE_PIPELINE_STATISTICS,
                                          .queryCount = GPU_MAX_VERTEX_COUNTS,
                                          .pipelineStatistics = VK_QUERY_PIPELINE_STATISTIC_VERTEX_SHADER_INVOCATIONS_BIT},
                                times = {.sType = VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO, .queryType = VK_QUERY_TYPE_TIMESTAMP, .queryCount = GPU_MAX_TIMESTAMPS};
    for (uint32_t i = 0; i < GPU_FRAMES_IN_FLIGHT; i++) {
        struct gpu_frame *frame = &device->frames[i];
        if (device->info.vertex_counts) TRY(create_queries(device, &counts, "vertex counts", &frame->vertex_counts));
        if (device->info.vertex_counts) atomic_store(&frame->vertices_counted, true); /* new ones must be reset, too */
        if (device->timestamp_mask) TRY(create_queries(device, &times, "timestamps", &frame->queries));
    }
    return FNL_OK;
}

void gpu_frames_finish(gpu_device *device) {
    for (uint32_t i = 0; i < GPU_FRAMES_IN_FLIGHT; i++) gpu_slices_finish(device, &device->frames[i].slices);
    for (uint32_t i = 0; i < GPU_FRAMES_IN_FLIGHT; i++) {
        struct gpu_frame *frame = &device->frames[i];
        gpu_retire_release(device, i);
        array_free(&device->host, &frame->retired.items);
        for (uint32_t queue = 0; queue < GPU_QUEUE_COUNT; queue++) {
            for (uint32_t chunk = 0; chunk < GPU_MAX_CHUNKS; chunk++)
                gpu_command_pool_finish(device, &frame->pools[queue][chunk]);
        }
        device->vk.DestroyQueryPool(device->handle, frame->queries, NULL);
        device->vk.DestroyQueryPool(device->handle, frame->vertex_counts, NULL);
    }
    array_free(&device->host, &device->submit_infos);
    array_free(&device->host, &device->batch_values);
}

uint32_t gpu_frame_slot(const gpu_device *device) {
    return device->frame_number ? (uint32_t)((device->frame_number - 1) % GPU_FRAMES_IN_FLIGHT) : 0;
}

uint64_t gpu_frame_number(const gpu_device *device) { return device->frame_number; }

static fnl_result wait_for_frame(gpu_device *device, const struct gpu_frame *frame) {
    for (uint32_t i = 0; i < GPU_QUEUE_COUNT; i++)
        TRY(gpu_semaphore_wait(device, device->queues[i].timeline, frame->values[i]));
    return FNL_OK;
}

/* ---- timestamps ---- */

/** Keeps the ticks of a frame that is over; its queries are reset after. */
static void fetch_timestamps(gpu_device *device, struct gpu_frame *frame) {
    if (!frame->timestamps_pending) return;
    frame->timestamps_pending = false;
    frame->tick_count = 0;
    struct {
        uint64_t ticks, written;
    } results[GPU_MAX_TIMESTAMPS];
    uint32_t count = atomic_load(&frame->timestamp_count);
    if (count == 0) return;
    VkResult result =
        device->vk.GetQueryPoolResults(device->handle, frame->queries, 0, count, sizeof results, results, sizeof *results,
                                       VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WITH_AVAILABILITY_BIT);
    if (result < 0) {
        gpu_check(device, result, "vkGetQueryPoolResults");
        return;
    }
    while (frame->tick_count < count && results[frame->tick_count].written) {
        frame->ticks[frame->tick_count] = results[frame->tick_count].ticks;
        frame->tick_count++;
    }
}

static bool is_finished(gpu_device *device, const struct gpu_frame *frame) {
    for (uint32_t i = 0; i < GPU_QUEUE_COUNT; i++) {
        uint64_t value = 0;
        VkResult result = device->vk.GetSemaphoreCounterValue(device->handle, device->queues[i].timeline, &value);
        if (result != VK_SUCCESS || value < frame->values[i]) return false;
    }
    return true;
}

fnl_result gpu_frame_done(gpu_device *device, uint64_t frame_number, bool *out) {
    *out = frame_number == 0 || frame_number + GPU_FRAMES_IN_FLIGHT <= device->frame_number ||
           is_finished(device, &device->frames[(frame_number - 1) % GPU_FRAMES_IN_FLIGHT]);
    return gpu_status(device);
}

bool gpu_frame_timestamps(gpu_device *device, uint32_t slot, uint32_t count, uint64_t *out) {
    if (slot >= GPU_FRAMES_IN_FLIGHT) return false;
    struct gpu_frame *frame = &device->frames[slot];
    if (frame->timestamps_pending && is_finished(device, frame)) fetch_timestamps(device, frame);
    if (count == 0 || count > frame->tick_count) return false;
    double period = device->properties.limits.timestampPeriod; /* nanoseconds of one tick */
    const uint64_t mask = device->timestamp_mask;
    uint64_t earliest = frame->ticks[0]; /* of the other queue it may be another than the first; ticks may wrap */
    for (uint32_t i = 1; i < count; i++)
        if (((frame->ticks[i] - earliest) & mask) > mask / 2) earliest = frame->ticks[i];
    for (uint32_t i = 0; i < count; i++) out[i] = (uint64_t)((double)((frame->ticks[i] - earliest) & mask) * period);
    return true;
}

bool gpu_frame_vertex_count(gpu_device *device, uint64_t frame_number, uint32_t first, uint32_t count, uint64_t *out) {
    if (frame_number == 0 || device->frame_number >= frame_number + GPU_FRAMES_IN_FLIGHT || first + count > GPU_MAX_VERTEX_COUNTS) return false;
    const struct gpu_frame *frame = &device->frames[(frame_number - 1) % GPU_FRAMES_IN_FLIGHT];
    if (!frame->vertex_counts || !is_finished(device, frame)) return false;
    *out = 0;
    for (uint32_t i = first; i < first + count; i++) {
        uint64_t result[2] = {0, 0}; /* the number, and whether it is there */
        if (device->vk.GetQueryPoolResults(device->handle, frame->vertex_counts, i, 1, sizeof result, result, sizeof result,
                                           VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WITH_AVAILABILITY_BIT) < 0)
            return false;
        if (result[1]) *out += result[0];
    }
    return count > 0;
}

/* ---- begin ---- */

fnl_result gpu_frame_begin(gpu_device *device) {
    REQUIRE(&device->host, !device->in_frame);
    if (gpu_status(device) == FNL_ERROR_DEVICE_LOST) return FNL_ERROR_DEVICE_LOST;
    uint32_t slot = (uint32_t)(device->frame_number % GPU_FRAMES_IN_FLIGHT);
    struct gpu_frame *frame = &device->frames[slot];
    TRY(wait_for_frame(device, frame));
    fetch_timestamps(device, frame);
    gpu_retire_release(device, slot);
    gpu_slices_reset(device, &frame->slices);
    gpu_scopes_begin_frame(device, slot);
    for (uint32_t queue = 0; queue < GPU_QUEUE_COUNT; queue++) {
        for (uint32_t chunk = 0; chunk < GPU_MAX_CHUNKS; chunk++) {
            struct gpu_command_pool *pool = &frame->pools[queue][chunk];
            if (pool->used == 0) continue;
            TRY(gpu_check(device, device->vk.ResetCommandPool(device->handle, pool->handle, 0), "vkResetCommandPool"));
            pool->used = 0;
        }
    }
    if (frame->queries) device->vk.ResetQueryPool(device->handle, frame->queries, 0, GPU_MAX_TIMESTAMPS);
    atomic_store(&frame->timestamp_count, 0);
    if (frame->vertex_counts && atomic_exchange(&frame->vertices_counted, false))
        device->vk.ResetQueryPool(device->handle, frame->vertex_counts, 0, GPU_MAX_VERTEX_COUNTS);
    device->frame_number++;
    device->in_frame = true;
    return FNL_OK;
}

/* ---- end ---- */

enum { MAX_WAITS = 5 };

struct submission {
    VkSemaphoreSubmitInfo waits[MAX_WAITS], signals[2];
    uint32_t wait_count, signal_count;
};

static VkSemaphoreSubmitInfo semaphore_info(VkSemaphore semaphore, uint64_t value) {
    return (VkSemaphoreSubmitInfo){
        .sType = VK_STRUCTURE_TYPE_SEMAPHORE_SUBMIT_INFO,
        .semaphore = semaphore,
        .value = value,
        .stageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
    };
}

static void add_wait(struct submission *submission, VkSemaphore semaphore, uint64_t value) {
    submission->waits[submission->wait_count++] = semaphore_info(semaphore, value);
}

static fnl_result submit(gpu_device *device, struct gpu_queue_state *queue, const struct submission *submission,
                         struct gpu_commands *const *commands, uint32_t count) {
    device->submit_infos.count = 0;
    if (!array_reserve(&device->host, &device->submit_infos, count)) return FNL_ERROR_MEMORY;
    for (uint32_t i = 0; i < count; i++) {
        device->submit_infos.data[i] = (VkCommandBufferSubmitInfo){
            .sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_SUBMIT_INFO,
            .commandBuffer = commands[i]->handle,
        };
    }
    VkSubmitInfo2 info = {
        .sType = VK_STRUCTURE_TYPE_SUBMIT_INFO_2,
        .waitSemaphoreInfoCount = submission->wait_count,
        .pWaitSemaphoreInfos = submission->waits,
        .commandBufferInfoCount = count,
        .pCommandBufferInfos = device->submit_infos.data,
        .signalSemaphoreInfoCount = submission->signal_count,
        .pSignalSemaphoreInfos = submission->signals,
    };
    return gpu_check(device, device->vk.QueueSubmit2(queue->handle, 1, &info, VK_NULL_HANDLE), "vkQueueSubmit2");
}

/** Submits one batch; the queue mutex is held. `before`: the queues' values when the frame began to be submitted. */
static fnl_result submit_batch(gpu_device *device, const struct gpu_batch *batch, bool first, bool last,
                               const uint64_t before[GPU_QUEUE_COUNT], const struct gpu_external_semaphores *external) {
    struct gpu_queue_state *queue = &device->queues[batch->queue], *other = &device->queues[!batch->queue];
    struct submission submission = {0};
    uint64_t wait_value = 0; /* on the other queue */
    if (batch->wait_batch != GPU_NO_INDEX) wait_value = device->batch_values.data[batch->wait_batch];
    /* The first batch of a queue waits for the frame before, which may use the same transient memory. */
    if (queue->value == before[batch->queue]) wait_value = MAX(wait_value, before[!batch->queue]);
    /* The caller's semaphore speaks for the whole frame. */
    if (last && external && external->signal) wait_value = MAX(wait_value, other->value);
    if (wait_value) add_wait(&submission, other->timeline, wait_value);
    uint64_t uploaded = atomic_load(&device->uploads.submitted);
    if (uploaded > queue->upload_seen) add_wait(&submission, device->uploads.timeline, uploaded);
    if (first && external && external->wait) add_wait(&submission, external->wait, external->wait_value);
    submission.signals[submission.signal_count++] = semaphore_info(queue->timeline, queue->value + 1);
    if (last && external && external->signal)
        submission.signals[submission.signal_count++] = semaphore_info(external->signal, external->signal_value);
    TRY(submit(device, queue, &submission, batch->commands, batch->command_count));
    queue->value++;
    queue->upload_seen = uploaded;
    return FNL_OK;
}

static fnl_result check_batches(gpu_device *device, const struct gpu_batch *batches, uint32_t batch_count) {
    for (uint32_t i = 0; i < batch_count; i++) {
        REQUIRE(&device->host, batches[i].queue == GPU_QUEUE_GRAPHICS || batches[i].queue == GPU_QUEUE_COMPUTE);
        uint32_t wait = batches[i].wait_batch;
        REQUIRE(&device->host, wait == GPU_NO_INDEX || (wait < i && batches[wait].queue != batches[i].queue));
        for (uint32_t k = 0; k < batches[i].command_count; k++)
            REQUIRE(&device->host, batches[i].commands[k]->handle != VK_NULL_HANDLE);
    }
    return FNL_OK;
}

static fnl_result submit_batches(gpu_device *device, const struct gpu_batch *batches, uint32_t batch_count,
                                 const struct gpu_external_semaphores *external) {
    TRY(check_batches(device, batches, batch_count));
    if (!array_reserve(&device->host, &device->batch_values, batch_count)) return FNL_ERROR_MEMORY;
    struct gpu_frame *frame = &device->frames[gpu_frame_slot(device)];
    fnl_result result = FNL_OK;
    pthread_mutex_lock(&device->queue_mutex);
    const uint64_t before[GPU_QUEUE_COUNT] = {device->queues[0].value, device->queues[1].value};
    for (uint32_t i = 0; i < batch_count && result == FNL_OK; i++) {
        result = submit_batch(device, &batches[i], i == 0, i + 1 == batch_count, before, external);
        device->batch_values.data[i] = device->queues[batches[i].queue].value;
    }
    for (uint32_t i = 0; i < GPU_QUEUE_COUNT; i++) frame->values[i] = device->queues[i].value;
    pthread_mutex_unlock(&device->queue_mutex);
    return result;
}

fnl_result gpu_frame_end(gpu_device *device, const struct gpu_batch *batches, uint32_t batch_count,
                         const struct gpu_external_semaphores *external) {
    REQUIRE(&device->host, device->in_frame);
    device->in_frame = false;
    fnl_result result = gpu_status(device);
    if (result == FNL_OK) {
        /* An empty frame still passes the caller's semaphores on. */
        const struct gpu_batch empty = {.queue = GPU_QUEUE_GRAPHICS, .wait_batch = GPU_NO_INDEX};
        bool none = batch_count == 0;
        result = submit_batches(device, none ? &empty : batches, none ? 1 : batch_count, external);
        if (result == FNL_OK) device->frames[gpu_frame_slot(device)].timestamps_pending = device->timestamp_mask != 0;
    }
    /* Reported: the next frame has a fresh start, unless there is no device any more. */
    if (gpu_status(device) != FNL_ERROR_DEVICE_LOST) atomic_store(&device->status, FNL_OK);
    return result;
}

fnl_result gpu_frame_wait(gpu_device *device, uint64_t frame_number) {
    REQUIRE(&device->host, frame_number <= device->frame_number);
    REQUIRE(&device->host, !device->in_frame || frame_number < device->frame_number);
    /* A slot is taken again only when its frame is over. */
    if (frame_number == 0 || frame_number + GPU_FRAMES_IN_FLIGHT <= device->frame_number) return FNL_OK;
    return wait_for_frame(device, &device->frames[(frame_number - 1) % GPU_FRAMES_IN_FLIGHT]);
}
