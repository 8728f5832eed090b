/* SPDX-License-Identifier: MIT */
#include "fanal/trace.h"

#include "base/check.h"
#include "base/jobs.h"
#include "ray/integrate.h"
#include "ray/tone.h"
#include "scene/scene.h"

#include <stdatomic.h>

enum { TILE = 16, TILES_PER_THREAD = 4 }; /* between two calls of the callback */

struct trace {
    const fnl_trace_params *params;
    struct ray_scene *scene;
    struct ray_camera camera;
    struct ray_sum *sums; /* of the pixels */
    uint32_t *counts;     /* samples that the tiles have */
    uint32_t tiles_x, tiles_y;
    uint32_t first_tile; /* of those that are traced at once */
    atomic_ullong ray_count;
    atomic_bool failed;
};

static fnl_result check(const struct call *call, const fnl_trace_params *p) {
    const double infinite = (double)FLT_MAX;
    TRY(check_count(call, "width", p->width, 1, 16384));
    TRY(check_count(call, "height", p->height, 1, 16384));
    TRY(camera_check(call, "camera.", &p->camera));
    TRY(check_count(call, "samples", p->samples, 1, 1048576));
    TRY(check_count(call, "bounces", p->bounces, 0, 1024));
    if (!(p->light_radius == INFINITY)) TRY(check_range(call, "light_radius", (double)p->light_radius, 0, infinite, " metres"));
    if (!(p->sun_angle == INFINITY)) TRY(check_range(call, "sun_angle", (double)p->sun_angle, 0, 1, " radians"));
    TRY(check_enum(call, "energy", (int)p->energy, FNL_ENERGY_COUNT, "fnl_energy"));
    TRY(check_enum(call, "ground", (int)p->ground, FNL_GROUND_COUNT, "fnl_ground"));
    TRY(check_enum(call, "background", (int)p->background, FNL_BACKGROUND_COUNT, "fnl_background"));
    TRY(check_range(call, "background_blur", (double)p->background_blur, 0, (double)PI, " radians"));
    TRY(check_enum(call, "tonemap", (int)p->tonemap, FNL_TONEMAP_COUNT, "fnl_tonemap"));
    TRY(check_enum(call, "exposure", (int)p->exposure, FNL_EXPOSURE_NONE + 1, "fnl_exposure"));
    return check_range(call, "ev", (double)p->ev, -64, 64, " EV100");
}

static void trace_tile(void *context, uint32_t index) {
    struct trace *t = context;
    const fnl_trace_params *p = t->params;
    const uint32_t tile = t->first_tile + index, sample = t->counts[tile]++;
    const uint32_t left = tile % t->tiles_x * TILE, top = tile / t->tiles_x * TILE;
    const vec2 jitter = pixel_jitter(sample);
    struct ray_walk walk = {.unseen = 255u & ~p->camera.view_mask};
    for (uint32_t y = top; y < MIN(top + TILE, p->height); y++)
        for (uint32_t x = left; x < MIN(left + TILE, p->width) && !walk.failed; x++) {
            struct ray_samples samples = ray_samples_make(p->seed, x, y, sample); /* its own, whoever traces it */
            ray_integrate(t->scene, p, &t->camera, x + 0.5 + (double)jitter.x, y + 0.5 + (double)jitter.y, &samples, &walk,
                          &t->sums[(size_t)y * p->width + x]);
        }
    atomic_fetch_add(&t->ray_count, walk.ray_count);
    if (walk.failed) atomic_store(&t->failed, true);
    array_free(ray_scene_host(t->scene), &walk.layers);
    array_free(ray_scene_host(t->scene), &walk.crossed);
    array_free(ray_scene_host(t->scene), &walk.lights);
}

/* True: all samples of all tiles. */
static bool trace_all(struct trace *t, struct jobs *jobs) {
    const fnl_trace_params *p = t->params;
    const uint32_t tiles = t->tiles_x * t->tiles_y, step = jobs_thread_count(jobs) * TILES_PER_THREAD;
    const uint64_t total = (uint64_t)tiles * p->samples;
    uint64_t done = 0;
    for (uint32_t sample = 0; sample < p->samples; sample++)
        for (t->first_tile = 0; t->first_tile < tiles; t->first_tile += step) {
            if (atomic_load(&t->failed)) return false;
            if (p->progress && !p->progress(p->user, done, total)) return false;
            const uint32_t count = MIN(step, tiles - t->first_tile);
            jobs_parallel_for(jobs, count, trace_tile, t);
            done += count;
        }
    if (p->progress) p->progress(p->user, total, total);
    return true;
}

/* ---- pictures ---- */

static void fill_radiance(const struct trace *t, float *radiance, float *visibility) {
    const fnl_trace_params *p = t->params;
    for (uint32_t y = 0; y < p->height; y++)
        for (uint32_t x = 0; x < p->width; x++) {
            const size_t pixel = (size_t)y * p->width + x;
            const struct ray_sum *sum = &t->sums[pixel];
            const uint32_t count = t->counts[y / TILE * t->tiles_x + x / TILE];
            const double scale = count ? 1.0 / count : 0;
            float *out = radiance + pixel * 4, *seen = visibility ? visibility + pixel * 4 : NULL;
            out[0] = (float)(sum->radiance.x * scale);
            out[1] = (float)(sum->radiance.y * scale);
            out[2] = (float)(sum->radiance.z * scale);
            out[3] = count ? 1 : 0; /* as in frames, also where nothing is */
            if (!seen) continue;
            seen[0] = count ? (float)(sum->unshadowed > 0 ? sum->direct / sum->unshadowed : 1) : 0;
            seen[1] = (float)(sum->unshadowed * scale);
            seen[2] = seen[3] = 0;
        }
}

