/* SPDX-License-Identifier: MIT */
/* Device memory in blocks, one list of free ranges each. Not on any frame's hot path: plain first fit. */
#include "gpu/gpu_internal.h"

#include <sys/mman.h>

enum { BLOCK_BYTES = 64 << 20 };

static VkDeviceSize block_size(const struct gpu_memory *memory, uint32_t type) {
    const VkMemoryHeap *heap = &memory->properties.memoryHeaps[memory->properties.memoryTypes[type].heapIndex];
    return MIN((VkDeviceSize)BLOCK_BYTES, align_up(heap->size / 8, 4096)); /* small heaps are not eaten up by one block */
}

uint32_t gpu_memory_order_types(const struct gpu_memory *memory, enum gpu_memory_kind kind, uint32_t mask,
                                uint32_t types[VK_MAX_MEMORY_TYPES]) {
    const VkMemoryPropertyFlags mapped = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
    static const struct {
        VkMemoryPropertyFlags required, wanted, unwanted;
    } rules[] = {
        [GPU_MEMORY_DEVICE] = {0, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT, VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT},
        [GPU_MEMORY_UPLOAD] = {mapped, mapped, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT | VK_MEMORY_PROPERTY_HOST_CACHED_BIT},
        [GPU_MEMORY_READBACK] = {mapped, VK_MEMORY_PROPERTY_HOST_CACHED_BIT, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT},
    };
    const VkMemoryPropertyFlags never = VK_MEMORY_PROPERTY_PROTECTED_BIT | VK_MEMORY_PROPERTY_LAZILY_ALLOCATED_BIT |
                                        VK_MEMORY_PROPERTY_DEVICE_COHERENT_BIT_AMD |
                                        VK_MEMORY_PROPERTY_DEVICE_UNCACHED_BIT_AMD;
    int scores[VK_MAX_MEMORY_TYPES];
    uint32_t count = 0;
    for (uint32_t i = 0; i < memory->properties.memoryTypeCount; i++) {
        VkMemoryPropertyFlags flags = memory->properties.memoryTypes[i].propertyFlags;
        if (!(mask >> i & 1) || (flags & rules[kind].required) != rules[kind].required || (flags & never)) continue;
        int score = ((flags & rules[kind].wanted) == rules[kind].wanted ? 4 : 0) - (flags & rules[kind].unwanted ? 1 : 0);
        uint32_t at = count++;
        for (; at > 0 && scores[at - 1] < score; at--) {
            scores[at] = scores[at - 1];
            types[at] = types[at - 1];
        }
        scores[at] = score;
        types[at] = i;
    }
    return count;
}

static VkResult allocate_device_memory(gpu_device *device, const char *name, uint32_t type, VkDeviceSize size,
                                       VkDeviceMemory *out) {
    VkMemoryAllocateFlagsInfo flags = {
        .sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_FLAGS_INFO,
        .flags = VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT,
    };
    VkMemoryAllocateInfo info = {
        .sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO,
        .pNext = &flags,
        .allocationSize = size,
        .memoryTypeIndex = type,
    };
    const struct gpu_memory *memory = &device->memory;
    if (size > memory->properties.memoryHeaps[memory->properties.memoryTypes[type].heapIndex].size)
        return VK_ERROR_OUT_OF_DEVICE_MEMORY;
    VkResult result = device->vk.AllocateMemory(device->handle, &info, NULL, out);
    if (result != VK_SUCCESS) {
        *out = VK_NULL_HANDLE;
        return result;
    }
    device->memory.stats.reserved_bytes += size;
    gpu_name(device, VK_OBJECT_TYPE_DEVICE_MEMORY, (uint64_t)*out, name);
    return VK_SUCCESS;
}

const char *gpu_use_name(enum gpu_use use) {
    static const char *const names[GPU_USE_COUNT] = {"other", "geometry", "textures", "lights", "shadows", "frame", "history", "transfer"};
    return names[use];
}

static void count_used(struct gpu_memory *memory, enum gpu_use use, uint64_t size) {
    memory->stats.used_bytes += size;
    memory->stats.use_bytes[use] += size;
    memory->stats.peak_used_bytes = MAX(memory->stats.peak_used_bytes, memory->stats.used_bytes);
}

