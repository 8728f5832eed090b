/* SPDX-License-Identifier: MIT */
/*
 * The numbers of a run as JSON, by docs/stats.schema.json. All keys are always there: an object is null where the frame had no such thing, a number
 * where it was not counted.
 */
#include "program.h"
#include "render.h"
#include "report_settings.h"

#include <jansson.h>
#include <stdio.h>
#include <stdlib.h>

enum { FORMAT_VERSION = 2, DIGITS = 9 };

static json_t *integer(uint64_t value) { return json_integer((json_int_t)value); }
static json_t *counted(bool is_known, uint64_t value) { return is_known ? integer(value) : json_null(); }
static json_t *measured(bool is_known, double value) { return is_known ? json_real(value) : json_null(); }
static json_t *vector(fnl_vec3 v) { return json_pack("[f,f,f]", (double)v.x, (double)v.y, (double)v.z); }

static json_t *make_camera(const fnl_camera *c) {
    return json_pack("{s:o,s:o,s:o,s:b,s:f,s:f}", "position", vector(c->position), "target", vector(c->target), "up",
                               vector(c->up), "orthographic", c->orthographic, "vertical_fov",
                               (double)c->vertical_fov * 57.295779513082321, "vertical_extent", (double)c->vertical_extent);
}

static json_t *make_view(const struct render_report *r) {
    const fnl_frame_stats *s = &r->stats;
    return json_pack("{s:i,s:i,s:s,s:s,s:i,s:o,s:o,s:f,s:o}", "width", (int)r->frame.width, "height", (int)r->frame.height,
                     "shading", fnl_value_name(FNL_ENUM_SHADING, s->shading), "lists", fnl_value_name(FNL_ENUM_LISTS, s->lists), "msaa",
                     (int)r->frame.msaa, "choice", s->choice[0] ? json_string(s->choice) : json_null(), "picture",
                     counted(r->picture != UINT32_MAX, r->picture), "time", r->time, "camera",
                     make_camera(&r->frame.camera));
}

static json_t *make_passes(const struct render_report *r) {
    json_t *passes = json_array();
    for (uint32_t i = 0; i < r->pass_count; i++) {
        struct report_summary p = report_summarise(r->pass_times + (size_t)i * r->frame_count, r->frame_count);
        bool timed = r->device.timestamps;
        json_array_append_new(passes, json_pack("{s:s,s:o,s:o,s:o}", "name", r->names[i], "gpu_ms_median",
                                                measured(timed, p.median), "gpu_ms_min", measured(timed, p.low), "gpu_ms_p95",
                                                measured(timed, p.p95)));
    }
    return passes;
}

static json_t *make_lights(const struct render_report *r) {
    const fnl_frame_stats *s = &r->stats;
    bool c = s->evaluations_counted;
    return json_pack("{s:o,s:o,s:o,s:o,s:o,s:o,s:o,s:o,s:o,s:o,s:o,s:o}", "total", integer(s->lights_total), "in_view",
                     integer(s->lights_in_view), "list_bytes", integer(s->list_bytes), "list_used_bytes",
                     integer(s->list_used_bytes), "list_entries", integer(s->list_entries), "overflow_cells",
                     integer(s->overflow_cells), "dropped", integer(s->lights_dropped), "behind",
                     counted(s->lists == FNL_LISTS_BACKFACE, s->lights_behind), "evaluations", counted(c, s->evaluations),
                     "evaluations_useful", counted(c, s->evaluations_useful), "mean_per_pixel",
                     measured(c, s->mean_per_pixel), "max_per_pixel", counted(c, s->max_per_pixel));
}

