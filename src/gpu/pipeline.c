/* SPDX-License-Identifier: MIT */
#include "gpu/gpu_internal.h"
#include "gpu/specialise.h"

#include <zstd.h>

fnl_result gpu_pipelines_init(gpu_device *device, const char *cache_folder) {
    return gpu_pipeline_cache_load(device, cache_folder);
}

/** The workers leave what is still in line; what they are at they have to finish. */
static void stop_workers(struct gpu_pipelines *pipelines) {
    pthread_mutex_lock(&pipelines->mutex);
    pipelines->stop = true;
    pthread_cond_broadcast(&pipelines->changed);
    pthread_mutex_unlock(&pipelines->mutex);
    for (; pipelines->worker_count; pipelines->worker_count--)
        pthread_join(pipelines->workers[pipelines->worker_count - 1].thread, NULL);
}

/* Culling is set by commands (gpu_bind): those that differ in it alone have one Vulkan pipeline, that of the entry which culls nothing. */
static bool is_culled(const struct gpu_pipeline *pipeline) {
    return pipeline->point == VK_PIPELINE_BIND_POINT_GRAPHICS && (pipeline->key.graphics.cull || pipeline->key.graphics.mirrored);
}

void gpu_pipelines_finish(gpu_device *device) {
    struct gpu_pipelines *pipelines = &device->pipelines;
    stop_workers(pipelines);
    gpu_pipeline_cache_save(device);
    for (uint32_t i = 0; i < pipelines->capacity; i++) {
        struct gpu_pipeline *pipeline = pipelines->table[i];
        if (!pipeline) continue;
        if (!is_culled(pipeline)) device->vk.DestroyPipeline(device->handle, pipeline->handle, NULL);
        host_free(&device->host, pipeline, sizeof *pipeline);
    }
    host_free(&device->host, pipelines->table, pipelines->capacity * sizeof *pipelines->table);
    device->vk.DestroyPipelineCache(device->handle, pipelines->cache, NULL);
    host_free(&device->host, pipelines->cache_path, pipelines->cache_path_size);
}

/* ---- the table ---- */

static size_t key_size(VkPipelineBindPoint point) {
    return point == VK_PIPELINE_BIND_POINT_COMPUTE ? sizeof(struct gpu_compute_params) : sizeof(struct gpu_graphics_params);
}

static struct gpu_pipeline *find_pipeline(struct gpu_pipelines *pipelines, VkPipelineBindPoint point, const void *key,
                                          uint64_t hash) {
    struct gpu_pipeline *found = NULL;
    pthread_rwlock_rdlock(&pipelines->lock);
    for (uint32_t i = (uint32_t)hash; pipelines->capacity; i++) {
        struct gpu_pipeline *pipeline = pipelines->table[i & (pipelines->capacity - 1)];
        if (!pipeline) break;
        if (pipeline->hash == hash && pipeline->point == point && memcmp(&pipeline->key, key, key_size(point)) == 0) {
            found = pipeline;
            break;
        }
    }
    pthread_rwlock_unlock(&pipelines->lock);
    return found;
}

static void put_pipeline(struct gpu_pipeline **table, uint32_t capacity, struct gpu_pipeline *pipeline) {
    uint32_t i = (uint32_t)pipeline->hash & (capacity - 1);
    while (table[i]) i = (i + 1) & (capacity - 1);
    table[i] = pipeline;
}

/** Makes room for one more at less than half full. The mutex is held: only readers are about. */
static bool grow_table(gpu_device *device) {
    struct gpu_pipelines *pipelines = &device->pipelines;
    if ((pipelines->count + 1) * 2 <= pipelines->capacity) return true;
    uint32_t capacity = MAX(64u, pipelines->capacity * 2);
    struct gpu_pipeline **table = host_allocate_zero(&device->host, capacity * sizeof *table);
    if (!table) return false;
    for (uint32_t i = 0; i < pipelines->capacity; i++) {
        if (pipelines->table[i]) put_pipeline(table, capacity, pipelines->table[i]);
    }
    pthread_rwlock_wrlock(&pipelines->lock);
    host_free(&device->host, pipelines->table, pipelines->capacity * sizeof *table);
    pipelines->table = table;
    pipelines->capacity = capacity;
    pthread_rwlock_unlock(&pipelines->lock);
    return true;
}

/* ---- creation ---- */

