/* SPDX-License-Identifier: MIT */
#include "gpu/gpu_internal.h"

VkImageAspectFlags gpu_format_aspect(VkFormat format) {
    switch (format) {
    case VK_FORMAT_D16_UNORM:
    case VK_FORMAT_X8_D24_UNORM_PACK32:
    case VK_FORMAT_D32_SFLOAT:
        return VK_IMAGE_ASPECT_DEPTH_BIT;
    case VK_FORMAT_D16_UNORM_S8_UINT:
    case VK_FORMAT_D24_UNORM_S8_UINT:
    case VK_FORMAT_D32_SFLOAT_S8_UINT:
        return VK_IMAGE_ASPECT_DEPTH_BIT | VK_IMAGE_ASPECT_STENCIL_BIT;
    case VK_FORMAT_S8_UINT:
        return VK_IMAGE_ASPECT_STENCIL_BIT;
    default:
        return VK_IMAGE_ASPECT_COLOR_BIT;
    }
}

uint32_t gpu_texel_bytes(VkFormat format) {
    switch (format) {
    case VK_FORMAT_R8_UNORM:
    case VK_FORMAT_R8_UINT:
        return 1;
    case VK_FORMAT_R8G8_UNORM:
    case VK_FORMAT_R8G8_UINT:
    case VK_FORMAT_R16_SFLOAT:
    case VK_FORMAT_R16_UNORM:
    case VK_FORMAT_R16_UINT:
    case VK_FORMAT_D16_UNORM:
        return 2;
    case VK_FORMAT_R8G8B8A8_UNORM:
    case VK_FORMAT_R8G8B8A8_SNORM:
    case VK_FORMAT_R8G8B8A8_SRGB:
    case VK_FORMAT_R8G8B8A8_UINT:
    case VK_FORMAT_B8G8R8A8_UNORM:
    case VK_FORMAT_B8G8R8A8_SRGB:
    case VK_FORMAT_A2B10G10R10_UNORM_PACK32:
    case VK_FORMAT_A2R10G10B10_UNORM_PACK32:
    case VK_FORMAT_B10G11R11_UFLOAT_PACK32:
    case VK_FORMAT_E5B9G9R9_UFLOAT_PACK32:
    case VK_FORMAT_R16G16_SFLOAT:
    case VK_FORMAT_R16G16_UNORM:
    case VK_FORMAT_R16G16_SNORM:
    case VK_FORMAT_R16G16_UINT:
    case VK_FORMAT_R32_SFLOAT:
    case VK_FORMAT_R32_UINT:
    case VK_FORMAT_R32_SINT:
    case VK_FORMAT_D32_SFLOAT:
    case VK_FORMAT_X8_D24_UNORM_PACK32:
    case VK_FORMAT_D24_UNORM_S8_UINT:
        return 4;
    case VK_FORMAT_D32_SFLOAT_S8_UINT:
        return 5;
    case VK_FORMAT_R16G16B16A16_SFLOAT:
    case VK_FORMAT_R16G16B16A16_UNORM:
    case VK_FORMAT_R16G16B16A16_SNORM:
    case VK_FORMAT_R16G16B16A16_UINT:
    case VK_FORMAT_R32G32_SFLOAT:
    case VK_FORMAT_R32G32_UINT:
        return 8;
    case VK_FORMAT_R32G32B32_SFLOAT:
        return 12;
    case VK_FORMAT_R32G32B32A32_SFLOAT:
    case VK_FORMAT_R32G32B32A32_UINT:
        return 16;
    default:
        return 0;
    }
}

static bool is_compressed(VkFormat format) { return format >= VK_FORMAT_BC1_RGB_UNORM_BLOCK && format <= VK_FORMAT_BC7_SRGB_BLOCK; }

uint64_t gpu_texels_bytes(VkFormat format, uint32_t width, uint32_t height) {
    if (format == VK_FORMAT_BC3_UNORM_BLOCK || format == VK_FORMAT_BC6H_UFLOAT_BLOCK || format == VK_FORMAT_BC6H_SFLOAT_BLOCK)
        return (uint64_t)DIVIDE_UP(width, 4u) * DIVIDE_UP(height, 4u) * 16;
    return (uint64_t)width * height * gpu_texel_bytes(format);
}

static bool stores_blocks(const struct gpu_image_params *params) {
    return is_compressed(params->format) && params->usage & VK_IMAGE_USAGE_STORAGE_BIT;
}

