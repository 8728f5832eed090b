/* SPDX-License-Identifier: MIT */
/**
 * A program with a Vulkan device of its own, which it made with validation and synchronisation validation, lets Fanal render
 * into its images. What it finds there is compared with what Fanal's own device gives.
 */
#include "base/base.h"
#include "fanal/fanal.h"
#include "fanal/vulkan.h"
#include "gpu/gpu.h"
#include "tests/frame_plain.h"

#include <math.h>
#include <setjmp.h>
#include <stdatomic.h>
#include <time.h>
#include <vulkan/vulkan.h>

#include <cmocka.h>

enum { WIDTH = 83, HEIGHT = 45, PIXELS = WIDTH * HEIGHT };

static const char layer[] = "VK_LAYER_KHRONOS_validation";

/* ---- the program ---- */

static struct world {
    VkInstance instance;
    VkDebugUtilsMessengerEXT messenger;
    VkPhysicalDevice physical;
    VkDevice device;
    fnl_device_info optional; /* what it could switch on, and what it did: */
    fnl_vulkan_requirements features;
    VkPhysicalDeviceMeshShaderFeaturesEXT meshes;
    VkDeviceCreateInfo created;
    fnl_vulkan_import handles; /* without `created` */
    uint32_t family;
    VkQueue queue;
    VkCommandPool pool;
    VkSemaphore binary[2], timeline;
    uint64_t ticks; /* what the timeline was last asked to reach */
    uint32_t layer_version;
    uint32_t told; /* warnings that ray queries are missing */
    uint32_t told_of_path;
    atomic_uint messages;
    char last_error[2048]; /* of Fanal's log */
    fnl_camera camera;
    fnl_scene *scene;
    fnl_device *own, *imported;
    fnl_renderer *reference, *renderer;
} w;

#define VK(call) assert_int_equal(call, VK_SUCCESS)
#define FNL(call) assert_int_equal(call, FNL_OK)

static VKAPI_ATTR VkBool32 VKAPI_CALL on_message(VkDebugUtilsMessageSeverityFlagBitsEXT severity,
                                                 VkDebugUtilsMessageTypeFlagsEXT types,
                                                 const VkDebugUtilsMessengerCallbackDataEXT *data, void *user) {
    UNUSED(severity);
    UNUSED(types);
    UNUSED(user);
    /* Older layers blame every shader that indexes a descriptor array, newer ones outputs without a target: src/gpu/instance.c tells more. */
    if (data->pMessageIdName && strstr(data->pMessageIdName, "ShaderOutputNotConsumed")) return VK_FALSE;
    if (w.layer_version < VK_MAKE_API_VERSION(0, 1, 3, 270) && strstr(data->pMessage, "_SHADER_SHADER_")) return VK_FALSE;
    print_error("%s\n", data->pMessage);
    atomic_fetch_add(&w.messages, 1);
    return VK_FALSE;
}

static void keep_error(void *user, fnl_log_level level, const char *line) {
    UNUSED(user);
    if (level == FNL_LOG_WARNING && strstr(line, "ray-query")) w.told++;
    if (level == FNL_LOG_WARNING && strstr(line, "stereo.path=instances")) w.told_of_path++;
    if (level == FNL_LOG_ERROR) snprintf(w.last_error, sizeof w.last_error, "%s", line);
}

static void make_instance(void) {
    VkLayerProperties layers[32];
    uint32_t count = COUNT_OF(layers);
    assert_true(vkEnumerateInstanceLayerProperties(&count, layers) >= 0);
    for (uint32_t i = 0; i < count; i++)
        if (strcmp(layers[i].layerName, layer) == 0) w.layer_version = layers[i].specVersion;
    const char *layer_names[] = {layer};
    const char *extensions[] = {VK_EXT_DEBUG_UTILS_EXTENSION_NAME, VK_EXT_VALIDATION_FEATURES_EXTENSION_NAME};
    VkValidationFeatureEnableEXT enabled[] = {VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT};
    VkValidationFeaturesEXT features = {.sType = VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT,
                                        .enabledValidationFeatureCount = 1,
                                        .pEnabledValidationFeatures = enabled};
    VkApplicationInfo application = {.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO, .apiVersion = VK_API_VERSION_1_3};
    VkInstanceCreateInfo info = {.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO,
                                 .pNext = &features,
                                 .pApplicationInfo = &application,
                                 .enabledLayerCount = 1,
                                 .ppEnabledLayerNames = layer_names,
                                 .enabledExtensionCount = 2,
                                 .ppEnabledExtensionNames = extensions};
    VK(vkCreateInstance(&info, NULL, &w.instance));
    VkDebugUtilsMessengerCreateInfoEXT messenger = {.sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT,
                                                    .messageSeverity = VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT |
                                                                       VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT,
                                                    .messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT,
                                                    .pfnUserCallback = on_message};
    PFN_vkCreateDebugUtilsMessengerEXT create =
        (PFN_vkCreateDebugUtilsMessengerEXT)vkGetInstanceProcAddr(w.instance, "vkCreateDebugUtilsMessengerEXT");
    VK(create(w.instance, &messenger, NULL, &w.messenger));
}

/* Switches on what the device has of numbers for triangles and of mesh shaders. */
static void make_device(void) {
    uint32_t count = 1;
    assert_true(vkEnumeratePhysicalDevices(w.instance, &count, &w.physical) >= 0 && count == 1);
    VkQueueFamilyProperties families[16];
    count = COUNT_OF(families);
    vkGetPhysicalDeviceQueueFamilyProperties(w.physical, &count, families);
    const VkQueueFlags both = VK_QUEUE_GRAPHICS_BIT | VK_QUEUE_COMPUTE_BIT;
    while ((families[w.family].queueFlags & both) != both) assert_true(++w.family < count);
    FNL(fnl_enumerate_devices(NULL, &w.optional, 1, &count));
    fnl_vulkan_requirements_init(&w.features);
    w.features.features.features.geometryShader = w.optional.primitive_ids;
    w.features.features.features.pipelineStatisticsQuery = w.optional.vertex_counts;
    w.features.features_12.shaderOutputLayer = w.optional.vertex_layers;
    w.meshes = (VkPhysicalDeviceMeshShaderFeaturesEXT){.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MESH_SHADER_FEATURES_EXT,
                                                       .pNext = &w.features.features,
                                                       .meshShader = VK_TRUE};
    static const float priority = 1;
    static const char *const extension = VK_EXT_MESH_SHADER_EXTENSION_NAME;
    static VkDeviceQueueCreateInfo queue = {
        .sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO, .queueCount = 1, .pQueuePriorities = &priority};
    queue.queueFamilyIndex = w.family;
    w.created = (VkDeviceCreateInfo){.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
                                     .pNext = w.optional.mesh_shader ? (const void *)&w.meshes : &w.features.features,
                                     .enabledExtensionCount = w.optional.mesh_shader,
                                     .ppEnabledExtensionNames = &extension,
                                     .queueCreateInfoCount = 1,
                                     .pQueueCreateInfos = &queue};
    VK(vkCreateDevice(w.physical, &w.created, NULL, &w.device));
    vkGetDeviceQueue(w.device, w.family, 0, &w.queue);
    VkCommandPoolCreateInfo pool = {.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO, .queueFamilyIndex = w.family};
    VK(vkCreateCommandPool(w.device, &pool, NULL, &w.pool));
    VkSemaphoreCreateInfo semaphore = {.sType = VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO};
    for (int i = 0; i < 2; i++) VK(vkCreateSemaphore(w.device, &semaphore, NULL, &w.binary[i]));
    VkSemaphoreTypeCreateInfo type = {.sType = VK_STRUCTURE_TYPE_SEMAPHORE_TYPE_CREATE_INFO,
                                      .semaphoreType = VK_SEMAPHORE_TYPE_TIMELINE};
    semaphore.pNext = &type;
    VK(vkCreateSemaphore(w.device, &semaphore, NULL, &w.timeline));
}

