/* SPDX-License-Identifier: MIT */
/*
 * Pictures for a surface without a window (VK_EXT_headless_surface): acquired, rendered to, presented, at changing sizes, with validation. What arrives
 * on a screen is compared in tests/cli/view_test.sh.
 */
#include "base/base.h"
#include "fanal/fanal.h"
#include "fanal/vulkan.h"
#include "tests/frame_plain.h"

#include <setjmp.h>
#include <vulkan/vulkan.h>

#include <cmocka.h>

static struct {
    fnl_device *device;
    fnl_scene *scene;
    fnl_renderer *renderer;
    fnl_vulkan_handles handles;
    char last_error[1024];
} w;

static void keep_error(void *user, fnl_log_level level, const char *line) {
    UNUSED(user);
    if (level == FNL_LOG_ERROR) snprintf(w.last_error, sizeof w.last_error, "%s", line);
}

static fnl_device *make_device(bool presentation) {
    fnl_device_params params = fnl_device_params_default();
    params.host.log = keep_error;
    params.validate = true;
    params.presentation = presentation;
    params.cache_folder = "";
    fnl_device *device = NULL;
    assert_int_equal(fnl_device_create(&params, &device), FNL_OK);
    return device;
}

static int set_up(void **state) {
    UNUSED(state);
    w.device = make_device(true);
    assert_int_equal(fnl_device_query_vulkan(w.device, &w.handles), FNL_OK);
    assert_int_equal(scene_load_plain(NULL, "builtin:onetile", NULL, &w.scene), FNL_OK);
    assert_int_equal(fnl_renderer_create(w.device, w.scene, &w.renderer), FNL_OK);
    return 0;
}

static int tear_down(void **state) {
    UNUSED(state);
    fnl_renderer_destroy(&w.renderer);
    fnl_scene_destroy(&w.scene);
    assert_int_equal(fnl_device_validation_count(w.device), 0);
    fnl_device_destroy(&w.device);
    return 0;
}

static VkSurfaceKHR make_surface(void) {
    PFN_vkCreateHeadlessSurfaceEXT create =
        (PFN_vkCreateHeadlessSurfaceEXT)w.handles.get_instance_proc_addr(w.handles.instance, "vkCreateHeadlessSurfaceEXT");
    const VkHeadlessSurfaceCreateInfoEXT info = {.sType = VK_STRUCTURE_TYPE_HEADLESS_SURFACE_CREATE_INFO_EXT};
    VkSurfaceKHR surface = VK_NULL_HANDLE;
    assert_non_null(create);
    assert_int_equal(create(w.handles.instance, &info, NULL, &surface), VK_SUCCESS);
    return surface;
}

static fnl_swapchain *make_swapchain(const fnl_swapchain_params *params) {
    fnl_swapchain *swapchain = NULL;
    assert_int_equal(fnl_swapchain_create(w.device, make_surface(), params, &swapchain), FNL_OK);
    return swapchain;
}

static fnl_frame small_frame(void) {
    fnl_frame frame = frame_plain();
    frame.width = 40;
    frame.height = 24;
    frame.lists = FNL_LISTS_ALL;
    frame.shading = FNL_SHADING_FORWARD;
    return frame;
}

static void show(fnl_swapchain *swapchain, uint32_t width, uint32_t height) {
    const fnl_frame frame = small_frame();
    fnl_vulkan_target target;
    assert_int_equal(fnl_swapchain_acquire(swapchain, &target), FNL_OK);
    assert_true(target.image != VK_NULL_HANDLE);
    assert_int_equal(target.width, width);
    assert_int_equal(target.height, height);
    assert_int_equal(fnl_renderer_render_to(w.renderer, &frame, &target), FNL_OK);
    assert_int_equal(fnl_swapchain_present(swapchain), FNL_OK);
}

