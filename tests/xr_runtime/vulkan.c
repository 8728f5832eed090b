/* SPDX-License-Identifier: MIT */
/* XR_KHR_vulkan_enable2, and the images of swapchains. */
#include "runtime.h"

#include <stdlib.h>
#include <string.h>

#define VK(name) PFN_vk##name name = (PFN_vk##name)rt.get_proc(rt.vulkan, "vk" #name)

static XRAPI_ATTR XrResult XRAPI_CALL callGetVulkanGraphicsRequirements2KHR(XrInstance instance, XrSystemId system, XrGraphicsRequirementsVulkan2KHR *out) {
    ENTER();
    (void)instance;
    if (system != 1) return mistake(XR_ERROR_SYSTEM_INVALID, "the system is none");
    CHECK_TYPE(out, XR_TYPE_GRAPHICS_REQUIREMENTS_VULKAN2_KHR);
    out->minApiVersionSupported = XR_MAKE_VERSION(1, 1, 0);
    out->maxApiVersionSupported = XR_MAKE_VERSION(1, 3, 0);
    rt.asked_requirements = true;
    return XR_SUCCESS;
}

static XRAPI_ATTR XrResult XRAPI_CALL callCreateVulkanInstanceKHR(XrInstance instance, const XrVulkanInstanceCreateInfoKHR *info, VkInstance *out, VkResult *result) {
    ENTER();
    (void)instance;
    CHECK_TYPE(info, XR_TYPE_VULKAN_INSTANCE_CREATE_INFO_KHR);
    if (!rt.asked_requirements) return mistake(XR_ERROR_GRAPHICS_REQUIREMENTS_CALL_MISSING, "xrGetVulkanGraphicsRequirements2KHR was not called");
    if (!info->pfnGetInstanceProcAddr || !info->vulkanCreateInfo) return mistake(XR_ERROR_VALIDATION_FAILURE, "a pointer is NULL");
    rt.get_proc = info->pfnGetInstanceProcAddr;
    PFN_vkCreateInstance create = (PFN_vkCreateInstance)rt.get_proc(NULL, "vkCreateInstance");
    *result = create(info->vulkanCreateInfo, info->vulkanAllocator, out);
    rt.vulkan = *result == VK_SUCCESS ? *out : VK_NULL_HANDLE;
    return XR_SUCCESS;
}

static XRAPI_ATTR XrResult XRAPI_CALL callGetVulkanGraphicsDevice2KHR(XrInstance instance, const XrVulkanGraphicsDeviceGetInfoKHR *info, VkPhysicalDevice *out) {
    ENTER();
    (void)instance;
    CHECK_TYPE(info, XR_TYPE_VULKAN_GRAPHICS_DEVICE_GET_INFO_KHR);
    if (info->vulkanInstance != rt.vulkan) return mistake(XR_ERROR_HANDLE_INVALID, "another Vulkan instance");
    VK(EnumeratePhysicalDevices);
    uint32_t count = 1;
    if (EnumeratePhysicalDevices(rt.vulkan, &count, &rt.physical) < 0 || count == 0) return XR_ERROR_RUNTIME_FAILURE;
    *out = rt.physical;
    rt.asked_device = true;
    return XR_SUCCESS;
}

static XRAPI_ATTR XrResult XRAPI_CALL callCreateVulkanDeviceKHR(XrInstance instance, const XrVulkanDeviceCreateInfoKHR *info, VkDevice *out, VkResult *result) {
    ENTER();
    (void)instance;
    CHECK_TYPE(info, XR_TYPE_VULKAN_DEVICE_CREATE_INFO_KHR);
    if (info->vulkanPhysicalDevice != rt.physical) return mistake(XR_ERROR_HANDLE_INVALID, "another physical device");
    VK(CreateDevice);
    *result = CreateDevice(rt.physical, info->vulkanCreateInfo, info->vulkanAllocator, out);
    rt.device = *result == VK_SUCCESS ? *out : VK_NULL_HANDLE;
    return XR_SUCCESS;
}

PFN_xrVoidFunction vulkan_function(const char *name) {
    FUNCTION(GetVulkanGraphicsRequirements2KHR, name)
    FUNCTION(CreateVulkanInstanceKHR, name)
    FUNCTION(GetVulkanGraphicsDevice2KHR, name)
    FUNCTION(CreateVulkanDeviceKHR, name)
    return NULL;
}

/* ---- images ---- */

