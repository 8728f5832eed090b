/* SPDX-License-Identifier: MIT */
#include "gpu/gpu_internal.h"

enum { FIRST_BYTES = 1 << 20, SLICE_ALIGNMENT = 256 };

static fnl_result allocate(gpu_device *device, struct gpu_slices *slices, uint64_t size, struct gpu_slice *out) {
    struct gpu_buffer *buffer = slices->count ? &slices->buffers[slices->count - 1] : NULL;
    if (!buffer || buffer->size - slices->used < size) {
        REQUIRE(&device->host, slices->count < GPU_SLICE_BUFFERS);
        uint64_t wanted = buffer ? buffer->size * 2 : FIRST_BYTES;
        while (wanted < size) wanted *= 2;
        TRY(gpu_buffer_create(device, "frame slices", wanted, GPU_MEMORY_UPLOAD, &slices->buffers[slices->count]));
        buffer = &slices->buffers[slices->count++];
        slices->used = 0;
    }
    *out = (struct gpu_slice){(char *)buffer->mapped + slices->used, buffer->address + slices->used, buffer, slices->used};
    slices->used += size;
    return FNL_OK;
}

struct gpu_slice gpu_frame_allocate(gpu_device *device, uint64_t size) {
    struct gpu_slice slice = {0};
    fnl_result result = gpu_status(device);
    if (result != FNL_OK) return slice;
    if (!device->in_frame || size > UINT64_MAX / 4) {
        log_error(&device->host, "gpu_frame_allocate: misuse, %llu bytes %s", (unsigned long long)size,
                  device->in_frame ? "are asked for" : "outside of a frame");
        result = FNL_ERROR_INVALID;
    } else {
        pthread_mutex_lock(&device->slice_mutex);
        result = allocate(device, &device->frames[gpu_frame_slot(device)].slices, align_up(MAX(size, 1u), SLICE_ALIGNMENT),
                          &slice);
        pthread_mutex_unlock(&device->slice_mutex);
    }
    gpu_fail(device, result);
    return slice;
}

/* The frame is over. If it needed several buffers, the next one gets the biggest, and a bigger one if that is too small. */
void gpu_slices_reset(gpu_device *device, struct gpu_slices *slices) {
    slices->used = 0;
    if (slices->count < 2) return;
    for (uint32_t i = 0; i + 1 < slices->count; i++) gpu_buffer_destroy(device, &slices->buffers[i]);
    slices->buffers[0] = slices->buffers[slices->count - 1];
    slices->buffers[slices->count - 1] = (struct gpu_buffer){0};
    slices->count = 1;
}

void gpu_slices_finish(gpu_device *device, struct gpu_slices *slices) {
    for (uint32_t i = 0; i < slices->count; i++) gpu_buffer_destroy(device, &slices->buffers[i]);
    slices->count = 0;
}
