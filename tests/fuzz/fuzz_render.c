/* SPDX-License-Identifier: MIT */
/*
 * Frames of scenes that the importer took, and of such that calls have made, with edits between them: no crash, no message of the validation layer,
 * no NaN in the picture. Slow: only small scenes, tiny pictures, and few ways to render, whose pipelines are soon made.
 */
#include "render/renderer_internal.h"
#include "tests/fuzz/calls.h"
#include "../frame_plain.h"

enum { FRAMES_MAX = 4, TEXELS_MAX = 1 << 16, VERTICES_MAX = 4096, LIGHTS_MAX = 512 };

/* One for all inputs; never destroyed, as the driver's own leaks are none of ours. */
static fnl_device *find_device(void) {
    static fnl_device *device;
    if (device) return device;
    fnl_device_params params = fnl_device_params_default();
    params.host.log = fuzz_drop_line;
    params.host.thread_count = 1;
    params.cache_folder = "";
    params.validate = true;
    if (fnl_device_create(&params, &device) != FNL_OK) abort();
    return device;
}

static bool is_small(const fnl_scene *scene) {
    uint64_t texels = 0, vertices = 0;
    for (uint32_t i = 0; i < scene->images.count; i++)
        texels += (uint64_t)scene->images.data[i].width * scene->images.data[i].height;
    for (uint32_t i = 0; i < scene->primitives.count; i++)
        vertices += scene->primitives.data[i].vertex_count + scene->primitives.data[i].index_count;
    fnl_scene_info info;
    if (fnl_scene_query_info(scene, &info) != FNL_OK) abort();
    return texels <= TEXELS_MAX && vertices <= VERTICES_MAX && info.triangle_count <= VERTICES_MAX &&
           info.light_count <= LIGHTS_MAX && info.decal_count <= LIGHTS_MAX;
}

static void check_picture(fnl_renderer *renderer) {
    fnl_image image;
    fnl_host host = fuzz_host();
    if (fnl_renderer_read(renderer, FNL_OUTPUT_RADIANCE, &image) != FNL_OK) abort();
    const float *values = image.pixels;
    for (size_t i = 0; i < (size_t)image.width * image.height * 4; i++)
        if (isnan(values[i])) abort();
    fnl_image_free(&host, &image);
}

static void render(struct fuzz_input *in, const fnl_scene *scene, fnl_renderer *renderer) {
    static const struct {
        fnl_shading shading;
        fnl_light_lists lists;
    } ways[] = {{FNL_SHADING_FORWARD, FNL_LISTS_ALL},
                {FNL_SHADING_DEFERRED, FNL_LISTS_TILED},
                {FNL_SHADING_DEFERRED, FNL_LISTS_CLUSTERED},
                {FNL_SHADING_VISIBILITY, FNL_LISTS_BVH}};
    fnl_frame frame = frame_plain();
    uint8_t way = fuzz_byte(in), camera = fuzz_byte(in);
    frame.width = 24;
    frame.height = 16;
    frame.shading = ways[way % COUNT_OF(ways)].shading;
    frame.lists = ways[way % COUNT_OF(ways)].lists;
    frame.timers = false;
    frame.culling = way & 64 ? FNL_CULLING_TRIANGLES : FNL_CULLING_INSTANCES;
    frame.outputs = FNL_OUTPUT_COLOR | FNL_OUTPUT_RADIANCE;
    uint32_t count = fnl_scene_count(scene, FNL_ENTITY_CAMERA);
    if (camera < 128 && count)
        fnl_scene_query_camera(scene, camera % count, &frame.camera);
    else if (fnl_scene_query_framing_camera(scene, 1.5f, &frame.camera) != FNL_OK)
        return;
    if (camera >= 240) {
        frame.camera.position = fuzz_vec3(in);
        frame.camera.target = fuzz_vec3(in);
        frame.camera.near_distance = fuzz_float(in);
        frame.ev = fuzz_float(in);
        frame.exposure = FNL_EXPOSURE_EV;
    }
    fnl_result result = fnl_renderer_render(renderer, &frame);
    if (result == FNL_ERROR_DEVICE_LOST) abort();
    if (result == FNL_OK) check_picture(renderer);
}

/* The first byte: how many bytes are of calls and frames; behind them is a glTF file, or nothing for an empty scene. */
int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size) {
    fnl_host host = fuzz_host();
    if (size == 0) return 0;
    size_t program = MIN((size_t)*bytes, size - 1);
    struct fuzz_input in = {bytes + 1, program};
    struct calls calls = {0};
    fnl_scene *scene;
    fnl_renderer *renderer;
    const uint8_t *file = bytes + 1 + program;
    size_t file_size = size - 1 - program;
    if ((file_size ? gltf_load_memory(&host, file, file_size, "input", NULL, &scene) : fnl_scene_create(&host, &scene)) !=
        FNL_OK)
        return 0;
    fnl_scene_set_ambient(scene, (fnl_vec3){1, 2, 3}, (fnl_vec3){1, 1, 1}); /* so that there is something to see */
    if (is_small(scene) && fnl_renderer_create(find_device(), scene, &renderer) == FNL_OK) {
        for (int frame = 0; frame < FRAMES_MAX && (frame == 0 || in.size > 0); frame++) {
            for (uint8_t count = fuzz_byte(&in) % 16; count > 0 && in.size > 0; count--) calls_make(&in, scene, &calls);
            if (!is_small(scene)) break;
            render(&in, scene, renderer);
        }
        fnl_renderer_destroy(&renderer);
        if (fnl_device_validation_count(find_device())) abort();
    }
    fnl_scene_destroy(&scene);
    return 0;
}