/* ---- ranges of one block ---- */

static bool take_range(struct gpu_block *block, uint64_t size, uint64_t alignment, uint64_t *offset) {
    for (uint32_t i = 0; i < block->free.count; i++) {
        struct gpu_range *range = &block->free.data[i];
        uint64_t start = align_up(range->offset, alignment), end = range->offset + range->size;
        if (start > end || end - start < size) continue;
        uint64_t before = start - range->offset, after = end - start - size;
        if (before && after) { /* one more range; there is room for allocation_count + 1 */
            memmove(range + 1, range, (block->free.count - i) * sizeof *range);
            block->free.count++;
            range[0].size = before;
            range[1] = (struct gpu_range){start + size, after};
        } else if (before) {
            range->size = before;
        } else if (after) {
            *range = (struct gpu_range){start + size, after};
        } else {
            block->free.count--;
            memmove(range, range + 1, (block->free.count - i) * sizeof *range);
        }
        *offset = start;
        return true;
    }
    return false;
}

static void give_range(struct gpu_block *block, uint64_t offset, uint64_t size) {
    uint32_t i = 0;
    while (i < block->free.count && block->free.data[i].offset < offset) i++;
    struct gpu_range *range = block->free.data + i;
    bool joins_before = i > 0 && range[-1].offset + range[-1].size == offset;
    bool joins_after = i < block->free.count && offset + size == range->offset;
    if (joins_before && joins_after) {
        range[-1].size += size + range->size;
        block->free.count--;
        memmove(range, range + 1, (block->free.count - i) * sizeof *range);
    } else if (joins_before) {
        range[-1].size += size;
    } else if (joins_after) {
        *range = (struct gpu_range){offset, size + range->size};
    } else {
        memmove(range + 1, range, (block->free.count - i) * sizeof *range);
        *range = (struct gpu_range){offset, size};
        block->free.count++;
    }
}

/* ---- blocks ---- */

static void free_block(gpu_device *device, struct gpu_block *block) {
    device->vk.FreeMemory(device->handle, block->memory, NULL);
    device->memory.stats.reserved_bytes -= block->size;
    array_free(&device->host, &block->free);
    *block = (struct gpu_block){0};
}

static VkResult add_block(gpu_device *device, uint32_t type, bool optimal, bool dedicated, const char *name,
                          VkDeviceSize size, uint32_t *out) {
    struct gpu_memory *memory = &device->memory;
    uint32_t index = 0;
    while (index < memory->blocks.count && memory->blocks.data[index].memory) index++;
    if (index == memory->blocks.count && !array_push(&device->host, &memory->blocks, (struct gpu_block){0}))
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    struct gpu_block block = {.size = size, .type = type, .optimal = optimal, .dedicated = dedicated};
    if (!array_push(&device->host, &block.free, ((struct gpu_range){0, size}))) return VK_ERROR_OUT_OF_HOST_MEMORY;
    VkResult result = allocate_device_memory(device, dedicated ? name : "memory block", type, size, &block.memory);
    if (result != VK_SUCCESS) {
        array_free(&device->host, &block.free);
        return result;
    }
    if (memory->properties.memoryTypes[type].propertyFlags & VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT) {
        result = device->vk.MapMemory(device->handle, block.memory, 0, VK_WHOLE_SIZE, 0, &block.mapped);
        /* Mesa's CPU driver hands on what mmap() returned, be it a failure, and calls that a success. */
        if (result == VK_SUCCESS && block.mapped == MAP_FAILED) result = VK_ERROR_MEMORY_MAP_FAILED;
        if (result != VK_SUCCESS) {
            free_block(device, &block);
            return result;
        }
    }
    memory->blocks.data[index] = block;
    *out = index;
    return VK_SUCCESS;
}

static bool take_from_block(gpu_device *device, uint32_t index, const VkMemoryRequirements *requirements,
                            struct gpu_allocation *out) {
    struct gpu_block *block = &device->memory.blocks.data[index];
    if (!array_reserve(&device->host, &block->free, (uint64_t)block->allocation_count + 2)) return false;
    uint64_t offset;
    if (!take_range(block, requirements->size, requirements->alignment, &offset)) return false;
    block->allocation_count++;
    *out = (struct gpu_allocation){.block = index, .type = block->type, .offset = offset, .size = requirements->size};
    return true;
}

