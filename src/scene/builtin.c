/* SPDX-License-Identifier: MIT */
#include "scene/builtin.h"

#include "scene/query.h"

#define LIGHTS(count)                                                                                                       \
    { "lights", 0, BUILTIN_LIGHTS_MAX, count }
#define DECALS                                                                                                              \
    { "decals", 0, BUILTIN_DECALS_MAX, 0 }
#define SUN                                                                                                                 \
    { "sun", 0, 200000, 0 }
#define SEED                                                                                                                \
    { "seed", 0, UINT32_MAX, 1 }

/* Skies by dusk, 3 lux and more, let the lamps be seen. Indoors an environment stands for what comes in by windows and from walls. */
static const struct builtin_scene scenes[] = {
    {"city",
     {LIGHTS(4096),
      {"blocks", 1, 16, 4},
      SEED,
      {"instances", 0, BUILTIN_INSTANCES_MAX, 0},
      {"triangles", 0, BUILTIN_TRIANGLES_MAX, 0},
      DECALS,
      SUN},
     builtin_make_city,
     "builtin:sky?elevation=-6&azimuth=-90",
     1,
     1},
    {"hall", {LIGHTS(1024), SEED, DECALS, {"overdraw", 0, 1, 0}, SUN}, builtin_make_hall, NULL, 0, 0},
    {"interior", {LIGHTS(96), SEED, {"overlap", 1, 16, 1}, SUN}, builtin_make_interior, NULL, 0, 0},
    {"wall", {{"test", 1, 4, 1}, LIGHTS(BUILTIN_NOT_GIVEN), SEED}, builtin_make_wall, "builtin:sky?elevation=-4&azimuth=60", 1, 0},
    {"room",
     {LIGHTS(3), SEED, {"cave", 0, 100, 0}, {"moving", 0, 1, 0}, SUN},
     builtin_make_room,
     "builtin:sky?elevation=1&azimuth=170&sun=0",
     1,
     0.06f},
    {"spheres", {LIGHTS(64), SEED, {"segments", 4, 1024, 48}, SUN}, builtin_make_spheres, "builtin:studio", 12, 0.5f},
    {"pole", {LIGHTS(256), SEED}, builtin_make_pole, "builtin:sky?elevation=-5&azimuth=-60", 0.6f, 0},
    {"lamps", {LIGHTS(256), SEED}, builtin_make_lamps, "builtin:sky?elevation=-6&azimuth=-100", 0.5f, 0},
    {"grass", {LIGHTS(512), SEED, SUN}, builtin_make_grass, "builtin:sky?elevation=-6&azimuth=-70", 0.4f, 1},
    {"onetile", {LIGHTS(1000), SEED}, builtin_make_onetile, NULL, 0, 0},
    {"nearplane", {LIGHTS(256), SEED}, builtin_make_nearplane, "builtin:studio", 2, 0},
    {"sky", {LIGHTS(256), SEED}, builtin_make_sky, "builtin:sky?elevation=-6&azimuth=-60", 1, 0},
    {"glass", {LIGHTS(256), SEED, {"crossing", 0, 1, 0}}, builtin_make_glass, "builtin:studio", 1, 0},
};

const struct builtin_scene *builtin_scene_at(uint32_t index) { return index < COUNT_OF(scenes) ? &scenes[index] : NULL; }

/* ---- materials ---- */

uint32_t builtin_plain(struct builtin *b, const char *name, vec3 color, float metallic, float roughness) {
    struct scene_material material = scene_material_default();
    material.name = name;
    material.base_color = vec4_make(color.x, color.y, color.z, 1);
    material.metallic = metallic;
    material.roughness = roughness;
    uint32_t index = b->failed ? SCENE_NONE : scene_add_material(b->scene, &material);
    if (index == SCENE_NONE) b->failed = true;
    return b->failed ? 0 : index;
}

