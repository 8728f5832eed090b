/* SPDX-License-Identifier: MIT */
#include "base/file.h"
#include "fanal/vulkan.h"
#include "tests/gpu_test.h"

#include <dirent.h>
#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

static void test_devices_are_listed_and_described(void **state) {
    UNUSED(state);
    fnl_device_info infos[8];
    uint32_t count = 0;
    assert_int_equal(fnl_enumerate_devices(NULL, infos, COUNT_OF(infos), &count), FNL_OK);
    assert_true(count > 0);
    assert_true(infos[0].name[0] && infos[0].memory_bytes > 0 && infos[0].max_msaa >= 4);
    assert_true(!infos[0].multiview || infos[0].max_views >= 6); /* as Vulkan demands */
    assert_true(infos[0].usable == !infos[0].missing[0]);
    fnl_device_params params = fnl_device_params_default();
    params.index = 0;
    params.cache_folder = "";
    gpu_device *device;
    assert_int_equal(fnl_device_create(&params, &device), FNL_OK);
    fnl_device_info info;
    assert_int_equal(fnl_device_query_info(device, &info), FNL_OK);
    assert_string_equal(info.name, infos[0].name);
    assert_string_equal(info.driver, infos[0].driver);
    assert_int_equal(fnl_device_validation_count(device), 0);
    fnl_device_destroy(&device);
    fnl_device_destroy(&device);
    fnl_device_destroy(NULL);
}

static void test_a_machine_without_a_driver(void **state) {
    UNUSED(state);
    static const char *const variables[] = {"VK_DRIVER_FILES", "VK_ICD_FILENAMES"}; /* the loader's new and old name */
    for (uint32_t i = 0; i < 2; i++) {
        if (getenv(variables[i])) skip(); /* it would be lost for the tests that follow */
        setenv(variables[i], "/no/such/driver.json", 1);
    }
    struct test_memory memory = {0};
    fnl_device_params params = fnl_device_params_default();
    params.host = test_host(&memory);
    uint32_t count = 9;
    assert_int_equal(fnl_enumerate_devices(&params.host, NULL, 0, &count), FNL_OK);
    assert_int_equal(count, 0);
    assert_int_equal(memory.errors, 0);
    gpu_device *device;
    assert_int_equal(fnl_device_create(&params, &device), FNL_ERROR_DEVICE);
    assert_null(device);
    assert_int_equal(memory.errors, 1);
    assert_int_equal(memory.live_bytes, 0);
    for (uint32_t i = 0; i < 2; i++) unsetenv(variables[i]);
}

static void test_a_device_that_is_not_there_is_refused(void **state) {
    UNUSED(state);
    struct test_memory memory = {0};
    fnl_device_params params = fnl_device_params_default();
    params.host = test_host(&memory);
    params.index = 1000;
    gpu_device *device = (gpu_device *)&params;
    assert_int_equal(fnl_device_create(&params, &device), FNL_ERROR_DEVICE);
    assert_null(device);
    assert_non_null(strstr(memory.last_error, "no device 1000"));
    params.index = -1;
    params.name = "No Such Device";
    assert_int_equal(fnl_device_create(&params, &device), FNL_ERROR_DEVICE);
    assert_non_null(strstr(memory.last_error, "No Such Device"));
    assert_true(atomic_load(&memory.errors) >= 3); /* also one line for each device */
    params.index = -2;
    assert_int_equal(fnl_device_create(&params, &device), FNL_ERROR_INVALID);
    assert_int_equal(memory.live_bytes, 0);
    assert_int_equal(memory.wrong_sizes, 0);
}

static void test_two_devices_at_once(void **state) {
    UNUSED(state);
    gpu_device *a = test_device_create(NULL), *b = test_device_create(NULL);
    struct gpu_buffer in_a, in_b;
    assert_int_equal(gpu_buffer_create(a, "a", 64, GPU_MEMORY_DEVICE, &in_a), FNL_OK);
    assert_int_equal(gpu_buffer_create(b, "b", 64, GPU_MEMORY_DEVICE, &in_b), FNL_OK);
    uint32_t sent = 7, got = 0;
    assert_int_equal(gpu_upload_buffer(b, &in_b, 0, &sent, 4), FNL_OK);
    gpu_buffer_destroy(a, &in_a);
    test_device_destroy(&a);
    assert_int_equal(gpu_read_buffer(b, &in_b, 0, &got, 4), FNL_OK);
    assert_int_equal(got, 7);
    gpu_buffer_destroy(b, &in_b);
    test_device_destroy(&b);
}

static void record_copy(struct gpu_commands *commands, void *context) {
    struct gpu_buffer *buffers = context;
    test_dispatch(commands, TEST_MULTIPLY, 3,
                  &(struct test_push){.from = buffers[0].address, .to = buffers[1].address, .count = 2, .width = 1});
}