static VkFormat srgb_format(VkFormat format) {
    switch (format) {
    case VK_FORMAT_R8G8B8A8_UNORM:
        return VK_FORMAT_R8G8B8A8_SRGB;
    case VK_FORMAT_B8G8R8A8_UNORM:
        return VK_FORMAT_B8G8R8A8_SRGB;
    case VK_FORMAT_BC1_RGB_UNORM_BLOCK:
        return VK_FORMAT_BC1_RGB_SRGB_BLOCK;
    case VK_FORMAT_BC1_RGBA_UNORM_BLOCK:
        return VK_FORMAT_BC1_RGBA_SRGB_BLOCK;
    case VK_FORMAT_BC3_UNORM_BLOCK:
        return VK_FORMAT_BC3_SRGB_BLOCK;
    case VK_FORMAT_BC7_UNORM_BLOCK:
        return VK_FORMAT_BC7_SRGB_BLOCK;
    default:
        return VK_FORMAT_UNDEFINED;
    }
}

/** A create info and what it points to; must not be moved. */
struct image_info {
    VkImageCreateInfo info;
    VkImageFormatListCreateInfo list;
    VkFormat formats[2];
    uint32_t families[GPU_QUEUE_COUNT];
};

static void describe_image(const gpu_device *device, const struct gpu_image_params *params, struct image_info *out) {
    *out = (struct image_info){
        .info =
            {
                .sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO,
                .flags = params->cube ? VK_IMAGE_CREATE_CUBE_COMPATIBLE_BIT : 0,
                .imageType = VK_IMAGE_TYPE_2D,
                .format = params->format,
                .extent = {params->width, params->height, 1},
                .mipLevels = params->mips,
                .arrayLayers = params->layers,
                .samples = (VkSampleCountFlagBits)params->samples,
                .tiling = VK_IMAGE_TILING_OPTIMAL,
                .usage = params->usage,
                .pQueueFamilyIndices = out->families,
            },
    };
    gpu_sharing(device, &out->info.sharingMode, &out->info.queueFamilyIndexCount, out->families);
    if (stores_blocks(params))
        out->info.flags |= VK_IMAGE_CREATE_BLOCK_TEXEL_VIEW_COMPATIBLE_BIT | VK_IMAGE_CREATE_MUTABLE_FORMAT_BIT | VK_IMAGE_CREATE_EXTENDED_USAGE_BIT;
    if (params->srgb_view) {
        /* The image itself is sRGB, so that blits between its mips average linear light. */
        out->formats[0] = srgb_format(params->format);
        out->formats[1] = params->format;
        out->list = (VkImageFormatListCreateInfo){
            .sType = VK_STRUCTURE_TYPE_IMAGE_FORMAT_LIST_CREATE_INFO,
            .viewFormatCount = 2,
            .pViewFormats = out->formats,
        };
        out->info.pNext = &out->list;
        out->info.flags |= VK_IMAGE_CREATE_MUTABLE_FORMAT_BIT;
        out->info.format = out->formats[0];
    }
}

static fnl_result check_params(gpu_device *device, const struct gpu_image_params *params) {
    const fnl_host *host = &device->host;
    REQUIRE(host, params->name != NULL);
    REQUIRE(host, params->width >= 1 && params->height >= 1);
    REQUIRE(host, params->layers >= 1 && params->mips >= 1);
    REQUIRE(host, params->samples == 1 || params->samples == 2 || params->samples == 4 || params->samples == 8);
    REQUIRE(host, !params->cube || (params->layers == 6 && params->width == params->height));
    REQUIRE(host, !params->srgb_view || srgb_format(params->format) != VK_FORMAT_UNDEFINED);
    REQUIRE(host, !params->srgb_view || !(params->usage & VK_IMAGE_USAGE_STORAGE_BIT)); /* no sRGB format can be stored to */
    REQUIRE(host, params->mips == 1 || (MAX(params->width, params->height) >> (params->mips - 1)) >= 1);
    return FNL_OK;
}