struct scene_material *builtin_material_at(struct builtin *b, uint32_t material) {
    return b->failed ? &b->scratch : &b->scene->materials.data[material];
}

uint32_t builtin_glow(struct builtin *b, const char *name, vec3 radiance) {
    uint32_t index = builtin_plain(b, name, vec3_make(0.02f, 0.02f, 0.02f), 0, 0.5f);
    builtin_material_at(b, index)->emissive = radiance;
    return index;
}

uint32_t builtin_globe(struct builtin *b, const char *name, vec3 radiance) {
    uint32_t index = builtin_glow(b, name, radiance);
    builtin_material_at(b, index)->casts_shadows = false;
    return index;
}

uint32_t builtin_glass(struct builtin *b, const char *name, vec3 tint, float alpha) {
    uint32_t index = builtin_plain(b, name, tint, 0, 0.06f);
    struct scene_material *material = builtin_material_at(b, index);
    material->base_color.w = alpha;
    material->alpha_mode = FNL_ALPHA_BLEND;
    material->double_sided = true;
    return index;
}

uint32_t builtin_material(struct builtin *b, const char *name, enum builtin_texture texture, vec3 tint) {
    const struct builtin_images *images = builtin_texture_images(b, texture);
    uint32_t index = builtin_plain(b, name, tint, images->surface == SCENE_NONE ? 0.0f : 1.0f, 1);
    struct scene_material *material = builtin_material_at(b, index);
    const uint32_t slots[][2] = {
        {SCENE_TEXTURE_BASE_COLOR, images->base_color}, {SCENE_TEXTURE_METALLIC_ROUGHNESS, images->surface},
        {SCENE_TEXTURE_OCCLUSION, images->surface},     {SCENE_TEXTURE_NORMAL, images->normal},
        {SCENE_TEXTURE_EMISSIVE, images->emissive},
    };
    for (uint32_t i = 0; i < COUNT_OF(slots); i++) {
        if (slots[i][1] == SCENE_NONE) continue;
        struct scene_texture *slot = &material->textures[slots[i][0]];
        *slot = scene_texture_none();
        slot->image = slots[i][1];
        slot->transform[0] = 1 / images->width;
        slot->transform[4] = 1 / images->height;
    }
    if (texture == TEXTURE_LEAVES || texture == TEXTURE_GRASS || texture == TEXTURE_MARKING) {
        material->alpha_mode = FNL_ALPHA_MASK;
        material->double_sided = texture != TEXTURE_MARKING;
    }
    return index;
}

/* ---- placing ---- */

void builtin_place(struct builtin *b, uint32_t mesh, mat4 transform) {
    const fnl_host *host = &b->scene->host;
    while (!b->failed && b->placements.count <= mesh)
        if (!array_push(host, &b->placements, (struct builtin_placement){0})) b->failed = true;
    if (b->failed) return;
    if (!array_push(host, &b->placements.data[mesh].transforms, transform)) b->failed = true;
    b->placed++;
    const struct scene_mesh *what = &b->scene->meshes.data[mesh];
    for (uint32_t i = 0; i < what->primitive_count; i++)
        b->placed_triangles += b->scene->primitives.data[what->first_primitive + i].index_count / 3;
}

mat4 builtin_at(float x, float y, float z, float yaw, float scale) {
    float c = cosf(yaw) * scale, s = sinf(yaw) * scale;
    return (mat4){{c, 0, -s, 0, 0, scale, 0, 0, s, 0, c, 0, x, y, z, 1}};
}

void builtin_flush(struct builtin *b) {
    fnl_scene *scene = b->scene;
    for (uint32_t i = 0; i < b->placements.count && !b->failed; i++) {
        struct builtin_placement *placement = &b->placements.data[i];
        uint32_t count = placement->transforms.count;
        if (!count) continue;
        mat4 local = count == 1 ? placement->transforms.data[0] : mat4_identity();
        uint32_t node = scene_add_node(scene, scene->meshes.data[i].name, SCENE_NONE, &local, i);
        const mat4 *copy = count == 1 ? NULL : arena_copy(&scene->arena, placement->transforms.data, sizeof(mat4) * count);
        if (node == SCENE_NONE || (count > 1 && !copy)) {
            b->failed = true;
            return;
        }
        scene->nodes.data[node].instances = copy;
        scene->nodes.data[node].instance_count = count;
    }
}

