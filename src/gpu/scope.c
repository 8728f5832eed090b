/* SPDX-License-Identifier: MIT */
/**
 * Scopes are render passes. (VK_KHR_dynamic_rendering_local_read says the same in other words, but it is younger than the headers and the
 * validation layers of the distributions that Fanal runs on, and many a tile-based GPU's driver; subpasses are in all of them.)
 * Framebuffers are imageless, so they outlive images and depend on sizes alone.
 */
#include "gpu/gpu_internal.h"

static const VkPipelineStageFlags all_stages =
    VK_PIPELINE_STAGE_FRAGMENT_SHADER_BIT | VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT |
    VK_PIPELINE_STAGE_EARLY_FRAGMENT_TESTS_BIT | VK_PIPELINE_STAGE_LATE_FRAGMENT_TESTS_BIT;
static const VkAccessFlags all_writes =
    VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT | VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT | VK_ACCESS_SHADER_WRITE_BIT;
static const VkAccessFlags all_accesses =
    VK_ACCESS_COLOR_ATTACHMENT_READ_BIT | VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT |
    VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_READ_BIT | VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT |
    VK_ACCESS_INPUT_ATTACHMENT_READ_BIT | VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_SHADER_WRITE_BIT;

/* ---- what all scopes share: the layout of pipelines, and descriptor sets that live for a frame ---- */

bool gpu_scope_supports(const gpu_device *device, uint32_t color_count, uint32_t input_count) {
    const VkPhysicalDeviceLimits *limits = &device->properties.limits;
    return color_count <= MIN(limits->maxColorAttachments, (uint32_t)GPU_MAX_COLORS) &&
           color_count <= limits->maxFragmentOutputAttachments && input_count <= device->scopes.input_count;
}

static fnl_result create_layouts(gpu_device *device) {
    struct gpu_scopes *scopes = &device->scopes;
    VkDescriptorSetLayoutBinding bindings[GPU_MAX_INPUTS];
    for (uint32_t i = 0; i < scopes->input_count; i++)
        bindings[i] =
            (VkDescriptorSetLayoutBinding){i, VK_DESCRIPTOR_TYPE_INPUT_ATTACHMENT, 1, VK_SHADER_STAGE_FRAGMENT_BIT, NULL};
    VkDescriptorSetLayoutCreateInfo set_layout = {
        .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO,
        .bindingCount = scopes->input_count,
        .pBindings = bindings,
    };
    TRY(gpu_check(device, device->vk.CreateDescriptorSetLayout(device->handle, &set_layout, NULL, &scopes->set_layout),
                  "vkCreateDescriptorSetLayout"));
    VkPushConstantRange push = {VK_SHADER_STAGE_ALL, 0, GPU_PUSH_BYTES};
    const VkDescriptorSetLayout layouts[] = {device->bindless.set_layout, scopes->set_layout};
    VkPipelineLayoutCreateInfo layout = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
        .setLayoutCount = COUNT_OF(layouts),
        .pSetLayouts = layouts,
        .pushConstantRangeCount = 1,
        .pPushConstantRanges = &push,
    };
    return gpu_check(device, device->vk.CreatePipelineLayout(device->handle, &layout, NULL, &scopes->layout),
                     "vkCreatePipelineLayout");
}

fnl_result gpu_scopes_init(gpu_device *device) {
    const VkPhysicalDeviceLimits *limits = &device->properties.limits;
    device->scopes.input_count =
        MIN(MIN(limits->maxPerStageDescriptorInputAttachments, limits->maxDescriptorSetInputAttachments),
            (uint32_t)GPU_MAX_INPUTS);
    return create_layouts(device);
}

/** All sets of a slot, on the first frame that has a scope. */
static fnl_result create_sets(gpu_device *device, uint32_t slot) {
    struct gpu_scopes *scopes = &device->scopes;
    VkDescriptorPoolSize size = {VK_DESCRIPTOR_TYPE_INPUT_ATTACHMENT, GPU_SCOPE_SETS * scopes->input_count};
    VkDescriptorPoolCreateInfo pool = {
        .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO,
        .maxSets = GPU_SCOPE_SETS,
        .poolSizeCount = 1,
        .pPoolSizes = &size,
    };
    TRY(gpu_check(device, device->vk.CreateDescriptorPool(device->handle, &pool, NULL, &scopes->pools[slot]),
                  "vkCreateDescriptorPool"));
    VkDescriptorSetLayout layouts[GPU_SCOPE_SETS];
    for (uint32_t i = 0; i < GPU_SCOPE_SETS; i++) layouts[i] = scopes->set_layout;
    VkDescriptorSetAllocateInfo sets = {
        .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO,
        .descriptorPool = scopes->pools[slot],
        .descriptorSetCount = GPU_SCOPE_SETS,
        .pSetLayouts = layouts,
    };
    return gpu_check(device, device->vk.AllocateDescriptorSets(device->handle, &sets, scopes->sets[slot]),
                     "vkAllocateDescriptorSets");
}

