/* SPDX-License-Identifier: MIT */
#include "gpu/gpu_internal.h"

static const VkDescriptorType descriptor_types[GPU_BINDING_COUNT] = {
    [GPU_BINDING_SAMPLED] = VK_DESCRIPTOR_TYPE_SAMPLED_IMAGE,
    [GPU_BINDING_SAMPLER] = VK_DESCRIPTOR_TYPE_SAMPLER,
    [GPU_BINDING_STORAGE] = VK_DESCRIPTOR_TYPE_STORAGE_IMAGE,
};
static const char *const binding_names[GPU_BINDING_COUNT] = {"sampled images", "samplers", "storage images"};

/**
 * Synchronisation validation before 1.3.270 visits every descriptor of the set at every draw and dispatch, written or not, which takes longer
 * than all else in small frames: so the arrays get a part of their size.
 */
static uint32_t share_of_arrays(const gpu_device *device) {
    const uint32_t version = device->instance.layer_version;
    return version != 0 && version < VK_MAKE_API_VERSION(0, 1, 3, 270) ? 16 : 1;
}

/** Sizes of the three arrays: what we want, or what the device has, less room for attachments. */
static void size_arrays(gpu_device *device) {
    VkPhysicalDeviceVulkan12Properties limits = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_PROPERTIES};
    VkPhysicalDeviceProperties2 properties = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, .pNext = &limits};
    device->instance.vk.GetPhysicalDeviceProperties2(device->physical, &properties);
    uint32_t sampled =
        MIN(limits.maxDescriptorSetUpdateAfterBindSampledImages, limits.maxPerStageDescriptorUpdateAfterBindSampledImages);
    uint32_t storage =
        MIN(limits.maxDescriptorSetUpdateAfterBindStorageImages, limits.maxPerStageDescriptorUpdateAfterBindStorageImages);
    uint32_t samplers =
        MIN(limits.maxDescriptorSetUpdateAfterBindSamplers, limits.maxPerStageDescriptorUpdateAfterBindSamplers);
    samplers = MIN(MIN(samplers, GPU_SAMPLER_MAX), device->properties.limits.maxSamplerAllocationCount);
    sampled = MIN(sampled, GPU_SAMPLED_MAX / share_of_arrays(device));
    storage = MIN(storage, GPU_STORAGE_MAX / share_of_arrays(device));
    uint32_t all = limits.maxPerStageUpdateAfterBindResources -
                   MIN(limits.maxPerStageUpdateAfterBindResources, GPU_MAX_COLORS + GPU_MAX_INPUTS + samplers);
    if (sampled + storage > all) {
        storage = MIN(storage, all / 4);
        sampled = MIN(sampled, all - storage);
    }
    device->bindless.pools[GPU_BINDING_SAMPLED].capacity = sampled;
    device->bindless.pools[GPU_BINDING_SAMPLER].capacity = samplers;
    device->bindless.pools[GPU_BINDING_STORAGE].capacity = storage;
}

static fnl_result create_set(gpu_device *device) {
    struct gpu_bindless *bindless = &device->bindless;
    VkDescriptorSetLayoutBinding bindings[GPU_BINDING_COUNT];
    VkDescriptorBindingFlags flags[GPU_BINDING_COUNT];
    VkDescriptorPoolSize sizes[GPU_BINDING_COUNT];
    for (uint32_t i = 0; i < GPU_BINDING_COUNT; i++) {
        uint32_t count = bindless->pools[i].capacity;
        bindings[i] = (VkDescriptorSetLayoutBinding){i, descriptor_types[i], count, VK_SHADER_STAGE_ALL, NULL};
        flags[i] = VK_DESCRIPTOR_BINDING_PARTIALLY_BOUND_BIT | VK_DESCRIPTOR_BINDING_UPDATE_AFTER_BIND_BIT |
                   VK_DESCRIPTOR_BINDING_UPDATE_UNUSED_WHILE_PENDING_BIT;
        sizes[i] = (VkDescriptorPoolSize){descriptor_types[i], count};
    }
    VkDescriptorSetLayoutBindingFlagsCreateInfo binding_flags = {
        .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_BINDING_FLAGS_CREATE_INFO,
        .bindingCount = GPU_BINDING_COUNT,
        .pBindingFlags = flags,
    };
    VkDescriptorSetLayoutCreateInfo set_layout = {
        .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO,
        .pNext = &binding_flags,
        .flags = VK_DESCRIPTOR_SET_LAYOUT_CREATE_UPDATE_AFTER_BIND_POOL_BIT,
        .bindingCount = GPU_BINDING_COUNT,
        .pBindings = bindings,
    };
    TRY(gpu_check(device, device->vk.CreateDescriptorSetLayout(device->handle, &set_layout, NULL, &bindless->set_layout),
                  "vkCreateDescriptorSetLayout"));
    VkDescriptorPoolCreateInfo pool = {
        .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO,
        .flags = VK_DESCRIPTOR_POOL_CREATE_UPDATE_AFTER_BIND_BIT,
        .maxSets = 1,
        .poolSizeCount = GPU_BINDING_COUNT,
        .pPoolSizes = sizes,
    };
    TRY(gpu_check(device, device->vk.CreateDescriptorPool(device->handle, &pool, NULL, &bindless->pool),
                  "vkCreateDescriptorPool"));
    VkDescriptorSetAllocateInfo set = {
        .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO,
        .descriptorPool = bindless->pool,
        .descriptorSetCount = 1,
        .pSetLayouts = &bindless->set_layout,
    };
    TRY(gpu_check(device, device->vk.AllocateDescriptorSets(device->handle, &set, &bindless->set),
                  "vkAllocateDescriptorSets"));
    gpu_name(device, VK_OBJECT_TYPE_DESCRIPTOR_SET, (uint64_t)bindless->set, "bindless");
    return FNL_OK;
}

