/* SPDX-License-Identifier: MIT */
#include "base/check.h"
#include "gpu/gpu_internal.h"

#include <strings.h>

/* What Fanal needs besides Vulkan 1.3 itself: X(member of struct gpu_features, feature). */
#define REQUIRED_FEATURES(X)                                                                                                \
    X(features.features, multiDrawIndirect)                                                                                 \
    X(features.features, drawIndirectFirstInstance)                                                                         \
    X(features.features, fullDrawIndexUint32)                                                                               \
    X(features.features, samplerAnisotropy)                                                                                 \
    X(features.features, depthClamp)                                                                                        \
    X(features.features, independentBlend)                                                                                  \
    X(features.features, fragmentStoresAndAtomics)                                                                          \
    X(features.features, shaderStorageImageReadWithoutFormat)                                                               \
    X(features.features, shaderStorageImageWriteWithoutFormat)                                                              \
    X(features.features, shaderSampledImageArrayDynamicIndexing)                                                            \
    X(features.features, shaderStorageImageArrayDynamicIndexing)                                                            \
    X(features_11, shaderDrawParameters)                                                                                    \
    X(features_12, drawIndirectCount)                                                                                       \
    X(features_12, descriptorIndexing)                                                                                      \
    X(features_12, runtimeDescriptorArray)                                                                                  \
    X(features_12, descriptorBindingPartiallyBound)                                                                         \
    X(features_12, descriptorBindingSampledImageUpdateAfterBind)                                                            \
    X(features_12, descriptorBindingStorageImageUpdateAfterBind)                                                            \
    X(features_12, descriptorBindingUpdateUnusedWhilePending)                                                               \
    X(features_12, shaderSampledImageArrayNonUniformIndexing)                                                               \
    X(features_12, shaderStorageImageArrayNonUniformIndexing)                                                               \
    X(features_12, bufferDeviceAddress)                                                                                     \
    X(features_12, scalarBlockLayout)                                                                                       \
    X(features_12, imagelessFramebuffer)                                                                                    \
    X(features_12, timelineSemaphore)                                                                                       \
    X(features_12, hostQueryReset)                                                                                          \
    X(features_12, separateDepthStencilLayouts)                                                                             \
    X(features_13, dynamicRendering)                                                                                        \
    X(features_13, synchronization2)                                                                                        \
    X(features_13, maintenance4)                                                                                            \
    X(features_13, shaderDemoteToHelperInvocation)                                                                          \
    X(features_13, shaderTerminateInvocation)

void gpu_features_clear(struct gpu_features *features) {
    *features = (struct gpu_features){
        .features.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2,
        .features.pNext = &features->features_11,
        .features_11.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_1_FEATURES,
        .features_11.pNext = &features->features_12,
        .features_12.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES,
        .features_12.pNext = &features->features_13,
        .features_13.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES,
    };
}

void gpu_features_require(struct gpu_features *features) {
    gpu_features_clear(features);
#define SET(member, feature) features->member.feature = VK_TRUE;
    REQUIRED_FEATURES(SET)
#undef SET
}

/* Appends to a comma-separated list, as far as there is room. */
static void append(char *list, size_t capacity, const char *what) {
    size_t length = strlen(list);
    snprintf(list + length, capacity - length, "%s%s", length ? ", " : "", what);
}

static void add_missing(fnl_device_info *info, const char *what) { append(info->missing, sizeof info->missing, what); }