static fnl_device_params device_params(void) {
    fnl_device_params params = fnl_device_params_default();
    params.host.log = keep_error;
    params.host.thread_count = 2;
    params.index = 0; /* make_device takes the first one, too */
    params.cache_folder = "";
    return params;
}

static int set_up(void **state) {
    UNUSED(state);
    make_instance();
    make_device();
    fnl_device_params params = device_params();
    w.handles = (fnl_vulkan_import){.get_instance_proc_addr = vkGetInstanceProcAddr,
                                    .instance = w.instance,
                                    .physical_device = w.physical,
                                    .device = w.device,
                                    .graphics_family = w.family,
                                    .graphics_queue = w.queue};
    FNL(scene_load_plain(NULL, "builtin:spheres?lights=16", NULL, &w.scene));
    FNL(fnl_scene_query_camera(w.scene, 0, &w.camera));
    FNL(fnl_device_create(&params, &w.own));
    FNL(fnl_device_import(&params, &w.handles, &w.imported));
    FNL(fnl_renderer_create(w.own, w.scene, &w.reference));
    FNL(fnl_renderer_create(w.imported, w.scene, &w.renderer));
    return 0;
}

static int tear_down(void **state) {
    UNUSED(state);
    fnl_renderer_destroy(&w.reference);
    fnl_renderer_destroy(&w.renderer);
    fnl_device_destroy(&w.own);
    fnl_device_destroy(&w.imported);
    fnl_scene_destroy(&w.scene);
    for (int i = 0; i < 2; i++) vkDestroySemaphore(w.device, w.binary[i], NULL);
    vkDestroySemaphore(w.device, w.timeline, NULL);
    vkDestroyCommandPool(w.device, w.pool, NULL);
    vkDestroyDevice(w.device, NULL); /* the layer would name whatever Fanal had left behind */
    PFN_vkDestroyDebugUtilsMessengerEXT destroy =
        (PFN_vkDestroyDebugUtilsMessengerEXT)vkGetInstanceProcAddr(w.instance, "vkDestroyDebugUtilsMessengerEXT");
    destroy(w.instance, w.messenger, NULL);
    vkDestroyInstance(w.instance, NULL);
    return atomic_load(&w.messages) ? -1 : 0;
}

/* ---- its images ---- */

struct picture {
    VkFormat format;
    uint32_t pixel_size, layers;
    VkImage image;
    VkBuffer buffer;
    VkDeviceMemory memory, buffer_memory;
    void *pixels;
};

static VkDeviceMemory allocate(const VkMemoryRequirements *needs, VkMemoryPropertyFlags flags) {
    VkPhysicalDeviceMemoryProperties memory;
    vkGetPhysicalDeviceMemoryProperties(w.physical, &memory);
    VkMemoryAllocateInfo info = {.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, .allocationSize = needs->size};
    while (!(needs->memoryTypeBits >> info.memoryTypeIndex & 1) ||
           (memory.memoryTypes[info.memoryTypeIndex].propertyFlags & flags) != flags)
        assert_true(++info.memoryTypeIndex < memory.memoryTypeCount);
    VkDeviceMemory allocated;
    VK(vkAllocateMemory(w.device, &info, NULL, &allocated));
    return allocated;
}

static struct picture make_layers(VkFormat format, uint32_t pixel_size, uint32_t layers) {
    struct picture p = {.format = format, .pixel_size = pixel_size, .layers = layers};
    VkImageCreateInfo info = {.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO,
                              .imageType = VK_IMAGE_TYPE_2D,
                              .format = format,
                              .extent = {WIDTH, HEIGHT, 1},
                              .mipLevels = 1,
                              .arrayLayers = layers,
                              .samples = VK_SAMPLE_COUNT_1_BIT,
                              .usage = VK_IMAGE_USAGE_TRANSFER_DST_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT |
                                       VK_IMAGE_USAGE_SAMPLED_BIT};
    VK(vkCreateImage(w.device, &info, NULL, &p.image));
    VkMemoryRequirements needs;
    vkGetImageMemoryRequirements(w.device, p.image, &needs);
    p.memory = allocate(&needs, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT);
    VK(vkBindImageMemory(w.device, p.image, p.memory, 0));
    VkBufferCreateInfo buffer = {.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO,
                                 .size = (VkDeviceSize)PIXELS * pixel_size * layers,
                                 .usage = VK_BUFFER_USAGE_TRANSFER_DST_BIT};
    VK(vkCreateBuffer(w.device, &buffer, NULL, &p.buffer));
    vkGetBufferMemoryRequirements(w.device, p.buffer, &needs);
    p.buffer_memory = allocate(&needs, VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT);
    VK(vkBindBufferMemory(w.device, p.buffer, p.buffer_memory, 0));
    VK(vkMapMemory(w.device, p.buffer_memory, 0, VK_WHOLE_SIZE, 0, &p.pixels));
    return p;
}

static struct picture make_picture(VkFormat format, uint32_t pixel_size) { return make_layers(format, pixel_size, 1); }

static void free_picture(struct picture *p) {
    VK(vkDeviceWaitIdle(w.device));
    vkDestroyImage(w.device, p->image, NULL);
    vkDestroyBuffer(w.device, p->buffer, NULL);
    vkFreeMemory(w.device, p->memory, NULL);
    vkFreeMemory(w.device, p->buffer_memory, NULL);
}

static VkSemaphoreSubmitInfo semaphore_info(VkSemaphore semaphore, uint64_t value) {
    return (VkSemaphoreSubmitInfo){.sType = VK_STRUCTURE_TYPE_SEMAPHORE_SUBMIT_INFO,
                                   .semaphore = semaphore,
                                   .value = value,
                                   .stageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT};
}

static void submit(VkCommandBuffer commands, VkSemaphore wait, uint64_t wait_value, VkSemaphore signal,
                   uint64_t signal_value) {
    VkSemaphoreSubmitInfo waits = semaphore_info(wait, wait_value), signals = semaphore_info(signal, signal_value);
    VkCommandBufferSubmitInfo buffer = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_SUBMIT_INFO, .commandBuffer = commands};
    VkSubmitInfo2 info = {.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO_2,
                          .waitSemaphoreInfoCount = wait != VK_NULL_HANDLE,
                          .pWaitSemaphoreInfos = &waits,
                          .commandBufferInfoCount = commands != VK_NULL_HANDLE,
                          .pCommandBufferInfos = &buffer,
                          .signalSemaphoreInfoCount = signal != VK_NULL_HANDLE,
                          .pSignalSemaphoreInfos = &signals};
    VK(vkQueueSubmit2(w.queue, 1, &info, VK_NULL_HANDLE));
}

