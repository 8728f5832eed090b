/* SPDX-License-Identifier: MIT */
#include "headset_display.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

const char *display_warp_name(int warp) {
    static const char *const names[FNL_WARP_COUNT] = {"mesh", "pixel", "off"};
    return warp >= 0 && warp < FNL_WARP_COUNT ? names[warp] : NULL;
}

const char *display_view_name(int view) {
    static const char *const names[FNL_DISPLAY_VIEW_COUNT] = {"none", "mask", "mesh", "fringes"};
    return view >= 0 && view < FNL_DISPLAY_VIEW_COUNT ? names[view] : NULL;
}

const char *display_problem(const struct display_options *o, const struct stereo_options *stereo, bool makes_exr) {
    if ((o->given || o->hides) && !stereo->hmd) return "--lens and --hidden-mesh belong to --hmd FILE";
    if (o->view != FNL_DISPLAY_VIEW_NONE && !o->given) return "--lens-view belongs to --lens";
    if (o->given && stereo->kind != STEREO_SIDE_BY_SIDE && stereo->kind != STEREO_LEFT && stereo->kind != STEREO_RIGHT)
        return "--lens makes the picture of a display: with --stereo side-by-side, left or right";
    if (o->given && makes_exr) return "--lens makes pictures of 8 bits: outputs must be PNG";
    return NULL;
}

/* ---- what is never seen ---- */

static float side_of(fnl_vec2 a, fnl_vec2 b, fnl_vec2 p) { return (b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x); }

static bool is_hidden(const struct headset_eye *eye, fnl_vec2 p) {
    for (uint32_t i = 0; i + 2 < eye->hidden_count; i += 3) {
        const fnl_vec2 *t = &eye->hidden[i];
        const float a = side_of(t[0], t[1], p), b = side_of(t[1], t[2], p), c = side_of(t[2], t[0], p);
        if ((a >= 0 && b >= 0 && c >= 0) || (a <= 0 && b <= 0 && c <= 0)) return true;
    }
    return false;
}

/* From the lens's centre as far as something is seen, found on a grid: up to a cell more than that. */
static float visible_radius(const struct headset_eye *eye) {
    enum { GRID = 192 };
    const fnl_eye *e = &eye->eye;
    const float dx = (e->right - e->left) / GRID, dy = (e->up - e->down) / GRID;
    float farthest = 0;
    for (int y = 0; y <= GRID; y++)
        for (int x = 0; x <= GRID; x++) {
            const fnl_vec2 p = {e->left + dx * (float)x, e->down + dy * (float)y};
            const float r = hypotf(p.x - eye->lens.center.x, p.y - eye->lens.center.y);
            if (r > farthest && !is_hidden(eye, p)) farthest = r;
        }
    return farthest + hypotf(dx, dy);
}

/* ---- displays ---- */

static fnl_display_eye eye_of(const struct headset_eye *from, bool hides) {
    fnl_display_eye eye = {.eye = from->eye, .lens = {.center = from->lens.center}, .visible_radius = hides && from->hidden_count ? visible_radius(from) : INFINITY};
    _Static_assert(sizeof eye.lens.k == sizeof from->lens.k, "the file has as many terms");
    memcpy(eye.lens.k, from->lens.k, sizeof eye.lens.k);
    eye.left = fnl_lens_display_edge(&eye.lens, eye.eye.left, false);
    eye.right = fnl_lens_display_edge(&eye.lens, eye.eye.right, false);
    eye.down = fnl_lens_display_edge(&eye.lens, eye.eye.down, true);
    eye.up = fnl_lens_display_edge(&eye.lens, eye.eye.up, true);
    return eye;
}

bool display_open(struct display *d, const struct display_options *options, const struct stereo *stereo, fnl_device *device, uint32_t width, uint32_t height) {
    *d = (struct display){.options = *options, .stereo = stereo};
    const uint32_t first = stereo->options.kind == STEREO_RIGHT, count = stereo_view_count(stereo);
    fnl_compositor_params params = fnl_compositor_params_default();
    params.width = width;
    params.height = height;
    params.eye_count = count;
    params.warp = options->warp;
    for (uint32_t i = 0; i < count; i++) {
        const struct headset_eye *eye = &stereo->headset.eyes[first + i];
        d->areas[i] = (fnl_hidden_area){eye->hidden, eye->hidden_count};
        params.eyes[i] = eye_of(eye, options->hides);
    }
    return !options->given || fnl_compositor_create(device, &params, &d->compositor) == FNL_OK;
}

void display_close(struct display *d) { fnl_compositor_destroy(&d->compositor); }

const fnl_hidden_area *display_hidden(const struct display *d) { return d->options.hides ? d->areas : NULL; }

bool display_show(struct display *d, const fnl_host *host, fnl_image *picture) {
    const fnl_rigid_pose still = {{0, 0, 0}, {0, 0, 0, 1}};
    const fnl_eye_pictures pictures = {.color = picture, .head = still};
    const fnl_composition composition = {.head = still, .view = d->options.view};
    fnl_image shown;
    if (fnl_compositor_submit(d->compositor, &pictures) != FNL_OK || fnl_compositor_compose(d->compositor, &composition, &shown) != FNL_OK) return false;
    fnl_image_free(host, picture);
    *picture = shown;
    return true;
}
