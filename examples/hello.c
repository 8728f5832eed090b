/* SPDX-License-Identifier: MIT */
/* Loads a scene, lights it, renders it, saves the picture:  hello [SCENE [PICTURE.png]] */
#include <fanal/fanal.h>

#include <stdio.h>

static fnl_result render(fnl_device *device, fnl_scene *scene, const char *path) {
    fnl_frame frame = fnl_frame_default();
    frame.width = 640;
    frame.height = 360;
    fnl_result result = fnl_scene_count(scene, FNL_ENTITY_CAMERA) > 0
                            ? fnl_scene_query_camera(scene, 0, &frame.camera)
                            : fnl_scene_query_framing_camera(scene, 640.0f / 360.0f, &frame.camera);
    fnl_renderer *renderer = NULL;
    fnl_image image = {0};
    if (result == FNL_OK) result = fnl_renderer_create(device, scene, &renderer);
    if (result == FNL_OK) result = fnl_renderer_render(renderer, &frame);
    if (result == FNL_OK) result = fnl_renderer_read(renderer, FNL_OUTPUT_COLOR, &image);
    if (result == FNL_OK) result = fnl_image_save(NULL, path, &image);
    fnl_image_free(NULL, &image);
    fnl_renderer_destroy(&renderer);
    return result;
}

int main(int argc, char **argv) {
    const char *source = argc > 1 ? argv[1] : "builtin:spheres?lights=0", *path = argc > 2 ? argv[2] : "hello.png";
    fnl_scene *scene = NULL;
    fnl_device *device = NULL;
    fnl_result result = fnl_scene_load(NULL, source, NULL, &scene);
    if (result == FNL_OK) result = fnl_scene_scatter_lights(scene, 200, 1);
    if (result == FNL_OK) result = fnl_device_create(NULL, &device);
    if (result == FNL_OK) result = render(device, scene, path);
    fnl_device_destroy(&device);
    fnl_scene_destroy(&scene);
    if (result != FNL_OK) { /* the log on stderr says more */
        fprintf(stderr, "hello: %s\n", fnl_result_name(result));
        return 1;
    }
    printf("%s written\n", path);
    return 0;
}
