/* SPDX-License-Identifier: MIT */
/*
 * Prints a picture hash, pass count and bytes moved for every shading path with every light list, and for options of
 * some paths: shadows, views, eyes, environments, probes, layers, kinds of lights, masks. Compare before and after a change that must keep pictures
 * bit-identical:
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
    fnl_frame_stats stats = {0};
    fnl_result result = fnl_renderer_render(s->renderer, frame);
    for (uint32_t bit = 1; bit <= frame->outputs && result == FNL_OK; bit *= 2)
        if (frame->outputs & bit) result = hash_output(s, (fnl_output)bit, &hash);
    if (result == FNL_OK) result = fnl_renderer_query_stats(s->renderer, &stats);
    printf("%s %s %s %s ", s->source, fnl_value_name(FNL_ENUM_SHADING, frame->shading), fnl_value_name(FNL_ENUM_LISTS, frame->lists), variant);
    if (result == FNL_OK) printf("%016" PRIx64 " %u passes %" PRIu64 " bytes\n", hash, stats.pass_count, stats.image_bytes_read + stats.image_bytes_written);
    else printf("%s\n", fnl_result_name(result));
    fflush(stdout);
}

static void print_lists(struct stage *s) {
    fnl_frame frame = s->frame;
    for (frame.shading = 0; frame.shading < FNL_SHADING_AUTO; frame.shading++)
        for (frame.lists = 0; frame.lists < FNL_LISTS_AUTO; frame.lists++)
            if (fnl_shading_supports(frame.shading, frame.lists, frame.msaa)) print_hash(s, &frame, "plain");
}

/* What goes with most orders: options as fnl_frame_set() takes them, of one view, two views, or two eyes. */
static const struct way {
    const char *name;
    uint32_t views;
    bool eyes;
    uint32_t outputs;
    const char *options[8]; /* key, value, … */
} ways[] = {
    {"msaa", 1, false, 0, {"msaa", "4"}},
    {"linked", 1, false, 0, {"transparency", "linked"}},
    {"weighted", 1, false, 0, {"transparency", "weighted"}},
    {"decals-gbuffer", 1, false, 0, {"decals", "gbuffer"}},
    {"culled", 1, false, 0, {"culling", "triangles", "occlusion", "on"}},
    {"smaa", 1, false, 0, {"aa", "smaa"}},
    {"taa", 1, false, 0, {"aa", "taa"}},
    {"metered", 1, false, 0, {"exposure", "auto"}},
    {"light-lod", 1, false, 0, {"light-lod", "3"}},
    {"aov", 1, false, FNL_OUTPUT_SURFACE | FNL_OUTPUT_NORMAL | FNL_OUTPUT_POSITION, {NULL}},
    {"shadows-rays", 1, false, 0, {"shadows", "rays"}},
    {"shadows-maps", 1, false, 0, {"shadows", "maps"}},
    {"shadows-filtered", 1, false, 0, {"shadows", "maps", "shadow.filter", "pcf", "shadow.light-radius", "0.1"}},
    {"shadows-hybrid", 1, false, 0, {"shadows", "hybrid"}},
    {"shadows-cubemap", 1, false, 0, {"shadows", "cubemap"}},
    {"shadows-sampled", 1, false, 0, {"shadows", "sampled"}},
    {"shadows-guided", 1, false, 0, {"shadows", "sampled", "shadow.denoise", "on", "shadow.guide", "on"}},
    {"views", 2, false, 0, {"multiview", "off"}},
    {"views-at-once", 2, false, 0, {"multiview", "on", "shadows", "maps"}},
    {"eyes", 2, true, 0, {"stereo.path", "eyes", "shadows", "maps"}},
    {"eyes-at-once", 2, true, 0, {"stereo.path", "multiview", "exposure", "auto"}},
    {"eyes-occlusion", 2, true, 0, {"occlusion", "on", "stereo.lists", "eye"}},
    {"eyes-far", 2, true, 0, {"stereo.mono-distance", "9", "shadows", "rays"}},
    {"eyes-far-maps", 2, true, 0, {"stereo.mono-distance", "9", "shadows", "maps", "stereo.path", "multiview"}},
};