static fnl_result check_support(gpu_device *device, const struct gpu_image_params *params, const VkImageCreateInfo *info) {
    VkPhysicalDeviceImageFormatInfo2 query = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_IMAGE_FORMAT_INFO_2,
        .pNext = info->pNext,
        .format = info->format,
        .type = info->imageType,
        .tiling = info->tiling,
        .usage = info->usage,
        .flags = info->flags,
    };
    VkImageFormatProperties2 properties = {.sType = VK_STRUCTURE_TYPE_IMAGE_FORMAT_PROPERTIES_2};
    VkResult result = device->instance.vk.GetPhysicalDeviceImageFormatProperties2(device->physical, &query, &properties);
    TRY(gpu_check(device, result, "'%s': an image of VkFormat %d with usage 0x%x", params->name, (int)params->format,
                  params->usage));
    const VkImageFormatProperties *limits = &properties.imageFormatProperties;
    if (params->width > limits->maxExtent.width || params->height > limits->maxExtent.height ||
        params->mips > limits->maxMipLevels || params->layers > limits->maxArrayLayers ||
        !(params->samples & limits->sampleCounts)) {
        log_error(&device->host,
                  "'%s': %ux%u with %u layers, %u mips and %u samples is more than the device can have of this format "
                  "(%ux%u, %u layers, %u mips, samples 0x%x)",
                  params->name, params->width, params->height, params->layers, params->mips, params->samples,
                  limits->maxExtent.width, limits->maxExtent.height, limits->maxArrayLayers, limits->maxMipLevels,
                  limits->sampleCounts);
        return FNL_ERROR_UNSUPPORTED;
    }
    return FNL_OK;
}

static VkMemoryRequirements image_requirements(gpu_device *device, const VkImageCreateInfo *info) {
    VkDeviceImageMemoryRequirements query = {
        .sType = VK_STRUCTURE_TYPE_DEVICE_IMAGE_MEMORY_REQUIREMENTS,
        .pCreateInfo = info,
    };
    VkMemoryRequirements2 requirements = {.sType = VK_STRUCTURE_TYPE_MEMORY_REQUIREMENTS_2};
    device->vk.GetDeviceImageMemoryRequirements(device->handle, &query, &requirements);
    return requirements.memoryRequirements;
}

struct gpu_requirements gpu_image_requirements(gpu_device *device, const struct gpu_image_params *params) {
    struct image_info info;
    describe_image(device, params, &info);
    VkMemoryRequirements requirements = image_requirements(device, &info.info);
    uint64_t granularity = device->memory.granularity;
    return (struct gpu_requirements){align_up(requirements.size, granularity), MAX(requirements.alignment, granularity),
                                     requirements.memoryTypeBits};
}

/* ---- views and indices ---- */

struct view_params {
    VkImageViewType type;
    VkFormat format;
    uint32_t mips;
    VkImageUsageFlags usage;
};

static fnl_result create_view(gpu_device *device, const struct gpu_image *image, const struct view_params *view,
                              VkImageView *out) {
    VkImageViewUsageCreateInfo usage = {.sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_USAGE_CREATE_INFO, .usage = view->usage};
    VkImageAspectFlags aspect = gpu_format_aspect(view->format);
    VkImageViewCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO,
        .pNext = &usage,
        .image = image->handle,
        .viewType = view->type,
        .format = view->format,
        .subresourceRange = {view->usage & VK_IMAGE_USAGE_SAMPLED_BIT && aspect & VK_IMAGE_ASPECT_DEPTH_BIT
                                 ? VK_IMAGE_ASPECT_DEPTH_BIT
                                 : aspect,
                             image->first_mip, view->mips, image->first_layer, image->params.layers},
    };
    VkResult result = device->vk.CreateImageView(device->handle, &info, NULL, out);
    TRY(gpu_check(device, result, "'%s': vkCreateImageView", image->params.name));
    gpu_name(device, VK_OBJECT_TYPE_IMAGE_VIEW, (uint64_t)*out, image->params.name);
    return FNL_OK;
}

VkImageUsageFlags gpu_view_usage(VkImageUsageFlags usage) {
    return usage & (VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT |
                    VK_IMAGE_USAGE_INPUT_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSIENT_ATTACHMENT_BIT |
                    VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_STORAGE_BIT);
}

