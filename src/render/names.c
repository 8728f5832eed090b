/* SPDX-License-Identifier: MIT */
/** Names and defaults of what a frame can ask for. */
#include "base/check.h"
#include "fanal/renderer.h"
#include "passes/shade/gbuffer_layouts.h"

#define NAME_OF(names, value) ((uint32_t)(value) < COUNT_OF(names) ? names[value] : NULL)

const char *fnl_shading_name(fnl_shading shading) {
    static const char *const names[] = {"forward",      "forward-prepass", "deferred", "deferred-volumes", "light-prepass",
                                        "pre-lighting", "low-res",         "inferred", "light-indexed",    "zioma",
                                        "visibility",   "texturing",       "virtual-texturing",
                                        "coarse",       "dais",            "mobile",   "auto"};
    _Static_assert(COUNT_OF(names) == FNL_SHADING_COUNT, "each has a name");
    return NAME_OF(names, shading);
}

const char *fnl_light_lists_name(fnl_light_lists lists) {
    static const char *const names[] = {"all",    "tiled",  "clustered", "clustered-cpu", "mesh",     "batches", "multipass",
                                        "grid2d", "world",  "halfz",     "2.5d",          "enhanced", "tree",    "backface",
                                        "fine",   "sparse", "bvh",       "raster",        "zbin",     "auto"};
    _Static_assert(COUNT_OF(names) == FNL_LISTS_COUNT, "each has a name");
    return NAME_OF(names, lists);
}

const char *fnl_tile_bounds_name(fnl_tile_bounds bounds) {
    static const char *const names[] = {"planes", "box", "projected"};
    _Static_assert(COUNT_OF(names) == FNL_TILE_BOUNDS_COUNT, "each has a name");
    return NAME_OF(names, bounds);
}

const char *fnl_backface_axis_name(fnl_backface_axis axis) {
    static const char *const names[] = {"samples", "sum", "mips"};
    _Static_assert(COUNT_OF(names) == FNL_BACKFACE_AXIS_COUNT, "each has a name");
    return NAME_OF(names, axis);
}

const char *fnl_slices_name(fnl_slices slices) {
    static const char *const names[] = {"exponential", "linear"};
    _Static_assert(COUNT_OF(names) == FNL_SLICES_COUNT, "each has a name");
    return NAME_OF(names, slices);
}

const char *fnl_raster_path_name(fnl_raster_path path) {
    static const char *const names[] = {"auto", "hardware", "software"};
    return (uint32_t)path < FNL_RASTER_COUNT ? names[path] : NULL;
}

const char *fnl_raster_nodes_name(fnl_raster_nodes nodes) {
    static const char *const names[] = {"array", "links64", "links32"};
    return (uint32_t)nodes < FNL_RASTER_NODES_COUNT ? names[nodes] : NULL;
}

const char *fnl_volume_shape_name(fnl_volume_shape shape) {
    static const char *const names[] = {"solids", "quads", "fullscreen", "ellipse", "depth-bounds", "stencil"};
    _Static_assert(COUNT_OF(names) == FNL_VOLUME_SHAPE_COUNT, "each has a name");
    return NAME_OF(names, shape);
}

const char *fnl_msaa_method_name(fnl_msaa_method method) {
    static const char *const names[] = {"all", "tiles", "stencil", "compact", "coverage", "aggregate"};
    _Static_assert(COUNT_OF(names) == FNL_MSAA_METHOD_COUNT, "each has a name");
    return NAME_OF(names, method);
}

const char *fnl_dais_mode_name(fnl_dais_mode mode) {
    static const char *const names[] = {"target", "list"};
    return (uint32_t)mode < FNL_DAIS_MODE_COUNT ? names[mode] : NULL;
}

const char *fnl_transparency_name(fnl_transparency transparency) {
    static const char *const names[] = {"sorted", "weighted", "linked"};
    _Static_assert(COUNT_OF(names) == FNL_TRANSPARENCY_COUNT, "each has a name");
    return NAME_OF(names, transparency);
}

