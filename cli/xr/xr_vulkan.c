/* SPDX-License-Identifier: MIT */
/* The Vulkan device of the session: made through the runtime, which knows what the headset needs, and imported by Fanal. */
#include "xr/xr.h"

#include "print.h"

#include <dlfcn.h>
#include <stdio.h>
#include <string.h>

#define LOAD(x, name) PFN_vk##name name = (PFN_vk##name)(x)->get_proc((x)->vulkan, "vk" #name)
#define LOAD_XR(x, name)                                                                                                    \
    PFN_##name name = NULL;                                                                                                 \
    if (!xr_good(x, "xrGetInstanceProcAddr(" #name ")", xrGetInstanceProcAddr((x)->instance, #name, (PFN_xrVoidFunction *)&name))) return false

static bool fail(struct xr *x, const char *text) {
    fprintf(stderr, "fanal: error: %s\n", text);
    x->end = XR_FAILED;
    return false;
}

static bool check_requirements(struct xr *x) {
    LOAD_XR(x, xrGetVulkanGraphicsRequirements2KHR);
    XrGraphicsRequirementsVulkan2KHR needs = {.type = XR_TYPE_GRAPHICS_REQUIREMENTS_VULKAN2_KHR};
    if (!xr_good(x, "xrGetVulkanGraphicsRequirements2KHR", xrGetVulkanGraphicsRequirements2KHR(x->instance, x->system, &needs))) return false;
    if (needs.minApiVersionSupported <= XR_MAKE_VERSION(1, 3, UINT32_MAX)) return true; /* above the highest tested one nothing is said to break */
    return fail(x, "the OpenXR runtime wants a Vulkan later than 1.3, which is what Fanal uses");
}

static bool create_instance(struct xr *x) {
    const bool validate = x->options->validate;
    const char *const layers[] = {"VK_LAYER_KHRONOS_validation"};
    const char *const extensions[] = {VK_EXT_DEBUG_UTILS_EXTENSION_NAME, VK_EXT_VALIDATION_FEATURES_EXTENSION_NAME};
    const VkValidationFeatureEnableEXT enabled[] = {VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT};
    const VkValidationFeaturesEXT features = {.sType = VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT, .enabledValidationFeatureCount = 1, .pEnabledValidationFeatures = enabled};
    const VkApplicationInfo application = {.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO, .pApplicationName = "fanal xr", .pEngineName = "Fanal", .apiVersion = VK_API_VERSION_1_3};
    const VkInstanceCreateInfo info = {.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO,
                                       .pNext = validate ? &features : NULL,
                                       .pApplicationInfo = &application,
                                       .enabledLayerCount = validate,
                                       .ppEnabledLayerNames = layers,
                                       .enabledExtensionCount = validate ? 2 : 0,
                                       .ppEnabledExtensionNames = extensions};
    const XrVulkanInstanceCreateInfoKHR create = {.type = XR_TYPE_VULKAN_INSTANCE_CREATE_INFO_KHR,
                                                  .systemId = x->system,
                                                  .pfnGetInstanceProcAddr = x->get_proc,
                                                  .vulkanCreateInfo = &info};
    VkResult result = VK_SUCCESS;
    LOAD_XR(x, xrCreateVulkanInstanceKHR);
    if (!xr_good(x, "xrCreateVulkanInstanceKHR", xrCreateVulkanInstanceKHR(x->instance, &create, &x->vulkan, &result))) {
        x->vulkan = VK_NULL_HANDLE;
        return false;
    }
    if (result == VK_SUCCESS) return true;
    x->vulkan = VK_NULL_HANDLE;
    fprintf(stderr, "fanal: error: vkCreateInstance, called by the OpenXR runtime: VkResult %d%s\n", (int)result,
            result == VK_ERROR_LAYER_NOT_PRESENT ? ", the validation layer is not installed (Debian: vulkan-validationlayers)" : "");
    x->end = XR_FAILED;
    return false;
}

/* What fnl_vulkan_import.created may switch on besides what Fanal needs, where the device has it. */
struct features {
    fnl_vulkan_requirements all;
    VkPhysicalDeviceMeshShaderFeaturesEXT mesh;
    VkPhysicalDeviceAccelerationStructureFeaturesKHR structures;
    VkPhysicalDeviceRayQueryFeaturesKHR rays;
    const char *extensions[8];
    uint32_t extension_count;
};

static bool has_extension(const struct xr *x, const char *name) {
    enum { MOST = 512 };
    static VkExtensionProperties all[MOST];
    LOAD(x, EnumerateDeviceExtensionProperties);
    uint32_t count = MOST;
    if (EnumerateDeviceExtensionProperties(x->physical, NULL, &count, all) < 0) return false;
    for (uint32_t i = 0; i < count; i++)
        if (strcmp(all[i].extensionName, name) == 0) return true;
    return false;
}

static void choose_features(const struct xr *x, struct features *f) {
    LOAD(x, GetPhysicalDeviceFeatures2);
    *f = (struct features){.mesh = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MESH_SHADER_FEATURES_EXT},
                           .structures = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ACCELERATION_STRUCTURE_FEATURES_KHR},
                           .rays = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_RAY_QUERY_FEATURES_KHR}};
    fnl_vulkan_requirements_init(&f->all);
    VkPhysicalDeviceVulkan12Features has_12 = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES};
    VkPhysicalDeviceVulkan11Features has_11 = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_1_FEATURES, .pNext = &has_12};
    VkPhysicalDeviceFeatures2 has = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2, .pNext = &has_11};
    void *more = NULL;
    const bool mesh = has_extension(x, VK_EXT_MESH_SHADER_EXTENSION_NAME),
               rays = has_extension(x, VK_KHR_RAY_QUERY_EXTENSION_NAME) && has_extension(x, VK_KHR_ACCELERATION_STRUCTURE_EXTENSION_NAME) &&
                      has_extension(x, VK_KHR_DEFERRED_HOST_OPERATIONS_EXTENSION_NAME);
    VkPhysicalDeviceMeshShaderFeaturesEXT has_mesh = f->mesh;
    VkPhysicalDeviceAccelerationStructureFeaturesKHR has_structures = f->structures;
    VkPhysicalDeviceRayQueryFeaturesKHR has_rays = f->rays;
    if (mesh) has_mesh.pNext = more, more = &has_mesh;
    if (rays) has_structures.pNext = more, has_rays.pNext = &has_structures, more = &has_rays;
    has_12.pNext = more;
    GetPhysicalDeviceFeatures2(x->physical, &has);
    f->all.features.features.geometryShader = has.features.geometryShader;
    f->all.features.features.pipelineStatisticsQuery = has.features.pipelineStatisticsQuery;
    f->all.features.features.shaderClipDistance = has.features.shaderClipDistance;
    f->all.features.features.textureCompressionBC = has.features.textureCompressionBC;
    f->all.features_11.multiview = has_11.multiview;
    f->all.features_12.shaderOutputLayer = has_12.shaderOutputLayer;
    f->all.features_12.samplerFilterMinmax = has_12.samplerFilterMinmax;
    void **end = &f->all.features_13.pNext;
    if (mesh && has_mesh.meshShader) {
        f->mesh.meshShader = VK_TRUE;
        f->mesh.taskShader = has_mesh.taskShader;
        f->extensions[f->extension_count++] = VK_EXT_MESH_SHADER_EXTENSION_NAME;
        *end = &f->mesh;
        end = &f->mesh.pNext;
    }
    if (rays && has_structures.accelerationStructure && has_rays.rayQuery) {
        f->structures.accelerationStructure = VK_TRUE;
        f->rays.rayQuery = VK_TRUE;
        f->extensions[f->extension_count++] = VK_KHR_RAY_QUERY_EXTENSION_NAME;
        f->extensions[f->extension_count++] = VK_KHR_ACCELERATION_STRUCTURE_EXTENSION_NAME;
        f->extensions[f->extension_count++] = VK_KHR_DEFERRED_HOST_OPERATIONS_EXTENSION_NAME;
        *end = &f->structures;
        f->structures.pNext = &f->rays;
    }
    if (has_extension(x, VK_EXT_CONSERVATIVE_RASTERIZATION_EXTENSION_NAME)) f->extensions[f->extension_count++] = VK_EXT_CONSERVATIVE_RASTERIZATION_EXTENSION_NAME;
    if (has_extension(x, VK_EXT_POST_DEPTH_COVERAGE_EXTENSION_NAME)) f->extensions[f->extension_count++] = VK_EXT_POST_DEPTH_COVERAGE_EXTENSION_NAME;
}

