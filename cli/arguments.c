/* SPDX-License-Identifier: MIT */
#include "arguments.h"

#include "output.h"

#include <errno.h>
#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

bool argument_bad(const char *option, const char *value, const char *wanted) {
    fprintf(stderr, "fanal: error: --%s: '%s' is not %s\n", option, value, wanted);
    return false;
}

bool argument_integer(const char *option, const char *text, long long low, long long high, long long *out) {
    char *end;
    errno = 0;
    *out = strtoll(text, &end, 10);
    if (*text && !*end && errno == 0 && *out >= low && *out <= high) return true;
    char wanted[96];
    snprintf(wanted, sizeof wanted, "a whole number from %lld to %lld", low, high);
    return argument_bad(option, text, wanted);
}

bool argument_number(const char *option, const char *text, double *out) {
    char *end;
    *out = strtod(text, &end);
    return (*text && !*end && isfinite(*out)) || argument_bad(option, text, "a number");
}

bool argument_vector(const char *option, const char *text, fnl_vec3 *out) {
    int used = 0;
    if (sscanf(text, "%f,%f,%f%n", &out->x, &out->y, &out->z, &used) == 3 && !text[used] && isfinite(out->x) &&
        isfinite(out->y) && isfinite(out->z))
        return true;
    return argument_bad(option, text, "three numbers such as 1,2.5,-3");
}

bool argument_size(const char *option, const char *text, uint32_t *out_width, uint32_t *out_height) {
    char *end, *second_end;
    unsigned long width = strtoul(text, &end, 10), height = *end == 'x' ? strtoul(end + 1, &second_end, 10) : 0;
    if (end != text && *end == 'x' && second_end != end + 1 && !*second_end && width >= 1 && width <= 16384 && height >= 1 &&
        height <= 16384) {
        *out_width = (uint32_t)width;
        *out_height = (uint32_t)height;
        return true;
    }
    return argument_bad(option, text, "a size such as 1280x720, with sides from 1 to 16384");
}

bool argument_name(const char *option, const char *text, const char *(*name_of)(int), int *out) {
    char wanted[512] = "one of";
    for (int i = 0; name_of(i); i++) {
        if (strcmp(text, name_of(i)) == 0) {
            *out = i;
            return true;
        }
        size_t length = strlen(wanted);
        snprintf(wanted + length, sizeof wanted - length, " %s", name_of(i));
    }
    return argument_bad(option, text, wanted);
}

bool argument_light_shapes(const char *option, const char *text, fnl_scatter_params *out) {
    char copy[256], *rest = copy;
    static const char wanted[] = "a list such as point,spot,capsule,wedge,box or point=3,spot=1";
    if (strlen(text) >= sizeof copy) return argument_bad(option, text, wanted);
    strcpy(copy, text);
    memset(out->shares, 0, sizeof out->shares);
    for (char *part; (part = strsep(&rest, ","));) {
        char *equals = strchr(part, '='), *end = NULL;
        double share = equals ? strtod(equals + 1, &end) : 1;
        if (equals && (!equals[1] || *end || !(share > 0 && share <= 1e6))) return argument_bad(option, text, wanted);
        if (equals) *equals = 0;
        fnl_light_kind kind = FNL_LIGHT_POINT;
        while (kind < FNL_LIGHT_KIND_COUNT && strcmp(part, fnl_light_kind_name(kind)) != 0) kind++;
        if (kind == FNL_LIGHT_KIND_COUNT) return argument_bad(option, text, wanted);
        out->shares[kind] = (float)share;
    }
    return true;
}

/* ---- settings of the light lists ---- */

static const char *tile_bounds_name(int i) { return fnl_tile_bounds_name((fnl_tile_bounds)i); }
static const char *backface_axis_name(int i) { return fnl_backface_axis_name((fnl_backface_axis)i); }
static const char *slices_name(int i) { return fnl_slices_name((fnl_slices)i); }
static const char *raster_path_name(int i) { return fnl_raster_path_name((fnl_raster_path)i); }
static const char *raster_nodes_name(int i) { return fnl_raster_nodes_name((fnl_raster_nodes)i); }
static const char *volume_shape_name(int i) { return fnl_volume_shape_name((fnl_volume_shape)i); }
static const char *light_packing_name(int i) { return fnl_light_packing_name((fnl_light_packing)i); }
static const char *light_buffer_name(int i) { return fnl_light_buffer_name((fnl_light_buffer)i); }

