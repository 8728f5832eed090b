/* SPDX-License-Identifier: MIT */
#include "gpu/gpu_internal.h"

#include <dlfcn.h>

static const char validation_layer[] = "VK_LAYER_KHRONOS_validation";

/**
 * Layers before 1.3.270 take it that a shader which indexes a descriptor array accesses every image in it, so with bindless
 * arrays each hazard against a shader's image access is suspect (Vulkan-ValidationLayers issue 3450; ended by pull requests
 * 6605 and 6743). All such accesses have "_SHADER_SHADER_" in their names. Attachments, copies and layouts stay checked.
 */
static bool is_false_hazard(const struct gpu_instance *instance, const VkDebugUtilsMessengerCallbackDataEXT *data) {
    return instance->layer_version < VK_MAKE_API_VERSION(0, 1, 3, 270) && data->pMessageIdName &&
           strncmp(data->pMessageIdName, "SYNC-HAZARD-", 12) == 0 && strstr(data->pMessage, "_SHADER_SHADER_");
}

/**
 * Layers from 1.4 on warn of shaders that write locations without an attachment. Such writes are dropped (Vulkan 1.3, "Fragment Output Interface"),
 * and shaders that serve several sets of targets count on it.
 */
static bool is_unused_output(const VkDebugUtilsMessengerCallbackDataEXT *data) {
    return data->pMessageIdName && strstr(data->pMessageIdName, "ShaderOutputNotConsumed");
}

static VKAPI_ATTR VkBool32 VKAPI_CALL on_message(VkDebugUtilsMessageSeverityFlagBitsEXT severity,
                                                 VkDebugUtilsMessageTypeFlagsEXT types,
                                                 const VkDebugUtilsMessengerCallbackDataEXT *data, void *user) {
    UNUSED(types);
    struct gpu_instance *instance = user;
    if (is_false_hazard(instance, data) || is_unused_output(data)) return VK_FALSE;
    char line[1900]; /* the host's log takes lines without breaks */
    size_t length = 0;
    for (const char *text = data->pMessage; *text && length + 1 < sizeof line; text++)
        line[length++] = *text == '\n' ? ' ' : *text;
    line[length] = 0;
    atomic_fetch_add(&instance->message_count, 1);
    bool error = severity & VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT;
    host_log(&instance->host, error ? FNL_LOG_ERROR : FNL_LOG_WARNING, "validation: %s", line);
    return VK_FALSE;
}

static VkDebugUtilsMessengerCreateInfoEXT messenger_info(struct gpu_instance *instance) {
    return (VkDebugUtilsMessengerCreateInfoEXT){
        .sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT,
        .messageSeverity = VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT,
        .messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT,
        .pfnUserCallback = on_message,
        .pUserData = instance,
    };
}

/** The version of Vulkan that the validation layer was made for; 0 when it is not installed. */
static uint32_t find_layer_version(const struct gpu_instance *instance) {
    PFN_vkEnumerateInstanceLayerProperties enumerate =
        (PFN_vkEnumerateInstanceLayerProperties)instance->get_proc(NULL, "vkEnumerateInstanceLayerProperties");
    uint32_t count = 0, version = 0;
    if (!enumerate || enumerate(&count, NULL) != VK_SUCCESS || count == 0) return 0;
    uint32_t capacity = count;
    VkLayerProperties *layers = host_allocate(&instance->host, capacity * sizeof *layers);
    if (!layers) return 0;
    if (enumerate(&count, layers) >= 0) {
        for (uint32_t i = 0; i < count; i++) {
            if (strcmp(layers[i].layerName, validation_layer) == 0) version = layers[i].specVersion;
        }
    }
    host_free(&instance->host, layers, capacity * sizeof *layers);
    return version;
}

static bool has_extension(const struct gpu_instance *instance, const char *layer, const char *name) {
    PFN_vkEnumerateInstanceExtensionProperties enumerate =
        (PFN_vkEnumerateInstanceExtensionProperties)instance->get_proc(NULL, "vkEnumerateInstanceExtensionProperties");
    uint32_t count = 0;
    if (!enumerate || enumerate(layer, &count, NULL) != VK_SUCCESS || count == 0) return false;
    uint32_t capacity = count;
    VkExtensionProperties *extensions = host_allocate(&instance->host, capacity * sizeof *extensions);
    if (!extensions) return false;
    bool found = false;
    if (enumerate(layer, &count, extensions) >= 0) {
        for (uint32_t i = 0; i < count && !found; i++) found = strcmp(extensions[i].extensionName, name) == 0;
    }
    host_free(&instance->host, extensions, capacity * sizeof *extensions);
    return found;
}

