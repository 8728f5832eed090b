/* SPDX-License-Identifier: MIT */
#include "world.h"

#include "arguments.h"
#include "origin.h"
#include "print.h"
#include "progress.h"
#include "views.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct world_options world_options_default(void) {
    return (struct world_options){.lights = -1, .scatter = fnl_scatter_params_default(), .loading = fnl_load_params_default(), .environment_params = fnl_environment_params_default()};
}

bool world_has(int option) { return loading_has(option) || (option >= WORLD_CAMERA && option < WORLD_END); }

static bool parse_probe(const char *value, struct world_options *o) {
    fnl_probe_params p = fnl_probe_params_default();
    const char *at = value;
    float half[3];
    double *centre = o->probe_centres[o->probe_count];
    if (strcmp(value, "auto") == 0) return o->probe_auto = true;
    if (o->probe_count == WORLD_PROBES) return argument_bad("probe", value, "given 32 times at most");
    bool good = argument_take_place(&at, centre) && *at == ',';
    good = good && (++at, argument_take_numbers(&at, half, 3));
    if (good && *at == ',') good = (++at, argument_take_numbers(&at, &p.softness, 1));
    if (!good || *at) return argument_bad("probe", value, "auto, or six or seven numbers such as 0,1.5,0,3,1.5,4,0.5");
    p.half_size = (fnl_vec3){half[0], half[1], half[2]};
    o->probes[o->probe_count++] = p;
    return true;
}

static const char *ground_name(int value) { return fnl_value_name(FNL_ENUM_GROUND, (uint32_t)value); }
static const char *switch_name(int value) { return value == 0 ? "off" : value == 1 ? "on" : NULL; }

static bool parse_background(const char *value, struct world_options *o) {
    double degrees;
    o->backdrop = FNL_BACKGROUND_SCENE;
    if (strcmp(value, "scene") == 0) return true;
    if (strcmp(value, "gradient") == 0) {
        o->backdrop = FNL_BACKGROUND_GRADIENT;
        return true;
    }
    if (strncmp(value, "blur:", 5) == 0) {
        if (!argument_number("background", value + 5, &degrees)) return false;
        if (!(degrees >= 0 && degrees <= 180)) return argument_bad("background", value, "blur: with an angle from 0 to 180 degrees");
        o->backdrop = FNL_BACKGROUND_BLUR;
        o->blur = (float)(degrees * 3.14159265358979323846 / 180);
        return true;
    }
    if (*value >= 'a' && *value <= 'z') return argument_bad("background", value, "scene, gradient, blur:DEGREES or R,G,B");
    o->has_background = true;
    return argument_vector("background", value, &o->background);
}