static VkResult allocate_from_type(gpu_device *device, const char *name, const VkMemoryRequirements *requirements,
                                   uint32_t type, bool optimal, struct gpu_allocation *out) {
    struct gpu_memory *memory = &device->memory;
    VkDeviceSize common = block_size(memory, type);
    bool dedicated = requirements->size > common / 2;
    for (uint32_t i = 0; i < memory->blocks.count && !dedicated; i++) {
        const struct gpu_block *block = &memory->blocks.data[i];
        if (block->memory && block->type == type && block->optimal == optimal && !block->dedicated &&
            take_from_block(device, i, requirements, out))
            return VK_SUCCESS;
    }
    uint32_t index;
    VkResult result =
        dedicated ? VK_ERROR_OUT_OF_DEVICE_MEMORY : add_block(device, type, optimal, false, name, common, &index);
    /* When a whole block is too much, the piece itself may still fit. */
    if (result != VK_SUCCESS) result = add_block(device, type, optimal, true, name, requirements->size, &index);
    if (result != VK_SUCCESS) return result;
    if (take_from_block(device, index, requirements, out)) return VK_SUCCESS;
    free_block(device, &memory->blocks.data[index]);
    return VK_ERROR_OUT_OF_HOST_MEMORY;
}

fnl_result gpu_memory_allocate(gpu_device *device, const char *name, const VkMemoryRequirements *requirements,
                               enum gpu_memory_kind kind, enum gpu_use use, bool optimal, struct gpu_allocation *out,
                               VkDeviceMemory *out_memory, void **mapped) {
    struct gpu_memory *memory = &device->memory;
    uint32_t types[VK_MAX_MEMORY_TYPES];
    uint32_t type_count = gpu_memory_order_types(memory, kind, requirements->memoryTypeBits, types);
    VkResult result = VK_ERROR_OUT_OF_DEVICE_MEMORY;
    pthread_mutex_lock(&memory->mutex);
    optimal = optimal && memory->granularity > 1; /* else neighbours of both sorts do not disturb one another */
    for (uint32_t i = 0; i < type_count && result != VK_SUCCESS; i++)
        result = allocate_from_type(device, name, requirements, types[i], optimal, out);
    if (result == VK_SUCCESS) {
        out->use = use;
        count_used(memory, use, out->size);
        const struct gpu_block *block = &memory->blocks.data[out->block];
        *out_memory = block->memory;
        if (mapped) *mapped = block->mapped ? (char *)block->mapped + out->offset : NULL;
    }
    uint64_t reserved = memory->stats.reserved_bytes;
    pthread_mutex_unlock(&memory->mutex);
    return gpu_check(device, result, "'%s': %llu bytes of device memory (%llu are in use)", name,
                     (unsigned long long)requirements->size, (unsigned long long)reserved);
}

void gpu_memory_free(gpu_device *device, const struct gpu_allocation *allocation) {
    struct gpu_memory *memory = &device->memory;
    pthread_mutex_lock(&memory->mutex);
    struct gpu_block *block = &memory->blocks.data[allocation->block];
    give_range(block, allocation->offset, allocation->size);
    memory->stats.used_bytes -= allocation->size;
    memory->stats.use_bytes[allocation->use] -= allocation->size;
    if (--block->allocation_count == 0) {
        /* One empty block of a sort is kept, so that a resource made and freed in turn does not cost a block each time. */
        bool spare = false;
        for (uint32_t i = 0; i < memory->blocks.count && !spare; i++) {
            const struct gpu_block *other = &memory->blocks.data[i];
            spare = other != block && other->memory && other->type == block->type && other->optimal == block->optimal &&
                    !other->dedicated && other->allocation_count == 0;
        }
        if (spare || block->dedicated) free_block(device, block);
    }
    pthread_mutex_unlock(&memory->mutex);
}

