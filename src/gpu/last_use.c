/* SPDX-License-Identifier: MIT */
#include "gpu/gpu_internal.h"

struct gpu_last_uses *gpu_last_uses(gpu_device *device) { return &device->last_uses; }

/* A few dozen at most: what frames import. */
static struct gpu_last_use *find(struct gpu_last_uses *uses, bool is_image, uint64_t handle) {
    for (uint32_t i = 0; i < uses->items.count; i++)
        if (uses->items.data[i].handle == handle && uses->items.data[i].is_image == is_image) return &uses->items.data[i];
    return NULL;
}

bool gpu_last_use_find(struct gpu_last_uses *uses, const fnl_host *host, struct gpu_last_use *use) {
    pthread_mutex_lock(&uses->mutex);
    const struct gpu_last_use *known = find(uses, use->is_image, use->handle);
    bool found = known || array_push(host, &uses->items, *use);
    if (known) *use = *known;
    pthread_mutex_unlock(&uses->mutex);
    return found;
}

void gpu_last_use_set(struct gpu_last_uses *uses, const struct gpu_last_use *use) {
    pthread_mutex_lock(&uses->mutex);
    struct gpu_last_use *known = find(uses, use->is_image, use->handle);
    if (known) *known = *use;
    pthread_mutex_unlock(&uses->mutex);
}

void gpu_last_use_remove(struct gpu_last_uses *uses, bool is_image, uint64_t handle) {
    pthread_mutex_lock(&uses->mutex);
    struct gpu_last_use *known = find(uses, is_image, handle);
    if (known) *known = uses->items.data[--uses->items.count];
    pthread_mutex_unlock(&uses->mutex);
}