/* More frames than there are images and semaphores, then at other sizes. The chain is made once for each. */
static void test_pictures_go_round_at_any_size(void **state) {
    UNUSED(state);
    fnl_swapchain_params params = fnl_swapchain_params_default();
    fnl_swapchain_info info;
    params.width = 64;
    params.height = 48;
    fnl_swapchain *swapchain = make_swapchain(&params);
    for (uint32_t i = 0; i < 9; i++) show(swapchain, 64, 48);
    assert_int_equal(fnl_swapchain_query_info(swapchain, &info), FNL_OK);
    assert_int_equal(info.made, 1);
    assert_true(info.image_count >= 2 && info.width == 64 && info.height == 48);
    params.width = 33;
    params.height = 21;
    params.present = FNL_PRESENT_MAILBOX;
    assert_int_equal(fnl_swapchain_set(swapchain, &params), FNL_OK);
    for (uint32_t i = 0; i < 5; i++) show(swapchain, 33, 21);
    assert_int_equal(fnl_swapchain_set(swapchain, &params), FNL_OK); /* the same: nothing is made */
    show(swapchain, 33, 21);
    assert_int_equal(fnl_swapchain_query_info(swapchain, &info), FNL_OK);
    assert_int_equal(info.made, 2);
    fnl_swapchain_destroy(&swapchain);
    assert_null(swapchain);
}

/* A window without area has no picture; with one again it has. */
static void test_minimised_windows_have_no_picture(void **state) {
    UNUSED(state);
    fnl_swapchain_params params = fnl_swapchain_params_default();
    fnl_vulkan_target target;
    fnl_swapchain_info info;
    params.width = 0;
    fnl_swapchain *swapchain = make_swapchain(&params);
    for (uint32_t i = 0; i < 2; i++) {
        assert_int_equal(fnl_swapchain_acquire(swapchain, &target), FNL_OK);
        assert_true(target.image == VK_NULL_HANDLE);
    }
    assert_int_equal(fnl_swapchain_query_info(swapchain, &info), FNL_OK);
    assert_int_equal(info.made, 0);
    assert_int_equal(fnl_swapchain_present(swapchain), FNL_ERROR_INVALID);
    params.width = 50;
    params.height = 30;
    assert_int_equal(fnl_swapchain_set(swapchain, &params), FNL_OK);
    show(swapchain, 50, 30);
    params.height = 0;
    assert_int_equal(fnl_swapchain_set(swapchain, &params), FNL_OK);
    assert_int_equal(fnl_swapchain_acquire(swapchain, &target), FNL_OK);
    assert_true(target.image == VK_NULL_HANDLE);
    fnl_swapchain_destroy(&swapchain);
}

/* What was acquired and not presented comes again, also after a frame that was refused; and a chain may go while it holds one. */
static void test_pictures_that_were_not_presented_come_again(void **state) {
    UNUSED(state);
    fnl_swapchain_params params = fnl_swapchain_params_default();
    fnl_vulkan_target first, second;
    fnl_frame frame = small_frame();
    params.width = params.height = 32;
    fnl_swapchain *swapchain = make_swapchain(&params);
    assert_int_equal(fnl_swapchain_acquire(swapchain, &first), FNL_OK);
    frame.msaa = 3;
    assert_int_equal(fnl_renderer_render_to(w.renderer, &frame, &first), FNL_ERROR_INVALID);
    assert_int_equal(fnl_swapchain_acquire(swapchain, &second), FNL_OK);
    assert_true(first.image == second.image && first.wait == second.wait);
    show(swapchain, 32, 32);
    assert_int_equal(fnl_swapchain_present(swapchain), FNL_ERROR_INVALID);
    assert_int_equal(fnl_swapchain_acquire(swapchain, &first), FNL_OK);
    fnl_swapchain_destroy(&swapchain);
}

/* ---- windows as no test machine has them: between Fanal and Vulkan stand functions that answer as the test wants ---- */

static struct {
    VkSurfaceFormatKHR formats[8];
    uint32_t format_count;
    VkResult acquire, present; /* VK_SUCCESS: as Vulkan answers */
    VkSwapchainCreateInfoKHR asked;
    PFN_vkGetDeviceProcAddr device_proc;
    PFN_vkCreateSwapchainKHR create;
    PFN_vkAcquireNextImageKHR acquire_next;
    PFN_vkQueuePresentKHR queue_present;
} fake;

