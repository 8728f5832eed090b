/* SPDX-License-Identifier: MIT */
/*
 * A program with a Vulkan device of its own lets Fanal render into its image:  import_device [SCENE [PICTURE.png]]
 *
 * What to look at: make_device() adds what Fanal needs to the device; import() hands the device over; render_frame() gives
 * Fanal an image and two semaphores. Frame 1 uses binary semaphores, as with a swapchain; frame 2 a timeline semaphore. All
 * else is what any Vulkan program does. It opens no window: the image is copied into a file.
 */
#include <fanal/fanal.h>
#include <fanal/vulkan.h>

#include <vulkan/vulkan.h>

#include <stdio.h>
#include <stdlib.h>

enum { WIDTH = 320, HEIGHT = 180, BYTES = WIDTH * HEIGHT * 4 };

/* The program's own objects. */
struct program {
    VkInstance instance;
    VkPhysicalDevice physical;
    VkDevice device;
    uint32_t family;
    VkQueue queue;
    VkImage image;
    VkBuffer buffer; /* the picture's way into host memory */
    VkDeviceMemory image_memory, buffer_memory;
    void *pixels;
    VkCommandPool pool;
    VkCommandBuffer copy;
    VkSemaphore free, done; /* binary: the image may be written, the image is finished */
    VkSemaphore timeline;
};

static void check(VkResult result, const char *what) {
    if (result == VK_SUCCESS) return;
    fprintf(stderr, "import_device: %s failed (VkResult %d)\n", what, (int)result);
    exit(1);
}

static void check_fanal(fnl_result result, const char *what) {
    if (result == FNL_OK) return;
    fprintf(stderr, "import_device: %s: %s\n", what, fnl_result_name(result)); /* Fanal's log on stderr says more */
    exit(1);
}

/* ---- the program's own Vulkan ---- */

static void make_device(struct program *p) {
    VkApplicationInfo application = {.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO, .apiVersion = VK_API_VERSION_1_3};
    VkInstanceCreateInfo instance_info = {.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO, .pApplicationInfo = &application};
    check(vkCreateInstance(&instance_info, NULL, &p->instance), "vkCreateInstance");

    uint32_t count = 1; /* the first device will do here; a program has its own way to choose */
    VkResult result = vkEnumeratePhysicalDevices(p->instance, &count, &p->physical);
    check(result == VK_INCOMPLETE ? VK_SUCCESS : result, "vkEnumeratePhysicalDevices");
    if (count == 0) check(VK_ERROR_INITIALIZATION_FAILED, "looking for a Vulkan device");

    /* Fanal wants one queue that can both draw and compute. */
    VkQueueFamilyProperties families[16];
    count = 16;
    vkGetPhysicalDeviceQueueFamilyProperties(p->physical, &count, families);
    const VkQueueFlags both = VK_QUEUE_GRAPHICS_BIT | VK_QUEUE_COMPUTE_BIT;
    while (p->family < count && (families[p->family].queueFlags & both) != both) p->family++;
    if (p->family == count) check(VK_ERROR_FEATURE_NOT_PRESENT, "looking for a queue");

    /*
     * The features that Fanal needs, as a chain for VkDeviceCreateInfo. A program that needs more sets more members, and
     * may append structures of its own to requirements.features_13.pNext. The struct must stay where it is.
     */
    fnl_vulkan_requirements requirements;
    fnl_vulkan_requirements_init(&requirements);
    float priority = 1;
    VkDeviceQueueCreateInfo queue_info = {.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO,
                                          .queueFamilyIndex = p->family,
                                          .queueCount = 1,
                                          .pQueuePriorities = &priority};
    VkDeviceCreateInfo info = {.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
                               .pNext = &requirements.features,
                               .queueCreateInfoCount = 1,
                               .pQueueCreateInfos = &queue_info};
    check(vkCreateDevice(p->physical, &info, NULL, &p->device), "vkCreateDevice");
    vkGetDeviceQueue(p->device, p->family, 0, &p->queue);
}

static VkDeviceMemory allocate(struct program *p, const VkMemoryRequirements *needs, VkMemoryPropertyFlags flags) {
    VkPhysicalDeviceMemoryProperties memory;
    vkGetPhysicalDeviceMemoryProperties(p->physical, &memory);
    uint32_t type = 0;
    while (type < memory.memoryTypeCount &&
           (!(needs->memoryTypeBits >> type & 1) || (memory.memoryTypes[type].propertyFlags & flags) != flags))
        type++;
    VkMemoryAllocateInfo info = {
        .sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, .allocationSize = needs->size, .memoryTypeIndex = type};
    VkDeviceMemory allocated;
    check(vkAllocateMemory(p->device, &info, NULL, &allocated), "vkAllocateMemory");
    return allocated;
}