static void check_device_works(gpu_device *device) {
    struct gpu_buffer buffers[2];
    assert_int_equal(gpu_buffer_create(device, "from", 8, GPU_MEMORY_UPLOAD, &buffers[0]), FNL_OK);
    assert_int_equal(gpu_buffer_create(device, "to", 8, GPU_MEMORY_READBACK, &buffers[1]), FNL_OK);
    memcpy(buffers[0].mapped, (uint32_t[]){5, 6}, 8);
    test_run(device, record_copy, buffers);
    assert_memory_equal(buffers[1].mapped, ((uint32_t[]){16, 19}), 8);
    gpu_buffer_destroy(device, &buffers[0]);
    gpu_buffer_destroy(device, &buffers[1]);
}

static void test_a_callers_device_is_imported(void **state) {
    UNUSED(state);
    fnl_host host = fnl_host_default();
    struct gpu_instance own;
    assert_int_equal(gpu_instance_open(&own, &host, &(struct gpu_instance_params){.validate = true}), FNL_OK);
    VkPhysicalDevice physical;
    uint32_t count = 1;
    assert_true(own.vk.EnumeratePhysicalDevices(own.handle, &count, &physical) >= 0 && count == 1);
    fnl_vulkan_requirements requirements;
    fnl_vulkan_requirements_init(&requirements);
    float priority = 1;
    VkDeviceQueueCreateInfo queue_info = {
        .sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO, .queueCount = 1, .pQueuePriorities = &priority};
    VkDeviceCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
        .pNext = &requirements.features,
        .queueCreateInfoCount = 1,
        .pQueueCreateInfos = &queue_info,
    };
    fnl_vulkan_import import = {.get_instance_proc_addr = own.get_proc, .instance = own.handle, .physical_device = physical};
    assert_int_equal(own.vk.CreateDevice(physical, &info, NULL, &import.device), VK_SUCCESS);
    PFN_vkGetDeviceQueue get_queue = (PFN_vkGetDeviceQueue)own.vk.GetDeviceProcAddr(import.device, "vkGetDeviceQueue");
    get_queue(import.device, 0, 0, &import.graphics_queue);

    fnl_device_params params = fnl_device_params_default();
    params.validate = true;
    params.cache_folder = "";
    for (int round = 0; round < 2; round++) { /* the caller's device survives */
        gpu_device *device;
        assert_int_equal(fnl_device_import(&params, &import, &device), FNL_OK);
        assert_false(gpu_info(device)->async_compute);
        check_device_works(device);
        assert_int_equal(test_ask(device, 10, 32), 32);
        if (round) /* the caller's device is destroyed with pipelines of it in the making the other time */
            while (gpu_pipeline_stats(device).done < 32) nanosleep(&(struct timespec){.tv_nsec = 1000000}, NULL);
        test_device_destroy(&device);
    }
    struct test_memory memory = {0};
    params.host = test_host(&memory);
    gpu_device *device;
    import.graphics_family = 99;
    assert_int_equal(fnl_device_import(&params, &import, &device), FNL_ERROR_INVALID);
    assert_null(device);
    import.get_instance_proc_addr = NULL;
    assert_int_equal(fnl_device_import(&params, &import, &device), FNL_ERROR_INVALID);
    assert_int_equal(memory.live_bytes, 0);
    PFN_vkDestroyDevice destroy = (PFN_vkDestroyDevice)own.vk.GetDeviceProcAddr(import.device, "vkDestroyDevice");
    destroy(import.device, NULL);
    assert_int_equal(atomic_load(&own.message_count), 0);
    gpu_instance_close(&own);
}

static void test_every_allocation_may_fail(void **state) {
    UNUSED(state);
    bool whole = false;
    int failures = 0;
    for (long long fail_at = 1; !whole; fail_at++) {
        struct test_memory memory = {.fail_at = fail_at};
        fnl_device_params params = fnl_device_params_default();
        params.host = test_host(&memory);
        params.cache_folder = "";
        gpu_device *device;
        struct gpu_buffer buffer = {0};
        struct gpu_image image = {0};
        fnl_result result = fnl_device_create(&params, &device);
        if (result == FNL_OK) {
            struct gpu_image_params image_params = {"image", VK_FORMAT_R8G8B8A8_UNORM,
                                                    4,       4,
                                                    1,       1,
                                                    1,       false,
                                                    false,   VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT, GPU_USE_OTHER};
            uint32_t pixels[16] = {0};
            result = gpu_image_create(device, &image_params, &image);
            if (result == FNL_OK) result = gpu_buffer_create(device, "buffer", 64, GPU_MEMORY_DEVICE, &buffer);
            if (result == FNL_OK) result = gpu_upload_image(device, &image, pixels, sizeof pixels, false, false);
            if (result == FNL_OK) result = gpu_frame_begin(device);
            if (result == FNL_OK) {
                struct gpu_slice slice = gpu_frame_allocate(device, 256);
                struct gpu_commands *commands = gpu_commands_begin(device, GPU_QUEUE_GRAPHICS, 0);
                test_dispatch(commands, TEST_MULTIPLY, 1,
                              &(struct test_push){.from = slice.address, .to = buffer.address, .width = 1});
                gpu_commands_end(commands);
                struct gpu_batch batch = {.commands = &commands, .command_count = 1, .wait_batch = GPU_NO_INDEX};
                result = gpu_frame_end(device, &batch, 1, NULL);
            }
            gpu_image_destroy(device, &image);
            gpu_buffer_destroy(device, &buffer);
        }
        whole = atomic_load(&memory.allocations) < fail_at;
        failures += result != FNL_OK;
        assert_true(result == FNL_OK || result == FNL_ERROR_MEMORY);
        assert_true(!whole || result == FNL_OK);
        fnl_device_destroy(&device);
        assert_int_equal(memory.live_bytes, 0);
        assert_int_equal(memory.wrong_sizes, 0);
    }
    assert_true(failures > 15);
}

