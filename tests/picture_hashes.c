/* SPDX-License-Identifier: MIT */
/*
 * Prints a hash of the picture of every shading order with every kind of light lists, and of the ways that one order or another has, so that
 * a change that must keep all pictures to the bit can be compared with what was before:
 *   picture_hashes > before.txt; …; picture_hashes | diff before.txt -
 * The hashes belong to one driver and are not kept.
 */
#include "frame_plain.h"
#include <fanal/fanal.h>

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

static uint64_t hash_of(uint64_t hash, const void *data, size_t size) { /* FNV-1a */
    const unsigned char *bytes = data;
    for (size_t i = 0; i < size; i++) hash = (hash ^ bytes[i]) * 1099511628211u;
    return hash;
}

/* Pairs that a driver or an order does not have stand in the list as such. */
static void log_nothing(void *user, fnl_log_level level, const char *line) {
    (void)user, (void)level, (void)line;
}

struct stage {
    const char *source;
    fnl_device *device;
    fnl_scene *scene;
    fnl_renderer *renderer;
    fnl_frame frame;
};

static fnl_result hash_output(struct stage *s, fnl_output output, uint64_t *hash) {
    fnl_image image = {0};
    fnl_result result = fnl_renderer_read(s->renderer, output, &image);
    if (result == FNL_OK) *hash = hash_of(*hash, image.pixels, fnl_pixel_size(image.format) * image.width * image.height);
    fnl_image_free(NULL, &image);
    return result;
}

static void print_hash(struct stage *s, const fnl_frame *frame, const char *variant) {
    uint64_t hash = 14695981039346656037u;
    fnl_result result = fnl_renderer_render(s->renderer, frame);
    for (uint32_t bit = 1; bit <= frame->outputs && result == FNL_OK; bit *= 2)
        if (frame->outputs & bit) result = hash_output(s, (fnl_output)bit, &hash);
    printf("%s %s %s %s ", s->source, fnl_value_name(FNL_ENUM_SHADING, frame->shading), fnl_value_name(FNL_ENUM_LISTS, frame->lists), variant);
    if (result == FNL_OK) printf("%016" PRIx64 "\n", hash);
    else printf("%s\n", fnl_result_name(result));
    fflush(stdout);
}

static void print_lists(struct stage *s) {
    fnl_frame frame = s->frame;
    for (frame.shading = 0; frame.shading < FNL_SHADING_AUTO; frame.shading++)
        for (frame.lists = 0; frame.lists < FNL_LISTS_AUTO; frame.lists++)
            if (fnl_shading_supports(frame.shading, frame.lists, frame.msaa)) print_hash(s, &frame, "plain");
}

/* What goes with most orders, one after the other. */
static void print_ways(struct stage *s) {
    for (fnl_shading shading = 0; shading < FNL_SHADING_AUTO; shading++) {
        fnl_frame plain = s->frame;
        plain.shading = shading;
        plain.lists = FNL_LISTS_CLUSTERED;
        fnl_frame frame = plain;
        frame.msaa = 4;
        if (fnl_shading_supports(shading, FNL_LISTS_AUTO, 4)) print_hash(s, &frame, "msaa");
        frame = plain;
        frame.transparency = FNL_TRANSPARENCY_LINKED;
        print_hash(s, &frame, "linked");
        frame.transparency = FNL_TRANSPARENCY_WEIGHTED;
        print_hash(s, &frame, "weighted");
        frame = plain;
        frame.decals = FNL_DECALS_GBUFFER;
        print_hash(s, &frame, "decals-gbuffer");
        frame = plain;
        frame.culling = FNL_CULLING_TRIANGLES;
        frame.occlusion = true;
        print_hash(s, &frame, "culled");
        frame = plain;
        frame.aa = FNL_ANTIALIASING_SMAA;
        print_hash(s, &frame, "smaa");
        frame.aa = FNL_ANTIALIASING_TAA;
        print_hash(s, &frame, "taa");
        frame = plain;
        frame.outputs |= FNL_OUTPUT_SURFACE | FNL_OUTPUT_NORMAL | FNL_OUTPUT_POSITION;
        print_hash(s, &frame, "aov");
        frame = plain;
        for (frame.debug = 1; frame.debug < FNL_DEBUG_COUNT; frame.debug++)
            print_hash(s, &frame, fnl_value_name(FNL_ENUM_DEBUG_VIEW, frame.debug));
    }
}

static fnl_result print_scene(fnl_device *device, const char *source, bool ways) {
    struct stage s = {.source = source, .device = device, .frame = frame_plain()};
    s.frame.width = 71;
    s.frame.height = 41;
    s.frame.exposure = FNL_EXPOSURE_EV;
    s.frame.ev = 8;
    s.frame.outputs = FNL_OUTPUT_COLOR | FNL_OUTPUT_RADIANCE;
    s.frame.timers = false;
    fnl_result result = scene_load_plain(NULL, source, NULL, &s.scene);
    if (result == FNL_OK)
        result = fnl_scene_count(s.scene, FNL_ENTITY_CAMERA) > 0
                     ? fnl_scene_query_camera(s.scene, 0, &s.frame.camera)
                     : fnl_scene_query_framing_camera(s.scene, 71.0f / 41.0f, &s.frame.camera);
    if (result == FNL_OK) result = fnl_renderer_create(device, s.scene, &s.renderer);
    if (result == FNL_OK) {
        print_lists(&s);
        if (ways) print_ways(&s);
    }
    fnl_renderer_destroy(&s.renderer);
    fnl_scene_destroy(&s.scene);
    return result;
}

int main(void) {
    fnl_device *device = NULL;
    fnl_device_params params = fnl_device_params_default();
    params.host.log = log_nothing;
    fnl_result result = fnl_device_create(&params, &device);
    if (result == FNL_OK) result = print_scene(device, "builtin:glass?lights=40", true);
    if (result == FNL_OK) result = print_scene(device, "builtin:hall?lights=300", false);
    if (result == FNL_OK) result = print_scene(device, "builtin:grass?lights=100", false);
    fnl_device_destroy(&device);
    return result == FNL_OK ? 0 : 1;
}
