/* SPDX-License-Identifier: MIT */
/* Uploads go through a ring of segments. One is filled with data and commands, submitted, and waited for when its turn
   comes again. */
#include "gpu/gpu_internal.h"

enum { STAGING_ALIGNMENT = 16, READBACK_BYTES = 4 << 20 };

/* ---- segments; the mutex is held ---- */

static fnl_result start_uploads(gpu_device *device) {
    struct gpu_uploads *uploads = &device->uploads;
    if (uploads->ready) return FNL_OK;
    if (!uploads->ring.handle) {
        TRY(gpu_buffer_create(device, "upload ring", (uint64_t)GPU_UPLOAD_SEGMENTS * GPU_UPLOAD_SEGMENT_BYTES,
                              GPU_MEMORY_UPLOAD, &uploads->ring));
    }
    for (uint32_t i = 0; i < GPU_UPLOAD_SEGMENTS; i++) {
        struct gpu_upload_segment *segment = &uploads->segments[i];
        VkCommandPoolCreateInfo pool = {
            .sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
            .flags = VK_COMMAND_POOL_CREATE_TRANSIENT_BIT,
            .queueFamilyIndex = device->queues[GPU_QUEUE_GRAPHICS].family,
        };
        if (!segment->pool)
            TRY(gpu_check(device, device->vk.CreateCommandPool(device->handle, &pool, NULL, &segment->pool),
                          "vkCreateCommandPool"));
        if (segment->commands) continue;
        VkCommandBufferAllocateInfo commands = {
            .sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
            .commandPool = segment->pool,
            .level = VK_COMMAND_BUFFER_LEVEL_PRIMARY,
            .commandBufferCount = 1,
        };
        VkResult result = device->vk.AllocateCommandBuffers(device->handle, &commands, &segment->commands);
        if (result != VK_SUCCESS) segment->commands = VK_NULL_HANDLE;
        TRY(gpu_check(device, result, "vkAllocateCommandBuffers"));
    }
    uploads->ready = true;
    return FNL_OK;
}

void gpu_uploads_finish(gpu_device *device) {
    struct gpu_uploads *uploads = &device->uploads;
    for (uint32_t i = 0; i < GPU_UPLOAD_SEGMENTS; i++)
        device->vk.DestroyCommandPool(device->handle, uploads->segments[i].pool, NULL);
    gpu_buffer_destroy(device, &uploads->ring);
    gpu_buffer_destroy(device, &uploads->readback);
}

static void barrier(gpu_device *device, VkCommandBuffer commands, VkPipelineStageFlags2 from, VkAccessFlags2 from_access,
                    VkPipelineStageFlags2 to, VkAccessFlags2 to_access) {
    VkMemoryBarrier2 memory = {
        .sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER_2,
        .srcStageMask = from,
        .srcAccessMask = from_access,
        .dstStageMask = to,
        .dstAccessMask = to_access,
    };
    VkDependencyInfo info = {
        .sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO, .memoryBarrierCount = 1, .pMemoryBarriers = &memory};
    device->vk.CmdPipelineBarrier2(commands, &info);
}

/** Makes the current segment's command buffer ready for recording. */
static fnl_result open_segment(gpu_device *device) {
    struct gpu_uploads *uploads = &device->uploads;
    TRY(start_uploads(device));
    if (uploads->open) return FNL_OK;
    struct gpu_upload_segment *segment = &uploads->segments[uploads->segment];
    TRY(gpu_semaphore_wait(device, uploads->timeline, segment->value));
    TRY(gpu_check(device, device->vk.ResetCommandPool(device->handle, segment->pool, 0), "vkResetCommandPool"));
    VkCommandBufferBeginInfo info = {
        .sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
        .flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT,
    };
    TRY(gpu_check(device, device->vk.BeginCommandBuffer(segment->commands, &info), "vkBeginCommandBuffer"));
    /* After what earlier submissions did to the same resources. */
    barrier(device, segment->commands, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, VK_ACCESS_2_MEMORY_WRITE_BIT,
            VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, VK_ACCESS_2_TRANSFER_READ_BIT | VK_ACCESS_2_TRANSFER_WRITE_BIT);
    uploads->used = 0;
    uploads->open = true;
    atomic_store(&uploads->recorded, atomic_load(&uploads->submitted) + 1);
    return FNL_OK;
}

