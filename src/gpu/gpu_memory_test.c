/* SPDX-License-Identifier: MIT */
#include "tests/gpu_test.h"

#include <math.h>
#include <sys/mman.h>

static void fill_random(void *data, size_t size, uint64_t seed) {
    struct random_state random = {seed};
    unsigned char *bytes = data;
    for (size_t i = 0; i < size; i++) bytes[i] = (unsigned char)(random_bits(&random) >> 56);
}

static void test_buffers_come_back_as_sent(void **state) {
    UNUSED(state);
    struct test_memory memory = {0};
    gpu_device *device = test_device_create(&memory);
    const size_t sizes[] = {1, 3, 13, 4097, GPU_UPLOAD_SEGMENT_BYTES + 5, 40 * 1024 * 1024 + 13};
    for (uint32_t i = 0; i < COUNT_OF(sizes); i++) {
        size_t size = sizes[i];
        unsigned char *sent = malloc(size), *got = malloc(size);
        fill_random(sent, size, i);
        struct gpu_buffer buffer;
        assert_int_equal(gpu_buffer_create(device, "odd", size + 7, GPU_MEMORY_DEVICE, &buffer), FNL_OK);
        assert_null(buffer.mapped);
        assert_int_equal(gpu_upload_buffer(device, &buffer, 5, sent, size), FNL_OK);
        assert_int_equal(gpu_upload_flush(device), FNL_OK);
        assert_int_equal(gpu_read_buffer(device, &buffer, 5, got, size), FNL_OK);
        assert_memory_equal(sent, got, size);
        assert_int_equal(gpu_upload_buffer(device, &buffer, buffer.size, sent, 1), FNL_ERROR_INVALID);
        gpu_buffer_destroy(device, &buffer);
        free(sent);
        free(got);
    }
    test_device_destroy(&device);
}

enum { THREAD_BUFFERS = 24, THREAD_BYTES = 1 << 20 };
struct threaded {
    gpu_device *device;
    struct gpu_buffer buffers[THREAD_BUFFERS];
    fnl_result results[THREAD_BUFFERS];
};

static void upload_one(void *context, uint32_t index) {
    struct threaded *work = context;
    unsigned char *data = malloc(THREAD_BYTES);
    fill_random(data, THREAD_BYTES, index);
    work->results[index] =
        gpu_buffer_create(work->device, "threaded", THREAD_BYTES, GPU_MEMORY_DEVICE, &work->buffers[index]);
    if (work->results[index] == FNL_OK)
        work->results[index] = gpu_upload_buffer(work->device, &work->buffers[index], 0, data, THREAD_BYTES);
    free(data);
}

static void test_threads_upload_at_once(void **state) {
    UNUSED(state);
    gpu_device *device = test_device_create(NULL);
    struct threaded work = {.device = device};
    jobs_parallel_for(gpu_jobs(device), THREAD_BUFFERS, upload_one, &work);
    assert_int_equal(gpu_upload_flush(device), FNL_OK);
    unsigned char *sent = malloc(THREAD_BYTES), *got = malloc(THREAD_BYTES);
    for (uint32_t i = 0; i < THREAD_BUFFERS; i++) {
        assert_int_equal(work.results[i], FNL_OK);
        fill_random(sent, THREAD_BYTES, i);
        assert_int_equal(gpu_read_buffer(device, &work.buffers[i], 0, got, THREAD_BYTES), FNL_OK);
        assert_memory_equal(sent, got, THREAD_BYTES);
        gpu_buffer_destroy(device, &work.buffers[i]);
    }
    free(sent);
    free(got);
    test_device_destroy(&device);
}

static double to_linear(double encoded) {
    return encoded <= 0.04045 ? encoded / 12.92 : pow((encoded + 0.055) / 1.055, 2.4);
}
static double to_srgb(double linear) { return linear <= 0.0031308 ? linear * 12.92 : 1.055 * pow(linear, 1 / 2.4) - 0.055; }