void builtin_light(struct builtin *b, const fnl_light_params *light) {
    if (!b->failed && scene_add_light(b->scene, light, SCENE_NONE) == SCENE_NONE) b->failed = true;
}

static fnl_light_params light_at(vec3 position, vec3 color, float intensity, float range) {
    fnl_light_params light = fnl_light_params_default();
    light.position = position;
    light.color[0] = color.x;
    light.color[1] = color.y;
    light.color[2] = color.z;
    light.intensity = intensity;
    light.range = range;
    return light;
}

void builtin_point(struct builtin *b, vec3 position, vec3 color, float intensity, float range) {
    fnl_light_params light = light_at(position, color, intensity, range);
    builtin_light(b, &light);
}

void builtin_spot(struct builtin *b, vec3 position, vec3 direction, vec3 color, float intensity, float range, float angle) {
    fnl_light_params light = light_at(position, color, intensity, range);
    light.kind = FNL_LIGHT_SPOT;
    light.direction = vec3_normalize(direction);
    light.outer_cone_angle = angle;
    light.inner_cone_angle = 0.6f * angle;
    builtin_light(b, &light);
}

void builtin_fill(struct builtin *b, uint64_t count, vec3 low, vec3 high, float overlap, float range) {
    if (!count) return;
    vec3 size = vec3_sub(high, low);
    range = fminf(range, cbrtf(overlap * size.x * size.y * size.z * 3 / (4 * PI * (float)count)));
    for (uint64_t i = 0; i < count; i++) {
        float x = random_range(&b->random, low.x, high.x), y = random_range(&b->random, low.y, high.y);
        vec3 p = {x, y, random_range(&b->random, low.z, high.z)};
        vec3 color = vec3_lerp(LIGHT_WARM, builtin_hue(random_float(&b->random), 0.7f), random_float(&b->random) * 0.6f);
        builtin_point(b, p, color, 1.2f * range * range, range);
    }
}

void builtin_camera(struct builtin *b, const char *name, vec3 position, vec3 target, float fov) {
    fnl_camera camera = fnl_camera_default();
    camera.position = position;
    camera.target = target;
    camera.vertical_fov = fov;
    if (!b->failed && fnl_scene_add_camera(b->scene, name, &camera) != FNL_OK) b->failed = true;
}

vec3 builtin_hue(float hue, float saturation) {
    float c[3], highest = 0;
    for (int i = 0; i < 3; i++) {
        c[i] = 1 - saturation * (0.5f - 0.5f * cosf(2 * PI * (hue - (float)i / 3)));
        highest = fmaxf(highest, c[i]);
    }
    return vec3_make(c[0] / highest, c[1] / highest, c[2] / highest);
}

/* ---- reading "NAME?key=value&key=value" ---- */

static uint32_t key_count(const struct builtin_scene *scene) {
    uint32_t count = 0;
    while (count < COUNT_OF(scene->keys) && scene->keys[count].name) count++;
    return count;
}

static const struct builtin_scene *find_scene(const fnl_host *host, const char *text, size_t length) {
    char known[256] = "";
    for (uint32_t i = 0; i < COUNT_OF(scenes); i++) {
        if (strlen(scenes[i].name) == length && memcmp(scenes[i].name, text, length) == 0) return &scenes[i];
        size_t used = strlen(known);
        snprintf(known + used, sizeof known - used, "%s%s", i ? ", " : "", scenes[i].name);
    }
    log_error(host, "builtin:%s: there is no built-in scene '%.*s'; there are: %s", text, (int)MIN(length, 64), text, known);
    return NULL;
}

