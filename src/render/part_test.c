/* SPDX-License-Identifier: MIT */
/* Frames that go to a part of the caller's image: what is written, and that nothing else is. With validation. */
#include "base/base.h"
#include "fanal/fanal.h"
#include "fanal/vulkan.h"
#include "tests/frame_plain.h"

#include <setjmp.h>
#include <vulkan/vulkan.h>

#include <cmocka.h>

enum { WIDTH = 83, HEIGHT = 45, LAYERS = 2, PIXELS = WIDTH * HEIGHT, BYTES = PIXELS * 4 * LAYERS };

static struct {
    fnl_device *device;
    fnl_scene *scene;
    fnl_renderer *reference, *renderer;
    fnl_vulkan_handles handles;
    VkCommandPool pool;
    VkImage image;
    VkBuffer buffer;
    VkDeviceMemory memory, buffer_memory;
    uint8_t *bytes;
    char last_error[1024];
} w;

#define VK(call) assert_int_equal(call, VK_SUCCESS)
#define FNL(call) assert_int_equal(call, FNL_OK)

static void keep_error(void *user, fnl_log_level level, const char *line) {
    UNUSED(user);
    if (level == FNL_LOG_ERROR) snprintf(w.last_error, sizeof w.last_error, "%s", line);
}

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

static void make_image(void) {
    const VkImageCreateInfo info = {.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO,
                                    .imageType = VK_IMAGE_TYPE_2D,
                                    .format = VK_FORMAT_R8G8B8A8_UNORM,
                                    .extent = {WIDTH, HEIGHT, 1},
                                    .mipLevels = 1,
                                    .arrayLayers = LAYERS,
                                    .samples = VK_SAMPLE_COUNT_1_BIT,
                                    .usage = VK_IMAGE_USAGE_TRANSFER_DST_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT};
    const VkBufferCreateInfo buffer = {.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO,
                                       .size = BYTES,
                                       .usage = VK_BUFFER_USAGE_TRANSFER_DST_BIT | VK_BUFFER_USAGE_TRANSFER_SRC_BIT};
    VkMemoryRequirements needs;
    VK(vkCreateImage(w.handles.device, &info, NULL, &w.image));
    vkGetImageMemoryRequirements(w.handles.device, w.image, &needs);
    w.memory = allocate(&needs, 0);
    VK(vkBindImageMemory(w.handles.device, w.image, w.memory, 0));
    VK(vkCreateBuffer(w.handles.device, &buffer, NULL, &w.buffer));
    vkGetBufferMemoryRequirements(w.handles.device, w.buffer, &needs);
    w.buffer_memory = allocate(&needs, VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT);
    VK(vkBindBufferMemory(w.handles.device, w.buffer, w.buffer_memory, 0));
    VK(vkMapMemory(w.handles.device, w.buffer_memory, 0, VK_WHOLE_SIZE, 0, (void **)&w.bytes));
}

static int set_up(void **state) {
    UNUSED(state);
    fnl_device_params params = fnl_device_params_default();
    params.host.log = keep_error;
    params.validate = true;
    params.index = 0;
    params.cache_folder = "";
    FNL(fnl_device_create(&params, &w.device));
    FNL(fnl_device_query_vulkan(w.device, &w.handles));
    FNL(scene_load_plain(NULL, "builtin:spheres?lights=16", NULL, &w.scene));
    FNL(fnl_renderer_create(w.device, w.scene, &w.reference));
    FNL(fnl_renderer_create(w.device, w.scene, &w.renderer));
    const VkCommandPoolCreateInfo pool = {.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO, .queueFamilyIndex = w.handles.graphics_family};
    VK(vkCreateCommandPool(w.handles.device, &pool, NULL, &w.pool));
    make_image();
    return 0;
}

