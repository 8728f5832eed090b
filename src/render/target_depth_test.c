/* SPDX-License-Identifier: MIT */
/* Depth in the caller's image: what each path hands over, of each view, reversed and forward, with samples and in a part. With validation. */
#include "base/base.h"
#include "fanal/fanal.h"
#include "fanal/vulkan.h"
#include "tests/frame_plain.h"

#include <setjmp.h>
#include <vulkan/vulkan.h>

#include <cmocka.h>

enum { WIDTH = 33, HEIGHT = 21, LAYERS = 2, PIXELS = WIDTH * HEIGHT };

static struct {
    fnl_device *device;
    fnl_scene *scene;
    fnl_renderer *reference, *renderer;
    fnl_vulkan_handles handles;
    VkCommandPool pool;
    VkImage color, depth;
    VkBuffer buffer;
    VkDeviceMemory memory[3];
    float *depths; /* of both layers */
    fnl_camera cameras[LAYERS];
} w;

#define VK(call) assert_int_equal(call, VK_SUCCESS)
#define FNL(call) assert_int_equal(call, FNL_OK)

static VkDeviceMemory allocate(const VkMemoryRequirements *needs, VkMemoryPropertyFlags flags) {
    VkPhysicalDeviceMemoryProperties memory;
    vkGetPhysicalDeviceMemoryProperties(w.handles.physical_device, &memory);
    VkMemoryAllocateInfo info = {.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, .allocationSize = needs->size};
    while (!(needs->memoryTypeBits >> info.memoryTypeIndex & 1) || (memory.memoryTypes[info.memoryTypeIndex].propertyFlags & flags) != flags)
        assert_true(++info.memoryTypeIndex < memory.memoryTypeCount);
    VkDeviceMemory allocated;
    VK(vkAllocateMemory(w.handles.device, &info, NULL, &allocated));
    return allocated;
}

static VkImage make_image(VkFormat format, VkDeviceMemory *memory) {
    const VkImageCreateInfo info = {.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO,
                                    .imageType = VK_IMAGE_TYPE_2D,
                                    .format = format,
                                    .extent = {WIDTH, HEIGHT, 1},
                                    .mipLevels = 1,
                                    .arrayLayers = LAYERS,
                                    .samples = VK_SAMPLE_COUNT_1_BIT,
                                    .usage = VK_IMAGE_USAGE_TRANSFER_DST_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT};
    VkMemoryRequirements needs;
    VkImage image;
    VK(vkCreateImage(w.handles.device, &info, NULL, &image));
    vkGetImageMemoryRequirements(w.handles.device, image, &needs);
    *memory = allocate(&needs, 0);
    VK(vkBindImageMemory(w.handles.device, image, *memory, 0));
    return image;
}

static int set_up(void **state) {
    UNUSED(state);
    fnl_device_params params = fnl_device_params_default();
    params.validate = true;
    params.index = 0;
    params.cache_folder = "";
    FNL(fnl_device_create(&params, &w.device));
    FNL(fnl_device_query_vulkan(w.device, &w.handles));
    FNL(scene_load_plain(NULL, "builtin:onetile", NULL, &w.scene));
    FNL(fnl_renderer_create(w.device, w.scene, &w.reference));
    FNL(fnl_renderer_create(w.device, w.scene, &w.renderer));
    FNL(fnl_scene_query_camera(w.scene, 0, &w.cameras[0]));
    w.cameras[1] = w.cameras[0];
    w.cameras[1].position.x += 0.3f;
    w.cameras[1].near_distance *= 2;
    const VkCommandPoolCreateInfo pool = {.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO, .queueFamilyIndex = w.handles.graphics_family};
    VK(vkCreateCommandPool(w.handles.device, &pool, NULL, &w.pool));
    w.color = make_image(VK_FORMAT_R8G8B8A8_UNORM, &w.memory[0]);
    w.depth = make_image(VK_FORMAT_D32_SFLOAT, &w.memory[1]);
    const VkBufferCreateInfo buffer = {.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO, .size = PIXELS * LAYERS * 4, .usage = VK_BUFFER_USAGE_TRANSFER_DST_BIT};
    VkMemoryRequirements needs;
    VK(vkCreateBuffer(w.handles.device, &buffer, NULL, &w.buffer));
    vkGetBufferMemoryRequirements(w.handles.device, w.buffer, &needs);
    w.memory[2] = allocate(&needs, VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT);
    VK(vkBindBufferMemory(w.handles.device, w.buffer, w.memory[2], 0));
    VK(vkMapMemory(w.handles.device, w.memory[2], 0, VK_WHOLE_SIZE, 0, (void **)&w.depths));
    return 0;
}

