/* SPDX-License-Identifier: MIT */
/** What the tests of this folder share. */
#ifndef FNL_TESTS_GPU_TEST_H
#define FNL_TESTS_GPU_TEST_H

#include "gpu/gpu_internal.h"
#include "tests/test_memory.h"

fnl_host test_host(struct test_memory *memory);

/** A device with validation and no cache folder; NULL memory: the default host. Fails the test if there is none. */
gpu_device *test_device_create(struct test_memory *memory);
/** Also checks that validation was silent. */
void test_device_destroy(gpu_device **device);

/** Records and submits one frame of one command buffer, and waits for it. */
void test_run(gpu_device *device, void (*record)(struct gpu_commands *commands, void *context), void *context);
/** Everything before it is done and visible to everything after, the host included. */
void test_barrier(struct gpu_commands *commands);
/** Changes the layout of the whole image, as slowly and safely as can be. */
void test_transition(struct gpu_commands *commands, const struct gpu_image *image, VkImageLayout from, VkImageLayout to);

struct test_push {
    VkDeviceAddress from, to;
    uint32_t count, width, lod, image, sampler_index;
    float u, v;
};
enum test_mode { TEST_MULTIPLY, TEST_FETCH, TEST_STORE, TEST_SAMPLE, TEST_LOAD, TEST_TRACE };
/** Binds the test's compute shader with these constants and dispatches it. */
void test_dispatch(struct gpu_commands *commands, enum test_mode mode, uint32_t factor, const struct test_push *push);
/** Asks for the test's compute shader with so many factors, from `first` on, in a frame of its own; returns the ticket. */
uint64_t test_ask(gpu_device *device, uint32_t first, uint32_t count);
/** The texels of a mip, by a shader; the image is in SHADER_READ_ONLY_OPTIMAL. */
void test_fetch_mip(gpu_device *device, const struct gpu_image *image, uint32_t mip, fnl_vec4 *out);

extern const struct CMUnitTest device_tests[], memory_tests[], commands_tests[], draw_tests[], scope_tests[], ahead_tests[],
    cache_tests[], specialise_tests[], structure_tests[];
extern const size_t device_test_count, memory_test_count, commands_test_count, draw_test_count, scope_test_count, ahead_test_count,
    cache_test_count, specialise_test_count, structure_test_count;

#endif
