/* SPDX-License-Identifier: MIT */
#include "scene/scene_environment.h"

#include "scene/scene.h"

enum { MOST_WIDTH = 4096 };

fnl_environment_params fnl_environment_params_default(void) {
    return (fnl_environment_params){.intensity = 1, .background = true, .lights = true};
}

static inline float bounded(float value) { return value > 0 ? (value < 65504 ? value : 65504) : 0; /* NaN: 0 */ }

static float decoded(const fnl_image *image, size_t index) {
    if (image->format == FNL_PIXEL_FORMAT_RGBA8) return decode_srgb((float)((const uint8_t *)image->pixels)[index] / 255);
    return decode_srgb((float)((const uint16_t *)image->pixels)[index] / 65535);
}

static fnl_result panorama_take(const fnl_host *host, const char *name, const fnl_image *image, struct panorama *out) {
    if (image->width != 2 * image->height) {
        log_error(host, "%s: an environment is twice as wide as high (longitude by latitude); this picture has %ux%u pixels", name, image->width,
                  image->height);
        return FNL_ERROR_UNSUPPORTED;
    }
    const size_t count = (size_t)image->width * image->height;
    float *texels = host_allocate(host, count * 3 * sizeof(float));
    if (!texels) return FNL_ERROR_MEMORY;
    if (image->format == FNL_PIXEL_FORMAT_RGBA32F)
        for (size_t i = 0; i < count; i++)
            for (size_t c = 0; c < 3; c++) texels[3 * i + c] = bounded(((const float *)image->pixels)[4 * i + c]);
    else
        for (size_t i = 0; i < count; i++)
            for (size_t c = 0; c < 3; c++) texels[3 * i + c] = decoded(image, 4 * i + c);
    *out = (struct panorama){image->width, image->height, texels};
    return FNL_OK;
}

static fnl_result read_panorama(const fnl_host *host, const fnl_environment_params *params, struct panorama *out) {
    if (!params->source) return panorama_take(host, "the environment's image", params->image, out);
    if (strncmp(params->source, "builtin:", 8) == 0) return panorama_make(host, params->source + 8, out);
    fnl_image image;
    TRY(fnl_image_load(host, params->source, &image));
    const fnl_result result = panorama_take(host, params->source, &image, out);
    fnl_image_free(host, &image);
    return result;
}

/* ---- its lights ---- */

static void remove_lights(fnl_scene *scene) {
    struct scene_environment *e = &scene->environment;
    for (uint32_t i = 0; i < e->source_count; i++) {
        const fnl_light_id id = e->lights[i];
        const struct scene_light *light = id.index < scene->lights.count ? &scene->lights.data[id.index] : NULL;
        if (light && !light->removed && light->generation == id.generation) (void)fnl_scene_remove_light(scene, id); /* unless the caller has */
    }
}

static vec3 turned(vec3 d, float angle) { return vec3_make(cosf(angle) * d.x + sinf(angle) * d.z, d.y, cosf(angle) * d.z - sinf(angle) * d.x); }

static fnl_light_params light_of(const struct panorama_source *source, const struct scene_environment *e) {
    fnl_light_params light = fnl_light_params_default();
    const float strength = fmaxf(source->illuminance.x, fmaxf(source->illuminance.y, source->illuminance.z));
    light.kind = FNL_LIGHT_DIRECTIONAL;
    light.direction = vec3_scale(turned(source->direction, e->rotation), -1);
    const vec3 color = vec3_scale(source->illuminance, 1 / strength);
    memcpy(light.color, &color, sizeof color);
    light.intensity = strength * e->intensity;
    light.source_radius = source->half_angle;
    return light;
}

static void add_lights(fnl_scene *scene) {
    struct scene_environment *e = &scene->environment;
    for (uint32_t i = 0; i < e->source_count; i++) {
        const fnl_light_params params = light_of(&e->sources[i], e);
        e->lights[i] = (fnl_light_id){SCENE_NONE, 0};
        (void)fnl_scene_add_light(scene, &params, &e->lights[i]); /* there is room */
    }
}