void gpu_scopes_begin_frame(gpu_device *device, uint32_t slot) { device->scopes.used[slot] = 0; }

void gpu_scopes_finish(gpu_device *device) {
    struct gpu_scopes *scopes = &device->scopes;
    for (uint32_t i = 0; i < scopes->items.count; i++) {
        struct gpu_scope *scope = scopes->items.data[i];
        for (uint32_t k = 0; k < GPU_SCOPE_FRAMEBUFFERS; k++)
            device->vk.DestroyFramebuffer(device->handle, scope->framebuffers[k].handle, NULL);
        device->vk.DestroyRenderPass(device->handle, scope->handle, NULL);
        host_free(&device->host, scope, sizeof *scope);
    }
    array_free(&device->host, &scopes->items);
    for (uint32_t i = 0; i < GPU_FRAMES_IN_FLIGHT; i++)
        device->vk.DestroyDescriptorPool(device->handle, scopes->pools[i], NULL);
    device->vk.DestroyPipelineLayout(device->handle, scopes->layout, NULL);
    device->vk.DestroyDescriptorSetLayout(device->handle, scopes->set_layout, NULL);
}

/* ---- render passes ---- */

static bool is_color_of(const struct gpu_scope_step *step, uint32_t attachment) {
    for (uint32_t i = 0; i < step->color_count; i++)
        if (step->colors[i] == attachment) return true;
    return false;
}

static bool is_input_of(const struct gpu_scope_step *step, uint32_t attachment) {
    for (uint32_t i = 0; i < step->input_count; i++)
        if (step->inputs[i] == attachment) return true;
    return false;
}

static bool uses(const struct gpu_scope_step *step, uint32_t attachment) {
    return is_color_of(step, attachment) || is_input_of(step, attachment) || step->depth == attachment;
}

static bool feeds_back(const struct gpu_scope_step *step) {
    for (uint32_t i = 0; i < step->input_count; i++)
        if (step->inputs[i] != GPU_NO_INDEX && is_color_of(step, step->inputs[i])) return true;
    return false;
}

/** A render pass's description; must not be moved. */
struct pass_info {
    VkAttachmentDescription2 attachments[GPU_MAX_SCOPE_ATTACHMENTS];
    VkSubpassDescription2 subpasses[GPU_MAX_SCOPE_STEPS];
    VkAttachmentReference2 colors[GPU_MAX_SCOPE_STEPS][GPU_MAX_COLORS], inputs[GPU_MAX_SCOPE_STEPS][GPU_MAX_INPUTS];
    VkAttachmentReference2 depths[GPU_MAX_SCOPE_STEPS];
    uint32_t preserved[GPU_MAX_SCOPE_STEPS][GPU_MAX_SCOPE_ATTACHMENTS];
    VkSubpassDependency2 dependencies[GPU_MAX_SCOPE_STEPS * (GPU_MAX_SCOPE_STEPS + 5) / 2];
    uint32_t dependency_count;
};

static VkAttachmentReference2 reference(uint32_t attachment, VkImageLayout layout, VkImageAspectFlags aspect) {
    return (VkAttachmentReference2){.sType = VK_STRUCTURE_TYPE_ATTACHMENT_REFERENCE_2,
                                    .attachment = attachment == GPU_NO_INDEX ? VK_ATTACHMENT_UNUSED : attachment,
                                    .layout = attachment == GPU_NO_INDEX ? VK_IMAGE_LAYOUT_UNDEFINED : layout,
                                    .aspectMask = aspect};
}

