/* SPDX-License-Identifier: MIT */
#include "fanal/vulkan.h"
#include "gpu/gpu_internal.h"

void fnl_vulkan_requirements_init(fnl_vulkan_requirements *requirements) {
    if (!requirements) return;
    struct gpu_features features;
    gpu_features_require(&features);
    *requirements =
        (fnl_vulkan_requirements){features.features, features.features_11, features.features_12, features.features_13};
    requirements->features.pNext = &requirements->features_11;
    requirements->features_11.pNext = &requirements->features_12;
    requirements->features_12.pNext = &requirements->features_13;
}

static fnl_result check_families(const gpu_device *device, const fnl_vulkan_import *import) {
    VkQueueFamilyProperties families[32];
    uint32_t count = COUNT_OF(families);
    device->instance.vk.GetPhysicalDeviceQueueFamilyProperties(import->physical_device, &count, families);
    const VkQueueFlags both = VK_QUEUE_GRAPHICS_BIT | VK_QUEUE_COMPUTE_BIT;
    REQUIRE(&device->host, import->graphics_family < count);
    REQUIRE(&device->host, (families[import->graphics_family].queueFlags & both) == both);
    if (import->compute_queue) {
        REQUIRE(&device->host, import->compute_family < count);
        REQUIRE(&device->host, families[import->compute_family].queueFlags & VK_QUEUE_COMPUTE_BIT);
    }
    return FNL_OK;
}

static fnl_result import_device(gpu_device *device, const fnl_device_params *params, const fnl_vulkan_import *import) {
    TRY(gpu_instance_import(&device->instance, &device->host, import->get_instance_proc_addr, import->instance,
                            params->validate));
    struct gpu_physical physical;
    gpu_physical_query(&device->instance, import->physical_device, &physical);
    if (!physical.info.usable) {
        log_error(&device->host, "the imported device (%s) cannot be used, it lacks: %s", physical.info.name,
                  physical.info.missing);
        return FNL_ERROR_DEVICE;
    }
    TRY(check_families(device, import));
    device->info = physical.info;
    /* What the caller switched on beyond the requirements is not known. */
    device->info.ray_query = device->info.mesh_shader = device->info.conservative_raster = false;
    device->info.barycentrics = device->info.sample_locations = device->info.fragment_shading_rate = false;
    device->info.multiview = device->info.pipeline_statistics = device->info.primitive_ids = false;
    device->info.minmax_samplers = false;
    device->info.post_depth_coverage = false;
    device->isotropic_gradients = physical.isotropic_gradients;
    device->imported = true;
    device->physical = import->physical_device;
    device->handle = import->device;
    bool second = import->compute_queue && import->compute_queue != import->graphics_queue;
    device->info.async_compute = second;
    device->queues[GPU_QUEUE_GRAPHICS].handle = import->graphics_queue;
    device->queues[GPU_QUEUE_GRAPHICS].family = import->graphics_family;
    device->queues[GPU_QUEUE_COMPUTE].handle = second ? import->compute_queue : import->graphics_queue;
    device->queues[GPU_QUEUE_COMPUTE].family = second ? import->compute_family : import->graphics_family;
    return gpu_device_start(device, params->cache_folder);
}

fnl_result fnl_device_import(const fnl_device_params *params, const fnl_vulkan_import *import, fnl_device **out) {
    fnl_device_params defaults = fnl_device_params_default();
    if (!params) params = &defaults;
    fnl_host host = host_resolve(&params->host);
    REQUIRE(&host, out != NULL);
    *out = NULL;
    REQUIRE(&host, import != NULL);
    REQUIRE(&host, import->get_instance_proc_addr != NULL);
    REQUIRE(&host, import->instance != VK_NULL_HANDLE);
    REQUIRE(&host, import->physical_device != VK_NULL_HANDLE);
    REQUIRE(&host, import->device != VK_NULL_HANDLE);
    REQUIRE(&host, import->graphics_queue != VK_NULL_HANDLE);
    gpu_device *device = NULL;
    fnl_result result = gpu_device_new(params, &device);
    if (result == FNL_OK) result = import_device(device, params, import);
    if (result != FNL_OK) {
        fnl_device_destroy(&device);
        return result;
    }
    *out = device;
    return FNL_OK;
}
