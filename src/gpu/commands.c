/* SPDX-License-Identifier: MIT */
#include "gpu/gpu_internal.h"

/* ---- command buffers ---- */

fnl_result gpu_command_pool_init(gpu_device *device, struct gpu_command_pool *pool, enum gpu_queue queue) {
    VkCommandPoolCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
        .flags = VK_COMMAND_POOL_CREATE_TRANSIENT_BIT,
        .queueFamilyIndex = device->queues[queue].family,
    };
    return gpu_check(device, device->vk.CreateCommandPool(device->handle, &info, NULL, &pool->handle),
                     "vkCreateCommandPool");
}

void gpu_command_pool_finish(gpu_device *device, struct gpu_command_pool *pool) {
    device->vk.DestroyCommandPool(device->handle, pool->handle, NULL);
    for (uint32_t i = 0; i < pool->buffers.count; i++)
        host_free(&device->host, pool->buffers.data[i], sizeof(struct gpu_commands));
    array_free(&device->host, &pool->buffers);
    *pool = (struct gpu_command_pool){0};
}

static fnl_result add_buffer(gpu_device *device, struct gpu_command_pool *pool) {
    if (!array_reserve(&device->host, &pool->buffers, (uint64_t)pool->buffers.count + 1)) return FNL_ERROR_MEMORY;
    struct gpu_commands *commands = host_allocate_zero(&device->host, sizeof *commands);
    if (!commands) return FNL_ERROR_MEMORY;
    VkCommandBufferAllocateInfo info = {
        .sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
        .commandPool = pool->handle,
        .level = VK_COMMAND_BUFFER_LEVEL_PRIMARY,
        .commandBufferCount = 1,
    };
    VkResult result = device->vk.AllocateCommandBuffers(device->handle, &info, &commands->handle);
    if (result != VK_SUCCESS) {
        host_free(&device->host, commands, sizeof *commands);
        return gpu_check(device, result, "vkAllocateCommandBuffers");
    }
    pool->buffers.data[pool->buffers.count++] = commands;
    return FNL_OK;
}

static fnl_result begin_commands(gpu_device *device, enum gpu_queue queue, uint32_t chunk, struct gpu_commands **out) {
    REQUIRE(&device->host, device->in_frame);
    REQUIRE(&device->host, chunk < GPU_MAX_CHUNKS);
    uint32_t slot = gpu_frame_slot(device);
    struct gpu_command_pool *pool = &device->frames[slot].pools[queue][chunk];
    if (!pool->handle) TRY(gpu_command_pool_init(device, pool, queue));
    if (pool->used == pool->buffers.count) TRY(add_buffer(device, pool));
    struct gpu_commands *commands = pool->buffers.data[pool->used];
    *commands = (struct gpu_commands){.device = device, .handle = commands->handle, .queue = queue, .slot = slot};
    VkCommandBufferBeginInfo info = {
        .sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
        .flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT,
    };
    TRY(gpu_check(device, device->vk.BeginCommandBuffer(commands->handle, &info), "vkBeginCommandBuffer"));
    pool->used++;
    *out = commands;
    return FNL_OK;
}

struct gpu_commands *gpu_commands_begin(gpu_device *device, enum gpu_queue queue, uint32_t chunk) {
    struct gpu_commands *commands;
    fnl_result result = begin_commands(device, queue, chunk, &commands);
    if (result == FNL_OK) return commands;
    gpu_fail(device, result);
    return &device->dead_commands;
}

void gpu_commands_end(struct gpu_commands *commands) {
    if (!commands->handle) return;
    gpu_device *device = commands->device;
    gpu_fail(device, gpu_check(device, device->vk.EndCommandBuffer(commands->handle), "vkEndCommandBuffer"));
}

gpu_device *gpu_commands_device(struct gpu_commands *commands) { return commands->device; }

/* ---- pipelines, draws and dispatches ---- */

void gpu_bind(struct gpu_commands *commands, const struct gpu_pipeline *pipeline) {
    if (!commands->handle) return;
    commands->pipeline = pipeline;
    if (!pipeline) return;
    gpu_device *device = commands->device;
    device->vk.CmdBindPipeline(commands->handle, pipeline->point, pipeline->handle);
    if (pipeline->point == VK_PIPELINE_BIND_POINT_GRAPHICS) {
        /* The viewport's negative height turns +Y up, so what is counter-clockwise there is so for Vulkan too. */
        device->vk.CmdSetCullMode(commands->handle, pipeline->key.graphics.cull);
        device->vk.CmdSetFrontFace(commands->handle, pipeline->key.graphics.mirrored ? VK_FRONT_FACE_CLOCKWISE : VK_FRONT_FACE_COUNTER_CLOCKWISE);
    }
    if (!commands->set_bound[pipeline->point]) {
        commands->set_bound[pipeline->point] = true;
        device->vk.CmdBindDescriptorSets(commands->handle, pipeline->point, device->bindless.layout, 0, 1,
                                         &device->bindless.set, 0, NULL);
    }
}

