/* SPDX-License-Identifier: MIT */
#include "scene/scene_environment.h"

#include "image/image.h"
#include "scene/light_kinds.h"
#include "scene/query.h"
#include "scene/scene.h"

enum { MOST_WIDTH = 4096, TEXEL_BYTES = 3 * sizeof(float) };

fnl_environment_params fnl_environment_params_default(void) {
    return (fnl_environment_params){.intensity = 1, .background = true, .lights = true, .max_memory = host_memory_limit()};
}

/* Finite, and so that sums over all texels are. */
static inline float bounded(float value) { return value > 0 ? (value < 1e20f ? value : 1e20f) : 0; /* NaN: 0 */ }

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
    float *texels = host_allocate(host, count * TEXEL_BYTES);
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

static fnl_result load_panorama(const fnl_host *host, const fnl_environment_params *params, struct panorama *out) {
    if (!params->source) return panorama_take(host, "the environment's image", params->image, out);
    fnl_image image;
    TRY(image_load(host, params->source, params->max_memory, TEXEL_BYTES, &image));
    const fnl_result result = panorama_take(host, params->source, &image, out);
    fnl_image_free(host, &image);
    return result;
}

/* The picture and, where they are wanted, the bright sources that go from it: with their whole light. */
static fnl_result read_panorama(const fnl_host *host, const fnl_environment_params *params, struct scene_environment *out) {
    if (params->source && strncmp(params->source, "builtin:", 8) == 0) {
        TRY(panorama_make(host, params->source + 8, params->lights, &out->panorama, out->sources, &out->source_count));
    } else {
        TRY(load_panorama(host, params, &out->panorama));
        if (params->lights) TRY(panorama_part(host, &out->panorama, out->sources, &out->source_count));
    }
    TRY(panorama_shrink(host, &out->panorama, MOST_WIDTH));
    out->unit = panorama_unit(&out->panorama);
    return FNL_OK;
}

/* ---- beside the scene's lights ---- */

static bool is_of_environment(const struct scene_environment *e, const fnl_scene *scene, uint32_t light) {
    for (uint32_t i = 0; i < e->source_count; i++)
        if (e->lights[i].index == light && e->lights[i].generation == scene->lights.data[light].generation) return true;
    return false;
}

static float luminance(vec3 color) { return 0.2126f * color.x + 0.7152f * color.y + 0.0722f * color.z; }

static float strength_of(const fnl_light_params *light) {
    return light->intensity * luminance(vec3_make(light->color[0], light->color[1], light->color[2]));
}

/* The scene's brightest directional light, or NULL. */
static const fnl_light_params *find_sun(const fnl_scene *scene) {
    const fnl_light_params *out = NULL;
    for (uint32_t i = 0; i < scene->suns.count; i++) {
        const uint32_t light = scene->suns.data[i];
        const fnl_light_params *params = &scene->lights.data[light].params;
        if (params->kind != FNL_LIGHT_DIRECTIONAL || is_of_environment(&scene->environment, scene, light)) continue;
        if (!out || strength_of(params) > strength_of(out)) out = params;
    }
    return out;
}

static bool has_key(const char *text, const char *key) {
    const size_t length = strlen(key);
    for (const char *at = strpbrk(text, "?&"); at; at = strpbrk(at + 1, "?&"))
        if (strncmp(at + 1, key, length) == 0 && at[1 + length] == '=') return true;
    return false;
}