/* Modules are specialised before the driver sees them; it is told the constants too, for those who listen (tools/shader_report.c, capture tools). */
struct constants {
    uint32_t count;
    struct gpu_constant list[GPU_MAX_CONSTANTS + 1];
    VkSpecializationInfo info;
    VkSpecializationMapEntry entries[GPU_MAX_CONSTANTS + 1];
    uint32_t values[GPU_MAX_CONSTANTS + 1];
};

/* Features of 0 are what shaders have by themselves. */
static void describe_constants(uint32_t count, const uint32_t *values, uint32_t features, struct constants *out) {
    for (uint32_t i = 0; i < count; i++) out->list[i] = (struct gpu_constant){i, values[i]};
    if (features) out->list[count++] = (struct gpu_constant){GPU_FEATURES_ID, features};
    out->count = count;
    for (uint32_t i = 0; i < count; i++) {
        out->entries[i] = (VkSpecializationMapEntry){out->list[i].id, i * 4, 4};
        out->values[i] = out->list[i].value;
    }
    out->info = (VkSpecializationInfo){count, out->entries, count * 4, out->values};
}

uint32_t *gpu_shader_code(const fnl_host *host, const struct gpu_shader *shader) {
    uint32_t *words = host_allocate(host, shader->size);
    if (!words) return NULL;
    if (ZSTD_decompress(words, shader->size, shader->packed, shader->packed_size) == shader->size) return words;
    log_error(host, "%s: out of memory while it was decompressed", shader->name); /* what is embedded is whole */
    host_free(host, words, shader->size);
    return NULL;
}

static fnl_result create_module(gpu_device *device, const struct gpu_shader *shader, const struct constants *constants, VkShaderModule *out) {
    uint32_t *code = gpu_shader_code(&device->host, shader);
    if (!code) return FNL_ERROR_MEMORY;
    struct gpu_spirv spirv;
    fnl_result specialised = gpu_specialise(&device->host, code, shader->size / 4, constants->count, constants->list, &spirv);
    host_free(&device->host, code, shader->size);
    if (specialised != FNL_OK) {
        if (specialised == FNL_ERROR_INVALID) log_error(&device->host, "%s: what is embedded is not SPIR-V", shader->name);
        return specialised;
    }
    VkShaderModuleCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO,
        .codeSize = spirv.count * 4,
        .pCode = spirv.words,
    };
    VkResult result = device->vk.CreateShaderModule(device->handle, &info, NULL, out);
    host_free(&device->host, spirv.words, spirv.size);
    TRY(gpu_check(device, result, "%s: vkCreateShaderModule", shader->name));
    gpu_name(device, VK_OBJECT_TYPE_SHADER_MODULE, (uint64_t)*out, shader->name);
    return FNL_OK;
}

static VkPipelineShaderStageCreateInfo stage_info(VkShaderStageFlagBits stage, VkShaderModule module, const struct constants *constants) {
    return (VkPipelineShaderStageCreateInfo){
        .sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
        .stage = stage,
        .module = module,
        .pName = "main",
        .pSpecializationInfo = constants->count ? &constants->info : NULL,
    };
}

/** Asks the driver whether it found the pipeline in the cache. */
static VkPipelineCreationFeedbackCreateInfo feedback_info(VkPipelineCreationFeedback *feedback) {
    return (VkPipelineCreationFeedbackCreateInfo){.sType = VK_STRUCTURE_TYPE_PIPELINE_CREATION_FEEDBACK_CREATE_INFO,
                                                  .pPipelineCreationFeedback = feedback};
}

static bool was_cached(const VkPipelineCreationFeedback *feedback) {
    const VkPipelineCreationFeedbackFlags both =
        VK_PIPELINE_CREATION_FEEDBACK_VALID_BIT | VK_PIPELINE_CREATION_FEEDBACK_APPLICATION_PIPELINE_CACHE_HIT_BIT;
    return (feedback->flags & both) == both;
}