fnl_result gpu_bindless_init(gpu_device *device) {
    size_arrays(device);
    TRY(create_set(device));
    VkPushConstantRange push = {VK_SHADER_STAGE_ALL, 0, GPU_PUSH_BYTES};
    VkPipelineLayoutCreateInfo layout = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
        .setLayoutCount = 1,
        .pSetLayouts = &device->bindless.set_layout,
        .pushConstantRangeCount = 1,
        .pPushConstantRanges = &push,
    };
    return gpu_check(device, device->vk.CreatePipelineLayout(device->handle, &layout, NULL, &device->bindless.layout),
                     "vkCreatePipelineLayout");
}

void gpu_bindless_finish(gpu_device *device) {
    struct gpu_bindless *bindless = &device->bindless;
    for (uint32_t i = 0; i < GPU_SAMPLER_MAX; i++)
        device->vk.DestroySampler(device->handle, bindless->sampler_handles[i], NULL);
    device->vk.DestroyPipelineLayout(device->handle, bindless->layout, NULL);
    device->vk.DestroyDescriptorPool(device->handle, bindless->pool, NULL);
    device->vk.DestroyDescriptorSetLayout(device->handle, bindless->set_layout, NULL);
    for (uint32_t i = 0; i < GPU_BINDING_COUNT; i++) array_free(&device->host, &bindless->pools[i].free);
}

static fnl_result take_index(gpu_device *device, enum gpu_binding binding, uint32_t *out) {
    struct gpu_index_pool *pool = &device->bindless.pools[binding];
    if (pool->free.count) {
        *out = pool->free.data[--pool->free.count];
        return FNL_OK;
    }
    if (pool->next == pool->capacity) {
        log_error(&device->host, "more than %u %s at once: the bindless set is full", pool->capacity,
                  binding_names[binding]);
        return FNL_ERROR_MEMORY;
    }
    if (!array_reserve(&device->host, &pool->free, (uint64_t)pool->next + 1)) return FNL_ERROR_MEMORY;
    *out = pool->next++;
    return FNL_OK;
}

static void write_descriptor(gpu_device *device, enum gpu_binding binding, uint32_t index,
                             const VkDescriptorImageInfo *image) {
    VkWriteDescriptorSet write = {
        .sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
        .dstSet = device->bindless.set,
        .dstBinding = binding,
        .dstArrayElement = index,
        .descriptorCount = 1,
        .descriptorType = descriptor_types[binding],
        .pImageInfo = image,
    };
    device->vk.UpdateDescriptorSets(device->handle, 1, &write, 0, NULL);
}

fnl_result gpu_bindless_add(gpu_device *device, enum gpu_binding binding, VkImageView view, VkImageLayout layout,
                            uint32_t *out) {
    *out = GPU_NO_INDEX;
    pthread_mutex_lock(&device->bindless.mutex);
    fnl_result result = take_index(device, binding, out);
    if (result == FNL_OK)
        write_descriptor(device, binding, *out, &(VkDescriptorImageInfo){.imageView = view, .imageLayout = layout});
    pthread_mutex_unlock(&device->bindless.mutex);
    return result;
}