/* "builtin:sky" beside a sun of the scene: without a sun of its own, bright where that one is. The result is `source`, or text in `buffer`. */
static const char *beside_sun(const fnl_scene *scene, const fnl_environment_params *params, size_t size, char *buffer) {
    const char *source = params->source, *name = source ? source + 8 : "";
    if (!source || strncmp(source, "builtin:sky", 11) != 0 || query_name_length(name) != 3 || has_key(name, "sun") || strlen(source) + 64 > size) return source;
    const fnl_light_params *sun = find_sun(scene);
    if (!sun) return source;
    const bool placed = has_key(name, "elevation") || has_key(name, "azimuth");
    size_t used = (size_t)snprintf(buffer, size, "%s%csun=0", source, strchr(name, '?') ? '&' : '?');
    if (placed) return buffer;
    /* In hundredths of degrees, so that no locale has a say. Turned back by the environment's rotation. */
    const float degrees = 180 / PI, elevation = asinf(CLAMP(-sun->direction.y, -1.0f, 1.0f)) * degrees;
    const float azimuth = remainderf((atan2f(-sun->direction.z, -sun->direction.x) + params->rotation) * degrees, 360);
    const int up = (int)lrintf(100 * fmaxf(elevation, -6)), turn = (int)lrintf(100 * azimuth);
    used += (size_t)snprintf(buffer + used, size - used, "&elevation=%s%d.%02d", up < 0 ? "-" : "", abs(up) / 100, abs(up) % 100);
    snprintf(buffer + used, size - used, "&azimuth=%s%d.%02d", turn < 0 ? "-" : "", abs(turn) / 100, abs(turn) % 100);
    return buffer;
}

/* Lux that the scene's lights give on average to surfaces that face anywhere: directional ones a quarter of theirs, and so do others from afar; near ones
   spread their light over the scene's box. */
static double light_of_scene(const fnl_scene *scene, const struct box *bounds) {
    const vec3 size = vec3_max(vec3_sub(bounds->high, bounds->low), vec3_make(0, 0, 0));
    const double area = 2 * (double)(size.x * size.y + size.y * size.z + size.z * size.x);
    const vec3 center = vec3_scale(vec3_add(bounds->low, bounds->high), 0.5f);
    double sum = 0;
    for (uint32_t i = 0; i < scene->lights.count; i++) {
        const struct scene_light *light = &scene->lights.data[i];
        if (light->removed || is_of_environment(&scene->environment, scene, i)) continue;
        const double strength = (double)strength_of(&light->params);
        if (light_kinds[light->params.kind].info.parallel) {
            sum += strength / 4;
        } else if (area > 0) {
            const double angle = light->params.kind == FNL_LIGHT_SPOT ? 2 * (double)PI * (1 - cos((double)light->params.outer_cone_angle)) : 4 * (double)PI;
            const double away = (double)vec3_distance(light->params.position, center);
            sum += fmin(strength * angle / area, strength / (4 * away * away));
        }
    }
    return sum;
}

/* The mean luminance of all directions, sources too, as the picture has it. */
static double mean_of(const struct scene_environment *e) {
    double sum = panorama_flux(&e->panorama);
    for (uint32_t i = 0; i < e->source_count; i++) sum += (double)luminance(e->sources[i].illuminance);
    return sum / (4 * (double)PI);
}

/* What the intensity must be for the environment to give as much as the scene's lights; 1 without any. */
static double matching_intensity(const fnl_scene *scene, const struct box *bounds) {
    const double lights = light_of_scene(scene, bounds), own = mean_of(&scene->environment) * (double)PI * (double)scene->environment.own.intensity;
    return lights > 0 && own > 0 ? lights / own : 1;
}

/* Pictures are often in relative values, whose mean is about 1: beside lamps and suns they are black. */
static void warn_of_relative(const fnl_scene *scene, const char *source) {
    if (source && strncmp(source, "builtin:", 8) == 0 && strcmp(source, "builtin:studio") != 0) return;
    const struct box bounds = scene_bounds(scene);
    const double mean = mean_of(&scene->environment), wanted = matching_intensity(scene, &bounds);
    if (mean > 20 || wanted < 30 || scene->environment.intensity != 1) return;
    log_warning(&scene->host, "%s: its values look relative (mean %.2g, not cd/m^2), and the scene's lights give %.0f times as much: an intensity of %.0f, or auto, makes both alike",
                source ? source : "the environment's image", mean, wanted, wanted);
}

/* ---- its lights ---- */

static void remove_lights(fnl_scene *scene) {
    struct scene_environment *e = &scene->environment;
    for (uint32_t i = 0; i < e->source_count; i++) {
        const fnl_light_id id = e->lights[i];
        const struct scene_light *light = id.index < scene->lights.count ? &scene->lights.data[id.index] : NULL;
        if (!light || light->generation != id.generation) continue;
        if (light->staged && array_reserve(&scene->host, &scene->free_lights, scene->lights.count)) scene_remove_light(scene, id.index);
        else if (!light->staged && !light->removed) (void)fnl_scene_remove_light(scene, id); /* unless the caller has */
    }
}