static fnl_result create_compute(gpu_device *device, const struct gpu_compute_params *params, VkPipeline *out,
                                 bool *out_cached) {
    struct constants constants;
    describe_constants(params->constant_count, params->constants, 0, &constants);
    VkShaderModule module;
    TRY(create_module(device, params->shader, &constants, &module));
    VkPipelineCreationFeedback feedback = {0};
    const VkPipelineCreationFeedbackCreateInfo wanted = feedback_info(&feedback);
    VkComputePipelineCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO,
        .pNext = &wanted,
        .stage = stage_info(VK_SHADER_STAGE_COMPUTE_BIT, module, &constants),
        .layout = device->bindless.layout,
    };
    VkResult result = device->vk.CreateComputePipelines(device->handle, device->pipelines.cache, 1, &info, NULL, out);
    device->vk.DestroyShaderModule(device->handle, module, NULL);
    TRY(gpu_check(device, result, "%s: vkCreateComputePipelines", params->shader->name));
    *out_cached = was_cached(&feedback);
    gpu_name(device, VK_OBJECT_TYPE_PIPELINE, (uint64_t)*out, params->shader->name);
    return FNL_OK;
}

static VkPipelineColorBlendAttachmentState blend_state(enum gpu_blend blend) {
    VkBlendFactor destination = blend == GPU_BLEND_ALPHA     ? VK_BLEND_FACTOR_ONE_MINUS_SRC_ALPHA
                                : blend == GPU_BLEND_QUARTER ? VK_BLEND_FACTOR_CONSTANT_COLOR
                                                             : VK_BLEND_FACTOR_ONE;
    VkBlendOp operation = blend == GPU_BLEND_MAX ? VK_BLEND_OP_MAX : VK_BLEND_OP_ADD;
    return (VkPipelineColorBlendAttachmentState){
        .blendEnable = blend != GPU_BLEND_NONE && blend != GPU_BLEND_KEEP,
        .srcColorBlendFactor = VK_BLEND_FACTOR_ONE,
        .dstColorBlendFactor = destination,
        .colorBlendOp = operation,
        .srcAlphaBlendFactor = VK_BLEND_FACTOR_ONE,
        .dstAlphaBlendFactor = destination,
        .alphaBlendOp = operation,
        .colorWriteMask = blend == GPU_BLEND_KEEP ? 0
                                                  : VK_COLOR_COMPONENT_R_BIT | VK_COLOR_COMPONENT_G_BIT |
                                                        VK_COLOR_COMPONENT_B_BIT | VK_COLOR_COMPONENT_A_BIT,
    };
}