static int tear_down(void **state) {
    UNUSED(state);
    VK(vkDeviceWaitIdle(w.handles.device));
    vkDestroyImage(w.handles.device, w.image, NULL);
    vkDestroyBuffer(w.handles.device, w.buffer, NULL);
    vkFreeMemory(w.handles.device, w.memory, NULL);
    vkFreeMemory(w.handles.device, w.buffer_memory, NULL);
    vkDestroyCommandPool(w.handles.device, w.pool, NULL);
    fnl_renderer_destroy(&w.reference);
    fnl_renderer_destroy(&w.renderer);
    fnl_scene_destroy(&w.scene);
    assert_int_equal(fnl_device_validation_count(w.device), 0);
    fnl_device_destroy(&w.device);
    return 0;
}

/* Between the image, in GENERAL before and after, and w.bytes. */
static void copy(bool to_image) {
    const VkCommandBufferAllocateInfo info = {
        .sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO, .commandPool = w.pool, .commandBufferCount = 1};
    const VkCommandBufferBeginInfo begin = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
    const VkBufferImageCopy region = {.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, LAYERS}, .imageExtent = {WIDTH, HEIGHT, 1}};
    VkImageMemoryBarrier2 barrier = {.sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2,
                                     .srcStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
                                     .srcAccessMask = VK_ACCESS_2_MEMORY_WRITE_BIT,
                                     .dstStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
                                     .dstAccessMask = VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT,
                                     .oldLayout = to_image ? VK_IMAGE_LAYOUT_UNDEFINED : VK_IMAGE_LAYOUT_GENERAL,
                                     .newLayout = VK_IMAGE_LAYOUT_GENERAL,
                                     .srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
                                     .dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
                                     .image = w.image,
                                     .subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, LAYERS}};
    const VkDependencyInfo dependency = {.sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO, .imageMemoryBarrierCount = 1, .pImageMemoryBarriers = &barrier};
    VkCommandBuffer commands;
    VK(vkAllocateCommandBuffers(w.handles.device, &info, &commands));
    VK(vkBeginCommandBuffer(commands, &begin));
    vkCmdPipelineBarrier2(commands, &dependency);
    if (to_image)
        vkCmdCopyBufferToImage(commands, w.buffer, w.image, VK_IMAGE_LAYOUT_GENERAL, 1, &region);
    else
        vkCmdCopyImageToBuffer(commands, w.image, VK_IMAGE_LAYOUT_GENERAL, w.buffer, 1, &region);
    VK(vkEndCommandBuffer(commands));
    const VkCommandBufferSubmitInfo buffer = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_SUBMIT_INFO, .commandBuffer = commands};
    const VkSubmitInfo2 submit = {.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO_2, .commandBufferInfoCount = 1, .pCommandBufferInfos = &buffer};
    VK(vkQueueSubmit2(w.handles.graphics_queue, 1, &submit, VK_NULL_HANDLE));
    VK(vkQueueWaitIdle(w.handles.graphics_queue));
    vkFreeCommandBuffers(w.handles.device, w.pool, 1, &commands);
}

static uint8_t pattern(uint32_t i) { return (uint8_t)(i * 7 + i / 251); }

/* Fills the image with a pattern, renders, and reads the image. */
static void render_over(const fnl_frame *frame, const fnl_vulkan_target *target) {
    for (uint32_t i = 0; i < BYTES; i++) w.bytes[i] = pattern(i);
    copy(true);
    FNL(fnl_renderer_render_to(w.renderer, frame, target));
    memset(w.bytes, 0, BYTES);
    copy(false);
}

static fnl_frame small_frame(uint32_t width, uint32_t height) {
    fnl_frame frame = frame_plain();
    FNL(fnl_scene_query_camera(w.scene, 0, &frame.camera));
    frame.width = width;
    frame.height = height;
    frame.outputs = 0;
    return frame;
}

static fnl_image expected(fnl_frame frame) {
    fnl_image image;
    frame.outputs = FNL_OUTPUT_COLOR;
    frame.overlay = NULL;
    FNL(fnl_renderer_render(w.reference, &frame));
    FNL(fnl_renderer_read(w.reference, FNL_OUTPUT_COLOR, &image));
    return image;
}