void scene_environment_axes(const struct scene_environment *e, vec3 out[3]) {
    const float c = cosf(e->rotation), s = sinf(e->rotation);
    const quat q = e->own.rotation;
    const vec3 back[3] = {{c, 0, -s}, {0, 1, 0}, {s, 0, c}};
    memcpy(out, back, sizeof back);
    if (q.x == 0 && q.y == 0 && q.z == 0) return;
    const mat4 own = mat4_from_trs(vec3_make(0, 0, 0), quat_normalize(q), vec3_make(1, 1, 1)); /* its columns are the rows of what undoes it */
    for (int i = 0; i < 3; i++)
        out[i] = vec3_add(vec3_add(vec3_scale(back[0], own.m[4 * i]), vec3_scale(back[1], own.m[4 * i + 1])), vec3_scale(back[2], own.m[4 * i + 2]));
}

float scene_environment_scale(const struct scene_environment *e) { return e->intensity * e->own.intensity; }

static fnl_light_params light_of(const struct panorama_source *source, const struct scene_environment *e) {
    fnl_light_params light = fnl_light_params_default();
    const vec3 d = source->direction;
    vec3 rows[3];
    scene_environment_axes(e, rows);
    const float strength = fmaxf(source->illuminance.x, fmaxf(source->illuminance.y, source->illuminance.z));
    light.kind = FNL_LIGHT_DIRECTIONAL;
    light.direction = vec3_scale(vec3_add(vec3_add(vec3_scale(rows[0], d.x), vec3_scale(rows[1], d.y)), vec3_scale(rows[2], d.z)), -1);
    const vec3 color = vec3_scale(source->illuminance, 1 / strength);
    memcpy(light.color, &color, sizeof color);
    light.intensity = strength * scene_environment_scale(e);
    light.source_angle = source->half_angle;
    return light;
}

static void add_lights(fnl_scene *scene) {
    struct scene_environment *e = &scene->environment;
    for (uint32_t i = 0; i < e->source_count; i++) {
        const fnl_light_params params = light_of(&e->sources[i], e);
        e->lights[i] = (fnl_light_id){SCENE_NONE, 0};
        (void)fnl_scene_add_light(scene, &params, &e->lights[i]); /* there is room */
        if (e->staged && e->lights[i].index != SCENE_NONE) scene->lights.data[e->lights[i].index].staged = scene->lights.data[e->lights[i].index].removed = true;
    }
}

void scene_environment_moved(fnl_scene *scene) {
    struct scene_environment *e = &scene->environment;
    e->animated = false;
    for (uint32_t i = 0; i < e->source_count; i++) {
        const fnl_light_id id = e->lights[i];
        if (id.index >= scene->lights.count || scene->lights.data[id.index].removed || scene->lights.data[id.index].generation != id.generation) continue;
        const fnl_light_params params = light_of(&e->sources[i], e);
        (void)fnl_scene_set_light(scene, id, &params);
    }
}

/* ---- the call ---- */

void scene_environment_finish(fnl_scene *scene) {
    struct scene_environment *e = &scene->environment;
    panorama_finish(&scene->host, &e->panorama);
    if (e->name) host_free(&scene->host, e->name, strlen(e->name) + 1);
    e->name = NULL;
}

static fnl_result check(const struct call *call, const fnl_scene *scene, const fnl_environment_params *params) {
    if (params->source && params->image) return misuse(call, "source and image are both given, must be one of them");
    if (!params->source && !params->image && (scene->environment.panorama.width == 0 || scene->environment.staged))
        return misuse(call, "source and image are both NULL, must be one of them: the scene has no environment to keep");
    TRY(check_range(call, "rotation", (double)params->rotation, -(double)FLT_MAX, (double)FLT_MAX, " radians"));
    TRY(check_range(call, "intensity", (double)params->intensity, 0, 1e6, ""));
    if (!params->image) return FNL_OK;
    if (!params->image->pixels || fnl_pixel_size(params->image->format) == 0) return misuse(call, "image has no pixels");
    return FNL_OK;
}