bool world_parse(int option, const char *value, struct world_options *o) {
    long long integer;
    double number;
    int index;
    if (loading_has(option)) return loading_parse(option, value, &o->loading);
    switch (option) {
    case WORLD_CAMERA:
        o->camera = value;
        return true;
    case WORLD_EYE:
        o->has_eye = true;
        return argument_place("eye", value, o->eye);
    case WORLD_LOOK_AT:
        o->has_look_at = true;
        return argument_place("look-at", value, o->look_at);
    case WORLD_FOV:
        if (!argument_number("fov", value, &number)) return false;
        if (!(number > 0 && number < 180)) return argument_bad("fov", value, "an angle between 0 and 180 degrees");
        o->fov = (float)(number * 3.14159265358979323846 / 180);
        return true;
    case WORLD_NEAR:
        if (!argument_number("near", value, &number)) return false;
        if (!(number > 0 && number <= 1e6)) return argument_bad("near", value, "a distance above 0 and up to 1e6 metres");
        o->near = (float)number;
        return true;
    case WORLD_UP:
        if (!argument_vector("up", value, &o->up)) return false;
        return o->up.x != 0 || o->up.y != 0 || o->up.z != 0 || argument_bad("up", value, "a direction");
    case WORLD_GROW_METAL:
        if (!argument_integer("grow-metal", value, 0, 64, &integer)) return false;
        o->grow_metal = (uint32_t)integer;
        return true;
    case WORLD_LIGHTS:
        if (!argument_integer("lights", value, 0, 1 << 24, &integer)) return false;
        o->lights = integer;
        return true;
    case WORLD_LIGHT_SEED:
        if (!argument_integer("light-seed", value, 0, INT64_MAX, &integer)) return false;
        o->scatter.seed = (uint64_t)integer;
        o->scatters = true;
        return true;
    case WORLD_PROBE:
        return parse_probe(value, o);
    case WORLD_PROBE_REFLECTIONS:
        return o->probe_reflections = true;
    case WORLD_LIGHT_SHAPES:
        o->scatters = true;
        return argument_light_shapes("light-shapes", value, &o->scatter);
    case WORLD_LIGHT_SCALE:
        if (!argument_number("light-scale", value, &number)) return false;
        if (!(number > 0 && number <= 1e6)) return argument_bad("light-scale", value, "a factor above 0");
        o->scatter.radius_scale = (float)number;
        o->scatters = true;
        return true;
    case WORLD_IES:
        o->ies = value;
        return true;
    case WORLD_RANGE_ROUGHNESS:
        if (!argument_number("range-roughness", value, &number)) return false;
        if (!(number >= 0 && number <= 1)) return argument_bad("range-roughness", value, "a number from 0 to 1");
        o->has_range_roughness = true;
        o->range_roughness = (float)number;
        return true;
    case WORLD_ANISOTROPY:
        if (!argument_number("anisotropy", value, &number)) return false;
        if (!(number >= 1 && number <= 16)) return argument_bad("anisotropy", value, "a number from 1 to 16");
        o->has_anisotropy = true;
        o->anisotropy = (float)number;
        return true;
    case WORLD_BACKGROUND:
        return parse_background(value, o);
    case WORLD_GROUND:
        if (!argument_name("ground", value, ground_name, &index)) return false;
        o->has_ground = true;
        o->ground = (fnl_ground)index;
        return true;
    case WORLD_STUDIO:
        if (!argument_name("studio", value, switch_name, &index)) return false;
        o->has_studio = true;
        o->no_studio = index == 0;
        return true;
    case WORLD_AMBIENT:
        o->has_ambient = true;
        return argument_vector("ambient", value, &o->ambient);
    case WORLD_ENVIRONMENT:
        o->environment = value;
        return true;
    case WORLD_ENVIRONMENT_ROTATION:
        if (!argument_number("environment-rotation", value, &number)) return false;
        o->environment_params.rotation = (float)(number * 3.14159265358979323846 / 180);
        return true;
    case WORLD_ENVIRONMENT_INTENSITY:
        o->environment_params.intensity_auto = strcmp(value, "auto") == 0;
        if (o->environment_params.intensity_auto) return true;
        if (!argument_number("environment-intensity", value, &number)) return false;
        if (!(number >= 0 && number <= 1e6)) return argument_bad("environment-intensity", value, "a factor from 0 to 1e6, or auto");
        o->environment_params.intensity = (float)number;
        return true;
    case WORLD_ENVIRONMENT_HIDDEN:
        o->environment_params.background = false;
        return true;
    case WORLD_ENVIRONMENT_COMPRESSED:
        o->environment_params.compressed = true;
        return true;
    case WORLD_TIME:
        return argument_number("time", value, &o->time);
    case WORLD_ANIMATION:
        o->animation = value;
        return true;
    case WORLD_VARIANT:
        o->variant = value;
        return true;
    default:
        return false;
    }
}

const char *world_problem(const struct world_options *o) {
    if (o->has_eye != o->has_look_at) return "--eye and --look-at belong together";
    if (o->camera && o->has_eye) return "--camera and --eye cannot be combined";
    return NULL;
}