static json_t *make_culling(const struct render_report *r) {
    const fnl_frame_stats *s = &r->stats;
    bool parts = r->frame.culling != FNL_CULLING_INSTANCES, hides = r->frame.occlusion;
    json_t *culling = json_pack("{s:o,s:o,s:o,s:s,s:o,s:o,s:o}", "items", integer(s->items), "items_visible",
                                integer(s->items_visible), "triangles_visible",
                                counted(s->evaluations_counted, s->triangles_visible), "kind",
                                fnl_value_name(FNL_ENUM_CULLING, r->frame.culling), "geometry",
                                parts ? json_string(fnl_value_name(FNL_ENUM_GEOMETRY, s->geometry)) : json_null(), "items_occluded",
                                counted(hides, s->items_occluded), "triangles_occluded",
                                counted(hides, s->triangles_occluded));
    json_object_set_new(culling, "triangles_total", counted(parts, s->triangles_total));
    json_object_set_new(culling, "triangles_drawn", counted(parts, s->triangles_drawn));
    json_object_set_new(culling, "triangles_outside", counted(parts, s->triangles_outside));
    json_object_set_new(culling, "triangles_back", counted(parts, s->triangles_back));
    json_object_set_new(culling, "triangles_small", counted(parts, s->triangles_small));
    json_object_set_new(culling, "clusters_total", counted(parts, s->clusters_total));
    json_object_set_new(culling, "clusters_drawn", counted(parts, s->clusters_drawn));
    json_object_set_new(culling, "items_whole", counted(parts, s->items_whole));
    return culling;
}

static json_t *make_shading_blocks(const struct render_report *r) {
    json_t *blocks = r->frame.deferred.class_blocks ? json_array() : json_null();
    for (int i = 0; i < 9 && r->frame.deferred.class_blocks; i++) json_array_append_new(blocks, integer(r->stats.shading_blocks[i]));
    return blocks;
}

static json_t *make_decals(const struct render_report *r) {
    const fnl_frame_stats *s = &r->stats;
    return json_pack("{s:s,s:o,s:o,s:o,s:o}", "way", fnl_value_name(FNL_ENUM_DECALS, r->frame.decals), "total", integer(s->decals_total),
                     "in_view", integer(s->decals_in_view), "entries", integer(s->decal_entries), "overflow",
                     integer(s->decal_overflow));
}

static json_t *make_transparency(const struct render_report *r) {
    const fnl_frame_stats *s = &r->stats;
    bool linked = r->frame.transparency == FNL_TRANSPARENCY_LINKED;
    return json_pack("{s:s,s:o,s:o,s:o,s:o}", "kind", fnl_value_name(FNL_ENUM_TRANSPARENCY, r->frame.transparency), "fragments",
                     counted(linked, s->blend_fragments), "longest", counted(linked, s->blend_longest), "bytes",
                     integer(s->blend_bytes), "overflow_pixels", counted(linked, s->blend_overflow));
}

static json_t *make_gbuffer(const struct render_report *r) {
    const fnl_frame_stats *s = &r->stats;
    return json_pack("{s:s,s:s,s:b,s:o,s:o}", "layout", fnl_value_name(FNL_ENUM_GBUFFER, r->frame.gbuffer.layout), "normals",
                     fnl_value_name(FNL_ENUM_NORMALS, r->frame.gbuffer.normals), "chroma", r->frame.gbuffer.chroma, "bytes",
                     integer(s->gbuffer_bytes), "items_forward", counted(s->evaluations_counted, s->items_forward));
}

static json_t *make_images(const struct render_report *r) {
    const fnl_frame_stats *s = &r->stats;
    return json_pack("{s:o,s:o,s:o,s:o,s:o}", "bytes_read", integer(s->image_bytes_read), "bytes_written",
                     integer(s->image_bytes_written), "tile_bytes", integer(s->tile_bytes), "lazy_bytes",
                     integer(s->lazy_bytes), "lazy_committed_bytes", integer(s->lazy_committed_bytes));
}

/* ---- what only some orders have ---- */