static VkImageMemoryBarrier2 layout_change(VkImage image, VkImageLayout from, VkImageLayout to) {
    return (VkImageMemoryBarrier2){.sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2,
                                   .srcStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
                                   .srcAccessMask = VK_ACCESS_2_MEMORY_WRITE_BIT,
                                   .dstStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
                                   .dstAccessMask = VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT,
                                   .oldLayout = from,
                                   .newLayout = to,
                                   .srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
                                   .dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
                                   .image = image,
                                   .subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, VK_REMAINING_ARRAY_LAYERS}};
}

/* Once `wait` is signalled, copies the image, which is in `layout` before and after, into p->pixels. */
static void fetch(struct picture *p, VkImageLayout layout, VkSemaphore wait, uint64_t wait_value) {
    VkCommandBufferAllocateInfo info = {
        .sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO, .commandPool = w.pool, .commandBufferCount = 1};
    VkCommandBuffer commands;
    VK(vkAllocateCommandBuffers(w.device, &info, &commands));
    VkCommandBufferBeginInfo begin = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
    VK(vkBeginCommandBuffer(commands, &begin));
    VkImageMemoryBarrier2 change = layout_change(p->image, layout, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
    VkDependencyInfo dependency = {
        .sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO, .imageMemoryBarrierCount = 1, .pImageMemoryBarriers = &change};
    vkCmdPipelineBarrier2(commands, &dependency);
    VkBufferImageCopy region = {.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, p->layers}, .imageExtent = {WIDTH, HEIGHT, 1}};
    vkCmdCopyImageToBuffer(commands, p->image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, p->buffer, 1, &region);
    change = layout_change(p->image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, layout);
    vkCmdPipelineBarrier2(commands, &dependency);
    VK(vkEndCommandBuffer(commands));
    submit(commands, wait, wait_value, VK_NULL_HANDLE, 0);
    VK(vkQueueWaitIdle(w.queue));
    vkFreeCommandBuffers(w.device, w.pool, 1, &commands);
}

/* ---- frames ---- */

static fnl_frame small_frame(void) {
    fnl_frame frame = frame_plain();
    frame.width = WIDTH;
    frame.height = HEIGHT;
    frame.camera = w.camera;
    frame.outputs = 0;
    return frame;
}

/* What Fanal's own device gives; freed by the caller. */
static fnl_image expected(fnl_frame frame, fnl_output output) {
    frame.outputs |= output;
    FNL(fnl_renderer_render(w.reference, &frame));
    fnl_image image;
    FNL(fnl_renderer_read(w.reference, output, &image));
    return image;
}

static void assert_bytes_equal(const struct picture *p, const fnl_image *image) {
    bool swap = p->format == VK_FORMAT_B8G8R8A8_UNORM || p->format == VK_FORMAT_B8G8R8A8_SRGB;
    const uint8_t *a = p->pixels, *b = image->pixels;
    uint64_t sum = 0;
    for (uint32_t i = 0; i < PIXELS * 4u; i++) {
        uint32_t from = swap && i % 4 != 3 ? i - i % 4 + 2 - i % 4 : i;
        if (a[i] != b[from]) fail_msg("byte %u is %d, not %d", i, a[i], b[from]);
        if (i % 4 != 3) sum += a[i];
    }
    assert_true(sum > PIXELS * 3ull * 20); /* far from black */
}

enum ordering { ORDER_BINARY, ORDER_TIMELINE, ORDER_COUNT };

/* Renders between two semaphores, each of which the program itself signals and waits for. */
static void render_and_fetch(const fnl_frame *frame, struct picture *p, enum ordering ordering, VkImageLayout from,
                             VkImageLayout to) {
    fnl_vulkan_target target = {.image = p->image, .format = p->format, .initial_layout = from, .final_layout = to};
    if (ordering == ORDER_BINARY) {
        target.wait = w.binary[0];
        target.signal = w.binary[1];
    } else {
        target.wait = target.signal = w.timeline;
        target.wait_value = ++w.ticks;
        target.signal_value = ++w.ticks;
    }
    submit(VK_NULL_HANDLE, VK_NULL_HANDLE, 0, target.wait, target.wait_value);
    memset(p->pixels, 0, (size_t)PIXELS * p->pixel_size * p->layers);
    FNL(fnl_renderer_render_to(w.renderer, frame, &target));
    fetch(p, to, target.signal, target.signal_value);
}

static const VkImageLayout layouts[] = {VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
                                        VK_IMAGE_LAYOUT_GENERAL};

static void test_8_bit_targets_get_the_picture(void **state) {
    UNUSED(state);
    static const VkFormat formats[] = {VK_FORMAT_R8G8B8A8_UNORM, VK_FORMAT_R8G8B8A8_SRGB, VK_FORMAT_B8G8R8A8_UNORM,
                                       VK_FORMAT_B8G8R8A8_SRGB};
    fnl_frame frame = small_frame();
    fnl_image image = expected(frame, FNL_OUTPUT_COLOR);
    frame.debug = FNL_DEBUG_NORMAL;
    fnl_image normals = expected(frame, FNL_OUTPUT_COLOR);
    for (uint32_t f = 0; f < COUNT_OF(formats); f++) {
        struct picture p = make_picture(formats[f], 4);
        VkImageLayout layout = VK_IMAGE_LAYOUT_UNDEFINED;
        frame.debug = FNL_DEBUG_NONE;
        for (uint32_t l = 0; l < COUNT_OF(layouts); l++) { /* from the layout that the last one left behind */
            render_and_fetch(&frame, &p, (enum ordering)((f + l) % ORDER_COUNT), layout, layouts[l]);
            layout = layouts[l];
            assert_bytes_equal(&p, &image);
        }
        frame.debug = FNL_DEBUG_NORMAL;
        render_and_fetch(&frame, &p, ORDER_TIMELINE, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_GENERAL);
        assert_bytes_equal(&p, &normals);
        free_picture(&p);
    }
    fnl_image_free(NULL, &image);
    fnl_image_free(NULL, &normals);
    assert_int_equal(atomic_load(&w.messages), 0);
}

