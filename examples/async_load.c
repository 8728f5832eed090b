/* SPDX-License-Identifier: MIT */
/*
 * Shows a file before its images are decoded, saves the picture that shows all of them, and says how long frames took:
 *   async_load FILE [PICTURE.png [wait]]
 * With "wait" the first frame decodes all images, as it does where nothing else is asked for.
 */
#include <fanal/fanal.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { FRAMES_MAX = 4096, STEADY = 32 };

static double milliseconds(void) {
    struct timespec t;
    timespec_get(&t, TIME_UTC);
    return (double)t.tv_sec * 1e3 + (double)t.tv_nsec * 1e-6;
}

static int compare(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Renders until no image is pending, and a few frames more; querying the statistics waits for each frame. */
static fnl_result render(fnl_renderer *renderer, const fnl_frame *frame, double start) {
    static double times[FRAMES_MAX];
    uint32_t count = 0, coming = FRAMES_MAX;
    double longest = 0, begun = milliseconds();
    while (count < FRAMES_MAX && count < coming + STEADY) {
        fnl_frame_stats stats;
        fnl_result result = fnl_renderer_render(renderer, frame);
        if (result == FNL_OK) result = fnl_renderer_query_stats(renderer, &stats);
        if (result != FNL_OK) return result;
        const fnl_counter *pending = fnl_counter_find(&stats, "images.pending");
        double now = milliseconds();
        times[count++] = now - begun;
        begun = now;
        if (count == 1) printf("first frame after %.0f ms, %llu images pending\n", now - start, (unsigned long long)pending->value);
        if (count > 1 && coming == FRAMES_MAX && times[count - 1] > longest) longest = times[count - 1];
        if (pending->value == 0 && coming == FRAMES_MAX) {
            coming = count;
            printf("all images after %.0f ms, in frame %u\n", now - start, count);
        }
    }
    if (coming == FRAMES_MAX) return FNL_OK; /* they take longer than this example has patience */
    qsort(times + coming, STEADY, sizeof *times, compare);
    printf("longest frame while images came %.1f ms; of %d frames after them %.1f ms, median %.1f ms\n", longest, STEADY,
           times[coming + STEADY - 1], times[coming + STEADY / 2]);
    return FNL_OK;
}

static fnl_result show(fnl_device *device, const char *source, const char *picture, bool async) {
    fnl_load_params params = fnl_load_params_default();
    params.async = async;
    double start = milliseconds();
    fnl_scene *scene = NULL;
    fnl_renderer *renderer = NULL;
    fnl_image image = {0};
    fnl_frame frame = fnl_frame_default();
    frame.width = 320;
    frame.height = 180;
    fnl_result result = fnl_scene_load(NULL, source, &params, &scene);
    if (result == FNL_OK) printf("loaded after %.0f ms\n", milliseconds() - start);
    if (result == FNL_OK)
        result = fnl_scene_count(scene, FNL_ENTITY_CAMERA) > 0
                     ? fnl_scene_query_camera(scene, 0, &frame.camera)
                     : fnl_scene_query_framing_camera(scene, 320.0f / 180.0f, &frame.camera);
    if (result == FNL_OK) result = fnl_scene_scatter_lights(scene, 20, 1);
    if (result == FNL_OK) result = fnl_renderer_create(device, scene, &renderer);
    if (result == FNL_OK) result = render(renderer, &frame, start);
    if (result == FNL_OK) result = fnl_renderer_read(renderer, FNL_OUTPUT_COLOR, &image);
    if (result == FNL_OK && picture) result = fnl_image_save(NULL, picture, &image);
    fnl_image_free(NULL, &image);
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
    return result;
}

int main(int argc, char **argv) {
    if (argc < 2) {
        fprintf(stderr, "usage: async_load FILE [PICTURE.png [wait]]\n");
        return 2;
    }
    fnl_device *device = NULL;
    fnl_result result = fnl_device_create(NULL, &device);
    if (result == FNL_OK) result = show(device, argv[1], argc > 2 ? argv[2] : NULL, argc < 4 || strcmp(argv[3], "wait") != 0);
    fnl_device_destroy(&device);
    if (result != FNL_OK) fprintf(stderr, "async_load: %s\n", fnl_result_name(result)); /* the log on stderr says more */
    return result != FNL_OK;
}
