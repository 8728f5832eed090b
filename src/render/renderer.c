/* SPDX-License-Identifier: MIT */
#include "fanal/vulkan.h"
#include "passes/aa/taa.h"
#include "passes/shade/gbuffer_layouts.h"
#include "passes/visibility/visibility.h"
#include "render/shading.h"

enum { CLUSTER_POOL_START = 1 << 14, TRIANGLE_POOL_START = 1 << 18 };
enum { SIDE_MAX = 16384, POOL_START = 1 << 18, POOL_LIMIT = 1 << 28 };

/* ---- names and defaults ---- */

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
    if ((uint32_t)layout >= FNL_GBUFFER_COUNT || !out) return FNL_ERROR_INVALID;
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
        "coarse-reason", "dais-addresses", "dais-triangles", "dais-failures", "clusters"};
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

fnl_coarse_options fnl_coarse_options_default(void) {
    return (fnl_coarse_options){.size = 2,
                                .depth_factor = 1,
                                .normal_degrees = 2,
                                .tolerance = 0.05f,
                                .albedo_tolerance = 1,
                                .bias = true};
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
                       .dais = {.cache_buckets = 1 << 16},
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

/* ---- auto ---- */

static void load_choices(fnl_renderer *r) {
    struct file_view file;
    if (!gpu_cache_load(r->device, "choices", &file)) return;
    chooser_parse(&r->chooser, (const char *)file.data, file.size);
    file_unmap(&file);
}

static void save_choices(fnl_renderer *r) {
    if (!r->chooser.memory_changed) return;
    r->chooser.memory_changed = false;
    size_t size = chooser_print(&r->chooser, NULL, 0);
    char *text = host_allocate(&r->host, size + 1);
    if (!text) return;
    chooser_print(&r->chooser, text, size + 1);
    gpu_cache_save(r->device, "choices", text, size);
    host_free(&r->host, text, size + 1);
}

/* Replaces auto by what this frame uses. */
static void choose(fnl_renderer *r, fnl_frame *frame) {
    r->asked = (struct choice){frame->shading, frame->lists};
    if (frame->shading != FNL_SHADING_AUTO && frame->lists != FNL_LISTS_AUTO) {
        r->chooser.last = CHOOSER_CANDIDATES;
        r->chooses = false;
        return;
    }
    const struct device_scene *d = &r->device_scene;
    uint64_t item_step = 0; /* a few objects more or less are the same scene */
    for (uint32_t count = d->item_count; count; count >>= 1) item_step++;
    const uint64_t parts[] = {item_step, d->buckets.count};
    const fnl_camera *camera = &frame->camera;
    struct choice_case at = {.asked = {frame->shading, frame->lists},
                             .scene = hash_bytes(parts, sizeof parts, HASH_SEED),
                             .light_count = (uint32_t)d->light_data.count - d->directional_count,
                             .msaa = frame->msaa,
                             .pixel_count = (uint64_t)frame->width * frame->height,
                             .depth_first = frame->gbuffer_prepass,
                             .eye = camera->position,
                             .forward = vec3_normalize(vec3_sub(camera->target, camera->position)),
                             .scene_size = box_is_empty(&d->bounds) ? 1 : vec3_distance(d->bounds.low, d->bounds.high)};
    struct choice choice = chooser_pick(&r->chooser, &at, frame->pin_choice);
    frame->shading = choice.shading;
    frame->lists = choice.lists;
    /* Counting slows a frame down; after a decision only frames that are timed anyway are watched. */
    r->chooses = !frame->pin_choice && !frame->count_lights && (frame->timers || r->chooser.state == CHOOSER_MEASURING);
}

/* Where only lists are chosen, drawing the surfaces costs the same with all of them: its jitter would only blur the comparison. */
static bool chosen_apart(const fnl_renderer *r, const char *pass) {
    return r->asked.shading != FNL_SHADING_AUTO && (strcmp(pass, "gbuffer") == 0 || strcmp(pass, "depth prepass") == 0);
}

/* Hands the chooser the times that have come in. */
static void feed_chooser(fnl_renderer *r) {
    for (uint64_t wanted; (wanted = chooser_wants(&r->chooser)) && wanted + GPU_FRAMES_IN_FLIGHT <= r->frame_number;) {
        const struct graph_timer *timers;
        uint32_t count;
        double sum = -1;
        if (graph_query_timers(r->graph, wanted, &timers, &count) && count > 0) {
            sum = 0;
            for (uint32_t i = 0; i < count; i++)
                if (!chosen_apart(r, timers[i].name)) sum += timers[i].milliseconds;
        }
        chooser_feed(&r->chooser, sum);
    }
    save_choices(r);
}

fnl_vec2 fnl_jitter(uint32_t index) { return taa_jitter(index); }

/* ---- life ---- */

fnl_result fnl_renderer_create(fnl_device *device, fnl_scene *scene, fnl_renderer **out) {
    if (!device || !scene || !out) return FNL_ERROR_INVALID;
    *out = NULL;
    const fnl_host *host = gpu_host(device);
    fnl_renderer *r = host_allocate_zero(host, sizeof *r);
    if (!r) return FNL_ERROR_MEMORY;
    r->host = *host;
    r->device = device;
    r->scene = scene;
    r->pool_capacity = POOL_START;
    r->decal_capacity = DECAL_POOL_START;
    r->decal_tree = 1024; /* from about there on, each cell asking each box costs more than making the tree */
    r->dais_capacity = DAIS_POOL_START;
    r->dais_node_capacity = DAIS_NODE_START;
    device_scene_init(&r->device_scene, device, scene);
    r->atlas.version = UINT64_MAX;
    lists_init(&r->lists, &r->host);
    load_choices(r);
    fnl_result result = graph_create(&r->host, device, &r->graph);
    for (uint32_t i = 0; i < GPU_FRAMES_IN_FLIGHT && result == FNL_OK; i++)
        result = gpu_buffer_create(device, "frame counts", sizeof(struct frame_counts), GPU_MEMORY_READBACK, &r->counts[i]);
    if (result != FNL_OK) fnl_renderer_destroy(&r);
    *out = r;
    return result;
}

void fnl_renderer_destroy(fnl_renderer **handle) {
    fnl_renderer *r = handle ? *handle : NULL;
    if (!r) return;
    gpu_wait_idle(r->device);
    graph_destroy(&r->graph);
    device_scene_finish(&r->device_scene);
    lists_finish(&r->lists, r->device);
    virtual_destroy(r->device, &r->atlas);
    for (uint32_t i = 0; i < OUTPUT_COUNT; i++) gpu_buffer_destroy(r->device, &r->outputs[i]);
    for (uint32_t i = 0; i < GPU_FRAMES_IN_FLIGHT; i++) gpu_buffer_destroy(r->device, &r->counts[i]);
    gpu_buffer_destroy(r->device, &r->draws);
    gpu_buffer_destroy(r->device, &r->counters);
    array_free(&r->host, &r->pass_times);
    gpu_wait_idle(r->device); /* nothing is in flight: this frees device memory at once */
    fnl_host host = r->host;
    host_free(&host, r, sizeof *r);
    *handle = NULL;
}

/* ---- one frame ---- */

static size_t output_pixel_size(uint32_t bit) { return bit == 0 ? 4 : 16; }

static fnl_result keep_buffer(fnl_renderer *r, struct gpu_buffer *buffer, const char *name, uint64_t size) {
    if (buffer->size >= size) return FNL_OK;
    gpu_buffer_destroy(r->device, buffer);
    return gpu_buffer_create(r->device, name, size, GPU_MEMORY_READBACK, buffer);
}

static fnl_result prepare_buffers(fnl_renderer *r, const fnl_frame *frame) {
    uint64_t pixels = (uint64_t)frame->width * frame->height;
    for (uint32_t i = 0; i < OUTPUT_COUNT; i++)
        if (frame->outputs & 1u << i) TRY(keep_buffer(r, &r->outputs[i], "output", pixels * output_pixel_size(i)));
    if (!frame->count_lights) return FNL_OK;
    /* Exactly two counters per pixel: the whole buffer is summed. */
    if (r->counters.size != pixels * 8) gpu_buffer_destroy(r->device, &r->counters);
    TRY(keep_buffer(r, &r->counters, "light counters", pixels * 8));
    return keep_buffer(r, &r->draws, "draws", MAX(r->device_scene.group_count, 1u) * sizeof(struct gpu_draw));
}

static fnl_result check_gbuffer(const fnl_renderer *r, const fnl_frame *frame) {
    const fnl_host *host = &r->host;
    REQUIRE(host, (uint32_t)frame->gbuffer < FNL_GBUFFER_COUNT);
    REQUIRE(host, (uint32_t)frame->normals < FNL_NORMALS_COUNT);
    REQUIRE(host, (uint32_t)frame->deferred_pass < FNL_DEFERRED_PASS_COUNT);
    if (frame->deferred_pass == FNL_DEFERRED_FRAGMENT && frame->shading == FNL_SHADING_DEFERRED &&
        (frame->class_blocks || frame->msaa > 1)) {
        log_error(host, "deferred lighting in a fragment pass has no classes and 1 sample a pixel");
        return FNL_ERROR_UNSUPPORTED;
    }
    bool plain = frame->gbuffer == FNL_GBUFFER_DEFAULT && frame->normals == FNL_NORMALS_LAYOUT && !frame->chroma;
    bool is_auto = frame->shading == FNL_SHADING_AUTO; /* may become deferred */
    if (plain || (!is_auto && !shading_is(frame->shading, SHADING_GBUFFER))) return FNL_OK;
    if (!is_auto && !shading_is(frame->shading, SHADING_LAYOUTS)) {
        log_error(host, "%s shading has a G-buffer of its own", fnl_shading_name(frame->shading));
        return FNL_ERROR_UNSUPPORTED;
    }
    fnl_gbuffer_info info;
    TRY(fnl_gbuffer_query_info(frame->gbuffer, &info));
    if (!(info.encodings >> frame->normals & 1)) {
        log_error(host, "the normals of layout %s cannot hold encoding %s", fnl_gbuffer_name(frame->gbuffer),
                  fnl_normal_encoding_name(frame->normals));
        return FNL_ERROR_UNSUPPORTED;
    }
    if (frame->chroma && frame->gbuffer != FNL_GBUFFER_DEFAULT) {
        log_error(host, "layout %s has no base colour that chroma could make smaller", fnl_gbuffer_name(frame->gbuffer));
        return FNL_ERROR_UNSUPPORTED;
    }
    return FNL_OK;
}

/* Views of the G-buffer need one that holds what they show. */
static fnl_result check_gbuffer_view(const fnl_renderer *r, const fnl_frame *frame) {
    if (frame->debug < FNL_DEBUG_GBUFFER_0 || frame->debug > FNL_DEBUG_LIT_FORWARD) return FNL_OK;
    const fnl_host *host = &r->host;
    if (frame->shading == FNL_SHADING_AUTO || !shading_is(frame->shading, SHADING_LAYOUTS) || frame->msaa > 1) {
        log_error(host, "the view %s shows the G-buffer of deferred shading with 1 sample",
                  fnl_debug_view_name(frame->debug));
        return FNL_ERROR_UNSUPPORTED;
    }
    fnl_gbuffer_info info;
    TRY(fnl_gbuffer_query_info(frame->gbuffer, &info));
    uint32_t index = (uint32_t)(frame->debug - FNL_DEBUG_GBUFFER_0);
    if (index <= 4 && index >= info.target_count + (frame->normals == FNL_NORMALS_FLOAT)) {
        log_error(host, "layout %s has no render target %u", fnl_gbuffer_name(frame->gbuffer), index);
        return FNL_ERROR_UNSUPPORTED;
    }
    if (frame->debug == FNL_DEBUG_MATERIAL_ID && info.material_count == 0) {
        log_error(host, "layout %s has no material ID", fnl_gbuffer_name(frame->gbuffer));
        return FNL_ERROR_UNSUPPORTED;
    }
    return FNL_OK;
}

static fnl_result check_coarse(const fnl_renderer *r, const fnl_frame *frame) {
    const fnl_host *host = &r->host;
    const fnl_coarse_options *o = &frame->coarse;
    REQUIRE(host, o->size == 1 || o->size == 2 || o->size == 4);
    REQUIRE(host, (uint32_t)o->criterion < FNL_COARSE_CRITERION_COUNT);
    REQUIRE(host, (uint32_t)o->split < FNL_COARSE_SPLIT_COUNT);
    REQUIRE(host, o->depth_factor >= 0 && isfinite(o->depth_factor));
    REQUIRE(host, o->normal_degrees >= 0 && o->normal_degrees <= 180);
    REQUIRE(host, o->tolerance >= 0 && o->tolerance <= 1 && o->albedo_tolerance >= 0 && o->albedo_tolerance <= 1);
    REQUIRE(host, o->ao_radius >= 0 && isfinite(o->ao_radius));
    REQUIRE(host, frame->shade_cost <= 100000);
    if (frame->shading == FNL_SHADING_COARSE && o->criterion == FNL_COARSE_CRITERION_ID &&
        !gpu_info(r->device)->primitive_ids) {
        log_error(host, "this device cannot number triangles, which the criterion id needs; use z");
        return FNL_ERROR_UNSUPPORTED;
    }
    bool view = frame->debug == FNL_DEBUG_COARSE || frame->debug == FNL_DEBUG_COARSE_REASON;
    if (view && frame->shading != FNL_SHADING_COARSE) {
        log_error(host, "the view %s shows the blocks of coarse shading", fnl_debug_view_name(frame->debug));
        return FNL_ERROR_UNSUPPORTED;
    }
    return FNL_OK;
}

static fnl_result check_frame(fnl_renderer *r, const fnl_frame *frame) {
    const fnl_host *host = &r->host;
    REQUIRE(host, frame->width >= 1 && frame->width <= SIDE_MAX && frame->height >= 1 && frame->height <= SIDE_MAX);
    REQUIRE(host, camera_valid(&frame->camera));
    REQUIRE(host, (uint32_t)frame->shading < FNL_SHADING_COUNT);
    REQUIRE(host, (uint32_t)frame->lists < FNL_LISTS_COUNT);
    TRY(lists_check(host, &frame->list_options));
    TRY(check_gbuffer(r, frame));
    REQUIRE(host, (uint32_t)frame->msaa_method < FNL_MSAA_METHOD_COUNT);
    REQUIRE(host, frame->msaa_groups == 2 || frame->msaa_groups == 3);
    REQUIRE(host, frame->msaa_tolerance >= 0 && frame->msaa_tolerance <= 1);
    REQUIRE(host, (uint32_t)frame->transparency < FNL_TRANSPARENCY_COUNT);
    REQUIRE(host, (uint32_t)frame->decals < FNL_DECALS_COUNT);
    REQUIRE(host, (uint32_t)frame->culling < FNL_CULLING_COUNT);
    REQUIRE(host, (uint32_t)frame->aa < FNL_ANTIALIASING_COUNT);
    REQUIRE(host, fabsf(frame->jitter.x) <= 8 && fabsf(frame->jitter.y) <= 8);
    REQUIRE(host, (uint32_t)frame->tonemap < FNL_TONEMAP_COUNT);
    REQUIRE(host, (uint32_t)frame->mobile.layout < FNL_MOBILE_LAYOUT_COUNT);
    REQUIRE(host, (uint32_t)frame->mobile.gamma < FNL_MOBILE_GAMMA_COUNT);
    REQUIRE(host, (uint32_t)frame->mobile.light < FNL_MOBILE_LIGHT_COUNT);
    REQUIRE(host, (uint32_t)frame->mobile.lights < FNL_MOBILE_LIGHTS_COUNT);
    REQUIRE(host, frame->mobile.range > 0 && isfinite(frame->mobile.range));
    REQUIRE(host, (uint32_t)frame->visibility.sort < FNL_VISIBILITY_SORT_COUNT);
    REQUIRE(host, frame->atlas_size >= 256 && frame->atlas_size <= 8192 && frame->atlas_size % 256 == 0);
    REQUIRE(host, (uint32_t)frame->gradients < FNL_GRADIENTS_COUNT);
    REQUIRE(host, (uint32_t)frame->exposure <= FNL_EXPOSURE_NONE);
    REQUIRE(host, frame->exposure != FNL_EXPOSURE_EV || (frame->ev >= -64 && frame->ev <= 64));
    REQUIRE(host, (uint32_t)frame->debug < FNL_DEBUG_COUNT);
    TRY(check_gbuffer_view(r, frame));
    TRY(check_coarse(r, frame));
    REQUIRE(host, frame->outputs < 1u << OUTPUT_COUNT);
    REQUIRE(host, frame->light_lod >= 0 && isfinite(frame->light_lod));
    REQUIRE(host, frame->class_blocks == 0 || frame->class_blocks == 4 || frame->class_blocks == 8);
    REQUIRE(host, frame->msaa == 1 || frame->msaa == 2 || frame->msaa == 4 || frame->msaa == 8);
    if (!fnl_lists_supported(frame->shading, frame->lists)) {
        log_error(host, "%s lists do not go with %s shading", fnl_light_lists_name(frame->lists),
                  fnl_shading_name(frame->shading));
        return FNL_ERROR_UNSUPPORTED;
    }
    if (!fnl_msaa_supported(frame->shading) && frame->msaa > 1) {
        log_error(host, "%s shading has no MSAA; use another order, or 1 sample",
                  fnl_shading_name(frame->shading));
        return FNL_ERROR_UNSUPPORTED;
    }
    if (frame->shading == FNL_SHADING_DEFERRED && frame->msaa > 1 && frame->class_blocks) {
        log_error(host, "blocks of pixels cannot be classified with MSAA; use class_blocks 0 or 1 sample");
        return FNL_ERROR_UNSUPPORTED;
    }
    if (frame->shading == FNL_SHADING_VISIBILITY && frame->visibility.grid &&
        (frame->msaa > 1 || frame->visibility.barycentrics || !visibility_grid_supported(r->device))) {
        log_error(host, "the grid takes 1 sample a pixel, no barycentrics, and a device with 4 samples");
        return FNL_ERROR_UNSUPPORTED;
    }
    if (frame->shading == FNL_SHADING_VISIBILITY && frame->visibility.barycentrics && frame->msaa > 1) {
        log_error(host, "barycentrics are stored with 1 sample a pixel");
        return FNL_ERROR_UNSUPPORTED;
    }
    if ((frame->shading == FNL_SHADING_VISIBILITY || frame->shading == FNL_SHADING_DAIS) && !gpu_info(r->device)->primitive_ids) {
        log_error(host, "this device cannot number triangles, which %s shading needs", fnl_shading_name(frame->shading));
        return FNL_ERROR_UNSUPPORTED;
    }
    TRY(dais_check(r, frame));
    if (frame->debug == FNL_DEBUG_CLUSTERS && !gpu_info(r->device)->primitive_ids) {
        log_error(host, "this device cannot number triangles, which the view of clusters needs");
        return FNL_ERROR_UNSUPPORTED;
    }
    if (temporal_needs_motion(frame) && frame->msaa > 1) {
        log_error(host, "motion vectors and temporal antialiasing take one sample per pixel, not %u", frame->msaa);
        return FNL_ERROR_UNSUPPORTED;
    }
    if (!shading_supported(r, frame)) return FNL_ERROR_UNSUPPORTED;
    if (!(gpu_info(r->device)->msaa_counts & frame->msaa)) {
        log_error(host, "this device cannot render with %u samples (at most %u)", frame->msaa,
                  gpu_info(r->device)->max_msaa);
        return FNL_ERROR_UNSUPPORTED;
    }
    return FNL_OK;
}

/* After an overflow the pool takes what the frame needed and a quarter more, but never so much that the device could run out: cells
 * beyond that go on using all lights. */
static void grow_pool(fnl_renderer *r, const struct frame_counts *counts) {
    uint64_t needed = MAX(counts->lights.entries, counts->blend_lights.entries);
    uint64_t limit = MIN(gpu_info(r->device)->memory_bytes / 32, (uint64_t)POOL_LIMIT);
    if (needed > r->pool_capacity) r->pool_capacity = (uint32_t)MIN(needed + needed / 4, MAX(limit, (uint64_t)POOL_START));
}

/* So does what holds decals: entries of their list, or fragments of the G-buffer's way. */
static void grow_decal_pool(fnl_renderer *r, const struct frame_counts *counts) {
    uint64_t needed = MAX(counts->decals.entries, counts->decal_fragments);
    uint64_t limit = MIN(gpu_info(r->device)->memory_bytes / 32, (uint64_t)POOL_LIMIT);
    if (needed > r->decal_capacity)
        r->decal_capacity = (uint32_t)MIN(needed + needed / 4, MAX(limit, (uint64_t)DECAL_POOL_START));
}

/* So do the pools of culling, as far as the scene can fill them. */
static void grow_cluster_pools(fnl_renderer *r, const struct frame_counts *counts) {
    const struct device_scene *d = &r->device_scene;
    if (r->cluster_limit) return;
    uint64_t limit = MAX(gpu_info(r->device)->memory_bytes / 128, (uint64_t)CLUSTER_POOL_START);
    uint64_t clusters = MIN(MAX(CLUSTER_POOL_START, counts->clusters.clusters + counts->clusters.clusters / 4ull), limit);
    uint64_t triangles =
        MIN(MAX(TRIANGLE_POOL_START, counts->clusters.triangles + counts->clusters.triangles / 4ull), limit);
    triangles = MIN(triangles, (UINT32_MAX - (uint64_t)d->index_count) / 3);
    r->cluster_capacity = (uint32_t)MAX(MIN(clusters, d->cluster_count), (uint64_t)r->cluster_capacity);
    r->triangle_capacity = (uint32_t)MAX(MIN(triangles, d->triangle_count), (uint64_t)r->triangle_capacity);
}

/* The lists of blended fragments start with one per pixel and grow in the same way. */
static uint32_t blend_capacity(const fnl_renderer *r, uint64_t wanted) {
    uint64_t limit = gpu_info(r->device)->memory_bytes / 16 / linked_bytes(8);
    return (uint32_t)MIN(MAX(wanted, (uint64_t)BLEND_POOL_START),
                         MIN(MAX(limit, (uint64_t)BLEND_POOL_START), LINKED_CAPACITY_MAX));
}

static void grow_blend_pool(fnl_renderer *r, const struct frame_counts *counts) {
    uint64_t needed = counts->blend.fragments;
    if (counts->blend.overflow_pixels > 0)
        r->blend_capacity = MAX(r->blend_capacity, blend_capacity(r, needed + needed / 4));
}

static void grow_dais_pools(fnl_renderer *r, const struct frame_counts *counts) {
    uint64_t limit = gpu_info(r->device)->memory_bytes / 8 / 4;
    if (counts->dais[DAIS_OVERFLOW] == 0) return;
    /* How much more the others want is not known: those that find no room take none. */
    if (counts->dais[DAIS_WORDS] + DAIS_RECORD_MAX > r->dais_capacity)
        r->dais_capacity = (uint32_t)MIN(MAX(2ull * r->dais_capacity, (uint64_t)DAIS_POOL_START), MIN(limit, DAIS_POOL_LIMIT));
    uint64_t nodes = counts->dais[DAIS_NODES] + 2ull;
    if (nodes > r->dais_node_capacity)
        r->dais_node_capacity = (uint32_t)MIN(nodes + nodes / 4, MIN(limit, DAIS_POOL_LIMIT) / 4);
}

static const struct frame_counts *slot_counts(const fnl_renderer *r, uint32_t slot) { return r->counts[slot].mapped; }

static fnl_result make_frame(fnl_renderer *r, fnl_frame *frame, const struct frame_target *target,
                             const struct gpu_external_semaphores *external) {
    r->device_scene.keeps_previous = temporal_needs_motion(frame);
    bool culls = frame->culling != FNL_CULLING_INSTANCES;
    r->device_scene.wanted_triangles = culls ? r->triangle_capacity : 0;
    TRY(device_scene_prepare(&r->device_scene));
    if (culls && r->device_scene.triangle_count > 0 && r->triangle_capacity == 0) { /* the scene's size is known now */
        grow_cluster_pools(r, &(struct frame_counts){0});
        r->device_scene.wanted_triangles = r->triangle_capacity;
        TRY(device_scene_prepare(&r->device_scene));
    }
    choose(r, frame);
    TRY(prepare_buffers(r, frame));
    if (frame->shading == FNL_SHADING_VIRTUAL_TEXTURING)
        TRY(device_virtual_prepare(&r->device_scene, frame->atlas_size, &r->atlas));
    TRY(gpu_frame_begin(r->device));
    double start = time_now();
    uint32_t slot = gpu_frame_slot(r->device);
    if (r->slot_frames[slot]) {
        grow_pool(r, slot_counts(r, slot));
        grow_blend_pool(r, slot_counts(r, slot));
        grow_decal_pool(r, slot_counts(r, slot));
        grow_cluster_pools(r, slot_counts(r, slot));
        grow_dais_pools(r, slot_counts(r, slot));
    }
    if (!r->blend_capacity) r->blend_capacity = blend_capacity(r, (uint64_t)frame->width * frame->height);
    memset(r->counts[slot].mapped, 0, sizeof(struct frame_counts));
    fnl_result result = frame_declare(r, frame, target);
    if (result != FNL_OK) {
        gpu_frame_end(r->device, NULL, 0, NULL);
        return result;
    }
    struct graph_execute_params execute = {.record_threads = frame->record_threads,
                                           .timers = frame->timers || r->chooses,
                                           .force_async_on_graphics = r->force_async,
                                           .poison = r->poison,
                                           .external = external};
    TRY(graph_execute_frame(r->graph, &execute));
    if (frame->shading == FNL_SHADING_VIRTUAL_TEXTURING) r->atlas.fresh = false;
    r->frame = *frame;
    r->frame_number = gpu_frame_number(r->device);
    if (r->chooses) chooser_note(&r->chooser, r->frame_number);
    feed_chooser(r);
    r->frame_slot = slot;
    r->slot_frames[slot] = r->frame_number;
    r->cpu_milliseconds = (time_now() - start) * 1e3;
    return FNL_OK;
}

static fnl_result render(fnl_renderer *r, const fnl_frame *given, const struct frame_target *target,
                         const struct gpu_external_semaphores *external) {
    fnl_frame frame = given ? *given : fnl_frame_default();
    TRY(check_frame(r, &frame));
    fnl_result result = make_frame(r, &frame, target, external);
    if (result != FNL_OK) {
        /* Buffers may have changed without a frame to fill them, and updates may never have reached the device. */
        r->frame_number = 0;
        r->temporal.valid = false;
        device_scene_forget(&r->device_scene);
        lists_forget(&r->lists);
        r->atlas.version = UINT64_MAX;
    }
    return result;
}

fnl_result fnl_renderer_render(fnl_renderer *r, const fnl_frame *frame) {
    if (!r) return FNL_ERROR_INVALID;
    return render(r, frame, NULL, NULL);
}

fnl_result fnl_renderer_render_to(fnl_renderer *r, const fnl_frame *given, const fnl_vulkan_target *target) {
    if (!r) return FNL_ERROR_INVALID;
    REQUIRE(&r->host, target != NULL);
    REQUIRE(&r->host, target->image != VK_NULL_HANDLE);
    REQUIRE(&r->host,
            target->final_layout != VK_IMAGE_LAYOUT_UNDEFINED && target->final_layout != VK_IMAGE_LAYOUT_PREINITIALIZED);
    fnl_frame frame = given ? *given : fnl_frame_default();
    frame.outputs &= ~(uint32_t)FNL_OUTPUT_COLOR; /* the picture goes into the target */
    struct gpu_image_params params = {.name = "target",
                                      .format = target->format,
                                      .width = frame.width,
                                      .height = frame.height,
                                      .layers = 1,
                                      .mips = 1,
                                      .samples = 1,
                                      .usage = VK_IMAGE_USAGE_TRANSFER_DST_BIT};
    static const VkFormat formats[] = {VK_FORMAT_R8G8B8A8_UNORM,      VK_FORMAT_R8G8B8A8_SRGB,
                                       VK_FORMAT_B8G8R8A8_UNORM,      VK_FORMAT_B8G8R8A8_SRGB,
                                       VK_FORMAT_R16G16B16A16_SFLOAT, VK_FORMAT_R32G32B32A32_SFLOAT};
    bool known = false;
    for (uint32_t i = 0; i < COUNT_OF(formats); i++) known = known || formats[i] == target->format;
    if (!known) {
        log_error(&r->host, "the target image has format %d, which is none of those that fnl_vulkan_target lists",
                  (int)target->format);
        return FNL_ERROR_UNSUPPORTED;
    }
    struct gpu_image image;
    TRY(gpu_image_import(r->device, target->image, &params, &image));
    struct frame_target frame_target = {&image, target->initial_layout, target->final_layout};
    struct gpu_external_semaphores external = {target->wait, target->signal, target->wait_value, target->signal_value};
    fnl_result result = render(r, &frame, &frame_target, &external);
    gpu_image_destroy(r->device, &image);
    return result;
}

/* ---- results ---- */

fnl_result fnl_renderer_read(fnl_renderer *r, fnl_output output, fnl_image *out) {
    if (!r || !out) return FNL_ERROR_INVALID;
    *out = (fnl_image){0};
    uint32_t bit = 0;
    while (bit < OUTPUT_COUNT && output != (fnl_output)(1u << bit)) bit++;
    REQUIRE(&r->host, bit < OUTPUT_COUNT && r->frame_number > 0 && (r->frame.outputs & (uint32_t)output));
    TRY(gpu_frame_wait(r->device, r->frame_number));
    size_t size = (size_t)r->frame.width * r->frame.height * output_pixel_size(bit);
    void *pixels = host_allocate(&r->host, size);
    if (!pixels) return FNL_ERROR_MEMORY;
    memcpy(pixels, r->outputs[bit].mapped, size);
    *out =
        (fnl_image){r->frame.width, r->frame.height, bit == 0 ? FNL_PIXEL_FORMAT_RGBA8 : FNL_PIXEL_FORMAT_RGBA32F, pixels};
    return FNL_OK;
}

static void sum_evaluations(const fnl_renderer *r, fnl_frame_stats *s) {
    const uint32_t *counters = r->counters.mapped;
    uint64_t pixels = (uint64_t)r->frame.width * r->frame.height;
    for (uint64_t i = 0; i < pixels; i++) {
        s->evaluations += counters[2 * i];
        s->evaluations_useful += counters[2 * i + 1];
        s->max_per_pixel = MAX(s->max_per_pixel, counters[2 * i]);
    }
    s->mean_per_pixel = (double)s->evaluations / (double)pixels;
    s->evaluations_counted = true;
    const struct gpu_draw *draws = r->draws.mapped;
    for (uint32_t b = 0; b < r->device_scene.buckets.count; b++) {
        const struct geometry_bucket *bucket = &r->device_scene.buckets.data[b];
        bool forward = !bucket->blend && shading_is(r->frame.shading, SHADING_LAYOUTS) &&
                       bucket->forward_layouts >> r->frame.gbuffer & 1;
        if (r->frame.shading == FNL_SHADING_VIRTUAL_TEXTURING)
            forward = !bucket->blend && bucket->forward_layouts >> VIRTUAL_FORWARD & 1;
        for (uint32_t i = 0; i < bucket->group_count && forward; i++)
            s->items_forward += draws[bucket->first_group + i].instance_count;
        if (bucket->topology != VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST) continue;
        for (uint32_t i = 0; i < bucket->group_count; i++) {
            const struct gpu_draw *draw = &draws[bucket->first_group + i];
            s->triangles_visible += (uint64_t)draw->index_count / 3 * draw->instance_count;
        }
    }
}

fnl_result fnl_renderer_query_stats(fnl_renderer *r, fnl_frame_stats *out) {
    if (!r || !out) return FNL_ERROR_INVALID;
    REQUIRE(&r->host, r->frame_number > 0);
    TRY(gpu_frame_wait(r->device, r->frame_number));
    const struct frame_counts *counts = slot_counts(r, r->frame_slot);
    grow_pool(r, counts);
    grow_blend_pool(r, counts);
    grow_decal_pool(r, counts);
    grow_cluster_pools(r, counts);
    grow_dais_pools(r, counts);
    *out = r->stats;
    dais_query(r, counts->dais, &out->dais);
    out->decals_in_view = MAX(counts->decals.in_view, counts->gbuffer_decals);
    out->decal_entries = (uint64_t)counts->decals.entries + counts->decal_fragments;
    out->decal_overflow = counts->decals.overflow_cells + counts->decal_overflow;
    struct light_totals lights = r->totals_known ? r->known_totals : counts->lights;
    out->lights_in_view = lights.in_view + r->device_scene.directional_count;
    out->list_entries = (uint64_t)lights.entries + counts->blend_lights.entries;
    out->overflow_cells = lights.overflow_cells + counts->blend_lights.overflow_cells;
    out->list_used_bytes = r->fixed_bytes + lights.entries * (uint64_t)r->entry_bytes +
                           counts->blend_lights.entries * (uint64_t)r->blend_entry_bytes;
    out->items_visible = counts->visible_items;
    const uint32_t *reasons = counts->clusters.reasons;
    uint64_t *const triangles[] = {[CLUSTERS_DRAWN] = &out->triangles_drawn,
                                   [CLUSTERS_OUTSIDE] = &out->triangles_outside,
                                   [CLUSTERS_BACK] = &out->triangles_back,
                                   [CLUSTERS_SMALL] = &out->triangles_small,
                                   [CLUSTERS_OCCLUDED] = &out->triangles_occluded};
    for (uint32_t i = 0; i < COUNT_OF(triangles); i++) *triangles[i] = reasons[2 * i] | (uint64_t)reasons[2 * i + 1] << 32;
    out->clusters_drawn = counts->clusters.clusters_drawn;
    out->items_occluded = counts->hidden_items;
    out->items_whole = counts->clusters.whole_items;
    memcpy(out->shading_blocks, counts->blocks, sizeof out->shading_blocks);
    out->msaa_pixels = counts->edges[EDGES_PIXELS];
    out->msaa_edge_pixels = counts->edges[EDGES_MIXED];
    out->msaa_surfaces = counts->edges[EDGES_SURFACES];
    out->msaa_samples = counts->edges[EDGES_SAMPLES];
    out->msaa_shaded = counts->edges[EDGES_SHADED];
    out->visibility_fragments = counts->visible_fragments;
    for (uint32_t c = 0; c < GPU_CLASSES; c++) {
        uint32_t entries = counts->visible[c][1] - counts->visible[c][0];
        out->visibility_classes += entries > 0;
        out->visibility_entries += entries;
    }
    out->coarse_shared = counts->coarse[COARSE_SHARED];
    out->coarse_by_depth = counts->coarse[COARSE_DEPTH];
    out->coarse_by_normal = counts->coarse[COARSE_NORMAL];
    out->coarse_by_material = counts->coarse[COARSE_OTHER];
    out->coarse_blocks =
        out->coarse_shared + out->coarse_by_depth + out->coarse_by_normal + out->coarse_by_material;
    out->coarse_pixels = counts->coarse[COARSE_COUNT_PIXELS];
    out->coarse_shaded = counts->coarse[COARSE_COUNT_SHADED];
    out->coarse_ao_shaded = counts->coarse_ao[COARSE_COUNT_SHADED];
    out->atlas_wanted = counts->pages.wanted;
    out->atlas_resident = counts->pages.resident;
    out->atlas_filled = counts->pages.filled;
    out->atlas_missing = counts->pages.missing;
    out->blend_fragments = counts->blend.fragments;
    out->blend_longest = counts->blend.longest;
    out->blend_overflow = counts->blend.overflow_pixels;
    if (r->frame.exposure == FNL_EXPOSURE_AUTO) out->ev = counts->exposure[1];
    if (r->frame.count_lights) sum_evaluations(r, out);
    out->lights_behind = counts->lights_behind;
    struct graph_stats graph = graph_query_stats(r->graph);
    out->image_bytes_read = graph.image_bytes_read;
    out->image_bytes_written = graph.image_bytes_written;
    out->tile_bytes = graph.tile_bytes;
    struct graph_lazy_memory lazy = graph_query_lazy_memory(r->graph);
    out->lazy_bytes = lazy.reserved_bytes;
    out->lazy_committed_bytes = lazy.committed_bytes;
    out->cpu_milliseconds = r->cpu_milliseconds;
    struct gpu_memory_stats memory = gpu_memory_stats(r->device);
    out->device_bytes = memory.used_bytes;
    out->device_peak_bytes = memory.peak_used_bytes;
    const struct graph_timer *timers;
    uint32_t count;
    r->pass_times.count = 0;
    if (r->frame.timers && graph_query_timers(r->graph, r->frame_number, &timers, &count)) {
        if (!array_reserve(&r->host, &r->pass_times, count)) return FNL_ERROR_MEMORY;
        for (uint32_t i = 0; i < count; i++) {
            r->pass_times.data[r->pass_times.count++] = (fnl_pass_time){timers[i].name, timers[i].milliseconds};
            out->gpu_milliseconds += timers[i].milliseconds;
        }
    }
    bool is_auto = r->asked.shading == FNL_SHADING_AUTO || r->asked.lists == FNL_LISTS_AUTO;
    out->shading = r->frame.shading;
    out->choosing = is_auto && r->chooser.state == CHOOSER_MEASURING;
    out->choice = is_auto ? r->chooser.reason : "";
    out->passes = r->pass_times.data;
    out->pass_count = r->pass_times.count;
    return FNL_OK;
}

size_t fnl_renderer_print_plan(const fnl_renderer *r, char *text, size_t capacity) {
    return r ? graph_print(r->graph, text, capacity) : 0;
}

size_t fnl_renderer_print_traffic(const fnl_renderer *r, char *text, size_t capacity) {
    return r ? graph_print_traffic(r->graph, text, capacity) : 0;
}