static VKAPI_ATTR VkResult VKAPI_CALL fake_formats(VkPhysicalDevice physical, VkSurfaceKHR surface, uint32_t *count, VkSurfaceFormatKHR *out) {
    UNUSED(physical);
    UNUSED(surface);
    *count = fake.format_count;
    if (out) memcpy(out, fake.formats, fake.format_count * sizeof *out);
    return VK_SUCCESS;
}
/* Notes what was asked for, and makes what there is. */
static VKAPI_ATTR VkResult VKAPI_CALL fake_create(VkDevice device, const VkSwapchainCreateInfoKHR *info, const VkAllocationCallbacks *allocator, VkSwapchainKHR *out) {
    VkSwapchainCreateInfoKHR real = *info;
    fake.asked = *info;
    real.imageFormat = VK_FORMAT_B8G8R8A8_UNORM;
    real.imageColorSpace = VK_COLOR_SPACE_SRGB_NONLINEAR_KHR;
    return fake.create(device, &real, allocator, out);
}
static VKAPI_ATTR VkResult VKAPI_CALL fake_acquire(VkDevice device, VkSwapchainKHR chain, uint64_t timeout, VkSemaphore semaphore, VkFence fence, uint32_t *out) {
    const VkResult answer = fake.acquire;
    fake.acquire = VK_SUCCESS;
    return answer == VK_SUCCESS ? fake.acquire_next(device, chain, timeout, semaphore, fence, out) : answer;
}
static VKAPI_ATTR VkResult VKAPI_CALL fake_present(VkQueue queue, const VkPresentInfoKHR *info) {
    const VkResult answer = fake.present, real = fake.queue_present(queue, info);
    fake.present = VK_SUCCESS;
    return answer == VK_SUCCESS ? real : answer;
}
static VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL fake_device_proc(VkDevice device, const char *name) {
    if (strcmp(name, "vkCreateSwapchainKHR") == 0) return (PFN_vkVoidFunction)fake_create;
    if (strcmp(name, "vkAcquireNextImageKHR") == 0) return (PFN_vkVoidFunction)fake_acquire;
    if (strcmp(name, "vkQueuePresentKHR") == 0) return (PFN_vkVoidFunction)fake_present;
    return fake.device_proc(device, name);
}
static VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL fake_proc(VkInstance instance, const char *name) {
    if (strcmp(name, "vkGetDeviceProcAddr") == 0) return (PFN_vkVoidFunction)fake_device_proc;
    if (strcmp(name, "vkGetPhysicalDeviceSurfaceFormatsKHR") == 0) return (PFN_vkVoidFunction)fake_formats;
    return w.handles.get_instance_proc_addr(instance, name);
}

/* The same Vulkan device again, behind these functions. */
static fnl_device *make_fake_device(void) {
    fnl_device_params params = fnl_device_params_default();
    params.host.log = keep_error;
    params.cache_folder = "";
    const fnl_vulkan_import import = {.get_instance_proc_addr = fake_proc,
                                      .instance = w.handles.instance,
                                      .physical_device = w.handles.physical_device,
                                      .device = w.handles.device,
                                      .graphics_family = w.handles.graphics_family,
                                      .graphics_queue = w.handles.graphics_queue};
    fake.device_proc = (PFN_vkGetDeviceProcAddr)w.handles.get_instance_proc_addr(w.handles.instance, "vkGetDeviceProcAddr");
    fake.create = (PFN_vkCreateSwapchainKHR)fake.device_proc(w.handles.device, "vkCreateSwapchainKHR");
    fake.acquire_next = (PFN_vkAcquireNextImageKHR)fake.device_proc(w.handles.device, "vkAcquireNextImageKHR");
    fake.queue_present = (PFN_vkQueuePresentKHR)fake.device_proc(w.handles.device, "vkQueuePresentKHR");
    fnl_device *device = NULL;
    assert_int_equal(fnl_device_import(&params, &import, &device), FNL_OK);
    return device;
}