/** The views: [0] all, [1] attachment and storage, [2] sRGB. */
static fnl_result create_views(gpu_device *device, struct gpu_image *image, VkImageView views[3]) {
    const struct gpu_image_params *params = &image->params;
    const VkImageUsageFlags attachment = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT;
    VkImageUsageFlags viewable = gpu_view_usage(params->usage);
    if (stores_blocks(params)) viewable &= ~(VkImageUsageFlags)VK_IMAGE_USAGE_STORAGE_BIT; /* views of its parts have it */
    if (!viewable) return FNL_OK; /* only copied */

    VkImageViewType flat = params->layers > 1 ? VK_IMAGE_VIEW_TYPE_2D_ARRAY : VK_IMAGE_VIEW_TYPE_2D;
    struct view_params whole = {params->cube ? VK_IMAGE_VIEW_TYPE_CUBE : flat, params->format, params->mips, viewable};
    if (params->cube) whole.usage &= ~(VkImageUsageFlags)VK_IMAGE_USAGE_STORAGE_BIT;
    if (params->mips > 1) whole.usage &= ~attachment;
    bool shared = params->mips == 1 && !params->cube;
    if (shared || whole.usage) TRY(create_view(device, image, &whole, &views[0]));
    image->view = image->attachment_view = views[0];
    if (!shared && (viewable & (attachment | VK_IMAGE_USAGE_STORAGE_BIT))) {
        struct view_params first = {flat, params->format, 1, viewable};
        TRY(create_view(device, image, &first, &views[1]));
        image->attachment_view = views[1];
        if (!image->view) image->view = views[1];
    }
    if (params->usage & VK_IMAGE_USAGE_SAMPLED_BIT) {
        bool depth = gpu_format_aspect(params->format) & VK_IMAGE_ASPECT_DEPTH_BIT;
        VkImageLayout layout = depth ? VK_IMAGE_LAYOUT_DEPTH_READ_ONLY_OPTIMAL : VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL;
        TRY(gpu_bindless_add(device, GPU_BINDING_SAMPLED, image->view, layout, &image->sampled_index));
        if (params->srgb_view) {
            struct view_params srgb = {whole.type, srgb_format(params->format), params->mips, VK_IMAGE_USAGE_SAMPLED_BIT};
            TRY(create_view(device, image, &srgb, &views[2]));
            TRY(gpu_bindless_add(device, GPU_BINDING_SAMPLED, views[2], layout, &image->srgb_index));
        }
    }
    if (viewable & VK_IMAGE_USAGE_STORAGE_BIT)
        TRY(gpu_bindless_add(device, GPU_BINDING_STORAGE, image->attachment_view, VK_IMAGE_LAYOUT_GENERAL,
                             &image->storage_index));
    return FNL_OK;
}

/* ---- making and freeing ---- */

static struct gpu_retired retired_image(const struct gpu_image *image) {
    return (struct gpu_retired){
        .image = image->imported ? VK_NULL_HANDLE : image->handle,
        .views = {image->view, image->attachment_view == image->view ? VK_NULL_HANDLE : image->attachment_view,
                  image->srgb_view},
        .sampled_index = image->sampled_index,
        .storage_index = image->storage_index,
        .srgb_index = image->srgb_index,
        .allocation = image->allocation,
    };
}

static struct gpu_image empty_image(void) {
    return (struct gpu_image){.sampled_index = GPU_NO_INDEX, .storage_index = GPU_NO_INDEX, .srgb_index = GPU_NO_INDEX};
}

/** The whole way of all three kinds: a handle (given, or made here), its memory (heap, own, or the caller's), its views. */
static fnl_result make_image(gpu_device *device, const struct gpu_heap *heap, uint64_t offset, struct gpu_image *image) {
    const char *name = image->params.name;
    VkImageView views[3] = {0};
    if (!image->imported) {
        struct image_info info;
        describe_image(device, &image->params, &info);
        TRY(check_support(device, &image->params, &info.info));
        VkResult result = device->vk.CreateImage(device->handle, &info.info, NULL, &image->handle);
        TRY(gpu_check(device, result, "'%s': vkCreateImage", name));
        gpu_name(device, VK_OBJECT_TYPE_IMAGE, (uint64_t)image->handle, name);
        VkDeviceMemory memory = heap ? heap->memory : VK_NULL_HANDLE;
        if (!heap) {
            VkMemoryRequirements requirements = image_requirements(device, &info.info);
            TRY(gpu_memory_allocate(device, name, &requirements, GPU_MEMORY_DEVICE, image->params.use, true, &image->allocation,
                                    &memory, NULL));
            image->owns_memory = true;
            offset = image->allocation.offset;
        }
        result = device->vk.BindImageMemory(device->handle, image->handle, memory, offset);
        TRY(gpu_check(device, result, "'%s': vkBindImageMemory", name));
    }
    fnl_result result = create_views(device, image, views);
    image->srgb_view = views[2];
    return result;
}

