/* SPDX-License-Identifier: MIT */
/*
 * What a GPU's compiler makes of every pipeline: registers, spills, scratch and shared memory, occupancy, instructions, latency. Needs no GPU: Mesa's
 * radv offers null hardware (RADV_FORCE_FAMILY=navi31), which compiles and cannot run. tools/shaders.sh runs it.
 *
 * The library gets the device by import, through functions of ours: those that take memory, record, submit or wait do nothing, and those that make
 * pipelines also ask what was made (VK_KHR_pipeline_executable_properties). Then fnl_renderer_warm() goes through shading paths, light lists, sample
 * counts and options. Prints a row for each shader: how many different programs it was compiled to, and the worst of each number
 * among them. With --all, each program has a row. With --only TEXT, only shaders whose names hold the text are compiled. The first line ends in a number
 * that stands for all that goes into the pipelines; with --inputs it is all that is printed, and nothing is compiled.
 */
#include "../tests/frame_plain.h"
#include <fanal/fanal.h>
#include <fanal/vulkan.h>

#include <dlfcn.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define COUNT_OF(array) (sizeof(array) / sizeof *(array))

static void fail(const char *what) {
    fprintf(stderr, "shader_report: %s\n", what);
    exit(2);
}

/* ---- what was compiled ---- */

/* The columns, as radv calls them. */
static const struct {
    const char *statistic, *column;
    bool less_is_worse;
} columns[] = {{"Subgroups per SIMD", "waves", true},
               {"VGPRs", "vgprs", false},
               {"Spilled VGPRs", "vgprs_spilled", false},
               {"Spilled SGPRs", "sgprs_spilled", false},
               {"Scratch size", "scratch_bytes", false},
               {"LDS size", "lds_bytes", false},
               {"Instructions", "instructions", false},
               {"Latency", "latency", false},
               {"Code size", "code_bytes", false}};
enum { INSTRUCTIONS = 6 };

struct row {
    char shader[64], constants[200];
    uint64_t values[COUNT_OF(columns)];
    uint32_t variants;
};

struct module {
    VkShaderModule handle;
    char name[64];
    uint64_t code; /* hash of the SPIR-V */
};

static struct {
    pthread_mutex_t mutex;
    VkDevice device;
    PFN_vkGetDeviceProcAddr get_proc;
    PFN_vkGetPipelineExecutablePropertiesKHR properties;
    PFN_vkGetPipelineExecutableStatisticsKHR statistics;
    PFN_vkCreateShaderModule create_module;
    PFN_vkCreateComputePipelines create_compute;
    PFN_vkCreateGraphicsPipelines create_graphics;
    PFN_vkGetDeviceBufferMemoryRequirements buffer_needs;
    struct row *rows;
    uint32_t row_count, row_capacity, pipeline_count, refused_count;
    struct module *modules;
    uint32_t module_count, module_capacity;
    const char *only; /* NULL: all */
    bool inputs_alone;
    uint64_t *inputs; /* what describe_…() gave, each once: pipelines are made in any order, and some again */
    uint32_t input_count, input_capacity;
} report = {.mutex = PTHREAD_MUTEX_INITIALIZER};

static void *grow(void *data, uint32_t count, uint32_t *capacity, size_t size) {
    if (count < *capacity) return data;
    *capacity = *capacity ? *capacity * 2 : 256;
    data = realloc(data, *capacity * size);
    if (!data) fail("out of memory");
    return data;
}

/* The entry of a module, new unless there is one. A handle may be used again for another module. The mutex is held. */
static struct module *module_of(uint64_t handle) {
    uint32_t i = 0;
    while (i < report.module_count && (uint64_t)report.modules[i].handle != handle) i++;
    report.modules = grow(report.modules, i, &report.module_capacity, sizeof *report.modules);
    if (i == report.module_count) report.modules[report.module_count++] = (struct module){.handle = (VkShaderModule)handle};
    return &report.modules[i];
}

/* FNV-1a. */
static uint64_t hash(const void *data, size_t size, uint64_t seed) {
    for (size_t i = 0; i < size; i++) seed = (seed ^ ((const unsigned char *)data)[i]) * 0x100000001b3;
    return seed;
}
#define HASH_VALUE(value, seed) hash(&(value), sizeof(value), seed)

static VkResult VKAPI_CALL create_module(VkDevice device, const VkShaderModuleCreateInfo *info, const VkAllocationCallbacks *allocator, VkShaderModule *out) {
    VkResult result = report.create_module(device, info, allocator, out);
    if (result != VK_SUCCESS) return result;
    pthread_mutex_lock(&report.mutex);
    module_of((uint64_t)*out)->code = hash(info->pCode, info->codeSize, 0xcbf29ce484222325);
    pthread_mutex_unlock(&report.mutex);
    return result;
}

static VkResult VKAPI_CALL set_name(VkDevice device, const VkDebugUtilsObjectNameInfoEXT *info) {
    (void)device;
    if (info->objectType != VK_OBJECT_TYPE_SHADER_MODULE) return VK_SUCCESS;
    pthread_mutex_lock(&report.mutex);
    struct module *module = module_of(info->objectHandle);
    snprintf(module->name, sizeof module->name, "%s", info->pObjectName);
    pthread_mutex_unlock(&report.mutex);
    return VK_SUCCESS;
}

static const char *name_of(VkShaderModule module) {
    for (uint32_t i = 0; i < report.module_count; i++)
        if (report.modules[i].handle == module) return report.modules[i].name;
    return "?";
}

