/* SPDX-License-Identifier: MIT */
#include "image/image.h"
#include "render/device/scene.h"

enum { BATCH = 16 }; /* decoded at once: bounds the memory that waits for upload */

static uint32_t mip_count(uint32_t width, uint32_t height) {
    uint32_t count = 1;
    for (uint32_t side = MAX(width, height); side > 1; side /= 2) count++;
    return count;
}

/* Formats of files that the device may sample as they are. Those of one or two channels have none for colours. */
static const struct {
    enum texture_format format;
    VkFormat vulkan;
    bool data_only;
} block_formats[] = {
    {TEXTURE_BC1, VK_FORMAT_BC1_RGB_UNORM_BLOCK, false}, {TEXTURE_BC1_ALPHA, VK_FORMAT_BC1_RGBA_UNORM_BLOCK, false},
    {TEXTURE_BC3, VK_FORMAT_BC3_UNORM_BLOCK, false},     {TEXTURE_BC4, VK_FORMAT_BC4_UNORM_BLOCK, true},
    {TEXTURE_BC5, VK_FORMAT_BC5_UNORM_BLOCK, true},      {TEXTURE_BC7, VK_FORMAT_BC7_UNORM_BLOCK, false},
};

static VkFormat vulkan_format(enum texture_format format) {
    for (uint32_t i = 0; i < COUNT_OF(block_formats); i++)
        if (block_formats[i].format == format) return block_formats[i].vulkan;
    return VK_FORMAT_R8G8B8A8_UNORM;
}

/* Bits of enum texture_format. */
static uint32_t kept_formats(const struct device_scene *d, const struct scene_image *image) {
    uint32_t bits = 0;
    for (uint32_t i = 0; gpu_info(d->device)->texture_compression && i < COUNT_OF(block_formats); i++)
        if (!(image->color && block_formats[i].data_only) &&
            gpu_format_supports(d->device, block_formats[i].vulkan, VK_FORMAT_FEATURE_2_SAMPLED_IMAGE_FILTER_LINEAR_BIT | VK_FORMAT_FEATURE_2_TRANSFER_DST_BIT))
            bits |= 1u << block_formats[i].format;
    return bits;
}

/* `blocks`: those that the device samples may stay. */
static struct texture_use use_of(const struct device_scene *d, const struct scene_image *image, bool blocks) {
    return (struct texture_use){.mips = true, .normals = image->normals, .keep = blocks ? kept_formats(d, image) : 0};
}

static fnl_result create_image(struct device_scene *d, uint32_t index, const struct texture *texture, struct gpu_image *out) {
    const struct scene_image *image = &d->scene->images.data[index];
    struct gpu_image_params params = {.name = image->name ? image->name : "image",
                                      .format = vulkan_format(texture->format),
                                      .width = texture->width,
                                      .height = texture->height,
                                      .layers = 1,
                                      .mips = mip_count(texture->width, texture->height),
                                      .samples = 1,
                                      .srgb_view = image->color,
                                      .use = GPU_USE_TEXTURES,
                                      .usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT};
    if (texture->format == TEXTURE_RGBA8) params.usage |= VK_IMAGE_USAGE_TRANSFER_SRC_BIT; /* mips are made by blits */
    return gpu_image_create(d->device, &params, out);
}

/* Rows of a mip. Where the file has no smaller mips they are made. */
static fnl_result send_rows(struct device_scene *d, const struct gpu_image *gpu, const struct texture *texture, uint32_t mip, uint32_t first, uint32_t count) {
    const struct gpu_image_params *params = &gpu->params;
    const uint64_t size = texture_face_bytes(texture, mip);
    const unsigned char *pixels = texture->bytes + texture_offset(texture, mip, 0);
    d->bytes_uploaded += size / gpu_mip_rows(gpu, mip) * count;
    if (texture->mips < params->mips) return gpu_upload_image_rows(d->device, gpu, pixels, size, first, count, true, params->srgb_view);
    return gpu_upload_image_mip(d->device, gpu, mip, pixels, size, first, count);
}

/* All its rows are sent. */
static void put_image(struct device_scene *d, uint32_t index, const struct gpu_image *gpu, const struct texture *texture) {
    struct device_image *own = &d->images.data[index];
    own->gpu = *gpu;
    own->version = d->scene->images.data[index].version;
    own->blue = texture_common_blue(texture);
    d->image_upload_count++;
}

static fnl_result upload_one(struct device_scene *d, uint32_t index, const struct texture *texture) {
    struct gpu_image gpu;
    TRY(create_image(d, index, texture, &gpu));
    put_image(d, index, &gpu, texture);
    for (uint32_t mip = 0; mip < texture->mips; mip++) TRY(send_rows(d, &gpu, texture, mip, 0, gpu_mip_rows(&gpu, mip)));
    return FNL_OK;
}

/* A material goes on without a broken one. */
static fnl_result deliver(struct device_scene *d, uint32_t index, const struct texture *texture) {
    if (texture) return upload_one(d, index, texture);
    d->images.data[index].broken = true;
    return FNL_OK;
}