void gpu_features_missing(const struct gpu_features *features, char *list, size_t capacity) {
#define CHECK(member, feature)                                                                                              \
    if (!features->member.feature) append(list, capacity, #feature);
    REQUIRED_FEATURES(CHECK)
#undef CHECK
}

static void query_queues(const struct gpu_instance *instance, struct gpu_physical *out) {
    VkQueueFamilyProperties families[32];
    uint32_t count = COUNT_OF(families);
    instance->vk.GetPhysicalDeviceQueueFamilyProperties(out->handle, &count, families);
    const VkQueueFlags both = VK_QUEUE_GRAPHICS_BIT | VK_QUEUE_COMPUTE_BIT;
    uint32_t graphics = GPU_NO_INDEX, compute = GPU_NO_INDEX;
    for (uint32_t i = 0; i < count && graphics == GPU_NO_INDEX; i++) {
        if ((families[i].queueFlags & both) == both) graphics = i;
    }
    if (graphics == GPU_NO_INDEX) {
        add_missing(&out->info, "a queue with graphics and compute");
        return;
    }
    for (uint32_t i = 0; i < count && compute == GPU_NO_INDEX; i++) {
        if ((families[i].queueFlags & both) == VK_QUEUE_COMPUTE_BIT) compute = i;
    }
    for (uint32_t i = 0; i < count && compute == GPU_NO_INDEX; i++) {
        if (i != graphics && (families[i].queueFlags & VK_QUEUE_COMPUTE_BIT)) compute = i;
    }
    if (compute == GPU_NO_INDEX && families[graphics].queueCount > 1) {
        compute = graphics;
        out->queue_indices[GPU_QUEUE_COMPUTE] = 1;
    }
    out->families[GPU_QUEUE_GRAPHICS] = graphics;
    out->families[GPU_QUEUE_COMPUTE] = compute == GPU_NO_INDEX ? graphics : compute;
    out->info.async_compute = compute != GPU_NO_INDEX;
    out->info.timestamps =
        families[graphics].timestampValidBits > 0 && families[out->families[GPU_QUEUE_COMPUTE]].timestampValidBits > 0;
}

static void query_extensions(const struct gpu_instance *instance, struct gpu_physical *out) {
    struct {
        const char *name;
        bool *flag;
    } known[] = {
        {VK_KHR_RAY_QUERY_EXTENSION_NAME, &out->info.ray_query},
        {VK_KHR_ACCELERATION_STRUCTURE_EXTENSION_NAME, &out->structures},
        {VK_KHR_DEFERRED_HOST_OPERATIONS_EXTENSION_NAME, &out->deferred_operations},
        {VK_EXT_MESH_SHADER_EXTENSION_NAME, &out->info.mesh_shader},
        {VK_EXT_CONSERVATIVE_RASTERIZATION_EXTENSION_NAME, &out->info.conservative_raster},
        {VK_KHR_SWAPCHAIN_EXTENSION_NAME, &out->swapchain},
        {VK_KHR_FRAGMENT_SHADER_BARYCENTRIC_EXTENSION_NAME, &out->info.barycentrics},
        {VK_EXT_SAMPLE_LOCATIONS_EXTENSION_NAME, &out->info.sample_locations},
        {VK_KHR_FRAGMENT_SHADING_RATE_EXTENSION_NAME, &out->info.fragment_shading_rate},
        {VK_EXT_POST_DEPTH_COVERAGE_EXTENSION_NAME, &out->info.post_depth_coverage},
    };
    uint32_t count = 0;
    if (instance->vk.EnumerateDeviceExtensionProperties(out->handle, NULL, &count, NULL) != VK_SUCCESS || count == 0) return;
    uint32_t capacity = count;
    VkExtensionProperties *extensions = host_allocate(&instance->host, capacity * sizeof *extensions);
    if (!extensions) return;
    if (instance->vk.EnumerateDeviceExtensionProperties(out->handle, NULL, &count, extensions) >= 0) {
        for (uint32_t i = 0; i < count; i++) {
            for (uint32_t k = 0; k < COUNT_OF(known); k++) {
                if (strcmp(extensions[i].extensionName, known[k].name) == 0) *known[k].flag = true;
            }
        }
    }
    host_free(&instance->host, extensions, capacity * sizeof *extensions);
}

static fnl_device_type device_type(VkPhysicalDeviceType type) {
    switch (type) {
    case VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU:
        return FNL_DEVICE_DISCRETE;
    case VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU:
        return FNL_DEVICE_INTEGRATED;
    case VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU:
        return FNL_DEVICE_VIRTUAL;
    case VK_PHYSICAL_DEVICE_TYPE_CPU:
        return FNL_DEVICE_CPU;
    default:
        return FNL_DEVICE_OTHER;
    }
}

void gpu_physical_query(const struct gpu_instance *instance, VkPhysicalDevice handle, struct gpu_physical *out) {
    *out = (struct gpu_physical){.handle = handle};
    fnl_device_info *info = &out->info;
    VkPhysicalDeviceProperties properties;
    instance->vk.GetPhysicalDeviceProperties(handle, &properties);
    snprintf(info->name, sizeof info->name, "%s", properties.deviceName);
    info->type = device_type(properties.deviceType);
    info->api_version_major = VK_API_VERSION_MAJOR(properties.apiVersion);
    info->api_version_minor = VK_API_VERSION_MINOR(properties.apiVersion);

    VkPhysicalDeviceMemoryProperties memory;
    instance->vk.GetPhysicalDeviceMemoryProperties(handle, &memory);
    for (uint32_t i = 0; i < memory.memoryHeapCount; i++) {
        if (memory.memoryHeaps[i].flags & VK_MEMORY_HEAP_DEVICE_LOCAL_BIT)
            info->memory_bytes = MAX(info->memory_bytes, memory.memoryHeaps[i].size);
    }
    VkSampleCountFlags counts =
        properties.limits.framebufferColorSampleCounts & properties.limits.framebufferDepthSampleCounts;
    for (info->max_msaa = 64; info->max_msaa > 1 && !(counts & info->max_msaa);) info->max_msaa /= 2;
    info->msaa_counts = counts & 0xfu;
    query_queues(instance, out);
    query_extensions(instance, out);

    if (properties.apiVersion < VK_API_VERSION_1_3) {
        add_missing(info, "Vulkan 1.3");
        return;
    }
    VkPhysicalDeviceDriverProperties driver = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DRIVER_PROPERTIES};
    VkPhysicalDeviceMultiviewProperties views = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MULTIVIEW_PROPERTIES,
                                                 .pNext = &driver};
    VkPhysicalDeviceConservativeRasterizationPropertiesEXT conservative = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_CONSERVATIVE_RASTERIZATION_PROPERTIES_EXT, .pNext = &views};
    VkPhysicalDeviceSubgroupProperties subgroup = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_PROPERTIES,
                                                   .pNext = &views};
    if (info->conservative_raster) subgroup.pNext = &conservative;
    VkPhysicalDeviceProperties2 properties2 = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, .pNext = &subgroup};
    instance->vk.GetPhysicalDeviceProperties2(handle, &properties2);
    snprintf(info->driver, sizeof info->driver, "%.120s%s%.120s", driver.driverName, driver.driverInfo[0] ? " " : "",
             driver.driverInfo);
    info->subgroup_size = subgroup.subgroupSize;
    info->quad_operations = subgroup.supportedOperations & VK_SUBGROUP_FEATURE_QUAD_BIT &&
                            subgroup.supportedStages & VK_SHADER_STAGE_FRAGMENT_BIT;
    out->isotropic_gradients = driver.driverID == VK_DRIVER_ID_MESA_LLVMPIPE;
    /* Where triangles that snapping has made flat vanish, so would small things. */
    info->conservative_raster = info->conservative_raster && conservative.degenerateTrianglesRasterized;

    gpu_features_clear(&out->supported);
    VkPhysicalDeviceMeshShaderFeaturesEXT meshes = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MESH_SHADER_FEATURES_EXT,
                                                    .pNext = out->supported.features.pNext};
    VkPhysicalDeviceRayQueryFeaturesKHR queries = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_RAY_QUERY_FEATURES_KHR};
    VkPhysicalDeviceAccelerationStructureFeaturesKHR structures = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ACCELERATION_STRUCTURE_FEATURES_KHR, .pNext = &queries};
    info->ray_query = info->ray_query && out->structures && out->deferred_operations;
    if (info->mesh_shader) out->supported.features.pNext = &meshes;
    if (info->ray_query) {
        queries.pNext = out->supported.features.pNext;
        out->supported.features.pNext = &structures;
    }
    instance->vk.GetPhysicalDeviceFeatures2(handle, &out->supported.features);
    out->supported.features.pNext = meshes.pNext;
    info->mesh_shader = info->mesh_shader && meshes.meshShader;
    info->ray_query = info->ray_query && queries.rayQuery && structures.accelerationStructure;
    gpu_features_missing(&out->supported, info->missing, sizeof info->missing);
    info->texture_compression = out->supported.features.features.textureCompressionBC;
    info->multiview = out->supported.features_11.multiview;
    info->max_views = info->multiview ? views.maxMultiviewViewCount : 1;
    info->primitive_ids = out->supported.features.features.geometryShader;
    info->vertex_layers = out->supported.features_12.shaderOutputLayer;
    info->vertex_counts = out->supported.features.features.pipelineStatisticsQuery;
    info->clip_distances = out->supported.features.features.shaderClipDistance;
    info->minmax_samplers = out->supported.features_12.samplerFilterMinmax;
    info->usable = !info->missing[0];
}