static fnl_vulkan_target target_with(fnl_vulkan_part part) {
    return (fnl_vulkan_target){.image = w.image,
                               .format = VK_FORMAT_R8G8B8A8_UNORM,
                               .initial_layout = VK_IMAGE_LAYOUT_GENERAL,
                               .final_layout = VK_IMAGE_LAYOUT_GENERAL,
                               .width = WIDTH,
                               .height = HEIGHT,
                               .part = part};
}

static bool inside(const fnl_vulkan_part *p, uint32_t x, uint32_t y) { return x >= p->x && y >= p->y && x < p->x + p->width && y < p->y + p->height; }

/* In the part the picture, from its pixel (left, top) on; the pattern everywhere else. */
static void assert_part(const fnl_vulkan_part *part, const fnl_image *picture, uint32_t left, uint32_t top) {
    uint64_t sum = 0;
    for (uint32_t i = 0; i < BYTES; i++) {
        const uint32_t pixel = i / 4 % PIXELS, x = pixel % WIDTH, y = pixel / WIDTH;
        const bool written = i < 4 * PIXELS && inside(part, x, y);
        const uint8_t *from = picture->pixels;
        const uint8_t wanted = written ? from[4 * ((size_t)(y - part->y + top) * picture->width + x - part->x + left) + i % 4] : pattern(i);
        if (written) sum += w.bytes[i];
        if (w.bytes[i] != wanted) fail_msg("byte %u of pixel %u, %u, layer %u: %d, not %d", i % 4, x, y, i / 4 / PIXELS, w.bytes[i], wanted);
    }
    assert_true(sum > part->width * part->height * 255ull); /* more than alpha */
}

/* Of a picture as large as the image the part shows its own pixels; outside not a byte changes. */
static void test_only_the_part_is_written(void **state) {
    UNUSED(state);
    static const fnl_vulkan_part parts[] = {
        {17, 9, 31, 20, false}, {0, 0, 41, HEIGHT, false}, {41, 0, WIDTH - 41, HEIGHT, false}, {40, 30, 1, 1, false}, {0, HEIGHT - 3, WIDTH, 3, false}};
    const fnl_frame frame = small_frame(WIDTH, HEIGHT);
    fnl_image image = expected(frame);
    for (size_t i = 0; i < COUNT_OF(parts); i++) {
        const fnl_vulkan_target target = target_with(parts[i]);
        render_over(&frame, &target);
        assert_part(&parts[i], &image, parts[i].x, parts[i].y);
    }
    fnl_vulkan_target target = target_with((fnl_vulkan_part){0}); /* all of it, with and without a size */
    const fnl_vulkan_part whole = {0, 0, WIDTH, HEIGHT, false};
    render_over(&frame, &target);
    assert_part(&whole, &image, 0, 0);
    target.width = target.height = 0;
    target.part = parts[0];
    render_over(&frame, &target);
    assert_part(&parts[0], &image, parts[0].x, parts[0].y);
    fnl_image_free(NULL, &image);
}

/* A fitted picture stands in the part as a whole: to the bit where it has its size. */
static void test_fitted_pictures_fill_the_part(void **state) {
    UNUSED(state);
    const fnl_vulkan_part part = {.x = 43, .y = 3, .width = 39, .height = 41, .fitted = true};
    const fnl_vulkan_target target = target_with(part);
    fnl_frame frame = small_frame(part.width, part.height);
    fnl_image image = expected(frame);
    render_over(&frame, &target);
    assert_part(&part, &image, 0, 0);
    fnl_image_free(NULL, &image);
}