static int tear_down(void **state) {
    UNUSED(state);
    VK(vkDeviceWaitIdle(w.handles.device));
    vkDestroyImage(w.handles.device, w.color, NULL);
    vkDestroyImage(w.handles.device, w.depth, NULL);
    vkDestroyBuffer(w.handles.device, w.buffer, NULL);
    for (int i = 0; i < 3; i++) vkFreeMemory(w.handles.device, w.memory[i], NULL);
    vkDestroyCommandPool(w.handles.device, w.pool, NULL);
    fnl_renderer_destroy(&w.reference);
    fnl_renderer_destroy(&w.renderer);
    fnl_scene_destroy(&w.scene);
    assert_int_equal(fnl_device_validation_count(w.device), 0);
    fnl_device_destroy(&w.device);
    return 0;
}

/* The depth image, which was left in TRANSFER_SRC, becomes w.depths. */
static void read_depth(void) {
    const VkCommandBufferAllocateInfo info = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO, .commandPool = w.pool, .commandBufferCount = 1};
    const VkCommandBufferBeginInfo begin = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
    const VkBufferImageCopy region = {.imageSubresource = {VK_IMAGE_ASPECT_DEPTH_BIT, 0, 0, LAYERS}, .imageExtent = {WIDTH, HEIGHT, 1}};
    VkCommandBuffer commands;
    VK(vkQueueWaitIdle(w.handles.graphics_queue));
    VK(vkAllocateCommandBuffers(w.handles.device, &info, &commands));
    VK(vkBeginCommandBuffer(commands, &begin));
    vkCmdCopyImageToBuffer(commands, w.depth, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, w.buffer, 1, &region);
    VK(vkEndCommandBuffer(commands));
    const VkSubmitInfo submit = {.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO, .commandBufferCount = 1, .pCommandBuffers = &commands};
    VK(vkQueueSubmit(w.handles.graphics_queue, 1, &submit, VK_NULL_HANDLE));
    VK(vkQueueWaitIdle(w.handles.graphics_queue));
    vkFreeCommandBuffers(w.handles.device, w.pool, 1, &commands);
}

static fnl_frame small_frame(uint32_t views) {
    fnl_frame frame = frame_plain();
    frame.camera = w.cameras[0];
    frame.views = w.cameras;
    frame.view_count = views;
    frame.width = WIDTH;
    frame.height = HEIGHT;
    frame.lists = FNL_LISTS_ALL;
    frame.outputs = 0;
    return frame;
}

static fnl_vulkan_target usual_target(void) {
    return (fnl_vulkan_target){.image = w.color,
                               .format = VK_FORMAT_R8G8B8A8_UNORM,
                               .final_layout = VK_IMAGE_LAYOUT_GENERAL,
                               .width = WIDTH,
                               .height = HEIGHT,
                               .depth = w.depth,
                               .depth_final_layout = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL};
}

/* View depths by another way than the paths' own: RGBA32F, in W. */
static fnl_image view_depths(uint32_t views, float right, float down) {
    fnl_frame frame = small_frame(views);
    fnl_image image;
    frame.shading = FNL_SHADING_FORWARD;
    frame.outputs = FNL_OUTPUT_NORMAL;
    frame.jitter = (fnl_vec2){right, down};
    FNL(fnl_renderer_render(w.reference, &frame));
    FNL(fnl_renderer_read(w.reference, FNL_OUTPUT_NORMAL, &image));
    return image;
}

/* `wrong`: pixels that may differ, where an edge falls on the place of a sample. */
static void check(const char *what, const fnl_image *truth, uint32_t views, bool forward, uint32_t wrong_allowed) {
    uint32_t seen = 0, wrong = 0;
    for (uint32_t i = 0; i < views * PIXELS; i++) {
        const float distance = ((const float *)truth->pixels)[4 * i + 3], near = w.cameras[i / PIXELS].near_distance;
        const float depth = forward ? 1 - w.depths[i] : w.depths[i], wanted = distance > 0 ? near / distance : 0;
        seen += distance > 0;
        wrong += !(fabsf(depth - wanted) <= 2e-5f * wanted + (forward ? 1e-7f : 0));
    }
    if (wrong > wrong_allowed || seen < 100) fail_msg("%s: the depth of %u of %u pixels is wrong, %u show something", what, wrong, views * PIXELS, seen);
}