/** Devices in the loader's order; *out_devices has *out_count entries and comes from the host. */
static fnl_result list_devices(const struct gpu_instance *instance, VkPhysicalDevice **out_devices, uint32_t *out_count) {
    *out_devices = NULL;
    *out_count = 0;
    uint32_t count = 0, capacity;
    VkResult result = instance->vk.EnumeratePhysicalDevices(instance->handle, &count, NULL);
    if (result == VK_ERROR_INITIALIZATION_FAILED || (result == VK_SUCCESS && count == 0)) return FNL_OK; /* no driver */
    if (result == VK_SUCCESS) {
        capacity = count;
        VkPhysicalDevice *devices = host_allocate(&instance->host, capacity * sizeof(VkPhysicalDevice));
        if (!devices) return FNL_ERROR_MEMORY;
        result = instance->vk.EnumeratePhysicalDevices(instance->handle, &count, devices);
        if (result == VK_SUCCESS && count == capacity) {
            *out_devices = devices;
            *out_count = count;
            return FNL_OK;
        }
        host_free(&instance->host, devices, capacity * sizeof(VkPhysicalDevice));
        if (result >= 0) result = VK_ERROR_INITIALIZATION_FAILED; /* the number changed in between */
    }
    log_error(&instance->host, "vkEnumeratePhysicalDevices: %s", gpu_result_text(result));
    return gpu_result_meaning(result);
}

