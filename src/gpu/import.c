/* SPDX-License-Identifier: MIT */
#include "base/check.h"
#include "fanal/vulkan.h"
#include "gpu/gpu_internal.h"

#include <string.h>

void fnl_vulkan_requirements_init(fnl_vulkan_requirements *requirements) {
    if (check_handle(__func__, "requirements", requirements) != FNL_OK) return;
    struct gpu_features features;
    gpu_features_require(&features);
    *requirements =
        (fnl_vulkan_requirements){features.features, features.features_11, features.features_12, features.features_13};
    requirements->features.pNext = &requirements->features_11;
    requirements->features_11.pNext = &requirements->features_12;
    requirements->features_12.pNext = &requirements->features_13;
}

static fnl_result check_family(const struct call *call, const char *name, const VkQueueFamilyProperties *families,
                               uint32_t count, uint32_t family, VkQueueFlags wanted) {
    TRY(check_index(call, name, family, count, "queue families"));
    if ((families[family].queueFlags & wanted) == wanted) return FNL_OK;
    return misuse(call, "%s is %u, must be a family with %scompute", name, family,
                  wanted & VK_QUEUE_GRAPHICS_BIT ? "graphics and " : "");
}

static fnl_result check_families(const struct call *call, const gpu_device *device, const fnl_vulkan_import *import) {
    VkQueueFamilyProperties families[32];
    uint32_t count = COUNT_OF(families);
    device->instance.vk.GetPhysicalDeviceQueueFamilyProperties(import->physical_device, &count, families);
    TRY(check_family(call, "graphics_family", families, count, import->graphics_family,
                     VK_QUEUE_GRAPHICS_BIT | VK_QUEUE_COMPUTE_BIT));
    if (!import->compute_queue) return FNL_OK;
    return check_family(call, "compute_family", families, count, import->compute_family, VK_QUEUE_COMPUTE_BIT);
}

/* ---- what the caller's device was created with ---- */

static bool has_extension(const VkDeviceCreateInfo *created, const char *name) {
    for (uint32_t i = 0; i < created->enabledExtensionCount; i++)
        if (strcmp(created->ppEnabledExtensionNames[i], name) == 0) return true;
    return false;
}

/* Structures that switch on features of Vulkan 1.1 to 1.3 one by one, in place of VkPhysicalDeviceVulkan1*Features:
   X(name, sType, member of struct gpu_features, feature). */
#define SINGLE_FEATURES(X)                                                                                                  \
    X(ShaderDrawParametersFeatures, SHADER_DRAW_PARAMETERS_FEATURES, features_11, shaderDrawParameters)                     \
    X(MultiviewFeatures, MULTIVIEW_FEATURES, features_11, multiview)                                                        \
    X(BufferDeviceAddressFeatures, BUFFER_DEVICE_ADDRESS_FEATURES, features_12, bufferDeviceAddress)                        \
    X(ScalarBlockLayoutFeatures, SCALAR_BLOCK_LAYOUT_FEATURES, features_12, scalarBlockLayout)                              \
    X(ImagelessFramebufferFeatures, IMAGELESS_FRAMEBUFFER_FEATURES, features_12, imagelessFramebuffer)                      \
    X(TimelineSemaphoreFeatures, TIMELINE_SEMAPHORE_FEATURES, features_12, timelineSemaphore)                               \
    X(HostQueryResetFeatures, HOST_QUERY_RESET_FEATURES, features_12, hostQueryReset)                                       \
    X(SeparateDepthStencilLayoutsFeatures, SEPARATE_DEPTH_STENCIL_LAYOUTS_FEATURES, features_12,                            \
      separateDepthStencilLayouts)                                                                                          \
    X(DynamicRenderingFeatures, DYNAMIC_RENDERING_FEATURES, features_13, dynamicRendering)                                  \
    X(Synchronization2Features, SYNCHRONIZATION_2_FEATURES, features_13, synchronization2)                                  \
    X(Maintenance4Features, MAINTENANCE_4_FEATURES, features_13, maintenance4)                                              \
    X(ShaderDemoteToHelperInvocationFeatures, SHADER_DEMOTE_TO_HELPER_INVOCATION_FEATURES, features_13,                     \
      shaderDemoteToHelperInvocation)                                                                                       \
    X(ShaderTerminateInvocationFeatures, SHADER_TERMINATE_INVOCATION_FEATURES, features_13, shaderTerminateInvocation)