/* A picture that is not of the image's size is scaled, and what lies over it counts in the image's pixels and goes to the channels of its format. */
static void test_targets_of_another_size_get_the_picture_scaled(void **state) {
    UNUSED(state);
    static const fnl_overlay_vertex corners[] = {
        {{0, 0}, {0, 0}, {255, 128, 0, 255}}, {{200, 0}, {0, 0}, {255, 128, 0, 255}}, {{0, 200}, {0, 0}, {255, 128, 0, 255}}};
    static const uint32_t indices[] = {0, 1, 2};
    const fnl_overlay_draw draw = {.index_count = 3, .x = WIDTH - 5, .y = 3, .width = 50, .height = 4};
    const fnl_overlay overlay = {.vertices = corners, .vertex_count = 3, .indices = indices, .index_count = 3, .draws = &draw, .draw_count = 1};
    fnl_frame frame = small_frame();
    frame.width = 31;
    frame.height = 70;
    fnl_image image = expected(frame, FNL_OUTPUT_COLOR);
    struct picture p = make_picture(VK_FORMAT_B8G8R8A8_UNORM, 4);
    frame.overlay = &overlay;
    const fnl_vulkan_target target = {.image = p.image, .format = p.format, .final_layout = VK_IMAGE_LAYOUT_GENERAL, .width = WIDTH, .height = HEIGHT};
    FNL(fnl_renderer_render_to(w.renderer, &frame, &target));
    fetch(&p, VK_IMAGE_LAYOUT_GENERAL, VK_NULL_HANDLE, 0);
    uint64_t sum = 0;
    for (uint32_t i = 0; i < PIXELS; i++) {
        const uint32_t x = i % WIDTH, y = i / WIDTH;
        const uint8_t *found = (const uint8_t *)p.pixels + 4 * i;
        const bool covered = x >= WIDTH - 5 && y >= 3 && y < 7;
        const double u = fmin(fmax((x + 0.5) / WIDTH * frame.width - 0.5, 0), frame.width - 1), v = fmin(fmax((y + 0.5) / HEIGHT * frame.height - 0.5, 0), frame.height - 1);
        const uint32_t left = (uint32_t)u, top = (uint32_t)v, right = MIN(left + 1, frame.width - 1), bottom = MIN(top + 1, frame.height - 1);
        for (uint32_t c = 0; c < 3; c++) {
            const uint8_t *from = image.pixels;
#define AT(x, y) from[4 * ((y) * frame.width + (x)) + c]
            const double upper = AT(left, top) + (u - left) * (AT(right, top) - AT(left, top));
            const double lower = AT(left, bottom) + (u - left) * (AT(right, bottom) - AT(left, bottom));
#undef AT
            static const double orange[] = {255, 128, 0};
            const double wanted = covered ? orange[c] : upper + (v - top) * (lower - upper);
            if (fabs(found[2 - c] - wanted) > 1.5) fail_msg("pixel %u, %u, channel %u: %d, not %g", x, y, c, found[2 - c], wanted);
            sum += found[c];
        }
    }
    assert_true(sum > PIXELS * 3ull * 20); /* far from black */
    fnl_image_free(NULL, &image);
    free_picture(&p);
    assert_int_equal(atomic_load(&w.messages), 0);
}

/* ---- screens of high dynamic range, in the words of BT.2100 ---- */

static double srgb_decoded(double value) { return value <= 0.04045 ? value / 12.92 : pow((value + 0.055) / 1.055, 2.4); }

/* Of exposed radiance, channel by channel, 0 .. 1023. */
static void hdr10_level(const double color[3], double level[3]) {
    static const double wide[3][3] = {{0.6274, 0.3293, 0.0433}, {0.0691, 0.9195, 0.0114}, {0.0164, 0.0880, 0.8956}};
    const double most = fmax(color[0], fmax(color[1], color[2])), half = 500.0 / 203;
    const double scale = most <= half ? 1 : (2 * half - half * half / most) / most;
    for (uint32_t i = 0; i < 3; i++) {
        const double light = scale * (wide[i][0] * color[0] + wide[i][1] * color[1] + wide[i][2] * color[2]) * 203 / 10000;
        const double power = pow(fmin(fmax(light, 0), 1), 0.1593017578125);
        level[i] = 1023 * pow((0.8359375 + 18.8515625 * power) / (1 + 18.6875 * power), 78.84375);
    }
}

static void assert_hdr10(const struct picture *p, const double *colors) {
    const bool swap = p->format == VK_FORMAT_A2R10G10B10_UNORM_PACK32;
    double highest = 0;
    for (uint32_t i = 0; i < PIXELS; i++) {
        const uint32_t found = ((const uint32_t *)p->pixels)[i];
        double level[3];
        hdr10_level(colors + 3 * (size_t)i, level);
        for (uint32_t c = 0; c < 3; c++) {
            const double channel = found >> (swap ? 20 - 10 * c : 10 * c) & 1023;
            if (fabs(channel - level[c]) > 1.5) fail_msg("pixel %u, channel %u: %g, not %g", i, c, channel, level[c]);
            highest = fmax(highest, channel);
        }
        assert_int_equal(found >> 30, 3);
    }
    assert_true(highest > 300);
}

/* 10-bit targets get what float targets get, encoded; what lies over it has the white of 203 cd/m^2; debug views are colours. */
static void test_10_bit_targets_get_hdr10(void **state) {
    UNUSED(state);
    static const VkFormat formats[] = {VK_FORMAT_A2B10G10R10_UNORM_PACK32, VK_FORMAT_A2R10G10B10_UNORM_PACK32};
    static const fnl_overlay_vertex corners[] = {
        {{0, 0}, {0, 0}, {255, 255, 255, 255}}, {{900, 0}, {0, 0}, {255, 255, 255, 255}}, {{0, 900}, {0, 0}, {255, 255, 255, 255}}};
    static const uint32_t indices[] = {0, 1, 2};
    const fnl_overlay_draw draw = {.index_count = 3, .width = WIDTH, .height = 2};
    const fnl_overlay overlay = {.vertices = corners, .vertex_count = 3, .indices = indices, .index_count = 3, .draws = &draw, .draw_count = 1};
    double *colors = calloc(3 * PIXELS, sizeof *colors);
    assert_non_null(colors);
    for (uint32_t debug = 0; debug < 2; debug++) {
        fnl_frame frame = small_frame();
        frame.exposure = FNL_EXPOSURE_EV;
        frame.ev = -3; /* with highlights beyond the peak */
        frame.debug = debug ? FNL_DEBUG_NORMAL : FNL_DEBUG_NONE;
        fnl_image normals = expected(frame, FNL_OUTPUT_COLOR);
        struct picture linear = make_picture(VK_FORMAT_R32G32B32A32_SFLOAT, 16);
        render_and_fetch(&frame, &linear, ORDER_BINARY, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_GENERAL);
        double most = 0;
        for (uint32_t i = 0; i < 3 * PIXELS; i++) {
            const double value = ((const float *)linear.pixels)[i / 3 * 4 + i % 3];
            if (debug) assert_float_equal(value, srgb_decoded(((const uint8_t *)normals.pixels)[i / 3 * 4 + i % 3] / 255.0), 5e-3);
            colors[i] = i / 3 < 2 * WIDTH ? 1 : value;
            most = fmax(most, colors[i]);
        }
        assert_true(debug || most > 5); /* the shoulder is seen */
        frame.overlay = &overlay;
        for (uint32_t f = 0; f < COUNT_OF(formats); f++) {
            struct picture p = make_picture(formats[f], 4);
            render_and_fetch(&frame, &p, ORDER_TIMELINE, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_GENERAL);
            assert_hdr10(&p, colors);
            free_picture(&p);
        }
        free_picture(&linear);
        fnl_image_free(NULL, &normals);
    }
    free(colors);
    assert_int_equal(atomic_load(&w.messages), 0);
}

