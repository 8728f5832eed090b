/* SPDX-License-Identifier: MIT */
/* Pipelines that are asked for before a frame needs them. */
#include "tests/gpu_test.h"

#include <time.h>

static void wait_for(gpu_device *device, uint64_t ticket) {
    for (int i = 0; i < 60000 && gpu_pipeline_stats(device).done < ticket; i++) nanosleep(&(struct timespec){.tv_nsec = 1000000}, NULL);
    assert_true(gpu_pipeline_stats(device).done >= ticket);
}

struct multiply {
    struct gpu_buffer from, to;
    uint32_t factor;
};

static void record_multiply(struct gpu_commands *commands, void *context) {
    const struct multiply *m = context;
    struct test_push push = {.from = m->from.address, .to = m->to.address, .count = 1, .width = 1};
    test_dispatch(commands, TEST_MULTIPLY, m->factor, &push);
}

/* A frame of the test's shader; returns how many pipelines it had to make or to wait for. */
static uint64_t use(gpu_device *device, uint32_t factor) {
    struct multiply m = {.factor = factor};
    assert_int_equal(gpu_buffer_create(device, "from", 4, GPU_MEMORY_UPLOAD, &m.from), FNL_OK);
    assert_int_equal(gpu_buffer_create(device, "to", 4, GPU_MEMORY_READBACK, &m.to), FNL_OK);
    *(uint32_t *)m.from.mapped = 10;
    uint64_t before = gpu_pipeline_stats(device).late;
    test_run(device, record_multiply, &m);
    assert_int_equal(*(uint32_t *)m.to.mapped, 10 * factor + 1);
    gpu_buffer_destroy(device, &m.from);
    gpu_buffer_destroy(device, &m.to);
    return gpu_pipeline_stats(device).late - before;
}

static void test_what_is_asked_for_is_made_in_the_background(void **state) {
    UNUSED(state);
    enum { COUNT = 5 };
    struct test_memory memory = {0};
    gpu_device *device = test_device_create(&memory);
    assert_int_equal(device->pipelines.worker_count, 0); /* who does not ask has no thread */
    uint64_t ticket = test_ask(device, 1, COUNT);
    assert_int_equal(ticket, COUNT);
    assert_int_equal(gpu_pipeline_stats(device).asked, COUNT);
    wait_for(device, ticket);
    assert_int_equal(gpu_pipeline_stats(device).ahead, COUNT);
    assert_int_equal(gpu_pipeline_stats(device).rehearsed, device->compiles_late ? COUNT : 0);
    for (uint32_t i = 1; i <= COUNT; i++) assert_int_equal(use(device, i), 0);
    assert_int_equal(use(device, COUNT + 1), 1); /* nobody asked for this one */
    assert_int_equal(use(device, COUNT + 1), 0);
    assert_int_equal(test_ask(device, 1, COUNT + 1), 0); /* all there */
    ticket = test_ask(device, COUNT, 3);                 /* one is not */
    assert_int_equal(ticket, COUNT + 1);
    wait_for(device, ticket);
    assert_int_equal(device->pipelines.count, COUNT + 2);
    test_device_destroy(&device);
    assert_int_equal(memory.live_bytes, 0);
    assert_int_equal(memory.errors, 0);
}

/* A frame makes what it needs itself, were it the last in line. */
static void test_a_frame_does_not_stand_in_line(void **state) {
    UNUSED(state);
    enum { COUNT = 100 };
    gpu_device *device = test_device_create(NULL);
    uint64_t ticket = test_ask(device, 1, COUNT);
    assert_int_equal(use(device, COUNT), 1);
    assert_int_equal(use(device, 2 * COUNT), 1);
    assert_true(gpu_pipeline_stats(device).done < ticket);
    wait_for(device, ticket);
    assert_int_equal(gpu_pipeline_stats(device).ahead, COUNT - 1);
    assert_int_equal(gpu_pipeline_stats(device).done, COUNT);
    test_device_destroy(&device);
}

static void test_what_cannot_be_made_is_told_by_the_frame_that_needs_it(void **state) {
    UNUSED(state);
    struct test_memory memory = {0};
    gpu_device *device = test_device_create(&memory);
    struct gpu_compute_params wrong;
    memset(&wrong, 0, sizeof wrong);
    assert_int_equal(gpu_frame_begin(device), FNL_OK);
    gpu_ask_begin(device);
    assert_null(gpu_compute_pipeline(device, &wrong)); /* has no shader */
    assert_int_equal(gpu_ask_end(device), 0);
    assert_int_equal(gpu_status(device), FNL_OK);
    assert_null(gpu_compute_pipeline(device, &wrong));
    assert_int_equal(gpu_frame_end(device, NULL, 0, NULL), FNL_ERROR_INVALID);
    assert_int_equal(use(device, 3), 1);
    test_device_destroy(&device);
    assert_int_equal(memory.live_bytes, 0);
}

static void test_a_device_is_destroyed_while_pipelines_are_made(void **state) {
    UNUSED(state);
    enum { COUNT = 64 };
    for (int round = 0; round < 2; round++) {
        struct test_memory memory = {0};
        gpu_device *device = test_device_create(&memory);
        uint64_t ticket = test_ask(device, 1, COUNT);
        if (round) wait_for(device, 2);
        assert_true(gpu_pipeline_stats(device).done < ticket);
        test_device_destroy(&device);
        assert_int_equal(memory.live_bytes, 0);
        assert_int_equal(memory.wrong_sizes, 0);
        assert_int_equal(memory.errors, 0);
    }
}

const struct CMUnitTest ahead_tests[] = {
    cmocka_unit_test(test_what_is_asked_for_is_made_in_the_background),
    cmocka_unit_test(test_a_frame_does_not_stand_in_line),
    cmocka_unit_test(test_what_cannot_be_made_is_told_by_the_frame_that_needs_it),
    cmocka_unit_test(test_a_device_is_destroyed_while_pipelines_are_made),
};
const size_t ahead_test_count = COUNT_OF(ahead_tests);