/** Submits the current segment and goes to the next. */
static fnl_result submit_segment(gpu_device *device) {
    struct gpu_uploads *uploads = &device->uploads;
    if (!uploads->open) return FNL_OK;
    struct gpu_upload_segment *segment = &uploads->segments[uploads->segment];
    uploads->open = false;
    uploads->segment = (uploads->segment + 1) % GPU_UPLOAD_SEGMENTS;
    barrier(device, segment->commands, VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT,
            VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT | VK_PIPELINE_STAGE_2_HOST_BIT,
            VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT | VK_ACCESS_2_HOST_READ_BIT);
    fnl_result result = gpu_check(device, device->vk.EndCommandBuffer(segment->commands), "vkEndCommandBuffer");
    pthread_mutex_lock(&device->queue_mutex);
    uint64_t value = atomic_load(&uploads->submitted) + 1;
    if (result == FNL_OK) {
        VkCommandBufferSubmitInfo commands = {
            .sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_SUBMIT_INFO,
            .commandBuffer = segment->commands,
        };
        VkSemaphoreSubmitInfo signal = {
            .sType = VK_STRUCTURE_TYPE_SEMAPHORE_SUBMIT_INFO,
            .semaphore = uploads->timeline,
            .value = value,
            .stageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
        };
        /* The barriers order it behind the graphics queue; the other may still read what it changes. */
        const struct gpu_queue_state *other = &device->queues[GPU_QUEUE_COMPUTE];
        VkSemaphoreSubmitInfo wait = {
            .sType = VK_STRUCTURE_TYPE_SEMAPHORE_SUBMIT_INFO,
            .semaphore = other->timeline,
            .value = other->value,
            .stageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
        };
        VkSubmitInfo2 info = {
            .sType = VK_STRUCTURE_TYPE_SUBMIT_INFO_2,
            .waitSemaphoreInfoCount = other->value ? 1 : 0,
            .pWaitSemaphoreInfos = &wait,
            .commandBufferInfoCount = 1,
            .pCommandBufferInfos = &commands,
            .signalSemaphoreInfoCount = 1,
            .pSignalSemaphoreInfos = &signal,
        };
        VkQueue queue = device->queues[GPU_QUEUE_GRAPHICS].handle;
        result = gpu_check(device, device->vk.QueueSubmit2(queue, 1, &info, VK_NULL_HANDLE), "vkQueueSubmit2 (uploads)");
    }
    if (result == FNL_OK) {
        segment->value = value;
        atomic_store(&uploads->submitted, value);
    }
    atomic_store(&uploads->recorded, atomic_load(&uploads->submitted));
    pthread_mutex_unlock(&device->queue_mutex);
    return result;
}

/** Room in an open segment: at least `unit` bytes, at most `wanted`, a multiple of `unit`. */
static fnl_result take_staging(gpu_device *device, uint64_t wanted, uint64_t unit, uint64_t *size, uint64_t *offset,
                               VkCommandBuffer *commands) {
    struct gpu_uploads *uploads = &device->uploads;
    REQUIRE(&device->host, unit > 0 && unit <= GPU_UPLOAD_SEGMENT_BYTES);
    TRY(open_segment(device));
    if (GPU_UPLOAD_SEGMENT_BYTES - uploads->used < unit) {
        TRY(submit_segment(device));
        TRY(open_segment(device));
    }
    *size = MIN(wanted, (GPU_UPLOAD_SEGMENT_BYTES - uploads->used) / unit * unit);
    *offset = (uint64_t)uploads->segment * GPU_UPLOAD_SEGMENT_BYTES + uploads->used;
    *commands = uploads->segments[uploads->segment].commands;
    uploads->used = MIN((uint64_t)GPU_UPLOAD_SEGMENT_BYTES, align_up(uploads->used + *size, STAGING_ALIGNMENT));
    return FNL_OK;
}

