/* SPDX-License-Identifier: MIT */
/*
 * A window of GLFW and a swapchain that Fanal renders into:  window [SCENE [FRAMES]]
 *
 * What to look at: draw() takes an image of the swapchain, hands it to Fanal with two semaphores, and presents it. The CPU never waits
 * for the GPU here: Fanal keeps two frames in flight by itself. import_device.c tells more about the device.
 */
#include <fanal/fanal.h>
#include <fanal/vulkan.h>

#include <vulkan/vulkan.h>

#include <GLFW/glfw3.h>

#include <stdio.h>
#include <stdlib.h>

enum { IMAGES_MAX = 16, ACQUIRES = 3 }; /* the third frame waits for the first, so its semaphore is free again */

static struct {
    GLFWwindow *window;
    VkInstance instance;
    VkSurfaceKHR surface;
    VkPhysicalDevice physical;
    VkDevice device;
    uint32_t family;
    VkQueue queue;
    VkSwapchainKHR swapchain;
    VkFormat format;
    VkExtent2D extent;
    VkImage images[IMAGES_MAX];
    VkSemaphore acquired[ACQUIRES], finished[IMAGES_MAX]; /* an image may be taken, is finished */
} w;

static void check(int failed, const char *what) { /* of VkResult and fnl_result zero is success */
    if (!failed) return;
    fprintf(stderr, "window: %s failed (%d)\n", what, failed);
    exit(1);
}

static void make_window(void) {
    check(!glfwInit() || !glfwVulkanSupported(), "looking for a display with Vulkan");
    glfwWindowHint(GLFW_CLIENT_API, GLFW_NO_API);
    w.window = glfwCreateWindow(640, 360, "Fanal", NULL, NULL);
    check(!w.window, "opening a window");
    VkApplicationInfo application = {.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO, .apiVersion = VK_API_VERSION_1_3};
    VkInstanceCreateInfo info = {.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO, .pApplicationInfo = &application};
    info.ppEnabledExtensionNames = glfwGetRequiredInstanceExtensions(&info.enabledExtensionCount);
    check(vkCreateInstance(&info, NULL, &w.instance), "vkCreateInstance");
    check(glfwCreateWindowSurface(w.instance, w.window, NULL, &w.surface), "glfwCreateWindowSurface");
}

/* The first device, and its first queue that draws, computes and presents: a program has its own way to choose. */
static void make_device(void) {
    uint32_t count = 1;
    check(vkEnumeratePhysicalDevices(w.instance, &count, &w.physical) < 0 || count == 0, "looking for a Vulkan device");
    VkQueueFamilyProperties families[16];
    VkBool32 presents = VK_FALSE;
    const VkQueueFlags both = VK_QUEUE_GRAPHICS_BIT | VK_QUEUE_COMPUTE_BIT;
    count = 16;
    vkGetPhysicalDeviceQueueFamilyProperties(w.physical, &count, families);
    for (; w.family < count; w.family++) {
        vkGetPhysicalDeviceSurfaceSupportKHR(w.physical, w.family, w.surface, &presents);
        if (presents && (families[w.family].queueFlags & both) == both) break;
    }
    check(w.family == count, "looking for a queue");

    fnl_vulkan_requirements requirements; /* what Fanal needs; the extension is the program's own */
    fnl_vulkan_requirements_init(&requirements);
    float priority = 1;
    const char *extension = VK_KHR_SWAPCHAIN_EXTENSION_NAME;
    VkDeviceQueueCreateInfo queue = {.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO,
                                     .queueFamilyIndex = w.family,
                                     .queueCount = 1,
                                     .pQueuePriorities = &priority};
    VkDeviceCreateInfo info = {.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
                               .pNext = &requirements.features,
                               .queueCreateInfoCount = 1,
                               .pQueueCreateInfos = &queue,
                               .enabledExtensionCount = 1,
                               .ppEnabledExtensionNames = &extension};
    check(vkCreateDevice(w.physical, &info, NULL, &w.device), "vkCreateDevice");
    vkGetDeviceQueue(w.device, w.family, 0, &w.queue);
}

