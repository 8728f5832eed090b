/* SPDX-License-Identifier: MIT */
#include "tests/render_harness.h"

#include <unistd.h>

static fnl_device *device;
static uint64_t messages_seen;
static struct stage open_stages[8]; /* those of a test that fails are closed after it */

static void log_line(void *user, fnl_log_level level, const char *line) {
    UNUSED(user);
    if (level >= FNL_LOG_WARNING) print_error("%s\n", line);
}

int harness_begin(void **state) {
    UNUSED(state);
    fnl_device_params params = fnl_device_params_default();
    params.host.log = log_line;
    params.host.thread_count = 4;
    params.validate = true;
    params.cache_folder = "";
    messages_seen = 0;
    return fnl_device_create(&params, &device) == FNL_OK ? 0 : -1;
}

int harness_check(void **state) {
    UNUSED(state);
    for (uint32_t i = 0; i < COUNT_OF(open_stages); i++)
        if (open_stages[i].scene) stage_close(&open_stages[i]);
    uint64_t messages = fnl_device_validation_count(device);
    bool silent = messages == messages_seen;
    if (!silent) print_error("%llu validation messages\n", (unsigned long long)(messages - messages_seen));
    messages_seen = messages;
    return silent ? 0 : -1;
}

int harness_end(void **state) {
    int result = gpu_wait_idle(device) == FNL_OK ? harness_check(state) : -1;
    fnl_device_destroy(&device);
    return result;
}

fnl_device *harness_device(void) { return device; }

/* ---- stages ---- */

struct stage stage_open_scene(fnl_scene *scene) {
    struct stage stage = {.scene = scene, .frame = fnl_frame_default()};
    stage.frame.lists = FNL_LISTS_CLUSTERED;
    uint32_t place = 0;
    while (place < COUNT_OF(open_stages) && open_stages[place].scene) place++;
    assert_true(place < COUNT_OF(open_stages));
    assert_int_equal(fnl_renderer_create(device, scene, &stage.renderer), FNL_OK);
    stage.renderer->poison = true; /* nobody may read what nobody wrote */
    open_stages[place] = stage;
    stage.frame.width = 161;
    stage.frame.height = 91;
    stage.frame.exposure = FNL_EXPOSURE_EV;
    stage.frame.ev = 5;
    stage.frame.outputs = FNL_OUTPUT_COLOR | FNL_OUTPUT_RADIANCE;
    stage.frame.timers = false;
    fnl_result result = fnl_scene_camera_count(scene)
                            ? fnl_scene_query_camera(scene, 0, &stage.frame.camera)
                            : fnl_scene_query_framing_camera(scene, 161 / 91.0f, &stage.frame.camera);
    assert_int_equal(result, FNL_OK);
    return stage;
}

struct stage stage_open(const char *source, uint32_t scattered) {
    char path[1024];
    const char *folder = getenv("FANAL_SCENES");
    bool builtin = strncmp(source, "builtin:", 8) == 0;
    snprintf(path, sizeof path, "%s%s%s", builtin ? "" : folder ? folder : "../shared/scenes", builtin ? "" : "/", source);
    if (!builtin && access(path, R_OK) != 0) {
        print_message("%s is not there: skipped\n", path);
        skip();
    }
    fnl_scene *scene;
    assert_int_equal(fnl_scene_load(gpu_host(device), path, &scene), FNL_OK);
    assert_int_equal(fnl_scene_scatter_lights(scene, scattered, 1), FNL_OK);
    return stage_open_scene(scene);
}

void stage_close(struct stage *stage) {
    fnl_scene *scene = stage->scene;
    fnl_renderer_destroy(&stage->renderer);
    fnl_scene_destroy(&stage->scene);
    for (uint32_t i = 0; i < COUNT_OF(open_stages); i++)
        if (open_stages[i].scene == scene) open_stages[i] = (struct stage){0};
}

/* ---- shots ---- */

struct shot stage_shoot(struct stage *stage, const fnl_frame *frame) {
    struct shot shot = {0};
    assert_int_equal(fnl_renderer_render(stage->renderer, frame), FNL_OK);
    fnl_image *images[] = {&shot.color, &shot.radiance, &shot.surface, &shot.normal, &shot.position};
    for (uint32_t i = 0; i < COUNT_OF(images); i++)
        if (frame->outputs & 1u << i)
            assert_int_equal(fnl_renderer_read(stage->renderer, (fnl_output)(1u << i), images[i]), FNL_OK);
    assert_int_equal(fnl_renderer_query_stats(stage->renderer, &shot.stats), FNL_OK);
    shot.stats.passes = NULL;
    shot.stats.pass_count = 0;
    assert_int_equal(shot.stats.lights_dropped, 0);
    return shot;
}

void shot_free(struct shot *shot) {
    fnl_image *images[] = {&shot->color, &shot->radiance, &shot->surface, &shot->normal, &shot->position};
    for (uint32_t i = 0; i < COUNT_OF(images); i++) fnl_image_free(gpu_host(device), images[i]);
}

uint64_t count_differing(const fnl_image *a, const fnl_image *b) {
    if (a->width != b->width || a->height != b->height || a->format != b->format || !a->pixels || !b->pixels)
        return UINT64_MAX;
    size_t size = fnl_pixel_size(a->format);
    uint64_t count = 0;
    for (size_t i = 0; i < (size_t)a->width * a->height; i++)
        count += memcmp((const char *)a->pixels + i * size, (const char *)b->pixels + i * size, size) != 0;
    return count;
}

int greatest_difference(const fnl_image *a, const fnl_image *b) {
    assert_true(a->width == b->width && a->height == b->height && a->pixels && b->pixels);
    assert_true(a->format == FNL_PIXEL_FORMAT_RGBA8 && b->format == FNL_PIXEL_FORMAT_RGBA8);
    const uint8_t *p = a->pixels, *q = b->pixels;
    int greatest = 0;
    for (size_t i = 0; i < (size_t)a->width * a->height * 4; i++) greatest = MAX(greatest, abs(p[i] - q[i]));
    return greatest;
}

uint64_t count_beyond(const fnl_image *a, const fnl_image *b, int allowed) {
    assert_true(a->width == b->width && a->height == b->height && a->pixels && b->pixels);
    assert_true(a->format == FNL_PIXEL_FORMAT_RGBA8 && b->format == FNL_PIXEL_FORMAT_RGBA8);
    const uint8_t *p = a->pixels, *q = b->pixels;
    uint64_t count = 0;
    for (size_t i = 0; i < (size_t)a->width * a->height; i++, p += 4, q += 4) {
        bool beyond = false;
        for (int k = 0; k < 4; k++) beyond = beyond || abs(p[k] - q[k]) > allowed;
        count += beyond;
    }
    return count;
}

uint64_t count_broken(const fnl_image *image) {
    assert_int_equal(image->format, FNL_PIXEL_FORMAT_RGBA32F);
    const fnl_vec4 *p = image->pixels;
    uint64_t count = 0;
    for (size_t i = 0; i < (size_t)image->width * image->height; i++)
        count += !(isfinite(p[i].x) && isfinite(p[i].y) && isfinite(p[i].z) && p[i].x >= 0 && p[i].y >= 0 && p[i].z >= 0);
    return count;
}