/** Checks each mip against 2x2 averages of the one before; returns the greatest distance of those from plain averages. */
static double check_mips(gpu_device *device, bool color) {
    enum { SIDE = 32, MIPS = 6 };
    struct gpu_image_params params = {
        "mips", VK_FORMAT_R8G8B8A8_UNORM,
        SIDE,   SIDE,
        1,      MIPS,
        1,      false,
        color,  VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT, GPU_USE_OTHER};
    struct gpu_image image;
    assert_int_equal(gpu_image_create(device, &params, &image), FNL_OK);
    assert_true((image.srgb_index != GPU_NO_INDEX) == color);
    unsigned char pixels[SIDE * SIDE * 4];
    fill_random(pixels, sizeof pixels, 3);
    assert_int_equal(gpu_upload_image(device, &image, pixels, sizeof pixels, true, !color), FNL_ERROR_INVALID);
    assert_int_equal(gpu_upload_image(device, &image, pixels, sizeof pixels, true, color), FNL_OK);
    assert_int_equal(gpu_upload_flush(device), FNL_OK);
    static float big[SIDE * SIDE][4], small[SIDE * SIDE][4];
    test_fetch_mip(device, &image, 0, (fnl_vec4 *)big);
    for (uint32_t i = 0; i < SIDE * SIDE * 4; i++) assert_true(fabsf(big[i / 4][i % 4] * 255 - pixels[i]) < 0.01f);
    double bend = 0;
    for (uint32_t mip = 1; mip < MIPS; mip++) {
        uint32_t side = SIDE >> mip;
        test_fetch_mip(device, &image, mip, (fnl_vec4 *)small);
        for (uint32_t i = 0; i < side * side * 4; i++) {
            uint32_t x = i / 4 % side, y = i / 4 / side, channel = i % 4;
            double sum = 0, plain = 0;
            for (uint32_t k = 0; k < 4; k++) {
                double value = big[(2 * y + k / 2) * 2 * side + 2 * x + k % 2][channel];
                plain += value / 4;
                sum += (color && channel < 3 ? to_linear(value) : value) / 4;
            }
            double expected = color && channel < 3 ? to_srgb(sum) : sum;
            assert_true(fabs(small[i / 4][channel] - expected) < 1.01 / 255);
            bend = fmax(bend, fabs(plain - expected));
        }
        memcpy(big, small, sizeof big);
    }
    gpu_image_destroy(device, &image);
    return bend;
}

static void test_mips_are_averages_of_light(void **state) {
    UNUSED(state);
    struct test_memory memory = {0};
    gpu_device *device = test_device_create(&memory);
    assert_true(check_mips(device, false) < 1e-6);
    assert_true(check_mips(device, true) > 10.0 / 255); /* so the two kinds are told apart */
    test_device_destroy(&device);
}

struct download {
    struct gpu_image image;
    struct gpu_buffer buffer;
};