static VkDeviceMemory allocate(const VkMemoryRequirements *needs, VkMemoryPropertyFlags flags) {
    VK(GetPhysicalDeviceMemoryProperties);
    VK(AllocateMemory);
    VkPhysicalDeviceMemoryProperties memory;
    GetPhysicalDeviceMemoryProperties(rt.physical, &memory);
    VkMemoryAllocateInfo info = {.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, .allocationSize = needs->size};
    while (info.memoryTypeIndex < memory.memoryTypeCount &&
           (!(needs->memoryTypeBits >> info.memoryTypeIndex & 1) || (memory.memoryTypes[info.memoryTypeIndex].propertyFlags & flags) != flags))
        info.memoryTypeIndex++;
    VkDeviceMemory out = VK_NULL_HANDLE;
    return AllocateMemory(rt.device, &info, NULL, &out) == VK_SUCCESS ? out : VK_NULL_HANDLE;
}

static VkImageAspectFlags aspect_of(int64_t format) {
    return format == VK_FORMAT_D16_UNORM || format == VK_FORMAT_D32_SFLOAT || format == VK_FORMAT_X8_D24_UNORM_PACK32 ? VK_IMAGE_ASPECT_DEPTH_BIT
           : format > VK_FORMAT_D32_SFLOAT && format <= VK_FORMAT_D32_SFLOAT_S8_UINT ? VK_IMAGE_ASPECT_DEPTH_BIT | VK_IMAGE_ASPECT_STENCIL_BIT
                                                                                      : VK_IMAGE_ASPECT_COLOR_BIT;
}

static VkImageLayout layout_of(const struct swapchain *chain) {
    return chain->is_depth ? VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL : VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL;
}

static VkCommandBuffer begin_commands(void) {
    VK(CreateCommandPool);
    VK(AllocateCommandBuffers);
    VK(BeginCommandBuffer);
    VkCommandPoolCreateInfo pool = {.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO, .queueFamilyIndex = rt.family};
    VkCommandBuffer commands = VK_NULL_HANDLE;
    if (!rt.pool && CreateCommandPool(rt.device, &pool, NULL, &rt.pool) != VK_SUCCESS) return VK_NULL_HANDLE;
    VkCommandBufferAllocateInfo info = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO, .commandPool = rt.pool, .commandBufferCount = 1};
    if (AllocateCommandBuffers(rt.device, &info, &commands) != VK_SUCCESS) return VK_NULL_HANDLE;
    VkCommandBufferBeginInfo begin = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO, .flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT};
    BeginCommandBuffer(commands, &begin);
    return commands;
}

static void end_commands(VkCommandBuffer commands) {
    VK(EndCommandBuffer);
    VK(QueueSubmit);
    VK(QueueWaitIdle);
    VK(FreeCommandBuffers);
    VkSubmitInfo info = {.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO, .commandBufferCount = 1, .pCommandBuffers = &commands};
    EndCommandBuffer(commands);
    QueueSubmit(rt.queue, 1, &info, VK_NULL_HANDLE);
    QueueWaitIdle(rt.queue);
    FreeCommandBuffers(rt.device, rt.pool, 1, &commands);
}

static void change_layout(VkCommandBuffer commands, const struct swapchain *chain, VkImage image, VkImageLayout from, VkImageLayout to) {
    VK(CmdPipelineBarrier);
    VkImageMemoryBarrier barrier = {.sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER,
                                    .srcAccessMask = VK_ACCESS_MEMORY_WRITE_BIT | VK_ACCESS_MEMORY_READ_BIT,
                                    .dstAccessMask = VK_ACCESS_MEMORY_WRITE_BIT | VK_ACCESS_MEMORY_READ_BIT,
                                    .oldLayout = from,
                                    .newLayout = to,
                                    .srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
                                    .dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
                                    .image = image,
                                    .subresourceRange = {aspect_of(chain->info.format), 0, 1, 0, chain->info.arraySize}};
    CmdPipelineBarrier(commands, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, 0, 0, NULL, 0, NULL, 1, &barrier);
}