void gpu_push(struct gpu_commands *commands, const void *data, uint32_t size) {
    if (!commands->handle) return;
    gpu_device *device = commands->device;
    if (size == 0 || size > GPU_PUSH_BYTES || size % 4) {
        log_error(&device->host, "gpu_push: misuse, %u bytes: a multiple of 4 up to %d is allowed", size, GPU_PUSH_BYTES);
        gpu_fail(device, FNL_ERROR_INVALID);
        return;
    }
    device->vk.CmdPushConstants(commands->handle, device->bindless.layout, VK_SHADER_STAGE_ALL, 0, size, data);
}

static bool can_run(const struct gpu_commands *commands, VkPipelineBindPoint point) {
    return commands->handle && commands->pipeline && commands->pipeline->point == point && !commands->scope_skipped;
}

void gpu_dispatch(struct gpu_commands *commands, uint32_t x, uint32_t y, uint32_t z) {
    if (!can_run(commands, VK_PIPELINE_BIND_POINT_COMPUTE)) return;
    commands->device->vk.CmdDispatch(commands->handle, x, y, z);
}

void gpu_dispatch_linear(struct gpu_commands *commands, uint32_t groups) {
    enum { ROW = 65535 }; /* every device takes this many groups in each dimension */
    gpu_dispatch(commands, MIN(groups, (uint32_t)ROW), DIVIDE_UP(groups, (uint32_t)ROW), 1);
}

void gpu_dispatch_indirect(struct gpu_commands *commands, const struct gpu_buffer *buffer, uint64_t offset) {
    if (!can_run(commands, VK_PIPELINE_BIND_POINT_COMPUTE)) return;
    commands->device->vk.CmdDispatchIndirect(commands->handle, buffer->handle, offset);
}

void gpu_bind_indices(struct gpu_commands *commands, const struct gpu_buffer *buffer, uint64_t offset) {
    if (!commands->handle) return;
    commands->device->vk.CmdBindIndexBuffer(commands->handle, buffer->handle, offset, VK_INDEX_TYPE_UINT32);
}

void gpu_draw(struct gpu_commands *commands, uint32_t vertex_count, uint32_t instance_count, uint32_t first_vertex,
              uint32_t first_instance) {
    if (!can_run(commands, VK_PIPELINE_BIND_POINT_GRAPHICS)) return;
    commands->device->vk.CmdDraw(commands->handle, vertex_count, instance_count, first_vertex, first_instance);
}

void gpu_draw_indexed_indirect(struct gpu_commands *commands, const struct gpu_buffer *buffer, uint64_t offset,
                               uint32_t count) {
    if (!can_run(commands, VK_PIPELINE_BIND_POINT_GRAPHICS) || count == 0) return;
    commands->device->vk.CmdDrawIndexedIndirect(commands->handle, buffer->handle, offset, count,
                                                sizeof(VkDrawIndexedIndirectCommand));
}

void gpu_draw_indexed_indirect_count(struct gpu_commands *commands, const struct gpu_buffer *buffer, uint64_t offset,
                                     const struct gpu_buffer *count_buffer, uint64_t count_offset, uint32_t max_count) {
    if (!can_run(commands, VK_PIPELINE_BIND_POINT_GRAPHICS)) return;
    commands->device->vk.CmdDrawIndexedIndirectCount(commands->handle, buffer->handle, offset, count_buffer->handle,
                                                     count_offset, max_count, sizeof(VkDrawIndexedIndirectCommand));
    /* Mesa's CPU driver goes on limiting later indirect draws of the command buffer by the last count that it was given. */
    if (!commands->device->keeps_draw_counts) return;
    struct gpu_slice all = gpu_frame_allocate(commands->device, sizeof(uint32_t));
    if (!all.data) return;
    *(uint32_t *)all.data = UINT32_MAX;
    commands->device->vk.CmdDrawIndexedIndirectCount(commands->handle, buffer->handle, offset, all.buffer->handle,
                                                     all.offset, 0, sizeof(VkDrawIndexedIndirectCommand));
}