void gpu_memory_count_structure(gpu_device *device, uint64_t size, bool made) {
    pthread_mutex_lock(&device->memory.mutex);
    device->memory.stats.structure_bytes += made ? size : 0 - size;
    pthread_mutex_unlock(&device->memory.mutex);
}

void gpu_memory_finish(gpu_device *device) {
    struct gpu_memory *memory = &device->memory;
    for (uint32_t i = 0; i < memory->blocks.count; i++) {
        if (memory->blocks.data[i].memory) free_block(device, &memory->blocks.data[i]);
    }
    array_free(&device->host, &memory->blocks);
}

struct gpu_memory_stats gpu_memory_stats(const gpu_device *device) {
    pthread_mutex_t *mutex = (pthread_mutex_t *)(uintptr_t)&device->memory.mutex; /* reading is const to the caller */
    pthread_mutex_lock(mutex);
    struct gpu_memory_stats stats = device->memory.stats;
    pthread_mutex_unlock(mutex);
    return stats;
}

/* ---- heaps ---- */

bool gpu_memory_lazy_type(const struct gpu_memory *memory, uint32_t mask, uint32_t *type) {
    for (uint32_t i = 0; i < memory->properties.memoryTypeCount; i++) {
        if (!(mask >> i & 1)) continue;
        if (!(memory->properties.memoryTypes[i].propertyFlags & VK_MEMORY_PROPERTY_LAZILY_ALLOCATED_BIT)) continue;
        *type = i;
        return true;
    }
    return false;
}

uint64_t gpu_heap_committed(gpu_device *device, const struct gpu_heap *heap) {
    VkDeviceSize bytes = heap->size;
    if (heap->lazy) device->vk.GetDeviceMemoryCommitment(device->handle, heap->memory, &bytes);
    return bytes;
}

fnl_result gpu_heap_create(gpu_device *device, const char *name, uint64_t size, uint32_t memory_types,
                           struct gpu_heap *out) {
    *out = (struct gpu_heap){0};
    if (!gpu_retire_reserve(device)) return FNL_ERROR_MEMORY;
    struct gpu_memory *memory = &device->memory;
    uint32_t types[VK_MAX_MEMORY_TYPES];
    uint32_t type_count = gpu_memory_lazy_type(memory, memory_types, types) ? 1 : 0;
    out->lazy = type_count > 0;
    if (!out->lazy) type_count = gpu_memory_order_types(memory, GPU_MEMORY_DEVICE, memory_types, types);
    VkResult result = VK_ERROR_OUT_OF_DEVICE_MEMORY;
    size = MAX(size, 1u);
    pthread_mutex_lock(&memory->mutex);
    for (uint32_t i = 0; i < type_count && result != VK_SUCCESS; i++)
        result = allocate_device_memory(device, name, types[i], size, &out->memory);
    if (result == VK_SUCCESS) count_used(memory, GPU_USE_FRAME, size);
    pthread_mutex_unlock(&memory->mutex);
    if (result != VK_SUCCESS) {
        gpu_retire_cancel(device);
        return gpu_check(device, result, "'%s': %llu bytes of device memory", name, (unsigned long long)size);
    }
    out->size = size;
    out->memory_types = memory_types;
    return FNL_OK;
}

void gpu_heap_destroy(gpu_device *device, struct gpu_heap *heap) {
    if (heap->memory) {
        gpu_retire(device, &(struct gpu_retired){.memory = heap->memory,
                                                 .heap_size = heap->size,
                                                 .sampled_index = GPU_NO_INDEX,
                                                 .storage_index = GPU_NO_INDEX,
                                                 .srgb_index = GPU_NO_INDEX});
    }
    *heap = (struct gpu_heap){0};
}

void gpu_memory_free_heap(gpu_device *device, VkDeviceMemory memory, uint64_t size) {
    pthread_mutex_lock(&device->memory.mutex);
    device->vk.FreeMemory(device->handle, memory, NULL);
    device->memory.stats.used_bytes -= size;
    device->memory.stats.use_bytes[GPU_USE_FRAME] -= size;
    device->memory.stats.reserved_bytes -= size;
    pthread_mutex_unlock(&device->memory.mutex);
}