/* ---- now ---- */

struct decode {
    const struct device_scene *d;
    const uint32_t *indices;
    bool blocks;
    struct texture textures[BATCH];
    fnl_result results[BATCH];
};

static void decode_one(void *context, uint32_t i) {
    struct decode *decode = context;
    const struct scene_image *image = &decode->d->scene->images.data[decode->indices[i]];
    const struct texture_use use = use_of(decode->d, image, decode->blocks);
    decode->results[i] = texture_decode(&decode->d->host, image->encoded, image->encoded_size, image->name, &use, &decode->textures[i]);
}

fnl_result device_images_decode(struct device_scene *d, const uint32_t *images, uint32_t count, bool blocks, device_image_deliver *to) {
    fnl_result result = FNL_OK;
    for (uint32_t first = 0; first < count && result == FNL_OK; first += BATCH) {
        struct decode decode = {.d = d, .indices = images + first, .blocks = blocks};
        uint32_t batch = MIN(count - first, (uint32_t)BATCH);
        jobs_parallel_for(gpu_jobs(d->device), batch, decode_one, &decode);
        for (uint32_t i = 0; i < batch; i++) {
            bool decoded = decode.results[i] == FNL_OK;
            if (decode.results[i] == FNL_ERROR_MEMORY && result == FNL_OK) result = FNL_ERROR_MEMORY;
            if (result == FNL_OK) result = to(d, images[first + i], decoded ? &decode.textures[i] : NULL);
            if (decoded) texture_free(&d->host, &decode.textures[i]);
        }
    }
    return result;
}

/* ---- in the background ---- */

fnl_result device_image_ask(struct device_scene *d, uint32_t index) {
    const struct scene_image *image = &d->scene->images.data[index];
    struct device_image *own = &d->images.data[index];
    if (own->coming) return FNL_OK;
    uint32_t threads = jobs_thread_count(gpu_jobs(d->device)); /* one stays free for frames */
    if (!d->image_queue) {
        TRY(image_queue_create(&d->host, MAX(threads, 2u) - 1, &d->image_queue));
        atomic_fetch_add(&d->scene->readers, 1);
    }
    const struct image_request request = {.id = index,
                                          .bytes = image->encoded,
                                          .size = image->encoded_size,
                                          .name = image->name,
                                          .pixel_bytes = (uint64_t)image->width * image->height * 4,
                                          .use = use_of(d, image, own->used && !own->gpu.handle)};
    TRY(image_queue_ask(d->image_queue, &request));
    own->version = image->version;
    own->coming = true;
    d->images_coming++;
    return FNL_OK;
}

static void arrived(struct device_scene *d, struct device_image *own) {
    d->images_coming -= own->coming;
    own->coming = false;
}

/* Waits for those that are being decoded. */
static void close_queue(struct device_scene *d) {
    if (d->image_queue) atomic_fetch_sub(&d->scene->readers, 1);
    image_queue_destroy(&d->image_queue);
}

/* Sends what there is room for; false: some rows are missing. */
static fnl_result send_arrival(struct device_scene *d, uint64_t *room, bool *out_whole) {
    struct device_arrival *a = &d->arrival;
    const struct texture *texture = &a->answer.texture;
    const struct device_image *own = &d->images.data[a->answer.id];
    *out_whole = true;
    if (a->answer.result != FNL_OK) return FNL_OK;
    if (!own->used || own->gpu.handle) { /* pictures of decals are small, and go at once */
        *room -= MIN(*room, texture_face_bytes(texture, 0));
        return FNL_OK;
    }
    if (!a->gpu.handle) TRY(create_image(d, a->answer.id, texture, &a->gpu));
    while (a->mip < texture->mips && *room > 0) {
        const uint32_t rows = gpu_mip_rows(&a->gpu, a->mip);
        const uint64_t row_bytes = texture_face_bytes(texture, a->mip) / rows;
        const uint32_t count = (uint32_t)MIN(rows - a->row_count, MAX(*room / row_bytes, 1));
        TRY(send_rows(d, &a->gpu, texture, a->mip, a->row_count, count));
        a->row_count += count;
        *room -= MIN(*room, count * row_bytes);
        if (a->row_count == rows) {
            a->row_count = 0;
            a->mip++;
        }
    }
    *out_whole = a->mip == texture->mips;
    return FNL_OK;
}

static void end_arrival(struct device_scene *d) {
    struct device_arrival *a = &d->arrival;
    if (a->gpu.handle) gpu_image_destroy(d->device, &a->gpu);
    if (a->busy && a->answer.result == FNL_OK) texture_free(&d->host, &a->answer.texture);
    *a = (struct device_arrival){0};
}