/* Each view goes to the layer of its place. The device was made without multiview: they are drawn one by one, whatever the frame asks for. */
static void test_views_go_to_layers(void **state) {
    UNUSED(state);
    enum { VIEWS = 3 };
    struct picture p = make_layers(VK_FORMAT_R8G8B8A8_UNORM, 4, VIEWS);
    fnl_frame frame = small_frame(), single = frame;
    fnl_camera cameras[VIEWS] = {w.camera, w.camera, w.camera};
    cameras[1].shift.x = 0.2f;
    cameras[2].vertical_fov *= 0.8f;
    frame.lists = single.lists = FNL_LISTS_TILED;
    frame.views = cameras;
    frame.view_count = VIEWS;
    frame.multiview = FNL_MULTIVIEW_ON;
    fnl_device_info info;
    FNL(fnl_device_query_info(w.imported, &info));
    assert_true(!info.multiview && info.max_views == 1 && w.optional.multiview && w.optional.max_views >= 6);
    for (int i = 0; i < 3; i++) { /* from nothing, then from what the last frame left */
        render_and_fetch(&frame, &p, ORDER_TIMELINE, i ? VK_IMAGE_LAYOUT_GENERAL : VK_IMAGE_LAYOUT_UNDEFINED,
                         VK_IMAGE_LAYOUT_GENERAL);
        for (int v = 0; v < VIEWS; v++) {
            single.camera = cameras[v];
            fnl_image image = expected(single, FNL_OUTPUT_COLOR);
            struct picture own = p;
            own.pixels = (char *)p.pixels + (size_t)v * PIXELS * p.pixel_size;
            assert_bytes_equal(&own, &image);
            fnl_image_free(NULL, &image);
        }
        frame.multiview = FNL_MULTIVIEW_AUTO; /* nor can vertex shaders choose a layer */
        frame.stereo.eyes = VIEWS;
        frame.stereo.path = FNL_STEREO_PATH_INSTANCES;
        frame.exposure = single.exposure = FNL_EXPOSURE_NONE; /* eyes share one */
    }
    free_picture(&p);
    assert_int_equal(w.told_of_path, 1);
    assert_int_equal(atomic_load(&w.messages), 0);
}

static float half_to_float(uint16_t h) {
    int exponent = h >> 10 & 31, digits = h & 0x3ff;
    float magnitude = exponent ? ldexpf((float)(digits + 0x400), exponent - 25) : ldexpf((float)digits, -24);
    return h & 0x8000 ? -magnitude : magnitude;
}