const char *fnl_decals_name(fnl_decals decals) {
    static const char *const names[] = {"lists", "gbuffer", "off"};
    _Static_assert(COUNT_OF(names) == FNL_DECALS_COUNT, "each has a name");
    return NAME_OF(names, decals);
}

const char *fnl_culling_name(fnl_culling culling) {
    static const char *const names[] = {"instances", "clusters", "triangles"};
    _Static_assert(COUNT_OF(names) == FNL_CULLING_COUNT, "each has a name");
    return NAME_OF(names, culling);
}

const char *fnl_geometry_name(fnl_geometry geometry) {
    static const char *const names[] = {"vertex", "mesh", "auto"};
    _Static_assert(COUNT_OF(names) == FNL_GEOMETRY_COUNT, "each has a name");
    return NAME_OF(names, geometry);
}

const char *fnl_antialiasing_name(fnl_antialiasing aa) {
    static const char *const names[] = {"none", "mlaa", "smaa", "taa"};
    _Static_assert(COUNT_OF(names) == FNL_ANTIALIASING_COUNT, "each has a name");
    return NAME_OF(names, aa);
}

const char *fnl_light_packing_name(fnl_light_packing packing) {
    static const char *const names[] = {"ids", "shift", "max"};
    _Static_assert(COUNT_OF(names) == FNL_LIGHT_PACKING_COUNT, "each has a name");
    return NAME_OF(names, packing);
}

const char *fnl_light_buffer_name(fnl_light_buffer buffer) {
    static const char *const names[] = {"auto", "rgba", "two", "four"};
    _Static_assert(COUNT_OF(names) == FNL_LIGHT_BUFFER_COUNT, "each has a name");
    return NAME_OF(names, buffer);
}

const char *fnl_coarse_criterion_name(fnl_coarse_criterion criterion) {
    static const char *const names[] = {"z", "id", "minmax"};
    _Static_assert(COUNT_OF(names) == FNL_COARSE_CRITERION_COUNT, "each has a name");
    return NAME_OF(names, criterion);
}

const char *fnl_coarse_split_name(fnl_coarse_split split) {
    static const char *const names[] = {"none", "albedo", "highlights", "sharp"};
    _Static_assert(COUNT_OF(names) == FNL_COARSE_SPLIT_COUNT, "each has a name");
    return NAME_OF(names, split);
}

const char *fnl_coarse_filter_name(fnl_coarse_filter filter) {
    static const char *const names[] = {"mean", "sampled", "none"};
    _Static_assert(COUNT_OF(names) == FNL_COARSE_FILTER_COUNT, "each has a name");
    return NAME_OF(names, filter);
}

const char *fnl_deferred_pass_name(fnl_deferred_pass pass) {
    static const char *const names[] = {"compute", "fragment"};
    _Static_assert(COUNT_OF(names) == FNL_DEFERRED_PASS_COUNT, "each has a name");
    return NAME_OF(names, pass);
}

const char *fnl_gbuffer_name(fnl_gbuffer layout) {
    return (uint32_t)layout < FNL_GBUFFER_COUNT ? gbuffer_layouts[layout].name : NULL;
}

const char *fnl_normal_encoding_name(fnl_normal_encoding normals) {
    static const char *const names[] = {"layout",     "octahedral",    "xyz",  "xy",       "spherical",
                                        "sphere-map", "stereographic", "view", "best-fit", "float"};
    _Static_assert(COUNT_OF(names) == FNL_NORMALS_COUNT, "each has a name");
    return NAME_OF(names, normals);
}

fnl_result fnl_gbuffer_query_info(fnl_gbuffer layout, fnl_gbuffer_info *out) {
    const fnl_host host = fnl_host_default();
    TRY(check_enum(CALL(&host), "layout", (int)layout, FNL_GBUFFER_COUNT, "fnl_gbuffer"));
    TRY(check_pointer(CALL(&host), "out", out));
    const struct gbuffer_layout *l = &gbuffer_layouts[layout];
    *out = (fnl_gbuffer_info){.target_count = l->target_count,
                              .published_bits = l->published_bits,
                              .material_count = l->id_count,
                              .normals = l->own,
                              .encodings = l->encodings | 1u << FNL_NORMALS_LAYOUT,
                              .field_count = l->field_count,
                              .fields = l->fields};
    for (uint32_t i = 0; i < l->target_count; i++) {
        out->target_bits[i] = gbuffer_format_bits(l->targets[i].format);
        out->bits += out->target_bits[i];
    }
    return FNL_OK;
}

