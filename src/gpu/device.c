/* SPDX-License-Identifier: MIT */
#include "base/check.h"
#include "gpu/gpu_internal.h"

/* ---- results ---- */

const char *gpu_result_text(VkResult result) {
#define ENTRY(name)                                                                                                         \
    { name, #name }
    static const struct {
        VkResult result;
        const char *text;
    } entries[] = {
        ENTRY(VK_SUCCESS),
        ENTRY(VK_TIMEOUT),
        ENTRY(VK_INCOMPLETE),
        ENTRY(VK_ERROR_OUT_OF_HOST_MEMORY),
        ENTRY(VK_ERROR_OUT_OF_DEVICE_MEMORY),
        ENTRY(VK_ERROR_INITIALIZATION_FAILED),
        ENTRY(VK_ERROR_DEVICE_LOST),
        ENTRY(VK_ERROR_MEMORY_MAP_FAILED),
        ENTRY(VK_ERROR_LAYER_NOT_PRESENT),
        ENTRY(VK_ERROR_EXTENSION_NOT_PRESENT),
        ENTRY(VK_ERROR_FEATURE_NOT_PRESENT),
        ENTRY(VK_ERROR_INCOMPATIBLE_DRIVER),
        ENTRY(VK_ERROR_TOO_MANY_OBJECTS),
        ENTRY(VK_ERROR_FORMAT_NOT_SUPPORTED),
        ENTRY(VK_ERROR_FRAGMENTED_POOL),
        ENTRY(VK_ERROR_OUT_OF_POOL_MEMORY),
        ENTRY(VK_ERROR_FRAGMENTATION),
        ENTRY(VK_ERROR_INVALID_OPAQUE_CAPTURE_ADDRESS),
    };
#undef ENTRY
    for (uint32_t i = 0; i < COUNT_OF(entries); i++) {
        if (entries[i].result == result) return entries[i].text;
    }
    return "an unknown VkResult";
}

fnl_result gpu_result_meaning(VkResult result) {
    switch (result) {
    case VK_ERROR_OUT_OF_HOST_MEMORY:
    case VK_ERROR_OUT_OF_DEVICE_MEMORY:
    case VK_ERROR_OUT_OF_POOL_MEMORY:
    case VK_ERROR_FRAGMENTED_POOL:
    case VK_ERROR_FRAGMENTATION:
    case VK_ERROR_MEMORY_MAP_FAILED:
    case VK_ERROR_TOO_MANY_OBJECTS:
        return FNL_ERROR_MEMORY;
    case VK_ERROR_DEVICE_LOST:
        return FNL_ERROR_DEVICE_LOST;
    case VK_ERROR_FORMAT_NOT_SUPPORTED:
        return FNL_ERROR_UNSUPPORTED;
    default:
        return result >= 0 ? FNL_OK : FNL_ERROR_DEVICE;
    }
}

fnl_result gpu_check(gpu_device *device, VkResult result, const char *format, ...) {
    if (result >= 0) return FNL_OK;
    char what[512];
    va_list arguments;
    va_start(arguments, format);
    text_format_list(what, sizeof what, format, arguments);
    va_end(arguments);
    /* A lost device is told once: every call after it fails as well. */
    if (result != VK_ERROR_DEVICE_LOST || atomic_exchange(&device->status, FNL_ERROR_DEVICE_LOST) != FNL_ERROR_DEVICE_LOST)
        log_error(&device->host, "%s: %s", what, gpu_result_text(result));
    return gpu_result_meaning(result);
}

fnl_result gpu_status(const gpu_device *device) { return (fnl_result)atomic_load(&device->status); }

void gpu_fail(gpu_device *device, fnl_result result) {
    if (result == FNL_OK) return;
    int expected = FNL_OK;
    bool first = atomic_compare_exchange_strong(&device->status, &expected, (int)result);
    /* Losing the device outweighs whatever went wrong before. */
    if (!first && result == FNL_ERROR_DEVICE_LOST && expected != FNL_ERROR_DEVICE_LOST) {
        atomic_store(&device->status, (int)result);
        first = true;
    }
    if (first) log_error(&device->host, "the frame cannot be finished: %s", fnl_result_name(result));
}

/* ---- small queries ---- */

const fnl_host *gpu_host(const gpu_device *device) { return &device->host; }
void **gpu_shared(gpu_device *device) { return &device->shared; }
struct jobs *gpu_jobs(gpu_device *device) {
    return device->jobs;
}
const fnl_device_info *gpu_info(const gpu_device *device) { return &device->info; }

bool gpu_standard_samples(const gpu_device *device) { return device->properties.limits.standardSampleLocations; }
uint32_t gpu_subpixel_bits(const gpu_device *device) { return device->properties.limits.subPixelPrecisionBits; }
bool gpu_isotropic_gradients(const gpu_device *device) { return device->isotropic_gradients; }

bool gpu_format_supports(const gpu_device *device, VkFormat format, VkFormatFeatureFlags2 features) {
    VkFormatProperties3 properties3 = {.sType = VK_STRUCTURE_TYPE_FORMAT_PROPERTIES_3};
    VkFormatProperties2 properties = {.sType = VK_STRUCTURE_TYPE_FORMAT_PROPERTIES_2, .pNext = &properties3};
    device->instance.vk.GetPhysicalDeviceFormatProperties2(device->physical, format, &properties);
    return (properties3.optimalTilingFeatures & features) == features;
}

uint32_t gpu_target_samples(const gpu_device *device, VkFormat format) {
    VkPhysicalDeviceImageFormatInfo2 query = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_IMAGE_FORMAT_INFO_2,
                                              .format = format,
                                              .type = VK_IMAGE_TYPE_2D,
                                              .tiling = VK_IMAGE_TILING_OPTIMAL,
                                              .usage =
                                                  VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT};
    VkImageFormatProperties2 properties = {.sType = VK_STRUCTURE_TYPE_IMAGE_FORMAT_PROPERTIES_2};
    VkResult result = device->instance.vk.GetPhysicalDeviceImageFormatProperties2(device->physical, &query, &properties);
    return result == VK_SUCCESS ? properties.imageFormatProperties.sampleCounts : 0;
}