static bool find_animation(const fnl_scene *scene, uint32_t count, const char *name, uint32_t *out) {
    const char *at = name;
    uint64_t index;
    if (argument_take_count(&at, &index) && !*at && index < count) {
        *out = (uint32_t)index;
        return true;
    }
    for (uint32_t i = 0; i < count; i++) {
        fnl_animation_info animation;
        if (fnl_scene_query_animation(scene, i, &animation) == FNL_OK && animation.name && strcmp(animation.name, name) == 0) {
            *out = i;
            return true;
        }
    }
    return false;
}

/* "NAME|INDEX:WEIGHT" with commas between. */
static bool find_animations(const fnl_scene *scene, uint32_t animation_count, const char *text, double time, fnl_animation_time out[WORLD_ANIMATIONS], uint32_t *count) {
    char *copy = strdup(text), *rest = copy;
    bool good = copy != NULL;
    *count = 0;
    for (char *part; good && (part = strsep(&rest, ","));) {
        char *colon = strrchr(part, ':');
        const char *at = colon ? colon + 1 : "";
        fnl_animation_time *t = &out[*count];
        if (colon) *colon = 0;
        t->seconds = time;
        good = *count < WORLD_ANIMATIONS && argument_take_numbers(&at, &t->weight, 1) && !*at && t->weight >= 0 && t->weight <= 1e6f && find_animation(scene, animation_count, part, &t->animation);
        ++*count;
    }
    float sum = 0;
    for (uint32_t i = 0; i < *count && good; i++) sum += out[i].weight;
    free(copy);
    return good && sum > 0;
}

bool world_set_time(const struct world_options *o, fnl_scene *scene, double time) {
    fnl_animation_time times[WORLD_ANIMATIONS + 1] = {{0, time, 1}};
    fnl_scene_info info;
    uint32_t count = 1;
    if (fnl_scene_query_info(scene, &info) != FNL_OK) return false;
    if (o->animation && !find_animation(scene, info.animation_count, o->animation, &times[0].animation) &&
        !find_animations(scene, info.animation_count, o->animation, time, times, &count)) {
        fprintf(stderr, "fanal: error: --animation: the scene has no animation '%s' (it has %u), nor is it a list as 0:0.3,1:0.7\n", o->animation, info.animation_count);
        return false;
    }
    return fnl_scene_set_times(scene, times, count) == FNL_OK;
}

static bool find_camera(const struct world_options *o, const fnl_scene *scene, float aspect, fnl_camera *out) {
    if (o->has_eye) {
        *out = fnl_camera_default();
        out->position = origin_position(scene, o->eye);
        out->target = origin_position(scene, o->look_at);
    } else if (o->camera) {
        if (!views_find_camera(scene, "--camera", o->camera, out)) return false;
    } else if (fnl_scene_count(scene, FNL_ENTITY_CAMERA) > 0) {
        if (fnl_scene_query_camera(scene, 0, out) != FNL_OK) return false;
    } else if (fnl_scene_query_framing_camera(scene, aspect, out) != FNL_OK) {
        return false;
    }
    if (o->fov > 0) out->vertical_fov = o->fov;
    if (o->near > 0) out->near_distance = o->near;
    if (o->up.x != 0 || o->up.y != 0 || o->up.z != 0) out->up = o->up;
    return true;
}

/* Moves the origin to the camera, then finds the camera again, without the rounding error of distant floats. */
static bool choose_camera(const struct world_options *o, fnl_scene *scene, float aspect, fnl_camera *out) {
    double place[3];
    if (!find_camera(o, scene, aspect, out)) return false;
    origin_place(scene, out->position, place);
    return origin_follow(scene, o->has_eye ? o->eye : place) && find_camera(o, scene, aspect, out);
}

static bool show_loading(void *user, uint32_t done, uint32_t total) {
    (void)user;
    progress_show("loading the scene", done, total);
    return true;
}

