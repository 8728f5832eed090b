/* SPDX-License-Identifier: MIT */
/* Small pictures of the built-in environments, one below the other in an image of the overlay. */
#include "view/view.h"

#include <string.h>

const char *const view_environments[VIEW_ENVIRONMENTS] = {"builtin:studio", "builtin:sky", "builtin:overcast"};

static bool render(struct view *v, const char *source, fnl_image *out) {
    fnl_environment_params params = fnl_environment_params_default();
    fnl_frame frame = view_bare_frame();
    fnl_scene *scene = NULL;
    fnl_renderer *renderer = NULL;
    params.source = source;
    frame.width = VIEW_THUMBNAIL_WIDTH;
    frame.height = VIEW_THUMBNAIL_HEIGHT;
    frame.outputs = FNL_OUTPUT_COLOR;
    frame.camera.vertical_fov = 1.4f;
    const bool good = fnl_scene_create(&v->host, &scene) == FNL_OK && fnl_scene_set_environment(scene, &params) == FNL_OK &&
                      fnl_renderer_create(v->device.device, scene, &renderer) == FNL_OK && fnl_renderer_render(renderer, &frame) == FNL_OK &&
                      fnl_renderer_read(renderer, FNL_OUTPUT_COLOR, out) == FNL_OK;
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
    return good;
}

void view_thumbnails_update(struct view *v) {
    enum { BYTES = 4 * VIEW_THUMBNAIL_WIDTH * VIEW_THUMBNAIL_HEIGHT };
    struct view_thumbnails *t = &v->thumbnails;
    fnl_image picture = {0};
    if (t->count == VIEW_ENVIRONMENTS) return;
    if (!t->image.pixels) {
        t->image = (fnl_image){VIEW_THUMBNAIL_WIDTH, VIEW_ENVIRONMENTS * VIEW_THUMBNAIL_HEIGHT, FNL_PIXEL_FORMAT_RGBA8,
                               v->host.reallocate(v->host.user, NULL, 0, BYTES * VIEW_ENVIRONMENTS)};
        if (!t->image.pixels) return;
        memset(t->image.pixels, 128, BYTES * VIEW_ENVIRONMENTS);
    }
    if (v->screen.is_drawing) return;
    pthread_mutex_lock(&v->device.mutex);
    if (render(v, view_environments[t->count], &picture)) memcpy((char *)t->image.pixels + BYTES * t->count, picture.pixels, BYTES);
    pthread_mutex_unlock(&v->device.mutex);
    fnl_image_free(&v->host, &picture);
    ui_set_image(VIEW_THUMBNAIL_IMAGE, &t->image, ++t->count);
    view_want(v, 2);
}