void gpu_name(gpu_device *device, VkObjectType type, uint64_t handle, const char *name) {
    if (!device->names || !name) return;
    VkDebugUtilsObjectNameInfoEXT info = {
        .sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_OBJECT_NAME_INFO_EXT,
        .objectType = type,
        .objectHandle = handle,
        .pObjectName = name,
    };
    device->vk.SetDebugUtilsObjectNameEXT(device->handle, &info);
}

void gpu_sharing(const gpu_device *device, VkSharingMode *mode, uint32_t *count, uint32_t families[GPU_QUEUE_COUNT]) {
    for (uint32_t i = 0; i < GPU_QUEUE_COUNT; i++) families[i] = device->queues[i].family;
    bool shared = families[GPU_QUEUE_GRAPHICS] != families[GPU_QUEUE_COMPUTE];
    *mode = shared ? VK_SHARING_MODE_CONCURRENT : VK_SHARING_MODE_EXCLUSIVE;
    *count = shared ? GPU_QUEUE_COUNT : 0;
}

fnl_result gpu_semaphore_create(gpu_device *device, const char *name, VkSemaphore *out) {
    VkSemaphoreTypeCreateInfo type = {
        .sType = VK_STRUCTURE_TYPE_SEMAPHORE_TYPE_CREATE_INFO,
        .semaphoreType = VK_SEMAPHORE_TYPE_TIMELINE,
    };
    VkSemaphoreCreateInfo info = {.sType = VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO, .pNext = &type};
    TRY(gpu_check(device, device->vk.CreateSemaphore(device->handle, &info, NULL, out), "vkCreateSemaphore"));
    gpu_name(device, VK_OBJECT_TYPE_SEMAPHORE, (uint64_t)*out, name);
    return FNL_OK;
}