static void make_image_and_buffer(struct program *p) {
    /* TRANSFER_DST is for Fanal, the rest is the program's business: here it copies out, elsewhere it may sample. */
    VkImageCreateInfo info = {.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO,
                              .imageType = VK_IMAGE_TYPE_2D,
                              .format = VK_FORMAT_R8G8B8A8_SRGB,
                              .extent = {WIDTH, HEIGHT, 1},
                              .mipLevels = 1,
                              .arrayLayers = 1,
                              .samples = VK_SAMPLE_COUNT_1_BIT,
                              .usage = VK_IMAGE_USAGE_TRANSFER_DST_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT};
    check(vkCreateImage(p->device, &info, NULL, &p->image), "vkCreateImage");
    VkMemoryRequirements needs;
    vkGetImageMemoryRequirements(p->device, p->image, &needs);
    p->image_memory = allocate(p, &needs, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT);
    check(vkBindImageMemory(p->device, p->image, p->image_memory, 0), "vkBindImageMemory");

    VkBufferCreateInfo buffer_info = {
        .sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO, .size = BYTES, .usage = VK_BUFFER_USAGE_TRANSFER_DST_BIT};
    check(vkCreateBuffer(p->device, &buffer_info, NULL, &p->buffer), "vkCreateBuffer");
    vkGetBufferMemoryRequirements(p->device, p->buffer, &needs);
    p->buffer_memory = allocate(p, &needs, VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT);
    check(vkBindBufferMemory(p->device, p->buffer, p->buffer_memory, 0), "vkBindBufferMemory");
    check(vkMapMemory(p->device, p->buffer_memory, 0, BYTES, 0, &p->pixels), "vkMapMemory");
}

static void make_semaphores(struct program *p) {
    VkSemaphoreCreateInfo info = {.sType = VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO};
    check(vkCreateSemaphore(p->device, &info, NULL, &p->free), "vkCreateSemaphore");
    check(vkCreateSemaphore(p->device, &info, NULL, &p->done), "vkCreateSemaphore");
    VkSemaphoreTypeCreateInfo type = {.sType = VK_STRUCTURE_TYPE_SEMAPHORE_TYPE_CREATE_INFO,
                                      .semaphoreType = VK_SEMAPHORE_TYPE_TIMELINE};
    info.pNext = &type;
    check(vkCreateSemaphore(p->device, &info, NULL, &p->timeline), "vkCreateSemaphore");
}

/* The work that stands for whatever a program does with the picture: a copy into host memory. */
static void record_copy(struct program *p) {
    VkCommandPoolCreateInfo pool_info = {.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO, .queueFamilyIndex = p->family};
    check(vkCreateCommandPool(p->device, &pool_info, NULL, &p->pool), "vkCreateCommandPool");
    VkCommandBufferAllocateInfo info = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
                                        .commandPool = p->pool,
                                        .level = VK_COMMAND_BUFFER_LEVEL_PRIMARY,
                                        .commandBufferCount = 1};
    check(vkAllocateCommandBuffers(p->device, &info, &p->copy), "vkAllocateCommandBuffers");
    VkCommandBufferBeginInfo begin = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
                                      .flags = VK_COMMAND_BUFFER_USAGE_SIMULTANEOUS_USE_BIT}; /* both frames submit it */
    check(vkBeginCommandBuffer(p->copy, &begin), "vkBeginCommandBuffer");
    /* No barrier for the image: Fanal leaves it in the layout asked for, and the semaphore makes its writes visible. */
    VkBufferImageCopy region = {.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1}, .imageExtent = {WIDTH, HEIGHT, 1}};
    vkCmdCopyImageToBuffer(p->copy, p->image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, p->buffer, 1, &region);
    VkMemoryBarrier2 to_host = {.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER_2,
                                .srcStageMask = VK_PIPELINE_STAGE_2_COPY_BIT,
                                .srcAccessMask = VK_ACCESS_2_TRANSFER_WRITE_BIT,
                                .dstStageMask = VK_PIPELINE_STAGE_2_HOST_BIT,
                                .dstAccessMask = VK_ACCESS_2_HOST_READ_BIT};
    VkDependencyInfo dependency = {
        .sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO, .memoryBarrierCount = 1, .pMemoryBarriers = &to_host};
    vkCmdPipelineBarrier2(p->copy, &dependency);
    check(vkEndCommandBuffer(p->copy), "vkEndCommandBuffer");
}

/* Submits `commands` (or nothing) between two semaphores; either may be VK_NULL_HANDLE, values are for the timeline. */
static void submit(struct program *p, VkCommandBuffer commands, VkSemaphore wait, uint64_t wait_value, VkSemaphore signal,
                   uint64_t signal_value) {
    VkSemaphoreSubmitInfo waits = {.sType = VK_STRUCTURE_TYPE_SEMAPHORE_SUBMIT_INFO,
                                   .semaphore = wait,
                                   .value = wait_value,
                                   .stageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT};
    VkSemaphoreSubmitInfo signals = waits;
    signals.semaphore = signal;
    signals.value = signal_value;
    VkCommandBufferSubmitInfo buffer = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_SUBMIT_INFO, .commandBuffer = commands};
    VkSubmitInfo2 info = {.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO_2,
                          .waitSemaphoreInfoCount = wait != VK_NULL_HANDLE,
                          .pWaitSemaphoreInfos = &waits,
                          .commandBufferInfoCount = commands != VK_NULL_HANDLE,
                          .pCommandBufferInfos = &buffer,
                          .signalSemaphoreInfoCount = signal != VK_NULL_HANDLE,
                          .pSignalSemaphoreInfos = &signals};
    check(vkQueueSubmit2(p->queue, 1, &info, VK_NULL_HANDLE), "vkQueueSubmit2");
}