XrResult images_make(struct swapchain *chain) {
    VK(CreateImage);
    VK(GetImageMemoryRequirements);
    VK(BindImageMemory);
    const XrSwapchainUsageFlags flags = chain->info.usageFlags;
    VkImageCreateInfo info = {.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO,
                              .imageType = VK_IMAGE_TYPE_2D,
                              .format = (VkFormat)chain->info.format,
                              .extent = {chain->info.width, chain->info.height, 1},
                              .mipLevels = 1,
                              .arrayLayers = chain->info.arraySize,
                              .samples = VK_SAMPLE_COUNT_1_BIT,
                              .usage = VK_IMAGE_USAGE_TRANSFER_SRC_BIT};
    if (flags & XR_SWAPCHAIN_USAGE_COLOR_ATTACHMENT_BIT) info.usage |= VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT;
    if (flags & XR_SWAPCHAIN_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT) info.usage |= VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT;
    if (flags & XR_SWAPCHAIN_USAGE_TRANSFER_DST_BIT) info.usage |= VK_IMAGE_USAGE_TRANSFER_DST_BIT;
    if (flags & XR_SWAPCHAIN_USAGE_SAMPLED_BIT) info.usage |= VK_IMAGE_USAGE_SAMPLED_BIT;
    if (flags & XR_SWAPCHAIN_USAGE_UNORDERED_ACCESS_BIT) info.usage |= VK_IMAGE_USAGE_STORAGE_BIT;
    VkCommandBuffer commands = begin_commands();
    if (!commands) return XR_ERROR_RUNTIME_FAILURE;
    for (uint32_t i = 0; i < IMAGES; i++) {
        VkMemoryRequirements needs;
        if (CreateImage(rt.device, &info, NULL, &chain->images[i]) != VK_SUCCESS) return XR_ERROR_RUNTIME_FAILURE;
        GetImageMemoryRequirements(rt.device, chain->images[i], &needs);
        chain->memory[i] = allocate(&needs, 0);
        if (!chain->memory[i] || BindImageMemory(rt.device, chain->images[i], chain->memory[i], 0) != VK_SUCCESS) return XR_ERROR_OUT_OF_MEMORY;
        change_layout(commands, chain, chain->images[i], VK_IMAGE_LAYOUT_UNDEFINED, layout_of(chain));
    }
    end_commands(commands);
    return XR_SUCCESS;
}

void images_free(struct swapchain *chain) {
    VK(DestroyImage);
    VK(FreeMemory);
    VK(DeviceWaitIdle);
    DeviceWaitIdle(rt.device);
    for (uint32_t i = 0; i < IMAGES; i++) {
        DestroyImage(rt.device, chain->images[i], NULL);
        FreeMemory(rt.device, chain->memory[i], NULL);
    }
}

void vulkan_forget(void) {
    if (!rt.pool) return;
    VK(DestroyCommandPool);
    DestroyCommandPool(rt.device, rt.pool, NULL);
    rt.pool = VK_NULL_HANDLE;
}

static uint32_t texel_bytes(int64_t format) { return format == VK_FORMAT_R16G16B16A16_SFLOAT ? 8 : format == VK_FORMAT_D16_UNORM ? 2 : 4; }

bool image_save(const struct swapchain *chain, uint32_t layer, const XrRect2Di *rect, const char *path) {
    VK(CreateBuffer);
    VK(GetBufferMemoryRequirements);
    VK(BindBufferMemory);
    VK(MapMemory);
    VK(CmdCopyImageToBuffer);
    VK(DestroyBuffer);
    VK(FreeMemory);
    const VkDeviceSize size = (VkDeviceSize)rect->extent.width * (uint32_t)rect->extent.height * texel_bytes(chain->info.format);
    VkBufferCreateInfo info = {.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO, .size = size, .usage = VK_BUFFER_USAGE_TRANSFER_DST_BIT};
    VkBuffer buffer;
    VkMemoryRequirements needs;
    void *pixels = NULL;
    if (CreateBuffer(rt.device, &info, NULL, &buffer) != VK_SUCCESS) return false;
    GetBufferMemoryRequirements(rt.device, buffer, &needs);
    VkDeviceMemory memory = allocate(&needs, VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT);
    BindBufferMemory(rt.device, buffer, memory, 0);
    MapMemory(rt.device, memory, 0, size, 0, &pixels);
    VkCommandBuffer commands = begin_commands();
    VkImage image = chain->images[chain->released];
    change_layout(commands, chain, image, layout_of(chain), VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
    VkBufferImageCopy region = {.imageSubresource = {aspect_of(chain->info.format) & ~(VkImageAspectFlags)VK_IMAGE_ASPECT_STENCIL_BIT, 0, layer, 1},
                                .imageOffset = {rect->offset.x, rect->offset.y, 0},
                                .imageExtent = {(uint32_t)rect->extent.width, (uint32_t)rect->extent.height, 1}};
    CmdCopyImageToBuffer(commands, image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, buffer, 1, &region);
    change_layout(commands, chain, image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, layout_of(chain));
    end_commands(commands);
    FILE *file = fopen(path, "wb");
    bool good = file && fwrite(pixels, 1, size, file) == size;
    if (file && fclose(file) != 0) good = false;
    DestroyBuffer(rt.device, buffer, NULL);
    FreeMemory(rt.device, memory, NULL);
    return good;
}