/* The best format of what was asked for; sRGB where there is none of it. */
static void test_formats_are_chosen_by_colour_space(void **state) {
    UNUSED(state);
    static const VkSurfaceFormatKHR srgb = {VK_FORMAT_R8G8B8A8_UNORM, VK_COLOR_SPACE_SRGB_NONLINEAR_KHR},
                                    other = {VK_FORMAT_A2B10G10R10_UNORM_PACK32, VK_COLOR_SPACE_SRGB_NONLINEAR_KHR},
                                    hdr10 = {VK_FORMAT_A2R10G10B10_UNORM_PACK32, VK_COLOR_SPACE_HDR10_ST2084_EXT},
                                    scrgb = {VK_FORMAT_R16G16B16A16_SFLOAT, VK_COLOR_SPACE_EXTENDED_SRGB_LINEAR_EXT};
    const struct {
        VkSurfaceFormatKHR formats[4];
        uint32_t count;
        fnl_color_space asked, wanted;
        VkFormat format;
    } cases[] = {{{other, srgb, scrgb, hdr10}, 4, FNL_COLOR_SRGB, FNL_COLOR_SRGB, srgb.format},
                 {{other, srgb, scrgb, hdr10}, 4, FNL_COLOR_SCRGB, FNL_COLOR_SCRGB, scrgb.format},
                 {{other, srgb, scrgb, hdr10}, 4, FNL_COLOR_HDR10, FNL_COLOR_HDR10, hdr10.format},
                 {{other, srgb}, 2, FNL_COLOR_HDR10, FNL_COLOR_SRGB, srgb.format},
                 {{hdr10, srgb}, 2, FNL_COLOR_SCRGB, FNL_COLOR_SRGB, srgb.format}};
    fnl_device *device = make_fake_device();
    fnl_swapchain_params params = fnl_swapchain_params_default();
    fnl_swapchain_info info;
    fnl_swapchain *swapchain = NULL;
    params.width = params.height = 16;
    for (uint32_t i = 0; i < COUNT_OF(cases); i++) {
        memcpy(fake.formats, cases[i].formats, sizeof cases[i].formats);
        fake.format_count = cases[i].count;
        params.color = cases[i].asked;
        assert_int_equal(fnl_swapchain_create(device, make_surface(), &params, &swapchain), FNL_OK);
        assert_int_equal(fnl_swapchain_query_info(swapchain, &info), FNL_OK);
        assert_int_equal(info.color, cases[i].wanted);
        assert_int_equal(info.format, cases[i].format);
        assert_int_equal(fake.asked.imageFormat, cases[i].format);
        fnl_swapchain_destroy(&swapchain);
    }
    fake.format_count = 1; /* 10 bits of sRGB alone: Fanal does not write that */
    assert_int_equal(fnl_swapchain_create(device, make_surface(), &params, &swapchain), FNL_ERROR_UNSUPPORTED);
    fnl_device_destroy(&device);
}

