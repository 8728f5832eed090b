/* SPDX-License-Identifier: MIT */
#include "tests/gpu_test.h"

#include <math.h>
#include <time.h>

static struct gpu_buffer make_buffer(gpu_device *device, uint64_t size, enum gpu_memory_kind kind) {
    struct gpu_buffer buffer;
    assert_int_equal(gpu_buffer_create(device, "test", size, kind, &buffer), FNL_OK);
    return buffer;
}

/* ---- compute ---- */

struct compute {
    struct gpu_buffer from, to, indirect;
    struct gpu_image image;
    struct test_push push;
};

static void record_multiply(struct gpu_commands *commands, void *context) {
    struct compute *compute = context;
    test_dispatch(commands, TEST_MULTIPLY, 7, &compute->push);
    test_barrier(commands);
    /* The same again through an indirect dispatch, on what the first made. */
    compute->push.from = compute->push.to;
    gpu_push(commands, &compute->push, sizeof compute->push);
    gpu_dispatch_indirect(commands, &compute->indirect, 16);
}

static void test_dispatches_see_push_and_specialisation_constants(void **state) {
    UNUSED(state);
    gpu_device *device = test_device_create(NULL);
    enum { COUNT = 1000 };
    struct compute compute = {.from = make_buffer(device, COUNT * 4, GPU_MEMORY_UPLOAD),
                              .to = make_buffer(device, COUNT * 4, GPU_MEMORY_READBACK),
                              .indirect = make_buffer(device, 28, GPU_MEMORY_UPLOAD)};
    uint32_t *from = compute.from.mapped, *to = compute.to.mapped;
    for (uint32_t i = 0; i < COUNT; i++) from[i] = i * i;
    memcpy((char *)compute.indirect.mapped + 16, (uint32_t[]){DIVIDE_UP(COUNT, 64), 1, 1}, 12);
    compute.push = (struct test_push){.from = compute.from.address, .to = compute.to.address, .count = COUNT, .width = 1};
    test_run(device, record_multiply, &compute);
    for (uint32_t i = 0; i < COUNT; i++) assert_int_equal(to[i], (i * i * 7 + 1) * 7 + 1);
    gpu_buffer_destroy(device, &compute.from);
    gpu_buffer_destroy(device, &compute.to);
    gpu_buffer_destroy(device, &compute.indirect);
    test_device_destroy(&device);
}

static void record_images(struct gpu_commands *commands, void *context) {
    struct compute *compute = context;
    test_transition(commands, &compute->image, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_GENERAL);
    compute->push.image = compute->image.storage_index;
    test_dispatch(commands, TEST_STORE, 99, &compute->push);
    test_barrier(commands);
    test_dispatch(commands, TEST_LOAD, 0, &compute->push);
    test_transition(commands, &compute->image, VK_IMAGE_LAYOUT_GENERAL, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);
    compute->push.image = compute->image.sampled_index;
    compute->push.to += compute->push.count * sizeof(fnl_vec4);
    test_dispatch(commands, TEST_FETCH, 0, &compute->push);
    compute->push.to += compute->push.count * sizeof(fnl_vec4);
    compute->push.count = 1;
    compute->push.u = 8.0f / 16; /* between texels 7 and 8 of the first row */
    compute->push.v = 0.5f / 16;
    test_dispatch(commands, TEST_SAMPLE, 0, &compute->push);
}