static void add_dependency(struct pass_info *info, uint32_t from, uint32_t to) {
    bool outside = from == VK_SUBPASS_EXTERNAL || to == VK_SUBPASS_EXTERNAL;
    info->dependencies[info->dependency_count++] =
        (VkSubpassDependency2){.sType = VK_STRUCTURE_TYPE_SUBPASS_DEPENDENCY_2,
                               .srcSubpass = from,
                               .dstSubpass = to,
                               .srcStageMask = all_stages,
                               .dstStageMask = all_stages,
                               .srcAccessMask = all_writes,
                               .dstAccessMask = all_accesses,
                               .dependencyFlags = outside ? 0 : VK_DEPENDENCY_BY_REGION_BIT};
}

static void describe_step(struct pass_info *info, const struct gpu_scope_params *params, uint32_t index) {
    const struct gpu_scope_step *step = &params->steps[index];
    VkSubpassDescription2 *subpass = &info->subpasses[index];
    *subpass = (VkSubpassDescription2){.sType = VK_STRUCTURE_TYPE_SUBPASS_DESCRIPTION_2,
                                       .pipelineBindPoint = VK_PIPELINE_BIND_POINT_GRAPHICS,
                                       .inputAttachmentCount = step->input_count,
                                       .pInputAttachments = info->inputs[index],
                                       .colorAttachmentCount = step->color_count,
                                       .pColorAttachments = info->colors[index],
                                       .pPreserveAttachments = info->preserved[index]};
    for (uint32_t i = 0; i < step->color_count; i++)
        info->colors[index][i] = reference(
            step->colors[i],
            is_input_of(step, step->colors[i]) ? VK_IMAGE_LAYOUT_GENERAL : VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL, 0);
    for (uint32_t i = 0; i < step->input_count; i++)
        info->inputs[index][i] = reference(step->inputs[i],
                                           is_color_of(step, step->inputs[i]) ? VK_IMAGE_LAYOUT_GENERAL
                                                                              : VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL,
                                           VK_IMAGE_ASPECT_COLOR_BIT);
    if (step->depth != GPU_NO_INDEX) {
        info->depths[index] = reference(
            step->depth,
            step->depth_read_only ? VK_IMAGE_LAYOUT_DEPTH_READ_ONLY_OPTIMAL : VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL, 0);
        subpass->pDepthStencilAttachment = &info->depths[index];
    }
    for (uint32_t i = 0; i < params->attachment_count; i++) {
        bool before = false, after = params->attachments[i].store == VK_ATTACHMENT_STORE_OP_STORE;
        for (uint32_t k = 0; k < params->step_count; k++) {
            if (k < index) before |= uses(&params->steps[k], i);
            if (k > index) after |= uses(&params->steps[k], i);
        }
        if (before && after && !uses(step, i)) info->preserved[index][subpass->preserveAttachmentCount++] = i;
    }
}

static void describe_pass(const struct gpu_scope_params *params, struct pass_info *info) {
    for (uint32_t i = 0; i < params->attachment_count; i++) {
        bool depth = gpu_format_aspect(params->attachments[i].format) & VK_IMAGE_ASPECT_DEPTH_BIT;
        VkImageLayout layout = depth ? VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL : VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL;
        info->attachments[i] = (VkAttachmentDescription2){.sType = VK_STRUCTURE_TYPE_ATTACHMENT_DESCRIPTION_2,
                                                          .format = params->attachments[i].format,
                                                          .samples = VK_SAMPLE_COUNT_1_BIT,
                                                          .loadOp = params->attachments[i].load,
                                                          .storeOp = params->attachments[i].store,
                                                          .stencilLoadOp = VK_ATTACHMENT_LOAD_OP_DONT_CARE,
                                                          .stencilStoreOp = VK_ATTACHMENT_STORE_OP_DONT_CARE,
                                                          .initialLayout = layout,
                                                          .finalLayout = layout};
    }
    info->dependency_count = 0;
    for (uint32_t i = 0; i < params->step_count; i++) {
        describe_step(info, params, i);
        add_dependency(info, VK_SUBPASS_EXTERNAL, i);
        for (uint32_t k = 0; k < i; k++) add_dependency(info, k, i);
        if (feeds_back(&params->steps[i])) add_dependency(info, i, i);
        add_dependency(info, i, VK_SUBPASS_EXTERNAL);
    }
}

