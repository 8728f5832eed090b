/* SPDX-License-Identifier: MIT */
/* Loads scenes on a thread, so that the window answers meanwhile. */
#include "view/view.h"

#include <stdlib.h>
#include <string.h>

void view_scene_free(struct view_scene *scene) {
    fnl_scene_destroy(&scene->scene);
    free(scene->source);
    *scene = (struct view_scene){0};
}

static bool show_progress(void *user, uint32_t done, uint32_t total) {
    struct view_loader *loader = user;
    atomic_store(&loader->progress, total ? (uint32_t)(1000ull * done / total) : 0);
    return !atomic_load(&loader->cancelled);
}

static void *load(void *argument) {
    struct view_loader *l = argument;
    l->world.loading.progress = show_progress;
    l->world.loading.user = l;
    l->good = world_load(&l->world, &l->host, l->width, l->height, true, &l->scene.scene, &l->scene.camera) &&
              fnl_scene_query_info(l->scene.scene, &l->scene.info) == FNL_OK;
    atomic_store(&l->done, true);
    return NULL;
}

bool view_loader_start(struct view_loader *l, const struct world_options *world, const fnl_host *host, const char *source, uint32_t width,
                       uint32_t height) {
    view_loader_stop(l);
    l->scene = (struct view_scene){.source = strdup(source)};
    l->world = *world;
    l->world.scene = l->scene.source;
    l->host = *host;
    l->width = width ? width : 1;
    l->height = height ? height : 1;
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