static bool is_wanted(const VkPipelineShaderStageCreateInfo *stages, uint32_t count) {
    bool wanted = !report.only;
    pthread_mutex_lock(&report.mutex);
    for (uint32_t i = 0; i < count; i++) wanted = wanted || strstr(name_of(stages[i].module), report.only);
    pthread_mutex_unlock(&report.mutex);
    return wanted;
}

/*
 * Shaders that light come in kinds, which have a row each: for lights of all shapes or for spheres and cones alone (GPU_LIGHTING_SIMPLE, a bit beside
 * the kind of list in constant 0), without shadows or with (GPU_LIGHTING_RAYS, GPU_LIGHTING_MAPS, GPU_LIGHTING_SOFT, GPU_LIGHTING_FILTERED,
 * GPU_LIGHTING_SAMPLED, GPU_LIGHTING_RAY_QUERY, GPU_LIGHTING_GUIDED). The worst of all would hide what the others gain.
 */
static void name_kind(struct row *row) {
    enum { KINDS = 0xff, LAST_KIND = 12, LAST_BIT = 0x8000, GUIDED = 0x1000000 };
    static const struct {
        unsigned bit;
        const char *name;
    } bits[] = {{0x200, " simple"}, {0x800, " maps"}, {0x2000, " filtered"}, {0x400, " rays"}, {0x1000, " soft"}, {0x4000, " sampled"}, {LAST_BIT, " query"}, {GUIDED, " guided"}};
    unsigned value = 0;
    if (sscanf(row->constants, "0=%u", &value) != 1 || (value & KINDS) > LAST_KIND || (value & ~(unsigned)GUIDED) >= 2 * LAST_BIT) return;
    for (size_t i = 0; i < COUNT_OF(bits); i++)
        if (value & bits[i].bit) {
            size_t length = strlen(row->shader);
            snprintf(row->shader + length, sizeof row->shader - length, "%s", bits[i].name);
        }
}

static void add_row(const struct row *row) {
    for (uint32_t i = 0; i < report.row_count; i++)
        if (strcmp(report.rows[i].shader, row->shader) == 0 && memcmp(report.rows[i].values, row->values, sizeof row->values) == 0) {
            report.rows[i].variants++;
            if (strcmp(row->constants, report.rows[i].constants) < 0) memcpy(report.rows[i].constants, row->constants, sizeof row->constants);
            return;
        }
    report.rows = grow(report.rows, report.row_count, &report.row_capacity, sizeof *report.rows);
    report.rows[report.row_count++] = *row;
}

static uint64_t statistic_value(const VkPipelineExecutableStatisticKHR *s) {
    switch (s->format) {
    case VK_PIPELINE_EXECUTABLE_STATISTIC_FORMAT_BOOL32_KHR: return s->value.b32;
    case VK_PIPELINE_EXECUTABLE_STATISTIC_FORMAT_INT64_KHR: return (uint64_t)s->value.i64;
    case VK_PIPELINE_EXECUTABLE_STATISTIC_FORMAT_FLOAT64_KHR: return (uint64_t)s->value.f64;
    default: return s->value.u64;
    }
}

static void print_constants(const VkSpecializationInfo *info, char *out, size_t capacity) {
    size_t length = 0;
    *out = 0;
    for (uint32_t i = 0; info && i < info->mapEntryCount && length < capacity; i++) {
        const VkSpecializationMapEntry *entry = &info->pMapEntries[i];
        uint32_t value;
        memcpy(&value, (const char *)info->pData + entry->offset, sizeof value);
        if (value) length += (size_t)snprintf(out + length, capacity - length, "%s%u=%u", length ? " " : "", entry->constantID, value);
    }
}

/* Objects that are nothing but a handle. */
static uint64_t some_handle(void) {
    static uint64_t next;
    return ++next;
}

/* Executables of one pipeline, each for one or several of its stages. */
static void add_pipeline(VkPipeline pipeline, const VkPipelineShaderStageCreateInfo *stages, uint32_t stage_count) {
    VkPipelineExecutablePropertiesKHR executables[8];
    uint32_t count = COUNT_OF(executables);
    for (uint32_t i = 0; i < count; i++)
        executables[i] = (VkPipelineExecutablePropertiesKHR){.sType = VK_STRUCTURE_TYPE_PIPELINE_EXECUTABLE_PROPERTIES_KHR};
    const VkPipelineInfoKHR pipeline_info = {.sType = VK_STRUCTURE_TYPE_PIPELINE_INFO_KHR, .pipeline = pipeline};
    if (report.properties(report.device, &pipeline_info, &count, executables) < 0) fail("vkGetPipelineExecutablePropertiesKHR");
    report.pipeline_count++;
    for (uint32_t e = 0; e < count; e++) {
        VkPipelineExecutableStatisticKHR statistics[64];
        uint32_t statistic_count = COUNT_OF(statistics);
        for (uint32_t i = 0; i < statistic_count; i++)
            statistics[i] = (VkPipelineExecutableStatisticKHR){.sType = VK_STRUCTURE_TYPE_PIPELINE_EXECUTABLE_STATISTIC_KHR};
        const VkPipelineExecutableInfoKHR info = {.sType = VK_STRUCTURE_TYPE_PIPELINE_EXECUTABLE_INFO_KHR, .pipeline = pipeline, .executableIndex = e};
        if (report.statistics(report.device, &info, &statistic_count, statistics) < 0) fail("vkGetPipelineExecutableStatisticsKHR");
        struct row row = {.variants = 1};
        for (uint32_t s = 0; s < stage_count; s++) {
            if (!(executables[e].stages & stages[s].stage)) continue;
            size_t length = strlen(row.shader);
            snprintf(row.shader + length, sizeof row.shader - length, "%s%s", length ? "+" : "", name_of(stages[s].module));
            print_constants(stages[s].pSpecializationInfo, row.constants, sizeof row.constants);
        }
        if (!row.shader[0]) continue; /* made by the driver, such as copies of geometry shaders */
        name_kind(&row);
        for (uint32_t i = 0; i < statistic_count; i++)
            for (uint32_t c = 0; c < COUNT_OF(columns); c++)
                if (strcmp(statistics[i].name, columns[c].statistic) == 0) row.values[c] = statistic_value(&statistics[i]);
        add_row(&row);
    }
}