static VkResult create_graphics_from(gpu_device *device, const struct gpu_graphics_params *params,
                                     const VkPipelineShaderStageCreateInfo *stages, uint32_t stage_count, VkPipeline *out,
                                     bool *out_cached) {
    VkPipelineVertexInputStateCreateInfo input = {.sType = VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO};
    VkPipelineInputAssemblyStateCreateInfo assembly = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO,
        .topology = params->topology,
    };
    VkPipelineViewportStateCreateInfo viewport = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO,
        .viewportCount = 1,
        .scissorCount = 1,
    };
    VkPipelineRasterizationConservativeStateCreateInfoEXT conservative = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_CONSERVATIVE_STATE_CREATE_INFO_EXT,
        .conservativeRasterizationMode = VK_CONSERVATIVE_RASTERIZATION_MODE_OVERESTIMATE_EXT,
    };
    VkPipelineRasterizationStateCreateInfo raster = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO,
        .pNext = params->conservative ? &conservative : NULL,
        .depthClampEnable = params->depth_clamp,
        .polygonMode = VK_POLYGON_MODE_FILL,
        .lineWidth = 1.0f,
    };
    VkPipelineMultisampleStateCreateInfo multisample = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO,
        .rasterizationSamples = (VkSampleCountFlagBits)params->samples,
    };
    VkStencilOpState stencil = {
        params->stencil.fail, params->stencil.pass,     VK_STENCIL_OP_KEEP, params->stencil.compare, UINT8_MAX,
        UINT8_MAX,          params->stencil.reference};
    VkPipelineDepthStencilStateCreateInfo depth = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO,
        .depthTestEnable = params->depth_test || params->depth_write, /* Vulkan writes only where it tests */
        .depthWriteEnable = params->depth_write,
        .depthCompareOp = params->depth_test ? params->depth_compare : VK_COMPARE_OP_ALWAYS,
        .stencilTestEnable = params->stencil.test,
        .front = stencil,
        .back = stencil,
    };
    VkPipelineColorBlendAttachmentState attachments[GPU_MAX_COLORS];
    for (uint32_t i = 0; i < params->color_count; i++) attachments[i] = blend_state(params->blends[i]);
    VkPipelineColorBlendStateCreateInfo blend = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO,
        .attachmentCount = params->color_count,
        .pAttachments = attachments,
        .blendConstants = {0.25f, 0.25f, 0.25f, 0.25f}, /* GPU_BLEND_QUARTER */
    };
    VkDynamicState dynamic_states[] = {VK_DYNAMIC_STATE_VIEWPORT, VK_DYNAMIC_STATE_SCISSOR, VK_DYNAMIC_STATE_CULL_MODE,
                                       VK_DYNAMIC_STATE_FRONT_FACE, VK_DYNAMIC_STATE_STENCIL_REFERENCE};
    bool reference_is_set = params->stencil.test && params->stencil.reference == GPU_STENCIL_SET;
    VkPipelineDynamicStateCreateInfo dynamic = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_DYNAMIC_STATE_CREATE_INFO,
        .dynamicStateCount = COUNT_OF(dynamic_states) - (reference_is_set ? 0 : 1),
        .pDynamicStates = dynamic_states,
    };
    VkPipelineRenderingCreateInfo rendering = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_RENDERING_CREATE_INFO,
        .viewMask = params->view_mask,
        .colorAttachmentCount = params->color_count,
        .pColorAttachmentFormats = params->color_formats,
        .depthAttachmentFormat = params->depth_format == VK_FORMAT_S8_UINT ? VK_FORMAT_UNDEFINED : params->depth_format,
        .stencilAttachmentFormat =
            params->depth_format == VK_FORMAT_S8_UINT || params->depth_format == VK_FORMAT_D32_SFLOAT_S8_UINT
                ? params->depth_format
                : VK_FORMAT_UNDEFINED,
    };
    VkPipelineCreationFeedback feedback = {0};
    VkPipelineCreationFeedbackCreateInfo wanted = feedback_info(&feedback);
    wanted.pNext = params->scope ? NULL : &rendering;
    VkGraphicsPipelineCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO,
        .pNext = &wanted,
        .stageCount = stage_count,
        .pStages = stages,
        .pVertexInputState = &input,
        .pInputAssemblyState = &assembly,
        .pViewportState = &viewport,
        .pRasterizationState = &raster,
        .pMultisampleState = &multisample,
        .pDepthStencilState = &depth,
        .pColorBlendState = &blend,
        .pDynamicState = &dynamic,
        .layout = device->bindless.layout,
    };
    if (params->scope) {
        info.layout = device->scopes.layout;
        info.renderPass = params->scope->handle;
        info.subpass = params->scope_step;
    }
    VkResult result = device->vk.CreateGraphicsPipelines(device->handle, device->pipelines.cache, 1, &info, NULL, out);
    *out_cached = was_cached(&feedback);
    return result;
}

static fnl_result create_graphics(gpu_device *device, const struct gpu_graphics_params *params, VkPipeline *out,
                                  bool *out_cached) {
    VkShaderModule first = VK_NULL_HANDLE, fragment = VK_NULL_HANDLE, geometry = VK_NULL_HANDLE;
    const struct gpu_shader *corners = params->mesh ? params->mesh : params->vertex;
    struct constants constants;
    describe_constants(params->constant_count, params->constants, params->features, &constants);
    const struct gpu_shader *const shaders[] = {corners, params->fragment, params->geometry};
    VkShaderModule *const modules[] = {&first, &fragment, &geometry};
    fnl_result result = FNL_OK;
    for (uint32_t i = 0; i < COUNT_OF(shaders) && result == FNL_OK; i++)
        if (shaders[i]) result = create_module(device, shaders[i], &constants, modules[i]);
    if (result == FNL_OK) {
        VkPipelineShaderStageCreateInfo stages[3] = {
            stage_info(params->mesh ? VK_SHADER_STAGE_MESH_BIT_EXT : VK_SHADER_STAGE_VERTEX_BIT, first, &constants)};
        uint32_t count = 1;
        if (params->geometry) stages[count++] = stage_info(VK_SHADER_STAGE_GEOMETRY_BIT, geometry, &constants);
        if (params->fragment) stages[count++] = stage_info(VK_SHADER_STAGE_FRAGMENT_BIT, fragment, &constants);
        VkResult vulkan = create_graphics_from(device, params, stages, count, out, out_cached);
        result = gpu_check(device, vulkan, "%s, %s: vkCreateGraphicsPipelines", corners->name,
                           params->fragment ? params->fragment->name : "no fragment shader");
    }
    device->vk.DestroyShaderModule(device->handle, first, NULL);
    device->vk.DestroyShaderModule(device->handle, fragment, NULL);
    device->vk.DestroyShaderModule(device->handle, geometry, NULL);
    if (result == FNL_OK)
        gpu_name(device, VK_OBJECT_TYPE_PIPELINE, (uint64_t)*out, (params->fragment ? params->fragment : corners)->name);
    return result;
}