/* A directional light of so many lux. */
static void add_sun(struct builtin *b, uint64_t lux) {
    fnl_light_params light = fnl_light_params_default();
    light.kind = FNL_LIGHT_DIRECTIONAL;
    light.direction = vec3_normalize((vec3){0.45f, -0.8f, -0.35f});
    light.intensity = (float)lux;
    if (lux > 0) builtin_light(b, &light);
}

/* It gives no lights: their number is that of the key. */
static void add_environment(struct builtin *b, const struct builtin_scene *what, bool by_sun) {
    fnl_environment_params params = fnl_environment_params_default();
    params.source = by_sun ? "builtin:sky" : what->environment;
    params.intensity = by_sun ? what->intensity_by_sun : what->intensity;
    params.lights = false;
    if (!b->failed && fnl_scene_set_environment(b->scene, &params) != FNL_OK) b->failed = true;
}

/** Scenes with the keys "overdraw", "decals" and "sun" get these once everything is in its place. */
static void finish_scene(struct builtin *b, const struct builtin_scene *what, const uint64_t *values) {
    uint64_t count = 0, seed = 1, sun = 0;
    for (uint32_t i = 0; i < key_count(what); i++) {
        if (strcmp(what->keys[i].name, "overdraw") == 0 && values[i]) {
            builtin_overdraw(b);
            scene_update_transforms(b->scene);
        }
        if (strcmp(what->keys[i].name, "decals") == 0) count = values[i];
        if (strcmp(what->keys[i].name, "sun") == 0) add_sun(b, sun = values[i]);
        if (strcmp(what->keys[i].name, "seed") == 0) seed = values[i];
    }
    if (what->environment) add_environment(b, what, sun > 0);
    if (!b->failed && fnl_scene_scatter_decals(b->scene, (uint32_t)count, seed) != FNL_OK) b->failed = true;
}

static fnl_result make_scene(const fnl_host *host, const char *text, const struct builtin_scene *what,
                             const uint64_t *values, fnl_scene **out) {
    char source[320];
    snprintf(source, sizeof source, "builtin:%s", text);
    TRY(scene_create(host, source, out));
    struct builtin b = {.scene = *out, .random = {1}};
    fnl_result result = jobs_create(host, &b.jobs);
    if (result == FNL_OK) {
        what->make(&b, values);
        builtin_flush(&b);
        scene_update_transforms(b.scene);
        finish_scene(&b, what, values);
        jobs_destroy(&b.jobs);
    }
    for (uint32_t i = 0; i < b.placements.count; i++) array_free(&b.scene->host, &b.placements.data[i].transforms);
    array_free(&b.scene->host, &b.placements);
    if (result == FNL_OK && b.failed) result = FNL_ERROR_MEMORY;
    if (result != FNL_OK) fnl_scene_destroy(out);
    return result;
}

fnl_result builtin_load(const fnl_host *host, const char *text, fnl_scene **out) {
    fnl_host resolved = host_resolve(host);
    *out = NULL;
    const struct builtin_scene *what = find_scene(&resolved, text, query_name_length(text));
    if (!what) return FNL_ERROR_INVALID;
    enum { KEYS = COUNT_OF(what->keys) };
    struct query_key keys[KEYS];
    double given[KEYS];
    uint64_t values[KEYS];
    const uint32_t count = key_count(what);
    for (uint32_t i = 0; i < count; i++) {
        keys[i] = (struct query_key){what->keys[i].name, (double)what->keys[i].low, (double)what->keys[i].high, false};
        given[i] = -1;
    }
    TRY(query_read(&resolved, text, what->name, keys, count, given));
    for (uint32_t i = 0; i < KEYS; i++) values[i] = i < count && given[i] >= 0 ? (uint64_t)given[i] : what->keys[i].fallback;
    return make_scene(&resolved, text, what, values, out);
}