static bool same_picture(const struct scene_environment *e, const fnl_environment_params *params) {
    if (e->panorama.width == 0 || e->staged) return false;
    if (!params->source && !params->image) return true;
    return e->name && params->source && strcmp(e->name, params->source) == 0 && e->parted == params->lights;
}

/* A new picture in place of the old one. */
static fnl_result replace(fnl_scene *scene, const fnl_environment_params *params) {
    const fnl_host *host = &scene->host;
    struct scene_environment made = {.version = scene->environment.version + 1, .parted = params->lights, .own = {quat_identity(), 1, SCENE_NONE}};
    fnl_result result = read_panorama(host, params, &made);
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

static fnl_result set(fnl_scene *scene, const fnl_environment_params *params, const struct scene_environment_own *own) {
    struct scene_environment *e = &scene->environment;
    if (same_picture(e, params)) {
        TRY(scene_reserve_lights(scene, e->source_count));
        remove_lights(scene);
    } else {
        TRY(replace(scene, params));
    }
    if (own) e->own = *own;
    e->rotation = params->rotation;
    e->intensity = params->intensity;
    e->background = params->background;
    if (e->compressed != params->compressed) e->version++; /* made anew */
    e->compressed = params->compressed;
    e->max_memory = params->max_memory;
    scene->light_version++;
    add_lights(scene);
    return FNL_OK;
}

static void remove_environment(fnl_scene *scene) {
    struct scene_environment *e = &scene->environment;
    remove_lights(scene);
    scene_environment_finish(scene);
    *e = (struct scene_environment){.version = e->version + 1, .own = {quat_identity(), 1, SCENE_NONE}};
    scene->light_version++;
}

fnl_result scene_environment_stage(fnl_scene *scene, enum stage_light light) {
    fnl_environment_params params = fnl_environment_params_default();
    params.source = "builtin:studio";
    if (light == STAGE_NO_LIGHT) {
        remove_environment(scene);
        return FNL_OK;
    }
    TRY(replace(scene, &params));
    struct scene_environment *e = &scene->environment;
    e->intensity = 1;
    if (light == STAGE_FILL) e->source_count = 0; /* the scene's own lights are the key */
    e->staged = true; /* and no background: it is not meant to be seen sharp */
    scene->light_version++;
    add_lights(scene);
    return FNL_OK;
}

void scene_environment_fill(fnl_scene *scene, const struct box *bounds) {
    scene->environment.intensity = fminf((float)matching_intensity(scene, bounds), 1e6f);
    scene->light_version++;
}

fnl_result scene_set_own_environment(fnl_scene *scene, const fnl_environment_params *params, const struct scene_environment_own *own) {
    return set(scene, params, own);
}

fnl_result fnl_scene_set_environment(fnl_scene *scene, const fnl_environment_params *params) {
    TRY(check_handle(__func__, "scene", scene));
    if (!params) {
        if (!scene->environment.staged) remove_environment(scene);
        return FNL_OK;
    }
    TRY(check(CALL(&scene->host), scene, params));
    fnl_environment_params wanted = *params;
    char source[512];
    wanted.source = beside_sun(scene, params, sizeof source, source);
    struct scene_environment *e = &scene->environment;
    const uint64_t before = e->version;
    TRY(set(scene, &wanted, NULL));
    if (params->intensity_auto) {
        const struct box bounds = scene_bounds(scene);
        e->intensity = fminf(params->intensity * (float)matching_intensity(scene, &bounds), 1e6f);
        scene_environment_moved(scene);
    } else if (e->version != before) {
        warn_of_relative(scene, params->source);
    }
    return FNL_OK;
}

fnl_result fnl_scene_query_environment(const fnl_scene *scene, fnl_environment_params *out) {
    TRY(check_handle(__func__, "scene", scene));
    TRY(check_pointer(CALL(&scene->host), "out", out));
    const struct scene_environment *e = &scene->environment;
    *out = fnl_environment_params_default();
    if (e->panorama.width == 0 || e->staged) return misuse(CALL(&scene->host), "the scene has no environment");
    *out = (fnl_environment_params){.source = e->name, .rotation = e->rotation, .intensity = e->intensity, .background = e->background, .lights = e->parted, .compressed = e->compressed, .max_memory = e->max_memory};
    return FNL_OK;
}