static void test_bindless_images_are_stored_fetched_and_sampled(void **state) {
    UNUSED(state);
    gpu_device *device = test_device_create(NULL);
    enum { SIDE = 16, COUNT = SIDE * SIDE };
    struct gpu_image_params params = {"bindless", VK_FORMAT_R32G32B32A32_SFLOAT,
                                      SIDE,       SIDE,
                                      1,          1,
                                      1,          false,
                                      false,      VK_IMAGE_USAGE_STORAGE_BIT | VK_IMAGE_USAGE_SAMPLED_BIT, GPU_USE_OTHER};
    struct gpu_sampler_params nearest = {.mag = VK_FILTER_NEAREST,
                                         .min = VK_FILTER_NEAREST,
                                         .mip = VK_SAMPLER_MIPMAP_MODE_NEAREST,
                                         .wrap_u = VK_SAMPLER_ADDRESS_MODE_REPEAT,
                                         .wrap_v = VK_SAMPLER_ADDRESS_MODE_REPEAT,
                                         .anisotropy = 1};
    struct gpu_sampler_params linear = nearest;
    linear.mag = linear.min = VK_FILTER_LINEAR;
    linear.anisotropy = 1000; /* clamped */
    uint32_t nearest_index = gpu_sampler_index(device, &nearest), linear_index = gpu_sampler_index(device, &linear);
    assert_int_not_equal(nearest_index, linear_index);
    assert_int_equal(nearest_index, gpu_sampler_index(device, &nearest));
    struct compute compute = {.to = make_buffer(device, (2 * COUNT + 1) * sizeof(fnl_vec4), GPU_MEMORY_READBACK)};
    struct gpu_image other;
    assert_int_equal(gpu_image_create(device, &params, &other), FNL_OK); /* so that the index is not 0 */
    assert_int_equal(gpu_image_create(device, &params, &compute.image), FNL_OK);
    assert_true(compute.image.sampled_index != other.sampled_index && compute.image.storage_index != other.storage_index);
    linear.anisotropy = 1;
    compute.push = (struct test_push){
        .to = compute.to.address, .count = COUNT, .width = SIDE, .sampler_index = gpu_sampler_index(device, &linear)};
    test_run(device, record_images, &compute);
    const float *texels = compute.to.mapped;
    for (uint32_t i = 0; i < 2 * COUNT; i++) {
        assert_true(fabsf(texels[4 * i] - (float)(i % COUNT) / 255) < 1e-6f);
        assert_true(texels[4 * i + 1] == 1 && fabsf(texels[4 * i + 3] - 99.0f / 255) < 1e-6f);
    }
    assert_true(fabsf(texels[8 * COUNT] - 7.5f / 255) < 1e-5f);
    gpu_image_destroy(device, &other);
    gpu_image_destroy(device, &compute.image);
    gpu_buffer_destroy(device, &compute.to);
    test_device_destroy(&device);
}

static void record_copies(struct gpu_commands *commands, void *context) {
    struct gpu_buffer *buffers = context;
    gpu_fill_buffer(commands, &buffers[0], 0, 64, 0x01020304);
    test_barrier(commands);
    gpu_fill_buffer(commands, &buffers[0], 16, 4, 9);
    test_barrier(commands);
    gpu_copy_buffer(commands, &buffers[0], 12, &buffers[1], 4, 12);
    gpu_bind(commands, NULL); /* what follows is skipped */
    gpu_dispatch(commands, 1, 1, 1);
    gpu_draw(commands, 3, 1, 0, 0);
}

static void test_buffers_are_filled_and_copied(void **state) {
    UNUSED(state);
    gpu_device *device = test_device_create(NULL);
    struct gpu_buffer buffers[] = {make_buffer(device, 64, GPU_MEMORY_DEVICE), make_buffer(device, 64, GPU_MEMORY_READBACK)};
    memset(buffers[1].mapped, 0, 64);
    test_run(device, record_copies, buffers);
    assert_memory_equal(buffers[1].mapped, ((uint32_t[]){0, 0x01020304, 9, 0x01020304, 0}), 20);
    gpu_buffer_destroy(device, &buffers[0]);
    gpu_buffer_destroy(device, &buffers[1]);
    test_device_destroy(&device);
}

/* ---- frames ---- */

/** One frame that copies its slices' first words to `to`. */
static void run_slices(gpu_device *device, const struct gpu_buffer *to, uint32_t frame, uint32_t slices, uint64_t size) {
    assert_int_equal(gpu_frame_begin(device), FNL_OK);
    struct gpu_commands *commands = gpu_commands_begin(device, GPU_QUEUE_GRAPHICS, 0);
    for (uint32_t i = 0; i < slices; i++) {
        struct gpu_slice slice = gpu_frame_allocate(device, size);
        assert_non_null(slice.data);
        assert_int_equal(slice.address % 256, 0);
        assert_int_equal(slice.address, slice.buffer->address + slice.offset);
        memset(slice.data, 0xff, size);
        *(uint32_t *)slice.data = frame * slices + i;
        test_dispatch(commands, TEST_MULTIPLY, 1,
                      &(struct test_push){
                          .from = slice.address, .to = to->address + 4 * (frame * slices + i), .count = 1, .width = 1});
    }
    test_barrier(commands);
    gpu_commands_end(commands);
    struct gpu_batch batch = {.commands = &commands, .command_count = 1, .wait_batch = GPU_NO_INDEX};
    assert_int_equal(gpu_frame_end(device, &batch, 1, NULL), FNL_OK);
}