/* A chain that is out of date is made anew, and the picture comes from the new one. A surface that is lost is an error of the device, and another can be made. */
static void test_windows_change_and_are_lost(void **state) {
    UNUSED(state);
    fnl_device *device = make_fake_device();
    fnl_renderer *renderer = NULL;
    assert_int_equal(fnl_renderer_create(device, w.scene, &renderer), FNL_OK);
    fnl_swapchain_params params = fnl_swapchain_params_default();
    fnl_swapchain_info info;
    fnl_swapchain *swapchain = NULL;
    fnl_vulkan_target target;
    const fnl_frame frame = small_frame();
    fake.formats[0] = (VkSurfaceFormatKHR){VK_FORMAT_B8G8R8A8_UNORM, VK_COLOR_SPACE_SRGB_NONLINEAR_KHR};
    fake.format_count = 1;
    params.width = params.height = 16;
    assert_int_equal(fnl_swapchain_create(device, make_surface(), &params, &swapchain), FNL_OK);
    static const VkResult answers[] = {VK_ERROR_OUT_OF_DATE_KHR, VK_SUBOPTIMAL_KHR};
    for (uint32_t i = 0; i < COUNT_OF(answers); i++) {
        fake.present = answers[i];
        for (uint32_t k = 0; k < 2; k++) {
            assert_int_equal(fnl_swapchain_acquire(swapchain, &target), FNL_OK);
            assert_int_equal(fnl_renderer_render_to(renderer, &frame, &target), FNL_OK);
            assert_int_equal(fnl_swapchain_present(swapchain), FNL_OK);
        }
        assert_int_equal(fnl_swapchain_query_info(swapchain, &info), FNL_OK);
        assert_int_equal(info.made, i + 2);
    }
    fake.acquire = VK_ERROR_OUT_OF_DATE_KHR;
    assert_int_equal(fnl_swapchain_acquire(swapchain, &target), FNL_OK);
    assert_true(target.image != VK_NULL_HANDLE);
    assert_int_equal(fnl_swapchain_query_info(swapchain, &info), FNL_OK);
    assert_int_equal(info.made, 4);
    assert_int_equal(fnl_renderer_render_to(renderer, &frame, &target), FNL_OK);
    fake.present = VK_ERROR_SURFACE_LOST_KHR;
    assert_int_equal(fnl_swapchain_present(swapchain), FNL_ERROR_DEVICE);
    fake.acquire = VK_ERROR_SURFACE_LOST_KHR;
    assert_int_equal(fnl_swapchain_acquire(swapchain, &target), FNL_ERROR_DEVICE);
    assert_true(target.image == VK_NULL_HANDLE);
    fnl_swapchain_destroy(&swapchain);
    assert_int_equal(fnl_swapchain_create(device, make_surface(), &params, &swapchain), FNL_OK);
    assert_int_equal(fnl_swapchain_acquire(swapchain, &target), FNL_OK);
    assert_int_equal(fnl_renderer_render_to(renderer, &frame, &target), FNL_OK);
    assert_int_equal(fnl_swapchain_present(swapchain), FNL_OK);
    fnl_swapchain_destroy(&swapchain);
    fnl_renderer_destroy(&renderer);
    fnl_device_destroy(&device);
}

static void test_misuse_is_refused(void **state) {
    UNUSED(state);
    fnl_swapchain *swapchain = NULL;
    fnl_swapchain_params params = fnl_swapchain_params_default();
    assert_int_equal(fnl_swapchain_create(w.device, VK_NULL_HANDLE, NULL, &swapchain), FNL_ERROR_INVALID);
    params.width = 16385;
    assert_int_equal(fnl_swapchain_create(w.device, make_surface(), &params, &swapchain), FNL_ERROR_INVALID); /* and the surface is gone */
    assert_non_null(strstr(w.last_error, "width"));
    params.width = 8;
    params.present = (fnl_present)FNL_PRESENT_COUNT;
    assert_int_equal(fnl_swapchain_create(w.device, make_surface(), &params, &swapchain), FNL_ERROR_INVALID);
    params.present = FNL_PRESENT_FIFO;
    params.color = (fnl_color_space)FNL_COLOR_SPACE_COUNT;
    assert_int_equal(fnl_swapchain_create(w.device, make_surface(), &params, &swapchain), FNL_ERROR_INVALID);
    fnl_device *plain = make_device(false);
    assert_int_equal(fnl_swapchain_create(plain, (VkSurfaceKHR)(uintptr_t)1, NULL, &swapchain), FNL_ERROR_UNSUPPORTED);
    assert_non_null(strstr(w.last_error, "without presentation"));
    fnl_device_destroy(&plain);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_pictures_go_round_at_any_size),
        cmocka_unit_test(test_minimised_windows_have_no_picture),
        cmocka_unit_test(test_pictures_that_were_not_presented_come_again),
        cmocka_unit_test(test_formats_are_chosen_by_colour_space),
        cmocka_unit_test(test_windows_change_and_are_lost),
        cmocka_unit_test(test_misuse_is_refused),
    };
    return cmocka_run_group_tests_name("render: swapchain", tests, set_up, tear_down);
}
