/* SPDX-License-Identifier: MIT */
/*
 * Pipelines that several threads make, and the file that they are kept in, with a driver whose cache the test can look into: it holds the
 * factors of the test's shader, and its data are the header that Vulkan prescribes with the factors behind. The pipelines are real.
 */
#include "tests/gpu_test.h"

#include <unistd.h>

enum { MOST = 16 };

static struct fake {
    pthread_mutex_t mutex;
    pthread_cond_t changed;
    uint32_t making, most_making; /* at once */
    uint32_t held;                /* the pipeline of this factor is not made until it is released */
    PFN_vkCreateComputePipelines create;
    const gpu_device *device;
    uint32_t caches_alive;
} fake = {.mutex = PTHREAD_MUTEX_INITIALIZER, .changed = PTHREAD_COND_INITIALIZER};

struct fake_cache {
    uint32_t count, factors[MOST];
};

static bool put_factor(struct fake_cache *cache, uint32_t factor) {
    for (uint32_t i = 0; i < cache->count; i++)
        if (cache->factors[i] == factor) return true;
    assert_true(cache->count < MOST);
    cache->factors[cache->count++] = factor;
    return false;
}

static VKAPI_ATTR VkResult VKAPI_CALL create_cache(VkDevice device, const VkPipelineCacheCreateInfo *info,
                                                   const VkAllocationCallbacks *allocator, VkPipelineCache *out) {
    UNUSED(device);
    UNUSED(allocator);
    struct fake_cache *cache = calloc(1, sizeof *cache);
    if (info->initialDataSize) {
        cache->count = (uint32_t)((info->initialDataSize - sizeof(VkPipelineCacheHeaderVersionOne)) / 4);
        assert_true(cache->count <= MOST);
        memcpy(cache->factors, (const char *)info->pInitialData + sizeof(VkPipelineCacheHeaderVersionOne), cache->count * 4ull);
    }
    fake.caches_alive++;
    *out = (VkPipelineCache)(uintptr_t)cache;
    return VK_SUCCESS;
}

static VKAPI_ATTR void VKAPI_CALL destroy_cache(VkDevice device, VkPipelineCache cache, const VkAllocationCallbacks *allocator) {
    UNUSED(device);
    UNUSED(allocator);
    if (!cache) return;
    fake.caches_alive--;
    free((void *)(uintptr_t)cache);
}

static VKAPI_ATTR VkResult VKAPI_CALL get_data(VkDevice device, VkPipelineCache handle, size_t *size, void *data) {
    UNUSED(device);
    const struct fake_cache *cache = (const void *)(uintptr_t)handle;
    VkPipelineCacheHeaderVersionOne header = {sizeof header, VK_PIPELINE_CACHE_HEADER_VERSION_ONE,
                                              fake.device->properties.vendorID, fake.device->properties.deviceID, {0}};
    memcpy(header.pipelineCacheUUID, fake.device->properties.pipelineCacheUUID, VK_UUID_SIZE);
    *size = sizeof header + cache->count * 4ull;
    if (!data) return VK_SUCCESS;
    memcpy(data, &header, sizeof header);
    memcpy((char *)data + sizeof header, cache->factors, cache->count * 4ull);
    return VK_SUCCESS;
}

static VKAPI_ATTR VkResult VKAPI_CALL merge(VkDevice device, VkPipelineCache into, uint32_t count, const VkPipelineCache *from) {
    UNUSED(device);
    for (uint32_t i = 0; i < count; i++) {
        const struct fake_cache *other = (const void *)(uintptr_t)from[i];
        for (uint32_t k = 0; k < other->count; k++) put_factor((void *)(uintptr_t)into, other->factors[k]);
    }
    return VK_SUCCESS;
}

static VKAPI_ATTR VkResult VKAPI_CALL create(VkDevice device, VkPipelineCache handle, uint32_t count,
                                             const VkComputePipelineCreateInfo *infos, const VkAllocationCallbacks *allocator,
                                             VkPipeline *out) {
    const uint32_t factor = ((const uint32_t *)infos->stage.pSpecializationInfo->pData)[1];
    const VkPipelineCreationFeedbackCreateInfo *wanted = infos->pNext;
    assert_int_equal(wanted->sType, VK_STRUCTURE_TYPE_PIPELINE_CREATION_FEEDBACK_CREATE_INFO);
    pthread_mutex_lock(&fake.mutex);
    fake.making++;
    fake.most_making = MAX(fake.most_making, fake.making);
    while (fake.held == factor) pthread_cond_wait(&fake.changed, &fake.mutex);
    bool hit = put_factor((void *)(uintptr_t)handle, factor);
    pthread_mutex_unlock(&fake.mutex);
    VkComputePipelineCreateInfo info = *infos;
    info.pNext = NULL;
    VkResult result = fake.create(device, VK_NULL_HANDLE, count, &info, allocator, out);
    wanted->pPipelineCreationFeedback->flags = VK_PIPELINE_CREATION_FEEDBACK_VALID_BIT;
    if (hit)
        wanted->pPipelineCreationFeedback->flags |= VK_PIPELINE_CREATION_FEEDBACK_APPLICATION_PIPELINE_CACHE_HIT_BIT;
    pthread_mutex_lock(&fake.mutex);
    fake.making--;
    pthread_mutex_unlock(&fake.mutex);
    return result;
}

