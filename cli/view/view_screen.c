/* SPDX-License-Identifier: MIT */
/*
 * The window's pictures by a device of their own. A device works on its frames in order, so that panels drawn by the scene's would wait for the scene:
 * here the scene's frame is submitted, panels are drawn over its last picture meanwhile, and its pixels are fetched when it is finished. On CPU
 * devices that is always so; on others it begins when frames are slow, as fetching costs time too.
 */
#include "view/view.h"

#include "view/ui.h"

#include "fanal/vulkan.h"

#include <math.h>
#include <string.h>

enum { PICTURE_IMAGE = 3 }; /* of the overlay */
enum { SLOW_MILLISECONDS = 50, SLOW_FRAMES = 3 };

static bool open_on(struct view *v, fnl_device *device) {
    fnl_swapchain_destroy(&v->swapchain);
    return view_window_open_swapchain(v->window, device, v->settings.present, v->settings.color, &v->swapchain);
}

static void close_screen(struct view *v) {
    struct view_screen *s = &v->screen;
    if (s->device) fnl_swapchain_destroy(&v->swapchain);
    fnl_renderer_destroy(&s->renderer);
    fnl_scene_destroy(&s->scene);
    fnl_device_destroy(&s->device);
    ui_set_image(PICTURE_IMAGE, NULL, 0);
    fnl_image_free(&v->host, &s->picture);
    *s = (struct view_screen){.version = s->version, .shown = s->shown};
}

bool view_screen_begin(struct view *v) {
    struct view_screen *s = &v->screen;
    if (s->device || s->failed) return true;
    const bool good = fnl_device_create(&v->device.params, &s->device) == FNL_OK && fnl_scene_create(&v->host, &s->scene) == FNL_OK &&
                      fnl_renderer_create(s->device, s->scene, &s->renderer) == FNL_OK && open_on(v, s->device);
    if (!good) close_screen(v);
    s->failed = !good;
    view_want(v, 2);
    return good || (v->swapchain || open_on(v, v->device.device));
}

bool view_screen_end(struct view *v) {
    if (!v->screen.device) return true;
    close_screen(v);
    view_want(v, 2);
    return open_on(v, v->device.device);
}

uint64_t view_screen_finish(struct view *v) {
    const uint64_t messages = v->screen.device ? fnl_device_validation_count(v->screen.device) : 0;
    close_screen(v);
    fnl_swapchain_destroy(&v->swapchain);
    return messages;
}

bool view_screen_adapt(struct view *v) {
    struct view_screen *s = &v->screen;
    const bool may = v->swapchain && !v->replays && v->settings.color == FNL_COLOR_SRGB; /* what is fetched has 8 bits */
    if (!may) return view_screen_end(v);
    if (v->device.info.type == FNL_DEVICE_CPU) return view_screen_begin(v);
    s->slow = v->shown.source && v->stats.gpu_milliseconds > SLOW_MILLISECONDS ? s->slow + 1 : 0;
    return s->slow >= SLOW_FRAMES ? view_screen_begin(v) : true;
}

/* ---- the scene ---- */

bool view_screen_has_changed(const struct view *v) {
    const struct view_screen *s = &v->screen;
    fnl_frame frame = view_screen_frame(v);
    return memcmp(&frame, &s->sent, sizeof frame) != 0;
}

fnl_frame view_screen_frame(const struct view *v) {
    fnl_frame frame = view_whole_frame(v);
    frame.pin_choice = v->part < 1; /* auto measures frames of the window's size alone */
    frame.width = (uint32_t)fmaxf(1, (float)v->width * v->part);
    frame.height = (uint32_t)fmaxf(1, (float)v->height * v->part);
    return frame;
}

void view_screen_take(struct view *v, fnl_image *picture) {
    struct view_screen *s = &v->screen;
    fnl_image_free(&v->host, &s->picture);
    s->picture = *picture;
    *picture = (fnl_image){0};
    ui_set_image(PICTURE_IMAGE, s->picture.pixels ? &s->picture : NULL, ++s->version);
}

/* ---- the window ---- */

fnl_frame view_bare_frame(void) {
    fnl_frame frame = fnl_frame_default();
    frame.width = frame.height = 1;
    frame.shading = FNL_SHADING_FORWARD;
    frame.lists = FNL_LISTS_ALL;
    frame.shadows = FNL_SHADOWS_OFF;
    frame.msaa = 1;
    frame.aa = FNL_ANTIALIASING_NONE;
    frame.studio = false;
    frame.ground = FNL_GROUND_OFF;
    frame.background = FNL_BACKGROUND_SCENE;
    return frame;
}

void view_screen_back(struct view *v) {
    if (v->screen.device && v->screen.picture.pixels) ui_back_image(PICTURE_IMAGE, 0, 0, (float)v->width, (float)v->height);
}

fnl_result view_screen_show(struct view *v, const fnl_overlay *overlay) {
    struct view_screen *s = &v->screen;
    fnl_vulkan_target target;
    fnl_frame frame = view_bare_frame();
    fnl_result result = fnl_swapchain_acquire(v->swapchain, &target);
    if (result == FNL_ERROR_DEVICE) { /* the surface is lost: another one, once */
        if (!open_on(v, s->device)) return result;
        result = fnl_swapchain_acquire(v->swapchain, &target);
    }
    if (result != FNL_OK || target.image == VK_NULL_HANDLE) return result;
    frame.overlay = overlay;
    result = fnl_renderer_render_to(s->renderer, &frame, &target);
    if (result != FNL_OK) return result;
    result = fnl_swapchain_present(v->swapchain);
    s->shown += !v->loader.running;
    return result == FNL_ERROR_DEVICE ? FNL_OK : result; /* the next one finds out whether the surface is lost */
}