enum setting_kind { SETTING_INTEGER, SETTING_NUMBER, SETTING_SWITCH, SETTING_NAME };

static const struct setting {
    const char *key, *help;
    size_t offset;
    enum setting_kind kind;
    long long low, high;           /* of integers */
    const char *(*name_of)(int i); /* of names */
} settings[] = {
#define FIELD(field) offsetof(fnl_list_options, field)
    {"frustum-cull", "on or off: leave out lights that are out of the view beforehand (on)", FIELD(frustum_cull),
     SETTING_SWITCH, 0, 0, NULL},
    {"tile-size", "8, 16, 32 or 64 pixels (16)", FIELD(tile_size), SETTING_INTEGER, 8, 64, NULL},
    {"tile-bounds", "planes, box or projected (box)", FIELD(tile_bounds), SETTING_NAME, 0, 0, tile_bounds_name},
    {"min-depth", "on or off: leave out lights before the nearest pixel of a tile (on)", FIELD(min_depth), SETTING_SWITCH, 0,
     0, NULL},
    {"max-depth", "on or off: leave out lights beyond the farthest pixel of a tile (on)", FIELD(max_depth), SETTING_SWITCH,
     0, 0, NULL},
    {"cone-tests", "on or off: test spots as cones (on)", FIELD(cone_tests), SETTING_SWITCH, 0, 0, NULL},
    {"normal-cones", "on or off: leave out lights behind all surfaces of a cluster (on)", FIELD(normal_cones),
     SETTING_SWITCH, 0, 0, NULL},
    {"fine-pruning", "on or off: test each pixel against the lights' volumes (on)", FIELD(fine_pruning), SETTING_SWITCH, 0,
     0, NULL},
    {"fine-masks", "0: none, 1: a mask of lights per pixel, 2: per 2x2 pixels (1)", FIELD(fine_masks), SETTING_INTEGER, 0, 2,
     NULL},
    {"fine-packed", "on or off: 32 bytes a tile, up to 24 of 1024 lights in view, no masks (off)", FIELD(fine_packed),
     SETTING_SWITCH, 0, 0, NULL},
    {"backface-axis", "samples, sum or mips (samples)", FIELD(backface_axis), SETTING_NAME, 0, 0, backface_axis_name},
    {"tree-hybrid", "on or off: plain rows where trees do not pay (on)", FIELD(tree_hybrid), SETTING_SWITCH, 0, 0, NULL},
    {"cluster-size", "8 .. 256 pixels (64)", FIELD(cluster_size), SETTING_INTEGER, 8, 256, NULL},
    {"slices", "1 .. 1024 (32)", FIELD(slices), SETTING_INTEGER, 1, 1024, NULL},
    {"distribution", "exponential or linear slices (exponential)", FIELD(distribution), SETTING_NAME, 0, 0, slices_name},
    {"cluster-near", "metres to the end of the first slice (by the scene)", FIELD(cluster_near), SETTING_NUMBER, 0, 0, NULL},
    {"cluster-far", "metres to the start of the last slice (by the scene)", FIELD(cluster_far), SETTING_NUMBER, 0, 0, NULL},
    {"raster-path", "auto, hardware or software: what draws the light meshes of raster (auto)", FIELD(raster_path),
     SETTING_NAME, 0, 0, raster_path_name},
    {"raster-nodes", "array, links64 or links32: how the clusters of raster hold lights (array)", FIELD(raster_nodes),
     SETTING_NAME, 0, 0, raster_nodes_name},
    {"volume-shape",
     "solids, quads, fullscreen, ellipse, depth-bounds or stencil: what deferred-volumes draws for a light (solids)",
     FIELD(volume_shape), SETTING_NAME, 0, 0, volume_shape_name},
    {"light-buffer", "auto, rgba, two or four: sums of light that light-prepass, low-res and inferred keep (auto)",
     FIELD(light_buffer), SETTING_NAME, 0, 0, light_buffer_name},
    {"light-packing", "ids, shift or max: how light-indexed writes down the lights of a pixel (ids)", FIELD(light_packing),
     SETTING_NAME, 0, 0, light_packing_name},
    {"light-layers", "1 .. 16: room for lights in a pixel, light-indexed and (up to 8) zioma (4)", FIELD(light_layers),
     SETTING_INTEGER, 1, 16, NULL},
    {"light-scale", "2 or 4: pixels along a side of what low-res and inferred light once (2)", FIELD(light_scale),
     SETTING_INTEGER, 2, 4, NULL},
#undef FIELD
};
enum { SETTING_COUNT = sizeof settings / sizeof settings[0] };