static void print_way(struct stage *s, const fnl_frame *plain, const struct way *way) {
    fnl_frame frame = *plain;
    fnl_camera cameras[2] = {frame.camera, frame.camera};
    bool known = true;
    for (uint32_t i = 0; i + 1 < sizeof way->options / sizeof *way->options && way->options[i]; i += 2)
        known = fnl_frame_set(NULL, &frame, way->options[i], way->options[i + 1]) == FNL_OK && known;
    if (!known) {
        printf("%s: its options are not known\n", way->name);
        return;
    }
    if (frame.msaa > 1 && !fnl_shading_supports(frame.shading, FNL_LISTS_AUTO, frame.msaa)) return;
    cameras[0].position.x -= 0.032f, cameras[0].target.x -= 0.032f;
    cameras[1].position.x += 0.032f, cameras[1].target.x += 0.032f;
    if (way->views > 1) frame.views = cameras, frame.view_count = way->views;
    if (way->eyes) frame.stereo.eyes = way->views;
    frame.outputs |= way->outputs;
    print_hash(s, &frame, way->name);
}

static void print_ways(struct stage *s) {
    for (fnl_shading shading = 0; shading < FNL_SHADING_AUTO; shading++) {
        fnl_frame plain = s->frame;
        plain.shading = shading;
        plain.lists = FNL_LISTS_CLUSTERED;
        for (uint32_t i = 0; i < sizeof ways / sizeof *ways; i++) print_way(s, &plain, &ways[i]);
        for (plain.debug = 1; plain.debug < FNL_DEBUG_COUNT; plain.debug++) print_hash(s, &plain, fnl_value_name(FNL_ENUM_DEBUG_VIEW, plain.debug));
    }
}

/* The environment and reflection probes. */
static void print_surroundings(struct stage *s) {
    fnl_environment_params environment = fnl_environment_params_default();
    fnl_probe_params probe = fnl_probe_params_default();
    environment.source = "builtin:overcast";
    probe.reflection = true;
    uint32_t count;
    if (fnl_scene_set_environment(s->scene, &environment) != FNL_OK || fnl_scene_place_probes(s->scene, &probe, 2, &count) != FNL_OK) return;
    static const struct way surrounded[] = {{"surrounded", 1, false, 0, {NULL}},
                                            {"surrounded-shadows", 1, false, 0, {"shadows", "maps"}},
                                            {"surrounded-eyes", 2, true, 0, {"shadows", "rays"}},
                                            {"surrounded-eyes-far", 2, true, 0, {"stereo.mono-distance", "9"}}};
    for (fnl_shading shading = 0; shading < FNL_SHADING_AUTO; shading++) {
        fnl_frame plain = s->frame;
        plain.shading = shading;
        plain.lists = FNL_LISTS_CLUSTERED;
        for (uint32_t i = 0; i < sizeof surrounded / sizeof *surrounded; i++) print_way(s, &plain, &surrounded[i]);
    }
}