static fnl_result check_params(const gpu_device *device, const struct gpu_scope_params *params) {
    const fnl_host *host = &device->host;
    REQUIRE(host, params->attachment_count <= GPU_MAX_SCOPE_ATTACHMENTS);
    REQUIRE(host, params->step_count >= 1 && params->step_count <= GPU_MAX_SCOPE_STEPS);
    for (uint32_t i = 0; i < params->step_count; i++) {
        const struct gpu_scope_step *step = &params->steps[i];
        REQUIRE(host, gpu_scope_supports(device, step->color_count, step->input_count));
        REQUIRE(host, step->depth == GPU_NO_INDEX || step->depth < params->attachment_count);
        for (uint32_t k = 0; k < step->color_count; k++) REQUIRE(host, step->colors[k] < params->attachment_count);
        for (uint32_t k = 0; k < step->input_count; k++)
            REQUIRE(host, step->inputs[k] == GPU_NO_INDEX || step->inputs[k] < params->attachment_count);
    }
    return FNL_OK;
}

static fnl_result create_scope(gpu_device *device, struct gpu_scope *scope) {
    TRY(check_params(device, &scope->params));
    struct pass_info info;
    describe_pass(&scope->params, &info);
    VkRenderPassCreateInfo2 create = {.sType = VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO_2,
                                      .attachmentCount = scope->params.attachment_count,
                                      .pAttachments = info.attachments,
                                      .subpassCount = scope->params.step_count,
                                      .pSubpasses = info.subpasses,
                                      .dependencyCount = info.dependency_count,
                                      .pDependencies = info.dependencies};
    return gpu_check(device, device->vk.CreateRenderPass2(device->handle, &create, NULL, &scope->handle),
                     "vkCreateRenderPass2");
}

static struct gpu_scope *find_or_create(gpu_device *device, const struct gpu_scope_params *params) {
    struct gpu_scopes *scopes = &device->scopes;
    uint64_t hash = hash_bytes(params, sizeof *params, HASH_SEED);
    for (uint32_t i = 0; i < scopes->items.count; i++)
        if (scopes->items.data[i]->hash == hash && memcmp(&scopes->items.data[i]->params, params, sizeof *params) == 0)
            return scopes->items.data[i];
    struct gpu_scope *scope = host_allocate_zero(&device->host, sizeof *scope);
    if (!scope || !array_push(&device->host, &scopes->items, scope)) {
        if (scope) host_free(&device->host, scope, sizeof *scope);
        gpu_fail(device, FNL_ERROR_MEMORY);
        return NULL;
    }
    scope->params = *params;
    scope->hash = hash;
    scope->result = create_scope(device, scope);
    return scope;
}

const struct gpu_scope *gpu_scope_find(gpu_device *device, const struct gpu_scope_params *params) {
    pthread_mutex_lock(&device->scopes.mutex);
    struct gpu_scope *scope = find_or_create(device, params);
    pthread_mutex_unlock(&device->scopes.mutex);
    if (!scope) return NULL;
    if (!scope->handle) {
        gpu_fail(device, scope->result != FNL_OK ? scope->result : FNL_ERROR_DEVICE);
        return NULL;
    }
    return scope;
}

/* ---- framebuffers ---- */

static fnl_result create_framebuffer(gpu_device *device, const struct gpu_scope *scope,
                                     struct gpu_framebuffer *framebuffer) {
    VkFramebufferAttachmentImageInfo images[GPU_MAX_SCOPE_ATTACHMENTS];
    uint32_t count = scope->params.attachment_count;
    for (uint32_t i = 0; i < count; i++)
        images[i] = (VkFramebufferAttachmentImageInfo){.sType = VK_STRUCTURE_TYPE_FRAMEBUFFER_ATTACHMENT_IMAGE_INFO,
                                                       .usage = framebuffer->usages[i],
                                                       .width = framebuffer->width,
                                                       .height = framebuffer->height,
                                                       .layerCount = framebuffer->layers,
                                                       .viewFormatCount = 1,
                                                       .pViewFormats = &scope->params.attachments[i].format};
    VkFramebufferAttachmentsCreateInfo attachments = {.sType = VK_STRUCTURE_TYPE_FRAMEBUFFER_ATTACHMENTS_CREATE_INFO,
                                                      .attachmentImageInfoCount = count,
                                                      .pAttachmentImageInfos = images};
    VkFramebufferCreateInfo info = {.sType = VK_STRUCTURE_TYPE_FRAMEBUFFER_CREATE_INFO,
                                    .pNext = &attachments,
                                    .flags = VK_FRAMEBUFFER_CREATE_IMAGELESS_BIT,
                                    .renderPass = scope->handle,
                                    .attachmentCount = count,
                                    .width = framebuffer->width,
                                    .height = framebuffer->height,
                                    .layers = framebuffer->layers};
    if (!gpu_retire_reserve(device)) return FNL_ERROR_MEMORY;
    VkResult result = device->vk.CreateFramebuffer(device->handle, &info, NULL, &framebuffer->handle);
    if (result == VK_SUCCESS) return FNL_OK;
    framebuffer->handle = VK_NULL_HANDLE;
    gpu_retire_cancel(device);
    return gpu_check(device, result, "vkCreateFramebuffer");
}