void gpu_bindless_remove(gpu_device *device, enum gpu_binding binding, uint32_t index) {
    if (index == GPU_NO_INDEX) return;
    struct gpu_index_pool *pool = &device->bindless.pools[binding];
    pthread_mutex_lock(&device->bindless.mutex);
    pool->free.data[pool->free.count++] = index;
    pthread_mutex_unlock(&device->bindless.mutex);
}

/* ---- samplers ---- */

static bool same_sampler(const struct gpu_sampler_params *a, const struct gpu_sampler_params *b) {
    return a->mag == b->mag && a->min == b->min && a->mip == b->mip && a->mipmapped == b->mipmapped &&
           a->wrap_u == b->wrap_u && a->wrap_v == b->wrap_v && a->anisotropy == b->anisotropy &&
           a->bias == b->bias && a->reduction == b->reduction;
}

static fnl_result create_sampler(gpu_device *device, const struct gpu_sampler_params *params, VkSampler *out) {
    VkSamplerReductionModeCreateInfo reduction = {.sType = VK_STRUCTURE_TYPE_SAMPLER_REDUCTION_MODE_CREATE_INFO,
                                                  .reductionMode = params->reduction};
    VkSamplerCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO,
        .pNext = params->reduction == VK_SAMPLER_REDUCTION_MODE_WEIGHTED_AVERAGE ? NULL : &reduction,
        .magFilter = params->mag,
        .minFilter = params->min,
        .mipmapMode = params->mip,
        .addressModeU = params->wrap_u,
        .addressModeV = params->wrap_v,
        .addressModeW = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE,
        .mipLodBias = params->bias,
        .anisotropyEnable = params->anisotropy > 1,
        .maxAnisotropy = params->anisotropy,
        /* Without mips, a quarter still tells minifying from magnifying (Vulkan specification, VkSamplerCreateInfo). */
        .maxLod = params->mipmapped ? VK_LOD_CLAMP_NONE : 0.25f,
        .borderColor = VK_BORDER_COLOR_FLOAT_OPAQUE_BLACK,
    };
    return gpu_check(device, device->vk.CreateSampler(device->handle, &info, NULL, out), "vkCreateSampler");
}

bool gpu_minmax_supported(const gpu_device *device, VkFormat format) {
    return device->info.minmax_samplers &&
           gpu_format_supports(device, format,
                               VK_FORMAT_FEATURE_2_SAMPLED_IMAGE_BIT | VK_FORMAT_FEATURE_2_SAMPLED_IMAGE_FILTER_MINMAX_BIT);
}

uint32_t gpu_sampler_index(gpu_device *device, const struct gpu_sampler_params *params) {
    struct gpu_bindless *bindless = &device->bindless;
    struct gpu_sampler_params wanted = *params;
    float limit = device->properties.limits.maxSamplerAnisotropy;
    wanted.anisotropy = wanted.anisotropy > 1 ? MIN(wanted.anisotropy, limit) : 1; /* NaN gives 1 */
    wanted.bias = CLAMP(wanted.bias, -device->properties.limits.maxSamplerLodBias, device->properties.limits.maxSamplerLodBias);
    pthread_mutex_lock(&bindless->mutex);
    uint32_t count = bindless->pools[GPU_BINDING_SAMPLER].next, index = 0;
    while (index < count && !same_sampler(&bindless->samplers[index], &wanted)) index++;
    fnl_result result = FNL_OK;
    if (index == count) {
        VkSampler sampler = VK_NULL_HANDLE;
        result = create_sampler(device, &wanted, &sampler);
        if (result == FNL_OK) result = take_index(device, GPU_BINDING_SAMPLER, &index);
        if (result == FNL_OK && index < COUNT_OF(bindless->samplers)) { /* as take_index says; gcc 14 wants to see it */
            memcpy(&bindless->samplers[index], &wanted, sizeof wanted); /* gcc 14 warns of an assignment */
            bindless->sampler_handles[index] = sampler;
            write_descriptor(device, GPU_BINDING_SAMPLER, index, &(VkDescriptorImageInfo){.sampler = sampler});
        } else {
            device->vk.DestroySampler(device->handle, sampler, NULL);
            index = 0;
        }
    }
    pthread_mutex_unlock(&bindless->mutex);
    gpu_fail(device, result);
    return index;
}
