/* SPDX-License-Identifier: MIT */
#include "fanal/vulkan.h"
#include "gpu/gpu_internal.h"

#include <string.h>

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

/* ---- optional features ---- */

static const void *find_in_chain(const VkDeviceCreateInfo *created, VkStructureType type) {
    const VkBaseInStructure *s = created->pNext;
    while (s && s->sType != type) s = s->pNext;
    return s;
}

static bool has_extension(const VkDeviceCreateInfo *created, const char *name) {
    for (uint32_t i = 0; i < created->enabledExtensionCount; i++)
        if (strcmp(created->ppEnabledExtensionNames[i], name) == 0) return true;
    return false;
}

/* Leaves of the optional features that Fanal uses those that the caller switched on. */
static void keep_enabled(const VkDeviceCreateInfo *created, fnl_device_info *info) {
    const VkDeviceCreateInfo nothing = {.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO};
    if (!created) created = &nothing;
    const VkPhysicalDeviceFeatures2 *two = find_in_chain(created, VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2);
    const VkPhysicalDeviceFeatures *core = two ? &two->features : created->pEnabledFeatures;
    const VkPhysicalDeviceVulkan11Features *in_11 =
        find_in_chain(created, VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_1_FEATURES);
    const VkPhysicalDeviceVulkan12Features *in_12 =
        find_in_chain(created, VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES);
    const VkPhysicalDeviceMeshShaderFeaturesEXT *mesh =
        find_in_chain(created, VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MESH_SHADER_FEATURES_EXT);
    info->primitive_ids = info->primitive_ids && core && core->geometryShader;
    info->pipeline_statistics = info->pipeline_statistics && core && core->pipelineStatisticsQuery;
    info->multiview = info->multiview && in_11 && in_11->multiview;
    info->minmax_samplers = info->minmax_samplers && in_12 && in_12->samplerFilterMinmax;
    info->mesh_shader =
        info->mesh_shader && mesh && mesh->meshShader && has_extension(created, VK_EXT_MESH_SHADER_EXTENSION_NAME);
    info->conservative_raster =
        info->conservative_raster && has_extension(created, VK_EXT_CONSERVATIVE_RASTERIZATION_EXTENSION_NAME);
    info->post_depth_coverage =
        info->post_depth_coverage && has_extension(created, VK_EXT_POST_DEPTH_COVERAGE_EXTENSION_NAME);
    /* Nothing uses these. */
    info->ray_query = info->barycentrics = info->sample_locations = info->fragment_shading_rate = false;
}

/* ---- the device ---- */

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
    keep_enabled(import->created, &device->info);
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