/* All lights that can have a profile get it, and keep their intensity in its brightest direction; points look down. */
static bool give_profile(fnl_scene *scene, const char *path) {
    fnl_light_profile_id profile;
    if (fnl_scene_add_light_profile(scene, path, NULL, 0, &profile, NULL) != FNL_OK) return false;
    for (uint32_t i = 0; i < fnl_scene_count(scene, FNL_ENTITY_LIGHT); i++) {
        fnl_entity_info entity;
        fnl_light_params light;
        if (fnl_scene_query_entity(scene, FNL_ENTITY_LIGHT, i, &entity) != FNL_OK || fnl_scene_query_light(scene, i, &light) != FNL_OK) return false;
        const fnl_light_kind_info *kind = fnl_light_kind_find(light.kind);
        if (!kind->has_profile) continue;
        if (!kind->has_direction && !light.profile.generation) {
            light.direction = (fnl_vec3){0, -1, 0};
            light.up = (fnl_vec3){0, 0, 1};
        }
        light.profile = profile;
        if (fnl_scene_set_light(scene, entity.id.light, &light) != FNL_OK) return false;
    }
    return true;
}

/* The scene's own become reflection probes where none is given. */
static bool add_probes(const struct world_options *o, fnl_scene *scene) {
    fnl_scene_info info;
    fnl_entity_info entity;
    fnl_probe_params params;
    fnl_probe_id id;
    if (fnl_scene_query_info(scene, &info) != FNL_OK) return false;
    for (uint32_t i = 0; i < info.probe_count && o->probe_reflections && o->probe_count == 0 && !o->probe_auto; i++) {
        if (fnl_scene_query_probe(scene, i, &params) != FNL_OK || fnl_scene_query_entity(scene, FNL_ENTITY_PROBE, i, &entity) != FNL_OK) return false;
        params.reflection = true;
        if (fnl_scene_set_probe(scene, entity.id.probe, &params) != FNL_OK) return false;
    }
    for (uint32_t i = 0; i < o->probe_count; i++) {
        params = o->probes[i];
        params.centre = origin_position(scene, o->probe_centres[i]);
        params.reflection = o->probe_reflections;
        if (fnl_scene_add_probe(scene, &params, &id) != FNL_OK) return false;
    }
    params = fnl_probe_params_default();
    params.reflection = o->probe_reflections;
    return !o->probe_auto || fnl_scene_place_probes(scene, &params, WORLD_PROBES_AUTO, NULL) == FNL_OK;
}

/* That of --environment; or what the options say of the file's own. */
static bool set_environment(const fnl_environment_params *params, fnl_scene *scene) {
    const fnl_environment_params usual = fnl_environment_params_default();
    const bool changes = params->rotation != usual.rotation || params->intensity != usual.intensity || params->background != usual.background ||
                         params->intensity_auto || params->compressed != usual.compressed;
    fnl_scene_info info;
    if (!params->source && (!changes || fnl_scene_query_info(scene, &info) != FNL_OK || !info.has_environment)) return true;
    return fnl_scene_set_environment(scene, params) == FNL_OK;
}

/* Whether frames show the studio. */
static bool is_dark(const fnl_scene *scene) {
    fnl_scene_info info;
    return fnl_scene_query_info(scene, &info) == FNL_OK && info.light_count == 0 && !info.has_environment && !info.has_ambient;
}

/* What the studio does for a scene. */
static void tell_studio(const fnl_scene *scene) {
    fnl_scene_info info;
    if (fnl_scene_query_info(scene, &info) != FNL_OK || info.has_environment || info.has_ambient) return;
    if (info.light_count == 0)
        puts("The scene has no light: using builtin:studio. To change this, use --environment, --lights, --ambient or --studio off.");
    else if (info.light_count <= FNL_STUDIO_FILL_LIGHTS)
        puts("The scene has no environment or ambient light: builtin:studio fills in the shadows. To change this, use --environment, --ambient or --studio off.");
}

/* Whether options of the environment are meant for the studio, which then becomes the scene's. */
static bool lights_studio(const struct world_options *o, const fnl_scene *scene) {
    const fnl_environment_params usual = fnl_environment_params_default(), *params = &o->environment_params;
    const bool changes = params->rotation != usual.rotation || params->intensity != usual.intensity || params->background != usual.background ||
                         params->compressed != usual.compressed;
    return changes && !o->no_studio && !o->has_ambient && is_dark(scene);
}