void gpu_draw_mesh_indirect(struct gpu_commands *commands, const struct gpu_buffer *buffer, uint64_t offset) {
    if (!can_run(commands, VK_PIPELINE_BIND_POINT_GRAPHICS)) return;
    commands->device->vk.CmdDrawMeshTasksIndirectEXT(commands->handle, buffer->handle, offset, 1,
                                                     sizeof(VkDrawMeshTasksIndirectCommandEXT));
}

/* ---- copies ---- */

void gpu_copy_buffer(struct gpu_commands *commands, const struct gpu_buffer *from, uint64_t from_offset,
                     const struct gpu_buffer *to, uint64_t to_offset, uint64_t size) {
    if (!commands->handle || size == 0) return;
    VkBufferCopy region = {from_offset, to_offset, size};
    commands->device->vk.CmdCopyBuffer(commands->handle, from->handle, to->handle, 1, &region);
}

void gpu_fill_buffer(struct gpu_commands *commands, const struct gpu_buffer *buffer, uint64_t offset, uint64_t size,
                     uint32_t value) {
    if (!commands->handle || size == 0) return;
    commands->device->vk.CmdFillBuffer(commands->handle, buffer->handle, offset, size, value);
}

static VkImageSubresourceLayers first_mip(const struct gpu_image *image) {
    VkImageAspectFlags aspect = gpu_format_aspect(image->params.format);
    if (aspect & VK_IMAGE_ASPECT_DEPTH_BIT) aspect = VK_IMAGE_ASPECT_DEPTH_BIT;
    return (VkImageSubresourceLayers){aspect, image->first_mip, image->first_layer, 1};
}

void gpu_copy_image_to_buffer(struct gpu_commands *commands, const struct gpu_image *from, const struct gpu_buffer *to,
                              uint64_t offset) {
    if (!commands->handle) return;
    VkBufferImageCopy region = {
        .bufferOffset = offset,
        .imageSubresource = first_mip(from),
        .imageExtent = {from->params.width, from->params.height, 1},
    };
    commands->device->vk.CmdCopyImageToBuffer(commands->handle, from->handle, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
                                              to->handle, 1, &region);
}

void gpu_copy_buffer_to_image(struct gpu_commands *commands, const struct gpu_buffer *from, uint64_t offset, const struct gpu_image *to) {
    if (!commands->handle) return;
    for (uint32_t mip = 0; mip < to->params.mips; mip++) {
        uint32_t width = MAX(to->params.width >> mip, 1u), height = MAX(to->params.height >> mip, 1u);
        VkBufferImageCopy region = {
            .bufferOffset = offset,
            .imageSubresource = {gpu_format_aspect(to->params.format), to->first_mip + mip, to->first_layer, to->params.layers},
            .imageExtent = {width, height, 1},
        };
        commands->device->vk.CmdCopyBufferToImage(commands->handle, from->handle, to->handle, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1,
                                                  &region);
        offset += gpu_texels_bytes(to->params.format, width, height) * to->params.layers;
    }
}

void gpu_copy_image(struct gpu_commands *commands, const struct gpu_image *from, const struct gpu_image *to, const struct gpu_image_copy *copy) {
    if (!commands->handle) return;
    const struct gpu_image_copy whole = {.width = from->params.width, .height = from->params.height};
    if (!copy) copy = &whole;
    VkImageCopy region = {
        .srcSubresource = first_mip(from),
        .srcOffset = {(int32_t)copy->from_x, (int32_t)copy->from_y, 0},
        .dstSubresource = first_mip(to),
        .dstOffset = {(int32_t)copy->to_x, (int32_t)copy->to_y, 0},
        .extent = {copy->width, copy->height, 1},
    };
    region.dstSubresource.baseArrayLayer += copy->layer;
    commands->device->vk.CmdCopyImage(commands->handle, from->handle, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, to->handle,
                                      VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &region);
}

/* ---- rendering ---- */

static bool is_integer(VkFormat format) {
    switch (format) {
    case VK_FORMAT_R8_UINT:
    case VK_FORMAT_R16_UINT:
    case VK_FORMAT_R32_UINT:
    case VK_FORMAT_R32_SINT:
    case VK_FORMAT_R8G8_UINT:
    case VK_FORMAT_R16G16_UINT:
    case VK_FORMAT_R32G32_UINT:
    case VK_FORMAT_R32G32_SINT:
    case VK_FORMAT_R8G8B8A8_UINT:
    case VK_FORMAT_R16G16B16A16_UINT:
    case VK_FORMAT_R32G32B32A32_UINT:
    case VK_FORMAT_R32G32B32A32_SINT:
        return true;
    default:
        return false;
    }
}

