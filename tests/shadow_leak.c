/* SPDX-License-Identifier: MIT */
#include "tests/shadow_leak.h"

#include "tests/trace_world.h"

static double luminance_at(const fnl_image *image, uint32_t x, uint32_t y) {
    const float *p = pixel_at(image, x, y);
    return 0.2126 * (double)p[0] + 0.7152 * (double)p[1] + 0.0722 * (double)p[2];
}

/* Whether rays give neighbours within `reach` pixels another part of their light than the pixel: an edge is near, of a shadow or a surface. */
static bool edge_is_near(const fnl_image *open, const fnl_image *rays, uint32_t x, uint32_t y, int reach) {
    double low = INFINITY, high = -INFINITY;
    for (int dy = -reach; dy <= reach; dy++)
        for (int dx = -reach; dx <= reach; dx++) {
            const int u = (int)x + dx, v = (int)y + dy;
            if (u < 0 || v < 0 || u >= (int)open->width || v >= (int)open->height) continue;
            const double part = luminance_at(rays, (uint32_t)u, (uint32_t)v) / fmax(luminance_at(open, (uint32_t)u, (uint32_t)v), 1e-9);
            low = fmin(low, part);
            high = fmax(high, part);
        }
    return high - low > 0.02;
}

struct stage shadow_stage(fnl_scene *scene, const fnl_trace_params *view) {
    struct stage s = stage_open_scene(scene);
    s.frame.width = view->width, s.frame.height = view->height;
    s.frame.camera = view->camera;
    s.frame.outputs = FNL_OUTPUT_RADIANCE;
    return s;
}

fnl_frame_stats shadow_parts(struct stage *s, float *out) {
    const uint32_t width = s->frame.width, height = s->frame.height;
    fnl_frame open = s->frame;
    open.shadows = FNL_SHADOWS_OFF;
    struct shot plain = stage_shoot(s, &open), shadowed = stage_shoot(s, &s->frame);
    for (uint32_t i = 0; i < width * height; i++) {
        const float *whole = pixel_at(&plain.radiance, i % width, i / width);
        out[i] = whole[1] > 0 ? pixel_at(&shadowed.radiance, i % width, i / width)[1] / whole[1] : 1;
    }
    const fnl_frame_stats stats = shadowed.stats;
    shot_free(&plain);
    shot_free(&shadowed);
    return stats;
}

struct shadow_leak shadow_leak_of(struct stage *s, int reach) {
    s->frame.outputs = FNL_OUTPUT_RADIANCE;
    s->frame.shadows = FNL_SHADOWS_OFF;
    struct shot open = stage_shoot(s, &s->frame);
    s->frame.shadows = FNL_SHADOWS_RAYS;
    struct shot rays = stage_shoot(s, &s->frame);
    s->frame.shadows = FNL_SHADOWS_MAPS;
    struct shot maps = stage_shoot(s, &s->frame);
    struct shadow_leak leak = {0};
    double all = 0;
    for (uint32_t y = 0; y < s->frame.height; y++)
        for (uint32_t x = 0; x < s->frame.width; x++) {
            const double whole = luminance_at(&open.radiance, x, y), wanted = luminance_at(&rays.radiance, x, y),
                         got = luminance_at(&maps.radiance, x, y);
            all += whole;
            leak.dark += whole - wanted;
            leak.error += fabs(got - wanted);
            if (fabs(got - wanted) > 0.05 * whole && !edge_is_near(&open.radiance, &rays.radiance, x, y, reach)) leak.far_off++;
        }
    leak.error /= all;
    leak.dark /= all;
    shot_free(&open);
    shot_free(&rays);
    shot_free(&maps);
    return leak;
}
