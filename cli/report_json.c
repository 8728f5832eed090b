/* SPDX-License-Identifier: MIT */
/*
 * The numbers of a run as JSON, by docs/stats.schema.json. All keys are always there: an object is null where the frame had no such thing, a number
 * where it was not counted. Those of single techniques come from their rows (counters.h).
 */
#include "counters.h"
#include "json_text.h"
#include "origin.h"
#include "pixel.h"
#include "program.h"
#include "render.h"
#include "report_settings.h"

#include <jansson.h>
#include <stdio.h>
#include <stdlib.h>

enum { FORMAT_VERSION = 4, DIGITS = 9 };

static json_t *integer(uint64_t value) { return json_integer((json_int_t)value); }
static json_t *counted(bool is_known, uint64_t value) { return is_known ? integer(value) : json_null(); }
static json_t *measured(bool is_known, double value) { return is_known ? json_real(value) : json_null(); }
static json_t *vector(fnl_vec3 v) { return json_pack("[f,f,f]", (double)v.x, (double)v.y, (double)v.z); }

static json_t *make_camera(const fnl_scene *scene, const fnl_camera *c) {
    return json_pack("{s:o,s:o,s:o,s:b,s:f,s:f}", "position", origin_json(scene, c->position), "target", origin_json(scene, c->target), "up",
                               vector(c->up), "orthographic", c->orthographic, "vertical_fov",
                               (double)c->vertical_fov * 57.295779513082321, "vertical_extent", (double)c->vertical_extent);
}

static json_t *make_candidates(const fnl_frame_stats *s) {
    json_t *candidates = json_array();
    for (uint32_t i = 0; i < s->candidate_count; i++) {
        const fnl_candidate *c = &s->candidates[i];
        json_array_append_new(candidates, json_pack("{s:s,s:s,s:o,s:i,s:b}", "shading", fnl_value_name(FNL_ENUM_SHADING, c->shading), "lists",
                                                    fnl_value_name(FNL_ENUM_LISTS, c->lists), "ms", measured(c->milliseconds > 0, c->milliseconds),
                                                    "frames", (int)c->frames, "chosen", c->chosen));
    }
    return candidates;
}

static json_t *make_view(const struct render_report *r) {
    const fnl_frame_stats *s = &r->stats;
    return json_pack("{s:i,s:i,s:s,s:s,s:i,s:o,s:o,s:o,s:f,s:o}", "width", (int)r->frame.width, "height", (int)r->frame.height,
                     "shading", fnl_value_name(FNL_ENUM_SHADING, s->shading), "lists", fnl_value_name(FNL_ENUM_LISTS, s->lists), "msaa",
                     (int)s->msaa, "choice", s->choice[0] ? json_text(s->choice) : json_null(), "candidates", make_candidates(s), "picture",
                     counted(r->picture != UINT32_MAX, r->picture), "time", r->time, "camera",
                     make_camera(r->shown, &r->frame.camera));
}

static struct report_summary row_of(const struct render_report *r, const double *rows, uint32_t index) {
    return report_summarise(rows + (size_t)index * r->frame_count, r->frame_count);
}

static json_t *make_passes(const struct render_report *r) {
    json_t *passes = json_array();
    const bool timed = r->device.timestamps;
    for (uint32_t i = 0; i < r->passes.count; i++) {
        struct report_summary p = row_of(r, r->passes.times, i);
        const struct report_row *row = &r->passes.rows[i];
        json_array_append_new(passes, json_pack("{s:s,s:s,s:s,s:o,s:o,s:o,s:o}", "name", row->name, "queue", fnl_value_name(FNL_ENUM_QUEUE, (uint32_t)row->queue),
                                                "role", fnl_value_name(FNL_ENUM_PASS_ROLE, (uint32_t)row->role), "begin_ms_median",
                                                measured(timed, row_of(r, r->passes.begins, i).median), "gpu_ms_median", measured(timed, p.median),
                                                "gpu_ms_min", measured(timed, p.low), "gpu_ms_p95", measured(timed, p.p95)));
    }
    return passes;
}

static json_t *make_sections(const struct render_report *r) {
    json_t *sections = json_array();
    for (uint32_t i = 0; i < r->sections.count; i++)
        json_array_append_new(sections, json_pack("{s:s,s:f,s:f}", "name", r->sections.rows[i].name, "begin_ms_median",
                                                  row_of(r, r->sections.begins, i).median, "ms_median", row_of(r, r->sections.times, i).median));
    return sections;
}