static json_t *make_msaa(const struct render_report *r) {
    const fnl_frame_stats *s = &r->stats;
    if (s->msaa_pixels == 0) return json_null();
    return json_pack("{s:s,s:o,s:o,s:o,s:o,s:o}", "method", fnl_value_name(FNL_ENUM_MSAA_METHOD, r->frame.deferred.msaa_method), "pixels",
                     integer(s->msaa_pixels), "edge_pixels", integer(s->msaa_edge_pixels), "surfaces",
                     integer(s->msaa_surfaces), "samples", integer(s->msaa_samples), "shaded",
                     counted(s->evaluations_counted, s->msaa_shaded));
}

static json_t *make_dais(const struct render_report *r) {
    const struct fnl_dais_stats *d = &r->stats.dais;
    const fnl_dais_options *o = &r->frame.dais;
    bool c = r->stats.evaluations_counted;
    if (r->stats.shading != FNL_SHADING_DAIS) return json_null();
    return json_pack("{s:s,s:b,s:o,s:o,s:o,s:o,s:o,s:o,s:o,s:o}", "mode", fnl_value_name(FNL_ENUM_DAIS_MODE, o->mode), "multirate",
                     o->multirate, "bytes", integer(d->bytes), "triangles", integer(d->triangles), "unique",
                     counted(c, d->unique), "cache_failures", integer(d->cache_failures), "overflow", integer(d->overflow),
                     "list_elements", counted(o->mode == FNL_DAIS_LIST, d->list_elements), "shading_samples",
                     counted(o->multirate, d->shading_samples), "shaded", counted(c, d->shaded));
}

static json_t *make_visibility(const struct render_report *r) {
    const fnl_frame_stats *s = &r->stats;
    const fnl_visibility_options *o = &r->frame.visibility;
    bool sorted = o->sort != FNL_VISIBILITY_SORT_OFF || r->frame.msaa > 1;
    if (s->shading != FNL_SHADING_VISIBILITY) return json_null();
    return json_pack("{s:s,s:b,s:b,s:o,s:o,s:o}", "sort", fnl_value_name(FNL_ENUM_VISIBILITY_SORT, o->sort), "barycentrics", o->barycentrics,
                     "grid", o->grid, "fragments", counted(s->evaluations_counted, s->visibility_fragments), "entries",
                     counted(sorted, s->visibility_entries), "classes", counted(sorted, s->visibility_classes));
}

static json_t *make_atlas(const struct render_report *r) {
    const fnl_frame_stats *s = &r->stats;
    if (s->atlas_pages == 0) return json_null();
    return json_pack("{s:o,s:o,s:o,s:o,s:o,s:o,s:o,s:o}", "pages", integer(s->atlas_pages), "capacity",
                     integer(s->atlas_capacity), "wanted", integer(s->atlas_wanted), "resident", integer(s->atlas_resident),
                     "filled", integer(s->atlas_filled), "missing", integer(s->atlas_missing), "evicted",
                     integer(s->atlas_evicted), "bytes", integer(s->atlas_bytes));
}

static json_t *make_mobile(const struct render_report *r) {
    if (r->stats.shading != FNL_SHADING_MOBILE) return json_null();
    return json_pack("{s:s,s:b,s:b}", "layout", fnl_value_name(FNL_ENUM_MOBILE_LAYOUT, r->frame.mobile.layout), "merged",
                     r->stats.mobile_merged, "tonemapped_inside", r->stats.mobile_tonemapped);
}

static json_t *make_coarse(const struct render_report *r) {
    const fnl_frame_stats *s = &r->stats;
    const fnl_coarse_options *o = &r->frame.coarse;
    if (s->shading != FNL_SHADING_COARSE) return json_null();
    return json_pack("{s:i,s:s,s:s,s:o,s:o,s:o,s:o,s:o,s:o,s:o,s:o}", "size", (int)o->size, "criterion",
                     fnl_value_name(FNL_ENUM_COARSE_CRITERION, o->criterion), "split", fnl_value_name(FNL_ENUM_COARSE_SPLIT, o->split), "blocks",
                     integer(s->coarse_blocks), "shared", integer(s->coarse_shared), "by_depth", integer(s->coarse_by_depth),
                     "by_normal", integer(s->coarse_by_normal), "by_material", integer(s->coarse_by_material), "pixels",
                     integer(s->coarse_pixels), "shaded", integer(s->coarse_shaded), "ao_shaded",
                     counted(o->ao_radius > 0, s->coarse_ao_shaded));
}

