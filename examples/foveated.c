/* SPDX-License-Identifier: MIT */
/*
 * Renders an eye's picture with fewer pixels toward its edges, as a lens shows it:  foveated [SCENE [PICTURE.png [cells|quadrants]]]
 * cells: 3 x 3 cells of four sizes, which take four frames. quadrants: four tilted quadrants of the same size, which take one frame. This example joins them
 * on the CPU; a program that warps the picture for its lens can sample the parts in that pass instead.
 */
#include <fanal/fanal.h>

#include <stdio.h>
#include <string.h>

enum { WIDTH = 480, HEIGHT = 480, MOST = 9 };

/* Renders parts of one size as views of one frame; their pictures stand one below the other in `all`, which the caller frees. */
static fnl_result render_parts(fnl_renderer *renderer, fnl_frame frame, const fnl_rigid_pose *head, const fnl_eye_cell *cells,
                               const int *which, int count, fnl_image *all, fnl_image pictures[MOST]) {
    fnl_camera cameras[4];
    fnl_result result = FNL_OK;
    frame.width = cells[which[0]].rendered_width;
    frame.height = cells[which[0]].rendered_height;
    for (int i = 0; i < count && result == FNL_OK; i++)
        result = fnl_eye_query_camera(NULL, &cells[which[i]].eye, head, frame.width, frame.height, 0.05f, &cameras[i]);
    frame.camera = cameras[0];
    frame.views = cameras;
    frame.view_count = (uint32_t)count;
    if (result == FNL_OK) result = fnl_renderer_render(renderer, &frame);
    if (result == FNL_OK) result = fnl_renderer_read(renderer, FNL_OUTPUT_COLOR, all);
    for (int i = 0; i < count && result == FNL_OK; i++) {
        const size_t bytes = (size_t)frame.width * frame.height * fnl_pixel_size(all->format);
        pictures[which[i]] = (fnl_image){frame.width, frame.height, all->format, (char *)all->pixels + (size_t)i * bytes};
    }
    return result;
}

/* All parts use the exposure of the whole picture, metered at a small size; otherwise each frame would choose its own. */
static fnl_result meter(fnl_renderer *renderer, const fnl_eye *eye, const fnl_rigid_pose *head, fnl_frame *frame) {
    fnl_frame small = *frame;
    fnl_frame_stats stats;
    small.width = small.height = 96;
    fnl_result result = fnl_eye_query_camera(NULL, eye, head, small.width, small.height, 0.05f, &small.camera);
    if (result == FNL_OK) result = fnl_renderer_render(renderer, &small);
    if (result == FNL_OK) result = fnl_renderer_query_stats(renderer, &stats);
    if (result != FNL_OK) return result;
    frame->exposure = FNL_EXPOSURE_EV;
    frame->ev = stats.ev;
    return FNL_OK;
}

static fnl_result render(fnl_device *device, fnl_scene *scene, bool quadrants, const char *path) {
    static const int groups[5][4] = {{4}, {0, 2, 6, 8}, {3, 5}, {1, 7}, {0, 1, 2, 3}}, counts[5] = {1, 4, 2, 2, 4};
    const fnl_eye eye = {{{0, 0, 0}, {0, 0, 0, 1}}, -1, 1, -1, 1}; /* 90 degrees */
    const fnl_rigid_pose head = {{0, 1.7f, 0}, {0, 0, 0, 1}};
    fnl_frame frame = fnl_frame_default();
    fnl_renderer *renderer = NULL;
    fnl_eye_cell cells[MOST];
    fnl_image all[5] = {0}, pictures[MOST], joined = {0};
    uint64_t pixels = 0;
    fnl_result result = fnl_renderer_create(device, scene, &renderer);
    if (result == FNL_OK) result = meter(renderer, &eye, &head, &frame);
    if (result == FNL_OK && quadrants) result = fnl_eye_query_quadrants(NULL, &eye, WIDTH, HEIGHT, (fnl_vec2){0.35f, 0.35f}, cells);
    if (result == FNL_OK && !quadrants) result = fnl_eye_query_cells(NULL, &eye, WIDTH, HEIGHT, 0.6f, 0.5f, cells);
    for (int g = quadrants ? 4 : 0; g < (quadrants ? 5 : 4) && result == FNL_OK; g++) {
        result = render_parts(renderer, frame, &head, cells, groups[g], counts[g], &all[g], pictures);
        pixels += (uint64_t)all[g].width * all[g].height;
    }
    if (result == FNL_OK) result = fnl_eye_join_cells(NULL, &eye, cells, quadrants ? 4 : 9, pictures, &joined);
    if (result == FNL_OK) result = fnl_image_save(NULL, path, &joined);
    if (result == FNL_OK)
        printf("%s written: %d x %d pixels; %.0f %% as many were rendered\n", path, WIDTH, HEIGHT, 100.0 * (double)pixels / (WIDTH * HEIGHT));
    for (int g = 0; g < 5; g++) fnl_image_free(NULL, &all[g]);
    fnl_image_free(NULL, &joined);
    fnl_renderer_destroy(&renderer);
    return result;
}

int main(int argc, char **argv) {
    const char *source = argc > 1 ? argv[1] : "builtin:hall?lights=256", *path = argc > 2 ? argv[2] : "foveated.png";
    fnl_scene *scene = NULL;
    fnl_device *device = NULL;
    fnl_result result = fnl_scene_load(NULL, source, NULL, &scene);
    if (result == FNL_OK) result = fnl_device_create(NULL, &device);
    if (result == FNL_OK) result = render(device, scene, argc > 3 && strcmp(argv[3], "quadrants") == 0, path);
    fnl_device_destroy(&device);
    fnl_scene_destroy(&scene);
    if (result == FNL_OK) return 0;
    fprintf(stderr, "foveated: %s\n", fnl_result_name(result)); /* the log on stderr says more */
    return 1;
}
