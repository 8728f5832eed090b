/* SPDX-License-Identifier: MIT */
/*
 * Whether the pictures that a headset was given are those of a frame with the eyes that the runtime told:
 *     xr_picture STATS.json FOLDER FRAME SCENE rgba|bgra reversed|forward|none [KEY=VALUE ...]
 * FOLDER has what the test runtime saved (xr_runtime/README.md). Colour must be equal to the bit, depth what the frame's view depth says.
 */
#include "fanal/fanal.h"
#include "frame_plain.h"

#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { VIEWS = 4 };

static int fail(const char *text) {
    fprintf(stderr, "xr_picture: %s\n", text);
    exit(1);
}

static float number(const json_t *json) { return (float)json_number_value(json); }

static fnl_vec3 vector(const json_t *json) { return (fnl_vec3){number(json_array_get(json, 0)), number(json_array_get(json, 1)), number(json_array_get(json, 2))}; }

static uint32_t read_eyes(const char *folder, const char *frame, fnl_eye eyes[VIEWS]) {
    char path[1024];
    float v[11];
    uint32_t count = 0;
    snprintf(path, sizeof path, "%s/views-%s.txt", folder, frame);
    FILE *file = fopen(path, "r");
    if (!file) fail("there are no views");
    while (count < VIEWS && fscanf(file, "%f %f %f %f %f %f %f %f %f %f %f", v, v + 1, v + 2, v + 3, v + 4, v + 5, v + 6, v + 7, v + 8, v + 9, v + 10) == 11)
        eyes[count++] = (fnl_eye){{{v[0], v[1], v[2]}, {v[3], v[4], v[5], v[6]}}, tanf(v[7]), tanf(v[8]), tanf(v[9]), tanf(v[10])};
    fclose(file);
    return count;
}

static void *read_raw(const char *folder, const char *kind, const char *frame, uint32_t view, size_t size) {
    char path[1024];
    void *bytes = malloc(size + 1);
    snprintf(path, sizeof path, "%s/%s-%s-%u.raw", folder, kind, frame, view);
    FILE *file = fopen(path, "rb");
    if (!file || !bytes || fread(bytes, 1, size + 1, file) != size) {
        fprintf(stderr, "xr_picture: %s is not there, or has not %zu bytes\n", path, size);
        exit(1);
    }
    fclose(file);
    return bytes;
}

/* `hidden`: the part of the picture that the mask covers; pixels at its edge may be on either side. */
static bool is_masked(size_t count, size_t pixels, double hidden) {
    return (double)count <= hidden * (double)pixels + (hidden > 0 ? 2 * sqrt((double)pixels) : 0);
}

static void check_color(const uint8_t *given, const uint8_t *own, size_t pixels, bool swapped, double hidden, uint32_t view) {
    size_t wrong = 0, black = 0;
    for (size_t i = 0; i < pixels; i++) {
        bool differs = false;
        for (uint32_t c = 0; c < 4; c++) differs = differs || given[4 * i + c] != own[4 * i + (swapped && c < 3 ? 2 - c : c)];
        if (given[4 * i] + given[4 * i + 1] + given[4 * i + 2] == 0) black += differs;
        else wrong += differs;
    }
    if (!wrong && is_masked(black, pixels, hidden)) return;
    fprintf(stderr, "xr_picture: view %u: %zu of %zu pixels differ, %zu are black instead; %g of the picture is hidden\n", view, wrong, pixels, black, hidden);
    exit(1);
}

/* `own`: RGBA32F with the view depth in W. */
static void check_depth(const float *given, const float *own, size_t pixels, float near_distance, bool forward, double hidden, uint32_t view) {
    size_t wrong = 0, seen = 0, covered = 0; /* by the mask, which is nearest of all */
    for (size_t i = 0; i < pixels; i++) {
        const float depth = forward ? 1 - given[i] : given[i], distance = own[4 * i + 3];
        seen += distance > 0;
        covered += depth == 1;
        if (depth == 1) continue;
        wrong += distance > 0 ? !(fabsf(depth - near_distance / distance) <= 1e-6f + 2e-5f * depth) : depth != 0;
    }
    if (!wrong && seen > 0 && is_masked(covered, pixels, hidden) && (hidden < 0.02 || (double)covered > hidden / 4 * (double)pixels)) return;
    fprintf(stderr, "xr_picture: view %u: the depth of %zu of %zu pixels is wrong; %zu show something, %zu are covered; %g of the picture is hidden\n", view, wrong, pixels,
            seen, covered, hidden);
    exit(1);
}