fnl_result gpu_uploads_wait(gpu_device *device, uint64_t value) {
    struct gpu_uploads *uploads = &device->uploads;
    if (value == 0) return FNL_OK;
    if (value > atomic_load(&uploads->submitted)) {
        pthread_mutex_lock(&uploads->mutex);
        fnl_result result = submit_segment(device);
        pthread_mutex_unlock(&uploads->mutex);
        TRY(result);
    }
    return gpu_semaphore_wait(device, uploads->timeline, MIN(value, atomic_load(&uploads->submitted)));
}

fnl_result gpu_upload_submit(gpu_device *device) {
    pthread_mutex_lock(&device->uploads.mutex);
    fnl_result result = submit_segment(device);
    pthread_mutex_unlock(&device->uploads.mutex);
    return result;
}

fnl_result gpu_upload_flush(gpu_device *device) { return gpu_uploads_wait(device, atomic_load(&device->uploads.recorded)); }

/* ---- buffers ---- */

static fnl_result upload_buffer(gpu_device *device, const struct gpu_buffer *buffer, uint64_t offset, const void *data,
                                uint64_t size) {
    const char *bytes = data;
    while (size > 0) {
        uint64_t piece, staging;
        VkCommandBuffer commands;
        TRY(take_staging(device, size, 1, &piece, &staging, &commands));
        memcpy((char *)device->uploads.ring.mapped + staging, bytes, (size_t)piece);
        VkBufferCopy region = {staging, offset, piece};
        device->vk.CmdCopyBuffer(commands, device->uploads.ring.handle, buffer->handle, 1, &region);
        bytes += piece;
        offset += piece;
        size -= piece;
    }
    return FNL_OK;
}

fnl_result gpu_upload_buffer(gpu_device *device, const struct gpu_buffer *buffer, uint64_t offset, const void *data,
                             uint64_t size) {
    REQUIRE(&device->host, buffer->handle != VK_NULL_HANDLE);
    REQUIRE(&device->host, offset <= buffer->size && size <= buffer->size - offset);
    if (size == 0) return FNL_OK;
    pthread_mutex_lock(&device->uploads.mutex);
    fnl_result result = upload_buffer(device, buffer, offset, data, size);
    pthread_mutex_unlock(&device->uploads.mutex);
    return result;
}

static fnl_result copy_buffer(gpu_device *device, const struct gpu_buffer *from, const struct gpu_buffer *to, uint64_t size) {
    TRY(open_segment(device));
    VkCommandBuffer commands = device->uploads.segments[device->uploads.segment].commands;
    /* After uploads that the same segment holds, and before those that it will. */
    const VkAccessFlags2 both = VK_ACCESS_2_TRANSFER_READ_BIT | VK_ACCESS_2_TRANSFER_WRITE_BIT;
    barrier(device, commands, VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT,
            VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, both);
    VkBufferCopy region = {0, 0, size};
    device->vk.CmdCopyBuffer(commands, from->handle, to->handle, 1, &region);
    barrier(device, commands, VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT,
            VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, both);
    return FNL_OK;
}

fnl_result gpu_grow_buffer(gpu_device *device, enum gpu_use use, const char *name, struct gpu_buffer *buffer, uint64_t used, uint64_t size) {
    REQUIRE(&device->host, used <= buffer->size && used <= size);
    struct gpu_buffer grown;
    TRY(gpu_buffer_create_for(device, use, name, size, GPU_MEMORY_DEVICE, &grown));
    fnl_result result = FNL_OK;
    if (used) {
        pthread_mutex_lock(&device->uploads.mutex);
        result = copy_buffer(device, buffer, &grown, used);
        pthread_mutex_unlock(&device->uploads.mutex);
    }
    gpu_buffer_destroy(device, result == FNL_OK ? buffer : &grown);
    if (result == FNL_OK) *buffer = grown;
    return result;
}

