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
     * shaderClipDistance (clip_distances), textureCompressionBC (texture_compression), multiview, shaderOutputLayer (vertex_layers),
     * pipelineStatisticsQuery (vertex_counts) and samplerFilterMinmax; VK_EXT_mesh_shader with meshShader, VK_EXT_conservative_rasterization and
     * VK_EXT_post_depth_coverage; VK_KHR_ray_query with rayQuery and VK_KHR_acceleration_structure with accelerationStructure (ray_query). With NULL
     * none is.
     */
    const VkDeviceCreateInfo *created;
} fnl_vulkan_import;

/**
 * Like fnl_device_create, on the caller's Vulkan device; `params` may be NULL (its device choice is ignored). FNL_ERROR_DEVICE when the
 * physical device lacks what Fanal needs, FNL_ERROR_UNSUPPORTED when the device was created without it.
 */
FNL_API fnl_result fnl_device_import(const fnl_device_params *params, const fnl_vulkan_import *import, fnl_device **out);

/** A rectangle of the pixels of an image, from its upper left corner. 0 x 0: all of it. */
typedef struct fnl_vulkan_part {
    uint32_t x, y, width, height;
    bool fitted; /**< the picture is scaled to the rectangle; else to the whole image, of which the rectangle shows its own part */
} fnl_vulkan_part;

/** Where a frame goes and how it is ordered against the caller's own work. */
typedef struct fnl_vulkan_target {
    VkImage image; /**< 2D, one sample, one mip, usage TRANSFER_DST; with a layer for each of its views, in their order */
    /**
     * An 8-bit RGBA or BGRA format, UNORM or SRGB: the picture is encoded as sRGB either way; RGBA16_SFLOAT or RGBA32_SFLOAT: radiance times
     * exposure, in linear light, without tone mapping; A2B10G10R10 or A2R10G10B10 UNORM: HDR10 (BT.2020 primaries, ST 2084), where 1 of the
     * former is 203 cd/m^2, and highlights are compressed to at most 1000 cd/m^2.
     */
    VkFormat format;
    VkImageLayout initial_layout; /**< layout on entry; UNDEFINED discards the contents, which is what most want */
    VkImageLayout final_layout;   /**< layout that the image is left in; not UNDEFINED */
    VkSemaphore wait;             /**< waited for before the image is touched, or VK_NULL_HANDLE */
    uint64_t wait_value;          /**< for timeline semaphores */
    VkSemaphore signal;           /**< signalled when the image is finished, or VK_NULL_HANDLE */
    uint64_t signal_value;
    /** Of the image, where that is not the frame's: the picture is scaled to it (bilinear). Frames of one view. 0 x 0: the frame's. */
    uint32_t width, height;
    /**
     * What the call writes of the image, in each of its layers; inside of it. The rest keeps its contents, unless initial_layout is UNDEFINED. An overlay is
     * drawn in the part alone; its places are those of the whole image. Two renderers can fill one image so: the first call waits, the second one signals
     * and has the first's final_layout as its initial_layout. `fitted`: frames of one view, unless the part has the frame's size.
     */
    fnl_vulkan_part part;
    /**
     * Gets the depth of what is seen, for compositors that move the picture to a newer pose; or VK_NULL_HANDLE. 2D, D32_SFLOAT, one sample, one mip, usage
     * TRANSFER_DST, of the size and with the layers of `image`, of which the same part is written. For perspective cameras it is their near distance by the
     * view depth: 1 at the near distance, 0 at infinity and where nothing is. Blended surfaces have none. With MSAA that of the first sample. Not
     * where the picture is scaled.
     */
    VkImage depth;
    VkImageLayout depth_initial_layout, depth_final_layout; /**< as those of `image` */
    bool depth_forward; /**< 1 minus the above: 0 at the near distance. Less precise far away */
} fnl_vulkan_target;

/**
 * Renders one frame into the caller's image; returns once the work is submitted. `frame` as for fnl_renderer_render, but for
 * FNL_OUTPUT_COLOR: the picture is in the image, and fnl_renderer_read has none. After an error nothing was submitted:
 * neither semaphore was touched. The image must live until the frame is over.
 */
FNL_API fnl_result fnl_renderer_render_to(fnl_renderer *renderer, const fnl_frame *frame, const fnl_vulkan_target *target);