static bool name_matches(const char *name, const char *part) {
    size_t length = strlen(part);
    for (; *name || length == 0; name++) {
        if (strncasecmp(name, part, length) == 0) return true;
    }
    return false;
}

fnl_result gpu_physical_pick(const struct gpu_instance *instance, const fnl_device_params *params,
                             struct gpu_physical *out) {
    const fnl_host *host = &instance->host;
    VkPhysicalDevice *devices, best = VK_NULL_HANDLE;
    uint32_t count;
    TRY(list_devices(instance, &devices, &count));
    fnl_result result = FNL_OK;
    if (count == 0) {
        log_error(host, "no Vulkan device on this machine (Debian: mesa-vulkan-drivers)");
        result = FNL_ERROR_DEVICE;
    } else if (params->index >= 0) {
        if ((uint32_t)params->index < count) {
            gpu_physical_query(instance, devices[params->index], out);
            best = devices[params->index];
            if (!out->info.usable) {
                log_error(host, "device %d (%s) cannot be used, it lacks: %s", params->index, out->info.name,
                          out->info.missing);
                result = FNL_ERROR_DEVICE;
            }
        } else {
            log_error(host, "there is no device %d: this machine has %u", params->index, count);
            result = FNL_ERROR_DEVICE;
        }
    } else {
        fnl_device_type best_type = FNL_DEVICE_OTHER;
        /* The first round is silent; the second gives the reasons if nothing was found. */
        for (int round = 0; round < 2 && !best; round++) {
            for (uint32_t i = 0; i < count; i++) {
                gpu_physical_query(instance, devices[i], out);
                bool named = !params->name || name_matches(out->info.name, params->name);
                if (round == 1) {
                    log_error(host, "device %u (%s) %s%s", i, out->info.name,
                              named ? "cannot be used, it lacks: " : "is not called so", named ? out->info.missing : "");
                } else if (named && out->info.usable && (!best || out->info.type < best_type)) {
                    best = devices[i];
                    best_type = out->info.type;
                }
            }
        }
        if (best) {
            gpu_physical_query(instance, best, out);
        } else {
            log_error(host, "no usable Vulkan device%s%s%s", params->name ? " called '" : "",
                      params->name ? params->name : "", params->name ? "'" : "");
            result = FNL_ERROR_DEVICE;
        }
    }
    host_free(host, devices, count * sizeof(VkPhysicalDevice));
    return result;
}

fnl_result fnl_enumerate_devices(const fnl_host *host, fnl_device_info *out, uint32_t capacity, uint32_t *out_count) {
    fnl_host resolved = host_resolve(host);
    TRY(check_pointer(CALL(&resolved), "out_count", out_count));
    *out_count = 0;
    if (!out && capacity) return misuse(CALL(&resolved), "out is NULL, but capacity is %u", capacity);
    struct gpu_instance instance;
    fnl_result result = gpu_instance_open(&instance, &resolved, &(struct gpu_instance_params){.quiet = true});
    if (result != FNL_OK) {
        bool no_loader = !instance.handle && result == FNL_ERROR_DEVICE;
        gpu_instance_close(&instance);
        return no_loader ? FNL_OK : result;
    }
    VkPhysicalDevice *devices;
    uint32_t count;
    result = list_devices(&instance, &devices, &count);
    if (result == FNL_OK) {
        for (uint32_t i = 0; i < MIN(count, capacity); i++) {
            struct gpu_physical physical;
            gpu_physical_query(&instance, devices[i], &physical);
            out[i] = physical.info;
        }
        *out_count = count;
        host_free(&resolved, devices, count * sizeof(VkPhysicalDevice));
    }
    gpu_instance_close(&instance);
    return result;
}
