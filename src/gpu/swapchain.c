/* SPDX-License-Identifier: MIT */
/** The pictures of a window. */
#include "base/check.h"
#include "fanal/vulkan.h"
#include "gpu/gpu_internal.h"

enum {
    SWAPCHAIN_IMAGES = 16, /* more are not used */
    /* A semaphore that was waited for is free again when its frame is over: when the second frame after it begins. */
    SWAPCHAIN_ACQUIRES = GPU_FRAMES_IN_FLIGHT + 1,
};

struct fnl_swapchain {
    fnl_device *device;
    struct gpu_swapchain_functions vk;
    VkSurfaceKHR surface;
    fnl_swapchain_params params;
    bool stale; /* the chain is to be made anew before the next picture */
    VkSwapchainKHR handle;
    VkSurfaceFormatKHR format;
    fnl_color_space color;
    VkExtent2D extent;
    VkPresentModeKHR mode;
    uint32_t image_count, made;
    VkImage images[SWAPCHAIN_IMAGES];
    VkSemaphore finished[SWAPCHAIN_IMAGES]; /* by image: it was rendered */
    VkSemaphore acquired[SWAPCHAIN_ACQUIRES];
    uint32_t acquire, image; /* the current ones */
    bool holds_image;
};

fnl_result fnl_device_query_vulkan(const fnl_device *device, fnl_vulkan_handles *out) {
    TRY(check_handle(__func__, "device", device));
    TRY(check_pointer(CALL(&device->host), "out", out));
    *out = (fnl_vulkan_handles){.get_instance_proc_addr = device->instance.get_proc,
                                .instance = device->instance.handle,
                                .physical_device = device->physical,
                                .device = device->handle,
                                .graphics_family = device->queues[GPU_QUEUE_GRAPHICS].family,
                                .graphics_queue = device->queues[GPU_QUEUE_GRAPHICS].handle};
    return FNL_OK;
}

fnl_swapchain_params fnl_swapchain_params_default(void) { return (fnl_swapchain_params){.width = 1280, .height = 720}; }

static fnl_result check_params(const struct call *call, const fnl_swapchain_params *params) {
    TRY(check_count(call, "width", params->width, 0, 16384));
    TRY(check_count(call, "height", params->height, 0, 16384));
    TRY(check_enum(call, "color", (int64_t)params->color, FNL_COLOR_SPACE_COUNT, "fnl_color_space"));
    return check_enum(call, "present", (int64_t)params->present, FNL_PRESENT_COUNT, "fnl_present");
}

/* ---- the chain ---- */