static fnl_result load_functions(struct gpu_instance *instance) {
#define LOAD(name)                                                                                                          \
    instance->vk.name = (PFN_vk##name)instance->get_proc(instance->handle, "vk" #name);                                     \
    if (!instance->vk.name) missing = "vk" #name;
    const char *missing = NULL;
    GPU_INSTANCE_FUNCTIONS(LOAD)
    if (missing) {
        log_error(&instance->host, "the Vulkan loader is too old: it has no %s", missing);
        return FNL_ERROR_DEVICE;
    }
    GPU_INSTANCE_DEBUG_FUNCTIONS(LOAD)
#undef LOAD
    return FNL_OK;
}

/* All kinds of surfaces that the loader knows of; returns how many extensions that is, 0: none. */
static uint32_t add_surfaces(const struct gpu_instance *instance, const char *extensions[GPU_SURFACE_EXTENSIONS]) {
    static const char *const kinds[] = {"VK_KHR_xcb_surface",   "VK_KHR_xlib_surface", "VK_KHR_wayland_surface", "VK_EXT_headless_surface",
                                        "VK_KHR_win32_surface", "VK_EXT_metal_surface"};
    _Static_assert(COUNT_OF(kinds) + 2 == GPU_SURFACE_EXTENSIONS, "each kind, and what they stand on");
    if (!has_extension(instance, NULL, VK_KHR_SURFACE_EXTENSION_NAME)) return 0;
    uint32_t count = 0;
    extensions[count++] = VK_KHR_SURFACE_EXTENSION_NAME;
    for (uint32_t i = 0; i < COUNT_OF(kinds); i++)
        if (has_extension(instance, NULL, kinds[i])) extensions[count++] = kinds[i];
    if (has_extension(instance, NULL, VK_EXT_SWAPCHAIN_COLOR_SPACE_EXTENSION_NAME))
        extensions[count++] = VK_EXT_SWAPCHAIN_COLOR_SPACE_EXTENSION_NAME;
    return count;
}

static fnl_result create_instance(struct gpu_instance *instance, const struct gpu_instance_params *params) {
    const bool validate = params->validate, quiet = params->quiet;
    PFN_vkCreateInstance create = (PFN_vkCreateInstance)instance->get_proc(NULL, "vkCreateInstance");
    const char *extensions[2 + GPU_SURFACE_EXTENSIONS];
    const char *layers[] = {validation_layer};
    uint32_t extension_count = 0;
    bool debug = has_extension(instance, NULL, VK_EXT_DEBUG_UTILS_EXTENSION_NAME);
    if (validate) {
        instance->layer_version = find_layer_version(instance);
        if (instance->layer_version == 0) {
            log_error(&instance->host,
                      "validation was asked for, but the layer %s is not installed (Debian: vulkan-validationlayers)",
                      validation_layer);
            return FNL_ERROR_UNSUPPORTED;
        }
        debug |= has_extension(instance, validation_layer, VK_EXT_DEBUG_UTILS_EXTENSION_NAME);
        if (!debug || !has_extension(instance, validation_layer, VK_EXT_VALIDATION_FEATURES_EXTENSION_NAME)) {
            log_error(&instance->host, "validation was asked for, but %s lacks %s or %s", validation_layer,
                      VK_EXT_DEBUG_UTILS_EXTENSION_NAME, VK_EXT_VALIDATION_FEATURES_EXTENSION_NAME);
            return FNL_ERROR_UNSUPPORTED;
        }
        extensions[extension_count++] = VK_EXT_VALIDATION_FEATURES_EXTENSION_NAME;
    }
    if (debug) extensions[extension_count++] = VK_EXT_DEBUG_UTILS_EXTENSION_NAME;
    if (params->presentation) {
        uint32_t count = add_surfaces(instance, extensions + extension_count);
        if (count == 0) {
            log_error(&instance->host, "presentation was asked for, but the Vulkan loader has no %s", VK_KHR_SURFACE_EXTENSION_NAME);
            return FNL_ERROR_UNSUPPORTED;
        }
        extension_count += count;
    }

    VkDebugUtilsMessengerCreateInfoEXT messenger = messenger_info(instance);
    VkValidationFeatureEnableEXT enabled[] = {VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT};
    VkValidationFeaturesEXT features = {
        .sType = VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT,
        .pNext = &messenger,
        .enabledValidationFeatureCount = COUNT_OF(enabled),
        .pEnabledValidationFeatures = enabled,
    };
    VkApplicationInfo application = {
        .sType = VK_STRUCTURE_TYPE_APPLICATION_INFO,
        .pEngineName = "Fanal",
        .engineVersion = VK_MAKE_API_VERSION(0, FNL_VERSION_MAJOR, FNL_VERSION_MINOR, FNL_VERSION_PATCH),
        .apiVersion = VK_API_VERSION_1_3,
    };
    VkInstanceCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO,
        .pNext = validate ? &features : NULL,
        .pApplicationInfo = &application,
        .enabledLayerCount = validate ? 1 : 0,
        .ppEnabledLayerNames = layers,
        .enabledExtensionCount = extension_count,
        .ppEnabledExtensionNames = extensions,
    };
    VkResult result = create ? create(&info, NULL, &instance->handle) : VK_ERROR_INITIALIZATION_FAILED;
    if (result != VK_SUCCESS) {
        instance->handle = VK_NULL_HANDLE;
        bool no_driver = result == VK_ERROR_INCOMPATIBLE_DRIVER;
        if (!no_driver || !quiet) {
            log_error(&instance->host, "Vulkan cannot be started: vkCreateInstance: %s%s", gpu_result_text(result),
                      no_driver ? ", there is no driver (Debian: mesa-vulkan-drivers)" : "");
        }
        return gpu_result_meaning(result);
    }
    instance->owned = true;
    return FNL_OK;
}