static void test_slices_live_until_their_frame_is_over(void **state) {
    UNUSED(state);
    gpu_device *device = test_device_create(NULL);
    enum { FRAMES = 40, SLICES = 24 };
    struct gpu_buffer to = make_buffer(device, FRAMES * SLICES * 4, GPU_MEMORY_READBACK);
    for (uint32_t frame = 0; frame < FRAMES; frame++) {
        run_slices(device, &to, frame, SLICES, 1 + frame * 3000); /* grows from 24 bytes to 2.8 MB */
        assert_int_equal(gpu_frame_number(device), frame + 1);
        assert_int_equal(gpu_frame_slot(device), frame % GPU_FRAMES_IN_FLIGHT);
    }
    assert_int_equal(gpu_frame_wait(device, FRAMES), FNL_OK);
    assert_int_equal(gpu_frame_wait(device, 1), FNL_OK);
    const uint32_t *words = to.mapped;
    for (uint32_t i = 0; i < FRAMES * SLICES; i++) assert_int_equal(words[i], i + 1);
    gpu_buffer_destroy(device, &to);
    test_device_destroy(&device);
}

struct chunks {
    struct gpu_commands *commands[GPU_MAX_CHUNKS];
    const struct gpu_buffer *to;
    gpu_device *device;
};

static void record_chunk(void *context, uint32_t index) {
    struct chunks *chunks = context;
    struct gpu_commands *commands = gpu_commands_begin(chunks->device, GPU_QUEUE_GRAPHICS, index);
    gpu_begin_label(commands, "chunk");
    gpu_timestamp(commands, 2 * index);
    struct gpu_slice slice = gpu_frame_allocate(chunks->device, 4);
    *(uint32_t *)slice.data = index;
    test_dispatch(commands, TEST_MULTIPLY, 2,
                  &(struct test_push){.from = slice.address, .to = chunks->to->address + 4 * index, .count = 1, .width = 1});
    gpu_timestamp(commands, 2 * index + 1);
    test_barrier(commands);
    gpu_end_label(commands);
    gpu_commands_end(commands);
    chunks->commands[index] = commands;
}

static void run_chunks(struct chunks *chunks) {
    assert_int_equal(gpu_frame_begin(chunks->device), FNL_OK);
    jobs_parallel_for(gpu_jobs(chunks->device), GPU_MAX_CHUNKS, record_chunk, chunks);
    struct gpu_batch batch = {.commands = chunks->commands, .command_count = GPU_MAX_CHUNKS, .wait_batch = GPU_NO_INDEX};
    assert_int_equal(gpu_frame_end(chunks->device, &batch, 1, NULL), FNL_OK);
}

static void test_a_steady_frame_allocates_nothing(void **state) {
    UNUSED(state);
    struct test_memory memory = {0};
    gpu_device *device = test_device_create(&memory);
    struct gpu_buffer to = make_buffer(device, GPU_MAX_CHUNKS * 4, GPU_MEMORY_READBACK);
    struct chunks chunks = {.to = &to, .device = device};
    for (uint32_t i = 0; i < 4; i++) run_chunks(&chunks);
    long long allocations = atomic_load(&memory.allocations);
    uint64_t reserved = gpu_memory_stats(device).reserved_bytes;
    for (uint32_t i = 0; i < 20; i++) {
        run_chunks(&chunks);
        uint64_t ticks[2 * GPU_MAX_CHUNKS];
        gpu_frame_timestamps(device, gpu_frame_slot(device), COUNT_OF(ticks), ticks);
    }
    assert_int_equal(atomic_load(&memory.allocations), allocations);
    assert_int_equal(gpu_memory_stats(device).reserved_bytes, reserved);
    assert_int_equal(gpu_wait_idle(device), FNL_OK);
    for (uint32_t i = 0; i < GPU_MAX_CHUNKS; i++) assert_int_equal(((uint32_t *)to.mapped)[i], 2 * i + 1);
    gpu_buffer_destroy(device, &to);
    test_device_destroy(&device);
    assert_int_equal(memory.live_bytes, 0);
}