/* Materials with layers, which some paths draw over the others; lights of all kinds; surfaces with light masks. */
static void print_special(struct stage *s) {
    const uint32_t materials = fnl_scene_count(s->scene, FNL_ENTITY_MATERIAL), instances = fnl_scene_count(s->scene, FNL_ENTITY_INSTANCE);
    for (uint32_t i = 0; i < materials; i++) {
        fnl_entity_info entity;
        fnl_material_params material;
        if (fnl_scene_query_entity(s->scene, FNL_ENTITY_MATERIAL, i, &entity) != FNL_OK || fnl_scene_query_material(s->scene, i, &material) != FNL_OK) continue;
        if (i % 3 == 0) material.clearcoat = (fnl_clearcoat_params){.strength = 0.8f, .roughness = 0.2f}, material.anisotropy.strength = 0.6f;
        if (i % 3 == 1) material.sheen.color[0] = 0.7f, material.sheen.color[2] = 0.5f, material.sheen.roughness = 0.4f, material.iridescence.strength = 0.5f;
        if (i % 3 == 2) material.diffuse_transmission.strength = 0.4f, material.diffuse_transmission.color[1] = 1;
        if (fnl_scene_set_material(s->scene, entity.id.material, &material) != FNL_OK) printf("material %u stays as it was\n", i);
    }
    fnl_scatter_params scatter = fnl_scatter_params_default();
    scatter.count = 24;
    for (int kind = FNL_LIGHT_POINT; kind < FNL_LIGHT_KIND_COUNT; kind++) scatter.shares[kind] = 1;
    if (fnl_scene_scatter_light_shapes(s->scene, &scatter) != FNL_OK) return;
    static const struct way layered[] = {{"layered", 1, false, 0, {NULL}},
                                         {"layered-msaa", 1, false, 0, {"msaa", "4"}},
                                         {"layered-gbuffer", 1, false, 0, {"gbuffer.layout", "layers"}},
                                         {"layered-rays", 1, false, 0, {"shadows", "rays", "shadow.samples", "4", "shadow.light-radius", "0.1"}},
                                         {"layered-maps", 1, false, 0, {"shadows", "maps"}},
                                         {"layered-eyes", 2, true, 0, {"shadows", "maps"}}};
    static const struct way masked[] = {{"masked", 1, false, 0, {NULL}}, {"masked-maps", 1, false, 0, {"shadows", "maps", "shadow.contact-length", "0.2"}}};
    for (int masks = 0; masks < 2; masks++) {
        const struct way *all = masks ? masked : layered;
        const uint32_t count = masks ? sizeof masked / sizeof *masked : sizeof layered / sizeof *layered;
        for (uint32_t i = 0; masks && i < instances; i++) {
            fnl_entity_info entity;
            if (fnl_scene_query_entity(s->scene, FNL_ENTITY_INSTANCE, i, &entity) == FNL_OK) fnl_scene_set_instance_light_mask(s->scene, entity.id.instance, i % 2 ? 1 : 255);
        }
        for (uint32_t i = 0; masks && i < fnl_scene_count(s->scene, FNL_ENTITY_LIGHT); i += 2) {
            fnl_entity_info entity;
            fnl_light_params light;
            if (fnl_scene_query_entity(s->scene, FNL_ENTITY_LIGHT, i, &entity) != FNL_OK || fnl_scene_query_light(s->scene, i, &light) != FNL_OK) continue;
            light.mask = 2;
            fnl_scene_set_light(s->scene, entity.id.light, &light);
        }
        for (fnl_shading shading = 0; shading < FNL_SHADING_AUTO; shading++) {
            fnl_frame plain = s->frame;
            plain.shading = shading;
            for (uint32_t i = 0; i < count; i++) {
                plain.lists = FNL_LISTS_CLUSTERED;
                print_way(s, &plain, &all[i]);
            }
            for (plain.lists = 0; plain.lists < FNL_LISTS_AUTO && !masks; plain.lists++)
                if (fnl_shading_supports(shading, plain.lists, 1)) print_hash(s, &plain, "layered");
        }
    }
}

static fnl_result print_scene(fnl_device *device, const char *source, bool more) {
    struct stage s = {.source = source, .device = device, .frame = frame_plain()};
    s.frame.width = 71;
    s.frame.height = 41;
    s.frame.exposure = FNL_EXPOSURE_EV;
    s.frame.ev = 8;
    s.frame.outputs = FNL_OUTPUT_COLOR | FNL_OUTPUT_RADIANCE;
    fnl_result result = scene_load_plain(NULL, source, NULL, &s.scene);
    if (result == FNL_OK)
        result = fnl_scene_count(s.scene, FNL_ENTITY_CAMERA) > 0
                     ? fnl_scene_query_camera(s.scene, 0, &s.frame.camera)
                     : fnl_scene_query_framing_camera(s.scene, 71.0f / 41.0f, &s.frame.camera);
    if (result == FNL_OK) result = fnl_renderer_create(device, s.scene, &s.renderer);
    if (result == FNL_OK) {
        print_lists(&s);
        if (more) print_ways(&s);
        if (more) print_surroundings(&s);
        if (more) print_special(&s);
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