/* ---- the call ---- */

void scene_environment_finish(fnl_scene *scene) {
    struct scene_environment *e = &scene->environment;
    panorama_finish(&scene->host, &e->panorama);
    if (e->name) host_free(&scene->host, e->name, strlen(e->name) + 1);
    e->name = NULL;
}

static fnl_result check(const struct call *call, const fnl_environment_params *params) {
    if (!params->source == !params->image) return misuse(call, "source and image are both %s, must be one of them", params->source ? "given" : "NULL");
    TRY(check_range(call, "rotation", (double)params->rotation, -(double)FLT_MAX, (double)FLT_MAX, " radians"));
    TRY(check_range(call, "intensity", (double)params->intensity, 0, 1e6, ""));
    if (!params->image) return FNL_OK;
    if (!params->image->pixels || fnl_pixel_size(params->image->format) == 0) return misuse(call, "image has no pixels");
    return FNL_OK;
}

static bool same_picture(const struct scene_environment *e, const fnl_environment_params *params) {
    return e->panorama.width > 0 && e->name && params->source && strcmp(e->name, params->source) == 0 && e->parted == params->lights;
}

/* A new picture in place of the old one. */
static fnl_result replace(fnl_scene *scene, const fnl_environment_params *params) {
    const fnl_host *host = &scene->host;
    struct scene_environment made = {.version = scene->environment.version + 1, .parted = params->lights};
    fnl_result result = read_panorama(host, params, &made.panorama);
    if (result == FNL_OK && params->lights) result = panorama_part(host, &made.panorama, made.sources, &made.source_count);
    if (result == FNL_OK) result = panorama_shrink(host, &made.panorama, MOST_WIDTH);
    if (result == FNL_OK) result = scene_reserve_lights(scene, made.source_count);
    if (result == FNL_OK && params->source) {
        const size_t size = strlen(params->source) + 1;
        made.name = host_allocate(host, size);
        if (made.name) memcpy(made.name, params->source, size);
        else result = FNL_ERROR_MEMORY;
    }
    if (result != FNL_OK) {
        panorama_finish(host, &made.panorama);
        return result;
    }
    remove_lights(scene);
    scene_environment_finish(scene);
    scene->environment = made;
    return FNL_OK;
}

fnl_result fnl_scene_set_environment(fnl_scene *scene, const fnl_environment_params *params) {
    TRY(check_handle(__func__, "scene", scene));
    struct scene_environment *e = &scene->environment;
    if (!params) {
        remove_lights(scene);
        scene_environment_finish(scene);
        *e = (struct scene_environment){.version = e->version + 1};
        scene->light_version++;
        return FNL_OK;
    }
    TRY(check(CALL(&scene->host), params));
    if (same_picture(e, params)) {
        TRY(scene_reserve_lights(scene, e->source_count));
        remove_lights(scene);
    } else {
        TRY(replace(scene, params));
    }
    e->rotation = params->rotation;
    e->intensity = params->intensity;
    e->background = params->background;
    if (e->compressed != params->compressed) e->version++; /* made anew */
    e->compressed = params->compressed;
    scene->light_version++;
    add_lights(scene);
    return FNL_OK;
}

fnl_result fnl_scene_query_environment(const fnl_scene *scene, fnl_environment_params *out) {
    TRY(check_handle(__func__, "scene", scene));
    TRY(check_pointer(CALL(&scene->host), "out", out));
    const struct scene_environment *e = &scene->environment;
    *out = fnl_environment_params_default();
    if (e->panorama.width == 0) return misuse(CALL(&scene->host), "the scene has no environment");
    *out = (fnl_environment_params){.source = e->name, .rotation = e->rotation, .intensity = e->intensity, .background = e->background, .lights = e->parted, .compressed = e->compressed};
    return FNL_OK;
}