static uint64_t describe_stages(const VkPipelineShaderStageCreateInfo *stages, uint32_t count) {
    uint64_t sum = 0xcbf29ce484222325;
    pthread_mutex_lock(&report.mutex);
    for (uint32_t i = 0; i < count; i++) {
        const struct module *module = module_of((uint64_t)stages[i].module);
        const VkSpecializationInfo *info = stages[i].pSpecializationInfo;
        sum = HASH_VALUE(module->code, hash(module->name, strlen(module->name), sum));
        if (info) sum = hash(info->pData, info->dataSize, hash(info->pMapEntries, info->mapEntryCount * sizeof *info->pMapEntries, sum));
    }
    pthread_mutex_unlock(&report.mutex);
    return sum;
}

/* What drivers compile into the code. */
static uint64_t describe_graphics(const VkGraphicsPipelineCreateInfo *info) {
    uint64_t sum = describe_stages(info->pStages, info->stageCount);
    sum = HASH_VALUE(info->pMultisampleState->rasterizationSamples, sum);
    if (info->pInputAssemblyState) sum = HASH_VALUE(info->pInputAssemblyState->topology, sum);
    if (info->pColorBlendState)
        sum = hash(info->pColorBlendState->pAttachments, info->pColorBlendState->attachmentCount * sizeof *info->pColorBlendState->pAttachments, sum);
    for (const VkBaseInStructure *next = info->pNext; next; next = next->pNext) {
        if (next->sType != VK_STRUCTURE_TYPE_PIPELINE_RENDERING_CREATE_INFO) continue;
        const VkPipelineRenderingCreateInfo *rendering = (const VkPipelineRenderingCreateInfo *)next;
        sum = hash(rendering->pColorAttachmentFormats, rendering->colorAttachmentCount * sizeof *rendering->pColorAttachmentFormats, sum);
        sum = HASH_VALUE(rendering->depthAttachmentFormat, HASH_VALUE(rendering->viewMask, sum));
    }
    return sum;
}

static VkResult skip_pipeline(VkPipeline *out) {
    *out = (VkPipeline)some_handle();
    return VK_SUCCESS;
}

/* Also false where nothing is to be compiled. */
static bool is_compiled(const VkPipelineShaderStageCreateInfo *stages, uint32_t count, uint64_t description) {
    pthread_mutex_lock(&report.mutex);
    uint32_t i = 0;
    while (i < report.input_count && report.inputs[i] != description) i++;
    report.inputs = grow(report.inputs, i, &report.input_capacity, sizeof *report.inputs);
    if (i == report.input_count) report.inputs[report.input_count++] = description;
    pthread_mutex_unlock(&report.mutex);
    return !report.inputs_alone && is_wanted(stages, count);
}

static VkResult VKAPI_CALL create_compute(VkDevice device, VkPipelineCache cache, uint32_t count, const VkComputePipelineCreateInfo *infos,
                                          const VkAllocationCallbacks *allocator, VkPipeline *out) {
    (void)count; /* the library makes one at a time */
    VkComputePipelineCreateInfo info = *infos;
    if (!is_compiled(&info.stage, 1, describe_stages(&info.stage, 1))) return skip_pipeline(out);
    info.flags |= VK_PIPELINE_CREATE_CAPTURE_STATISTICS_BIT_KHR;
    VkResult result = report.create_compute(device, cache, 1, &info, allocator, out);
    pthread_mutex_lock(&report.mutex);
    if (result == VK_SUCCESS) add_pipeline(*out, &info.stage, 1);
    else report.refused_count++;
    pthread_mutex_unlock(&report.mutex);
    return result;
}

static VkResult VKAPI_CALL create_graphics(VkDevice device, VkPipelineCache cache, uint32_t count, const VkGraphicsPipelineCreateInfo *infos,
                                           const VkAllocationCallbacks *allocator, VkPipeline *out) {
    (void)count;
    VkGraphicsPipelineCreateInfo info = *infos;
    if (!is_compiled(info.pStages, info.stageCount, describe_graphics(&info))) return skip_pipeline(out);
    info.flags |= VK_PIPELINE_CREATE_CAPTURE_STATISTICS_BIT_KHR;
    VkResult result = report.create_graphics(device, cache, 1, &info, allocator, out);
    pthread_mutex_lock(&report.mutex);
    if (result == VK_SUCCESS) add_pipeline(*out, info.pStages, info.stageCount);
    else report.refused_count++;
    pthread_mutex_unlock(&report.mutex);
    return result;
}

/* ---- a device that runs nothing ---- */