/* A device whose cache is the test's, from the file in the folder. */
static gpu_device *open_device(const char *folder, uint32_t threads) {
    fnl_device_params params = fnl_device_params_default();
    params.host.thread_count = threads;
    params.cache_folder = "";
    gpu_device *device;
    assert_int_equal(fnl_device_create(&params, &device), FNL_OK);
    fake.device = device;
    fake.create = device->vk.CreateComputePipelines;
    device->compiles_late = false; /* nothing is rehearsed */
    device->vk.DestroyPipelineCache(device->handle, device->pipelines.cache, NULL);
    device->vk.CreatePipelineCache = create_cache;
    device->vk.DestroyPipelineCache = destroy_cache;
    device->vk.GetPipelineCacheData = get_data;
    device->vk.MergePipelineCaches = merge;
    device->vk.CreateComputePipelines = create;
    assert_int_equal(gpu_pipeline_cache_load(device, folder), FNL_OK);
    return device;
}

static void make(gpu_device *device, uint32_t first, uint32_t count) { gpu_ask_wait(device, test_ask(device, first, count)); }

static void test_two_processes_share_the_file(void **state) {
    UNUSED(state);
    char folder[64], path[512];
    snprintf(folder, sizeof folder, "/tmp/fanal-cache-test-%d", (int)getpid());
    gpu_device *a = open_device(folder, 2), *b = open_device(folder, 2); /* neither finds a file */
    make(a, 1, 3);
    make(b, 3, 2);
    make(b, 3, 2);
    assert_int_equal(gpu_pipeline_stats(a).made, 3);
    assert_int_equal(gpu_pipeline_stats(b).made, 2);
    assert_int_equal(gpu_pipeline_stats(b).cached, 0);
    snprintf(path, sizeof path, "%s", a->pipelines.cache_path);
    fnl_device_destroy(&a);
    fnl_device_destroy(&b); /* keeps what the first has saved */
    gpu_device *c = open_device(folder, 2);
    make(c, 1, 5);
    assert_int_equal(gpu_pipeline_stats(c).made, 5);
    assert_int_equal(gpu_pipeline_stats(c).cached, 4); /* but for the last */
    fnl_device_destroy(&c);
    assert_int_equal(fake.caches_alive, 0);

    /* What is no cache is left alone by a merge, and replaced. */
    gpu_device *d = open_device(folder, 2);
    fnl_host host = fnl_host_default();
    assert_int_equal(file_save(&host, path, "rubbish", 7), FNL_OK);
    make(d, 6, 1);
    fnl_device_destroy(&d);
    gpu_device *e = open_device(folder, 2);
    make(e, 1, 6);
    assert_int_equal(gpu_pipeline_stats(e).cached, 6);
    fnl_device_destroy(&e);
    assert_int_equal(fake.caches_alive, 0);
    unlink(path);
    rmdir(folder);
}

/* The second pipeline is made while the first is not; what counts as done are those before the first that is missing. */
static void test_several_threads_make_pipelines(void **state) {
    UNUSED(state);
    gpu_device *device = open_device("", 3);
    fake.held = 1;
    fake.most_making = 0;
    uint64_t ticket = test_ask(device, 1, 6);
    assert_int_equal(device->pipelines.worker_count, 3);
    while (gpu_pipeline_stats(device).made < 5) usleep(1000);
    assert_int_equal(gpu_pipeline_stats(device).made, 5);
    assert_int_equal(gpu_pipeline_stats(device).done, 0);
    assert_true(fake.most_making >= 2);
    pthread_mutex_lock(&fake.mutex);
    fake.held = 0;
    pthread_cond_broadcast(&fake.changed);
    pthread_mutex_unlock(&fake.mutex);
    gpu_ask_wait(device, ticket);
    assert_int_equal(gpu_pipeline_stats(device).done, 6);
    assert_int_equal(gpu_pipeline_stats(device).made, 6);
    gpu_ask_wait(device, ticket + 10); /* more than was ever asked for: what was */
    fnl_device_destroy(&device);
}

const struct CMUnitTest cache_tests[] = {
    cmocka_unit_test(test_two_processes_share_the_file),
    cmocka_unit_test(test_several_threads_make_pipelines),
};
const size_t cache_test_count = COUNT_OF(cache_tests);
