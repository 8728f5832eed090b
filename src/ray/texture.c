/* SPDX-License-Identifier: MIT */
#include "ray/texture.h"

#include "image/image.h"

#include <pthread.h>

static double decoded[256]; /* IEC 61966-2-1 */
static void make_decoded(void) {
    for (int i = 0; i < 256; i++) {
        double x = i / 255.0;
        decoded[i] = x <= 0.04045 ? x / 12.92 : pow((x + 0.055) / 1.055, 2.4);
    }
}
static uint8_t encode(double x) {
    double c = x <= 0.0031308 ? 12.92 * x : 1.055 * pow(x, 1 / 2.4) - 0.055;
    return (uint8_t)(CLAMP(c, 0.0, 1.0) * 255 + 0.5);
}

/* ---- levels ---- */

static uint32_t side_at(uint32_t side, uint32_t level) { return MAX(side >> level, 1u); }

/* A level from the one above it, filtered linearly at the middles of its texels, as a blit does it. */
static void make_level(struct ray_image *image, uint32_t level) {
    const uint32_t from_width = side_at(image->width, level - 1), from_height = side_at(image->height, level - 1);
    const uint32_t width = side_at(image->width, level), height = side_at(image->height, level);
    const uint8_t *from = image->pixels + image->levels[level - 1];
    uint8_t *to = image->pixels + image->levels[level];
    for (uint32_t y = 0; y < height; y++) {
        double fy = (y + 0.5) * from_height / height - 0.5;
        uint32_t y0 = (uint32_t)MAX(fy, 0.0), y1 = MIN(y0 + 1, from_height - 1);
        for (uint32_t x = 0; x < width; x++, to += 4) {
            double fx = (x + 0.5) * from_width / width - 0.5, wx = MAX(fx, 0.0), wy = MAX(fy, 0.0);
            uint32_t x0 = (uint32_t)wx, x1 = MIN(x0 + 1, from_width - 1);
            const uint8_t *texels[4] = {from + 4 * ((size_t)y0 * from_width + x0), from + 4 * ((size_t)y0 * from_width + x1),
                                        from + 4 * ((size_t)y1 * from_width + x0),
                                        from + 4 * ((size_t)y1 * from_width + x1)};
            wx -= x0;
            wy -= y0;
            for (int c = 0; c < 4; c++) {
                double t[4];
                for (int k = 0; k < 4; k++) t[k] = image->color && c < 3 ? decoded[texels[k][c]] : texels[k][c] / 255.0;
                double mean = (t[0] * (1 - wx) + t[1] * wx) * (1 - wy) + (t[2] * (1 - wx) + t[3] * wx) * wy;
                to[c] = image->color && c < 3 ? encode(mean) : (uint8_t)(mean * 255 + 0.5);
            }
        }
    }
}

struct load {
    const fnl_scene *scene;
    struct ray_image *images;
    const uint32_t *indices;
    fnl_result *results;
};

static void load_one(void *context, uint32_t i) {
    const struct load *load = context;
    const struct scene_image *source = &load->scene->images.data[load->indices[i]];
    struct ray_image *image = &load->images[load->indices[i]];
    const fnl_host *host = &load->scene->host;
    struct texture pixels = {.format = TEXTURE_RGBA8, .width = source->width, .height = source->height, .faces = 1, .mips = 1, .bytes = source->pixels};
    if (!source->pixels) {
        load->results[i] = texture_decode(host, source->encoded, source->encoded_size, source->name, &(struct texture_use){.mips = true, .normals = source->normals}, &pixels);
        if (load->results[i] != FNL_OK) return;
    }
    *image = (struct ray_image){.width = pixels.width, .height = pixels.height, .color = source->color};
    for (uint32_t side = MAX(image->width, image->height); side && image->level_count < RAY_LEVELS_MAX; side /= 2) {
        image->levels[image->level_count] = image->size;
        image->size += 4 * (size_t)side_at(image->width, image->level_count) * side_at(image->height, image->level_count);
        image->level_count++;
    }
    image->pixels = host_allocate(host, image->size);
    load->results[i] = image->pixels ? FNL_OK : FNL_ERROR_MEMORY;
    if (image->pixels) memcpy(image->pixels, pixels.bytes, texture_offset(&pixels, pixels.mips, 0));
    const uint32_t own = pixels.mips; /* the file has all, or one */
    if (!source->pixels) texture_free(host, &pixels);
    for (uint32_t level = own; image->pixels && level < image->level_count; level++) make_level(image, level);
}

