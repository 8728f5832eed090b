/* SPDX-License-Identifier: MIT */
#include "report_settings.h"

#include "json_text.h"
#include "options.h"

#include <math.h>
#include <string.h>

static json_t *vector(bool is_set, fnl_vec3 v) {
    return is_set ? json_pack("[f,f,f]", (double)v.x, (double)v.y, (double)v.z) : json_null();
}
static json_t *place(bool is_set, const double p[3]) { return is_set ? json_pack("[f,f,f]", p[0], p[1], p[2]) : json_null(); }
static json_t *number(bool is_set, double value) { return is_set ? json_real(value) : json_null(); }

static json_t *names(uint32_t bits, const char *(*name_of)(int)) {
    json_t *array = json_array();
    for (int i = 0; name_of(i); i++)
        if (bits >> i & 1) json_array_append_new(array, json_string(name_of(i)));
    return array;
}

static void add_eyes(json_t *json, const struct render_options *o) {
    json_object_set_new(json, "stereo", json_text(stereo_kind_name((int)o->stereo.kind - 1)));
    json_object_set_new(json, "ipd", number(!isnan(o->stereo.ipd), (double)o->stereo.ipd));
    json_object_set_new(json, "hmd", json_text(o->stereo.hmd));
    json_object_set_new(json, "lens", json_text(o->display.given ? display_warp_name((int)o->display.warp) : NULL));
    json_object_set_new(json, "lens_view", json_text(display_view_name((int)o->display.view)));
    json_object_set_new(json, "hidden_mesh", json_boolean(o->display.hides));
}

static json_t *make_picture(const struct render_options *o) {
    const fnl_environment_params *environment = &o->world.environment_params;
    json_t *outputs = json_array();
    for (int i = 0; i < o->output_count; i++) json_array_append_new(outputs, json_text(o->outputs[i]));
    return json_pack("{s:o,s:o,s:o,s:o,s:o,s:o,s:o,s:o,s:o,s:o,s:o,s:o,s:o,s:f,s:o,s:b,s:b,s:o,s:o}", "output", outputs, "format",
                     json_text(render_format_name(o->has_format ? (int)o->format : -1)), "camera", json_text(o->world.camera), "views", json_text(o->views), "camera_path",
                     json_text(o->camera_path), "eye", place(o->world.has_eye, o->world.eye), "look_at", place(o->world.has_look_at, o->world.look_at), "fov",
                     number(o->world.fov > 0, (double)o->world.fov * 57.295779513082321), "near", number(o->world.near > 0, (double)o->world.near), "up",
                     vector(o->world.up.x != 0 || o->world.up.y != 0 || o->world.up.z != 0, o->world.up), "background",
                     vector(o->world.has_background, o->world.background), "ambient", vector(o->world.has_ambient, o->world.ambient), "environment",
                     json_text(o->world.environment), "environment_rotation", (double)environment->rotation * 57.295779513082321, "environment_intensity",
                     number(!environment->intensity_auto, (double)environment->intensity), "environment_hidden", !environment->background, "environment_compressed", environment->compressed, "anisotropy",
                     number(o->world.has_anisotropy, (double)o->world.anisotropy), "aov", names(o->aovs, render_aov_name));
}

/* As --probe takes them. */
static json_t *probes(const struct render_options *o) {
    json_t *array = json_array();
    for (uint32_t i = 0; i < o->world.probe_count; i++) {
        const fnl_probe_params *p = &o->world.probes[i];
        const double *centre = o->world.probe_centres[i];
        const double values[] = {centre[0], centre[1], centre[2], (double)p->half_size.x, (double)p->half_size.y, (double)p->half_size.z, (double)p->softness};
        json_t *probe = json_array();
        for (size_t j = 0; j < sizeof values / sizeof *values; j++) json_array_append_new(probe, json_real(values[j]));
        json_array_append_new(array, probe);
    }
    return array;
}

static void add_scene(json_t *json, const struct render_options *o) {
    json_t *shapes = json_object();
    for (int i = 0; i < FNL_LIGHT_KIND_COUNT; i++)
        if (i != FNL_LIGHT_DIRECTIONAL)
            json_object_set_new(shapes, fnl_value_name(FNL_ENUM_LIGHT_KIND, (fnl_light_kind)i), json_real((double)o->world.scatter.shares[i]));
    json_object_set_new(json, "lights", o->world.lights < 0 ? json_null() : json_integer(o->world.lights));
    json_object_set_new(json, "light_seed", json_integer((json_int_t)o->world.scatter.seed));
    json_object_set_new(json, "light_shapes", shapes);
    json_object_set_new(json, "light_scale", json_real((double)o->world.scatter.radius_scale));
    json_object_set_new(json, "ies", json_text(o->world.ies));
    uint64_t most = o->world.loading.max_memory < INT64_MAX ? o->world.loading.max_memory : INT64_MAX;
    json_object_set_new(json, "probe", probes(o));
    json_object_set_new(json, "probe_auto", json_boolean(o->world.probe_auto));
    json_object_set_new(json, "probe_reflections", json_boolean(o->world.probe_reflections));
    json_object_set_new(json, "grow_metal", json_integer(o->world.grow_metal));
    json_object_set_new(json, "lenient", json_boolean(o->world.loading.lenient));
    json_object_set_new(json, "confine", json_boolean(o->world.loading.confine));
    json_object_set_new(json, "max_memory", json_integer((json_int_t)most));
    json_object_set_new(json, "range_roughness", number(o->world.has_range_roughness, (double)o->world.range_roughness));
    json_object_set_new(json, "time", json_real(o->world.time));
    json_object_set_new(json, "animation", json_text(o->world.animation));
    json_object_set_new(json, "variant", json_text(o->world.variant));
}

static void add_run(json_t *json, const struct render_options *o) {
    json_object_set_new(json, "frames", json_integer(o->frame_count));
    json_object_set_new(json, "start_frame", json_integer(o->start_frame));
    json_object_set_new(json, "frame_time", json_real(o->frame_time));
    json_object_set_new(json, "choose_seconds", json_real(o->choose_seconds));
    json_object_set_new(json, "stats", json_text(o->stats));
    json_object_set_new(json, "trace_file", json_text(o->trace_file));
    json_object_set_new(json, "save_scene", json_text(o->save_scene));
    const fnl_pixel_query *pixel = &o->frame.pixel;
    json_object_set_new(json, "pixel", pixel->asked ? json_pack("[i,i,i]", (int)pixel->x, (int)pixel->y, (int)pixel->view) : json_null());
    json_object_set_new(json, "plan", json_text(render_plan_name((int)o->plan)));
    json_object_set_new(json, "traffic", json_boolean(o->traffic));
    json_object_set_new(json, "device", json_text(o->device));
    json_object_set_new(json, "validate", json_boolean(o->validate));
    json_object_set_new(json, "no_cache", json_boolean(o->no_cache));
    json_object_set_new(json, "quiet", json_boolean(o->quiet));
    json_object_set_new(json, "verbose", json_boolean(o->verbose));
}

json_t *report_settings(const struct render_options *o) {
    json_t *json = make_picture(o);
    add_eyes(json, o);
    add_scene(json, o);
    json_object_set_new(json, "options", options_json(&o->frame));
    json_object_set_new(json, "supersample", json_integer(o->supersample ? o->supersample : 1));
    add_run(json, o);
    return json;
}
