/* SPDX-License-Identifier: MIT */
/** The scene's pictures on the CPU, sampled as GPUs do it: mips of 8 bits, linear filtering, anisotropy. */
#ifndef FNL_RAY_TEXTURE_H
#define FNL_RAY_TEXTURE_H

#include "base/jobs.h"
#include "scene/scene.h"

enum { RAY_LEVELS_MAX = 16 };

struct ray_image {
    uint8_t *pixels; /* RGBA8, all levels one behind the other; NULL: the picture is missing or broken, and white */
    size_t size;
    uint32_t level_count, width, height;
    size_t levels[RAY_LEVELS_MAX]; /* where they begin, bytes */
    bool color;
};

/** Where a texture is sampled: coordinates of both sets, and how they change to the next pixel right and down (0: level 0 is sampled). */
struct ray_uv {
    double at[2][2], along[2][2], across[2][2];
};

/** Decodes those that materials use; FNL_ERROR_MEMORY is the only error: broken ones are logged. `count` images; freed by the caller. */
fnl_result ray_images_create(const fnl_scene *scene, struct jobs *jobs, struct ray_image **out);
void ray_images_destroy(const fnl_scene *scene, struct ray_image **images);

/** The texel of a material's slot as RGBA, white without a texture; RGB of colour slots is decoded from sRGB. */
void ray_texture_sample(const fnl_scene *scene, const struct ray_image *images, const struct scene_material *material,
                        enum scene_texture_slot slot, const struct ray_uv *uv, double out[4]);
bool ray_texture_exists(const struct ray_image *images, const struct scene_material *material, enum scene_texture_slot slot);

#endif