static json_t *make_lights(const struct render_report *r) {
    const fnl_frame_stats *s = &r->stats;
    bool c = s->evaluations_counted;
    return json_pack("{s:o,s:o,s:o,s:o,s:o,s:o,s:o,s:o,s:o,s:o,s:o}", "total", integer(s->lights_total), "in_view",
                     integer(s->lights_in_view), "list_bytes", integer(s->list_bytes), "list_used_bytes",
                     integer(s->list_used_bytes), "list_entries", integer(s->list_entries), "overflow_cells",
                     integer(s->overflow_cells), "dropped", integer(s->lights_dropped), "evaluations",
                     counted(c, s->evaluations), "evaluations_useful", counted(c, s->evaluations_useful), "mean_per_pixel",
                     measured(c, s->mean_per_pixel), "max_per_pixel", counted(c, s->max_per_pixel));
}

static json_t *make_culling(const struct render_report *r) {
    const fnl_frame_stats *s = &r->stats;
    bool parts = r->frame.culling != FNL_CULLING_INSTANCES, hides = r->stats.occlusion;
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

static json_t *make_images(const struct render_report *r) {
    const fnl_frame_stats *s = &r->stats;
    return json_pack("{s:o,s:o,s:o,s:o,s:o}", "bytes_read", integer(s->image_bytes_read), "bytes_written",
                     integer(s->image_bytes_written), "tile_bytes", integer(s->tile_bytes), "lazy_bytes",
                     integer(s->lazy_bytes), "lazy_committed_bytes", integer(s->lazy_committed_bytes));
}

/* The numbers of a frame's views, where it has several. */
static json_t *make_views(const struct render_report *r) {
    json_t *views = r->stats.view_count ? json_array() : json_null();
    for (uint32_t i = 0; i < r->stats.view_count; i++) {
        struct render_report view = *r;
        view.stats = r->stats.views[i];
        json_t *own = json_pack("{s:o,s:o,s:o,s:f}", "camera", make_camera(r->shown, &r->frame.views[i]), "lights", make_lights(&view),
                                "culling", make_culling(&view), "ev", (double)view.stats.ev);
        if (own) counters_set_groups(own, &view.stats);
        json_array_append_new(views, own);
    }
    return views;
}

char *report_text(const struct render_report *r, bool line) {
    const fnl_frame_stats *s = &r->stats;
    const fnl_scene_info *scene = &r->scene;
    double gpu = report_summarise(r->gpu_times, r->frame_count).median;
    json_t *json = json_pack(
        "{s:i,s:{s:s,s:s},s:{s:s,s:s,s:s},s:{s:o,s:o,s:o,s:o,s:o,s:o,s:o,s:o,s:o,s:o,s:o},s:o,s:o,s:o,s:{s:o,s:f,s:o},s:o,s:i,s:o}",
        "version", FORMAT_VERSION, "program", "version", fnl_version(), "commit", program_commit, "device", "name",
        r->device.name, "driver", r->device.driver, "type", fnl_value_name(FNL_ENUM_DEVICE_TYPE, r->device.type), "scene", "source",
        json_text(r->options->world.scene), "triangles", integer(scene->triangle_count), "instances", integer(scene->instance_count), "lights",
        integer(s->lights_total), "unlimited_lights", integer(scene->unlimited_light_count), "light_threshold",
        scene->light_threshold > 0 ? json_real(scene->light_threshold) : json_null(), "decals", integer(scene->decal_count), "meshes", integer(scene->mesh_count), "materials",
        integer(scene->material_count), "images", integer(scene->image_count), "animations",
        integer(scene->animation_count), "settings", report_settings(r->options), "view", make_view(r), "passes",
        make_passes(r), "frame", "gpu_ms_median", measured(r->device.timestamps, gpu), "cpu_ms_median",
        report_summarise(r->cpu_times, r->frame_count).median, "cpu", make_sections(r), "lights", make_lights(r), "draws", (int)s->draws, "culling",
        make_culling(r));
    if (!json) return NULL;
    json_object_set_new(json, "views", make_views(r));
    json_object_set_new(json, "ev", json_real((double)s->ev));
    json_t *kinds = json_object();
    for (uint32_t i = 0; i < s->memory_kind_count; i++) json_object_set_new(kinds, s->memory_kinds[i].name, integer(s->memory_kinds[i].bytes));
    json_object_set_new(json, "memory",
                        json_pack("{s:o,s:o,s:o}", "device_bytes", integer(s->device_bytes), "peak_bytes", integer(s->device_peak_bytes), "kinds", kinds));
    json_object_set_new(json, "images", make_images(r));
    json_object_set_new(json, "pixel", pixel_json(r->shown, &r->pixel));
    counters_set_groups(json, s);
    char *text = json_text_write(json, (line ? JSON_COMPACT : JSON_INDENT(2)) | JSON_REAL_PRECISION(DIGITS));
    json_decref(json);
    char *ended = NULL;
    if (text && asprintf(&ended, "%s\n", text) < 0) ended = NULL;
    free(text);
    return ended;
}
