/* SPDX-License-Identifier: MIT */
#include "image/image.h"
#include "render/device/scene.h"

enum { BATCH = 16 }; /* decoded at once: bounds the memory that waits for upload */

struct decode {
    struct device_scene *d;
    uint32_t indices[BATCH];
    fnl_image pixels[BATCH];
    fnl_result results[BATCH];
};

static void decode_one(void *context, uint32_t i) {
    struct decode *decode = context;
    const struct scene_image *image = &decode->d->scene->images.data[decode->indices[i]];
    decode->results[i] =
        image_decode(&decode->d->host, image->encoded, image->encoded_size, image->name, true, &decode->pixels[i]);
}

static uint32_t mip_count(uint32_t width, uint32_t height) {
    uint32_t count = 1;
    for (uint32_t side = MAX(width, height); side > 1; side /= 2) count++;
    return count;
}

static int16_t common_blue(const uint8_t *pixels, uint64_t count) {
    for (uint64_t i = 1; i < count; i++)
        if (pixels[4 * i + 2] != pixels[2]) return -1;
    return pixels[2];
}

static fnl_result upload_one(struct device_scene *d, uint32_t index, uint32_t width, uint32_t height, const void *pixels) {
    const struct scene_image *image = &d->scene->images.data[index];
    struct gpu_image_params params = {.name = image->name ? image->name : "image",
                                      .format = VK_FORMAT_R8G8B8A8_UNORM,
                                      .width = width,
                                      .height = height,
                                      .layers = 1,
                                      .mips = mip_count(width, height),
                                      .samples = 1,
                                      .srgb_view = image->color,
                                      .usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT |
                                               VK_IMAGE_USAGE_TRANSFER_DST_BIT};
    TRY(gpu_image_create(d->device, &params, &d->images.data[index]));
    d->image_upload_count++;
    d->bytes_uploaded += (uint64_t)width * height * 4;
    d->image_versions.data[index] = image->version;
    d->image_blues.data[index] = common_blue(pixels, (uint64_t)width * height);
    return gpu_upload_image(d->device, &d->images.data[index], pixels, (uint64_t)width * height * 4, true, image->color);
}

/* A broken image was reported by the decoder; the material goes on without it. */
static fnl_result upload_batch(struct decode *decode, uint32_t count, struct jobs *jobs) {
    jobs_parallel_for(jobs, count, decode_one, decode);
    fnl_result result = FNL_OK;
    for (uint32_t i = 0; i < count; i++) {
        if (decode->results[i] == FNL_ERROR_MEMORY && result == FNL_OK) result = FNL_ERROR_MEMORY;
        if (decode->results[i] == FNL_OK && result == FNL_OK)
            result = upload_one(decode->d, decode->indices[i], decode->pixels[i].width, decode->pixels[i].height,
                                decode->pixels[i].pixels);
        if (decode->results[i] == FNL_OK) fnl_image_free(&decode->d->host, &decode->pixels[i]);
    }
    return result;
}

fnl_result device_images_upload(struct device_scene *d, struct jobs *jobs) {
    const fnl_scene *scene = d->scene;
    if (!array_reserve(&d->host, &d->images, scene->images.count)) return FNL_ERROR_MEMORY;
    if (!array_reserve(&d->host, &d->image_blues, scene->images.count)) return FNL_ERROR_MEMORY;
    if (!array_reserve(&d->host, &d->image_versions, scene->images.count)) return FNL_ERROR_MEMORY;
    for (uint32_t i = d->images.count; i < scene->images.count; i++) { /* scenes lose none */
        d->images.data[i] = (struct gpu_image){0};
        d->image_blues.data[i] = -1;
    }
    d->images.count = d->image_blues.count = d->image_versions.count = scene->images.count;

    bool *used = host_allocate_zero(&d->host, MAX(scene->images.count, 1u));
    if (!used) return FNL_ERROR_MEMORY;
    for (uint32_t m = 0; m < scene->materials.count; m++)
        for (int slot = 0; slot < SCENE_TEXTURE_SLOT_COUNT; slot++) {
            uint32_t image = scene->materials.data[m].textures[slot].image;
            if (image != SCENE_NONE) used[image] = true;
        }
    struct decode decode = {.d = d};
    uint32_t count = 0;
    fnl_result result = FNL_OK;
    for (uint32_t i = 0; i < scene->images.count && result == FNL_OK; i++) {
        const struct scene_image *image = &scene->images.data[i];
        if (d->images.data[i].handle && d->image_versions.data[i] != image->version)
            gpu_image_destroy(d->device, &d->images.data[i]);
        if (!used[i] || d->images.data[i].handle || image->width == 0 || image->height == 0) continue;
        if (image->pixels) {
            result = upload_one(d, i, image->width, image->height, image->pixels);
        } else if (image->encoded) {
            decode.indices[count++] = i;
            if (count == BATCH) {
                result = upload_batch(&decode, count, jobs);
                count = 0;
            }
        }
    }
    if (count && result == FNL_OK) result = upload_batch(&decode, count, jobs);
    host_free(&d->host, used, MAX(scene->images.count, 1u));
    return result;
}