static fnl_result read_buffer(gpu_device *device, const struct gpu_buffer *buffer, uint64_t offset, void *data,
                              uint64_t size) {
    struct gpu_uploads *uploads = &device->uploads;
    if (!uploads->readback.handle)
        TRY(gpu_buffer_create(device, "readback", READBACK_BYTES, GPU_MEMORY_READBACK, &uploads->readback));
    for (uint64_t done = 0; done < size;) {
        uint64_t piece = MIN(size - done, (uint64_t)READBACK_BYTES);
        TRY(open_segment(device));
        VkBufferCopy region = {offset + done, 0, piece};
        device->vk.CmdCopyBuffer(uploads->segments[uploads->segment].commands, buffer->handle, uploads->readback.handle, 1,
                                 &region);
        TRY(submit_segment(device));
        TRY(gpu_semaphore_wait(device, uploads->timeline, atomic_load(&uploads->submitted)));
        memcpy((char *)data + done, uploads->readback.mapped, (size_t)piece);
        done += piece;
    }
    return FNL_OK;
}

fnl_result gpu_read_buffer(gpu_device *device, const struct gpu_buffer *buffer, uint64_t offset, void *data, uint64_t size) {
    REQUIRE(&device->host, buffer->handle != VK_NULL_HANDLE);
    REQUIRE(&device->host, offset <= buffer->size && size <= buffer->size - offset);
    TRY(gpu_wait_idle(device));
    if (buffer->mapped) {
        memcpy(data, (const char *)buffer->mapped + offset, (size_t)size);
        return FNL_OK;
    }
    pthread_mutex_lock(&device->uploads.mutex);
    fnl_result result = read_buffer(device, buffer, offset, data, size);
    pthread_mutex_unlock(&device->uploads.mutex);
    return result;
}

/* ---- images ---- */

/** Bytes of one texel of the formats that can be uploaded; 0 for others. */
static uint32_t texel_size(VkFormat format) {
    switch (format) {
    case VK_FORMAT_R8_UNORM:
    case VK_FORMAT_R8_UINT:
        return 1;
    case VK_FORMAT_R8G8_UNORM:
    case VK_FORMAT_R16_UNORM:
    case VK_FORMAT_R16_SFLOAT:
    case VK_FORMAT_R16_UINT:
        return 2;
    case VK_FORMAT_R8G8B8A8_UNORM:
    case VK_FORMAT_R8G8B8A8_SRGB:
    case VK_FORMAT_B8G8R8A8_UNORM:
    case VK_FORMAT_B8G8R8A8_SRGB:
    case VK_FORMAT_R8G8B8A8_UINT:
    case VK_FORMAT_R16G16_UNORM:
    case VK_FORMAT_R16G16_SFLOAT:
    case VK_FORMAT_R32_SFLOAT:
    case VK_FORMAT_R32_UINT:
    case VK_FORMAT_A2B10G10R10_UNORM_PACK32:
    case VK_FORMAT_B10G11R11_UFLOAT_PACK32:
    case VK_FORMAT_E5B9G9R9_UFLOAT_PACK32:
        return 4;
    case VK_FORMAT_R16G16B16A16_UNORM:
    case VK_FORMAT_R16G16B16A16_SFLOAT:
    case VK_FORMAT_R32G32_SFLOAT:
    case VK_FORMAT_R32G32_UINT:
        return 8;
    case VK_FORMAT_R32G32B32A32_SFLOAT:
    case VK_FORMAT_R32G32B32A32_UINT:
        return 16;
    default:
        return 0;
    }
}

static void transition(gpu_device *device, VkCommandBuffer commands, const struct gpu_image *image, uint32_t mip,
                       uint32_t mips, VkImageLayout from, VkImageLayout to) {
    bool discards = from == VK_IMAGE_LAYOUT_UNDEFINED, ends = to == VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL;
    VkAccessFlags2 transfer = VK_ACCESS_2_TRANSFER_READ_BIT | VK_ACCESS_2_TRANSFER_WRITE_BIT;
    VkImageMemoryBarrier2 change = {
        .sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2,
        .srcStageMask = discards ? VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT : VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT,
        .srcAccessMask = discards ? VK_ACCESS_2_MEMORY_WRITE_BIT : VK_ACCESS_2_TRANSFER_WRITE_BIT,
        .dstStageMask = ends ? VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT : VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT,
        .dstAccessMask = ends ? VK_ACCESS_2_SHADER_READ_BIT : transfer,
        .oldLayout = from,
        .newLayout = to,
        .srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
        .dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
        .image = image->handle,
        .subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, mip, mips, 0, 1},
    };
    VkDependencyInfo info = {
        .sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO, .imageMemoryBarrierCount = 1, .pImageMemoryBarriers = &change};
    device->vk.CmdPipelineBarrier2(commands, &info);
}