static VkRenderingAttachmentInfo attachment_info(const struct gpu_attachment *attachment, VkImageLayout layout) {
    VkRenderingAttachmentInfo info = {
        .sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO,
        .imageView = attachment->image->attachment_view,
        .imageLayout = layout,
        .loadOp = attachment->load,
        .storeOp = attachment->store,
        .clearValue = attachment->clear,
    };
    if (attachment->resolve) {
        /* Integers have no average: the first sample stands for all. */
        info.resolveMode =
            is_integer(attachment->image->params.format) ? VK_RESOLVE_MODE_SAMPLE_ZERO_BIT : VK_RESOLVE_MODE_AVERAGE_BIT;
        info.resolveImageView = attachment->resolve->attachment_view;
        info.resolveImageLayout = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL;
    }
    return info;
}

void gpu_begin_rendering(struct gpu_commands *commands, const struct gpu_rendering *rendering) {
    if (!commands->handle) return;
    const struct gpu_device_functions *vk = &commands->device->vk;
    VkRenderingAttachmentInfo colors[GPU_MAX_COLORS], depth;
    for (uint32_t i = 0; i < rendering->color_count; i++)
        colors[i] = attachment_info(&rendering->colors[i], VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL);
    VkFormat format = rendering->depth.image ? rendering->depth.image->params.format : VK_FORMAT_UNDEFINED;
    bool is_stencil = format == VK_FORMAT_S8_UINT, is_both = format == VK_FORMAT_D32_SFLOAT_S8_UINT;
    if (rendering->depth.image) {
        VkImageLayout layout =
            rendering->depth.read_only ? VK_IMAGE_LAYOUT_DEPTH_READ_ONLY_OPTIMAL : VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL;
        if (is_stencil)
            layout = rendering->depth.read_only ? VK_IMAGE_LAYOUT_STENCIL_READ_ONLY_OPTIMAL
                                                : VK_IMAGE_LAYOUT_STENCIL_ATTACHMENT_OPTIMAL;
        else if (is_both)
            layout = rendering->depth.read_only ? VK_IMAGE_LAYOUT_DEPTH_STENCIL_READ_ONLY_OPTIMAL
                                                : VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL;
        depth = attachment_info(&rendering->depth, layout);
        if (rendering->depth.read_only) depth.storeOp = VK_ATTACHMENT_STORE_OP_NONE; /* STORE would count as a write */
    }
    VkRect2D area = {{0, 0}, {rendering->width, rendering->height}};
    VkRenderingInfo info = {
        .sType = VK_STRUCTURE_TYPE_RENDERING_INFO,
        .renderArea = area,
        .layerCount = MAX(1u, rendering->layers), /* ignored with a view mask */
        .viewMask = rendering->view_mask,
        .colorAttachmentCount = rendering->color_count,
        .pColorAttachments = colors,
        .pDepthAttachment = rendering->depth.image && !is_stencil ? &depth : NULL,
        .pStencilAttachment = is_stencil || is_both ? &depth : NULL,
    };
    vk->CmdBeginRendering(commands->handle, &info);
    VkViewport viewport = {0, (float)rendering->height, (float)rendering->width, -(float)rendering->height, 0, 1};
    vk->CmdSetViewport(commands->handle, 0, 1, &viewport);
    vk->CmdSetScissor(commands->handle, 0, 1, &area);
}

void gpu_end_rendering(struct gpu_commands *commands) {
    if (commands->handle) commands->device->vk.CmdEndRendering(commands->handle);
}

void gpu_scissor(struct gpu_commands *commands, uint32_t x, uint32_t y, uint32_t width, uint32_t height) {
    const VkRect2D area = {{(int32_t)x, (int32_t)y}, {width, height}};
    if (commands->handle) commands->device->vk.CmdSetScissor(commands->handle, 0, 1, &area);
}

void gpu_stencil_reference(struct gpu_commands *commands, uint32_t reference) {
    if (commands->handle)
        commands->device->vk.CmdSetStencilReference(commands->handle, VK_STENCIL_FACE_FRONT_AND_BACK, reference);
}

void gpu_clear_stencil(struct gpu_commands *commands, uint32_t width, uint32_t height, uint32_t value) {
    if (!commands->handle) return;
    VkClearAttachment clear = {.aspectMask = VK_IMAGE_ASPECT_STENCIL_BIT, .clearValue.depthStencil.stencil = value};
    VkClearRect area = {.rect.extent = {width, height}, .layerCount = 1};
    commands->device->vk.CmdClearAttachments(commands->handle, 1, &clear, 1, &area);
}