const char *fnl_gradients_name(fnl_gradients gradients) {
    static const char *const names[] = {"stored", "derived"};
    _Static_assert(COUNT_OF(names) == FNL_GRADIENTS_COUNT, "each has a name");
    return NAME_OF(names, gradients);
}

const char *fnl_tonemap_name(fnl_tonemap tonemap) {
    static const char *const names[] = {"none", "khronos-neutral", "aces", "agx"};
    _Static_assert(COUNT_OF(names) == FNL_TONEMAP_COUNT, "each has a name");
    return NAME_OF(names, tonemap);
}

const char *fnl_debug_view_name(fnl_debug_view view) {
    static const char *const names[] = {
        "none",         "albedo",    "normal",      "depth",       "roughness", "lights",    "cells",     "overdraw",
        "tile-normals", "backfaces", "overshading", "layers",      "decals",    "gbuffer-0", "gbuffer-1", "gbuffer-2",
        "gbuffer-3",    "gbuffer-4", "material-id", "lit-forward", "edges",     "motion",    "halos",     "coarse",
        "coarse-reason", "dais-addresses", "dais-triangles", "dais-failures", "clusters", "atlas", "pages"};
    _Static_assert(COUNT_OF(names) == FNL_DEBUG_COUNT, "each has a name");
    return NAME_OF(names, view);
}

const char *fnl_visibility_sort_name(fnl_visibility_sort sort) {
    static const char *const names[] = {"off", "class", "material"};
    _Static_assert(COUNT_OF(names) == FNL_VISIBILITY_SORT_COUNT, "each has a name");
    return NAME_OF(names, sort);
}

fnl_visibility_options fnl_visibility_options_default(void) {
    return (fnl_visibility_options){.sort = FNL_VISIBILITY_SORT_OFF};
}

fnl_list_options fnl_list_options_default(void) {
    return (fnl_list_options){.frustum_cull = true,
                              .tile_size = 16,
                              .tile_bounds = FNL_TILE_BOUNDS_BOX,
                              .min_depth = true,
                              .max_depth = true,
                              .cone_tests = true,
                              .tree_hybrid = true,
                              .normal_cones = true,
                              .fine_pruning = true,
                              .fine_masks = 1,
                              .cluster_size = 64,
                              .slices = 32,
                              .light_scale = 2,
                              .light_layers = 4,
                              .cluster_near = INFINITY,
                              .cluster_far = INFINITY};
}

fnl_dais_options fnl_dais_options_default(void) { return (fnl_dais_options){.cache_buckets = 1 << 16}; }

fnl_coarse_options fnl_coarse_options_default(void) {
    return (fnl_coarse_options){.size = 2,
                                .depth_factor = 1,
                                .normal_degrees = 2,
                                .tolerance = 0.05f,
                                .albedo_tolerance = 1};
}

fnl_frame fnl_frame_default(void) {
    return (fnl_frame){.width = 1280,
                       .height = 720,
                       .camera = fnl_camera_default(),
                       .shading = FNL_SHADING_DEFERRED,
                       .lists = FNL_LISTS_AUTO,
                       .list_options = fnl_list_options_default(),
                       .mobile = fnl_mobile_options_default(),
                       .visibility = fnl_visibility_options_default(),
                       .coarse = fnl_coarse_options_default(),
                       .dais = fnl_dais_options_default(),
                       .msaa = 1,
                       .msaa_method = FNL_MSAA_COMPACT,
                       .msaa_groups = 2,
                       .atlas_size = 8192,
                       .decals = FNL_DECALS_LISTS,
                       .decal_mip_fix = true,
                       .tonemap = FNL_TONEMAP_KHRONOS_NEUTRAL,
                       .exposure = FNL_EXPOSURE_AUTO,
                       .outputs = FNL_OUTPUT_COLOR,
                       .timers = true};
}