static bool find_queue(struct xr *x) {
    LOAD(x, GetPhysicalDeviceQueueFamilyProperties);
    VkQueueFamilyProperties families[32];
    uint32_t count = 32;
    GetPhysicalDeviceQueueFamilyProperties(x->physical, &count, families);
    const VkQueueFlags both = VK_QUEUE_GRAPHICS_BIT | VK_QUEUE_COMPUTE_BIT;
    for (x->family = 0; x->family < count; x->family++)
        if ((families[x->family].queueFlags & both) == both) return true;
    return fail(x, "the headset's Vulkan device has no queue for both graphics and compute");
}

static bool create_device(struct xr *x, struct features *features, VkDeviceCreateInfo *info, VkDeviceQueueCreateInfo *queue, const float *priority) {
    LOAD_XR(x, xrGetVulkanGraphicsDevice2KHR);
    const XrVulkanGraphicsDeviceGetInfoKHR get = {.type = XR_TYPE_VULKAN_GRAPHICS_DEVICE_GET_INFO_KHR, .systemId = x->system, .vulkanInstance = x->vulkan};
    if (!xr_good(x, "xrGetVulkanGraphicsDevice2KHR", xrGetVulkanGraphicsDevice2KHR(x->instance, &get, &x->physical)) || !find_queue(x)) return false;
    choose_features(x, features);
    *queue = (VkDeviceQueueCreateInfo){.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO, .queueFamilyIndex = x->family, .queueCount = 1, .pQueuePriorities = priority};
    *info = (VkDeviceCreateInfo){.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
                                 .pNext = &features->all.features,
                                 .queueCreateInfoCount = 1,
                                 .pQueueCreateInfos = queue,
                                 .enabledExtensionCount = features->extension_count,
                                 .ppEnabledExtensionNames = features->extensions};
    const XrVulkanDeviceCreateInfoKHR create = {.type = XR_TYPE_VULKAN_DEVICE_CREATE_INFO_KHR,
                                                .systemId = x->system,
                                                .pfnGetInstanceProcAddr = x->get_proc,
                                                .vulkanPhysicalDevice = x->physical,
                                                .vulkanCreateInfo = info};
    VkResult result = VK_SUCCESS;
    LOAD_XR(x, xrCreateVulkanDeviceKHR);
    if (!xr_good(x, "xrCreateVulkanDeviceKHR", xrCreateVulkanDeviceKHR(x->instance, &create, &x->vk_device, &result))) {
        x->vk_device = VK_NULL_HANDLE;
        return false;
    }
    if (result == VK_SUCCESS) return true;
    x->vk_device = VK_NULL_HANDLE;
    VkPhysicalDeviceProperties properties;
    LOAD(x, GetPhysicalDeviceProperties);
    GetPhysicalDeviceProperties(x->physical, &properties);
    fprintf(stderr, "fanal: error: vkCreateDevice, called by the OpenXR runtime: VkResult %d%s; the device is %s\n", (int)result,
            result == VK_ERROR_FEATURE_NOT_PRESENT ? ": it lacks something that Fanal needs ('fanal devices' says what)" : "", properties.deviceName);
    x->end = XR_FAILED;
    return false;
}