static void test_float_targets_get_exposed_radiance(void **state) {
    UNUSED(state);
    fnl_frame frame = small_frame();
    frame.exposure = FNL_EXPOSURE_EV;
    frame.ev = 4;
    frame.outputs = FNL_OUTPUT_RADIANCE; /* read beside the target, and computed in 32 bits */
    fnl_image radiance = expected(frame, FNL_OUTPUT_RADIANCE);
    const float *wanted = radiance.pixels, factor = 1 / (1.2f * 16);
    struct picture full = make_picture(VK_FORMAT_R32G32B32A32_SFLOAT, 16);
    struct picture half = make_picture(VK_FORMAT_R16G16B16A16_SFLOAT, 8);
    render_and_fetch(&frame, &full, ORDER_BINARY, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);
    fnl_image read;
    FNL(fnl_renderer_read(w.renderer, FNL_OUTPUT_RADIANCE, &read));
    assert_memory_equal(read.pixels, radiance.pixels, PIXELS * 16);
    fnl_image_free(NULL, &read);
    render_and_fetch(&frame, &half, ORDER_TIMELINE, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
    float brightest = 0;
    for (uint32_t i = 0; i < PIXELS * 4u; i++) {
        float value = i % 4 == 3 ? wanted[i] : wanted[i] * factor;
        float a = ((const float *)full.pixels)[i], b = half_to_float(((const uint16_t *)half.pixels)[i]);
        assert_true(fabsf(a - value) <= value * 1e-6f);
        assert_true(fabsf(b - value) <= value / 1024 + 1e-6f);
        brightest = fmaxf(brightest, value);
    }
    assert_true(brightest > 1); /* nothing was tone-mapped or clamped */
    free_picture(&full);
    free_picture(&half);
    fnl_image_free(NULL, &radiance);
    assert_int_equal(atomic_load(&w.messages), 0);
}

static uint64_t timeline_value(void) {
    uint64_t value;
    VK(vkGetSemaphoreCounterValue(w.device, w.timeline, &value));
    return value;
}

static void test_semaphores_are_waited_for_and_signalled(void **state) {
    UNUSED(state);
    fnl_frame frame = small_frame();
    struct picture p = make_picture(VK_FORMAT_R8G8B8A8_UNORM, 4);
    fnl_vulkan_target target = {.image = p.image,
                                .format = p.format,
                                .final_layout = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
                                .wait = w.timeline,
                                .wait_value = w.ticks + 1,
                                .signal = w.timeline,
                                .signal_value = w.ticks + 2};
    FNL(fnl_renderer_render_to(w.renderer, &frame, &target)); /* returns although nothing may begin */
    nanosleep(&(struct timespec){.tv_nsec = 200000000}, NULL);
    assert_int_equal(timeline_value(), w.ticks);
    VkSemaphoreSignalInfo signal = {
        .sType = VK_STRUCTURE_TYPE_SEMAPHORE_SIGNAL_INFO, .semaphore = w.timeline, .value = w.ticks + 1};
    VK(vkSignalSemaphore(w.device, &signal));
    w.ticks += 2;
    VkSemaphoreWaitInfo wait = {.sType = VK_STRUCTURE_TYPE_SEMAPHORE_WAIT_INFO,
                                .semaphoreCount = 1,
                                .pSemaphores = &w.timeline,
                                .pValues = &w.ticks};
    VK(vkWaitSemaphores(w.device, &wait, 60000000000u));
    fetch(&p, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, VK_NULL_HANDLE, 0);
    fnl_image image = expected(frame, FNL_OUTPUT_COLOR);
    assert_bytes_equal(&p, &image);

    /* Without semaphores the order of submission counts. */
    target.wait = target.signal = VK_NULL_HANDLE;
    memset(p.pixels, 0, PIXELS * 4);
    FNL(fnl_renderer_render_to(w.renderer, &frame, &target));
    fetch(&p, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, VK_NULL_HANDLE, 0);
    assert_bytes_equal(&p, &image);
    fnl_image_free(NULL, &image);
    free_picture(&p);
    assert_int_equal(atomic_load(&w.messages), 0);
}

static void expect_refusal(const fnl_frame *frame, const fnl_vulkan_target *target, fnl_result result, const char *words) {
    w.last_error[0] = 0;
    assert_int_equal(fnl_renderer_render_to(w.renderer, frame, target), result);
    if (!strstr(w.last_error, words)) fail_msg("'%s' does not say '%s'", w.last_error, words);
}

static void test_misuse_is_refused_and_does_no_harm(void **state) {
    UNUSED(state);
    fnl_frame frame = small_frame();
    struct picture p = make_picture(VK_FORMAT_R8G8B8A8_UNORM, 4);
    const fnl_vulkan_target good = {.image = p.image,
                                    .format = p.format,
                                    .final_layout = VK_IMAGE_LAYOUT_GENERAL,
                                    .signal = w.timeline,
                                    .signal_value = w.ticks + 1};
    assert_int_equal(fnl_renderer_render_to(NULL, &frame, &good), FNL_ERROR_INVALID);
    expect_refusal(&frame, NULL, FNL_ERROR_INVALID, "target");
    fnl_vulkan_target bad = good;
    bad.image = VK_NULL_HANDLE;
    expect_refusal(&frame, &bad, FNL_ERROR_INVALID, "image");
    bad = good;
    bad.format = VK_FORMAT_R8G8B8A8_SNORM;
    expect_refusal(&frame, &bad, FNL_ERROR_UNSUPPORTED, "format 38");
    bad = good;
    bad.width = 16385;
    bad.height = 4;
    expect_refusal(&frame, &bad, FNL_ERROR_INVALID, "width");
    bad.width = 0;
    expect_refusal(&frame, &bad, FNL_ERROR_INVALID, "width");
    bad = good;
    bad.format = VK_FORMAT_UNDEFINED;
    expect_refusal(&frame, &bad, FNL_ERROR_UNSUPPORTED, "format 0");
    bad = good;
    bad.final_layout = VK_IMAGE_LAYOUT_UNDEFINED; /* no image can be left in it */
    expect_refusal(&frame, &bad, FNL_ERROR_INVALID, "final_layout");
    bad.final_layout = VK_IMAGE_LAYOUT_PREINITIALIZED;
    expect_refusal(&frame, &bad, FNL_ERROR_INVALID, "final_layout");
    fnl_frame wrong = frame;
    wrong.width = 0;
    expect_refusal(&wrong, &good, FNL_ERROR_INVALID, "width");
    wrong.width = 16385;
    expect_refusal(&wrong, &good, FNL_ERROR_INVALID, "width");
    wrong = frame;
    wrong.shading = FNL_SHADING_MOBILE;
    wrong.msaa = 4;
    expect_refusal(&wrong, &good, FNL_ERROR_UNSUPPORTED, "MSAA");
    assert_int_equal(timeline_value(), w.ticks); /* a frame that was refused signals nothing */

    frame.outputs = FNL_OUTPUT_COLOR; /* the picture went to the target: there is none to read */
    fnl_image image = expected(frame, FNL_OUTPUT_COLOR), read;
    render_and_fetch(&frame, &p, ORDER_TIMELINE, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_GENERAL);
    assert_bytes_equal(&p, &image);
    assert_int_equal(fnl_renderer_read(w.renderer, FNL_OUTPUT_COLOR, &read), FNL_ERROR_INVALID);
    assert_null(read.pixels);
    fnl_image_free(NULL, &image);
    free_picture(&p);
    assert_int_equal(atomic_load(&w.messages), 0);
}

/* ---- optional features ---- */

static void assert_equal_on(fnl_renderer *renderer, fnl_frame frame) {
    fnl_image own = expected(frame, FNL_OUTPUT_RADIANCE), other;
    frame.outputs |= FNL_OUTPUT_RADIANCE;
    FNL(fnl_renderer_render(renderer, &frame));
    FNL(fnl_renderer_read(renderer, FNL_OUTPUT_RADIANCE, &other));
    const uint32_t *a = own.pixels, *b = other.pixels;
    for (uint32_t i = 0; i < PIXELS * 3u; i++)
        if (a[i] != b[i]) fail_msg("%s: float %u differs", fnl_value_name(FNL_ENUM_SHADING, frame.shading), i);
    fnl_image_free(NULL, &own);
    fnl_image_free(NULL, &other);
}

/* Without primitive_ids the output of objects has all but the triangles. */
static void check_objects(void) {
    fnl_frame frame = small_frame();
    fnl_image own = expected(frame, FNL_OUTPUT_OBJECT), other;
    frame.outputs = FNL_OUTPUT_OBJECT;
    FNL(fnl_renderer_render(w.renderer, &frame));
    FNL(fnl_renderer_read(w.renderer, FNL_OUTPUT_OBJECT, &other));
    const float *a = own.pixels, *b = other.pixels;
    uint32_t hits = 0, triangles = 0;
    for (uint32_t i = 0; i < PIXELS; i++) {
        assert_memory_equal(&a[4 * i], &b[4 * i], 3 * sizeof(float));
        assert_true(b[4 * i + 3] == 0);
        hits += b[4 * i] > 0;
        triangles += a[4 * i + 3] > 0;
    }
    assert_true(hits > 0 && triangles > 0);
    fnl_image_free(NULL, &own);
    fnl_image_free(NULL, &other);
}

static void test_optional_features_are_used_where_the_caller_says_so(void **state) {
    UNUSED(state);
    fnl_frame frame = small_frame();
    frame.shading = FNL_SHADING_VISIBILITY;
    fnl_device_info without, with;
    FNL(fnl_device_query_info(w.imported, &without));
    assert_false(without.primitive_ids || without.mesh_shader || without.post_depth_coverage || without.minmax_samplers || without.clip_distances ||
                 without.vertex_layers || without.vertex_counts);
    assert_int_equal(fnl_renderer_render(w.renderer, &frame), FNL_ERROR_UNSUPPORTED);
    check_objects();

    fnl_device_params params = device_params();
    fnl_vulkan_import handles = w.handles;
    handles.created = &w.created;
    fnl_device *device;
    fnl_renderer *renderer;
    FNL(fnl_device_import(&params, &handles, &device));
    FNL(fnl_device_query_info(device, &with));
    assert_int_equal(with.primitive_ids, w.optional.primitive_ids);
    assert_int_equal(with.mesh_shader, w.optional.mesh_shader);
    assert_int_equal(with.vertex_layers, w.optional.vertex_layers);
    assert_int_equal(with.vertex_counts, w.optional.vertex_counts);
    assert_false(with.post_depth_coverage || with.minmax_samplers || with.clip_distances); /* the device has them, but they are not switched on */
    FNL(fnl_renderer_create(device, w.scene, &renderer));
    const fnl_shading orders[] = {FNL_SHADING_VISIBILITY, FNL_SHADING_DAIS};
    for (uint32_t i = 0; i < COUNT_OF(orders) && with.primitive_ids; i++) {
        frame.shading = orders[i];
        assert_equal_on(renderer, frame);
    }
    frame.shading = FNL_SHADING_DEFERRED;
    frame.culling = FNL_CULLING_CLUSTERS;
    frame.geometry = FNL_GEOMETRY_MESH;
    if (with.mesh_shader) assert_equal_on(renderer, frame);
    fnl_renderer_destroy(&renderer);
    fnl_device_destroy(&device);
    assert_int_equal(atomic_load(&w.messages), 0);
}

/* The device has not been created for them: shaders must be free of them, which validation sees, and the log says once what was done. */
static void test_devices_without_ray_queries_walk_trees(void **state) {
    UNUSED(state);
    fnl_frame frame = small_frame();
    fnl_device_info info;
    FNL(fnl_device_query_info(w.imported, &info));
    assert_false(info.ray_query);
    frame.shadows = FNL_SHADOWS_RAYS;
    assert_equal_on(w.renderer, frame); /* auto */
    assert_int_equal(w.told, 0);
    frame.shadow.ray_backend = FNL_RAY_BACKEND_RAY_QUERY;
    for (int i = 0; i < 2; i++) assert_equal_on(w.renderer, frame);
    assert_int_equal(w.told, 1);
    assert_int_equal(atomic_load(&w.messages), 0);
}

/* Another device of the caller's, which was. */
static void test_ray_queries_are_used_where_the_caller_says_so(void **state) {
    UNUSED(state);
    if (!w.optional.ray_query) skip();
    static const char *const extensions[] = {VK_KHR_RAY_QUERY_EXTENSION_NAME, VK_KHR_ACCELERATION_STRUCTURE_EXTENSION_NAME,
                                             VK_KHR_DEFERRED_HOST_OPERATIONS_EXTENSION_NAME};
    fnl_vulkan_requirements features;
    fnl_vulkan_requirements_init(&features);
    VkPhysicalDeviceRayQueryFeaturesKHR queries = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_RAY_QUERY_FEATURES_KHR, .pNext = &features.features, .rayQuery = VK_TRUE};
    VkPhysicalDeviceAccelerationStructureFeaturesKHR structures = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ACCELERATION_STRUCTURE_FEATURES_KHR, .pNext = &queries, .accelerationStructure = VK_TRUE};
    VkDeviceCreateInfo created = w.created;
    created.pNext = &structures;
    created.enabledExtensionCount = COUNT_OF(extensions);
    created.ppEnabledExtensionNames = extensions;
    fnl_device_params params = device_params();
    fnl_vulkan_import handles = w.handles;
    VK(vkCreateDevice(w.physical, &created, NULL, &handles.device));
    vkGetDeviceQueue(handles.device, w.family, 0, &handles.graphics_queue);
    fnl_frame frame = small_frame();
    frame.shadows = FNL_SHADOWS_RAYS;
    frame.shadow.ray_backend = FNL_RAY_BACKEND_RAY_QUERY;
    for (int on = 0; on < 2; on++) {
        queries.rayQuery = on; /* what the caller says, not what is */
        handles.created = &created;
        fnl_device *device;
        fnl_renderer *renderer;
        fnl_device_info info;
        FNL(fnl_device_import(&params, &handles, &device));
        FNL(fnl_device_query_info(device, &info));
        assert_int_equal(info.ray_query, on);
        FNL(fnl_renderer_create(device, w.scene, &renderer));
        if (on) assert_equal_on(renderer, frame);
        fnl_renderer_destroy(&renderer);
        fnl_device_destroy(&device);
    }
    vkDestroyDevice(handles.device, NULL);
    assert_int_equal(atomic_load(&w.messages), 0);
}

