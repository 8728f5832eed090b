/* SPDX-License-Identifier: MIT */
/**
 * The Vulkan functions that Fanal calls, kept per instance and per device. (Not volk's: that defines variables called
 * vkCreateInstance and so on, which would clash with a program that links both the loader and a static libfanal.)
 */
#ifndef FNL_GPU_FUNCTIONS_H
#define FNL_GPU_FUNCTIONS_H

#include <vulkan/vulkan_core.h>

#define GPU_INSTANCE_FUNCTIONS(X)                                                                                           \
    X(DestroyInstance)                                                                                                      \
    X(EnumeratePhysicalDevices)                                                                                             \
    X(EnumerateDeviceExtensionProperties) X(CreateDevice) X(GetDeviceProcAddr) X(GetPhysicalDeviceProperties)               \
        X(GetPhysicalDeviceProperties2) X(GetPhysicalDeviceFeatures2) X(GetPhysicalDeviceMemoryProperties)                  \
            X(GetPhysicalDeviceQueueFamilyProperties) X(GetPhysicalDeviceFormatProperties2)                                 \
                X(GetPhysicalDeviceImageFormatProperties2)

/* Present only with VK_EXT_debug_utils. */
#define GPU_INSTANCE_DEBUG_FUNCTIONS(X) X(CreateDebugUtilsMessengerEXT) X(DestroyDebugUtilsMessengerEXT)

/* Of render passes, see scope.c. */
#define GPU_SCOPE_FUNCTIONS(X)                                                                                              \
    X(CreateRenderPass2)                                                                                                    \
    X(DestroyRenderPass)                                                                                                    \
    X(CreateFramebuffer) X(DestroyFramebuffer) X(CmdBeginRenderPass2) X(CmdNextSubpass2) X(CmdEndRenderPass2)               \
        X(ResetDescriptorPool) X(GetDeviceMemoryCommitment)

#define GPU_DEVICE_FUNCTIONS(X)                                                                                             \
    X(DestroyDevice)                                                                                                        \
    X(DeviceWaitIdle)                                                                                                       \
    X(GetDeviceQueue)                                                                                                       \
    X(QueueSubmit2)                                                                                                         \
    X(AllocateMemory)                                                                                                       \
    X(FreeMemory)                                                                                                           \
    X(MapMemory)                                                                                                            \
    X(CreateBuffer) X(DestroyBuffer) X(BindBufferMemory) X(GetBufferDeviceAddress) X(GetDeviceBufferMemoryRequirements)     \
        X(CreateImage) X(DestroyImage) X(BindImageMemory) X(GetDeviceImageMemoryRequirements) X(CreateImageView) X(         \
            DestroyImageView) X(CreateSampler) X(DestroySampler) X(CreateDescriptorSetLayout) X(DestroyDescriptorSetLayout) \
            X(CreateDescriptorPool) X(DestroyDescriptorPool) X(AllocateDescriptorSets) X(UpdateDescriptorSets)              \
                X(CreatePipelineLayout) X(DestroyPipelineLayout) X(CreatePipelineCache) X(DestroyPipelineCache)             \
                    X(GetPipelineCacheData) X(MergePipelineCaches) X(CreateShaderModule) X(DestroyShaderModule) X(CreateComputePipelines)          \
                        X(CreateGraphicsPipelines) X(DestroyPipeline) X(CreateCommandPool) X(DestroyCommandPool)            \
                            X(ResetCommandPool) X(AllocateCommandBuffers) X(BeginCommandBuffer) X(EndCommandBuffer)         \
                                X(CreateSemaphore) X(DestroySemaphore) X(WaitSemaphores) X(GetSemaphoreCounterValue)        \
                                    X(CreateQueryPool) X(DestroyQueryPool) X(ResetQueryPool) X(GetQueryPoolResults)         \
                                        X(CmdBindPipeline) X(CmdBindDescriptorSets) X(CmdPushConstants) X(CmdDispatch)      \
                                            X(CmdDispatchIndirect) X(CmdBindIndexBuffer) X(CmdDraw)                         \
                                                X(CmdDrawIndexedIndirect) X(CmdDrawIndexedIndirectCount) X(CmdCopyBuffer)   \
                                                    X(CmdFillBuffer) X(CmdCopyBufferToImage) X(CmdCopyImageToBuffer)        \
                                                        X(CmdCopyImage) X(CmdBlitImage) X(CmdBeginRendering)                \
                                                            X(CmdEndRendering) X(CmdSetViewport) X(CmdSetScissor)           \
                                                                X(CmdSetCullMode) X(CmdSetFrontFace)                        \
                                                                X(CmdSetStencilReference) X(CmdClearAttachments)            \
                                                                    X(CmdPipelineBarrier2) X(CmdWriteTimestamp2)            \
                                                                    X(CmdBeginQuery) X(CmdEndQuery)                         \
                                                                        GPU_SCOPE_FUNCTIONS(X)