static bool load_functions(fnl_swapchain *s) {
    const struct gpu_instance *instance = &s->device->instance;
    const char *missing = NULL;
#define LOAD(name)                                                                                                          \
    s->vk.name = (PFN_vk##name)instance->get_proc(instance->handle, "vk" #name);                                            \
    if (!s->vk.name) missing = "vk" #name;
    GPU_INSTANCE_SURFACE_FUNCTIONS(LOAD)
#undef LOAD
#define LOAD(name)                                                                                                          \
    s->vk.name = (PFN_vk##name)instance->vk.GetDeviceProcAddr(s->device->handle, "vk" #name);                               \
    if (!s->vk.name) missing = "vk" #name;
    GPU_DEVICE_SWAPCHAIN_FUNCTIONS(LOAD)
#undef LOAD
    if (missing) log_error(&s->device->host, "fnl_swapchain_create: the device was made without presentation: it has no %s", missing);
    return !missing;
}

static fnl_result create_semaphore(gpu_device *device, const char *name, VkSemaphore *out) {
    VkSemaphoreCreateInfo info = {.sType = VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO};
    TRY(gpu_check(device, device->vk.CreateSemaphore(device->handle, &info, NULL, out), "vkCreateSemaphore"));
    gpu_name(device, VK_OBJECT_TYPE_SEMAPHORE, (uint64_t)*out, name);
    return FNL_OK;
}

/* What was asked for where there is such a format, else 8 bits of sRGB. */
static fnl_result choose_format(fnl_swapchain *s) {
    gpu_device *device = s->device;
    VkSurfaceFormatKHR formats[128];
    uint32_t count = COUNT_OF(formats);
    VkResult result = s->vk.GetPhysicalDeviceSurfaceFormatsKHR(device->physical, s->surface, &count, formats);
    TRY(gpu_check(device, result, "vkGetPhysicalDeviceSurfaceFormatsKHR"));
    static const struct {
        fnl_color_space color;
        VkSurfaceFormatKHR format;
    } known[] = {{FNL_COLOR_SCRGB, {VK_FORMAT_R16G16B16A16_SFLOAT, VK_COLOR_SPACE_EXTENDED_SRGB_LINEAR_EXT}},
                 {FNL_COLOR_HDR10, {VK_FORMAT_A2B10G10R10_UNORM_PACK32, VK_COLOR_SPACE_HDR10_ST2084_EXT}},
                 {FNL_COLOR_HDR10, {VK_FORMAT_A2R10G10B10_UNORM_PACK32, VK_COLOR_SPACE_HDR10_ST2084_EXT}},
                 {FNL_COLOR_SRGB, {VK_FORMAT_B8G8R8A8_UNORM, VK_COLOR_SPACE_SRGB_NONLINEAR_KHR}},
                 {FNL_COLOR_SRGB, {VK_FORMAT_R8G8B8A8_UNORM, VK_COLOR_SPACE_SRGB_NONLINEAR_KHR}},
                 {FNL_COLOR_SRGB, {VK_FORMAT_B8G8R8A8_SRGB, VK_COLOR_SPACE_SRGB_NONLINEAR_KHR}},
                 {FNL_COLOR_SRGB, {VK_FORMAT_R8G8B8A8_SRGB, VK_COLOR_SPACE_SRGB_NONLINEAR_KHR}}};
    for (uint32_t k = 0; k < COUNT_OF(known); k++) {
        if (known[k].color != FNL_COLOR_SRGB && known[k].color != s->params.color) continue;
        for (uint32_t i = 0; i < count; i++) {
            if (formats[i].format != known[k].format.format || formats[i].colorSpace != known[k].format.colorSpace) continue;
            s->format = formats[i];
            s->color = known[k].color;
            return FNL_OK;
        }
    }
    log_error(&device->host, "the window's surface has no format that Fanal writes: none of its %u is 8-bit RGBA or BGRA in sRGB", count);
    return FNL_ERROR_UNSUPPORTED;
}

static fnl_result choose_mode(fnl_swapchain *s) {
    static const VkPresentModeKHR modes[FNL_PRESENT_COUNT] = {VK_PRESENT_MODE_FIFO_KHR, VK_PRESENT_MODE_MAILBOX_KHR, VK_PRESENT_MODE_IMMEDIATE_KHR};
    VkPresentModeKHR found[16];
    uint32_t count = COUNT_OF(found);
    VkResult result = s->vk.GetPhysicalDeviceSurfacePresentModesKHR(s->device->physical, s->surface, &count, found);
    TRY(gpu_check(s->device, result, "vkGetPhysicalDeviceSurfacePresentModesKHR"));
    s->mode = VK_PRESENT_MODE_FIFO_KHR;
    for (uint32_t i = 0; i < count; i++)
        if (found[i] == modes[s->params.present]) s->mode = found[i];
    return FNL_OK;
}

static VkExtent2D choose_extent(const fnl_swapchain *s, const VkSurfaceCapabilitiesKHR *surface) {
    if (s->params.width == 0 || s->params.height == 0) return (VkExtent2D){0, 0};
    if (surface->currentExtent.width != UINT32_MAX) return surface->currentExtent;
    return (VkExtent2D){MIN(MAX(s->params.width, surface->minImageExtent.width), surface->maxImageExtent.width),
                        MIN(MAX(s->params.height, surface->minImageExtent.height), surface->maxImageExtent.height)};
}

/* What is on its way to the screen is waited for. */
static void drop_chain(fnl_swapchain *s) {
    gpu_device *device = s->device;
    gpu_wait_idle(device);
    pthread_mutex_lock(&device->queue_mutex);
    device->vk.DeviceWaitIdle(device->handle);
    pthread_mutex_unlock(&device->queue_mutex);
    for (uint32_t i = 0; i < s->image_count; i++) device->vk.DestroySemaphore(device->handle, s->finished[i], NULL);
    for (uint32_t i = 0; i < SWAPCHAIN_ACQUIRES; i++) device->vk.DestroySemaphore(device->handle, s->acquired[i], NULL);
    memset(s->finished, 0, sizeof s->finished);
    memset(s->acquired, 0, sizeof s->acquired);
    s->image_count = 0;
    s->extent = (VkExtent2D){0, 0};
    s->holds_image = false;
}

static fnl_result fill_chain(fnl_swapchain *s, VkSwapchainKHR old, const VkSurfaceCapabilitiesKHR *surface) {
    gpu_device *device = s->device;
    uint32_t wanted = MAX(surface->minImageCount + 1, 3u);
    if (surface->maxImageCount > 0) wanted = MIN(wanted, surface->maxImageCount);
    static const VkCompositeAlphaFlagBitsKHR alphas[] = {VK_COMPOSITE_ALPHA_OPAQUE_BIT_KHR, VK_COMPOSITE_ALPHA_INHERIT_BIT_KHR,
                                                         VK_COMPOSITE_ALPHA_PRE_MULTIPLIED_BIT_KHR, VK_COMPOSITE_ALPHA_POST_MULTIPLIED_BIT_KHR};
    VkCompositeAlphaFlagBitsKHR alpha = alphas[0];
    for (uint32_t i = COUNT_OF(alphas); i-- > 0;)
        if (surface->supportedCompositeAlpha & alphas[i]) alpha = alphas[i];
    VkSwapchainCreateInfoKHR info = {.sType = VK_STRUCTURE_TYPE_SWAPCHAIN_CREATE_INFO_KHR,
                                     .surface = s->surface,
                                     .minImageCount = wanted,
                                     .imageFormat = s->format.format,
                                     .imageColorSpace = s->format.colorSpace,
                                     .imageExtent = s->extent,
                                     .imageArrayLayers = 1,
                                     .imageUsage = VK_IMAGE_USAGE_TRANSFER_DST_BIT,
                                     .preTransform = surface->currentTransform,
                                     .compositeAlpha = alpha,
                                     .presentMode = s->mode,
                                     .clipped = VK_TRUE,
                                     .oldSwapchain = old};
    TRY(gpu_check(device, s->vk.CreateSwapchainKHR(device->handle, &info, NULL, &s->handle), "vkCreateSwapchainKHR"));
    uint32_t count = SWAPCHAIN_IMAGES;
    VkResult result = s->vk.GetSwapchainImagesKHR(device->handle, s->handle, &count, s->images);
    TRY(gpu_check(device, result, "vkGetSwapchainImagesKHR"));
    if (result == VK_INCOMPLETE) {
        log_error(&device->host, "the swapchain has more than %d images", SWAPCHAIN_IMAGES);
        return FNL_ERROR_UNSUPPORTED;
    }
    for (s->image_count = 0; s->image_count < count; s->image_count++)
        TRY(create_semaphore(device, "picture finished", &s->finished[s->image_count]));
    for (uint32_t i = 0; i < SWAPCHAIN_ACQUIRES; i++) TRY(create_semaphore(device, "picture acquired", &s->acquired[i]));
    s->made++;
    return FNL_OK;
}

static fnl_result make_chain(fnl_swapchain *s) {
    gpu_device *device = s->device;
    VkSurfaceCapabilitiesKHR surface;
    if (s->handle) drop_chain(s);
    VkResult result = s->vk.GetPhysicalDeviceSurfaceCapabilitiesKHR(device->physical, s->surface, &surface);
    TRY(gpu_check(device, result, "vkGetPhysicalDeviceSurfaceCapabilitiesKHR"));
    s->extent = choose_extent(s, &surface);
    if (s->extent.width == 0 || s->extent.height == 0) return FNL_OK; /* stays stale: asked again for the next picture */
    if (!(surface.supportedUsageFlags & VK_IMAGE_USAGE_TRANSFER_DST_BIT)) {
        log_error(&device->host, "pictures cannot be copied to the window's surface");
        return FNL_ERROR_UNSUPPORTED;
    }
    TRY(choose_format(s));
    TRY(choose_mode(s));
    VkSwapchainKHR old = s->handle;
    s->handle = VK_NULL_HANDLE;
    fnl_result filled = fill_chain(s, old, &surface);
    if (old) s->vk.DestroySwapchainKHR(device->handle, old, NULL);
    s->stale = filled != FNL_OK;
    if (filled != FNL_OK) s->extent = (VkExtent2D){0, 0};
    return filled;
}

/* ---- calls ---- */

fnl_result fnl_swapchain_create(fnl_device *device, VkSurfaceKHR surface, const fnl_swapchain_params *params, fnl_swapchain **out) {
    TRY(check_handle(__func__, "device", device));
    const struct call *call = CALL(&device->host);
    fnl_swapchain_params defaults = fnl_swapchain_params_default();
    if (!params) params = &defaults;
    TRY(check_pointer(call, "out", out));
    *out = NULL;
    if (surface == VK_NULL_HANDLE) return misuse(call, "surface is NULL");
    fnl_swapchain made = {.device = device, .surface = surface, .params = *params, .stale = true};
    fnl_result result = check_params(call, params);
    if (!load_functions(&made)) return FNL_ERROR_UNSUPPORTED; /* such a device has no surfaces either */
    if (result == FNL_OK) {
        VkBool32 shows = VK_FALSE;
        VkResult asked = made.vk.GetPhysicalDeviceSurfaceSupportKHR(device->physical, device->queues[GPU_QUEUE_GRAPHICS].family, surface, &shows);
        result = gpu_check(device, asked, "vkGetPhysicalDeviceSurfaceSupportKHR");
        if (result == FNL_OK && !shows) {
            log_error(&device->host, "%s cannot show pictures in this window", device->info.name);
            result = FNL_ERROR_UNSUPPORTED;
        }
    }
    fnl_swapchain *s = result == FNL_OK ? host_allocate(&device->host, sizeof *s) : NULL;
    if (!s) {
        made.vk.DestroySurfaceKHR(device->instance.handle, surface, NULL);
        return result == FNL_OK ? FNL_ERROR_MEMORY : result;
    }
    *s = made;
    result = make_chain(s);
    if (result != FNL_OK) fnl_swapchain_destroy(&s);
    *out = s;
    return result;
}

void fnl_swapchain_destroy(fnl_swapchain **address) {
    if (!address || !*address) return;
    fnl_swapchain *s = *address;
    *address = NULL;
    const fnl_host host = s->device->host;
    drop_chain(s);
    if (s->handle) s->vk.DestroySwapchainKHR(s->device->handle, s->handle, NULL);
    s->vk.DestroySurfaceKHR(s->device->instance.handle, s->surface, NULL);
    host_free(&host, s, sizeof *s);
}

fnl_result fnl_swapchain_set(fnl_swapchain *s, const fnl_swapchain_params *params) {
    TRY(check_handle(__func__, "swapchain", s));
    const struct call *call = CALL(&s->device->host);
    TRY(check_pointer(call, "params", params));
    TRY(check_params(call, params));
    const fnl_swapchain_params *old = &s->params;
    s->stale |= old->width != params->width || old->height != params->height || old->present != params->present || old->color != params->color;
    s->params = *params;
    return FNL_OK;
}

static void hand_out(const fnl_swapchain *s, fnl_vulkan_target *out) {
    *out = (fnl_vulkan_target){.image = s->images[s->image],
                               .format = s->format.format,
                               .initial_layout = VK_IMAGE_LAYOUT_UNDEFINED,
                               .final_layout = VK_IMAGE_LAYOUT_PRESENT_SRC_KHR,
                               .wait = s->acquired[s->acquire],
                               .signal = s->finished[s->image],
                               .width = s->extent.width,
                               .height = s->extent.height};
}

fnl_result fnl_swapchain_acquire(fnl_swapchain *s, fnl_vulkan_target *out) {
    TRY(check_handle(__func__, "swapchain", s));
    gpu_device *device = s->device;
    TRY(check_pointer(CALL(&device->host), "out", out));
    *out = (fnl_vulkan_target){0};
    for (uint32_t attempt = 0; attempt < 4; attempt++) {
        if (s->stale) TRY(make_chain(s));
        if (s->extent.width == 0 || s->extent.height == 0) return FNL_OK;
        if (!s->holds_image) {
            uint32_t next = (s->acquire + 1) % SWAPCHAIN_ACQUIRES;
            VkResult result = s->vk.AcquireNextImageKHR(device->handle, s->handle, UINT64_MAX, s->acquired[next], VK_NULL_HANDLE, &s->image);
            s->stale = result == VK_ERROR_OUT_OF_DATE_KHR; /* a suboptimal one is shown first: it is there already */
            if (s->stale) continue;
            TRY(gpu_check(device, result, "vkAcquireNextImageKHR"));
            s->acquire = next;
            s->holds_image = true;
        }
        hand_out(s, out);
        return FNL_OK;
    }
    s->stale = true; /* the window changes faster than pictures are made for it */
    return FNL_OK;
}

fnl_result fnl_swapchain_present(fnl_swapchain *s) {
    TRY(check_handle(__func__, "swapchain", s));
    gpu_device *device = s->device;
    if (!s->holds_image) return misuse(CALL(&device->host), "there is no picture of fnl_swapchain_acquire");
    VkPresentInfoKHR info = {.sType = VK_STRUCTURE_TYPE_PRESENT_INFO_KHR,
                             .waitSemaphoreCount = 1,
                             .pWaitSemaphores = &s->finished[s->image],
                             .swapchainCount = 1,
                             .pSwapchains = &s->handle,
                             .pImageIndices = &s->image};
    pthread_mutex_lock(&device->queue_mutex);
    VkResult result = s->vk.QueuePresentKHR(device->queues[GPU_QUEUE_GRAPHICS].handle, &info);
    pthread_mutex_unlock(&device->queue_mutex);
    s->holds_image = false;
    if (result == VK_SUBOPTIMAL_KHR || result == VK_ERROR_OUT_OF_DATE_KHR) {
        s->stale = true;
        return FNL_OK;
    }
    return gpu_check(device, result, "vkQueuePresentKHR");
}

fnl_result fnl_swapchain_query_info(const fnl_swapchain *s, fnl_swapchain_info *out) {
    TRY(check_handle(__func__, "swapchain", s));
    TRY(check_pointer(CALL(&s->device->host), "out", out));
    *out = (fnl_swapchain_info){.made = s->made};
    if (s->image_count == 0) return FNL_OK;
    out->width = s->extent.width;
    out->height = s->extent.height;
    out->image_count = s->image_count;
    out->format = s->format.format;
    out->present = s->mode == VK_PRESENT_MODE_MAILBOX_KHR     ? FNL_PRESENT_MAILBOX
                   : s->mode == VK_PRESENT_MODE_IMMEDIATE_KHR ? FNL_PRESENT_IMMEDIATE
                                                              : FNL_PRESENT_FIFO;
    out->color = s->color;
    return FNL_OK;
}