static fnl_result check_compute(const fnl_host *host, const struct gpu_compute_params *params) {
    REQUIRE(host, params->shader != NULL);
    REQUIRE(host, params->constant_count <= GPU_MAX_CONSTANTS);
    return FNL_OK;
}

static fnl_result check_graphics(const gpu_device *device, const struct gpu_graphics_params *params) {
    const fnl_host *host = &device->host;
    REQUIRE(host, params->vertex != NULL || params->mesh != NULL);
    REQUIRE(host, !params->mesh || (device->info.mesh_shader && !params->vertex && !params->geometry));
    REQUIRE(host, params->constant_count <= GPU_MAX_CONSTANTS);
    REQUIRE(host, params->color_count <= GPU_MAX_COLORS);
    REQUIRE(host, !params->conservative || device->info.conservative_raster);
    REQUIRE(host, !params->geometry || device->info.primitive_ids);
    if (params->view_mask) {
        REQUIRE(host, device->info.max_views >= 32 || params->view_mask >> device->info.max_views == 0);
        REQUIRE(host, !params->geometry && !params->mesh && !params->scope); /* those need features of their own */
    }
    if (params->scope) {
        REQUIRE(host, params->scope_step < params->scope->params.step_count);
        REQUIRE(host, params->color_count == params->scope->params.steps[params->scope_step].color_count);
    }
    REQUIRE(host, params->samples == 1 || params->samples == 2 || params->samples == 4 || params->samples == 8);
    return FNL_OK;
}

/* ---- who makes them: the frame that needs one, or the workers those that were asked for ---- */

static fnl_result check_params(const gpu_device *device, VkPipelineBindPoint point, const void *key) {
    return point == VK_PIPELINE_BIND_POINT_COMPUTE ? check_compute(&device->host, key) : check_graphics(device, key);
}

/** The table's entry, new if need be; NULL when memory ran out. The mutex is held. */
static struct gpu_pipeline *enter_pipeline(gpu_device *device, VkPipelineBindPoint point, const void *key, uint64_t hash) {
    struct gpu_pipelines *pipelines = &device->pipelines;
    struct gpu_pipeline *pipeline = find_pipeline(pipelines, point, key, hash);
    if (pipeline) return pipeline;
    pipeline = grow_table(device) ? host_allocate_zero(&device->host, sizeof *pipeline) : NULL;
    if (!pipeline) return NULL;
    pipeline->point = point;
    pipeline->hash = hash;
    memcpy(&pipeline->key, key, key_size(point));
    pthread_rwlock_wrlock(&pipelines->lock);
    put_pipeline(pipelines->table, pipelines->capacity, pipeline);
    pipelines->count++;
    pthread_rwlock_unlock(&pipelines->lock);
    return pipeline;
}

/** The mutex is held, but not meanwhile: different pipelines are made at once, and a frame never waits for one that it does not need. */
static fnl_result create_pipeline(gpu_device *device, const struct gpu_pipeline *pipeline, VkPipeline *out) {
    struct gpu_pipelines *pipelines = &device->pipelines;
    pthread_mutex_unlock(&pipelines->mutex);
    bool cached = false;
    fnl_result result = pipeline->point == VK_PIPELINE_BIND_POINT_COMPUTE
                            ? create_compute(device, &pipeline->key.compute, out, &cached)
                            : create_graphics(device, &pipeline->key.graphics, out, &cached);
    pthread_mutex_lock(&pipelines->mutex);
    pipelines->stats.made += result == FNL_OK;
    pipelines->stats.cached += result == FNL_OK && cached;
    return result;
}

static fnl_result finish_pipeline(gpu_device *device, struct gpu_pipeline *pipeline);