static void test_timestamps(void **state) {
    UNUSED(state);
    gpu_device *device = test_device_create(NULL);
    struct gpu_buffer to = make_buffer(device, GPU_MAX_CHUNKS * 4, GPU_MEMORY_READBACK);
    struct chunks chunks = {.to = &to, .device = device};
    uint64_t times[2 * GPU_MAX_CHUNKS + 1];
    assert_false(gpu_frame_timestamps(device, 0, 1, times));
    assert_true(gpu_info(device)->timestamps);
    for (uint32_t frame = 1; frame <= 5; frame++) {
        run_chunks(&chunks);
        assert_int_equal(gpu_frame_wait(device, frame), FNL_OK);
        assert_true(gpu_frame_timestamps(device, gpu_frame_slot(device), 2 * GPU_MAX_CHUNKS, times));
        assert_int_equal(times[0], 0);
        for (uint32_t i = 1; i < 2 * GPU_MAX_CHUNKS; i++) assert_true(times[i] >= times[i - 1]); /* in order of submission */
        assert_true(times[2 * GPU_MAX_CHUNKS - 1] > 0);
        assert_false(gpu_frame_timestamps(device, gpu_frame_slot(device), 2 * GPU_MAX_CHUNKS + 1, times));
    }
    gpu_buffer_destroy(device, &to);
    test_device_destroy(&device);
}

/* ---- batches, semaphores, errors ---- */

static struct gpu_commands *record_step(gpu_device *device, enum gpu_queue queue, uint32_t factor,
                                        const struct gpu_buffer *buffer) {
    struct gpu_commands *commands = gpu_commands_begin(device, queue, 0);
    test_barrier(commands);
    test_dispatch(commands, TEST_MULTIPLY, factor,
                  &(struct test_push){.from = buffer->address, .to = buffer->address, .count = 256, .width = 1});
    test_barrier(commands);
    gpu_commands_end(commands);
    return commands;
}

static void test_batches_of_two_queues_wait_for_each_other(void **state) {
    UNUSED(state);
    gpu_device *device = test_device_create(NULL);
    struct gpu_buffer buffer = make_buffer(device, 256 * 4, GPU_MEMORY_READBACK);
    memset(buffer.mapped, 0, 256 * 4);
    uint32_t expected = 0;
    for (uint32_t frame = 0; frame < 6; frame++) {
        assert_int_equal(gpu_frame_begin(device), FNL_OK);
        struct gpu_commands *commands[] = {record_step(device, GPU_QUEUE_GRAPHICS, 2, &buffer),
                                           record_step(device, GPU_QUEUE_COMPUTE, 3, &buffer),
                                           record_step(device, GPU_QUEUE_GRAPHICS, 5, &buffer)};
        struct gpu_batch batches[] = {{GPU_QUEUE_GRAPHICS, &commands[0], 1, GPU_NO_INDEX},
                                      {GPU_QUEUE_COMPUTE, &commands[1], 1, 0},
                                      {GPU_QUEUE_GRAPHICS, &commands[2], 1, 1}};
        assert_int_equal(gpu_frame_end(device, batches, 3, NULL), FNL_OK);
        expected = ((expected * 2 + 1) * 3 + 1) * 5 + 1;
    }
    assert_int_equal(gpu_frame_wait(device, 6), FNL_OK);
    for (uint32_t i = 0; i < 256; i++) assert_int_equal(((uint32_t *)buffer.mapped)[i], expected);
    gpu_buffer_destroy(device, &buffer);
    test_device_destroy(&device);
}

/* What vkQueueSubmit2 was given, one submission each call. */
static struct {
    PFN_vkQueueSubmit2 real;
    VkSemaphoreSubmitInfo waits[8][8];
    uint32_t wait_counts[8], count;
} spied;

static VKAPI_ATTR VkResult VKAPI_CALL spy_on_submit(VkQueue queue, uint32_t count, const VkSubmitInfo2 *infos,
                                                    VkFence fence) {
    assert_true(count == 1 && infos->waitSemaphoreInfoCount <= 8 && spied.count < 8);
    spied.wait_counts[spied.count] = infos->waitSemaphoreInfoCount;
    memcpy(spied.waits[spied.count++], infos->pWaitSemaphoreInfos, infos->waitSemaphoreInfoCount * sizeof *spied.waits[0]);
    return spied.real(queue, count, infos, fence);
}

