/* SPDX-License-Identifier: MIT */
/** Metalness of textures, grown beyond its edges. */
#include "image/image.h"
#include "scene/scene.h"

static uint32_t beside(int64_t at, uint32_t side, bool repeats) {
    if (repeats) return (uint32_t)((at % side + side) % side);
    return (uint32_t)CLAMP(at, 0, (int64_t)side - 1);
}

/* The greatest blue of a square round each texel, first along rows and then along columns. `rows` has room for one channel. */
static void grow(uint8_t *pixels, uint32_t width, uint32_t height, uint32_t texels, bool repeats_u, bool repeats_v,
                 uint8_t *rows) {
    const int64_t reach = texels;
    for (uint32_t y = 0; y < height; y++)
        for (uint32_t x = 0; x < width; x++) {
            uint8_t most = 0;
            for (int64_t d = -reach; d <= reach; d++)
                most = MAX(most, pixels[4 * ((size_t)y * width + beside(x + d, width, repeats_u)) + 2]);
            rows[(size_t)y * width + x] = most;
        }
    for (uint32_t y = 0; y < height; y++)
        for (uint32_t x = 0; x < width; x++) {
            uint8_t most = 0;
            for (int64_t d = -reach; d <= reach; d++)
                most = MAX(most, rows[(size_t)beside(y + d, height, repeats_v) * width + x]);
            pixels[4 * ((size_t)y * width + x) + 2] = most;
        }
}

static fnl_result grow_image(fnl_scene *scene, uint32_t index, uint32_t texels, const struct scene_sampler *sampler) {
    struct scene_image *image = &scene->images.data[index];
    if (!image->pixels && image->encoded) {
        fnl_image decoded;
        if (image_decode(&scene->host, image->encoded, image->encoded_size, image->name, true, &decoded) != FNL_OK)
            return FNL_OK; /* it said so, and renders as white */
        image->pixels = arena_copy(&scene->arena, decoded.pixels, (size_t)decoded.width * decoded.height * 4);
        image->width = decoded.width;
        image->height = decoded.height;
        fnl_image_free(&scene->host, &decoded);
        if (!image->pixels) return FNL_ERROR_MEMORY;
    }
    if (!image->pixels) return FNL_OK;
    size_t size = (size_t)image->width * image->height;
    uint8_t *rows = host_allocate(&scene->host, size);
    if (!rows) return FNL_ERROR_MEMORY;
    grow(image->pixels, image->width, image->height, texels, sampler->wrap_u == SCENE_WRAP_REPEAT,
         sampler->wrap_v == SCENE_WRAP_REPEAT, rows);
    host_free(&scene->host, rows, size);
    image->version++;
    return FNL_OK;
}

fnl_result fnl_scene_grow_metal(fnl_scene *scene, uint32_t texels) {
    TRY(check_handle(__func__, "scene", scene));
    TRY(check_count(CALL(&scene->host), "texels", texels, 0, 64));
    bool *done = host_allocate_zero(&scene->host, MAX(scene->images.count, 1u));
    if (!done) return FNL_ERROR_MEMORY;
    fnl_result result = FNL_OK;
    for (uint32_t i = 0; i < scene->materials.count && result == FNL_OK && texels; i++) {
        const struct scene_texture *texture = &scene->materials.data[i].textures[SCENE_TEXTURE_METALLIC_ROUGHNESS];
        if (texture->image == SCENE_NONE || done[texture->image]) continue;
        done[texture->image] = true;
        result = grow_image(scene, texture->image, texels, &scene->samplers.data[texture->sampler]);
    }
    host_free(&scene->host, done, MAX(scene->images.count, 1u));
    scene_materials_changed(scene);
    return result;
}
