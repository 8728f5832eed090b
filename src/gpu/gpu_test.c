/* SPDX-License-Identifier: MIT */
#include "tests/gpu_test.h"
#include "shaders.h"

/* ---- host ---- */

static void log_line(void *user, fnl_log_level level, const char *line) {
    struct test_memory *memory = user;
    if (strncmp(line, "validation: ", 12) == 0) print_error("%s\n", line);
    if (level < FNL_LOG_ERROR) return;
    atomic_fetch_add(&memory->errors, 1);
    snprintf(memory->last_error, sizeof memory->last_error, "%s", line);
}

fnl_host test_host(struct test_memory *memory) {
    fnl_host host = fnl_host_default();
    host.user = memory;
    host.reallocate = test_memory_reallocate;
    host.log = log_line;
    host.thread_count = 2;
    return host;
}

/* ---- device ---- */

gpu_device *test_device_create(struct test_memory *memory) {
    fnl_device_params params = fnl_device_params_default();
    if (memory) params.host = test_host(memory);
    params.validate = true;
    params.cache_folder = "";
    gpu_device *device;
    assert_int_equal(fnl_device_create(&params, &device), FNL_OK);
    return device;
}

void test_device_destroy(gpu_device **device) {
    assert_int_equal(gpu_wait_idle(*device), FNL_OK);
    uint64_t messages = fnl_device_validation_count(*device);
    fnl_device_destroy(device);
    assert_null(*device);
    assert_int_equal(messages, 0);
}

void test_run(gpu_device *device, void (*record)(struct gpu_commands *commands, void *context), void *context) {
    assert_int_equal(gpu_frame_begin(device), FNL_OK);
    struct gpu_commands *commands = gpu_commands_begin(device, GPU_QUEUE_GRAPHICS, 0);
    record(commands, context);
    test_barrier(commands);
    gpu_commands_end(commands);
    struct gpu_batch batch = {.commands = &commands, .command_count = 1, .wait_batch = GPU_NO_INDEX};
    assert_int_equal(gpu_frame_end(device, &batch, 1, NULL), FNL_OK);
    assert_int_equal(gpu_frame_wait(device, gpu_frame_number(device)), FNL_OK);
}

/* ---- commands ---- */

void test_barrier(struct gpu_commands *commands) {
    gpu_barrier(commands, NULL, 0, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, VK_ACCESS_2_MEMORY_WRITE_BIT,
                VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT | VK_PIPELINE_STAGE_2_HOST_BIT,
                VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT | VK_ACCESS_2_HOST_READ_BIT);
}

void test_transition(struct gpu_commands *commands, const struct gpu_image *image, VkImageLayout from, VkImageLayout to) {
    struct gpu_image_barrier barrier = {
        .image = image,
        .from_stages = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
        .to_stages = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
        .from_access = VK_ACCESS_2_MEMORY_WRITE_BIT,
        .to_access = VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT,
        .from_layout = from,
        .to_layout = to,
    };
    gpu_barrier(commands, &barrier, 1, 0, 0, 0, 0);
}

void test_dispatch(struct gpu_commands *commands, enum test_mode mode, uint32_t factor, const struct test_push *push) {
    struct gpu_compute_params params;
    memset(&params, 0, sizeof params);
    params.shader = &shader_gpu_test_comp;
    params.constant_count = 2;
    params.constants[0] = mode;
    params.constants[1] = factor;
    gpu_bind(commands, gpu_compute_pipeline(gpu_commands_device(commands), &params));
    gpu_push(commands, push, sizeof *push);
    gpu_dispatch(commands, DIVIDE_UP(push->count, 64), 1, 1);
}

uint64_t test_ask(gpu_device *device, uint32_t first, uint32_t count) {
    assert_int_equal(gpu_frame_begin(device), FNL_OK);
    struct gpu_commands *commands = gpu_ask_begin(device);
    for (uint32_t i = 0; i < count; i++) test_dispatch(commands, TEST_MULTIPLY, first + i, &(struct test_push){.count = 1});
    uint64_t ticket = gpu_ask_end(device);
    assert_int_equal(gpu_frame_end(device, NULL, 0, NULL), FNL_OK);
    return ticket;
}

static void record_fetch(struct gpu_commands *commands, void *context) { test_dispatch(commands, TEST_FETCH, 0, context); }

void test_fetch_mip(gpu_device *device, const struct gpu_image *image, uint32_t mip, fnl_vec4 *out) {
    uint32_t width = MAX(1u, image->params.width >> mip), height = MAX(1u, image->params.height >> mip);
    struct gpu_buffer buffer;
    assert_int_equal(gpu_buffer_create(device, "texels", sizeof(fnl_vec4) * width * height, GPU_MEMORY_READBACK, &buffer),
                     FNL_OK);
    struct test_push push = {
        .to = buffer.address, .count = width * height, .width = width, .lod = mip, .image = image->sampled_index};
    test_run(device, record_fetch, &push);
    memcpy(out, buffer.mapped, sizeof(fnl_vec4) * width * height);
    gpu_buffer_destroy(device, &buffer);
}

int main(void) {
    int failed = 0;
    failed += _cmocka_run_group_tests("gpu: device", device_tests, device_test_count, NULL, NULL);
    failed += _cmocka_run_group_tests("gpu: memory", memory_tests, memory_test_count, NULL, NULL);
    failed += _cmocka_run_group_tests("gpu: commands", commands_tests, commands_test_count, NULL, NULL);
    failed += _cmocka_run_group_tests("gpu: draws", draw_tests, draw_test_count, NULL, NULL);
    failed += _cmocka_run_group_tests("gpu: scopes", scope_tests, scope_test_count, NULL, NULL);
    failed += _cmocka_run_group_tests("gpu: pipelines ahead", ahead_tests, ahead_test_count, NULL, NULL);
    failed += _cmocka_run_group_tests("gpu: pipeline cache", cache_tests, cache_test_count, NULL, NULL);
    failed += _cmocka_run_group_tests("gpu: acceleration structures", structure_tests, structure_test_count, NULL, NULL);
    failed += _cmocka_run_group_tests("gpu: specialised shaders", specialise_tests, specialise_test_count, NULL, NULL);
    return failed;
}