static void check_wait(uint32_t submission, const struct gpu_queue_state *queue, uint64_t value) {
    assert_int_equal(spied.wait_counts[submission], value ? 1 : 0);
    if (value)
        assert_true(spied.waits[submission][0].semaphore == queue->timeline && spied.waits[submission][0].value == value);
}

/** On one hardware queue the waits cannot be seen in the results, so look at the submissions. */
static void test_batches_wait_by_timeline_values(void **state) {
    UNUSED(state);
    gpu_device *device = test_device_create(NULL);
    const struct gpu_queue_state *graphics = &device->queues[GPU_QUEUE_GRAPHICS],
                                 *compute = &device->queues[GPU_QUEUE_COMPUTE];
    spied.real = device->vk.QueueSubmit2;
    device->vk.QueueSubmit2 = spy_on_submit;
    const struct gpu_batch batches[] = {{GPU_QUEUE_GRAPHICS, NULL, 0, GPU_NO_INDEX},
                                        {GPU_QUEUE_COMPUTE, NULL, 0, 0},
                                        {GPU_QUEUE_GRAPHICS, NULL, 0, GPU_NO_INDEX},
                                        {GPU_QUEUE_GRAPHICS, NULL, 0, 1}};
    for (uint32_t frame = 0; frame < 2; frame++) {
        spied.count = 0;
        assert_int_equal(gpu_frame_begin(device), FNL_OK);
        assert_int_equal(gpu_frame_end(device, batches, COUNT_OF(batches), NULL), FNL_OK);
        assert_int_equal(spied.count, 4);
        check_wait(0, compute, frame); /* the frame before, which may share memory */
        check_wait(1, graphics, 3 * frame + 1);
        check_wait(2, compute, 0);
        check_wait(3, compute, frame + 1);
    }
    device->vk.QueueSubmit2 = spied.real;
    test_device_destroy(&device);
}

static void test_a_callers_semaphores_are_waited_for_and_signalled(void **state) {
    UNUSED(state);
    gpu_device *device = test_device_create(NULL);
    VkSemaphore timeline, binary;
    VkSemaphoreCreateInfo info = {.sType = VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO};
    assert_int_equal(gpu_semaphore_create(device, "caller's", &timeline), FNL_OK);
    assert_int_equal(device->vk.CreateSemaphore(device->handle, &info, NULL, &binary), VK_SUCCESS);
    struct gpu_external_semaphores links[] = {
        {.signal = timeline, .signal_value = 3},
        {.wait = timeline, .wait_value = 3, .signal = binary},
        {.wait = binary, .signal = timeline, .signal_value = 8},
    };
    for (uint32_t i = 0; i < COUNT_OF(links); i++) {
        assert_int_equal(gpu_frame_begin(device), FNL_OK);
        assert_int_equal(gpu_frame_end(device, NULL, 0, &links[i]), FNL_OK); /* no batch: passed on all the same */
    }
    assert_int_equal(gpu_semaphore_wait(device, timeline, 8), FNL_OK);

    /* A frame does not run before its semaphore allows it. */
    assert_int_equal(gpu_frame_begin(device), FNL_OK);
    struct gpu_external_semaphores late = {.wait = timeline, .wait_value = 9};
    assert_int_equal(gpu_frame_end(device, NULL, 0, &late), FNL_OK);
    const struct timespec moment = {.tv_nsec = 50000000};
    nanosleep(&moment, NULL);
    uint64_t reached = 0;
    const struct gpu_queue_state *queue = &device->queues[GPU_QUEUE_GRAPHICS];
    assert_int_equal(device->vk.GetSemaphoreCounterValue(device->handle, queue->timeline, &reached), VK_SUCCESS);
    assert_int_equal(reached, queue->value - 1);
    PFN_vkSignalSemaphore signal =
        (PFN_vkSignalSemaphore)device->instance.vk.GetDeviceProcAddr(device->handle, "vkSignalSemaphore");
    VkSemaphoreSignalInfo allow = {.sType = VK_STRUCTURE_TYPE_SEMAPHORE_SIGNAL_INFO, .semaphore = timeline, .value = 9};
    assert_int_equal(signal(device->handle, &allow), VK_SUCCESS);
    assert_int_equal(gpu_wait_idle(device), FNL_OK);
    device->vk.DestroySemaphore(device->handle, timeline, NULL);
    device->vk.DestroySemaphore(device->handle, binary, NULL);
    test_device_destroy(&device);
}