fnl_result gpu_semaphore_wait(gpu_device *device, VkSemaphore semaphore, uint64_t value) {
    if (value == 0) return FNL_OK;
    VkSemaphoreWaitInfo info = {
        .sType = VK_STRUCTURE_TYPE_SEMAPHORE_WAIT_INFO,
        .semaphoreCount = 1,
        .pSemaphores = &semaphore,
        .pValues = &value,
    };
    return gpu_check(device, device->vk.WaitSemaphores(device->handle, &info, UINT64_MAX), "vkWaitSemaphores");
}

fnl_result gpu_wait_idle(gpu_device *device) {
    TRY(gpu_uploads_wait(device, atomic_load(&device->uploads.recorded)));
    for (uint32_t i = 0; i < GPU_QUEUE_COUNT; i++)
        TRY(gpu_semaphore_wait(device, device->queues[i].timeline, device->queues[i].value));
    if (!device->in_frame) {
        for (uint32_t i = 0; i < GPU_FRAMES_IN_FLIGHT; i++) gpu_retire_release(device, i);
    }
    return FNL_OK;
}

/* ---- making ---- */

fnl_device_params fnl_device_params_default(void) { return (fnl_device_params){.host = fnl_host_default(), .index = -1}; }

fnl_result gpu_device_new(const fnl_device_params *params, gpu_device **out) {
    fnl_host host = host_resolve(&params->host);
    gpu_device *device = host_allocate_zero(&host, sizeof *device);
    if (!device) return FNL_ERROR_MEMORY;
    device->host = host;
    pthread_mutex_init(&device->queue_mutex, NULL);
    pthread_mutex_init(&device->retire_mutex, NULL);
    pthread_mutex_init(&device->slice_mutex, NULL);
    pthread_mutex_init(&device->last_uses.mutex, NULL);
    pthread_mutex_init(&device->memory.mutex, NULL);
    pthread_mutex_init(&device->bindless.mutex, NULL);
    pthread_mutex_init(&device->scopes.mutex, NULL);
    pthread_mutex_init(&device->uploads.mutex, NULL);
    pthread_mutex_init(&device->pipelines.mutex, NULL);
    pthread_cond_init(&device->pipelines.changed, NULL);
    pthread_rwlock_init(&device->pipelines.lock, NULL);
    device->dead_commands.device = device;
    *out = device;
    return jobs_create(&host, &device->jobs);
}