static void test_each_path_hands_depth_over_VR_20(void **state) {
    UNUSED(state);
    fnl_image truth = view_depths(2, 0, 0);
    for (fnl_shading shading = 0; shading < FNL_SHADING_AUTO; shading++) {
        fnl_frame frame = small_frame(shading == FNL_SHADING_VIRTUAL_TEXTURING ? 1 : 2);
        frame.shading = shading;
        if (!fnl_shading_supports(shading, frame.lists, 1)) frame.lists = FNL_LISTS_TILED;
        if (frame.view_count == 1) frame.view_count = 0;
        fnl_vulkan_target target = usual_target();
        FNL(fnl_renderer_render_to(w.renderer, &frame, &target));
        read_depth();
        check(fnl_value_name(FNL_ENUM_SHADING, shading), &truth, frame.view_count ? 2 : 1, false, 0);
    }
    fnl_image_free(NULL, &truth);
}

static void test_forward_samples_and_parts_VR_20(void **state) {
    UNUSED(state);
    fnl_image truth = view_depths(2, 0, 0);
    fnl_frame frame = small_frame(2);
    fnl_vulkan_target target = usual_target();
    target.depth_forward = true;
    FNL(fnl_renderer_render_to(w.renderer, &frame, &target));
    read_depth();
    check("forward", &truth, 2, true, 0);
    /* The first of four samples lies an eighth left of the middle and three eighths above. */
    fnl_image sampled = view_depths(2, -0.125f, -0.375f);
    frame.shading = FNL_SHADING_FORWARD_PREPASS;
    frame.msaa = 4;
    target.depth_forward = false;
    FNL(fnl_renderer_render_to(w.renderer, &frame, &target));
    read_depth();
    check("samples", &sampled, 2, false, 4);
    /* In a part nothing else changes. */
    frame.msaa = 1;
    target.depth_initial_layout = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL;
    target.part = (fnl_vulkan_part){5, 7, 11, 9, false};
    float *before = malloc(sizeof *before * PIXELS * LAYERS);
    assert_non_null(before);
    memcpy(before, w.depths, sizeof *before * PIXELS * LAYERS);
    FNL(fnl_renderer_render_to(w.renderer, &frame, &target));
    read_depth();
    for (uint32_t i = 0; i < PIXELS * LAYERS; i++) {
        const uint32_t x = i % WIDTH, y = i % PIXELS / WIDTH;
        const bool inside = x >= 5 && x < 16 && y >= 7 && y < 16;
        if (!inside) assert_true(w.depths[i] == before[i]);
        else ((float *)sampled.pixels)[4 * i + 3] = ((const float *)truth.pixels)[4 * i + 3];
    }
    check("part", &sampled, 2, false, 4);
    free(before);
    fnl_image_free(NULL, &truth);
    fnl_image_free(NULL, &sampled);
}

static void test_misuse(void **state) {
    UNUSED(state);
    fnl_frame frame = small_frame(0);
    fnl_vulkan_target target = usual_target();
    target.depth_final_layout = VK_IMAGE_LAYOUT_UNDEFINED;
    assert_int_equal(fnl_renderer_render_to(w.renderer, &frame, &target), FNL_ERROR_INVALID);
    target = usual_target();
    frame.width = 20; /* the picture would be scaled */
    assert_int_equal(fnl_renderer_render_to(w.renderer, &frame, &target), FNL_ERROR_UNSUPPORTED);
}

/* Pipelines of frames with depth are made ahead. */
static void test_warm(void **state) {
    UNUSED(state);
    fnl_renderer *renderer;
    fnl_frame_stats stats;
    fnl_frame frame = small_frame(2);
    fnl_vulkan_target target = usual_target();
    frame.shading = FNL_SHADING_FORWARD_PREPASS;
    frame.msaa = 4;
    target.depth_forward = true;
    FNL(fnl_renderer_create(w.device, w.scene, &renderer));
    FNL(fnl_renderer_warm(renderer, &frame, &target, true, NULL));
    FNL(fnl_renderer_render_to(renderer, &frame, &target));
    FNL(fnl_renderer_query_stats(renderer, &stats));
    assert_int_equal(stats.pipelines_made, 0);
    fnl_renderer_destroy(&renderer);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_warm), /* first: the others make pipelines too */
                                       cmocka_unit_test(test_each_path_hands_depth_over_VR_20), cmocka_unit_test(test_forward_samples_and_parts_VR_20),
                                       cmocka_unit_test(test_misuse)};
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