/* ---- required features ---- */

/* All that fnl_vulkan_requirements_init switches on, once more: X(member, feature). */
#define REQUIRED(X)                                                                                                         \
    X(features.features, multiDrawIndirect)                                                                                 \
    X(features.features, drawIndirectFirstInstance)                                                                         \
    X(features.features, fullDrawIndexUint32)                                                                               \
    X(features.features, samplerAnisotropy)                                                                                 \
    X(features.features, depthClamp)                                                                                        \
    X(features.features, independentBlend)                                                                                  \
    X(features.features, fragmentStoresAndAtomics)                                                                          \
    X(features.features, shaderStorageImageReadWithoutFormat)                                                               \
    X(features.features, shaderStorageImageWriteWithoutFormat)                                                              \
    X(features.features, shaderSampledImageArrayDynamicIndexing)                                                            \
    X(features.features, shaderStorageImageArrayDynamicIndexing)                                                            \
    X(features_11, shaderDrawParameters)                                                                                    \
    X(features_12, drawIndirectCount)                                                                                       \
    X(features_12, descriptorIndexing)                                                                                      \
    X(features_12, runtimeDescriptorArray)                                                                                  \
    X(features_12, descriptorBindingPartiallyBound)                                                                         \
    X(features_12, descriptorBindingSampledImageUpdateAfterBind)                                                            \
    X(features_12, descriptorBindingStorageImageUpdateAfterBind)                                                            \
    X(features_12, descriptorBindingUpdateUnusedWhilePending)                                                               \
    X(features_12, shaderSampledImageArrayNonUniformIndexing)                                                               \
    X(features_12, shaderStorageImageArrayNonUniformIndexing)                                                               \
    X(features_12, bufferDeviceAddress)                                                                                     \
    X(features_12, scalarBlockLayout)                                                                                       \
    X(features_12, imagelessFramebuffer)                                                                                    \
    X(features_12, timelineSemaphore)                                                                                       \
    X(features_12, hostQueryReset)                                                                                          \
    X(features_12, separateDepthStencilLayouts)                                                                             \
    X(features_13, dynamicRendering)                                                                                        \
    X(features_13, synchronization2)                                                                                        \
    X(features_13, maintenance4)                                                                                            \
    X(features_13, shaderDemoteToHelperInvocation)                                                                          \
    X(features_13, shaderTerminateInvocation)

static uint32_t count_on(const void *first, const void *last) {
    uint32_t count = 0;
    for (const VkBool32 *bit = first; bit <= (const VkBool32 *)last; bit++) count += *bit;
    return count;
}

static fnl_result import_created(const VkDeviceCreateInfo *created) {
    fnl_device_params params = device_params();
    fnl_vulkan_import handles = w.handles;
    handles.created = created;
    fnl_device *device = NULL;
    w.last_error[0] = 0;
    fnl_result result = fnl_device_import(&params, &handles, &device);
    assert_int_equal(device != NULL, result == FNL_OK);
    fnl_device_destroy(&device);
    return result;
}

/* `name` is off in what the device is said to be created with, and nothing else is. */
static void expect_missing(const VkDeviceCreateInfo *created, const char *name) {
    char end[100];
    snprintf(end, sizeof end, ": %s", name);
    assert_int_equal(import_created(created), FNL_ERROR_UNSUPPORTED);
    size_t length = strlen(w.last_error);
    if (length < strlen(end) || strcmp(w.last_error + length - strlen(end), end) != 0)
        fail_msg("'%s' does not name %s", w.last_error, name);
}