/*
 * Windows. The program makes a window and a VkSurfaceKHR for it, with the library of its choice:
 *
 *     fnl_vulkan_handles handles;
 *     fnl_device_query_vulkan(device, &handles);                 // a device with fnl_device_params.presentation
 *     glfwCreateWindowSurface(handles.instance, window, NULL, &surface);
 *     fnl_swapchain_create(device, surface, &params, &swapchain);
 *     for each picture:
 *         fnl_swapchain_acquire(swapchain, &target);
 *         if (target.image) fnl_renderer_render_to(renderer, &frame, &target), fnl_swapchain_present(swapchain);
 */

/** What a device is made of; all stays the device's. */
typedef struct fnl_vulkan_handles {
    PFN_vkGetInstanceProcAddr get_instance_proc_addr;
    VkInstance instance;
    VkPhysicalDevice physical_device;
    VkDevice device;
    uint32_t graphics_family;
    VkQueue graphics_queue; /**< not to be used while a call of Fanal runs */
} fnl_vulkan_handles;

FNL_API fnl_result fnl_device_query_vulkan(const fnl_device *device, fnl_vulkan_handles *out);

/** When a finished picture goes to the screen. */
typedef enum fnl_present {
    FNL_PRESENT_FIFO = 0,  /**< in order, at the screen's refresh: no tearing, and the program waits (vertical synchronisation); every device has it */
    FNL_PRESENT_MAILBOX,   /**< the newest at the refresh; the program does not wait */
    FNL_PRESENT_IMMEDIATE, /**< at once, with tearing */
    FNL_PRESENT_COUNT
} fnl_present;

/** What a window's pictures are encoded as. */
typedef enum fnl_color_space {
    FNL_COLOR_SRGB = 0, /**< 8 bits; every window has it */
    FNL_COLOR_SCRGB,    /**< RGBA16_SFLOAT in linear light, where values above 1 are brighter than white: no tone mapping */
    FNL_COLOR_HDR10,    /**< 10 bits, BT.2020 primaries and ST 2084: no tone mapping */
    FNL_COLOR_SPACE_COUNT
} fnl_color_space;

typedef struct fnl_swapchain_params {
    /** Of the window's picture in pixels, 0 .. 16384; used where the surface has no size of its own. 0: minimised. Default 1280 x 720. */
    uint32_t width, height;
    fnl_present present; /**< FIFO is taken where the surface has no other. Default FIFO */
    fnl_color_space color; /**< sRGB is taken where the surface has no such format. Default sRGB */
} fnl_swapchain_params;

FNL_API fnl_swapchain_params fnl_swapchain_params_default(void);

/** The pictures of a window. Calls on it belong to the thread that renders. */
typedef struct fnl_swapchain fnl_swapchain;

/**
 * `surface` becomes the swapchain's, and is destroyed with it; after an error at once. FNL_ERROR_UNSUPPORTED where the device was made without
 * swapchains or cannot show pictures on this surface.
 */
FNL_API fnl_result fnl_swapchain_create(fnl_device *device, VkSurfaceKHR surface, const fnl_swapchain_params *params, fnl_swapchain **out);
/** Waits for the device. Destroy it before the device. */
FNL_API void fnl_swapchain_destroy(fnl_swapchain **swapchain);
/** Other params, such as a new size: heeded from the next picture on. */
FNL_API fnl_result fnl_swapchain_set(fnl_swapchain *swapchain, const fnl_swapchain_params *params);
/**
 * The next picture of the window, for fnl_renderer_render_to; may wait until one is free. `out->image` is VK_NULL_HANDLE while the window has no area:
 * there is nothing to draw then. A picture that was not presented is handed out again, unless the window has changed meanwhile.
 * FNL_ERROR_DEVICE when the surface is lost: make a new surface and swapchain.
 */
FNL_API fnl_result fnl_swapchain_acquire(fnl_swapchain *swapchain, fnl_vulkan_target *out);
/** Shows the picture of fnl_swapchain_acquire, which was rendered to. */
FNL_API fnl_result fnl_swapchain_present(fnl_swapchain *swapchain);

typedef struct fnl_swapchain_info {
    uint32_t width, height, image_count; /**< 0 before the first picture, or while the window has no area */
    VkFormat format;
    fnl_present present; /**< what is really done */
    fnl_color_space color; /**< likewise */
    uint32_t made; /**< how often the chain was made: once, and once more for each new size */
} fnl_swapchain_info;

FNL_API fnl_result fnl_swapchain_query_info(const fnl_swapchain *swapchain, fnl_swapchain_info *out);

#ifdef __cplusplus
}
#endif
#endif