/** Takes the one that culls nothing. The mutex is held. */
static fnl_result take_plain(gpu_device *device, const struct gpu_pipeline *pipeline, VkPipeline *out) {
    struct gpu_graphics_params key;
    memcpy(&key, &pipeline->key.graphics, sizeof key); /* padding is hashed too */
    key.cull = VK_CULL_MODE_NONE;
    key.mirrored = false;
    struct gpu_pipeline *plain = enter_pipeline(device, pipeline->point, &key, hash_bytes(&key, sizeof key, HASH_SEED));
    if (!plain) return FNL_ERROR_MEMORY;
    TRY(finish_pipeline(device, plain));
    *out = plain->handle;
    return FNL_OK;
}

/**
 * Makes an entry that nobody is making. The mutex is held, but not meanwhile. One that the driver refuses counts as made, so that it is not tried
 * each frame.
 */
static void make_pipeline(gpu_device *device, struct gpu_pipeline *pipeline) {
    struct gpu_pipelines *pipelines = &device->pipelines;
    atomic_store(&pipeline->state, GPU_PIPELINE_BEING_MADE);
    VkPipeline handle = VK_NULL_HANDLE;
    fnl_result result = is_culled(pipeline) ? take_plain(device, pipeline, &handle) : create_pipeline(device, pipeline, &handle);
    pipeline->handle = result == FNL_OK ? handle : VK_NULL_HANDLE;
    pipeline->result = result;
    bool may_go_better = result == FNL_ERROR_MEMORY || result == FNL_ERROR_DEVICE_LOST;
    atomic_store(&pipeline->state, may_go_better ? GPU_PIPELINE_NEW : GPU_PIPELINE_MADE);
    pthread_cond_broadcast(&pipelines->changed);
}

static void *work(void *argument) {
    struct gpu_pipeline_worker *worker = argument;
    gpu_device *device = worker->device, *stage = NULL;
    struct gpu_pipelines *pipelines = &device->pipelines;
    if (device->compiles_late) gpu_device_create_beside(device, &stage); /* without it the first use takes its time */
    pthread_mutex_lock(&pipelines->mutex);
    for (;;) {
        while (!pipelines->stop && !pipelines->first_asked) pthread_cond_wait(&pipelines->changed, &pipelines->mutex);
        if (pipelines->stop) break;
        struct gpu_pipeline *pipeline = pipelines->first_asked;
        pipelines->first_asked = pipeline->next_asked;
        if (!pipelines->first_asked) pipelines->last_asked = NULL;
        worker->at = pipeline->asked;
        pipelines->stats.done++;
        /* A frame that needed it may have been faster. */
        bool made = atomic_load(&pipeline->state) == GPU_PIPELINE_ASKED;
        if (made) {
            make_pipeline(device, pipeline);
            pipelines->stats.ahead++;
        }
        while (atomic_load(&pipeline->state) == GPU_PIPELINE_BEING_MADE)
            pthread_cond_wait(&pipelines->changed, &pipelines->mutex);
        if (stage && made && pipeline->handle && !pipelines->stop) {
            pthread_mutex_unlock(&pipelines->mutex);
            bool rehearsed = gpu_rehearse(stage, pipeline);
            pthread_mutex_lock(&pipelines->mutex);
            pipelines->stats.rehearsed += rehearsed;
        }
        worker->at = 0;
        pthread_cond_broadcast(&pipelines->changed);
    }
    pthread_mutex_unlock(&pipelines->mutex);
    fnl_device_destroy(&stage);
    return NULL;
}

/* As many as may be had; without any the frame makes what it needs. The mutex is held. */
static void start_workers(gpu_device *device) {
    struct gpu_pipelines *pipelines = &device->pipelines;
    uint32_t count = MIN(jobs_thread_count(device->jobs), (uint32_t)GPU_PIPELINE_WORKERS);
    while (pipelines->worker_count < MAX(count, 1u)) {
        struct gpu_pipeline_worker *worker = &pipelines->workers[pipelines->worker_count];
        *worker = (struct gpu_pipeline_worker){.device = device};
        if (pthread_create(&worker->thread, NULL, work, worker) != 0) return;
        pipelines->worker_count++;
    }
}

/** Puts an entry in line, unless it is there or further on already. The mutex is held. */
static void ask_pipeline(gpu_device *device, struct gpu_pipeline *pipeline) {
    struct gpu_pipelines *pipelines = &device->pipelines;
    int state = atomic_load(&pipeline->state);
    if (state == GPU_PIPELINE_MADE) return;
    pipelines->asking_missed = true;
    if (state != GPU_PIPELINE_NEW) return;
    if (!pipelines->worker_count) start_workers(device);
    if (!pipelines->worker_count) return; /* then the frame that needs it makes it */
    atomic_store(&pipeline->state, GPU_PIPELINE_ASKED);
    pipeline->next_asked = NULL;
    *(pipelines->last_asked ? &pipelines->last_asked->next_asked : &pipelines->first_asked) = pipeline;
    pipelines->last_asked = pipeline;
    pipeline->asked = ++pipelines->stats.asked;
    pthread_cond_broadcast(&pipelines->changed);
}

