/* SPDX-License-Identifier: MIT */
/* Decals of a scene: the public calls, and where a decal is. */
#include "scene/scene.h"

const char *fnl_decal_kind_name(fnl_decal_kind kind) {
    static const char *const names[FNL_DECAL_KIND_COUNT] = {"box", "volume", "mesh", "redraw", "baked"};
    return (uint32_t)kind < FNL_DECAL_KIND_COUNT ? names[kind] : NULL;
}

const char *fnl_decal_blend_name(fnl_decal_blend blend) {
    static const char *const names[FNL_DECAL_BLEND_COUNT] = {"alpha", "multiply", "add", "screen", "overlay"};
    return (uint32_t)blend < FNL_DECAL_BLEND_COUNT ? names[blend] : NULL;
}

fnl_decal_params fnl_decal_params_default(void) {
    return (fnl_decal_params){.kind = FNL_DECAL_BOX,
                              .transform = mat4_identity(),
                              .color = {1, 1, 1, 1},
                              .roughness = 0.5f,
                              .normal_scale = 1,
                              .channels = FNL_DECAL_COLOR | FNL_DECAL_ROUGHNESS | FNL_DECAL_METALLIC,
                              .blend = FNL_DECAL_BLEND_ALPHA,
                              .fade_start = 65 * PI / 180,
                              .fade_end = 85 * PI / 180,
                              .receivers = 255,
                              .cut = 0.5f,
                              .slices = 1};
}

/* ---- checks ---- */

static bool in_range(const float *values, uint32_t count, float low, float high) {
    for (uint32_t i = 0; i < count; i++)
        if (!(values[i] >= low && values[i] <= high)) return false;
    return true;
}

static bool is_invertible(const mat4 *m) {
    mat4 inverse;
    for (int i = 0; i < 16; i++)
        if (!isfinite(m->m[i])) return false;
    if (m->m[3] != 0 || m->m[7] != 0 || m->m[11] != 0 || m->m[15] != 1 || !mat4_inverse(m, &inverse)) return false;
    for (int i = 0; i < 16; i++)
        if (!isfinite(inverse.m[i])) return false;
    return true;
}

static bool needs_instance(fnl_decal_kind kind) {
    return kind == FNL_DECAL_MESH || kind == FNL_DECAL_REDRAW || kind == FNL_DECAL_BAKED;
}

fnl_result decal_check(const fnl_host *host, const fnl_decal_params *p) {
    REQUIRE(host, p != NULL);
    REQUIRE(host, (uint32_t)p->kind < FNL_DECAL_KIND_COUNT);
    REQUIRE(host, (uint32_t)p->blend < FNL_DECAL_BLEND_COUNT);
    REQUIRE(host, is_invertible(&p->transform));
    REQUIRE(host, in_range(p->color, 4, 0, 1));
    REQUIRE(host, in_range(&p->metallic, 1, 0, 1));
    REQUIRE(host, in_range(&p->roughness, 1, 0, 1));
    REQUIRE(host, isfinite(p->normal_scale));
    REQUIRE(host, in_range(p->emissive, 3, 0, FLT_MAX));
    REQUIRE(host, p->channels <= FNL_DECAL_ALL);
    REQUIRE(host, p->fade_start >= 0 && p->fade_end >= p->fade_start && p->fade_end <= PI + 1e-6f);
    REQUIRE(host, p->receivers <= 255);
    REQUIRE(host, in_range(&p->cut, 1, 0, 1));
    REQUIRE(host, p->slices >= 1 && p->slices <= 4096);
    return FNL_OK;
}

static bool image_known(const fnl_scene *scene, fnl_image_id id) {
    return id.generation ? id.generation == 1 && id.index < scene->images.count : id.index == 0;
}

static bool instance_alive(const fnl_scene *scene, fnl_instance_id id) {
    return id.generation != 0 && id.index < scene->nodes.count && !scene->nodes.data[id.index].removed &&
           scene->nodes.data[id.index].generation == id.generation;
}

static fnl_result check_all(const fnl_scene *scene, const fnl_decal_params *p) {
    TRY(decal_check(&scene->host, p));
    REQUIRE(&scene->host, image_known(scene, p->color_image));
    REQUIRE(&scene->host, image_known(scene, p->normal_image));
    REQUIRE(&scene->host, image_known(scene, p->metallic_roughness_image));
    REQUIRE(&scene->host, image_known(scene, p->emissive_image));
    bool nothing = p->instance.generation == 0 && p->instance.index == 0;
    REQUIRE(&scene->host, (nothing && !needs_instance(p->kind)) || instance_alive(scene, p->instance));
    return FNL_OK;
}

/* ---- where they are ---- */

bool decal_shows(const fnl_scene *scene, const struct scene_decal *decal) {
    if (decal->removed) return false;
    if (decal->node == SCENE_NONE) return true;
    const struct scene_node *node = &scene->nodes.data[decal->node];
    uint32_t wanted = decal->params.instance.generation; /* 0: of a file, whose nodes stay */
    return node->active && !node->removed && (wanted == 0 || node->generation == wanted);
}

mat4 decal_transform(const fnl_scene *scene, const struct scene_decal *decal) {
    if (decal->node == SCENE_NONE || needs_instance(decal->params.kind)) return decal->params.transform;
    return mat4_mul(scene->nodes.data[decal->node].world, decal->params.transform);
}