int main(int argc, char **argv) {
    if (argc < 7) return fail("wrong arguments");
    const char *folder = argv[2], *number_text = argv[3];
    const bool swapped = strcmp(argv[5], "bgra") == 0, has_depth = strcmp(argv[6], "none") != 0, forward = strcmp(argv[6], "forward") == 0;
    json_error_t error;
    json_t *stats = json_load_file(argv[1], 0, &error);
    const json_t *last = json_object_get(stats, "last"), *views = json_object_get(last, "views"), *rig_json = json_object_get(last, "rig");
    const json_t *r = json_object_get(rig_json, "rotation");
    const fnl_rigid_pose rig = {vector(json_object_get(rig_json, "position")),
                                {number(json_array_get(r, 0)), number(json_array_get(r, 1)), number(json_array_get(r, 2)), number(json_array_get(r, 3))}};
    const json_t *point = json_object_get(json_object_get(stats, "gaze"), "point");
    const fnl_vec3 gaze = vector(point);
    fnl_eye eyes[VIEWS];
    fnl_camera cameras[VIEWS];
    const uint32_t count = read_eyes(folder, number_text, eyes);
    if (count == 0 || json_array_size(views) != count) return fail("views were expected");
    const float scale = number(json_object_get(stats, "world_scale"));
    for (uint32_t i = 0; i < count; i++) {
        fnl_vec3 *place = &eyes[i].pose.position;
        *place = (fnl_vec3){place->x * scale, place->y * scale, place->z * scale};
    }
    fnl_scene *scene = NULL;
    fnl_scene_info info;
    fnl_device *device = NULL;
    fnl_device_params params = fnl_device_params_default();
    if (fnl_scene_load(NULL, argv[4], NULL, &scene) != FNL_OK || fnl_scene_query_info(scene, &info) != FNL_OK || fnl_device_create(&params, &device) != FNL_OK)
        return fail("no scene or device");
    for (uint32_t first = 0, together; first < count; first += together) { /* views of one size */
        const json_t *size = json_object_get(json_array_get(views, first), "size");
        fnl_frame frame = frame_plain();
        fnl_renderer *renderer = NULL;
        fnl_image color, normal = {0};
        frame.width = (uint32_t)json_integer_value(json_array_get(size, 0));
        frame.height = (uint32_t)json_integer_value(json_array_get(size, 1));
        frame.shadows = info.light_count ? FNL_SHADOWS_MAPS : FNL_SHADOWS_OFF;
        frame.exposure = FNL_EXPOSURE_EV;
        for (int i = 7; i < argc; i++) {
            char *value = strchr(argv[i], '=');
            if (!value) return fail("an option is KEY=VALUE");
            char key[64];
            snprintf(key, sizeof key, "%.*s", (int)(value - argv[i]), argv[i]);
            if (strcmp(key, "ev") == 0) frame.ev = strtof(value + 1, NULL);
            else if (fnl_frame_set(NULL, &frame, key, value + 1) != FNL_OK) return fail("an option is wrong");
        }
        for (together = 0; first + together < count; together++) {
            const json_t *view = json_array_get(views, first + together);
            if (!json_equal(json_object_get(view, "size"), size)) break;
            if (fnl_eye_query_camera(NULL, &eyes[first + together], &rig, frame.width, frame.height, number(json_object_get(view, "near_distance")),
                                     &cameras[together]) != FNL_OK)
                return fail("an eye is wrong");
        }
        frame.views = cameras;
        frame.view_count = together;
        frame.stereo.eyes = together > 1 ? together : 0;
        frame.gaze = json_is_array(point) ? &gaze : NULL;
        frame.outputs = FNL_OUTPUT_COLOR | (has_depth ? FNL_OUTPUT_NORMAL : 0);
        if (fnl_renderer_create(device, scene, &renderer) != FNL_OK || fnl_renderer_render(renderer, &frame) != FNL_OK ||
            fnl_renderer_read(renderer, FNL_OUTPUT_COLOR, &color) != FNL_OK || (has_depth && fnl_renderer_read(renderer, FNL_OUTPUT_NORMAL, &normal) != FNL_OK))
            return fail("nothing was rendered");
        const size_t pixels = (size_t)frame.width * frame.height;
        for (uint32_t i = 0; i < together; i++) {
            const double hidden = json_number_value(json_object_get(json_array_get(views, first + i), "hidden"));
            uint8_t *given = read_raw(folder, "color", number_text, first + i, pixels * 4);
            check_color(given, (const uint8_t *)color.pixels + i * pixels * 4, pixels, swapped, hidden, first + i);
            free(given);
            if (!has_depth) continue;
            float *depth = read_raw(folder, "depth", number_text, first + i, pixels * 4);
            check_depth(depth, (const float *)normal.pixels + i * pixels * 4, pixels, cameras[i].near_distance, forward, hidden, first + i);
            free(depth);
        }
        fnl_image_free(NULL, &color);
        fnl_image_free(NULL, &normal);
        fnl_renderer_destroy(&renderer);
    }
    fnl_device_destroy(&device);
    fnl_scene_destroy(&scene);
    json_decref(stats);
    return 0;
}