/** The entry is made when this returns, by whoever. The mutex is held. */
static fnl_result finish_pipeline(gpu_device *device, struct gpu_pipeline *pipeline) {
    struct gpu_pipelines *pipelines = &device->pipelines;
    while (atomic_load(&pipeline->state) == GPU_PIPELINE_BEING_MADE)
        pthread_cond_wait(&pipelines->changed, &pipelines->mutex);
    if (atomic_load(&pipeline->state) != GPU_PIPELINE_MADE) make_pipeline(device, pipeline);
    return pipeline->result;
}

static const struct gpu_pipeline *get_pipeline(gpu_device *device, VkPipelineBindPoint point, const void *key) {
    struct gpu_pipelines *pipelines = &device->pipelines;
    uint64_t hash = hash_bytes(key, key_size(point), HASH_SEED);
    struct gpu_pipeline *pipeline = find_pipeline(pipelines, point, key, hash);
    fnl_result result = FNL_OK;
    if (!pipeline || atomic_load(&pipeline->state) != GPU_PIPELINE_MADE) {
        result = check_params(device, point, key);
        pthread_mutex_lock(&pipelines->mutex);
        if (result == FNL_OK && !(pipeline = enter_pipeline(device, point, key, hash))) result = FNL_ERROR_MEMORY;
        if (result == FNL_OK && pipelines->asking)
            ask_pipeline(device, pipeline);
        else if (result == FNL_OK) {
            pipelines->stats.late += atomic_load(&pipeline->state) != GPU_PIPELINE_MADE;
            result = finish_pipeline(device, pipeline);
        }
        pthread_mutex_unlock(&pipelines->mutex);
    } else {
        result = pipeline->result;
    }
    if (pipelines->asking) return NULL; /* what goes wrong is for the frame that draws with it to tell */
    gpu_fail(device, result);
    return result == FNL_OK ? pipeline : NULL;
}

const struct gpu_pipeline *gpu_compute_pipeline(gpu_device *device, const struct gpu_compute_params *params) {
    return get_pipeline(device, VK_PIPELINE_BIND_POINT_COMPUTE, params);
}

const struct gpu_pipeline *gpu_graphics_pipeline(gpu_device *device, const struct gpu_graphics_params *params) {
    return get_pipeline(device, VK_PIPELINE_BIND_POINT_GRAPHICS, params);
}

struct gpu_commands *gpu_ask_begin(gpu_device *device) {
    device->pipelines.asking = true;
    device->pipelines.asking_missed = false;
    return &device->dead_commands;
}

uint64_t gpu_ask_end(gpu_device *device) {
    struct gpu_pipelines *pipelines = &device->pipelines;
    pipelines->asking = false;
    return pipelines->asking_missed ? gpu_pipeline_stats(device).asked : 0;
}

/* Of those taken from the line all but what workers are at, and what was taken after it. The mutex is held. */
static uint64_t count_done(const struct gpu_pipelines *pipelines) {
    uint64_t done = pipelines->stats.done;
    for (uint32_t i = 0; i < pipelines->worker_count; i++)
        if (pipelines->workers[i].at) done = MIN(done, pipelines->workers[i].at - 1);
    return done;
}

void gpu_ask_wait(gpu_device *device, uint64_t ticket) {
    struct gpu_pipelines *pipelines = &device->pipelines;
    pthread_mutex_lock(&pipelines->mutex);
    while (count_done(pipelines) < MIN(ticket, pipelines->stats.asked))
        pthread_cond_wait(&pipelines->changed, &pipelines->mutex);
    pthread_mutex_unlock(&pipelines->mutex);
}

struct gpu_pipeline_stats gpu_pipeline_stats(gpu_device *device) {
    pthread_mutex_lock(&device->pipelines.mutex);
    struct gpu_pipeline_stats stats = device->pipelines.stats;
    stats.done = count_done(&device->pipelines);
    pthread_mutex_unlock(&device->pipelines.mutex);
    return stats;
}