/* Of the sizes that a scope is drawn at the last few are kept. */
static VkFramebuffer find_framebuffer(gpu_device *device, struct gpu_scope *scope, const struct gpu_image *const *images) {
    struct gpu_framebuffer wanted = {
        .width = images[0]->params.width, .height = images[0]->params.height, .layers = images[0]->params.layers};
    for (uint32_t i = 0; i < scope->params.attachment_count; i++) wanted.usages[i] = gpu_view_usage(images[i]->params.usage);
    struct gpu_framebuffer *oldest = &scope->framebuffers[0];
    wanted.last_use = ++device->scopes.uses;
    for (uint32_t i = 0; i < GPU_SCOPE_FRAMEBUFFERS; i++) {
        struct gpu_framebuffer *known = &scope->framebuffers[i];
        if (known->handle && known->width == wanted.width && known->height == wanted.height &&
            known->layers == wanted.layers && memcmp(known->usages, wanted.usages, sizeof wanted.usages) == 0) {
            known->last_use = wanted.last_use;
            return known->handle;
        }
        if (known->last_use < oldest->last_use) oldest = known;
    }
    fnl_result result = create_framebuffer(device, scope, &wanted);
    if (result != FNL_OK) {
        gpu_fail(device, result);
        return VK_NULL_HANDLE;
    }
    if (oldest->handle)
        gpu_retire(device, &(struct gpu_retired){.framebuffer = oldest->handle,
                                                 .sampled_index = GPU_NO_INDEX,
                                                 .storage_index = GPU_NO_INDEX,
                                                 .srgb_index = GPU_NO_INDEX});
    *oldest = wanted;
    return wanted.handle;
}

/* ---- recording ---- */

static VkDescriptorSet take_set(gpu_device *device, uint32_t slot) {
    struct gpu_scopes *scopes = &device->scopes;
    fnl_result result = FNL_OK;
    VkDescriptorSet set = VK_NULL_HANDLE;
    pthread_mutex_lock(&scopes->mutex);
    if (!scopes->pools[slot]) result = create_sets(device, slot);
    if (result == FNL_OK && scopes->used[slot] < GPU_SCOPE_SETS)
        set = scopes->sets[slot][scopes->used[slot]++];
    else if (result == FNL_OK) {
        log_error(&device->host, "more than %d steps of scopes in a frame", GPU_SCOPE_SETS);
        result = FNL_ERROR_INVALID;
    }
    pthread_mutex_unlock(&scopes->mutex);
    gpu_fail(device, result);
    return set;
}