fnl_result ray_images_create(const fnl_scene *scene, struct jobs *jobs, struct ray_image **out) {
    static pthread_once_t once = PTHREAD_ONCE_INIT;
    const fnl_host *host = &scene->host;
    const uint32_t count = scene->images.count;
    pthread_once(&once, make_decoded);
    struct ray_image *images = *out = host_allocate_zero(host, MAX(count, 1u) * sizeof *images);
    size_t size = MAX(count, 1u) * (sizeof(uint32_t) + sizeof(fnl_result) + sizeof(bool));
    uint32_t *indices = host_allocate_zero(host, size), used_count = 0;
    if (!images || !indices) {
        host_free(host, indices, size);
        return FNL_ERROR_MEMORY;
    }
    fnl_result *results = (fnl_result *)(indices + MAX(count, 1u)), result = FNL_OK;
    bool *used = (bool *)(results + MAX(count, 1u));
    for (uint32_t m = 0; m < scene->materials.count; m++)
        for (int slot = 0; slot < SCENE_TEXTURE_SLOT_COUNT; slot++) {
            uint32_t image = scene->materials.data[m].textures[slot].image;
            if (image == SCENE_NONE || used[image] || !scene->images.data[image].width || !scene->images.data[image].height)
                continue;
            used[image] = true;
            if (scene->images.data[image].pixels || scene->images.data[image].encoded) indices[used_count++] = image;
        }
    jobs_parallel_for(jobs, used_count, load_one, &(struct load){scene, images, indices, results});
    for (uint32_t i = 0; i < used_count; i++)
        if (results[i] == FNL_ERROR_MEMORY) result = FNL_ERROR_MEMORY;
    host_free(host, indices, size);
    return result;
}

void ray_images_destroy(const fnl_scene *scene, struct ray_image **handle) {
    struct ray_image *images = *handle;
    if (!images) return;
    for (uint32_t i = 0; i < scene->images.count; i++) host_free(&scene->host, images[i].pixels, images[i].size);
    host_free(&scene->host, images, MAX(scene->images.count, 1u) * sizeof *images);
    *handle = NULL;
}

/* ---- sampling ---- */

static uint32_t wrap(double at, uint32_t side, enum scene_wrap how) {
    if (how == SCENE_WRAP_CLAMP) return (uint32_t)CLAMP(at, 0.0, side - 1.0);
    double period = how == SCENE_WRAP_MIRROR ? 2.0 * side : side, rest = at - period * floor(at / period);
    uint32_t texel = (uint32_t)CLAMP(rest, 0.0, period - 1);
    return texel < side ? texel : 2 * side - 1 - texel;
}

static void add_texel(const struct ray_image *image, const struct scene_sampler *s, bool decodes, uint32_t level, double x,
                      double y, double weight, double out[4]) {
    uint32_t width = side_at(image->width, level), height = side_at(image->height, level);
    const uint8_t *texel =
        image->pixels + image->levels[level] + 4 * ((size_t)wrap(y, height, s->wrap_v) * width + wrap(x, width, s->wrap_u));
    for (int c = 0; c < 3; c++) out[c] += weight * (decodes ? decoded[texel[c]] : texel[c] / 255.0);
    out[3] += weight * texel[3] / 255.0;
}

