/* SPDX-License-Identifier: MIT */
/*
 * Loads scenes on a thread, so that the window answers meanwhile: the file, its geometry on the device, and the pipelines of the first picture. While the
 * thread uses the device it holds its mutex; frames of the window are left out then. Images come later, over the next frames.
 */
#include "view/view.h"

#include "fanal/vulkan.h"

#include <math.h>
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
    atomic_store(&l->phase, VIEW_SENDING);
    pthread_mutex_lock(&d->mutex);
    const bool good = fnl_renderer_create(d->device, l->scene.scene, &l->scene.renderer) == FNL_OK;
    pthread_mutex_unlock(&d->mutex);
    atomic_store(&l->phase, VIEW_COMPILING);
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
    l->good = world_load(&l->world, &l->host, (uint32_t)fmaxf(l->width, 1), (uint32_t)fmaxf(l->height, 1), true, &l->scene.scene, &l->scene.camera) &&
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
    atomic_store(&l->phase, VIEW_READING);
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

void view_loader_describe(struct view_loader *l, char *text, size_t capacity) {
    static const char *const phases[] = {"reading", "sending it to the device", "compiling pipelines"};
    const char *source = l->world.scene ? l->world.scene : "", *slash = strrchr(source, '/');
    const unsigned phase = atomic_load(&l->phase), progress = atomic_load(&l->progress) / 10;
    snprintf(text, capacity, phase == VIEW_READING && progress > 0 ? "Loading %.200s: %s, %u %%" : "Loading %.200s: %s", slash ? slash + 1 : source, phases[phase], progress);
}

void view_loader_stop(struct view_loader *l) {
    struct view_scene scene;
    atomic_store(&l->cancelled, true);
    if (view_loader_take(l, true, &scene)) view_scene_free(&scene);
}