/* Present only with VK_EXT_mesh_shader. */
#define GPU_DEVICE_MESH_FUNCTIONS(X) X(CmdDrawMeshTasksIndirectEXT)

/* Present only with VK_KHR_acceleration_structure. */
#define GPU_DEVICE_STRUCTURE_FUNCTIONS(X)                                                                                   \
    X(CreateAccelerationStructureKHR)                                                                                       \
    X(DestroyAccelerationStructureKHR)                                                                                      \
    X(GetAccelerationStructureBuildSizesKHR)                                                                                \
    X(GetAccelerationStructureDeviceAddressKHR)                                                                             \
    X(CmdBuildAccelerationStructuresKHR)                                                                                    \
    X(CmdCopyAccelerationStructureKHR) X(CmdWriteAccelerationStructuresPropertiesKHR)

/* Present only with VK_EXT_debug_utils. */
#define GPU_DEVICE_DEBUG_FUNCTIONS(X) X(SetDebugUtilsObjectNameEXT) X(CmdBeginDebugUtilsLabelEXT) X(CmdEndDebugUtilsLabelEXT)

/* Present only with VK_KHR_surface and VK_KHR_swapchain. */
#define GPU_INSTANCE_SURFACE_FUNCTIONS(X)                                                                                   \
    X(DestroySurfaceKHR)                                                                                                    \
    X(GetPhysicalDeviceSurfaceSupportKHR)                                                                                   \
    X(GetPhysicalDeviceSurfaceCapabilitiesKHR) X(GetPhysicalDeviceSurfaceFormatsKHR) X(GetPhysicalDeviceSurfacePresentModesKHR)
#define GPU_DEVICE_SWAPCHAIN_FUNCTIONS(X)                                                                                   \
    X(CreateSwapchainKHR) X(DestroySwapchainKHR) X(GetSwapchainImagesKHR) X(AcquireNextImageKHR) X(QueuePresentKHR)

#define GPU_FUNCTION_MEMBER(name) PFN_vk##name name;
struct gpu_instance_functions {
    GPU_INSTANCE_FUNCTIONS(GPU_FUNCTION_MEMBER)
    GPU_INSTANCE_DEBUG_FUNCTIONS(GPU_FUNCTION_MEMBER)
};
struct gpu_swapchain_functions {
    GPU_INSTANCE_SURFACE_FUNCTIONS(GPU_FUNCTION_MEMBER)
    GPU_DEVICE_SWAPCHAIN_FUNCTIONS(GPU_FUNCTION_MEMBER)
};
struct gpu_device_functions {
    GPU_DEVICE_FUNCTIONS(GPU_FUNCTION_MEMBER)
    GPU_DEVICE_MESH_FUNCTIONS(GPU_FUNCTION_MEMBER)
    GPU_DEVICE_STRUCTURE_FUNCTIONS(GPU_FUNCTION_MEMBER)
    GPU_DEVICE_DEBUG_FUNCTIONS(GPU_FUNCTION_MEMBER)
};
#undef GPU_FUNCTION_MEMBER

#endif