static size_t file_size_in(const char *folder, char *path, size_t capacity) {
    DIR *directory = opendir(folder);
    size_t size = 0;
    if (!directory) return 0;
    for (struct dirent *entry; (entry = readdir(directory));) {
        if (strncmp(entry->d_name, "pipelines-", 10) != 0) continue;
        snprintf(path, capacity, "%s/%s", folder, entry->d_name);
        struct file_view view;
        fnl_host host = fnl_host_default();
        if (file_load(&host, path, &view) == FNL_OK) size = view.size;
        file_free(&host, &view);
    }
    closedir(directory);
    return size;
}

static size_t run_with_cache(const char *folder) {
    fnl_device_params params = fnl_device_params_default();
    params.cache_folder = folder;
    params.validate = true;
    gpu_device *device;
    assert_int_equal(fnl_device_create(&params, &device), FNL_OK);
    size_t loaded = device->pipelines.loaded_size;
    check_device_works(device);
    test_device_destroy(&device);
    return loaded;
}

static void test_pipelines_are_kept_in_a_file(void **state) {
    UNUSED(state);
    char base[64], folder[96], path[512];
    snprintf(base, sizeof base, "/tmp/fanal-gpu-test-%d", (int)getpid());
    snprintf(folder, sizeof folder, "%s/deep/er", base);
    assert_int_equal(run_with_cache(folder), 0);
    size_t size = file_size_in(folder, path, sizeof path);
    assert_true(size >= 24 + 32);                        /* our header and, at the least, the driver's */
    assert_int_equal(run_with_cache(folder), size - 24); /* all of it was taken */

    fnl_host host = fnl_host_default();
    struct file_view view;
    assert_int_equal(file_load(&host, path, &view), FNL_OK);
    unsigned char *bytes = calloc(1, view.size + 1);
    memcpy(bytes, view.data, view.size);
    file_free(&host, &view);
    bytes[size - 1] ^= 1;
    assert_int_equal(file_save(&host, path, bytes, size), FNL_OK);
    assert_int_equal(run_with_cache(folder), 0); /* damaged: not used, and written anew */
    assert_int_equal(run_with_cache(folder), size - 24);
    assert_int_equal(file_save(&host, path, bytes, 10), FNL_OK);
    assert_int_equal(run_with_cache(folder), 0);
    bytes[size - 1] ^= 1;
    bytes[8] += 1; /* one byte more, as the size says, but not as the hash says */
    assert_int_equal(file_save(&host, path, bytes, size + 1), FNL_OK);
    assert_int_equal(run_with_cache(folder), 0);
    free(bytes);
    unlink(path);
    rmdir(folder);
    snprintf(folder, sizeof folder, "%s/deep", base);
    rmdir(folder);
    rmdir(base);
    assert_int_equal(run_with_cache("/proc/no/such"), 0); /* a folder that cannot be is no error */
}

/* Whoever holds a lock on the folder does not keep a program from ending. */
static void test_a_lock_on_the_cache_folder_keeps_nobody(void **state) {
    UNUSED(state);
    char folder[64], path[512];
    snprintf(folder, sizeof folder, "/tmp/fanal-gpu-lock-%d", (int)getpid());
    assert_int_equal(mkdir(folder, 0700), 0);
    const int lock = open(folder, O_RDONLY | O_DIRECTORY);
    assert_int_equal(flock(lock, LOCK_SH), 0);
    assert_int_equal(run_with_cache(folder), 0);
    assert_int_equal(file_size_in(folder, path, sizeof path), 0);
    close(lock);
    assert_int_equal(run_with_cache(folder), 0);
    assert_true(file_size_in(folder, path, sizeof path) > 0);
    unlink(path);
    assert_int_equal(rmdir(folder), 0);
}

const struct CMUnitTest device_tests[] = {
    cmocka_unit_test(test_devices_are_listed_and_described),      cmocka_unit_test(test_a_machine_without_a_driver),
    cmocka_unit_test(test_a_device_that_is_not_there_is_refused), cmocka_unit_test(test_two_devices_at_once),
    cmocka_unit_test(test_a_callers_device_is_imported),          cmocka_unit_test(test_every_allocation_may_fail),
    cmocka_unit_test(test_pipelines_are_kept_in_a_file),          cmocka_unit_test(test_a_lock_on_the_cache_folder_keeps_nobody),
};
const size_t device_test_count = COUNT_OF(device_tests);