static VkResult VKAPI_CALL create_semaphore(VkDevice device, const VkSemaphoreCreateInfo *info, const VkAllocationCallbacks *allocator, VkSemaphore *out) {
    (void)device, (void)info, (void)allocator;
    *out = (VkSemaphore)some_handle();
    return VK_SUCCESS;
}
static VkResult VKAPI_CALL semaphore_value(VkDevice device, VkSemaphore semaphore, uint64_t *out) {
    (void)device, (void)semaphore;
    *out = UINT64_MAX;
    return VK_SUCCESS;
}
/* Null hardware has no memory. Ours takes room only where it is written. */
static VkResult VKAPI_CALL allocate_memory(VkDevice device, const VkMemoryAllocateInfo *info, const VkAllocationCallbacks *allocator, VkDeviceMemory *out) {
    (void)device, (void)allocator;
    void *memory = calloc(1, info->allocationSize);
    *out = (VkDeviceMemory)(uintptr_t)memory;
    return memory ? VK_SUCCESS : VK_ERROR_OUT_OF_DEVICE_MEMORY;
}
static void VKAPI_CALL free_memory(VkDevice device, VkDeviceMemory memory, const VkAllocationCallbacks *allocator) {
    (void)device, (void)allocator;
    free((void *)(uintptr_t)memory);
}
static VkResult VKAPI_CALL map_memory(VkDevice device, VkDeviceMemory memory, VkDeviceSize offset, VkDeviceSize size, VkMemoryMapFlags flags, void **out) {
    (void)device, (void)size, (void)flags;
    *out = (char *)(uintptr_t)memory + offset;
    return VK_SUCCESS;
}
static VkResult VKAPI_CALL create_image(VkDevice device, const VkImageCreateInfo *info, const VkAllocationCallbacks *allocator, VkImage *out) {
    (void)device, (void)info, (void)allocator;
    *out = (VkImage)some_handle();
    return VK_SUCCESS;
}
static VkResult VKAPI_CALL create_view(VkDevice device, const VkImageViewCreateInfo *info, const VkAllocationCallbacks *allocator, VkImageView *out) {
    (void)device, (void)info, (void)allocator;
    *out = (VkImageView)some_handle();
    return VK_SUCCESS;
}
static VkDeviceAddress VKAPI_CALL buffer_address(VkDevice device, const VkBufferDeviceAddressInfo *info) {
    (void)device;
    return (VkDeviceAddress)info->buffer;
}
static void VKAPI_CALL buffer_needs(VkDevice device, const VkDeviceBufferMemoryRequirements *info, VkMemoryRequirements2 *out) {
    report.buffer_needs(device, info, out);
    out->memoryRequirements.memoryTypeBits = 1;
}
static void VKAPI_CALL image_needs(VkDevice device, const VkDeviceImageMemoryRequirements *info, VkMemoryRequirements2 *out) {
    (void)device, (void)info;
    out->memoryRequirements = (VkMemoryRequirements){.size = 256, .alignment = 256, .memoryTypeBits = 1};
}
static void VKAPI_CALL memory_properties(VkPhysicalDevice physical, VkPhysicalDeviceMemoryProperties *out) {
    (void)physical;
    *out = (VkPhysicalDeviceMemoryProperties){.memoryTypeCount = 1, .memoryHeapCount = 1};
    out->memoryHeaps[0] = (VkMemoryHeap){(VkDeviceSize)16 << 30, VK_MEMORY_HEAP_DEVICE_LOCAL_BIT};
    out->memoryTypes[0].propertyFlags = VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT | VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT |
                                        VK_MEMORY_PROPERTY_HOST_COHERENT_BIT | VK_MEMORY_PROPERTY_HOST_CACHED_BIT;
}
static VkResult VKAPI_CALL create_structure(VkDevice device, const VkAccelerationStructureCreateInfoKHR *info, const VkAllocationCallbacks *allocator,
                                            VkAccelerationStructureKHR *out) {
    (void)device, (void)info, (void)allocator;
    *out = (VkAccelerationStructureKHR)some_handle();
    return VK_SUCCESS;
}
static VkDeviceAddress VKAPI_CALL structure_address(VkDevice device, const VkAccelerationStructureDeviceAddressInfoKHR *info) {
    (void)device;
    return (VkDeviceAddress)info->accelerationStructure;
}
static void VKAPI_CALL structure_sizes(VkDevice device, VkAccelerationStructureBuildTypeKHR type, const VkAccelerationStructureBuildGeometryInfoKHR *info,
                                       const uint32_t *counts, VkAccelerationStructureBuildSizesInfoKHR *out) {
    (void)device, (void)type, (void)info, (void)counts;
    out->accelerationStructureSize = out->buildScratchSize = out->updateScratchSize = 256;
}
/* For calls that return nothing. Ignoring the arguments is safe where the caller cleans up the stack, as on all ABIs that radv runs on. */
static void VKAPI_CALL do_nothing(void) {}
static VkResult VKAPI_CALL succeed(void) { return VK_SUCCESS; }

