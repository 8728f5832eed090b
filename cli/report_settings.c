/* SPDX-License-Identifier: MIT */
#include "report_settings.h"

#include "arguments.h"

#include <string.h>

static json_t *vector(bool is_set, fnl_vec3 v) {
    return is_set ? json_pack("[f,f,f]", (double)v.x, (double)v.y, (double)v.z) : json_null();
}
static json_t *number(bool is_set, double value) { return is_set ? json_real(value) : json_null(); }
static json_t *text(const char *value) { return value ? json_string(value) : json_null(); }

static json_t *names(uint32_t bits, const char *(*name_of)(int)) {
    json_t *array = json_array();
    for (int i = 0; name_of(i); i++)
        if (bits >> i & 1) json_array_append_new(array, json_string(name_of(i)));
    return array;
}

static json_t *make_picture(const struct render_options *o) {
    const fnl_frame *f = &o->frame;
    json_t *outputs = json_array();
    for (int i = 0; i < o->output_count; i++) json_array_append_new(outputs, json_string(o->outputs[i]));
    json_t *exposure = f->exposure == FNL_EXPOSURE_EV     ? json_real((double)f->ev)
                       : f->exposure == FNL_EXPOSURE_AUTO ? json_string("auto")
                                                          : json_string("none");
    return json_pack("{s:o,s:o,s:[i,i],s:o,s:o,s:o,s:o,s:o,s:o,s:s,s:o,s:o,s:o,s:s,s:o}", "output", outputs, "format",
                     text(render_format_name(o->has_format ? (int)o->format : -1)), "size", (int)f->width, (int)f->height,
                     "camera", text(o->camera), "camera_path", text(o->camera_path), "eye", vector(o->has_eye, o->eye),
                     "look_at", vector(o->has_look_at, o->look_at), "fov", number(o->fov > 0, (double)o->fov * 57.295779513082321),
                     "exposure", exposure, "tonemap", fnl_tonemap_name(f->tonemap), "background",
                     vector(o->has_background, o->background), "ambient", vector(o->has_ambient, o->ambient), "anisotropy",
                     number(o->has_anisotropy, (double)o->anisotropy), "debug", fnl_debug_view_name(f->debug), "aov",
                     names(o->aovs, render_aov_name));
}

static void add_scene(json_t *json, const struct render_options *o) {
    json_t *shapes = json_object();
    for (int i = 0; i < FNL_LIGHT_KIND_COUNT; i++)
        if (i != FNL_LIGHT_DIRECTIONAL)
            json_object_set_new(shapes, fnl_light_kind_name((fnl_light_kind)i), json_real((double)o->scatter.shares[i]));
    json_object_set_new(json, "lights", json_integer(o->scatter.count));
    json_object_set_new(json, "light_seed", json_integer((json_int_t)o->scatter.seed));
    json_object_set_new(json, "light_shapes", shapes);
    json_object_set_new(json, "light_scale", json_real((double)o->scatter.radius_scale));
    uint64_t most = o->loading.max_memory < INT64_MAX ? o->loading.max_memory : INT64_MAX;
    json_object_set_new(json, "grow_metal", json_integer(o->grow_metal));
    json_object_set_new(json, "lenient", json_boolean(o->loading.lenient));
    json_object_set_new(json, "confine", json_boolean(o->loading.confine));
    json_object_set_new(json, "max_memory", json_integer((json_int_t)most));
    json_object_set_new(json, "range_roughness", number(o->has_range_roughness, (double)o->range_roughness));
    json_object_set_new(json, "time", json_real(o->time));
    json_object_set_new(json, "animation", text(o->animation));
}

static json_t *make_mobile(const fnl_mobile_options *m) {
    return json_pack("{s:s,s:s,s:f,s:b,s:b}", "gamma", fnl_mobile_gamma_name(m->gamma), "light", fnl_mobile_light_name(m->light),
                     "range", (double)m->range, "separate", m->separate, "recycle", m->recycle);
}