static void blit_mip(gpu_device *device, VkCommandBuffer commands, const struct gpu_image *image, uint32_t mip) {
    int32_t width = (int32_t)image->params.width, height = (int32_t)image->params.height;
    VkImageBlit region = {
        .srcSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, mip - 1, 0, 1},
        .srcOffsets = {{0, 0, 0}, {MAX(1, width >> (mip - 1)), MAX(1, height >> (mip - 1)), 1}},
        .dstSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, mip, 0, 1},
        .dstOffsets = {{0, 0, 0}, {MAX(1, width >> mip), MAX(1, height >> mip), 1}},
    };
    device->vk.CmdBlitImage(commands, image->handle, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, image->handle,
                            VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &region, VK_FILTER_LINEAR);
}

/* Rows `first` .. `end` - 1 of a mip; `side`: texels of a row's height, 1 or 4. */
struct rows {
    const char *pixels;
    uint64_t row_bytes;
    uint32_t mip, first, end, count, side;
    bool last; /* no mips are sent behind this one */
};

static fnl_result upload_rows(gpu_device *device, const struct gpu_image *image, const struct rows *part, bool generate_mips) {
    const VkImageLayout to_write = VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, to_read = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL;
    const uint32_t mips = image->params.mips, side = part->side;
    const uint32_t width = MAX(image->params.width >> part->mip, 1u), height = MAX(image->params.height >> part->mip, 1u);
    VkCommandBuffer commands = VK_NULL_HANDLE;
    for (uint32_t row = part->first; row < part->end;) {
        uint64_t piece, staging;
        TRY(take_staging(device, (part->end - row) * part->row_bytes, part->row_bytes, &piece, &staging, &commands));
        if (row == 0 && part->mip == 0) transition(device, commands, image, 0, mips, VK_IMAGE_LAYOUT_UNDEFINED, to_write);
        memcpy((char *)device->uploads.ring.mapped + staging, part->pixels + row * part->row_bytes, (size_t)piece);
        uint32_t rows = (uint32_t)(piece / part->row_bytes);
        VkBufferImageCopy region = {
            .bufferOffset = staging,
            .imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, part->mip, 0, 1},
            .imageOffset = {0, (int32_t)(row * side), 0},
            .imageExtent = {width, MIN(rows * side, height - row * side), 1},
        };
        device->vk.CmdCopyBufferToImage(commands, device->uploads.ring.handle, image->handle, to_write, 1, &region);
        row += rows;
    }
    if (part->end < part->count || !part->last) return FNL_OK;
    const VkImageLayout final_layout = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL;
    if (generate_mips && mips > 1) {
        for (uint32_t mip = 1; mip < mips; mip++) {
            transition(device, commands, image, mip - 1, 1, to_write, to_read);
            blit_mip(device, commands, image, mip);
        }
        transition(device, commands, image, 0, mips - 1, to_read, final_layout);
        transition(device, commands, image, mips - 1, 1, to_write, final_layout);
    } else {
        transition(device, commands, image, 0, mips, to_write, final_layout);
    }
    return FNL_OK;
}

/* Of 4 x 4 texels; 0: the format is not compressed. */
static uint32_t block_size(VkFormat format) {
    switch (format) {
    case VK_FORMAT_BC1_RGB_UNORM_BLOCK:
    case VK_FORMAT_BC1_RGBA_UNORM_BLOCK:
    case VK_FORMAT_BC4_UNORM_BLOCK:
        return 8;
    case VK_FORMAT_BC3_UNORM_BLOCK:
    case VK_FORMAT_BC5_UNORM_BLOCK:
    case VK_FORMAT_BC7_UNORM_BLOCK:
        return 16;
    default:
        return 0;
    }
}