static PFN_vkVoidFunction VKAPI_CALL get_device_proc(VkDevice device, const char *name) {
    static const struct {
        const char *name;
        PFN_vkVoidFunction function;
    } ours[] = {{"vkCreateSemaphore", (PFN_vkVoidFunction)create_semaphore},
                {"vkDestroySemaphore", (PFN_vkVoidFunction)do_nothing},
                {"vkCreateImage", (PFN_vkVoidFunction)create_image},
                {"vkDestroyImage", (PFN_vkVoidFunction)do_nothing},
                {"vkCreateImageView", (PFN_vkVoidFunction)create_view},
                {"vkDestroyImageView", (PFN_vkVoidFunction)do_nothing},
                {"vkCreateAccelerationStructureKHR", (PFN_vkVoidFunction)create_structure},
                {"vkDestroyAccelerationStructureKHR", (PFN_vkVoidFunction)do_nothing},
                {"vkGetAccelerationStructureDeviceAddressKHR", (PFN_vkVoidFunction)structure_address},
                {"vkGetAccelerationStructureBuildSizesKHR", (PFN_vkVoidFunction)structure_sizes},
                {"vkBeginCommandBuffer", (PFN_vkVoidFunction)succeed},
                {"vkEndCommandBuffer", (PFN_vkVoidFunction)succeed},
                {"vkDeviceWaitIdle", (PFN_vkVoidFunction)succeed},
                {"vkUpdateDescriptorSets", (PFN_vkVoidFunction)do_nothing},
                {"vkWaitSemaphores", (PFN_vkVoidFunction)succeed},
                {"vkGetSemaphoreCounterValue", (PFN_vkVoidFunction)semaphore_value},
                {"vkQueueSubmit2", (PFN_vkVoidFunction)succeed},
                {"vkAllocateMemory", (PFN_vkVoidFunction)allocate_memory},
                {"vkFreeMemory", (PFN_vkVoidFunction)free_memory},
                {"vkMapMemory", (PFN_vkVoidFunction)map_memory},
                {"vkBindBufferMemory", (PFN_vkVoidFunction)succeed},
                {"vkBindImageMemory", (PFN_vkVoidFunction)succeed},
                {"vkGetBufferDeviceAddress", (PFN_vkVoidFunction)buffer_address},
                {"vkGetDeviceBufferMemoryRequirements", (PFN_vkVoidFunction)buffer_needs},
                {"vkGetDeviceImageMemoryRequirements", (PFN_vkVoidFunction)image_needs},
                {"vkSetDebugUtilsObjectNameEXT", (PFN_vkVoidFunction)set_name},
                {"vkCreateShaderModule", (PFN_vkVoidFunction)create_module},
                {"vkCreateComputePipelines", (PFN_vkVoidFunction)create_compute},
                {"vkCreateGraphicsPipelines", (PFN_vkVoidFunction)create_graphics}};
    for (size_t i = 0; i < COUNT_OF(ours); i++)
        if (strcmp(name, ours[i].name) == 0) return ours[i].function;
    if ((report.only || report.inputs_alone) && strcmp(name, "vkDestroyPipeline") == 0) return (PFN_vkVoidFunction)do_nothing; /* most are not there */
    if (strncmp(name, "vkCmd", 5) == 0) return (PFN_vkVoidFunction)do_nothing;
    return report.get_proc(device, name);
}

static PFN_vkGetInstanceProcAddr loader;

static PFN_vkVoidFunction VKAPI_CALL get_instance_proc(VkInstance instance, const char *name) {
    if (strcmp(name, "vkGetDeviceProcAddr") == 0) return (PFN_vkVoidFunction)get_device_proc;
    if (strcmp(name, "vkGetPhysicalDeviceMemoryProperties") == 0) return (PFN_vkVoidFunction)memory_properties;
    return loader(instance, name);
}

/* Many combinations are refused, which is no error here. */
static void log_nothing(void *user, fnl_log_level level, const char *line) { (void)user, (void)level, (void)line; }

#define LOAD(instance, name) ((PFN_##name)loader(instance, #name))