static fnl_result create_messenger(struct gpu_instance *instance) {
    VkDebugUtilsMessengerCreateInfoEXT info = messenger_info(instance);
    VkResult result = instance->vk.CreateDebugUtilsMessengerEXT(instance->handle, &info, NULL, &instance->messenger);
    if (result != VK_SUCCESS) {
        log_error(&instance->host, "vkCreateDebugUtilsMessengerEXT: %s", gpu_result_text(result));
        return gpu_result_meaning(result);
    }
    return FNL_OK;
}

fnl_result gpu_instance_open(struct gpu_instance *out, const fnl_host *host, const struct gpu_instance_params *params) {
    const bool quiet = params->quiet;
    *out = (struct gpu_instance){.host = *host};
    out->library = dlopen("libvulkan.so.1", RTLD_NOW | RTLD_LOCAL);
    if (!out->library) {
        if (!quiet) log_error(host, "no Vulkan loader on this machine: %s", dlerror());
        return FNL_ERROR_DEVICE;
    }
    void *symbol = dlsym(out->library, "vkGetInstanceProcAddr");
    if (!symbol) {
        if (!quiet) log_error(host, "libvulkan.so.1 is no Vulkan loader: %s", dlerror());
        return FNL_ERROR_DEVICE;
    }
    memcpy(&out->get_proc, &symbol, sizeof symbol); /* ISO C has no cast from object to function pointer */
    TRY(create_instance(out, params));
    TRY(load_functions(out));
    return params->validate ? create_messenger(out) : FNL_OK;
}

fnl_result gpu_instance_import(struct gpu_instance *out, const fnl_host *host, PFN_vkGetInstanceProcAddr get_proc,
                               VkInstance handle, bool validate) {
    *out = (struct gpu_instance){.host = *host, .get_proc = get_proc, .handle = handle};
    TRY(load_functions(out));
    if (!validate) return FNL_OK;
    if (!out->vk.CreateDebugUtilsMessengerEXT) {
        log_error(host, "validation was asked for, but the imported instance was made without %s",
                  VK_EXT_DEBUG_UTILS_EXTENSION_NAME);
        return FNL_ERROR_UNSUPPORTED;
    }
    out->layer_version = find_layer_version(out);
    return create_messenger(out);
}

void gpu_instance_close(struct gpu_instance *instance) {
    if (instance->messenger) instance->vk.DestroyDebugUtilsMessengerEXT(instance->handle, instance->messenger, NULL);
    if (instance->owned) {
        PFN_vkDestroyInstance destroy = (PFN_vkDestroyInstance)instance->get_proc(instance->handle, "vkDestroyInstance");
        if (destroy) destroy(instance->handle, NULL);
    }
    if (instance->library) dlclose(instance->library);
    *instance = (struct gpu_instance){0};
}
