/* SPDX-License-Identifier: MIT */
/* The scene's environment on the device. */
#include "render/device/scene.h"

static fnl_result send_picture(struct device_scene *d, const struct panorama *p) {
    const size_t count = (size_t)p->width * p->height, bytes = count * 4 * sizeof(uint16_t);
    const uint16_t one = half_from_float(1);
    uint16_t *pixels = host_allocate(&d->host, bytes);
    if (!pixels) return FNL_ERROR_MEMORY;
    for (size_t i = 0; i < count; i++) {
        for (size_t c = 0; c < 3; c++) pixels[4 * i + c] = half_from_float(p->texels[3 * i + c]);
        pixels[4 * i + 3] = one;
    }
    const bool compressed = d->scene->environment.compressed && gpu_info(d->device)->texture_compression;
    const fnl_result result = environment_prepare(d->device, pixels, p->width, p->height, compressed, &d->environment);
    host_free(&d->host, pixels, bytes);
    d->bytes_uploaded += bytes;
    return result;
}

static bool needs_table(const struct device_scene *d) { return device_has_layers(d) || scene_has_reflections(d->scene); }

fnl_result device_environment_prepare(struct device_scene *d) {
    const struct scene_environment *e = &d->scene->environment;
    if (e->panorama.width == 0 && needs_table(d)) TRY(environment_prepare_table(d->device, &d->environment));
    if (d->environment_version == e->version) {
        if (d->sent.environment == e->version) environment_release(d->device, &d->environment);
        return FNL_OK;
    }
    d->environment_version = d->sent.environment = UINT64_MAX;
    if (e->panorama.width > 0) TRY(send_picture(d, &e->panorama));
    d->environment_version = e->version;
    return FNL_OK;
}

struct environment_light device_environment_add(struct device_scene *d, struct graph *graph) {
    const struct scene_environment *e = &d->scene->environment;
    if (e->panorama.width == 0) {
        if (!needs_table(d)) return (struct environment_light){0};
        const bool fill = !d->sent.table;
        d->sent.table = true;
        return environment_add_table(graph, &d->environment, fill);
    }
    const bool filter = d->sent.environment != e->version;
    d->sent.environment = e->version;
    d->sent.table |= filter;
    return environment_add(graph, d->device, &d->environment, filter);
}

void device_environment_finish(struct device_scene *d) {
    environment_finish_maps(d->device, &d->environment);
    d->environment_version = UINT64_MAX;
    d->sent.table = false;
}
