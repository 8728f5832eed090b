/* SPDX-License-Identifier: MIT */
/* fanal devices: the Vulkan devices of this machine. */
#include "argument_next.h"
#include "commands.h"
#include "json_text.h"
#include "print.h"

#include "fanal/device.h"

#include <jansson.h>
#include <stdio.h>
#include <stdlib.h>

enum { MAX_DEVICES = 64 };

static void print_help(void) {
    puts("Usage: fanal devices [--json]\n"
         "\n"
         "Lists the Vulkan devices by index, whether Fanal can use them, and which optional features are there.\n"
         "\n"
         "  --json            prints JSON\n"
         "  -h, --help        prints this text\n"
         "\n"
         "Exit status: 0 when a usable device was found, 2 when none was.\n"
         "\n"
         "Examples:\n"
         "  fanal devices\n"
         "  fanal render scene.glb --device 1 -o out.png");
}

/* Optional features, and what they are for. */
static const struct {
    const char *name, *use;
    size_t offset;
} features[] = {
#define FEATURE(field, use)                                                                                                 \
    { #field, use, offsetof(fnl_device_info, field) }
    FEATURE(async_compute, "builds light lists while drawing"),
    FEATURE(timestamps, "measures the time of each pass"),
    FEATURE(primitive_ids, "visibility and dais shading, coarse.criterion=id, --debug clusters"),
    FEATURE(minmax_samplers, "coarse.criterion=minmax reads fewer texels"),
    FEATURE(post_depth_coverage, "dais.mode=list stores fewer elements with MSAA"),
    FEATURE(vertex_layers, "--stereo-path objects and instances"),
    FEATURE(vertex_counts, "stereo.vertices, a counter of --stats"),
    FEATURE(clip_distances, "--shadows maps; without it shadows are found by rays"),
    FEATURE(quad_operations, "dais.multirate shares ambient light between four pixels"),
    FEATURE(conservative_raster, "--lists raster draws light meshes conservatively"),
    FEATURE(barycentrics, "not used; visibility.barycentrics works without it"),
    FEATURE(mesh_shader, "--geometry mesh"),
    FEATURE(ray_query, "shadow.ray-backend=ray-query: the device's own ray tracing"),
    FEATURE(sample_locations, "not used; visibility.grid uses the standard locations"),
    FEATURE(fragment_shading_rate, "not used; coarse shading works without it"),
    FEATURE(texture_compression, "not used by frames; fanal compress works without it"),
    FEATURE(multiview, "--set multiview=on and --stereo draw several views at once"),
#undef FEATURE
};
enum { FEATURE_COUNT = sizeof features / sizeof *features };

static bool has(const fnl_device_info *info, int i) { return *(const bool *)((const char *)info + features[i].offset); }

static void print_text(const fnl_device_info *infos, uint32_t count) {
    for (uint32_t i = 0; i < count; i++) {
        const fnl_device_info *d = &infos[i];
        printf("%u  %s  (%s, %s, Vulkan %u.%u, %.1f GiB, MSAA up to %ux)\n", i, d->name, fnl_value_name(FNL_ENUM_DEVICE_TYPE, d->type),
               d->driver, d->api_version_major, d->api_version_minor, (double)d->memory_bytes / (1 << 30), d->max_msaa);
        if (!d->usable) printf("   cannot be used: lacks %s\n", d->missing);
        for (int f = 0; f < FEATURE_COUNT; f++)
            printf("   %-4s %-22s %s\n", has(d, f) ? "yes" : "no", features[f].name, features[f].use);
    }
}

static int print_json(const fnl_device_info *infos, uint32_t count) {
    json_t *list = json_array();
    for (uint32_t i = 0; i < count; i++) {
        const fnl_device_info *d = &infos[i];
        json_t *optional = json_object();
        for (int f = 0; f < FEATURE_COUNT; f++) json_object_set_new(optional, features[f].name, json_boolean(has(d, f)));
        json_array_append_new(
            list, json_pack("{s:i,s:s,s:s,s:s,s:s#,s:b,s:s,s:I,s:i,s:i,s:i,s:o}", "index", (int)i, "name", d->name, "driver",
                            d->driver, "type", fnl_value_name(FNL_ENUM_DEVICE_TYPE, d->type), "vulkan",
                            (char[]){(char)('0' + d->api_version_major % 10), '.', (char)('0' + d->api_version_minor % 10)},
                            3, "usable", d->usable, "missing", d->missing, "memory_bytes", (json_int_t)d->memory_bytes,
                            "max_msaa", (int)d->max_msaa, "subgroup_size", (int)d->subgroup_size, "max_views", (int)d->max_views,
                            "features", optional));
    }
    int status = json_text_print(list, JSON_INDENT(2)) ? 0 : 2;
    json_decref(list);
    return status;
}

int command_devices(int argc, char **argv) {
    static const struct option options[] = {
        {"json", no_argument, NULL, 'j'}, {"help", no_argument, NULL, 'h'}, {NULL, 0, NULL, 0}};
    bool json = false;
    optind = 0;
    for (int option; (option = argument_next(argc, argv, "h", options)) != -1;) {
        switch (option) {
        case 'j':
            json = true;
            break;
        case 'h':
            print_help();
            return 0;
        default:
            return 2;
        }
    }
    if (optind < argc) {
        fprintf(stderr, "fanal: error: '%s' is one argument too many; see 'fanal devices --help'\n", argv[optind]);
        return 2;
    }
    fnl_device_info *infos = calloc(MAX_DEVICES, sizeof *infos);
    uint32_t count = 0, usable = 0;
    if (!infos || fnl_enumerate_devices(NULL, infos, MAX_DEVICES, &count) != FNL_OK) {
        free(infos);
        return 2;
    }
    if (count > MAX_DEVICES) count = MAX_DEVICES;
    for (uint32_t i = 0; i < count; i++) usable += infos[i].usable;
    int status = 0;
    if (json)
        status = print_json(infos, count);
    else
        print_text(infos, count);
    if (usable == 0) fputs("fanal: error: no usable Vulkan device; is a driver installed?\n", stderr);
    free(infos);
    return usable ? status : 2;
}