static VkSemaphore make_semaphore(void) {
    VkSemaphoreCreateInfo info = {.sType = VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO};
    VkSemaphore semaphore;
    check(vkCreateSemaphore(w.device, &info, NULL, &semaphore), "vkCreateSemaphore");
    return semaphore;
}

/* Fanal copies into the images, so they need TRANSFER_DST and one of the formats in fanal/vulkan.h. */
static void make_swapchain(void) {
    VkSurfaceCapabilitiesKHR limits;
    VkSurfaceFormatKHR formats[64], chosen = {VK_FORMAT_UNDEFINED, VK_COLOR_SPACE_SRGB_NONLINEAR_KHR};
    uint32_t count = 64;
    int width, height;
    check(vkGetPhysicalDeviceSurfaceCapabilitiesKHR(w.physical, w.surface, &limits), "asking for the surface");
    check(!(limits.supportedUsageFlags & VK_IMAGE_USAGE_TRANSFER_DST_BIT), "looking for images to copy into");
    check(vkGetPhysicalDeviceSurfaceFormatsKHR(w.physical, w.surface, &count, formats) < 0, "asking for formats");
    for (uint32_t i = count; i-- > 0;)
        if (formats[i].colorSpace == chosen.colorSpace &&
            (formats[i].format == VK_FORMAT_B8G8R8A8_UNORM || formats[i].format == VK_FORMAT_R8G8B8A8_UNORM ||
             formats[i].format == VK_FORMAT_B8G8R8A8_SRGB || formats[i].format == VK_FORMAT_R8G8B8A8_SRGB))
            chosen = formats[i];
    check(chosen.format == VK_FORMAT_UNDEFINED, "looking for a format");
    glfwGetFramebufferSize(w.window, &width, &height);
    w.format = chosen.format;
    w.extent = limits.currentExtent.width != UINT32_MAX ? limits.currentExtent : (VkExtent2D){(uint32_t)width, (uint32_t)height};
    VkSwapchainKHR old = w.swapchain;
    VkSwapchainCreateInfoKHR info = {.sType = VK_STRUCTURE_TYPE_SWAPCHAIN_CREATE_INFO_KHR,
                                     .surface = w.surface,
                                     .minImageCount = limits.maxImageCount == 0 || limits.minImageCount < limits.maxImageCount
                                                          ? limits.minImageCount + 1
                                                          : limits.maxImageCount,
                                     .imageFormat = chosen.format,
                                     .imageColorSpace = chosen.colorSpace,
                                     .imageExtent = w.extent,
                                     .imageArrayLayers = 1,
                                     .imageUsage = VK_IMAGE_USAGE_TRANSFER_DST_BIT,
                                     .preTransform = limits.currentTransform,
                                     .compositeAlpha = VK_COMPOSITE_ALPHA_OPAQUE_BIT_KHR,
                                     .presentMode = VK_PRESENT_MODE_FIFO_KHR,
                                     .clipped = VK_TRUE,
                                     .oldSwapchain = old};
    vkDeviceWaitIdle(w.device); /* the old images and semaphores are in use until now */
    check(vkCreateSwapchainKHR(w.device, &info, NULL, &w.swapchain), "vkCreateSwapchainKHR");
    vkDestroySwapchainKHR(w.device, old, NULL);
    count = IMAGES_MAX;
    check(vkGetSwapchainImagesKHR(w.device, w.swapchain, &count, w.images), "vkGetSwapchainImagesKHR");
    for (uint32_t i = 0; i < IMAGES_MAX; i++) {
        vkDestroySemaphore(w.device, w.finished[i], NULL);
        w.finished[i] = i < count ? make_semaphore() : VK_NULL_HANDLE;
    }
}