static void test_errors_stick_until_the_frame_ends(void **state) {
    UNUSED(state);
    struct test_memory memory = {0};
    gpu_device *device = test_device_create(&memory);
    struct gpu_buffer buffer = make_buffer(device, 256 * 4, GPU_MEMORY_READBACK);
    memset(buffer.mapped, 0, 256 * 4);
    assert_int_equal(gpu_frame_begin(device), FNL_OK);
    assert_int_equal(gpu_frame_begin(device), FNL_ERROR_INVALID);
    struct gpu_commands *commands = record_step(device, GPU_QUEUE_GRAPHICS, 2, &buffer);
    assert_true(gpu_commands_begin(device, GPU_QUEUE_GRAPHICS, GPU_MAX_CHUNKS)->handle == VK_NULL_HANDLE);
    assert_int_equal(gpu_status(device), FNL_ERROR_INVALID);
    gpu_fail(device, FNL_ERROR_MEMORY); /* the first error stays */
    assert_null(gpu_frame_allocate(device, 16).data);
    struct gpu_batch batch = {.commands = &commands, .command_count = 1, .wait_batch = GPU_NO_INDEX};
    assert_int_equal(gpu_frame_end(device, &batch, 1, NULL), FNL_ERROR_INVALID);
    assert_int_equal(gpu_frame_end(device, &batch, 1, NULL), FNL_ERROR_INVALID); /* no frame */
    assert_int_equal(gpu_wait_idle(device), FNL_OK);
    assert_int_equal(*(uint32_t *)buffer.mapped, 0); /* nothing was submitted */

    assert_int_equal(gpu_status(device), FNL_OK); /* a new frame may do better */
    assert_int_equal(gpu_frame_begin(device), FNL_OK);
    commands = record_step(device, GPU_QUEUE_GRAPHICS, 2, &buffer);
    assert_int_equal(gpu_frame_end(device, &batch, 1, NULL), FNL_OK);
    assert_int_equal(gpu_frame_wait(device, 2), FNL_OK);
    assert_int_equal(*(uint32_t *)buffer.mapped, 1);
    assert_int_equal(gpu_frame_wait(device, 3), FNL_ERROR_INVALID);

    memory.errors = 0;
    assert_int_equal(gpu_check(device, VK_ERROR_DEVICE_LOST, "a test"), FNL_ERROR_DEVICE_LOST);
    assert_int_equal(gpu_check(device, VK_ERROR_DEVICE_LOST, "the next call"), FNL_ERROR_DEVICE_LOST);
    gpu_fail(device, FNL_ERROR_DEVICE_LOST);
    assert_int_equal(memory.errors, 1); /* told once */
    assert_non_null(strstr(memory.last_error, "a test: "));
    assert_int_equal(gpu_frame_begin(device), FNL_ERROR_DEVICE_LOST);
    assert_int_equal(gpu_status(device), FNL_ERROR_DEVICE_LOST); /* for good */
    gpu_buffer_destroy(device, &buffer);
    test_device_destroy(&device);
    assert_int_equal(memory.live_bytes, 0);
}

const struct CMUnitTest commands_tests[] = {
    cmocka_unit_test(test_dispatches_see_push_and_specialisation_constants),
    cmocka_unit_test(test_bindless_images_are_stored_fetched_and_sampled),
    cmocka_unit_test(test_buffers_are_filled_and_copied),
    cmocka_unit_test(test_slices_live_until_their_frame_is_over),
    cmocka_unit_test(test_a_steady_frame_allocates_nothing),
    cmocka_unit_test(test_timestamps),
    cmocka_unit_test(test_batches_of_two_queues_wait_for_each_other),
    cmocka_unit_test(test_batches_wait_by_timeline_values),
    cmocka_unit_test(test_a_callers_semaphores_are_waited_for_and_signalled),
    cmocka_unit_test(test_errors_stick_until_the_frame_ends),
};
const size_t commands_test_count = COUNT_OF(commands_tests);
