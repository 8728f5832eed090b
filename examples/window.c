/* SPDX-License-Identifier: MIT */
/*
 * A window of GLFW and a swapchain that Fanal renders into:  window [SCENE [FRAMES]]
 *
 * What to look at: draw() takes an image of the swapchain, hands it to Fanal with two semaphores, and presents it. The CPU never waits
 * for the GPU here: Fanal keeps two frames in flight by itself. When the window changes its size the swapchain is made again; Fanal only
 * needs the new size in the frame. import_device.c tells more about the device.
 */
#include <fanal/fanal.h>
#include <fanal/vulkan.h>

#include <vulkan/vulkan.h>

#include <GLFW/glfw3.h>

#include <stdio.h>
#include <stdlib.h>

enum { IMAGES_MAX = 16, ACQUIRES = 3 }; /* the third frame waits for the first, so its semaphore is free again */

static fnl_vulkan_import vk = {.get_instance_proc_addr = vkGetInstanceProcAddr}; /* instance, device and queue */
static VkSurfaceKHR surface;
static VkSwapchainKHR swapchain;
static VkSurfaceFormatKHR format; /* of its images */
static VkExtent2D extent;
static VkImage images[IMAGES_MAX];
static VkSemaphore acquired[ACQUIRES], finished[IMAGES_MAX]; /* an image may be taken, is finished */

static void check(int failed, const char *what) { /* of VkResult and fnl_result zero is success */
    if (!failed) return;
    fprintf(stderr, "window: %s failed (%d)\n", what, failed);
    exit(1);
}

/* The first device, and its first queue that draws, computes and presents: a program has its own way to choose. */
static void make_device(GLFWwindow *window) {
    VkApplicationInfo application = {.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO, .apiVersion = VK_API_VERSION_1_3};
    VkInstanceCreateInfo instance = {.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO, .pApplicationInfo = &application};
    instance.ppEnabledExtensionNames = glfwGetRequiredInstanceExtensions(&instance.enabledExtensionCount);
    check(vkCreateInstance(&instance, NULL, &vk.instance), "vkCreateInstance");
    check(glfwCreateWindowSurface(vk.instance, window, NULL, &surface), "glfwCreateWindowSurface");
    uint32_t devices = 1, families = 16, *family = &vk.graphics_family;
    check(vkEnumeratePhysicalDevices(vk.instance, &devices, &vk.physical_device) < 0 || devices == 0, "looking for a device");
    VkQueueFamilyProperties properties[16];
    vkGetPhysicalDeviceQueueFamilyProperties(vk.physical_device, &families, properties);
    const VkQueueFlags both = VK_QUEUE_GRAPHICS_BIT | VK_QUEUE_COMPUTE_BIT;
    while (*family < families && ((properties[*family].queueFlags & both) != both ||
                                  !glfwGetPhysicalDevicePresentationSupport(vk.instance, vk.physical_device, *family)))
        ++*family;
    check(*family == families, "looking for a queue");

    fnl_vulkan_requirements requirements; /* what Fanal needs; the extension is the program's own */
    fnl_vulkan_requirements_init(&requirements);
    VkDeviceQueueCreateInfo queue = {.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO,
                                     .queueFamilyIndex = *family,
                                     .queueCount = 1,
                                     .pQueuePriorities = &(float){1}};
    VkDeviceCreateInfo device = {.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
                                 .pNext = &requirements.features,
                                 .queueCreateInfoCount = 1,
                                 .pQueueCreateInfos = &queue,
                                 .enabledExtensionCount = 1,
                                 .ppEnabledExtensionNames = &(const char *){VK_KHR_SWAPCHAIN_EXTENSION_NAME}};
    check(vkCreateDevice(vk.physical_device, &device, NULL, &vk.device), "vkCreateDevice");
    vkGetDeviceQueue(vk.device, *family, 0, &vk.graphics_queue);
}

static void make_semaphores(VkSemaphore *semaphores, uint32_t count) {
    VkSemaphoreCreateInfo info = {.sType = VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO};
    for (uint32_t i = 0; i < count; i++) check(vkCreateSemaphore(vk.device, &info, NULL, &semaphores[i]), "vkCreateSemaphore");
}

static void destroy_semaphores(VkSemaphore *semaphores, uint32_t count) {
    for (uint32_t i = 0; i < count; i++) vkDestroySemaphore(vk.device, semaphores[i], NULL);
}

/* Fanal copies into the images, so they need TRANSFER_DST. The first format of a surface nearly always has 8 bits; with one that is not in fanal/vulkan.h the
 * first frame fails, and the log says so. */