static void add_level(const struct ray_image *image, const struct scene_sampler *s, bool decodes, uint32_t level,
                      enum scene_filter filter, const double uv[2], double weight, double out[4]) {
    double x = uv[0] * side_at(image->width, level), y = uv[1] * side_at(image->height, level);
    if (filter == SCENE_FILTER_NEAREST) {
        add_texel(image, s, decodes, level, floor(x), floor(y), weight, out);
        return;
    }
    double x0 = floor(x - 0.5), y0 = floor(y - 0.5), fx = x - 0.5 - x0, fy = y - 0.5 - y0;
    for (int k = 0; k < 4; k++)
        add_texel(image, s, decodes, level, x0 + (k & 1), y0 + (k >> 1),
                  weight * (k & 1 ? fx : 1 - fx) * (k >> 1 ? fy : 1 - fy), out);
}

static void add_tap(const struct ray_image *image, const struct scene_sampler *s, bool decodes, double lod,
                    const double uv[2], double weight, double out[4]) {
    if (lod <= 0 || !s->mipmapped) {
        add_level(image, s, decodes, 0, lod <= 0 ? s->mag : s->min, uv, weight, out);
        return;
    }
    lod = fmin(lod, image->level_count - 1.0);
    if (s->mip == SCENE_FILTER_NEAREST) {
        add_level(image, s, decodes, (uint32_t)(lod + 0.5), s->min, uv, weight, out);
        return;
    }
    uint32_t low = (uint32_t)lod;
    double part = lod - low;
    add_level(image, s, decodes, low, s->min, uv, weight * (1 - part), out);
    if (part > 0) add_level(image, s, decodes, low + 1, s->min, uv, weight * part, out);
}

static void transform_uv(const struct scene_texture *t, const double uv[2], double offset, double out[2]) {
    for (int i = 0; i < 2; i++)
        out[i] = (double)t->transform[3 * i] * uv[0] + (double)t->transform[3 * i + 1] * uv[1] +
                 (double)t->transform[3 * i + 2] * offset;
}

bool ray_texture_exists(const struct ray_image *images, const struct scene_material *material,
                        enum scene_texture_slot slot) {
    uint32_t image = material->textures[slot].image;
    return image != SCENE_NONE && images[image].pixels;
}

/* As Vulkan describes anisotropic filtering: the level by the shorter axis of the pixel's footprint, several taps along the longer one. */
void ray_texture_sample(const fnl_scene *scene, const struct ray_image *images, const struct scene_material *material,
                        enum scene_texture_slot slot, const struct ray_uv *uv, double out[4]) {
    for (int c = 0; c < 4; c++) out[c] = 1;
    if (!ray_texture_exists(images, material, slot)) return;
    const struct scene_texture *t = &material->textures[slot];
    const struct ray_image *image = &images[t->image];
    const struct scene_sampler *s = &scene->samplers.data[t->sampler];
    const bool decodes = image->color && scene_texture_is_color(slot);
    double at[2], along[2], across[2];
    transform_uv(t, uv->at[t->uv_set], 1, at);
    transform_uv(t, uv->along[t->uv_set], 0, along);
    transform_uv(t, uv->across[t->uv_set], 0, across);
    memset(out, 0, 4 * sizeof *out);
    if (!isfinite(at[0]) || !isfinite(at[1])) at[0] = at[1] = 0;
    double a = hypot(along[0] * image->width, along[1] * image->height),
           b = hypot(across[0] * image->width, across[1] * image->height);
    double longer = fmax(a, b), shorter = fmin(a, b),
           most = s->mipmapped && s->min == SCENE_FILTER_LINEAR ? (double)scene->anisotropy : 1;
    if (!(longer > 0) || !isfinite(longer)) {
        add_tap(image, s, decodes, 0, at, 1, out);
        return;
    }
    double ratio = fmin(longer / fmax(shorter, 1e-12), most), taps = ceil(ratio), lod = log2(longer / ratio);
    const double *axis = a > b ? along : across;
    if (lod <= 0) taps = 1;
    for (double i = 0; i < taps; i++) {
        double offset = (i + 0.5) / taps - 0.5, tap[2] = {at[0] + axis[0] * offset, at[1] + axis[1] * offset};
        add_tap(image, s, decodes, lod, tap, 1 / taps, out);
    }
}
