/* SPDX-License-Identifier: MIT */
/*
 * Loads scenes on a thread, so that the window answers meanwhile: the file, its geometry on the device, and the pipelines of the first picture. While the
 * thread uses the device it holds its mutex; frames of the window are left out then. Images come later, over the next frames.
 */
#include "view/view.h"

#include "fanal/vulkan.h"

#include <stdlib.h>
#include <string.h>
#include <time.h>

void view_scene_free(struct view_scene *scene) {
    fnl_renderer_destroy(&scene->renderer);
    fnl_scene_destroy(&scene->scene);
    free(scene->source);
    *scene = (struct view_scene){0};
}

static bool show_progress(void *user, uint32_t done, uint32_t total) {
    struct view_loader *loader = user;
    atomic_store(&loader->progress, total ? (uint32_t)(1000ull * done / total) : 0);
    return !atomic_load(&loader->cancelled);
}

/* What the first frame needs of the device. What goes wrong here is told when it is drawn. */
static bool prepare(struct view_loader *l) {
    struct view_device *d = l->device;
    fnl_frame frame = l->frame;
    const fnl_vulkan_target target = {.format = (VkFormat)l->format, .width = frame.width, .height = frame.height};
    uint32_t pending = 1;
    frame.camera = l->scene.camera;
    if (!l->own_shadows) frame.shadows = world_usual_shadows(&l->scene.info, &d->info, true);
    pthread_mutex_lock(&d->mutex);
    const bool good = fnl_renderer_create(d->device, l->scene.scene, &l->scene.renderer) == FNL_OK;
    pthread_mutex_unlock(&d->mutex);
    while (good && pending > 0 && !atomic_load(&l->cancelled)) {
        pthread_mutex_lock(&d->mutex);
        if (fnl_renderer_warm(l->scene.renderer, &frame, l->format ? &target : NULL, false, &pending) != FNL_OK) pending = 0;
        pthread_mutex_unlock(&d->mutex);
        if (pending > 0) nanosleep(&(struct timespec){.tv_nsec = 4000000}, NULL);
    }
    return good;
}

static void *load(void *argument) {
    struct view_loader *l = argument;
    l->world.loading.progress = show_progress;
    l->world.loading.user = l;
    l->world.loading.async = true;
    l->good = world_load(&l->world, &l->host, l->frame.width, l->frame.height, true, &l->scene.scene, &l->scene.camera) &&
              fnl_scene_query_info(l->scene.scene, &l->scene.info) == FNL_OK && prepare(l);
    atomic_store(&l->done, true);
    return NULL;
}

bool view_loader_start(struct view_loader *l, const char *source) {
    l->scene = (struct view_scene){.source = strdup(source)};
    l->world.scene = l->scene.source;
    atomic_store(&l->done, false);
    atomic_store(&l->cancelled, false);
    atomic_store(&l->progress, 0);
    l->running = l->scene.source && pthread_create(&l->thread, NULL, load, l) == 0;
    if (!l->running) view_scene_free(&l->scene);
    return l->running;
}

bool view_loader_take(struct view_loader *l, bool wait, struct view_scene *out) {
    *out = (struct view_scene){0};
    if (!l->running || (!wait && !atomic_load(&l->done))) return false;
    pthread_join(l->thread, NULL);
    l->running = false;
    if (!l->good) view_scene_free(&l->scene);
    *out = l->scene;
    l->scene = (struct view_scene){0};
    return true;
}

void view_loader_stop(struct view_loader *l) {
    struct view_scene scene;
    atomic_store(&l->cancelled, true);
    if (view_loader_take(l, true, &scene)) view_scene_free(&scene);
}
