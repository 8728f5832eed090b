/* SPDX-License-Identifier: MIT */
#include "gpu/gpu_internal.h"

static VkBufferCreateInfo buffer_info(const gpu_device *device, uint64_t size, uint32_t families[GPU_QUEUE_COUNT]) {
    VkBufferCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO,
        .size = MAX(size, 16u),
        .usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_INDEX_BUFFER_BIT |
                 VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT |
                 VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT,
        .pQueueFamilyIndices = families,
    };
    if (device->info.ray_query) info.usage |= VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR;
    gpu_sharing(device, &info.sharingMode, &info.queueFamilyIndexCount, families);
    return info;
}

static VkMemoryRequirements buffer_requirements(gpu_device *device, const VkBufferCreateInfo *info) {
    VkDeviceBufferMemoryRequirements query = {
        .sType = VK_STRUCTURE_TYPE_DEVICE_BUFFER_MEMORY_REQUIREMENTS,
        .pCreateInfo = info,
    };
    VkMemoryRequirements2 requirements = {.sType = VK_STRUCTURE_TYPE_MEMORY_REQUIREMENTS_2};
    device->vk.GetDeviceBufferMemoryRequirements(device->handle, &query, &requirements);
    return requirements.memoryRequirements;
}

struct gpu_requirements gpu_buffer_requirements(gpu_device *device, uint64_t size) {
    uint32_t families[GPU_QUEUE_COUNT];
    VkBufferCreateInfo info = buffer_info(device, size, families);
    VkMemoryRequirements requirements = buffer_requirements(device, &info);
    /* Padded, so that buffers and images may be neighbours in a heap. */
    uint64_t granularity = device->memory.granularity;
    return (struct gpu_requirements){align_up(requirements.size, granularity), MAX(requirements.alignment, granularity),
                                     requirements.memoryTypeBits};
}

static struct gpu_retired retired_buffer(const struct gpu_buffer *buffer) {
    return (struct gpu_retired){.buffer = buffer->handle,
                                .allocation = buffer->allocation,
                                .sampled_index = GPU_NO_INDEX,
                                .storage_index = GPU_NO_INDEX,
                                .srgb_index = GPU_NO_INDEX};
}

static fnl_result make_buffer(gpu_device *device, const char *name, const VkBufferCreateInfo *info, struct gpu_buffer *out) {
    if (info->size > device->max_buffer_size) {
        log_error(&device->host, "'%s': a buffer of %llu bytes is more than the device can have (%llu)", name,
                  (unsigned long long)info->size, (unsigned long long)device->max_buffer_size);
        return FNL_ERROR_MEMORY;
    }
    TRY(gpu_check(device, device->vk.CreateBuffer(device->handle, info, NULL, &out->handle), "'%s': vkCreateBuffer", name));
    gpu_name(device, VK_OBJECT_TYPE_BUFFER, (uint64_t)out->handle, name);
    return FNL_OK;
}

static fnl_result bind_buffer(gpu_device *device, const char *name, VkDeviceMemory memory, uint64_t offset, uint64_t size,
                              struct gpu_buffer *out) {
    TRY(gpu_check(device, device->vk.BindBufferMemory(device->handle, out->handle, memory, offset),
                  "'%s': vkBindBufferMemory", name));
    VkBufferDeviceAddressInfo info = {.sType = VK_STRUCTURE_TYPE_BUFFER_DEVICE_ADDRESS_INFO, .buffer = out->handle};
    out->address = device->vk.GetBufferDeviceAddress(device->handle, &info);
    out->size = size;
    return FNL_OK;
}

static fnl_result finish_buffer(gpu_device *device, fnl_result result, struct gpu_buffer *out) {
    if (result == FNL_OK) return FNL_OK;
    struct gpu_retired item = retired_buffer(out);
    gpu_retired_free(device, &item);
    gpu_retire_cancel(device);
    *out = (struct gpu_buffer){0};
    return result;
}

static fnl_result create_buffer(gpu_device *device, enum gpu_use use, const char *name, uint64_t size, enum gpu_memory_kind kind,
                                VkBufferUsageFlags more, struct gpu_buffer *out) {
    *out = (struct gpu_buffer){0};
    if (!gpu_retire_reserve(device)) return FNL_ERROR_MEMORY;
    uint32_t families[GPU_QUEUE_COUNT];
    VkBufferCreateInfo info = buffer_info(device, size, families);
    info.usage |= more;
    VkDeviceMemory memory = VK_NULL_HANDLE;
    void *mapped = NULL;
    fnl_result result = make_buffer(device, name, &info, out);
    if (result == FNL_OK) {
        VkMemoryRequirements requirements = buffer_requirements(device, &info);
        result = gpu_memory_allocate(device, name, &requirements, kind, use, false, &out->allocation, &memory, &mapped);
    }
    if (result == FNL_OK) result = bind_buffer(device, name, memory, out->allocation.offset, info.size, out);
    if (kind != GPU_MEMORY_DEVICE) out->mapped = mapped;
    return finish_buffer(device, result, out);
}

fnl_result gpu_buffer_create(gpu_device *device, const char *name, uint64_t size, enum gpu_memory_kind kind,
                             struct gpu_buffer *out) {
    return create_buffer(device, kind == GPU_MEMORY_DEVICE ? GPU_USE_OTHER : GPU_USE_TRANSFER, name, size, kind, 0, out);
}

fnl_result gpu_buffer_create_for(gpu_device *device, enum gpu_use use, const char *name, uint64_t size, enum gpu_memory_kind kind, struct gpu_buffer *out) {
    return create_buffer(device, use, name, size, kind, 0, out);
}

fnl_result gpu_structure_buffer_create(gpu_device *device, const char *name, uint64_t size, struct gpu_buffer *out) {
    TRY(create_buffer(device, GPU_USE_GEOMETRY, name, size, GPU_MEMORY_DEVICE, VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR, out));
    gpu_memory_count_structure(device, out->allocation.size, true);
    return FNL_OK;
}

fnl_result gpu_buffer_create_in(gpu_device *device, const struct gpu_heap *heap, uint64_t offset, const char *name,
                                uint64_t size, struct gpu_buffer *out) {
    *out = (struct gpu_buffer){0};
    if (!gpu_retire_reserve(device)) return FNL_ERROR_MEMORY;
    uint32_t families[GPU_QUEUE_COUNT];
    VkBufferCreateInfo info = buffer_info(device, size, families);
    fnl_result result = make_buffer(device, name, &info, out);
    if (result == FNL_OK) result = bind_buffer(device, name, heap->memory, offset, info.size, out);
    return finish_buffer(device, result, out);
}

void gpu_buffer_destroy(gpu_device *device, struct gpu_buffer *buffer) {
    if (buffer->handle) {
        struct gpu_retired item = retired_buffer(buffer);
        gpu_last_use_remove(&device->last_uses, false, (uint64_t)buffer->handle);
        gpu_retire(device, &item);
    }
    *buffer = (struct gpu_buffer){0};
}