void world_set_frame(const struct world_options *o, fnl_frame *frame) {
    if (o->has_studio) frame->studio = !o->no_studio;
    if (o->has_ground) frame->ground = o->ground;
    if (o->backdrop != FNL_BACKGROUND_AUTO) frame->background = o->backdrop;
    if (o->backdrop == FNL_BACKGROUND_BLUR) frame->background_blur = o->blur;
}

void world_set_trace(const struct world_options *o, fnl_trace_params *params) {
    fnl_frame frame = fnl_frame_default();
    world_set_frame(o, &frame);
    params->studio = frame.studio;
    params->ground = frame.ground;
    params->background = frame.background;
    params->background_blur = frame.background_blur;
}

bool world_load(const struct world_options *o, const fnl_host *host, uint32_t width, uint32_t height, bool quiet, fnl_scene **scene,
                fnl_camera *camera) {
    fnl_load_params loading = o->loading;
    if (!loading.progress) loading.progress = show_loading;
    char source[2048];
    fnl_scatter_params scatter = o->scatter;
    scatter.count = loading_lights(o->scene, o->lights, o->scatters, source, sizeof source);
    if (fnl_scene_load(host, source, &loading, scene) != FNL_OK || !loading_select_variant(*scene, o->variant, NULL)) return false;
    if (!world_set_time(o, *scene, o->time)) return false;
    if (o->grow_metal && fnl_scene_grow_metal(*scene, o->grow_metal) != FNL_OK) return false;
    if (fnl_scene_scatter_light_shapes(*scene, &scatter) != FNL_OK) return false;
    if (o->has_range_roughness && fnl_scene_set_light_cutoff(*scene, o->range_roughness, 0.05f) != FNL_OK) return false;
    if (o->ies && !give_profile(*scene, o->ies)) return false;
    fnl_environment_params environment = o->environment_params;
    environment.source = o->environment;
    environment.max_memory = o->loading.max_memory;
    if (!environment.source && lights_studio(o, *scene)) environment.source = "builtin:studio"; /* turned, or as bright, as the options say */
    environment.background &= !o->has_background || o->environment;
    if (!set_environment(&environment, *scene)) return false;
    if (!add_probes(o, *scene)) return false;
    if (o->has_ambient && !o->environment && fnl_scene_set_environment(*scene, NULL) != FNL_OK) return false; /* ambient light takes its place */
    if (o->has_ambient && fnl_scene_set_ambient(*scene, o->ambient, o->ambient) != FNL_OK) return false;
    if (o->has_anisotropy && fnl_scene_set_anisotropy(*scene, o->anisotropy) != FNL_OK) return false;
    if (o->has_background && fnl_scene_set_background(*scene, o->background) != FNL_OK) return false;
    if (!quiet && !o->no_studio) tell_studio(*scene);
    return choose_camera(o, *scene, (float)width / (float)height, camera);
}

fnl_shadows world_usual_shadows(const fnl_scene_info *scene, const fnl_device_info *device, bool quiet) {
    enum { MOST_MAPS = 65536, MAPS_OF_SUN = 192 }; /* fanal/shadows.h */
    const uint32_t count = scene->light_count, suns = scene->light_kind_counts[FNL_LIGHT_DIRECTIONAL];
    if (device->clip_distances && count - suns + (uint64_t)MAPS_OF_SUN * suns <= MOST_MAPS) return FNL_SHADOWS_MAPS;
    if (!quiet && count > 0)
        fprintf(stderr, "fanal: warning: no shadows: %s; --shadows rays finds them all, slowly\n",
                device->clip_distances ? "the scene has more than the 65536 lights that may have shadow maps, of which a sun counts as 192"
                                       : "this device cannot draw shadow maps");
    return FNL_SHADOWS_OFF;
}