static bool set(const struct setting *s, const char *value, fnl_list_options *out) {
    void *field = (char *)out + s->offset;
    long long integer;
    double number;
    int index;
    switch (s->kind) {
    case SETTING_INTEGER:
        if (!argument_integer(s->key, value, s->low, s->high, &integer)) return false;
        if (s->offset == offsetof(fnl_list_options, tile_size) && (integer & (integer - 1)))
            return argument_bad(s->key, value, "one of 8 16 32 64");
        if (s->offset == offsetof(fnl_list_options, light_scale) && integer == 3)
            return argument_bad(s->key, value, "2 or 4");
        *(uint32_t *)field = (uint32_t)integer;
        return true;
    case SETTING_NUMBER:
        if (!argument_number(s->key, value, &number)) return false;
        if (!(number > 0)) return argument_bad(s->key, value, "a number above 0");
        *(float *)field = (float)number;
        return true;
    case SETTING_SWITCH:
        if (strcmp(value, "on") != 0 && strcmp(value, "off") != 0) return argument_bad(s->key, value, "on or off");
        *(bool *)field = strcmp(value, "on") == 0;
        return true;
    default:
        if (!argument_name(s->key, value, s->name_of, &index)) return false;
        memcpy(field, &index, sizeof index); /* enums have the size of int */
        return true;
    }
}

static void argument_list_options_help(void) {
    puts("Settings of the light lists, KEY=VALUE, several with commas between; the picture is the same with all of them:");
    for (int i = 0; i < SETTING_COUNT; i++) printf("  %-14s %s\n", settings[i].key, settings[i].help);
}

json_t *argument_list_options_json(const fnl_list_options *options) {
    json_t *json = json_object();
    for (int i = 0; i < SETTING_COUNT; i++) {
        const struct setting *s = &settings[i];
        const void *field = (const char *)options + s->offset;
        char key[32];
        int index;
        json_t *value;
        snprintf(key, sizeof key, "%s", s->key);
        for (char *dash; (dash = strchr(key, '-'));) *dash = '_';
        switch (s->kind) {
        case SETTING_INTEGER:
            value = json_integer(*(const uint32_t *)field);
            break;
        case SETTING_NUMBER: /* infinite: chosen by the scene */
            value = isinf(*(const float *)field) ? json_null() : json_real((double)*(const float *)field);
            break;
        case SETTING_SWITCH:
            value = json_boolean(*(const bool *)field);
            break;
        default:
            memcpy(&index, field, sizeof index);
            value = json_string(s->name_of(index));
        }
        json_object_set_new(json, key, value);
    }
    return json;
}

bool argument_list_options(const char *option, const char *text, fnl_list_options *out) {
    if (strcmp(text, "help") == 0) {
        argument_list_options_help();
        exit(output_flush() ? 0 : 2);
    }
    char copy[512];
    if (strlen(text) >= sizeof copy) return argument_bad(option, text, "shorter than 512 characters");
    strcpy(copy, text);
    for (char *part = strtok(copy, ","); part; part = strtok(NULL, ",")) {
        char *value = strchr(part, '=');
        if (!value) return argument_bad(option, part, "KEY=VALUE");
        *value++ = 0;
        const struct setting *found = NULL;
        for (int i = 0; i < SETTING_COUNT; i++)
            if (strcmp(part, settings[i].key) == 0) found = &settings[i];
        if (!found) return argument_bad(option, part, "a setting of the lists; '--list-option help' prints them");
        if (!set(found, value, out)) return false;
    }
    if (out->cluster_near >= out->cluster_far && !isinf(out->cluster_near)) {
        fprintf(stderr, "fanal: error: --%s: cluster-near must be less than cluster-far\n", option);
        return false;
    }
    return true;
}

/* ---- settings of the order mobile ---- */

static const char *mobile_gamma_name(int i) { return fnl_mobile_gamma_name((fnl_mobile_gamma)i); }
static const char *mobile_light_name(int i) { return fnl_mobile_light_name((fnl_mobile_light)i); }