static void record_download(struct gpu_commands *commands, void *context) {
    struct download *download = context;
    test_transition(commands, &download->image, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL,
                    VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
    gpu_copy_image_to_buffer(commands, &download->image, &download->buffer, 0);
}

static void test_images_bigger_than_the_ring_go_in_slices(void **state) {
    UNUSED(state);
    struct test_memory memory = {0};
    gpu_device *device = test_device_create(&memory);
    const struct {
        uint32_t width, height;
        VkFormat format;
        size_t texel;
    } cases[] = {
        {1, 1, VK_FORMAT_R8_UNORM, 1},
        {37, 5, VK_FORMAT_R8G8_UNORM, 2},
        {1283, 721, VK_FORMAT_R16G16B16A16_SFLOAT, 8},
        {4001, 2203, VK_FORMAT_R8G8B8A8_UNORM, 4}, /* 35 MB */
    };
    for (uint32_t i = 0; i < COUNT_OF(cases); i++) {
        struct download download;
        struct gpu_image_params params = {"big",
                                          cases[i].format,
                                          cases[i].width,
                                          cases[i].height,
                                          1,
                                          1,
                                          1,
                                          false,
                                          false,
                                          VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT |
                                              VK_IMAGE_USAGE_TRANSFER_SRC_BIT, GPU_USE_OTHER};
        size_t size = cases[i].texel * cases[i].width * cases[i].height;
        unsigned char *sent = malloc(size);
        fill_random(sent, size, i);
        assert_int_equal(gpu_image_create(device, &params, &download.image), FNL_OK);
        assert_int_equal(gpu_buffer_create(device, "download", size, GPU_MEMORY_READBACK, &download.buffer), FNL_OK);
        assert_int_equal(gpu_upload_image(device, &download.image, sent, size - 1, false, false), FNL_ERROR_INVALID);
        assert_int_equal(gpu_upload_image(device, &download.image, sent, size, false, false), FNL_OK);
        assert_int_equal(gpu_upload_flush(device), FNL_OK);
        test_run(device, record_download, &download);
        assert_memory_equal(download.buffer.mapped, sent, size);
        gpu_image_destroy(device, &download.image);
        gpu_buffer_destroy(device, &download.buffer);
        free(sent);
    }
    test_device_destroy(&device);
}

static void test_images_that_cannot_be_are_refused(void **state) {
    UNUSED(state);
    struct test_memory memory = {0};
    gpu_device *device = test_device_create(&memory);
    const struct gpu_image_params good = {"never", VK_FORMAT_R8G8B8A8_UNORM,  8, 8, 1, 1, 1, false,
                                          false,   VK_IMAGE_USAGE_SAMPLED_BIT, GPU_USE_OTHER};
    struct gpu_image_params params = good;
    struct gpu_image image;
    params.width = 0;
    assert_int_equal(gpu_image_create(device, &params, &image), FNL_ERROR_INVALID);
    params = good;
    params.mips = 5;
    assert_int_equal(gpu_image_create(device, &params, &image), FNL_ERROR_INVALID);
    params = good;
    params.width = 1 << 20;
    assert_int_equal(gpu_image_create(device, &params, &image), FNL_ERROR_UNSUPPORTED);
    assert_non_null(strstr(memory.last_error, "'never'"));
    params = good;
    params.usage = VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT;
    assert_int_equal(gpu_image_create(device, &params, &image), FNL_ERROR_UNSUPPORTED);
    struct gpu_buffer buffer;
    assert_int_equal(gpu_buffer_create(device, "far too big", UINT64_MAX / 2, GPU_MEMORY_DEVICE, &buffer), FNL_ERROR_MEMORY);
    assert_non_null(strstr(memory.last_error, "'far too big'"));
    gpu_buffer_destroy(device, &buffer);
    gpu_image_destroy(device, &image);
    assert_int_equal(gpu_memory_stats(device).used_bytes, 0);
    test_device_destroy(&device);
    assert_int_equal(memory.live_bytes, 0);
}

/** Pieces of a random life never overlap, and all memory comes back. */
static void test_memory_is_accounted(void **state) {
    UNUSED(state);
    struct test_memory memory = {0};
    gpu_device *device = test_device_create(&memory);
    assert_int_equal(gpu_memory_stats(device).used_bytes, 0);
    enum { SLOTS = 60, STEPS = 1500 };
    static struct gpu_buffer buffers[SLOTS];
    static struct gpu_image images[SLOTS];
    memset(buffers, 0, sizeof buffers);
    for (uint32_t i = 0; i < SLOTS; i++) images[i] = (struct gpu_image){0};
    struct random_state random = {5};
    for (uint32_t step = 0; step < STEPS; step++) {
        uint32_t i = (uint32_t)(random_bits(&random) % SLOTS);
        if (random_bits(&random) & 1) {
            gpu_buffer_destroy(device, &buffers[i]);
            uint64_t size = 1 + random_bits(&random) % (1u << (random_bits(&random) % 23));
            assert_int_equal(
                gpu_buffer_create(device, "random", size, (enum gpu_memory_kind)(random_bits(&random) % 3), &buffers[i]),
                FNL_OK);
            assert_true(buffers[i].size >= size);
        } else {
            if (images[i].handle) gpu_image_destroy(device, &images[i]);
            struct gpu_image_params params = {"random",
                                              VK_FORMAT_R8G8B8A8_UNORM,
                                              1 + (uint32_t)(random_bits(&random) % 300),
                                              1 + (uint32_t)(random_bits(&random) % 300),
                                              1,
                                              1,
                                              1,
                                              false,
                                              false,
                                              VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_STORAGE_BIT, GPU_USE_OTHER};
            assert_int_equal(gpu_image_create(device, &params, &images[i]), FNL_OK);
        }
        if (step % 50 == 0) assert_int_equal(gpu_wait_idle(device), FNL_OK);
        for (uint32_t k = 0; k < SLOTS && step % 10 == 0; k++) {
            if (k == i || !buffers[k].handle || !buffers[i].handle) continue;
            const struct gpu_allocation *a = &buffers[i].allocation, *b = &buffers[k].allocation;
            assert_true(a->block != b->block || a->offset + a->size <= b->offset || b->offset + b->size <= a->offset);
        }
    }
    struct gpu_memory_stats stats = gpu_memory_stats(device);
    assert_true(stats.used_bytes > 0 && stats.reserved_bytes >= stats.used_bytes &&
                stats.peak_used_bytes >= stats.used_bytes);
    for (uint32_t i = 0; i < SLOTS; i++) {
        gpu_buffer_destroy(device, &buffers[i]);
        if (images[i].handle) gpu_image_destroy(device, &images[i]);
    }
    assert_int_equal(gpu_wait_idle(device), FNL_OK);
    assert_int_equal(gpu_memory_stats(device).used_bytes, 0);
    for (uint32_t i = 0; i < device->memory.blocks.count; i++) { /* the ranges have grown together again */
        const struct gpu_block *block = &device->memory.blocks.data[i];
        if (block->memory) assert_true(block->free.count == 1 && block->free.data[0].size == block->size);
    }
    const struct gpu_index_pool *pool = &device->bindless.pools[GPU_BINDING_SAMPLED];
    assert_int_equal(pool->free.count, pool->next);
    assert_true(pool->next < STEPS);
    test_device_destroy(&device);
    assert_int_equal(memory.live_bytes, 0);
    assert_int_equal(memory.wrong_sizes, 0);
}

/* The set takes what it holds and no more. Where the layer visits all of it at each draw, it holds a sixteenth. */
static void assert_uses(gpu_device *device, const uint64_t wanted[GPU_USE_COUNT]) {
    const struct gpu_memory_stats stats = gpu_memory_stats(device);
    uint64_t sum = 0;
    for (uint32_t use = 0; use < GPU_USE_COUNT; use++) {
        if (stats.use_bytes[use] != wanted[use])
            fail_msg("%s has %llu bytes, not %llu", gpu_use_name((enum gpu_use)use), (unsigned long long)stats.use_bytes[use], (unsigned long long)wanted[use]);
        sum += stats.use_bytes[use];
    }
    assert_true(sum == stats.used_bytes);
}

/** Each piece counts where it says, from when it is made until it is freed. */
static void test_memory_is_accounted_by_use(void **state) {
    UNUSED(state);
    gpu_device *device = test_device_create(NULL);
    struct gpu_buffer buffers[GPU_USE_COUNT], mapped, plain;
    struct gpu_image images[GPU_USE_COUNT];
    uint64_t wanted[GPU_USE_COUNT] = {0};
    for (uint32_t use = 0; use < GPU_USE_COUNT; use++) {
        const struct gpu_image_params params = {.name = "of a use",
                                                .format = VK_FORMAT_R8G8B8A8_UNORM,
                                                .width = 64 + 32 * use,
                                                .height = 64,
                                                .layers = 1,
                                                .mips = 1,
                                                .samples = 1,
                                                .usage = VK_IMAGE_USAGE_SAMPLED_BIT,
                                                .use = (enum gpu_use)use};
        assert_int_equal(gpu_buffer_create_for(device, (enum gpu_use)use, "of a use", 5000 * (use + 1), GPU_MEMORY_DEVICE, &buffers[use]), FNL_OK);
        assert_int_equal(gpu_image_create(device, &params, &images[use]), FNL_OK);
        wanted[use] += buffers[use].allocation.size + images[use].allocation.size;
        assert_uses(device, wanted);
    }
    assert_int_equal(gpu_buffer_create(device, "mapped", 3000, GPU_MEMORY_READBACK, &mapped), FNL_OK);
    assert_int_equal(gpu_buffer_create(device, "plain", 3000, GPU_MEMORY_DEVICE, &plain), FNL_OK);
    wanted[GPU_USE_TRANSFER] += mapped.allocation.size;
    wanted[GPU_USE_OTHER] += plain.allocation.size;
    struct gpu_heap heap;
    assert_int_equal(gpu_heap_create(device, "heap", 70000, gpu_buffer_requirements(device, 70000).memory_types, &heap), FNL_OK);
    wanted[GPU_USE_FRAME] += heap.size;
    assert_uses(device, wanted);
    wanted[GPU_USE_LIGHTS] -= buffers[GPU_USE_LIGHTS].allocation.size;
    assert_int_equal(gpu_grow_buffer(device, GPU_USE_LIGHTS, "grown", &buffers[GPU_USE_LIGHTS], 0, 90000), FNL_OK);
    gpu_wait_idle(device);
    wanted[GPU_USE_LIGHTS] += buffers[GPU_USE_LIGHTS].allocation.size;
    assert_uses(device, wanted);
    gpu_heap_destroy(device, &heap);
    gpu_buffer_destroy(device, &mapped);
    gpu_buffer_destroy(device, &plain);
    for (uint32_t use = 0; use < GPU_USE_COUNT; use++) {
        gpu_buffer_destroy(device, &buffers[use]);
        gpu_image_destroy(device, &images[use]);
    }
    gpu_wait_idle(device);
    memset(wanted, 0, sizeof wanted);
    assert_uses(device, wanted);
    test_device_destroy(&device);
}

static void test_the_bindless_set_fills(void **state) {
    UNUSED(state);
    struct test_memory memory = {0};
    fnl_device_params params = fnl_device_params_default();
    params.host = test_host(&memory);
    params.cache_folder = "";
    gpu_device *fast, *device = test_device_create(&memory);
    assert_int_equal(fnl_device_create(&params, &fast), FNL_OK);
    const uint32_t version = device->instance.layer_version, share = version < VK_MAKE_API_VERSION(0, 1, 3, 270) ? 16 : 1;
    for (uint32_t i = 0; i < GPU_BINDING_COUNT; i++)
        assert_int_equal(fast->bindless.pools[i].capacity, device->bindless.pools[i].capacity * (i == GPU_BINDING_SAMPLER ? 1 : share));
    test_device_destroy(&fast);

    struct gpu_image_params small = {.name = "small", .format = VK_FORMAT_R8G8B8A8_UNORM, .width = 1, .height = 1, .layers = 1, .mips = 1,
                                     .samples = 1, .usage = VK_IMAGE_USAGE_SAMPLED_BIT};
    struct gpu_image image;
    assert_int_equal(gpu_image_create(device, &small, &image), FNL_OK);
    struct gpu_index_pool *pool = &device->bindless.pools[GPU_BINDING_SAMPLED];
    uint32_t added = 1, index, first = GPU_NO_INDEX;
    while (share > 1 && gpu_bindless_add(device, GPU_BINDING_SAMPLED, image.view, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL, &index) == FNL_OK) {
        if (first == GPU_NO_INDEX) first = index;
        added++;
    }
    if (share > 1) {
        assert_int_equal(added, pool->capacity);
        assert_int_equal(index, GPU_NO_INDEX);
        gpu_bindless_remove(device, GPU_BINDING_SAMPLED, first);
        assert_int_equal(gpu_bindless_add(device, GPU_BINDING_SAMPLED, image.view, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL, &index), FNL_OK);
        assert_int_equal(index, first);
    }
    gpu_image_destroy(device, &image);
    test_device_destroy(&device);
    assert_int_equal(memory.live_bytes, 0);
}

static void test_a_heap_holds_images_and_buffers(void **state) {
    UNUSED(state);
    gpu_device *device = test_device_create(NULL);
    struct gpu_image_params params = {"in a heap", VK_FORMAT_R8G8B8A8_UNORM,
                                      64,          64,
                                      1,           1,
                                      1,           false,
                                      false,       VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT, GPU_USE_OTHER};
    struct gpu_requirements for_image = gpu_image_requirements(device, &params),
                            for_buffer = gpu_buffer_requirements(device, 1000);
    assert_true(for_image.size >= 64 * 64 * 4 && for_buffer.size >= 1000 &&
                (for_image.memory_types & for_buffer.memory_types));
    uint64_t offset = align_up(for_image.size, for_buffer.alignment);
    struct gpu_heap heap;
    assert_int_equal(
        gpu_heap_create(device, "heap", offset + for_buffer.size, for_image.memory_types & for_buffer.memory_types, &heap),
        FNL_OK);
    assert_int_equal(gpu_memory_stats(device).used_bytes, heap.size);
    struct gpu_image image;
    struct gpu_buffer buffer;
    assert_int_equal(gpu_image_create_in(device, &heap, 0, &params, &image), FNL_OK);
    assert_int_equal(gpu_buffer_create_in(device, &heap, offset, "in a heap too", 1000, &buffer), FNL_OK);
    unsigned char pixels[64 * 64 * 4], words[1000], got[1000];
    fnl_vec4 texels[64 * 64];
    fill_random(pixels, sizeof pixels, 1);
    fill_random(words, sizeof words, 2);
    assert_int_equal(gpu_upload_image(device, &image, pixels, sizeof pixels, false, false), FNL_OK);
    assert_int_equal(gpu_upload_buffer(device, &buffer, 0, words, sizeof words), FNL_OK);
    assert_int_equal(gpu_read_buffer(device, &buffer, 0, got, sizeof got), FNL_OK);
    assert_memory_equal(words, got, sizeof got);
    test_fetch_mip(device, &image, 0, texels);
    for (uint32_t i = 0; i < 64 * 64; i++) assert_true(fabsf(texels[i].z * 255 - pixels[4 * i + 2]) < 0.01f);
    gpu_image_destroy(device, &image);
    gpu_buffer_destroy(device, &buffer);
    gpu_heap_destroy(device, &heap);
    assert_null(heap.memory);
    test_device_destroy(&device);
}

static void test_what_is_destroyed_right_after_its_upload(void **state) {
    UNUSED(state);
    gpu_device *device = test_device_create(NULL);
    uint32_t word = 1;
    for (uint32_t i = 0; i < 8; i++) {
        struct gpu_buffer buffer;
        assert_int_equal(gpu_buffer_create(device, "short-lived", 4, GPU_MEMORY_DEVICE, &buffer), FNL_OK);
        assert_int_equal(gpu_upload_buffer(device, &buffer, 0, &word, 4), FNL_OK);
        gpu_buffer_destroy(device, &buffer); /* its copy is not even submitted yet */
        assert_int_equal(gpu_frame_begin(device), FNL_OK);
        assert_int_equal(gpu_frame_end(device, NULL, 0, NULL), FNL_OK);
    }
    test_device_destroy(&device);
}

static VKAPI_ATTR VkResult VKAPI_CALL map_nothing(VkDevice device, VkDeviceMemory memory, VkDeviceSize offset,
                                                  VkDeviceSize size, VkMemoryMapFlags flags, void **data) {
    UNUSED(device);
    UNUSED(memory);
    UNUSED(offset);
    UNUSED(size);
    UNUSED(flags);
    *data = MAP_FAILED;
    return VK_SUCCESS;
}

/* As the CPU driver does when addresses run out. */
static void test_mapping_that_failed_is_no_success(void **state) {
    UNUSED(state);
    struct test_memory memory = {0};
    gpu_device *device = test_device_create(&memory);
    struct gpu_memory_stats before = gpu_memory_stats(device);
    struct gpu_buffer buffer;
    PFN_vkMapMemory real = device->vk.MapMemory;
    device->vk.MapMemory = map_nothing;
    assert_int_equal(gpu_buffer_create(device, "unmapped", (uint64_t)40 << 20, GPU_MEMORY_UPLOAD, &buffer), FNL_ERROR_MEMORY);
    device->vk.MapMemory = real;
    assert_non_null(strstr(memory.last_error, "'unmapped'"));
    assert_int_equal(gpu_memory_stats(device).reserved_bytes, before.reserved_bytes);
    assert_int_equal(gpu_buffer_create(device, "mapped", (uint64_t)40 << 20, GPU_MEMORY_UPLOAD, &buffer), FNL_OK);
    memset(buffer.mapped, 1, (size_t)40 << 20);
    gpu_buffer_destroy(device, &buffer);
    test_device_destroy(&device);
}

const struct CMUnitTest memory_tests[] = {
    cmocka_unit_test(test_buffers_come_back_as_sent),
    cmocka_unit_test(test_threads_upload_at_once),
    cmocka_unit_test(test_mips_are_averages_of_light),
    cmocka_unit_test(test_images_bigger_than_the_ring_go_in_slices),
    cmocka_unit_test(test_images_that_cannot_be_are_refused),
    cmocka_unit_test(test_memory_is_accounted),
    cmocka_unit_test(test_memory_is_accounted_by_use),
    cmocka_unit_test(test_the_bindless_set_fills),
    cmocka_unit_test(test_a_heap_holds_images_and_buffers),
    cmocka_unit_test(test_what_is_destroyed_right_after_its_upload),
    cmocka_unit_test(test_mapping_that_failed_is_no_success),
};
const size_t memory_test_count = COUNT_OF(memory_tests);