static fnl_result load_functions(gpu_device *device) {
    PFN_vkGetDeviceProcAddr get = device->instance.vk.GetDeviceProcAddr;
    const char *missing = NULL;
#define LOAD(name)                                                                                                          \
    device->vk.name = (PFN_vk##name)get(device->handle, "vk" #name);                                                        \
    if (!device->vk.name) missing = "vk" #name;
    GPU_DEVICE_FUNCTIONS(LOAD)
    if (missing) {
        log_error(&device->host, "%s: the driver has no %s", device->info.name, missing);
        return FNL_ERROR_DEVICE;
    }
    if (device->info.mesh_shader) {
        GPU_DEVICE_MESH_FUNCTIONS(LOAD)
        device->info.mesh_shader = !missing;
    }
    missing = NULL;
    if (device->info.ray_query) {
        GPU_DEVICE_STRUCTURE_FUNCTIONS(LOAD)
        device->info.ray_query = !missing;
    }
    missing = NULL;
    /* Only where the instance has the extension: some loaders hand these out even if it is off. */
    if (device->instance.vk.CreateDebugUtilsMessengerEXT) {
        GPU_DEVICE_DEBUG_FUNCTIONS(LOAD)
        device->names = !missing;
    }
#undef LOAD
    return FNL_OK;
}

fnl_result gpu_device_start(gpu_device *device, const char *cache_folder) {
    TRY(load_functions(device));
    VkPhysicalDeviceMaintenance4Properties maintenance4 = {.sType =
                                                               VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MAINTENANCE_4_PROPERTIES};
    VkPhysicalDeviceProperties2 properties = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2,
                                              .pNext = &maintenance4};
    device->instance.vk.GetPhysicalDeviceProperties2(device->physical, &properties);
    device->properties = properties.properties;
    device->max_buffer_size = maintenance4.maxBufferSize;
    VkPhysicalDeviceAccelerationStructurePropertiesKHR structures = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ACCELERATION_STRUCTURE_PROPERTIES_KHR};
    if (device->info.ray_query) {
        VkPhysicalDeviceProperties2 query = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, .pNext = &structures};
        device->instance.vk.GetPhysicalDeviceProperties2(device->physical, &query);
    }
    device->scratch_alignment = MAX(1u, structures.minAccelerationStructureScratchOffsetAlignment);
    device->memory.granularity = MAX(1u, device->properties.limits.bufferImageGranularity);
    device->instance.vk.GetPhysicalDeviceMemoryProperties(device->physical, &device->memory.properties);

    VkQueueFamilyProperties families[32];
    uint32_t count = COUNT_OF(families);
    device->instance.vk.GetPhysicalDeviceQueueFamilyProperties(device->physical, &count, families);
    uint32_t bits = 64;
    for (uint32_t i = 0; i < GPU_QUEUE_COUNT; i++) bits = MIN(bits, families[device->queues[i].family].timestampValidBits);
    device->timestamp_mask = bits == 0 ? 0 : UINT64_MAX >> (64 - bits);
    device->info.timestamps = bits > 0;

    static const char *const names[GPU_QUEUE_COUNT] = {"graphics timeline", "compute timeline"};
    for (uint32_t i = 0; i < GPU_QUEUE_COUNT; i++) TRY(gpu_semaphore_create(device, names[i], &device->queues[i].timeline));
    TRY(gpu_semaphore_create(device, "upload timeline", &device->uploads.timeline));
    TRY(gpu_bindless_init(device));
    TRY(gpu_scopes_init(device));
    TRY(gpu_pipelines_init(device, cache_folder));
    TRY(gpu_frames_init(device));
    VkPhysicalDeviceDriverProperties driver = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DRIVER_PROPERTIES};
    properties.pNext = &driver;
    device->instance.vk.GetPhysicalDeviceProperties2(device->physical, &properties);
    device->keeps_draw_counts = device->compiles_late = driver.driverID == VK_DRIVER_ID_MESA_LLVMPIPE;
    return FNL_OK;
}

