/* SPDX-License-Identifier: MIT */
#include "gpu/gpu_internal.h"

bool gpu_retire_reserve(gpu_device *device) {
    pthread_mutex_lock(&device->retire_mutex);
    bool reserved = true;
    for (uint32_t i = 0; i < GPU_FRAMES_IN_FLIGHT && reserved; i++)
        reserved = array_reserve(&device->host, &device->frames[i].retired.items, (uint64_t)device->object_count + 1);
    if (reserved) device->object_count++;
    pthread_mutex_unlock(&device->retire_mutex);
    return reserved;
}

void gpu_retire_cancel(gpu_device *device) {
    pthread_mutex_lock(&device->retire_mutex);
    device->object_count--;
    pthread_mutex_unlock(&device->retire_mutex);
}

/* The list of the latest frame: it is released when its slot comes up again, and by then that frame is over. */
void gpu_retire(gpu_device *device, const struct gpu_retired *item) {
    pthread_mutex_lock(&device->retire_mutex);
    struct gpu_retire_list *list = &device->frames[gpu_frame_slot(device)].retired;
    list->items.data[list->items.count++] = *item;
    list->upload_value = atomic_load(&device->uploads.recorded);
    pthread_mutex_unlock(&device->retire_mutex);
}

void gpu_retire_release(gpu_device *device, uint32_t slot) {
    struct gpu_retire_list *list = &device->frames[slot].retired;
    pthread_mutex_lock(&device->retire_mutex);
    for (uint64_t waited = 0; list->items.count && list->upload_value > waited;) {
        waited = list->upload_value;
        pthread_mutex_unlock(&device->retire_mutex); /* an upload under way may need this lock */
        gpu_uploads_wait(device, waited);
        pthread_mutex_lock(&device->retire_mutex);
    }
    for (uint32_t i = 0; i < list->items.count; i++) gpu_retired_free(device, &list->items.data[i]);
    device->object_count -= list->items.count;
    list->items.count = 0;
    pthread_mutex_unlock(&device->retire_mutex);
}

void gpu_retired_free(gpu_device *device, const struct gpu_retired *item) {
    const struct gpu_device_functions *vk = &device->vk;
    gpu_bindless_remove(device, GPU_BINDING_SAMPLED, item->sampled_index);
    gpu_bindless_remove(device, GPU_BINDING_SAMPLED, item->srgb_index);
    gpu_bindless_remove(device, GPU_BINDING_STORAGE, item->storage_index);
    for (uint32_t i = 0; i < COUNT_OF(item->views); i++) vk->DestroyImageView(device->handle, item->views[i], NULL);
    vk->DestroyFramebuffer(device->handle, item->framebuffer, NULL);
    vk->DestroyImage(device->handle, item->image, NULL);
    if (item->structure) {
        vk->DestroyAccelerationStructureKHR(device->handle, item->structure, NULL);
        gpu_memory_count_structure(device, item->allocation.size, false);
    }
    vk->DestroyQueryPool(device->handle, item->queries, NULL);
    vk->DestroyBuffer(device->handle, item->buffer, NULL);
    if (item->allocation.size) gpu_memory_free(device, &item->allocation);
    if (item->memory) gpu_memory_free_heap(device, item->memory, item->heap_size);
}