static json_t *make_coarse(const fnl_coarse_options *c) {
    return json_pack("{s:i,s:s,s:f,s:f,s:f,s:f,s:s,s:s,s:f,s:b}", "size", (int)c->size, "criterion",
                     fnl_coarse_criterion_name(c->criterion), "depth_factor", (double)c->depth_factor, "normal_degrees",
                     (double)c->normal_degrees, "tolerance", (double)c->tolerance, "albedo_tolerance",
                     (double)c->albedo_tolerance, "split", fnl_coarse_split_name(c->split), "filter",
                     fnl_coarse_filter_name(c->filter), "ao", (double)c->ao_radius, "gather", c->gather);
}

static void add_method(json_t *json, const struct render_options *o) {
    const fnl_frame *f = &o->frame;
    json_t *decals = f->decal_mip_fix ? json_string(fnl_decals_name(f->decals))
                                      : json_sprintf("%s,no-mip-fix", fnl_decals_name(f->decals));
    const struct {
        const char *key;
        json_t *value;
    } values[] = {{"shading", text(fnl_shading_name(f->shading))},
                  {"lists", text(fnl_light_lists_name(f->lists))},
                  {"list_option", argument_list_options_json(&f->list_options)},
                  {"light_lod", json_real((double)f->light_lod)},
                  {"deferred_pass", text(fnl_deferred_pass_name(f->deferred_pass))},
                  {"gbuffer", text(fnl_gbuffer_name(f->gbuffer))},
                  {"normals", text(fnl_normal_encoding_name(f->normals))},
                  {"chroma", json_boolean(f->chroma)},
                  {"atlas_size", json_integer(f->atlas_size)},
                  {"gradients", text(fnl_gradients_name(f->gradients))},
                  {"gbuffer_prepass", json_boolean(f->gbuffer_prepass)},
                  {"class_blocks", json_integer(f->class_blocks)},
                  {"mobile_layout", text(fnl_mobile_layout_name(f->mobile.layout))},
                  {"mobile_lights", text(fnl_mobile_lights_name(f->mobile.lights))},
                  {"mobile", make_mobile(&f->mobile)},
                  {"visibility_sort", text(fnl_visibility_sort_name(f->visibility.sort))},
                  {"visibility_barycentrics", json_boolean(f->visibility.barycentrics)},
                  {"visibility_grid", json_boolean(f->visibility.grid)},
                  {"dais", text(fnl_dais_mode_name(f->dais.mode))},
                  {"dais_multirate", json_boolean(f->dais.multirate)},
                  {"dais_cache", json_integer(f->dais.cache_buckets)},
                  {"coarse", make_coarse(&f->coarse)},
                  {"shade_cost", json_integer(f->shade_cost)},
                  {"msaa", json_integer(f->msaa)},
                  {"msaa_method", text(fnl_msaa_method_name(f->msaa_method))},
                  {"msaa_groups", json_integer(f->msaa_groups)},
                  {"msaa_tolerance", json_real((double)f->msaa_tolerance)},
                  {"decals", decals},
                  {"cull", text(fnl_culling_name(f->culling))},
                  {"geometry", text(fnl_geometry_name(f->geometry))},
                  {"occlusion", json_boolean(f->occlusion)},
                  {"transparency", text(fnl_transparency_name(f->transparency))},
                  {"aa", text(fnl_antialiasing_name(f->aa))},
                  {"supersample", json_integer(o->supersample ? o->supersample : 1)}};
    for (size_t i = 0; i < sizeof values / sizeof *values; i++) json_object_set_new(json, values[i].key, values[i].value);
}

static void add_run(json_t *json, const struct render_options *o) {
    json_object_set_new(json, "frames", json_integer(o->frame_count));
    json_object_set_new(json, "start_frame", json_integer(o->start_frame));
    json_object_set_new(json, "frame_time", json_real(o->frame_time));
    json_object_set_new(json, "choose_seconds", json_real(o->choose_seconds));
    json_object_set_new(json, "stats", text(o->stats));
    json_object_set_new(json, "plan", json_boolean(o->plan));
    json_object_set_new(json, "traffic", json_boolean(o->traffic));
    json_object_set_new(json, "device", text(o->device));
    json_object_set_new(json, "validate", json_boolean(o->validate));
    json_object_set_new(json, "quiet", json_boolean(o->quiet));
}

json_t *report_settings(const struct render_options *o) {
    json_t *json = make_picture(o);
    add_scene(json, o);
    add_method(json, o);
    add_run(json, o);
    return json;
}