bool xr_open_device(struct xr *x) {
    if (!x->vulkan_library) x->vulkan_library = dlopen("libvulkan.so.1", RTLD_NOW | RTLD_LOCAL);
    if (x->vulkan_library) *(void **)&x->get_proc = dlsym(x->vulkan_library, "vkGetInstanceProcAddr");
    if (!x->get_proc) return fail(x, "there is no Vulkan loader (Debian: libvulkan1)");
    struct features features;
    VkDeviceCreateInfo created;
    VkDeviceQueueCreateInfo queue;
    const float priority = 1;
    if (!check_requirements(x) || !create_instance(x) || !create_device(x, &features, &created, &queue, &priority)) return false;
    LOAD(x, GetDeviceQueue);
    GetDeviceQueue(x->vk_device, x->family, 0, &x->queue);
    fnl_device_params params = fnl_device_params_default();
    params.host = x->host;
    params.validate = x->options->validate;
    if (x->options->no_cache) params.cache_folder = "";
    const fnl_vulkan_import import = {.get_instance_proc_addr = x->get_proc,
                                      .instance = x->vulkan,
                                      .physical_device = x->physical,
                                      .device = x->vk_device,
                                      .graphics_family = x->family,
                                      .graphics_queue = x->queue,
                                      .created = &created};
    if (fnl_device_import(&params, &import, &x->device) == FNL_OK && fnl_device_query_info(x->device, &x->device_info) == FNL_OK) return true;
    x->end = XR_FAILED; /* the library has told why */
    return false;
}

void xr_close_device(struct xr *x) {
    if (x->device && x->options->validate && fnl_device_validation_count(x->device)) {
        fprintf(stderr, "fanal: error: Vulkan validation sent %llu messages\n", (unsigned long long)fnl_device_validation_count(x->device));
        x->end = XR_FAILED;
    }
    fnl_device_destroy(&x->device);
    if (x->vk_device) {
        LOAD(x, DestroyDevice);
        DestroyDevice(x->vk_device, NULL);
    }
    if (x->vulkan) {
        LOAD(x, DestroyInstance);
        DestroyInstance(x->vulkan, NULL);
    }
    x->vk_device = VK_NULL_HANDLE;
    x->vulkan = VK_NULL_HANDLE;
}