/* Both sets are bound again: a set of inputs is for one step only. */
static void bind_inputs(struct gpu_commands *commands) {
    gpu_device *device = commands->device;
    const struct gpu_scope_step *step = &commands->scope->params.steps[commands->scope_step];
    VkDescriptorSet sets[] = {device->bindless.set, VK_NULL_HANDLE};
    if (step->input_count) {
        sets[1] = take_set(device, commands->slot);
        if (!sets[1]) {
            commands->scope_skipped = true;
            return;
        }
        VkDescriptorImageInfo images[GPU_MAX_INPUTS];
        VkWriteDescriptorSet writes[GPU_MAX_INPUTS];
        uint32_t count = 0;
        for (uint32_t i = 0; i < step->input_count; i++) {
            if (step->inputs[i] == GPU_NO_INDEX) continue;
            images[i] = (VkDescriptorImageInfo){.imageView = commands->scope_views[step->inputs[i]],
                                                .imageLayout = is_color_of(step, step->inputs[i])
                                                                   ? VK_IMAGE_LAYOUT_GENERAL
                                                                   : VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
            writes[count++] = (VkWriteDescriptorSet){.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                                     .dstSet = sets[1],
                                                     .dstBinding = i,
                                                     .descriptorCount = 1,
                                                     .descriptorType = VK_DESCRIPTOR_TYPE_INPUT_ATTACHMENT,
                                                     .pImageInfo = &images[i]};
        }
        device->vk.UpdateDescriptorSets(device->handle, count, writes, 0, NULL);
    }
    device->vk.CmdBindDescriptorSets(commands->handle, VK_PIPELINE_BIND_POINT_GRAPHICS, device->scopes.layout, 0,
                                     sets[1] ? 2 : 1, sets, 0, NULL);
    commands->set_bound[VK_PIPELINE_BIND_POINT_GRAPHICS] = true;
}

void gpu_begin_scope(struct gpu_commands *commands, const struct gpu_scope *scope, const struct gpu_image *const *images,
                     const VkClearValue *clears) {
    if (!commands->handle) return;
    gpu_device *device = commands->device;
    VkFramebuffer framebuffer = VK_NULL_HANDLE;
    commands->scope = NULL;
    if (scope) {
        struct gpu_scope *own = (struct gpu_scope *)(uintptr_t)scope; /* const to the caller */
        pthread_mutex_lock(&device->scopes.mutex);
        framebuffer = find_framebuffer(device, own, images);
        pthread_mutex_unlock(&device->scopes.mutex);
    }
    commands->scope_skipped = !framebuffer;
    if (!framebuffer) return;
    commands->scope = scope;
    commands->scope_step = 0;
    uint32_t count = scope->params.attachment_count;
    for (uint32_t i = 0; i < count; i++) commands->scope_views[i] = images[i]->attachment_view;
    VkRect2D area = {{0, 0}, {images[0]->params.width, images[0]->params.height}};
    VkRenderPassAttachmentBeginInfo attachments = {.sType = VK_STRUCTURE_TYPE_RENDER_PASS_ATTACHMENT_BEGIN_INFO,
                                                   .attachmentCount = count,
                                                   .pAttachments = commands->scope_views};
    VkRenderPassBeginInfo info = {.sType = VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO,
                                  .pNext = &attachments,
                                  .renderPass = scope->handle,
                                  .framebuffer = framebuffer,
                                  .renderArea = area,
                                  .clearValueCount = count,
                                  .pClearValues = clears};
    VkSubpassBeginInfo contents = {.sType = VK_STRUCTURE_TYPE_SUBPASS_BEGIN_INFO, .contents = VK_SUBPASS_CONTENTS_INLINE};
    device->vk.CmdBeginRenderPass2(commands->handle, &info, &contents);
    VkViewport viewport = {0, (float)area.extent.height, (float)area.extent.width, -(float)area.extent.height, 0, 1};
    device->vk.CmdSetViewport(commands->handle, 0, 1, &viewport);
    device->vk.CmdSetScissor(commands->handle, 0, 1, &area);
    bind_inputs(commands);
}

void gpu_next_step(struct gpu_commands *commands) {
    if (!commands->handle || !commands->scope) return;
    commands->scope_step++;
    VkSubpassBeginInfo begin = {.sType = VK_STRUCTURE_TYPE_SUBPASS_BEGIN_INFO, .contents = VK_SUBPASS_CONTENTS_INLINE};
    VkSubpassEndInfo end = {.sType = VK_STRUCTURE_TYPE_SUBPASS_END_INFO};
    commands->device->vk.CmdNextSubpass2(commands->handle, &begin, &end);
    bind_inputs(commands);
}

void gpu_scope_barrier(struct gpu_commands *commands) {
    if (!commands->handle || !commands->scope || !feeds_back(&commands->scope->params.steps[commands->scope_step])) return;
    VkMemoryBarrier2 memory = {.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER_2,
                               .srcStageMask = VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT,
                               .srcAccessMask = VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT,
                               .dstStageMask = VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT,
                               .dstAccessMask = VK_ACCESS_2_INPUT_ATTACHMENT_READ_BIT};
    VkDependencyInfo info = {.sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO,
                             .dependencyFlags = VK_DEPENDENCY_BY_REGION_BIT,
                             .memoryBarrierCount = 1,
                             .pMemoryBarriers = &memory};
    commands->device->vk.CmdPipelineBarrier2(commands->handle, &info);
}

void gpu_end_scope(struct gpu_commands *commands) {
    if (!commands->handle) return;
    if (commands->scope) {
        VkSubpassEndInfo end = {.sType = VK_STRUCTURE_TYPE_SUBPASS_END_INFO};
        commands->device->vk.CmdEndRenderPass2(commands->handle, &end);
    }
    commands->scope = NULL;
    commands->scope_skipped = false;
    commands->pipeline = NULL; /* it was made for one step */
}