/* The first device, with everything on that Fanal can use. */
static fnl_device *open_device(char *name, size_t capacity) {
    void *library = dlopen("libvulkan.so.1", RTLD_NOW);
    void *symbol = library ? dlsym(library, "vkGetInstanceProcAddr") : NULL;
    if (!symbol) fail("there is no Vulkan loader");
    memcpy(&loader, &symbol, sizeof symbol);
    const char *instance_extensions[] = {VK_EXT_DEBUG_UTILS_EXTENSION_NAME};
    const VkApplicationInfo application = {.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO, .apiVersion = VK_API_VERSION_1_3};
    const VkInstanceCreateInfo instance_info = {.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO,
                                                .pApplicationInfo = &application,
                                                .enabledExtensionCount = 1,
                                                .ppEnabledExtensionNames = instance_extensions};
    VkInstance instance;
    if (LOAD(NULL, vkCreateInstance)(&instance_info, NULL, &instance) != VK_SUCCESS) fail("vkCreateInstance");
    VkPhysicalDevice physical;
    uint32_t count = 1;
    if (LOAD(instance, vkEnumeratePhysicalDevices)(instance, &count, &physical) < 0 || count == 0) fail("there is no device");
    VkPhysicalDeviceDriverProperties driver = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DRIVER_PROPERTIES};
    VkPhysicalDeviceProperties2 properties = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, .pNext = &driver};
    LOAD(instance, vkGetPhysicalDeviceProperties2)(physical, &properties);
    snprintf(name, capacity, "%s, %s %s", properties.properties.deviceName, driver.driverName, driver.driverInfo);

    fnl_vulkan_requirements requirements;
    fnl_vulkan_requirements_init(&requirements);
    requirements.features.features.geometryShader = VK_TRUE;
    requirements.features.features.shaderClipDistance = VK_TRUE;
    requirements.features.features.imageCubeArray = VK_TRUE;
    requirements.features.features.sampleRateShading = VK_TRUE;
    requirements.features_11.multiview = VK_TRUE;
    requirements.features_12.samplerFilterMinmax = VK_TRUE;
    requirements.features_12.shaderOutputLayer = VK_TRUE;
    VkPhysicalDeviceMeshShaderFeaturesEXT meshes = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MESH_SHADER_FEATURES_EXT, .pNext = &requirements.features, .meshShader = VK_TRUE};
    VkPhysicalDevicePipelineExecutablePropertiesFeaturesKHR executables = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PIPELINE_EXECUTABLE_PROPERTIES_FEATURES_KHR, .pNext = &meshes, .pipelineExecutableInfo = VK_TRUE};
    VkPhysicalDeviceRayQueryFeaturesKHR queries = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_RAY_QUERY_FEATURES_KHR, .pNext = &executables, .rayQuery = VK_TRUE};
    VkPhysicalDeviceAccelerationStructureFeaturesKHR structures = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ACCELERATION_STRUCTURE_FEATURES_KHR, .pNext = &queries, .accelerationStructure = VK_TRUE};
    static const char *const extensions[] = {VK_KHR_RAY_QUERY_EXTENSION_NAME, VK_KHR_ACCELERATION_STRUCTURE_EXTENSION_NAME,
                                             VK_KHR_DEFERRED_HOST_OPERATIONS_EXTENSION_NAME, VK_KHR_PIPELINE_EXECUTABLE_PROPERTIES_EXTENSION_NAME, VK_EXT_MESH_SHADER_EXTENSION_NAME,
                                             VK_EXT_CONSERVATIVE_RASTERIZATION_EXTENSION_NAME, VK_EXT_POST_DEPTH_COVERAGE_EXTENSION_NAME};
    const float priority = 1;
    const VkDeviceQueueCreateInfo queue = {.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO, .queueCount = 1, .pQueuePriorities = &priority};
    const VkDeviceCreateInfo device_info = {.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
                                            .pNext = &structures,
                                            .queueCreateInfoCount = 1,
                                            .pQueueCreateInfos = &queue,
                                            .enabledExtensionCount = COUNT_OF(extensions),
                                            .ppEnabledExtensionNames = extensions};
    if (LOAD(instance, vkCreateDevice)(physical, &device_info, NULL, &report.device) != VK_SUCCESS)
        fail("vkCreateDevice: the device lacks an extension that shaders are to be compiled with");
    report.get_proc = LOAD(instance, vkGetDeviceProcAddr);
    report.properties = (PFN_vkGetPipelineExecutablePropertiesKHR)report.get_proc(report.device, "vkGetPipelineExecutablePropertiesKHR");
    report.statistics = (PFN_vkGetPipelineExecutableStatisticsKHR)report.get_proc(report.device, "vkGetPipelineExecutableStatisticsKHR");
    report.create_module = (PFN_vkCreateShaderModule)report.get_proc(report.device, "vkCreateShaderModule");
    report.create_compute = (PFN_vkCreateComputePipelines)report.get_proc(report.device, "vkCreateComputePipelines");
    report.create_graphics = (PFN_vkCreateGraphicsPipelines)report.get_proc(report.device, "vkCreateGraphicsPipelines");
    report.buffer_needs = (PFN_vkGetDeviceBufferMemoryRequirements)report.get_proc(report.device, "vkGetDeviceBufferMemoryRequirements");
    VkQueue handle;
    ((PFN_vkGetDeviceQueue)report.get_proc(report.device, "vkGetDeviceQueue"))(report.device, 0, 0, &handle);
    const fnl_vulkan_import import = {.get_instance_proc_addr = get_instance_proc,
                                      .instance = instance,
                                      .physical_device = physical,
                                      .device = report.device,
                                      .graphics_queue = handle,
                                      .created = &device_info};
    fnl_device *device = NULL;
    fnl_device_params params = fnl_device_params_default();
    params.host.log = log_nothing;
    params.cache_folder = "";
    if (fnl_device_import(&params, &import, &device) != FNL_OK) fail("the device cannot be imported");
    return device;
}

/* ---- everything that frames are made of ---- */

static bool waits; /* for the pipelines of each frame */

/* Combinations that a path or the device does not support are refused: nothing to compile. */
static void warm(fnl_renderer *renderer, const fnl_frame *frame) { fnl_renderer_warm(renderer, frame, NULL, waits, NULL); }

static const fnl_host quiet = {.log = log_nothing};

/* The words of the i-th value of an option; NULL beyond the last. Numbers in a range hardly change code: only choices of numbers count. */
static const char *value_of(const fnl_option *option, uint32_t i, char text[32]) {
    if (option->kind == FNL_OPTION_SWITCH) return i == 0 ? "off" : i == 1 ? "on" : NULL;
    if (option->kind == FNL_OPTION_NAME) return fnl_value_name(option->names, (int)i);
    if (i >= option->choice_count) return NULL;
    snprintf(text, 32, "%u", option->choices[i]);
    return text;
}

/* Each value of each option from `first` on; `depth` 2: with each value of each option behind it, where both belong to some paths alone. */
static void warm_options(fnl_renderer *renderer, const fnl_frame *base, uint32_t first, uint32_t depth) {
    fnl_option option;
    char text[32];
    for (uint32_t index = first; fnl_option_query(index, &option); index++) {
        fnl_frame frame = *base;
        bool own = option.shadings != UINT32_MAX;
        bool walked = strcmp(option.key, "shading") == 0 || strcmp(option.key, "msaa") == 0; /* by warm_all */
        if (walked || !(option.shadings >> frame.shading & 1) || (first > 0 && !own)) continue;
        if (option.lists != UINT32_MAX)
            for (frame.lists = 0; frame.lists < FNL_LISTS_AUTO && !(option.lists >> frame.lists & 1);) frame.lists++;
        for (uint32_t i = 0; value_of(&option, i, text); i++) {
            if (fnl_frame_set(&quiet, &frame, option.key, value_of(&option, i, text)) != FNL_OK) continue;
            warm(renderer, &frame);
            if (own && depth > 1) warm_options(renderer, &frame, index + 1, depth - 1);
        }
    }
}