/* The numbers of a frame's views, where it has several. */
static json_t *make_views(const struct render_report *r) {
    json_t *views = r->stats.view_count ? json_array() : json_null();
    for (uint32_t i = 0; i < r->stats.view_count; i++) {
        struct render_report view = *r;
        view.stats = r->stats.views[i];
        json_array_append_new(views, json_pack("{s:o,s:o,s:o,s:f}", "camera", make_camera(&r->frame.views[i]), "lights", make_lights(&view),
                                               "culling", make_culling(&view), "ev", (double)view.stats.ev));
    }
    return views;
}

char *report_text(const struct render_report *r, bool line) {
    const fnl_frame_stats *s = &r->stats;
    const fnl_scene_info *scene = &r->scene;
    double gpu = report_summarise(r->gpu_times, r->frame_count).median;
    json_t *json = json_pack(
        "{s:i,s:{s:s,s:s},s:{s:s,s:s,s:s},s:{s:s,s:o,s:o,s:o,s:o,s:o,s:o,s:o,s:o},s:o,s:o,s:o,s:{s:o,s:f},s:o,s:i,s:o}",
        "version", FORMAT_VERSION, "program", "version", fnl_version(), "commit", program_commit, "device", "name",
        r->device.name, "driver", r->device.driver, "type", fnl_value_name(FNL_ENUM_DEVICE_TYPE, r->device.type), "scene", "source",
        r->options->scene, "triangles", integer(scene->triangle_count), "instances", integer(scene->instance_count), "lights",
        integer(s->lights_total), "decals", integer(scene->decal_count), "meshes", integer(scene->mesh_count), "materials",
        integer(scene->material_count), "images", integer(scene->image_count), "animations",
        integer(scene->animation_count), "settings", report_settings(r->options), "view", make_view(r), "passes",
        make_passes(r), "frame", "gpu_ms_median", measured(r->device.timestamps, gpu), "cpu_ms_median",
        report_summarise(r->cpu_times, r->frame_count).median, "lights", make_lights(r), "draws", (int)s->draws, "culling",
        make_culling(r));
    if (!json) return NULL;
    json_object_set_new(json, "views", make_views(r));
    json_object_set_new(json, "ev", json_real((double)s->ev));
    json_object_set_new(json, "memory",
                        json_pack("{s:o,s:o}", "device_bytes", integer(s->device_bytes), "peak_bytes",
                                  integer(s->device_peak_bytes)));
    json_object_set_new(json, "light_bytes", integer(s->light_bytes));
    json_object_set_new(json, "light_draws", integer(s->light_draws));
    json_object_set_new(json, "images", make_images(r));
    json_object_set_new(json, "gbuffer", make_gbuffer(r));
    json_object_set_new(json, "decals", make_decals(r));
    json_object_set_new(json, "transparency", make_transparency(r));
    json_object_set_new(json, "shading_blocks", make_shading_blocks(r));
    json_object_set_new(json, "msaa", make_msaa(r));
    json_object_set_new(json, "visibility", make_visibility(r));
    json_object_set_new(json, "dais", make_dais(r));
    json_object_set_new(json, "coarse", make_coarse(r));
    json_object_set_new(json, "atlas", make_atlas(r));
    json_object_set_new(json, "mobile", make_mobile(r));
    char *text = json_dumps(json, (line ? JSON_COMPACT : JSON_INDENT(2)) | JSON_REAL_PRECISION(DIGITS));
    json_decref(json);
    char *ended = NULL;
    if (text && asprintf(&ended, "%s\n", text) < 0) ended = NULL;
    free(text);
    return ended;
}
