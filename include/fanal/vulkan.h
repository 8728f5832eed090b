/* SPDX-License-Identifier: MIT */
/**
 * Rendering inside a program that has a Vulkan device of its own: Fanal imports the device and renders into the
 * program's image. The only public header with Vulkan types; link nothing more than the program links already.
 */
#ifndef FANAL_VULKAN_H
#define FANAL_VULKAN_H

#include "fanal/device.h"
#include "fanal/renderer.h"

#include <vulkan/vulkan_core.h>

#ifdef __cplusplus
extern "C" {
#endif

/**
 * Features that a device must be created with, besides Vulkan 1.3 itself. Links the structures into one chain of
 * VkPhysicalDeviceFeatures2; pass `&requirements.features` as pNext of VkDeviceCreateInfo. The struct must not be moved
 * afterwards. Needs no device extension.
 */
typedef struct fnl_vulkan_requirements {
    VkPhysicalDeviceFeatures2 features;
    VkPhysicalDeviceVulkan11Features features_11;
    VkPhysicalDeviceVulkan12Features features_12;
    VkPhysicalDeviceVulkan13Features features_13;
} fnl_vulkan_requirements;

FNL_API void fnl_vulkan_requirements_init(fnl_vulkan_requirements *requirements);

/** The caller's device. All handles stay the caller's and must outlive the fnl_device. */
typedef struct fnl_vulkan_import {
    PFN_vkGetInstanceProcAddr get_instance_proc_addr; /**< required */
    VkInstance instance;
    VkPhysicalDevice physical_device;
    VkDevice device;          /**< made for Vulkan 1.3 with at least the features of fnl_vulkan_requirements_init */
    uint32_t graphics_family; /**< a family with graphics and compute */
    VkQueue graphics_queue;   /**< used only inside Fanal's calls; the caller must not submit to it at the same time */
    uint32_t compute_family;  /**< of compute_queue */
    VkQueue compute_queue;    /**< a second queue for asynchronous compute, or VK_NULL_HANDLE */
    /**
     * What `device` was created with, read during the call alone, or NULL. The features of fnl_vulkan_requirements_init must be on in it, in
     * pEnabledFeatures or VkPhysicalDeviceFeatures2, and in VkPhysicalDeviceVulkan11/12/13Features or the structures of single features;
     * otherwise the import fails with FNL_ERROR_UNSUPPORTED, and the log names those that are off. With NULL the caller vouches for them. Of
     * the optional features (fnl_device_info) those are used that it switches on: geometryShader (primitive_ids),
     * shaderClipDistance (clip_distances), textureCompressionBC (texture_compression), multiview and samplerFilterMinmax; VK_EXT_mesh_shader with
     * meshShader, VK_EXT_conservative_rasterization and VK_EXT_post_depth_coverage; VK_KHR_ray_query with rayQuery and
     * VK_KHR_acceleration_structure with accelerationStructure (ray_query). With NULL none is.
     */
    const VkDeviceCreateInfo *created;
} fnl_vulkan_import;

/**
 * Like fnl_device_create, on the caller's Vulkan device; `params` may be NULL (its device choice is ignored). FNL_ERROR_DEVICE when the
 * physical device lacks what Fanal needs, FNL_ERROR_UNSUPPORTED when the device was created without it.
 */
FNL_API fnl_result fnl_device_import(const fnl_device_params *params, const fnl_vulkan_import *import, fnl_device **out);

/** Where a frame goes and how it is ordered against the caller's own work. */
typedef struct fnl_vulkan_target {
    VkImage image; /**< 2D, one sample, one mip, usage TRANSFER_DST; of the size of the frame; with a layer for each of its views, in their order */
    VkFormat
        format; /**< an 8-bit RGBA or BGRA format, UNORM or SRGB: the picture is sRGB-encoded either way; or RGBA16_SFLOAT / RGBA32_SFLOAT for linear radiance times exposure */
    VkImageLayout initial_layout; /**< layout on entry; UNDEFINED discards the contents, which is what most want */
    VkImageLayout final_layout;   /**< layout that the image is left in; not UNDEFINED */
    VkSemaphore wait;             /**< waited for before the image is touched, or VK_NULL_HANDLE */
    uint64_t wait_value;          /**< for timeline semaphores */
    VkSemaphore signal;           /**< signalled when the image is finished, or VK_NULL_HANDLE */
    uint64_t signal_value;
} fnl_vulkan_target;

/**
 * Renders one frame into the caller's image; returns once the work is submitted. `frame` as for fnl_renderer_render, but for
 * FNL_OUTPUT_COLOR: the picture is in the image, and fnl_renderer_read has none. After an error nothing was submitted:
 * neither semaphore was touched. The image must live until the frame is over.
 */
FNL_API fnl_result fnl_renderer_render_to(fnl_renderer *renderer, const fnl_frame *frame, const fnl_vulkan_target *target);

#ifdef __cplusplus
}
#endif
#endif