static void fill_color(const struct trace *t, const float *radiance, double factor, uint8_t *color) {
    const fnl_trace_params *p = t->params;
    for (uint32_t y = 0; y < p->height; y++)
        for (uint32_t x = 0; x < p->width; x++) {
            const size_t at = ((size_t)y * p->width + x) * 4;
            const float *from = radiance + at;
            dvec3 c = dvec3_scale(dvec3_make((double)from[0], (double)from[1], (double)from[2]), factor);
            c = ray_tone_map(p->tonemap, dvec3_make(fmin(c.x, 1e15), fmin(c.y, 1e15), fmin(c.z, 1e15)));
            color[at] = (uint8_t)(ray_srgb(c.x) * 255 + 0.5);
            color[at + 1] = (uint8_t)(ray_srgb(c.y) * 255 + 0.5);
            color[at + 2] = (uint8_t)(ray_srgb(c.z) * 255 + 0.5);
            color[at + 3] = t->counts[y / TILE * t->tiles_x + x / TILE] ? 255 : 0;
        }
}

static bool create_image(const fnl_host *host, const fnl_trace_params *p, fnl_pixel_format format, fnl_image *out) {
    *out = (fnl_image){p->width, p->height, format, NULL};
    out->pixels = host_allocate(host, (size_t)p->width * p->height * fnl_pixel_size(format));
    return out->pixels;
}

/* A pixel shows a surface if half of its samples do. */
static bool meter(const struct trace *t, const fnl_host *host, const float *radiance, double *ev) {
    const fnl_trace_params *p = t->params;
    const size_t count = (size_t)p->width * p->height;
    uint8_t *surfaces = host_allocate(host, count);
    if (!surfaces) return false;
    for (uint32_t y = 0; y < p->height; y++)
        for (uint32_t x = 0; x < p->width; x++) {
            const size_t pixel = (size_t)y * p->width + x;
            surfaces[pixel] = 2 * (uint64_t)t->sums[pixel].surfaces > t->counts[y / TILE * t->tiles_x + x / TILE];
        }
    *ev = ray_meter(radiance, surfaces, p->width, p->height);
    host_free(host, surfaces, count);
    return true;
}

static fnl_result make_pictures(struct trace *t, const fnl_host *host, fnl_trace *out) {
    const fnl_trace_params *p = t->params;
    if (!create_image(host, p, FNL_PIXEL_FORMAT_RGBA32F, &out->radiance) ||
        !create_image(host, p, FNL_PIXEL_FORMAT_RGBA8, &out->color))
        return FNL_ERROR_MEMORY;
    if (p->visibility && !create_image(host, p, FNL_PIXEL_FORMAT_RGBA32F, &out->visibility)) return FNL_ERROR_MEMORY;
    fill_radiance(t, out->radiance.pixels, out->visibility.pixels);
    double ev = (double)p->ev;
    if (p->exposure == FNL_EXPOSURE_AUTO && !meter(t, host, out->radiance.pixels, &ev)) return FNL_ERROR_MEMORY;
    out->ev = p->exposure == FNL_EXPOSURE_NONE ? 0 : (float)ev;
    fill_color(t, out->radiance.pixels, p->exposure == FNL_EXPOSURE_NONE ? 1 : ray_exposure(ev), out->color.pixels);
    return FNL_OK;
}

static fnl_result run(struct trace *t, const fnl_scene *scene, struct jobs *jobs, fnl_trace *out) {
    const fnl_trace_params *p = t->params;
    t->camera = ray_camera_make(&p->camera, p->width, p->height);
    t->tiles_x = (p->width + TILE - 1) / TILE;
    t->tiles_y = (p->height + TILE - 1) / TILE;
    const size_t sums_size = (size_t)p->width * p->height * sizeof *t->sums,
                 counts_size = (size_t)t->tiles_x * t->tiles_y * sizeof *t->counts;
    t->sums = host_allocate_zero(&scene->host, sums_size);
    t->counts = host_allocate_zero(&scene->host, counts_size);
    fnl_result result = t->sums && t->counts ? ray_scene_create(scene, p->energy, jobs, &t->scene) : FNL_ERROR_MEMORY;
    if (result == FNL_OK) {
        out->unseen = ray_scene_unseen(t->scene);
        out->complete = trace_all(t, jobs);
        out->ray_count = atomic_load(&t->ray_count);
        result = atomic_load(&t->failed) ? FNL_ERROR_MEMORY : make_pictures(t, &scene->host, out);
    }
    ray_scene_destroy(&t->scene);
    host_free(&scene->host, t->sums, sums_size);
    host_free(&scene->host, t->counts, counts_size);
    return result;
}

fnl_result fnl_scene_trace(const fnl_scene *scene, const fnl_trace_params *params, fnl_trace *out) {
    TRY(check_handle(__func__, "scene", scene));
    const struct call *call = CALL(&scene->host);
    TRY(check_pointer(call, "out", out));
    *out = (fnl_trace){0};
    const fnl_trace_params usual = fnl_trace_params_default();
    struct trace trace = {.params = params ? params : &usual};
    TRY(check(call, trace.params));
    struct jobs *jobs;
    TRY(jobs_create(&scene->host, &jobs));
    /* Neither is a property of the scene: each picture chooses its own. */
    scene_choose_levels((fnl_scene *)scene, &trace.params->camera);
    fnl_result result = scene_set_stage((fnl_scene *)scene, trace.params->studio, trace.params->ground);
    scene_follow_reach((fnl_scene *)scene);
    if (result == FNL_OK) result = run(&trace, scene, jobs, out);
    jobs_destroy(&jobs);
    if (result != FNL_OK) {
        fnl_trace_free(&scene->host, out);
        *out = (fnl_trace){0};
    }
    return result;
}