static fnl_result start_image(gpu_device *device, VkImage handle, uint32_t first_layer, uint32_t first_mip, const struct gpu_heap *heap,
                              uint64_t offset, const struct gpu_image_params *params, struct gpu_image *out) {
    *out = empty_image();
    TRY(check_params(device, params));
    if (!gpu_retire_reserve(device)) return FNL_ERROR_MEMORY;
    out->params = *params;
    out->handle = handle;
    out->first_layer = first_layer;
    out->first_mip = first_mip;
    out->imported = handle != VK_NULL_HANDLE;
    fnl_result result = make_image(device, heap, offset, out);
    if (result != FNL_OK) {
        struct gpu_retired item = retired_image(out);
        gpu_retired_free(device, &item);
        gpu_retire_cancel(device);
        *out = empty_image();
    }
    return result;
}

fnl_result gpu_image_create(gpu_device *device, const struct gpu_image_params *params, struct gpu_image *out) {
    return start_image(device, VK_NULL_HANDLE, 0, 0, NULL, 0, params, out);
}

fnl_result gpu_image_create_in(gpu_device *device, const struct gpu_heap *heap, uint64_t offset,
                               const struct gpu_image_params *params, struct gpu_image *out) {
    return start_image(device, VK_NULL_HANDLE, 0, 0, heap, offset, params, out);
}

fnl_result gpu_image_import(gpu_device *device, VkImage handle, const struct gpu_image_params *params,
                            struct gpu_image *out) {
    *out = empty_image();
    REQUIRE(&device->host, handle != VK_NULL_HANDLE);
    REQUIRE(&device->host, !params->srgb_view);
    return start_image(device, handle, 0, 0, NULL, 0, params, out);
}

fnl_result gpu_image_layer(gpu_device *device, const struct gpu_image *image, uint32_t layer, struct gpu_image *out) {
    *out = empty_image();
    REQUIRE(&device->host, layer < image->params.layers && !image->params.srgb_view);
    struct gpu_image_params params = image->params;
    params.layers = 1;
    params.cube = false;
    return start_image(device, image->handle, image->first_layer + layer, image->first_mip, NULL, 0, &params, out);
}

fnl_result gpu_image_part(gpu_device *device, const struct gpu_image *image, uint32_t layer, uint32_t mip, bool as_blocks,
                          struct gpu_image *out) {
    *out = empty_image();
    REQUIRE(&device->host, layer < image->params.layers && mip < image->params.mips && !image->params.srgb_view);
    REQUIRE(&device->host, !as_blocks || stores_blocks(&image->params));
    struct gpu_image_params params = image->params;
    params.layers = params.mips = 1;
    params.width = MAX(params.width >> mip, 1u);
    params.height = MAX(params.height >> mip, 1u);
    params.cube = false;
    if (as_blocks) {
        params.format = VK_FORMAT_R32G32B32A32_UINT;
        params.width = DIVIDE_UP(params.width, 4u);
        params.height = DIVIDE_UP(params.height, 4u);
        params.usage = VK_IMAGE_USAGE_STORAGE_BIT;
    }
    return start_image(device, image->handle, image->first_layer + layer, image->first_mip + mip, NULL, 0, &params, out);
}

bool gpu_block_stores_supported(gpu_device *device, VkFormat format) {
    struct gpu_image_params params = {.format = format,
                                      .width = 4,
                                      .height = 4,
                                      .layers = 6,
                                      .mips = 1,
                                      .samples = 1,
                                      .cube = true,
                                      .usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_STORAGE_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT};
    struct image_info info;
    describe_image(device, &params, &info);
    VkPhysicalDeviceImageFormatInfo2 query = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_IMAGE_FORMAT_INFO_2,
                                              .format = format,
                                              .type = VK_IMAGE_TYPE_2D,
                                              .usage = params.usage,
                                              .flags = info.info.flags};
    VkImageFormatProperties2 properties = {.sType = VK_STRUCTURE_TYPE_IMAGE_FORMAT_PROPERTIES_2};
    return device->info.texture_compression &&
           device->instance.vk.GetPhysicalDeviceImageFormatProperties2(device->physical, &query, &properties) == VK_SUCCESS;
}

void gpu_image_destroy(gpu_device *device, struct gpu_image *image) {
    if (image->handle) {
        struct gpu_retired item = retired_image(image);
        gpu_last_use_remove(&device->last_uses, true, (uint64_t)image->handle);
        gpu_retire(device, &item);
    }
    *image = empty_image();
}