static void make_swapchain(uint32_t width, uint32_t height) {
    VkSurfaceCapabilitiesKHR limits;
    VkSwapchainKHR old = swapchain;
    uint32_t count = 1;
    vkDeviceWaitIdle(vk.device); /* the old images and semaphores are in use until now */
    check(vkGetPhysicalDeviceSurfaceCapabilitiesKHR(vk.physical_device, surface, &limits), "asking for the surface");
    check(vkGetPhysicalDeviceSurfaceFormatsKHR(vk.physical_device, surface, &count, &format) < 0, "asking for a format");
    extent = limits.currentExtent.width != UINT32_MAX ? limits.currentExtent : (VkExtent2D){width, height};
    VkSwapchainCreateInfoKHR info = {.sType = VK_STRUCTURE_TYPE_SWAPCHAIN_CREATE_INFO_KHR,
                                     .surface = surface,
                                     .minImageCount = limits.minImageCount + (limits.minImageCount != limits.maxImageCount),
                                     .imageFormat = format.format,
                                     .imageColorSpace = format.colorSpace,
                                     .imageExtent = extent,
                                     .imageArrayLayers = 1,
                                     .imageUsage = VK_IMAGE_USAGE_TRANSFER_DST_BIT,
                                     .preTransform = limits.currentTransform,
                                     .compositeAlpha = VK_COMPOSITE_ALPHA_OPAQUE_BIT_KHR,
                                     .presentMode = VK_PRESENT_MODE_FIFO_KHR,
                                     .clipped = VK_TRUE,
                                     .oldSwapchain = old};
    check(vkCreateSwapchainKHR(vk.device, &info, NULL, &swapchain), "vkCreateSwapchainKHR");
    vkDestroySwapchainKHR(vk.device, old, NULL);
    count = IMAGES_MAX;
    check(vkGetSwapchainImagesKHR(vk.device, swapchain, &count, images), "vkGetSwapchainImagesKHR");
    destroy_semaphores(finished, IMAGES_MAX);
    make_semaphores(finished, IMAGES_MAX);
}

/* Whether the swapchain still fits the window. */
static int draw(fnl_renderer *renderer, fnl_frame *frame, VkSemaphore wait) {
    uint32_t index;
    VkResult result = vkAcquireNextImageKHR(vk.device, swapchain, UINT64_MAX, wait, VK_NULL_HANDLE, &index);
    if (result == VK_ERROR_OUT_OF_DATE_KHR) return 0; /* the semaphore was not touched */
    check(result < 0 ? result : 0, "vkAcquireNextImageKHR");
    frame->width = extent.width;
    frame->height = extent.height;
    fnl_vulkan_target target = {.image = images[index],
                                .format = format.format,
                                .final_layout = VK_IMAGE_LAYOUT_PRESENT_SRC_KHR,
                                .wait = wait,
                                .signal = finished[index]};
    check((int)fnl_renderer_render_to(renderer, frame, &target), "rendering");
    VkPresentInfoKHR present = {.sType = VK_STRUCTURE_TYPE_PRESENT_INFO_KHR,
                                .waitSemaphoreCount = 1,
                                .pWaitSemaphores = &finished[index],
                                .swapchainCount = 1,
                                .pSwapchains = &swapchain,
                                .pImageIndices = &index};
    result = vkQueuePresentKHR(vk.graphics_queue, &present);
    check(result < 0 && result != VK_ERROR_OUT_OF_DATE_KHR ? result : 0, "vkQueuePresentKHR");
    return result == VK_SUCCESS; /* nor VK_SUBOPTIMAL_KHR */
}

int main(int argc, char **argv) {
    fnl_scene *scene;
    fnl_device *device;
    fnl_renderer *renderer;
    fnl_frame frame = fnl_frame_default();
    frame.shadows = FNL_SHADOWS_OFF; /* maps need shaderClipDistance, which this device has not enabled */
    frame.outputs = 0; /* the picture goes into the window's images */
    check((int)fnl_scene_load(NULL, argc > 1 ? argv[1] : "builtin:spheres", NULL, &scene), "loading the scene");
    check((int)(fnl_scene_count(scene, FNL_ENTITY_CAMERA) ? fnl_scene_query_camera(scene, 0, &frame.camera)
                                                          : fnl_scene_query_framing_camera(scene, 16.0f / 9, &frame.camera)),
          "looking for a camera");
    check(!glfwInit() || !glfwVulkanSupported(), "looking for a display with Vulkan");
    glfwWindowHint(GLFW_CLIENT_API, GLFW_NO_API);
    GLFWwindow *window = glfwCreateWindow(640, 360, "Fanal", NULL, NULL);
    check(!window, "opening a window");
    make_device(window);
    make_semaphores(acquired, ACQUIRES);
    check((int)fnl_device_import(NULL, &vk, &device), "importing the device");
    check((int)fnl_renderer_create(device, scene, &renderer), "making the renderer");
    int fits = 0, width, height;
    uint32_t count = argc > 2 ? (uint32_t)atoi(argv[2]) : UINT32_MAX; /* until the window is closed */
    for (uint32_t number = 0; number < count && !glfwWindowShouldClose(window);) {
        glfwPollEvents();
        glfwGetFramebufferSize(window, &width, &height);
        if (width == 0 || height == 0) { /* minimised: nothing can be drawn until something happens */
            glfwWaitEvents();
            continue;
        }
        if (!fits || extent.width != (uint32_t)width || extent.height != (uint32_t)height)
            make_swapchain((uint32_t)width, (uint32_t)height);
        fits = draw(renderer, &frame, acquired[number++ % ACQUIRES]);
    }
    fnl_renderer_destroy(&renderer); /* waits for its frames */
    fnl_device_destroy(&device);
    fnl_scene_destroy(&scene);
    vkDeviceWaitIdle(vk.device); /* and for the presentation of them */
    destroy_semaphores(acquired, ACQUIRES);
    destroy_semaphores(finished, IMAGES_MAX);
    vkDestroySwapchainKHR(vk.device, swapchain, NULL);
    vkDestroyDevice(vk.device, NULL);
    vkDestroySurfaceKHR(vk.instance, surface, NULL);
    vkDestroyInstance(vk.instance, NULL);
    glfwTerminate();
    return 0;
}