static bool set_mobile(const char *option, const char *key, const char *value, fnl_mobile_options *out) {
    int index;
    double number;
    if (strcmp(key, "separate") == 0 && !value) {
        out->separate = true;
    } else if (strcmp(key, "recycle") == 0 && !value) {
        out->recycle = true;
    } else if (strcmp(key, "gamma") == 0 && value) {
        if (!argument_name(option, value, mobile_gamma_name, &index)) return false;
        out->gamma = (fnl_mobile_gamma)index;
    } else if (strcmp(key, "light") == 0 && value) {
        if (!argument_name(option, value, mobile_light_name, &index)) return false;
        out->light = (fnl_mobile_light)index;
    } else if (strcmp(key, "range") == 0 && value) {
        if (!argument_number(option, value, &number)) return false;
        if (!(number > 0 && number <= 1e9)) return argument_bad(option, value, "a range above 0");
        out->range = (float)number;
    } else {
        return argument_bad(option, key, "a list of gamma=, light=, range=, separate and recycle");
    }
    return true;
}

bool argument_mobile(const char *option, const char *text, fnl_mobile_options *out) {
    char copy[256], *rest = copy;
    if (strlen(text) >= sizeof copy) return argument_bad(option, text, "a shorter list");
    strcpy(copy, text);
    for (char *part; (part = strsep(&rest, ","));) {
        char *equals = strchr(part, '=');
        if (equals) *equals = 0;
        if (!set_mobile(option, part, equals ? equals + 1 : NULL, out)) return false;
    }
    return true;
}

/* ---- settings of the order coarse ---- */

static const char *coarse_criterion_name(int i) { return fnl_coarse_criterion_name((fnl_coarse_criterion)i); }
static const char *coarse_split_name(int i) { return fnl_coarse_split_name((fnl_coarse_split)i); }
static const char *coarse_filter_name(int i) { return fnl_coarse_filter_name((fnl_coarse_filter)i); }

static bool set_coarse(const char *option, const char *key, const char *value, fnl_coarse_options *out) {
    const struct {
        const char *key;
        float *field;
        double most;
    } numbers[] = {{"depth-factor", &out->depth_factor, 1e9},
                   {"normal-degrees", &out->normal_degrees, 180},
                   {"tolerance", &out->tolerance, 1},
                   {"albedo-tolerance", &out->albedo_tolerance, 1},
                   {"ao", &out->ao_radius, 1e9}};
    int index;
    double number;
    long long size;
    for (size_t i = 0; value && i < sizeof numbers / sizeof *numbers; i++) {
        if (strcmp(key, numbers[i].key) != 0) continue;
        if (!argument_number(option, value, &number)) return false;
        if (!(number >= 0 && number <= numbers[i].most)) {
            char wanted[96];
            snprintf(wanted, sizeof wanted, "a number from 0 to %g for %s", numbers[i].most, key);
            return argument_bad(option, value, wanted);
        }
        *numbers[i].field = (float)number;
        return true;
    }
    if (value && strcmp(key, "size") == 0) {
        if (!argument_integer(option, value, 1, 4, &size)) return false;
        if (size == 3) return argument_bad(option, value, "one of 1 2 4 for size");
        out->size = (uint32_t)size;
    } else if (value && strcmp(key, "criterion") == 0) {
        if (!argument_name(option, value, coarse_criterion_name, &index)) return false;
        out->criterion = (fnl_coarse_criterion)index;
    } else if (value && strcmp(key, "split") == 0) {
        if (!argument_name(option, value, coarse_split_name, &index)) return false;
        out->split = (fnl_coarse_split)index;
    } else if (value && strcmp(key, "filter") == 0) {
        if (!argument_name(option, value, coarse_filter_name, &index)) return false;
        out->filter = (fnl_coarse_filter)index;
    } else if (!value && strcmp(key, "gather") == 0) {
        out->gather = true;
    } else {
        return argument_bad(option, key,
                            "a list of size=, criterion=, depth-factor=, normal-degrees=, tolerance=, albedo-tolerance=, "
                            "split=, filter=, ao= and gather");
    }
    return true;
}

bool argument_coarse(const char *option, const char *text, fnl_coarse_options *out) {
    char copy[256], *rest = copy;
    if (strlen(text) >= sizeof copy) return argument_bad(option, text, "a shorter list");
    strcpy(copy, text);
    for (char *part; (part = strsep(&rest, ","));) {
        char *equals = strchr(part, '=');
        if (equals) *equals = 0;
        if (!set_coarse(option, part, equals ? equals + 1 : NULL, out)) return false;
    }
    return true;
}