static void warm_with(fnl_renderer *renderer, const fnl_frame *base, const char *const *settings) { /* pairs of key and value up to NULL */
    fnl_frame frame = *base;
    for (; settings[0]; settings += 2)
        if (fnl_frame_set(&quiet, &frame, settings[0], settings[1]) != FNL_OK) fail(settings[0]);
    warm(renderer, &frame);
}

/* What two eyes share, and what is drawn once for both. */
static void warm_eyes(fnl_renderer *renderer, const fnl_frame *base) {
    fnl_frame frame = *base;
    fnl_camera eyes[2] = {base->camera, base->camera};
    eyes[1].position.x += 0.06f;
    frame.views = eyes;
    frame.view_count = frame.stereo.eyes = 2;
    frame.occlusion = FNL_OCCLUSION_ON;
    warm(renderer, &frame);
    frame.occlusion = FNL_OCCLUSION_OFF;
    frame.stereo.path = FNL_STEREO_PATH_INSTANCES;
    warm(renderer, &frame); /* objects takes the same pipelines */
    frame.stereo.path = FNL_STEREO_PATH_AUTO;
    frame.stereo.mono_distance = 10;
    warm(renderer, &frame); /* nothing is made where it is refused */
}

/* Boxes, one on a mesh and one that draws an object again: shaders have features for them. */
static void add_decals(fnl_scene *scene) {
    fnl_entity_info first;
    fnl_decal_params params = fnl_decal_params_default();
    fnl_decal_id decal;
    params.kind = FNL_DECAL_MESH;
    if (fnl_scene_scatter_decals(scene, 8, 1) != FNL_OK || fnl_scene_query_entity(scene, FNL_ENTITY_INSTANCE, 0, &first) != FNL_OK) fail("no decals");
    params.instance = first.id.instance;
    if (fnl_scene_add_decal(scene, &params, &decal) != FNL_OK) fail("no mesh decal");
    params.kind = FNL_DECAL_REDRAW;
    if (fnl_scene_add_decal(scene, &params, &decal) != FNL_OK) fail("no redraw decal");
}

/* With `everything`: all lists with one sample, and all options. Without: the most common lists, and what goes with decals. */
static void warm_all(fnl_renderer *renderer, const fnl_scene *scene, bool everything) {
    static const uint32_t samples[] = {1, 4, 8};
    static const char *const with[][5] = {{"culling", "clusters", "geometry", "mesh"}, {"culling", "triangles", "geometry", "mesh"},
                                          {"culling", "clusters", "occlusion", "on"},  {"decals", "gbuffer"}, {"aa", "taa"},
                                          {"shadows", "rays", "shadow.ray-backend", "ray-query"},
                                          {"shadows", "sampled", "shadow.guide", "on"}};
    fnl_frame frame = frame_plain();
    frame.width = 320;
    frame.height = 180;
    frame.shadow.ray_backend = FNL_RAY_BACKEND_BVH;
    if (fnl_scene_query_framing_camera(scene, 16.0f / 9.0f, &frame.camera) != FNL_OK) fail("no camera");
    for (frame.shading = 0; frame.shading < FNL_SHADING_AUTO; frame.shading++)
        for (uint32_t s = 0; s < COUNT_OF(samples); s++) {
            frame.msaa = samples[s];
            for (frame.lists = 0; frame.lists < FNL_LISTS_AUTO; frame.lists++) {
                bool common = frame.lists == FNL_LISTS_CLUSTERED || frame.lists == FNL_LISTS_TILED || frame.lists == FNL_LISTS_FINE;
                if ((common || (s == 0 && everything)) && fnl_shading_supports(frame.shading, frame.lists, frame.msaa)) warm(renderer, &frame);
            }
            frame.lists = FNL_LISTS_CLUSTERED;
            for (size_t i = 0; s < 2 && i < COUNT_OF(with); i++) warm_with(renderer, &frame, with[i]);
            if (everything && s == 0) warm_eyes(renderer, &frame);
            if (s == 0 && frame.shading == FNL_SHADING_COARSE)
                for (int i = 0; i < 3; i++) warm_with(renderer, &frame, (const char *const[]){"coarse.fovea", "10", "shadows", (const char *const[]){"off", "maps", "rays"}[i], NULL});
            if (everything && s < 2) warm_options(renderer, &frame, 0, frame.shading == FNL_SHADING_MOBILE ? 2 : 1);
            if (!everything && frame.shading == FNL_SHADING_MOBILE) warm_options(renderer, &frame, 0, 2);
        }
}

/* A light of a shape that most scenes lack. */
static void add_capsule(fnl_scene *scene) {
    fnl_light_params light = fnl_light_params_default();
    fnl_light_id id;
    light.kind = FNL_LIGHT_CAPSULE;
    if (fnl_scene_add_light(scene, &light, &id) != FNL_OK) fail("no capsule");
}