static fnl_result put_arrival(struct device_scene *d) {
    struct device_arrival *a = &d->arrival;
    const uint32_t index = a->answer.id;
    struct device_image *own = &d->images.data[index];
    const struct texture *texture = a->answer.result == FNL_OK ? &a->answer.texture : NULL;
    arrived(d, own);
    if (a->answer.result == FNL_ERROR_MEMORY) return FNL_ERROR_MEMORY;
    if (!texture) d->texture_version++; /* the textures that were expected are none */
    if (a->gpu.handle && own->used) {
        put_image(d, index, &a->gpu, texture);
        a->gpu = (struct gpu_image){0};
    }
    return device_decals_deliver(d, index, texture);
}

static fnl_result show_arrivals(struct device_scene *d) {
    bool regroup;
    d->image_arrivals++;
    TRY(gpu_upload_submit(d->device)); /* this frame may have sent materials before: only submissions are ordered */
    TRY(device_materials_upload(d, &regroup));
    if (!regroup) return FNL_OK;
    TRY(device_items_upload(d));
    return device_table_send(d);
}

fnl_result device_images_take(struct device_scene *d) {
    struct device_arrival *a = &d->arrival;
    bool any = false;
    if (!d->image_queue) return FNL_OK;
    for (uint64_t room = DEVICE_IMAGE_BYTES; room > 0;) {
        bool whole;
        if (!a->busy) a->busy = image_queue_take(d->image_queue, &a->answer);
        if (!a->busy) break;
        if (!d->images.data[a->answer.id].coming) { /* the scene has given it other pixels since */
            end_arrival(d);
            continue;
        }
        TRY(send_arrival(d, &room, &whole));
        if (!whole) break;
        fnl_result result = put_arrival(d);
        end_arrival(d);
        TRY(result);
        any = true;
    }
    if (d->images_coming == 0) {
        end_arrival(d);
        close_queue(d);
    }
    return any ? show_arrivals(d) : FNL_OK;
}

void device_images_free(struct device_scene *d) {
    end_arrival(d);
    close_queue(d);
    for (uint32_t i = 0; i < d->images.count; i++)
        if (d->images.data[i].gpu.handle) gpu_image_destroy(d->device, &d->images.data[i].gpu);
    d->images.count = d->images_coming = 0;
}

/* ---- what materials use ---- */

static void find_used(struct device_scene *d) {
    const fnl_scene *scene = d->scene;
    for (uint32_t i = 0; i < d->images.count; i++) d->images.data[i].used = false;
    for (uint32_t m = 0; m < scene->materials.count; m++)
        for (int slot = 0; slot < SCENE_TEXTURE_SLOT_COUNT; slot++) {
            uint32_t image = scene->materials.data[m].textures[slot].image;
            if (image != SCENE_NONE) d->images.data[image].used = true;
        }
}

static void free_image(struct device_scene *d, struct device_image *own) {
    if (own->gpu.handle) gpu_image_destroy(d->device, &own->gpu);
    own->blue = -1;
}

/* The image of before is of no more use. */
static void forget_changed(struct device_scene *d, struct device_image *own, uint32_t version) {
    if (own->version == version) return;
    free_image(d, own);
    arrived(d, own);
    own->broken = false;
    own->version = version;
}

/* Uploads an image, or asks for it, or adds it to `encoded`, of those to be decoded now. */
static fnl_result need_image(struct device_scene *d, uint32_t index, uint32_t *encoded, uint32_t *encoded_count) {
    const struct scene_image *image = &d->scene->images.data[index];
    struct device_image *own = &d->images.data[index];
    forget_changed(d, own, image->version);
    if (!own->used) free_image(d, own);
    if (!own->used || own->gpu.handle || own->broken || image->width == 0 || image->height == 0) return FNL_OK;
    if (image->pixels) {
        const struct texture texture = {
            .format = TEXTURE_RGBA8, .width = image->width, .height = image->height, .faces = 1, .mips = 1, .bytes = image->pixels};
        return upload_one(d, index, &texture);
    }
    if (image->encoded && image->async) return device_image_ask(d, index);
    if (image->encoded) encoded[(*encoded_count)++] = index;
    return FNL_OK;
}

fnl_result device_images_upload(struct device_scene *d) {
    const uint32_t count = d->scene->images.count;
    if (!array_reserve(&d->host, &d->images, count)) return FNL_ERROR_MEMORY;
    for (uint32_t i = d->images.count; i < count; i++) /* scenes lose none */
        d->images.data[i] = (struct device_image){.version = d->scene->images.data[i].version, .blue = -1};
    d->images.count = count;
    find_used(d);
    uint32_t *encoded = host_allocate(&d->host, MAX(count, 1u) * sizeof *encoded), encoded_count = 0;
    if (!encoded) return FNL_ERROR_MEMORY;
    fnl_result result = FNL_OK;
    for (uint32_t i = 0; i < count && result == FNL_OK; i++) result = need_image(d, i, encoded, &encoded_count);
    if (result == FNL_OK) result = device_images_decode(d, encoded, encoded_count, true, deliver);
    host_free(&d->host, encoded, MAX(count, 1u) * sizeof *encoded);
    return result;
}