/* Scaled pictures: the part shows what the whole image would show there; a fitted one what an image of the part's size would. */
static void test_scaled_pictures(void **state) {
    UNUSED(state);
    const fnl_frame frame = small_frame(29, 60);
    uint8_t *whole = malloc(BYTES);
    assert_non_null(whole);
    fnl_vulkan_target target = target_with((fnl_vulkan_part){0});
    render_over(&frame, &target);
    memcpy(whole, w.bytes, BYTES);
    const fnl_image image = {WIDTH, HEIGHT, FNL_PIXEL_FORMAT_RGBA8, whole};
    target.part = (fnl_vulkan_part){.x = 5, .y = 7, .width = 50, .height = 33};
    render_over(&frame, &target);
    assert_part(&target.part, &image, 5, 7);
    /* Fitted: each pixel is near to those of the frame around its place. */
    target.part.fitted = true;
    fnl_image small = expected(frame);
    render_over(&frame, &target);
    for (uint32_t i = 0; i < PIXELS * 4; i++) {
        const uint32_t x = i / 4 % WIDTH, y = i / 4 / WIDTH;
        if (!inside(&target.part, x, y)) {
            assert_int_equal(w.bytes[i], pattern(i));
            continue;
        }
        const double u = (x - 5 + 0.5) / 50 * frame.width - 0.5, v = (y - 7 + 0.5) / 33 * frame.height - 0.5;
        int low = 255, high = 0;
        for (int corner = 0; corner < 4; corner++) {
            const int column = MIN(MAX((int)floor(u) + corner % 2, 0), (int)frame.width - 1), row = MIN(MAX((int)floor(v) + corner / 2, 0), (int)frame.height - 1);
            const int value = ((const uint8_t *)small.pixels)[4 * (row * (int)frame.width + column) + (int)(i % 4)];
            low = MIN(low, value);
            high = MAX(high, value);
        }
        if (w.bytes[i] < low - 1 || w.bytes[i] > high + 1) fail_msg("pixel %u, %u: %d, not %d .. %d", x, y, w.bytes[i], low, high);
    }
    fnl_image_free(NULL, &small);
    free(whole);
}

/* What lies over the picture counts in the image's pixels, wherever the part is, and stays inside of it. */
static void test_overlays_keep_their_place(void **state) {
    UNUSED(state);
    static const fnl_overlay_vertex corners[] = {
        {{30, 2}, {0, 0}, {255, 128, 0, 255}}, {{70, 2}, {0, 0}, {255, 128, 0, 255}}, {{30, 35}, {0, 0}, {255, 128, 0, 255}}, {{70, 35}, {0, 0}, {255, 128, 0, 255}}};
    static const uint32_t indices[] = {0, 1, 2, 2, 1, 3};
    const fnl_overlay_draw draw = {.index_count = 6, .x = -3, .y = 5, .width = 58, .height = 100};
    const fnl_overlay overlay = {.vertices = corners, .vertex_count = 4, .indices = indices, .index_count = 6, .draws = &draw, .draw_count = 1};
    for (int fitted = 0; fitted < 2; fitted++) {
        const fnl_vulkan_part part = {.x = 21, .y = 10, .width = 37, .height = 31, .fitted = fitted};
        const fnl_vulkan_target target = target_with(part);
        fnl_frame frame = fitted ? small_frame(part.width, part.height) : small_frame(WIDTH, HEIGHT);
        fnl_image image = expected(frame);
        for (uint32_t y = 0; y < image.height; y++)
            for (uint32_t x = 0; x < image.width; x++) {
                const uint32_t place_x = x + (fitted ? part.x : 0), place_y = y + (fitted ? part.y : 0);
                if (place_x >= 30 && place_x < 55 && place_y >= 5 && place_y < 35)
                    memcpy((uint8_t *)image.pixels + 4 * (y * image.width + x), (uint8_t[4]){255, 128, 0, 255}, 4);
            }
        frame.overlay = &overlay;
        render_over(&frame, &target);
        assert_part(&part, &image, fitted ? 0 : part.x, fitted ? 0 : part.y);
        fnl_image_free(NULL, &image);
    }
}