static void warm_scene(fnl_device *device, const char *source, bool decals, bool shapes) {
    fnl_scene *scene = NULL;
    fnl_renderer *renderer = NULL;
    if (fnl_scene_load(NULL, source, NULL, &scene) != FNL_OK) fail(source);
    if (decals) add_decals(scene);
    if (shapes) add_capsule(scene);
    if (fnl_renderer_create(device, scene, &renderer) != FNL_OK) fail(source);
    for (int turn = 0; turn < 2; turn++) { /* all frames ask at once, so that the threads are busy; then what is missing is waited for */
        waits = turn;
        warm_all(renderer, scene, !decals && !shapes);
    }
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

/* Materials with layers, some of which one looks through. */
static void warm_layers(fnl_device *device) {
    static const fnl_shading shadings[] = {FNL_SHADING_FORWARD, FNL_SHADING_DEFERRED, FNL_SHADING_VISIBILITY};
    static const fnl_shadows shadows[] = {FNL_SHADOWS_OFF, FNL_SHADOWS_RAYS, FNL_SHADOWS_MAPS};
    fnl_scene *scene = NULL;
    fnl_renderer *renderer = NULL;
    fnl_frame frame = frame_plain();
    if (fnl_scene_load(NULL, "builtin:glass?lights=10", NULL, &scene) != FNL_OK) fail("glass");
    for (uint32_t i = 0; i < 3; i++) { /* one that a G-buffer holds, glass, and one that is lit forward after it */
        fnl_entity_info entity;
        fnl_material_params params;
        if (fnl_scene_query_entity(scene, FNL_ENTITY_MATERIAL, i, &entity) != FNL_OK || fnl_scene_query_material(scene, i, &params) != FNL_OK) fail("no materials");
        params.alpha_mode = FNL_ALPHA_OPAQUE;
        params.clearcoat.strength = 1;
        params.transmission.strength = i == 1;
        if (i == 2) params.sheen.color[0] = 0.5f;
        if (fnl_scene_set_material(scene, entity.id.material, &params) != FNL_OK) fail("no layers");
    }
    if (fnl_scene_query_framing_camera(scene, 16.0f / 9.0f, &frame.camera) != FNL_OK || fnl_renderer_create(device, scene, &renderer) != FNL_OK) fail("glass");
    frame.width = 320;
    frame.height = 180;
    frame.lists = FNL_LISTS_CLUSTERED;
    waits = true;
    for (uint32_t i = 0; i < COUNT_OF(shadings) * COUNT_OF(shadows) * 2; i++) {
        frame.shading = shadings[i % COUNT_OF(shadings)];
        frame.shadows = shadows[i / COUNT_OF(shadings) % COUNT_OF(shadows)];
        frame.msaa = i < COUNT_OF(shadings) * COUNT_OF(shadows) ? 1 : 4;
        warm(renderer, &frame);
    }
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

static int by_shader(const void *a, const void *b) {
    const struct row *x = a, *y = b;
    int order = strcmp(x->shader, y->shader);
    return order ? order : strcmp(x->constants, y->constants);
}

static void print_row(const struct row *row) {
    printf("%s,%u", row->shader, row->variants);
    for (size_t c = 0; c < COUNT_OF(columns); c++) printf(",%llu", (unsigned long long)row->values[c]);
    printf(",%s\n", row->constants);
}

/* The worst of each number; the constants are those of the program with the most instructions. */
static void merge(struct row *into, const struct row *row, uint64_t *most) {
    into->variants++;
    for (size_t c = 0; c < COUNT_OF(columns); c++) {
        bool worse = columns[c].less_is_worse ? row->values[c] < into->values[c] : row->values[c] > into->values[c];
        if (worse) into->values[c] = row->values[c];
    }
    if (row->values[INSTRUCTIONS] <= *most) return;
    *most = row->values[INSTRUCTIONS];
    memcpy(into->constants, row->constants, sizeof into->constants);
}

static void print_rows(bool all) {
    printf("shader,programs");
    for (size_t c = 0; c < COUNT_OF(columns); c++) printf(",%s", columns[c].column);
    printf(",constants\n");
    qsort(report.rows, report.row_count, sizeof *report.rows, by_shader);
    for (uint32_t i = 0, next; i < report.row_count; i = next) {
        struct row row = report.rows[i];
        uint64_t most = row.values[INSTRUCTIONS];
        row.variants = 1;
        for (next = i + 1; !all && next < report.row_count && strcmp(report.rows[next].shader, row.shader) == 0; next++)
            merge(&row, &report.rows[next], &most);
        print_row(&row);
    }
}

/* What no frame has. */
static void compress(fnl_device *device) {
    float pixel[4] = {1, 1, 1, 1};
    const fnl_image image = {1, 1, FNL_PIXEL_FORMAT_RGBA32F, pixel};
    for (int i = 0; i < 4; i++) {
        fnl_compress_params params = fnl_compress_params_default();
        params.device = device;
        params.quality = i & 1 ? FNL_COMPRESS_QUALITY : FNL_COMPRESS_FAST;
        params.is_signed = i & 2;
        if (fnl_image_compress(NULL, NULL, &image, &params, NULL) != FNL_OK) fail("fnl_image_compress");
    }
}

int main(int argc, char **argv) {
    bool all = false;
    for (int i = 1; i < argc; i++) {
        if (strcmp(argv[i], "--all") == 0) all = true;
        else if (strcmp(argv[i], "--only") == 0 && i + 1 < argc) report.only = argv[++i];
        else if (strcmp(argv[i], "--inputs") == 0) report.inputs_alone = true;
        else fail("usage: shader_report [--all] [--only TEXT] [--inputs]");
    }
    char name[800];
    fnl_device *device = open_device(name, sizeof name);
    warm_scene(device, "builtin:glass?lights=10", false, false);
    warm_scene(device, "builtin:glass?lights=10", false, true);
    warm_scene(device, "builtin:grass?lights=10", true, true);
    warm_layers(device);
    compress(device);
    fnl_device_destroy(&device);
    unsigned long long inputs = 0;
    for (uint32_t i = 0; i < report.input_count; i++) inputs += report.inputs[i];
    if (report.inputs_alone) return printf("# %s; inputs %016llx\n", name, inputs) < 0;
    printf("# %s; %u pipelines; inputs %016llx\n", name, report.pipeline_count, inputs);
    print_rows(all);
    if (report.refused_count) fail("the driver refused pipelines");
    return 0;
}