static void destroy(struct program *p) {
    vkDeviceWaitIdle(p->device);
    vkDestroySemaphore(p->device, p->free, NULL);
    vkDestroySemaphore(p->device, p->done, NULL);
    vkDestroySemaphore(p->device, p->timeline, NULL);
    vkDestroyCommandPool(p->device, p->pool, NULL);
    vkDestroyImage(p->device, p->image, NULL);
    vkDestroyBuffer(p->device, p->buffer, NULL);
    vkFreeMemory(p->device, p->image_memory, NULL);
    vkFreeMemory(p->device, p->buffer_memory, NULL);
    vkDestroyDevice(p->device, NULL);
    vkDestroyInstance(p->instance, NULL);
}

/* ---- Fanal ---- */

/* Handles stay the program's; Fanal uses the queue only inside its calls, so both may submit in turns. */
static fnl_device *import(const struct program *p) {
    fnl_vulkan_import handles = {.get_instance_proc_addr = vkGetInstanceProcAddr,
                                 .instance = p->instance,
                                 .physical_device = p->physical,
                                 .device = p->device,
                                 .graphics_family = p->family,
                                 .graphics_queue = p->queue};
    fnl_device *device;
    check_fanal(fnl_device_import(NULL, &handles, &device), "importing the device");
    return device;
}

static void render_frame(fnl_renderer *renderer, const struct program *p, const fnl_camera *camera, VkSemaphore wait,
                         uint64_t wait_value, VkSemaphore signal, uint64_t signal_value) {
    fnl_frame frame = fnl_frame_default();
    frame.width = WIDTH; /* the image's size */
    frame.height = HEIGHT;
    frame.camera = *camera;
    frame.outputs = 0; /* nothing to be read back by Fanal: the picture goes into the image */
    fnl_vulkan_target target = {.image = p->image,
                                .format = VK_FORMAT_R8G8B8A8_SRGB,
                                .initial_layout = VK_IMAGE_LAYOUT_UNDEFINED, /* what was in it does not matter */
                                .final_layout = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
                                .wait = wait,
                                .wait_value = wait_value,
                                .signal = signal,
                                .signal_value = signal_value};
    check_fanal(fnl_renderer_render_to(renderer, &frame, &target), "rendering"); /* returns when it is submitted */
}

int main(int argc, char **argv) {
    const char *source = argc > 1 ? argv[1] : "builtin:spheres", *path = argc > 2 ? argv[2] : "import_device.png";
    fnl_scene *scene; /* knows nothing of devices */
    check_fanal(fnl_scene_load(NULL, source, NULL, &scene), source);
    fnl_camera camera;
    check_fanal(fnl_scene_count(scene, FNL_ENTITY_CAMERA) ? fnl_scene_query_camera(scene, 0, &camera)
                                              : fnl_scene_query_framing_camera(scene, (float)WIDTH / HEIGHT, &camera),
                "looking for a camera");

    struct program p = {0};
    make_device(&p);
    make_image_and_buffer(&p);
    make_semaphores(&p);
    record_copy(&p);
    fnl_device *device = import(&p);
    fnl_renderer *renderer;
    check_fanal(fnl_renderer_create(device, scene, &renderer), "making the renderer");

    /* Frame 1. `free` is signalled as vkAcquireNextImageKHR would; `done` is what vkQueuePresentKHR would wait for. */
    submit(&p, VK_NULL_HANDLE, VK_NULL_HANDLE, 0, p.free, 0);
    render_frame(renderer, &p, &camera, p.free, 0, p.done, 0);
    submit(&p, p.copy, p.done, 0, p.timeline, 1);

    /* Frame 2 waits until the copy of frame 1 is over (1), and is copied in turn (2 to 3). The CPU does not wait. */
    render_frame(renderer, &p, &camera, p.timeline, 1, p.timeline, 2);
    submit(&p, p.copy, p.timeline, 2, p.timeline, 3);

    uint64_t value = 3;
    VkSemaphoreWaitInfo wait = {
        .sType = VK_STRUCTURE_TYPE_SEMAPHORE_WAIT_INFO, .semaphoreCount = 1, .pSemaphores = &p.timeline, .pValues = &value};
    check(vkWaitSemaphores(p.device, &wait, UINT64_MAX), "vkWaitSemaphores");
    fnl_image picture = {WIDTH, HEIGHT, FNL_PIXEL_FORMAT_RGBA8, p.pixels};
    check_fanal(fnl_image_save(NULL, path, &picture), path);
    printf("%s written\n", path);

    fnl_renderer_destroy(&renderer); /* Fanal's objects first, then the device they live on */
    fnl_device_destroy(&device);
    fnl_scene_destroy(&scene);
    destroy(&p);
    return 0;
}