/* Two renderers fill one image, one after the other. */
static void test_two_renderers_share_an_image(void **state) {
    UNUSED(state);
    fnl_frame left = small_frame(WIDTH, HEIGHT), right = left;
    right.debug = FNL_DEBUG_NORMAL;
    fnl_image images[2] = {expected(left), expected(right)};
    fnl_vulkan_target target = target_with((fnl_vulkan_part){.width = 30, .height = HEIGHT});
    target.initial_layout = VK_IMAGE_LAYOUT_UNDEFINED;
    target.final_layout = VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL;
    FNL(fnl_renderer_render_to(w.renderer, &left, &target));
    target = target_with((fnl_vulkan_part){.x = 30, .width = WIDTH - 30, .height = HEIGHT});
    target.initial_layout = VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL;
    FNL(fnl_renderer_render_to(w.reference, &right, &target));
    copy(false);
    for (uint32_t i = 0; i < PIXELS * 4; i++) assert_int_equal(w.bytes[i], ((const uint8_t *)images[i / 4 % WIDTH >= 30].pixels)[i]);
    fnl_image_free(NULL, &images[0]);
    fnl_image_free(NULL, &images[1]);
}

/* Each view writes the part of its own layer. */
static void test_views_write_their_layers(void **state) {
    UNUSED(state);
    fnl_frame frame = small_frame(WIDTH, HEIGHT);
    fnl_camera cameras[2] = {frame.camera, frame.camera};
    cameras[1].position.x += 0.5f;
    frame.views = cameras;
    frame.view_count = 2;
    fnl_image image = expected(frame);
    fnl_vulkan_target target = target_with((fnl_vulkan_part){.x = 60, .y = 1, .width = 11, .height = 44});
    render_over(&frame, &target);
    for (uint32_t i = 0; i < BYTES; i++)
        assert_int_equal(w.bytes[i], inside(&target.part, i / 4 % WIDTH, i / 4 % PIXELS / WIDTH) ? ((const uint8_t *)image.pixels)[i] : pattern(i));
    target.part.fitted = true; /* would have to be scaled */
    assert_int_equal(fnl_renderer_render_to(w.renderer, &frame, &target), FNL_ERROR_UNSUPPORTED);
    fnl_image_free(NULL, &image);
}

static void test_parts_outside_are_refused(void **state) {
    UNUSED(state);
    static const fnl_vulkan_part bad[] = {{0, 0, WIDTH + 1, HEIGHT, false}, {0, 0, WIDTH, HEIGHT + 1, false}, {1, 0, WIDTH, HEIGHT, false},
                                          {0, 1, 4, HEIGHT, true},          {WIDTH, 0, 1, 1, false},          {0, HEIGHT, 1, 1, true},
                                          {3, 0, 0, 0, false},              {0, 0, 4, 0, false},              {0, 0, 0, 4, true},
                                          {2, 2, UINT32_MAX, 1, false},     {UINT32_MAX, 0, 2, 2, true}};
    const fnl_frame frame = small_frame(WIDTH, HEIGHT);
    for (size_t i = 0; i < COUNT_OF(bad); i++) {
        const fnl_vulkan_target target = target_with(bad[i]);
        w.last_error[0] = 0;
        assert_int_equal(fnl_renderer_render_to(w.renderer, &frame, &target), FNL_ERROR_INVALID);
        if (!strstr(w.last_error, "target.part")) fail_msg("case %zu: '%s' does not name the part", i, w.last_error);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_only_the_part_is_written),   cmocka_unit_test(test_fitted_pictures_fill_the_part), cmocka_unit_test(test_scaled_pictures),
        cmocka_unit_test(test_overlays_keep_their_place),  cmocka_unit_test(test_two_renderers_share_an_image),  cmocka_unit_test(test_views_write_their_layers),
        cmocka_unit_test(test_parts_outside_are_refused),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