uint32_t gpu_mip_rows(const struct gpu_image *image, uint32_t mip) {
    const uint32_t height = MAX(image->params.height >> mip, 1u);
    return block_size(image->params.format) ? DIVIDE_UP(height, 4u) : height;
}

static struct rows rows_of(const struct gpu_image *image, uint32_t mip, const void *pixels, uint32_t first, uint32_t count) {
    const uint32_t width = MAX(image->params.width >> mip, 1u), block = block_size(image->params.format);
    return (struct rows){.pixels = pixels,
                         .row_bytes = block ? (uint64_t)DIVIDE_UP(width, 4u) * block : (uint64_t)width * texel_size(image->params.format),
                         .mip = mip,
                         .first = first,
                         .end = first + count,
                         .count = gpu_mip_rows(image, mip),
                         .side = block ? 4 : 1,
                         .last = true};
}

static fnl_result check_rows(const fnl_host *host, const struct gpu_image *image, const struct rows *rows, uint64_t size) {
    const struct gpu_image_params *params = &image->params;
    REQUIRE(host, image->handle != VK_NULL_HANDLE);
    REQUIRE(host, params->usage & VK_IMAGE_USAGE_TRANSFER_DST_BIT);
    REQUIRE(host, params->usage & VK_IMAGE_USAGE_SAMPLED_BIT);
    REQUIRE(host, params->samples == 1);
    REQUIRE(host, rows->row_bytes > 0 && size == rows->row_bytes * rows->count);
    REQUIRE(host, rows->first < rows->count && rows->end > rows->first && rows->end <= rows->count);
    return FNL_OK;
}

fnl_result gpu_upload_image_rows(gpu_device *device, const struct gpu_image *image, const void *pixels, uint64_t size,
                                 uint32_t first, uint32_t count, bool generate_mips, bool color) {
    const fnl_host *host = &device->host;
    const struct gpu_image_params *params = &image->params;
    const struct rows rows = rows_of(image, 0, pixels, first, count);
    TRY(check_rows(host, image, &rows, size));
    if (generate_mips && params->mips > 1) {
        REQUIRE(host, params->usage & VK_IMAGE_USAGE_TRANSFER_SRC_BIT);
        REQUIRE(host, color == params->srgb_view); /* the image's own format decides how blits average */
        if (!gpu_format_supports(device, params->format,
                                 VK_FORMAT_FEATURE_2_BLIT_SRC_BIT | VK_FORMAT_FEATURE_2_BLIT_DST_BIT |
                                     VK_FORMAT_FEATURE_2_SAMPLED_IMAGE_FILTER_LINEAR_BIT)) {
            log_error(host, "'%s': this device cannot make mips of VkFormat %d", params->name, (int)params->format);
            return FNL_ERROR_UNSUPPORTED;
        }
    }
    pthread_mutex_lock(&device->uploads.mutex);
    fnl_result result = upload_rows(device, image, &rows, generate_mips);
    pthread_mutex_unlock(&device->uploads.mutex);
    return result;
}

fnl_result gpu_upload_image_mip(gpu_device *device, const struct gpu_image *image, uint32_t mip, const void *pixels, uint64_t size, uint32_t first,
                                uint32_t count) {
    REQUIRE(&device->host, mip < image->params.mips);
    struct rows rows = rows_of(image, mip, pixels, first, count);
    rows.last = mip + 1 == image->params.mips;
    TRY(check_rows(&device->host, image, &rows, size));
    pthread_mutex_lock(&device->uploads.mutex);
    fnl_result result = upload_rows(device, image, &rows, false);
    pthread_mutex_unlock(&device->uploads.mutex);
    return result;
}

fnl_result gpu_upload_image(gpu_device *device, const struct gpu_image *image, const void *pixels, uint64_t size,
                            bool generate_mips, bool color) {
    return gpu_upload_image_rows(device, image, pixels, size, 0, image->params.height, generate_mips, color);
}