static void read_descriptor_indexing(const VkPhysicalDeviceDescriptorIndexingFeatures *in,
                                     VkPhysicalDeviceVulkan12Features *out) {
    out->descriptorIndexing = VK_TRUE; /* says no more than the following ones together */
    out->runtimeDescriptorArray = in->runtimeDescriptorArray;
    out->descriptorBindingPartiallyBound = in->descriptorBindingPartiallyBound;
    out->descriptorBindingSampledImageUpdateAfterBind = in->descriptorBindingSampledImageUpdateAfterBind;
    out->descriptorBindingStorageImageUpdateAfterBind = in->descriptorBindingStorageImageUpdateAfterBind;
    out->descriptorBindingUpdateUnusedWhilePending = in->descriptorBindingUpdateUnusedWhilePending;
    out->shaderSampledImageArrayNonUniformIndexing = in->shaderSampledImageArrayNonUniformIndexing;
    out->shaderStorageImageArrayNonUniformIndexing = in->shaderStorageImageArrayNonUniformIndexing;
}

struct enabled {
    struct gpu_features features; /* its pNext pointers are the caller's */
    bool mesh_shader, ray_query, structures;
};

/* A valid chain has each structure once, and no single one beside VkPhysicalDeviceVulkan1*Features of its version. */
static void read_enabled(const VkDeviceCreateInfo *created, struct enabled *out) {
    *out = (struct enabled){0};
    if (created->pEnabledFeatures) out->features.features.features = *created->pEnabledFeatures;
    for (const VkBaseInStructure *s = created->pNext; s; s = s->pNext) {
        const void *in = s;
        switch ((int)s->sType) {
        case VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2:
            out->features.features = *(const VkPhysicalDeviceFeatures2 *)in;
            break;
        case VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_1_FEATURES:
            out->features.features_11 = *(const VkPhysicalDeviceVulkan11Features *)in;
            break;
        case VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES:
            out->features.features_12 = *(const VkPhysicalDeviceVulkan12Features *)in;
            break;
        case VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES:
            out->features.features_13 = *(const VkPhysicalDeviceVulkan13Features *)in;
            break;
        case VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DESCRIPTOR_INDEXING_FEATURES:
            read_descriptor_indexing(in, &out->features.features_12);
            break;
        case VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MESH_SHADER_FEATURES_EXT:
            out->mesh_shader = ((const VkPhysicalDeviceMeshShaderFeaturesEXT *)in)->meshShader;
            break;
        case VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_RAY_QUERY_FEATURES_KHR:
            out->ray_query = ((const VkPhysicalDeviceRayQueryFeaturesKHR *)in)->rayQuery;
            break;
        case VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ACCELERATION_STRUCTURE_FEATURES_KHR:
            out->structures = ((const VkPhysicalDeviceAccelerationStructureFeaturesKHR *)in)->accelerationStructure;
            break;
#define READ(name, type, member, feature)                                                                                   \
    case VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_##type:                                                                          \
        out->features.member.feature = ((const VkPhysicalDevice##name *)in)->feature;                                       \
        break;
            SINGLE_FEATURES(READ)
#undef READ
        default:
            break;
        }
    }
    /* Extensions that became features of Vulkan 1.2: naming them switches the feature on. */
    if (has_extension(created, VK_KHR_DRAW_INDIRECT_COUNT_EXTENSION_NAME))
        out->features.features_12.drawIndirectCount = VK_TRUE;
    if (has_extension(created, VK_EXT_SHADER_VIEWPORT_INDEX_LAYER_EXTENSION_NAME)) out->features.features_12.shaderOutputLayer = VK_TRUE;
    if (has_extension(created, VK_EXT_SAMPLER_FILTER_MINMAX_EXTENSION_NAME))
        out->features.features_12.samplerFilterMinmax = VK_TRUE;
}

static fnl_result check_required(const struct call *call, const struct enabled *enabled) {
    char missing[1600] = "";
    gpu_features_missing(&enabled->features, missing, sizeof missing);
    if (!missing[0]) return FNL_OK;
    log_error(call->host, "%s: the device was created without features that Fanal needs (fnl_vulkan_requirements_init): %s",
              call->function, missing);
    return FNL_ERROR_UNSUPPORTED;
}

/* Leaves of the optional features that Fanal uses those that the caller switched on. */
static void keep_enabled(const VkDeviceCreateInfo *created, const struct enabled *enabled, fnl_device_info *info) {
    info->primitive_ids &= enabled->features.features.features.geometryShader != 0;
    info->vertex_layers &= enabled->features.features_12.shaderOutputLayer != 0;
    info->vertex_counts &= enabled->features.features.features.pipelineStatisticsQuery != 0;
    info->clip_distances &= enabled->features.features.features.shaderClipDistance != 0;
    info->texture_compression &= enabled->features.features.features.textureCompressionBC != 0;
    info->multiview &= enabled->features.features_11.multiview != 0;
    if (!info->multiview) info->max_views = 1;
    info->minmax_samplers &= enabled->features.features_12.samplerFilterMinmax != 0;
    info->mesh_shader &= enabled->mesh_shader && has_extension(created, VK_EXT_MESH_SHADER_EXTENSION_NAME);
    info->conservative_raster &= has_extension(created, VK_EXT_CONSERVATIVE_RASTERIZATION_EXTENSION_NAME);
    info->post_depth_coverage &= has_extension(created, VK_EXT_POST_DEPTH_COVERAGE_EXTENSION_NAME);
    info->ray_query &= enabled->ray_query && enabled->structures && has_extension(created, VK_KHR_RAY_QUERY_EXTENSION_NAME) &&
                       has_extension(created, VK_KHR_ACCELERATION_STRUCTURE_EXTENSION_NAME);
    /* Nothing uses these. */
    info->barycentrics = info->sample_locations = info->fragment_shading_rate = false;
}

/* ---- the device ---- */

static fnl_result import_device(const struct call *call, gpu_device *device, const fnl_device_params *params,
                                const fnl_vulkan_import *import) {
    TRY(gpu_instance_import(&device->instance, &device->host, import->get_instance_proc_addr, import->instance,
                            params->validate));
    struct gpu_physical physical;
    gpu_physical_query(&device->instance, import->physical_device, &physical);
    if (!physical.info.usable) {
        log_error(&device->host, "the imported device (%s) cannot be used, it lacks: %s", physical.info.name,
                  physical.info.missing);
        return FNL_ERROR_DEVICE;
    }
    TRY(check_families(call, device, import));
    const VkDeviceCreateInfo nothing = {.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO};
    const VkDeviceCreateInfo *created = import->created ? import->created : &nothing;
    struct enabled enabled;
    read_enabled(created, &enabled);
    if (import->created) TRY(check_required(call, &enabled));
    device->info = physical.info;
    keep_enabled(created, &enabled, &device->info);
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
    const struct call *call = CALL(&host);
    TRY(check_pointer(call, "out", out));
    *out = NULL;
    TRY(check_pointer(call, "import", import));
    if (!import->get_instance_proc_addr) return misuse(call, "get_instance_proc_addr is NULL");
    TRY(check_pointer(call, "instance", import->instance));
    TRY(check_pointer(call, "physical_device", import->physical_device));
    TRY(check_pointer(call, "device", import->device));
    TRY(check_pointer(call, "graphics_queue", import->graphics_queue));
    gpu_device *device = NULL;
    fnl_result result = gpu_device_new(params, &device);
    if (result == FNL_OK) result = import_device(call, device, params, import);
    if (result != FNL_OK) {
        fnl_device_destroy(&device);
        return result;
    }
    *out = device;
    return FNL_OK;
}