/* The separating axes of a box and a triangle (Akenine-Moeller 2001). */
bool decal_touches(const vec3 corners[3]) {
    const vec3 edges[3] = {vec3_sub(corners[1], corners[0]), vec3_sub(corners[2], corners[1]),
                           vec3_sub(corners[0], corners[2])};
    const vec3 axes[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    vec3 tests[13];
    uint32_t count = 0;
    for (int i = 0; i < 3; i++) tests[count++] = axes[i];
    tests[count++] = vec3_cross(edges[0], edges[1]);
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++) tests[count++] = vec3_cross(axes[i], edges[k]);
    for (uint32_t i = 0; i < count; i++) {
        float a = vec3_dot(tests[i], corners[0]), b = vec3_dot(tests[i], corners[1]), c = vec3_dot(tests[i], corners[2]);
        float reach = 0.5f * (fabsf(tests[i].x) + fabsf(tests[i].y) + fabsf(tests[i].z));
        if (fminf(a, fminf(b, c)) > reach || fmaxf(a, fmaxf(b, c)) < -reach) return false;
    }
    return true;
}

/* ---- adding and changing ---- */

/* What changed besides the array of decals: pictures, draws, materials. */
static void touch(fnl_scene *scene) { scene->decal_version++; }

uint32_t scene_add_decal(fnl_scene *scene, const fnl_decal_params *params, uint32_t node) {
    if (++scene->next_generation == 0) scene->next_generation = 1;
    struct scene_decal decal = {.params = *params, .node = node, .generation = scene->next_generation};
    uint32_t index;
    if (scene->free_decals.count > 0) {
        index = scene->free_decals.data[--scene->free_decals.count];
        scene->decals.data[index] = decal;
    } else {
        index = scene->decals.count;
        if (index == SCENE_NONE || !array_push(&scene->host, &scene->decals, decal)) return SCENE_NONE;
    }
    touch(scene);
    if (params->kind == FNL_DECAL_BAKED && decal_bake(scene, node) != FNL_OK) {
        scene->decals.data[index].removed = true;
        UNUSED(array_push(&scene->host, &scene->free_decals, index)); /* else it stays a hole */
        return SCENE_NONE;
    }
    return index;
}

fnl_result fnl_scene_add_decal(fnl_scene *scene, const fnl_decal_params *params, fnl_decal_id *out) {
    if (!scene) return FNL_ERROR_INVALID;
    REQUIRE(&scene->host, out != NULL);
    *out = (fnl_decal_id){0};
    TRY(check_all(scene, params));
    uint32_t index = scene_add_decal(scene, params, params->instance.generation ? params->instance.index : SCENE_NONE);
    if (index == SCENE_NONE) return FNL_ERROR_MEMORY;
    *out = (fnl_decal_id){index, scene->decals.data[index].generation};
    return FNL_OK;
}

static bool decal_alive(const fnl_scene *scene, fnl_decal_id id) {
    if (id.generation == 0 || id.index >= scene->decals.count) return false;
    const struct scene_decal *decal = &scene->decals.data[id.index];
    return decal->generation == id.generation && !decal->removed;
}

fnl_result fnl_scene_set_decal(fnl_scene *scene, fnl_decal_id id, const fnl_decal_params *params) {
    if (!scene) return FNL_ERROR_INVALID;
    REQUIRE(&scene->host, decal_alive(scene, id));
    TRY(check_all(scene, params));
    struct scene_decal *decal = &scene->decals.data[id.index];
    REQUIRE(&scene->host, params->kind == decal->params.kind);
    bool same = params->instance.index == decal->params.instance.index &&
                params->instance.generation == decal->params.instance.generation;
    REQUIRE(&scene->host, same || !needs_instance(params->kind));
    decal->params = *params;
    decal->node = params->instance.generation ? params->instance.index : SCENE_NONE;
    touch(scene);
    return params->kind == FNL_DECAL_BAKED ? decal_bake(scene, decal->node) : FNL_OK;
}

fnl_result fnl_scene_remove_decal(fnl_scene *scene, fnl_decal_id id) {
    if (!scene) return FNL_ERROR_INVALID;
    REQUIRE(&scene->host, decal_alive(scene, id));
    if (!array_push(&scene->host, &scene->free_decals, id.index)) return FNL_ERROR_MEMORY;
    struct scene_decal *decal = &scene->decals.data[id.index];
    bool shown = decal_shows(scene, decal);
    decal->removed = true;
    touch(scene);
    return decal->params.kind == FNL_DECAL_BAKED && shown ? decal_bake(scene, decal->node) : FNL_OK;
}

fnl_result fnl_scene_set_instance_receivers(fnl_scene *scene, fnl_instance_id instance, uint32_t receivers) {
    if (!scene) return FNL_ERROR_INVALID;
    REQUIRE(&scene->host, instance_alive(scene, instance));
    REQUIRE(&scene->host, receivers <= 255);
    scene->nodes.data[instance.index].refuses = (uint8_t)~receivers;
    scene->structure_version++;
    return FNL_OK;
}

fnl_result fnl_scene_query_decal(const fnl_scene *scene, uint32_t index, fnl_decal_params *out) {
    if (!scene) return FNL_ERROR_INVALID;
    REQUIRE(&scene->host, out != NULL);
    REQUIRE(&scene->host, index < scene->decals.count - scene->free_decals.count);
    uint32_t alive = index;
    for (index = 0; alive > 0 || scene->decals.data[index].removed; index++)
        if (!scene->decals.data[index].removed) alive--;
    *out = scene->decals.data[index].params;
    return FNL_OK;
}