static fnl_result create_device(gpu_device *device, const struct gpu_physical *physical, bool presentation) {
    struct gpu_features features;
    gpu_features_require(&features);
    const VkPhysicalDeviceFeatures *supported = &physical->supported.features.features;
    VkPhysicalDeviceFeatures *enabled = &features.features.features;
    enabled->geometryShader = supported->geometryShader; /* fragment shaders get gl_PrimitiveID with it */
    enabled->pipelineStatisticsQuery = supported->pipelineStatisticsQuery;
    enabled->shaderClipDistance = supported->shaderClipDistance;
    enabled->textureCompressionBC = supported->textureCompressionBC;
    enabled->imageCubeArray = supported->imageCubeArray;
    enabled->sampleRateShading = supported->sampleRateShading;
    features.features_11.multiview = physical->supported.features_11.multiview;
    features.features_12.shaderOutputLayer = physical->supported.features_12.shaderOutputLayer;
    features.features_12.samplerFilterMinmax = physical->supported.features_12.samplerFilterMinmax;

    bool second = physical->info.async_compute;
    bool same_family = physical->families[0] == physical->families[1];
    float priorities[] = {1.0f, 1.0f};
    VkDeviceQueueCreateInfo queues[GPU_QUEUE_COUNT];
    for (uint32_t i = 0; i < GPU_QUEUE_COUNT; i++) {
        queues[i] = (VkDeviceQueueCreateInfo){
            .sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO,
            .queueFamilyIndex = physical->families[i],
            .queueCount = same_family && second ? 2 : 1,
            .pQueuePriorities = priorities,
        };
    }
    VkPhysicalDeviceMeshShaderFeaturesEXT meshes = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MESH_SHADER_FEATURES_EXT,
                                                    .pNext = &features.features,
                                                    .meshShader = VK_TRUE};
    VkPhysicalDeviceRayQueryFeaturesKHR queries = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_RAY_QUERY_FEATURES_KHR,
                                                   .pNext = physical->info.mesh_shader ? (void *)&meshes : &features.features,
                                                   .rayQuery = VK_TRUE};
    VkPhysicalDeviceAccelerationStructureFeaturesKHR structures = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ACCELERATION_STRUCTURE_FEATURES_KHR,
        .pNext = &queries,
        .accelerationStructure = VK_TRUE};
    const char *extensions[9];
    uint32_t extension_count = 0;
    if (presentation && !physical->swapchain) {
        log_error(&device->host, "%s: presentation was asked for, but the driver has no %s", physical->info.name, VK_KHR_SWAPCHAIN_EXTENSION_NAME);
        return FNL_ERROR_UNSUPPORTED;
    }
    if (presentation) extensions[extension_count++] = VK_KHR_SWAPCHAIN_EXTENSION_NAME;
    if (physical->info.conservative_raster)
        extensions[extension_count++] = VK_EXT_CONSERVATIVE_RASTERIZATION_EXTENSION_NAME;
    if (physical->info.post_depth_coverage) extensions[extension_count++] = VK_EXT_POST_DEPTH_COVERAGE_EXTENSION_NAME;
    if (physical->info.mesh_shader) extensions[extension_count++] = VK_EXT_MESH_SHADER_EXTENSION_NAME;
    if (physical->info.ray_query) {
        extensions[extension_count++] = VK_KHR_RAY_QUERY_EXTENSION_NAME;
        extensions[extension_count++] = VK_KHR_ACCELERATION_STRUCTURE_EXTENSION_NAME;
        extensions[extension_count++] = VK_KHR_DEFERRED_HOST_OPERATIONS_EXTENSION_NAME;
    }
    VkDeviceCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
        .enabledExtensionCount = extension_count,
        .ppEnabledExtensionNames = extensions,
        .pNext = physical->info.ray_query ? (const void *)&structures : queries.pNext,
        .queueCreateInfoCount = same_family ? 1 : GPU_QUEUE_COUNT,
        .pQueueCreateInfos = queues,
    };
    VkResult result = device->instance.vk.CreateDevice(physical->handle, &info, NULL, &device->handle);
    if (result != VK_SUCCESS) {
        device->handle = VK_NULL_HANDLE;
        log_error(&device->host, "%s: vkCreateDevice: %s", physical->info.name, gpu_result_text(result));
        return gpu_result_meaning(result);
    }
    PFN_vkGetDeviceQueue get_queue =
        (PFN_vkGetDeviceQueue)device->instance.vk.GetDeviceProcAddr(device->handle, "vkGetDeviceQueue");
    for (uint32_t i = 0; i < GPU_QUEUE_COUNT; i++) {
        device->queues[i].family = physical->families[i];
        get_queue(device->handle, physical->families[i], physical->queue_indices[i], &device->queues[i].handle);
    }
    return FNL_OK;
}

static fnl_result open_device(gpu_device *device, const struct gpu_physical *physical, const char *cache_folder, bool presentation) {
    device->physical = physical->handle;
    device->info = physical->info;
    device->isotropic_gradients = physical->isotropic_gradients;
    TRY(create_device(device, physical, presentation));
    return gpu_device_start(device, cache_folder);
}

static void no_log(void *user, fnl_log_level level, const char *line) {
    UNUSED(user);
    UNUSED(level);
    UNUSED(line);
}