static void test_each_required_feature_that_is_off_is_named(void **state) {
    UNUSED(state);
    fnl_vulkan_requirements r;
    fnl_vulkan_requirements_init(&r);
    VkDeviceCreateInfo created = {.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO, .pNext = &r.features};
    uint32_t tried = 0;
#define TURN_OFF(member, feature)                                                                                           \
    assert_true(r.member.feature);                                                                                          \
    r.member.feature = VK_FALSE;                                                                                            \
    expect_missing(&created, #feature);                                                                                     \
    r.member.feature = VK_TRUE;                                                                                             \
    tried++;
    REQUIRED(TURN_OFF)
#undef TURN_OFF
    uint32_t required = count_on(&r.features.features, &r.features.features.inheritedQueries) +
                        count_on(&r.features_11.storageBuffer16BitAccess, &r.features_11.shaderDrawParameters) +
                        count_on(&r.features_12.samplerMirrorClampToEdge, &r.features_12.subgroupBroadcastDynamicId) +
                        count_on(&r.features_13.robustImageAccess, &r.features_13.maintenance4);
    assert_int_equal(tried, required);
    FNL(import_created(&created)); /* with all of them on again */

    created.pEnabledFeatures = &r.features.features; /* as programs do that begin the chain with Vulkan 1.1 */
    created.pNext = &r.features_11;
    FNL(import_created(&created));
    r.features.features.depthClamp = VK_FALSE;
    expect_missing(&created, "depthClamp");

    created = (VkDeviceCreateInfo){.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO}; /* nothing on: every one is named */
    assert_int_equal(import_created(&created), FNL_ERROR_UNSUPPORTED);
#define NAMED(member, feature)                                                                                              \
    if (!strstr(w.last_error, #feature)) fail_msg("'%s' does not name %s", w.last_error, #feature);
    REQUIRED(NAMED)
#undef NAMED
    assert_int_equal(atomic_load(&w.messages), 0);
}

/* Features of Vulkan 1.1 to 1.3 by structures of their own: X(structure, sType, features that Fanal needs of it). */
#define SINGLE(X)                                                                                                           \
    X(ShaderDrawParameters, SHADER_DRAW_PARAMETERS, shaderDrawParameters)                                                   \
    X(BufferDeviceAddress, BUFFER_DEVICE_ADDRESS, bufferDeviceAddress)                                                      \
    X(ScalarBlockLayout, SCALAR_BLOCK_LAYOUT, scalarBlockLayout)                                                            \
    X(ImagelessFramebuffer, IMAGELESS_FRAMEBUFFER, imagelessFramebuffer)                                                    \
    X(TimelineSemaphore, TIMELINE_SEMAPHORE, timelineSemaphore)                                                             \
    X(HostQueryReset, HOST_QUERY_RESET, hostQueryReset)                                                                     \
    X(SeparateDepthStencilLayouts, SEPARATE_DEPTH_STENCIL_LAYOUTS, separateDepthStencilLayouts)                             \
    X(DynamicRendering, DYNAMIC_RENDERING, dynamicRendering)                                                                \
    X(Synchronization2, SYNCHRONIZATION_2, synchronization2)                                                                \
    X(Maintenance4, MAINTENANCE_4, maintenance4)                                                                            \
    X(ShaderDemoteToHelperInvocation, SHADER_DEMOTE_TO_HELPER_INVOCATION, shaderDemoteToHelperInvocation)                   \
    X(ShaderTerminateInvocation, SHADER_TERMINATE_INVOCATION, shaderTerminateInvocation)

static void test_structures_of_single_features_count(void **state) {
    UNUSED(state);
    fnl_vulkan_requirements r;
    fnl_vulkan_requirements_init(&r);
    static const char *const extension = VK_KHR_DRAW_INDIRECT_COUNT_EXTENSION_NAME;
    VkDeviceCreateInfo created = {.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
                                  .enabledExtensionCount = 1,
                                  .ppEnabledExtensionNames = &extension,
                                  .pEnabledFeatures = &r.features.features};
#define LINK(name, type, feature)                                                                                           \
    VkPhysicalDevice##name##Features in_##feature = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_##type##_FEATURES,          \
                                                     .pNext = (void *)(uintptr_t)created.pNext,                             \
                                                     .feature = VK_TRUE};                                                   \
    created.pNext = &in_##feature;
    SINGLE(LINK)
#undef LINK
    VkPhysicalDeviceDescriptorIndexingFeatures indexing = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DESCRIPTOR_INDEXING_FEATURES,
        .pNext = (void *)(uintptr_t)created.pNext,
        .runtimeDescriptorArray = VK_TRUE,
        .descriptorBindingPartiallyBound = VK_TRUE,
        .descriptorBindingSampledImageUpdateAfterBind = VK_TRUE,
        .descriptorBindingStorageImageUpdateAfterBind = VK_TRUE,
        .descriptorBindingUpdateUnusedWhilePending = VK_TRUE,
        .shaderSampledImageArrayNonUniformIndexing = VK_TRUE,
        .shaderStorageImageArrayNonUniformIndexing = VK_TRUE};
    created.pNext = &indexing;
    FNL(import_created(&created));
#define TURN_OFF(name, type, feature)                                                                                       \
    in_##feature.feature = VK_FALSE;                                                                                        \
    expect_missing(&created, #feature);                                                                                     \
    in_##feature.feature = VK_TRUE;
    SINGLE(TURN_OFF)
#undef TURN_OFF
    indexing.runtimeDescriptorArray = VK_FALSE;
    expect_missing(&created, "runtimeDescriptorArray");
    indexing.runtimeDescriptorArray = VK_TRUE;
    created.enabledExtensionCount = 0;
    expect_missing(&created, "drawIndirectCount");
    assert_int_equal(atomic_load(&w.messages), 0);
}

/* Pipelines of candidates are made on the caller's device too, and it is given back in the middle of that. */
static void test_auto_makes_pipelines_in_the_background(void **state) {
    UNUSED(state);
    fnl_device_params params = device_params();
    fnl_device *device;
    fnl_renderer *renderer;
    FNL(fnl_device_import(&params, &w.handles, &device));
    FNL(fnl_renderer_create(device, w.scene, &renderer));
    fnl_frame frame = small_frame();
    frame.lists = FNL_LISTS_AUTO;
    for (int i = 0; i < 3; i++) assert_equal_on(renderer, frame);
    assert_true(gpu_pipeline_stats(device).asked > 0);
    fnl_renderer_destroy(&renderer);
    fnl_device_destroy(&device);
    assert_int_equal(atomic_load(&w.messages), 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_8_bit_targets_get_the_picture),
        cmocka_unit_test(test_targets_of_another_size_get_the_picture_scaled),
        cmocka_unit_test(test_10_bit_targets_get_hdr10),
        cmocka_unit_test(test_views_go_to_layers),
        cmocka_unit_test(test_float_targets_get_exposed_radiance),
        cmocka_unit_test(test_semaphores_are_waited_for_and_signalled),
        cmocka_unit_test(test_misuse_is_refused_and_does_no_harm),
        cmocka_unit_test(test_optional_features_are_used_where_the_caller_says_so),
        cmocka_unit_test(test_devices_without_ray_queries_walk_trees),
        cmocka_unit_test(test_ray_queries_are_used_where_the_caller_says_so),
        cmocka_unit_test(test_each_required_feature_that_is_off_is_named),
        cmocka_unit_test(test_structures_of_single_features_count),
        cmocka_unit_test(test_auto_makes_pipelines_in_the_background),
    };
    return cmocka_run_group_tests_name("render: import", tests, set_up, tear_down);
}
