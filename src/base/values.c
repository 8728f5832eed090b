/* SPDX-License-Identifier: MIT */
/* The names of the values of all public enums. */
#include "base/values.h"

#include "base/check.h"
#include "fanal/fanal.h"

struct names {
    const char *type; /* in C */
    uint32_t count;
    const char *const *names;
};
/* More names than values do not compile; values_test finds a value without one. */
#define NAMES(type, number, ...) {#type, number, (const char *const[number]){__VA_ARGS__}}

static const struct names enums[] = {
    [FNL_ENUM_SHADING] = NAMES(fnl_shading, FNL_SHADING_COUNT, "forward", "forward-prepass", "deferred", "deferred-volumes", "light-prepass",
                               "pre-lighting", "low-res", "inferred", "light-indexed", "zioma", "visibility", "texturing",
                               "virtual-texturing", "coarse", "dais", "mobile", "auto"),
    [FNL_ENUM_LISTS] = NAMES(fnl_light_lists, FNL_LISTS_COUNT, "all", "tiled", "clustered", "clustered-cpu", "mesh", "batches", "multipass",
                             "grid2d", "world", "halfz", "2.5d", "enhanced", "tree", "backface", "fine", "sparse", "bvh",
                             "raster", "zbin", "auto"),
    [FNL_ENUM_TILE_BOUNDS] = NAMES(fnl_tile_bounds, FNL_TILE_BOUNDS_COUNT, "planes", "box", "projected"),
    [FNL_ENUM_BACKFACE_AXIS] = NAMES(fnl_backface_axis, FNL_BACKFACE_AXIS_COUNT, "samples", "sum", "mips"),
    [FNL_ENUM_SLICES] = NAMES(fnl_slices, FNL_SLICES_COUNT, "exponential", "linear"),
    [FNL_ENUM_RASTER_PATH] = NAMES(fnl_raster_path, FNL_RASTER_COUNT, "auto", "hardware", "software"),
    [FNL_ENUM_RASTER_NODES] = NAMES(fnl_raster_nodes, FNL_RASTER_NODES_COUNT, "array", "links64", "links32"),
    [FNL_ENUM_VOLUME_SHAPE] =
        NAMES(fnl_volume_shape, FNL_VOLUME_SHAPE_COUNT, "solids", "quads", "fullscreen", "ellipse", "depth-bounds", "stencil"),
    [FNL_ENUM_LIGHT_BUFFER] = NAMES(fnl_light_buffer, FNL_LIGHT_BUFFER_COUNT, "auto", "rgba", "two", "four"),
    [FNL_ENUM_LIGHT_PACKING] = NAMES(fnl_light_packing, FNL_LIGHT_PACKING_COUNT, "ids", "shift", "max"),
    [FNL_ENUM_MSAA_METHOD] = NAMES(fnl_msaa_method, FNL_MSAA_METHOD_COUNT, "all", "tiles", "stencil", "compact", "coverage", "aggregate"),
    [FNL_ENUM_TRANSPARENCY] = NAMES(fnl_transparency, FNL_TRANSPARENCY_COUNT, "sorted", "weighted", "linked"),
    [FNL_ENUM_DECALS] = NAMES(fnl_decals, FNL_DECALS_COUNT, "lists", "gbuffer", "off"),
    [FNL_ENUM_CULLING] = NAMES(fnl_culling, FNL_CULLING_COUNT, "instances", "clusters", "triangles"),
    [FNL_ENUM_GEOMETRY] = NAMES(fnl_geometry, FNL_GEOMETRY_COUNT, "vertex", "mesh", "auto"),
    [FNL_ENUM_ANTIALIASING] = NAMES(fnl_antialiasing, FNL_ANTIALIASING_COUNT, "none", "mlaa", "smaa", "taa"),
    [FNL_ENUM_DEFERRED_PASS] = NAMES(fnl_deferred_pass, FNL_DEFERRED_PASS_COUNT, "compute", "fragment"),
    [FNL_ENUM_GBUFFER] = NAMES(fnl_gbuffer, FNL_GBUFFER_COUNT, "default", "siege", "killzone2", "frostbite2", "stalker", "clear-sky", "engel",
                               "destiny"),
    [FNL_ENUM_NORMALS] = NAMES(fnl_normal_encoding, FNL_NORMALS_COUNT, "layout", "octahedral", "xyz", "xy", "spherical", "sphere-map",
                               "stereographic", "view", "best-fit", "float"),
    [FNL_ENUM_GRADIENTS] = NAMES(fnl_gradients, FNL_GRADIENTS_COUNT, "stored", "derived"),
    [FNL_ENUM_VISIBILITY_SORT] = NAMES(fnl_visibility_sort, FNL_VISIBILITY_SORT_COUNT, "off", "class", "material"),
    [FNL_ENUM_COARSE_CRITERION] = NAMES(fnl_coarse_criterion, FNL_COARSE_CRITERION_COUNT, "z", "id", "minmax"),
    [FNL_ENUM_COARSE_SPLIT] = NAMES(fnl_coarse_split, FNL_COARSE_SPLIT_COUNT, "none", "albedo", "highlights", "sharp"),
    [FNL_ENUM_COARSE_FILTER] = NAMES(fnl_coarse_filter, FNL_COARSE_FILTER_COUNT, "mean", "sampled", "none"),
    [FNL_ENUM_DAIS_MODE] = NAMES(fnl_dais_mode, FNL_DAIS_MODE_COUNT, "target", "list"),
    [FNL_ENUM_MOBILE_LAYOUT] =
        NAMES(fnl_mobile_layout, FNL_MOBILE_LAYOUT_COUNT, "metallic-128", "specular-160", "metallic-256", "specular-256"),
    [FNL_ENUM_MOBILE_GAMMA] = NAMES(fnl_mobile_gamma, FNL_MOBILE_GAMMA_COUNT, "srgb", "sqrt", "power"),
    [FNL_ENUM_MOBILE_LIGHT] = NAMES(fnl_mobile_light, FNL_MOBILE_LIGHT_COUNT, "float", "unorm"),
    [FNL_ENUM_MOBILE_LIGHTS] = NAMES(fnl_mobile_lights, FNL_MOBILE_LIGHTS_COUNT, "lists", "volumes"),
    [FNL_ENUM_TONEMAP] = NAMES(fnl_tonemap, FNL_TONEMAP_COUNT, "none", "khronos-neutral", "aces", "agx"),
    [FNL_ENUM_EXPOSURE] = NAMES(fnl_exposure, FNL_EXPOSURE_NONE + 1, "auto", "ev", "none"),
    [FNL_ENUM_DEBUG_VIEW] =
        NAMES(fnl_debug_view, FNL_DEBUG_COUNT, "none", "albedo", "normal", "depth", "roughness", "lights", "cells", "overdraw", "tile-normals",
              "backfaces", "overshading", "layers", "decals", "gbuffer-0", "gbuffer-1", "gbuffer-2", "gbuffer-3", "gbuffer-4",
              "material-id", "lit-forward", "edges", "motion", "halos", "coarse", "coarse-reason", "dais-addresses",
              "dais-triangles", "dais-failures", "clusters", "atlas", "pages"),
    [FNL_ENUM_LIGHT_KIND] = NAMES(fnl_light_kind, FNL_LIGHT_KIND_COUNT, "directional", "point", "spot", "capsule", "wedge", "box"),
    [FNL_ENUM_DECAL_KIND] = NAMES(fnl_decal_kind, FNL_DECAL_KIND_COUNT, "box", "volume", "mesh", "redraw", "baked"),
    [FNL_ENUM_DECAL_BLEND] = NAMES(fnl_decal_blend, FNL_DECAL_BLEND_COUNT, "alpha", "multiply", "add", "screen", "overlay"),
    [FNL_ENUM_DEVICE_TYPE] = NAMES(fnl_device_type, FNL_DEVICE_OTHER + 1, "discrete", "integrated", "virtual", "cpu", "other"),
};
_Static_assert(COUNT_OF(enums) == FNL_ENUM_COUNT, "each enum has its names");

const char *fnl_value_name(fnl_enum type, uint32_t value) {
    if ((uint32_t)type >= FNL_ENUM_COUNT || value >= enums[type].count) return NULL;
    return enums[type].names[value];
}

uint32_t value_count(fnl_enum type) { return enums[type].count; }
const char *value_type(fnl_enum type) { return enums[type].type; }

bool fnl_value_find(fnl_enum type, const char *name, uint32_t *out) {
    const char *candidate;
    if (check_handle(__func__, "name", name) != FNL_OK) return false;
    for (uint32_t i = 0; (candidate = fnl_value_name(type, i)); i++) {
        if (strcmp(candidate, name) != 0) continue;
        if (out) *out = i;
        return true;
    }
    return false;
}