static void draw(fnl_renderer *renderer, const fnl_camera *camera, uint32_t number) {
    uint32_t index;
    VkSemaphore acquired = w.acquired[number % ACQUIRES];
    VkResult result = vkAcquireNextImageKHR(w.device, w.swapchain, UINT64_MAX, acquired, VK_NULL_HANDLE, &index);
    if (result == VK_ERROR_OUT_OF_DATE_KHR) { /* the window has another size: the next frame has it too */
        make_swapchain();
        return;
    }
    check(result < 0 ? result : 0, "vkAcquireNextImageKHR");
    fnl_frame frame = fnl_frame_default();
    frame.width = w.extent.width;
    frame.height = w.extent.height;
    frame.camera = *camera;
    frame.outputs = 0; /* the picture goes into the image */
    fnl_vulkan_target target = {.image = w.images[index],
                                .format = w.format,
                                .initial_layout = VK_IMAGE_LAYOUT_UNDEFINED,
                                .final_layout = VK_IMAGE_LAYOUT_PRESENT_SRC_KHR,
                                .wait = acquired,
                                .signal = w.finished[index]};
    check((int)fnl_renderer_render_to(renderer, &frame, &target), "rendering");
    VkPresentInfoKHR present = {.sType = VK_STRUCTURE_TYPE_PRESENT_INFO_KHR,
                                .waitSemaphoreCount = 1,
                                .pWaitSemaphores = &w.finished[index],
                                .swapchainCount = 1,
                                .pSwapchains = &w.swapchain,
                                .pImageIndices = &index};
    result = vkQueuePresentKHR(w.queue, &present);
    check(result < 0 && result != VK_ERROR_OUT_OF_DATE_KHR ? result : 0, "vkQueuePresentKHR");
    if (result != VK_SUCCESS) make_swapchain(); /* VK_SUBOPTIMAL_KHR or out of date */
}

int main(int argc, char **argv) {
    fnl_scene *scene;
    fnl_device *device;
    fnl_renderer *renderer;
    fnl_camera camera;
    check((int)fnl_scene_load(NULL, argc > 1 ? argv[1] : "builtin:spheres", NULL, &scene), "loading the scene");
    make_window();
    make_device();
    make_swapchain();
    for (int i = 0; i < ACQUIRES; i++) w.acquired[i] = make_semaphore();
    fnl_vulkan_import handles = {.get_instance_proc_addr = vkGetInstanceProcAddr,
                                 .instance = w.instance,
                                 .physical_device = w.physical,
                                 .device = w.device,
                                 .graphics_family = w.family,
                                 .graphics_queue = w.queue};
    check((int)fnl_device_import(NULL, &handles, &device), "importing the device");
    check((int)fnl_renderer_create(device, scene, &renderer), "making the renderer");
    check((int)(fnl_scene_count(scene, FNL_ENTITY_CAMERA) ? fnl_scene_query_camera(scene, 0, &camera)
                                              : fnl_scene_query_framing_camera(scene, 16.0f / 9, &camera)),
          "looking for a camera");
    uint32_t count = argc > 2 ? (uint32_t)atoi(argv[2]) : UINT32_MAX; /* until the window is closed */
    for (uint32_t number = 0; number < count && !glfwWindowShouldClose(w.window); number++) {
        glfwPollEvents();
        if (glfwGetWindowAttrib(w.window, GLFW_ICONIFIED)) continue;
        draw(renderer, &camera, number);
    }
    fnl_renderer_destroy(&renderer); /* waits for its frames */
    fnl_device_destroy(&device);
    fnl_scene_destroy(&scene);
    vkDeviceWaitIdle(w.device); /* and for the presentation of them */
    for (int i = 0; i < ACQUIRES; i++) vkDestroySemaphore(w.device, w.acquired[i], NULL);
    for (int i = 0; i < IMAGES_MAX; i++) vkDestroySemaphore(w.device, w.finished[i], NULL);
    vkDestroySwapchainKHR(w.device, w.swapchain, NULL);
    vkDestroyDevice(w.device, NULL);
    vkDestroySurfaceKHR(w.instance, w.surface, NULL);
    vkDestroyInstance(w.instance, NULL);
    glfwTerminate();
    return 0;
}