/* ---- barriers, labels, timestamps ---- */

void gpu_barrier(struct gpu_commands *commands, const struct gpu_image_barrier *images, uint32_t image_count,
                 VkPipelineStageFlags2 from_stages, VkAccessFlags2 from_access, VkPipelineStageFlags2 to_stages,
                 VkAccessFlags2 to_access) {
    if (!commands->handle) return;
    enum { BATCH = 32 };
    VkImageMemoryBarrier2 barriers[BATCH];
    VkMemoryBarrier2 memory = {
        .sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER_2,
        .srcStageMask = from_stages,
        .srcAccessMask = from_access,
        .dstStageMask = to_stages,
        .dstAccessMask = to_access,
    };
    uint32_t memory_count = from_stages || to_stages ? 1 : 0;
    for (uint32_t first = 0; first < image_count || memory_count; first += BATCH) {
        uint32_t count = first < image_count ? MIN(image_count - first, (uint32_t)BATCH) : 0;
        for (uint32_t i = 0; i < count; i++) {
            const struct gpu_image_barrier *from = &images[first + i];
            barriers[i] = (VkImageMemoryBarrier2){
                .sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2,
                .srcStageMask = from->from_stages,
                .srcAccessMask = from->from_access,
                .dstStageMask = from->to_stages,
                .dstAccessMask = from->to_access,
                .oldLayout = from->from_layout,
                .newLayout = from->to_layout,
                .srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
                .dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
                .image = from->image->handle,
                .subresourceRange = {gpu_format_aspect(from->image->params.format), 0, VK_REMAINING_MIP_LEVELS, 0,
                                     VK_REMAINING_ARRAY_LAYERS},
            };
        }
        VkDependencyInfo info = {
            .sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO,
            .memoryBarrierCount = memory_count,
            .pMemoryBarriers = &memory,
            .imageMemoryBarrierCount = count,
            .pImageMemoryBarriers = barriers,
        };
        commands->device->vk.CmdPipelineBarrier2(commands->handle, &info);
        memory_count = 0;
    }
}

void gpu_begin_label(struct gpu_commands *commands, const char *name) {
    if (!commands->handle || !commands->device->names) return;
    VkDebugUtilsLabelEXT label = {.sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_LABEL_EXT, .pLabelName = name};
    commands->device->vk.CmdBeginDebugUtilsLabelEXT(commands->handle, &label);
}

void gpu_end_label(struct gpu_commands *commands) {
    if (commands->handle && commands->device->names) commands->device->vk.CmdEndDebugUtilsLabelEXT(commands->handle);
}

void gpu_timestamp(struct gpu_commands *commands, uint32_t index) {
    gpu_device *device = commands->device;
    if (!commands->handle || !device->timestamp_mask || index >= GPU_MAX_TIMESTAMPS) return;
    struct gpu_frame *frame = &device->frames[commands->slot];
    device->vk.CmdWriteTimestamp2(commands->handle, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, frame->queries, index);
    /* The CPU driver takes the time when it next flushes, which may be after a later dispatch: a barrier flushes. It makes
       no memory visible, so that validation still finds what lacks a barrier of its own. */
    if (device->info.type == FNL_DEVICE_CPU)
        gpu_barrier(commands, NULL, 0, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, 0, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, 0);
    unsigned count = atomic_load(&frame->timestamp_count);
    while (count < index + 1 && !atomic_compare_exchange_weak(&frame->timestamp_count, &count, index + 1)) continue;
}

static VkQueryPool vertex_counts(const struct gpu_commands *commands, uint32_t query, uint32_t views) {
    if (!commands->handle || query + views > GPU_MAX_VERTEX_COUNTS) return VK_NULL_HANDLE;
    return commands->device->frames[commands->slot].vertex_counts;
}

void gpu_begin_vertex_count(struct gpu_commands *commands, uint32_t query, uint32_t views) {
    VkQueryPool pool = vertex_counts(commands, query, views);
    if (!pool) return;
    commands->device->vk.CmdBeginQuery(commands->handle, pool, query, 0);
    atomic_store(&commands->device->frames[commands->slot].vertices_counted, true);
}

void gpu_end_vertex_count(struct gpu_commands *commands, uint32_t query, uint32_t views) {
    VkQueryPool pool = vertex_counts(commands, query, views);
    if (pool) commands->device->vk.CmdEndQuery(commands->handle, pool, query);
}