fnl_result gpu_device_create_beside(const gpu_device *device, gpu_device **out) {
    fnl_device_params params = fnl_device_params_default();
    struct gpu_physical physical;
    params.host = device->host;
    params.host.log = no_log;
    params.host.thread_count = 1;
    fnl_result result = gpu_device_new(&params, out);
    if (result == FNL_OK)
        result = gpu_instance_import(&(*out)->instance, &(*out)->host, device->instance.get_proc, device->instance.handle,
                                     false);
    if (result == FNL_OK) {
        gpu_physical_query(&(*out)->instance, device->physical, &physical);
        result = open_device(*out, &physical, "", false);
    }
    if (result != FNL_OK) fnl_device_destroy(out);
    return result;
}

fnl_result fnl_device_create(const fnl_device_params *params, fnl_device **out) {
    fnl_device_params defaults = fnl_device_params_default();
    if (!params) params = &defaults;
    fnl_host host = host_resolve(&params->host);
    TRY(check_pointer(CALL(&host), "out", out));
    *out = NULL;
    if (params->index < -1) return misuse(CALL(&host), "index is %d, must be -1 or the number of a device", params->index);

    gpu_device *device = NULL;
    struct gpu_physical physical;
    fnl_result result = gpu_device_new(params, &device);
    if (result == FNL_OK) result = gpu_instance_open(&device->instance, &device->host,
                                   &(struct gpu_instance_params){.validate = params->validate, .presentation = params->presentation});
    if (result == FNL_OK) result = gpu_physical_pick(&device->instance, params, &physical);
    if (result == FNL_OK) result = open_device(device, &physical, params->cache_folder, params->presentation);
    if (result != FNL_OK) {
        fnl_device_destroy(&device);
        return result;
    }
    log_debug(&device->host, "device: %s, %s, %s", device->info.name, device->info.driver,
              fnl_value_name(FNL_ENUM_DEVICE_TYPE, device->info.type));
    *out = device;
    return FNL_OK;
}

void fnl_device_destroy(fnl_device **address) {
    if (!address || !*address) return;
    gpu_device *device = *address;
    *address = NULL;
    if (device->handle && device->vk.DestroyDevice) {
        device->in_frame = false;
        gpu_wait_idle(device);
        /* Mesa's CPU driver still tidies up after the last semaphore is signalled. What is imported is for its owner to wait for. */
        if (!device->imported) device->vk.DeviceWaitIdle(device->handle);
        gpu_uploads_finish(device);
        gpu_frames_finish(device);
        gpu_pipelines_finish(device);
        gpu_scopes_finish(device);
        gpu_bindless_finish(device);
        gpu_memory_finish(device);
        for (uint32_t i = 0; i < GPU_QUEUE_COUNT; i++)
            device->vk.DestroySemaphore(device->handle, device->queues[i].timeline, NULL);
        device->vk.DestroySemaphore(device->handle, device->uploads.timeline, NULL);
        if (!device->imported) device->vk.DestroyDevice(device->handle, NULL);
    }
    gpu_instance_close(&device->instance);
    jobs_destroy(&device->jobs);
    pthread_mutex_destroy(&device->queue_mutex);
    pthread_mutex_destroy(&device->retire_mutex);
    pthread_mutex_destroy(&device->slice_mutex);
    array_free(&device->host, &device->last_uses.items);
    pthread_mutex_destroy(&device->last_uses.mutex);
    pthread_mutex_destroy(&device->memory.mutex);
    pthread_mutex_destroy(&device->bindless.mutex);
    pthread_mutex_destroy(&device->scopes.mutex);
    pthread_mutex_destroy(&device->uploads.mutex);
    pthread_mutex_destroy(&device->pipelines.mutex);
    pthread_cond_destroy(&device->pipelines.changed);
    pthread_rwlock_destroy(&device->pipelines.lock);
    fnl_host host = device->host;
    host_free(&host, device, sizeof *device);
}

fnl_result fnl_device_query_info(const fnl_device *device, fnl_device_info *out) {
    TRY(check_handle(__func__, "device", device));
    TRY(check_pointer(CALL(&device->host), "out", out));
    *out = device->info;
    return FNL_OK;
}

uint64_t fnl_device_validation_count(const fnl_device *device) {
    return check_handle(__func__, "device", device) == FNL_OK ? atomic_load(&device->instance.message_count) : 0;
}
