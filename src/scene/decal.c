/* SPDX-License-Identifier: MIT */
/* Decals of a scene: the public calls, and where a decal is. */
#include "scene/scene.h"

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

fnl_result decal_check(const struct call *call, const fnl_decal_params *p) {
    TRY(check_pointer(call, "params", p));
    const double infinite = (double)FLT_MAX;
    TRY(check_enum(call, "kind", (int)p->kind, FNL_DECAL_KIND_COUNT, "fnl_decal_kind"));
    TRY(check_enum(call, "blend", (int)p->blend, FNL_DECAL_BLEND_COUNT, "fnl_decal_blend"));
    TRY(check_floats(call, "transform.m", p->transform.m, 16, -infinite, infinite, ""));
    if (!is_invertible(&p->transform)) return misuse(call, "transform is not affine and invertible, must be both");
    TRY(check_floats(call, "color", p->color, 4, 0, 1, ""));
    TRY(check_range(call, "metallic", (double)p->metallic, 0, 1, ""));
    TRY(check_range(call, "roughness", (double)p->roughness, 0, 1, ""));
    TRY(check_range(call, "normal_scale", (double)p->normal_scale, -infinite, infinite, ""));
    TRY(check_floats(call, "emissive", p->emissive, 3, 0, infinite, " cd/m^2"));
    TRY(check_count(call, "channels", p->channels, 0, FNL_DECAL_ALL));
    TRY(check_range(call, "fade_start", (double)p->fade_start, 0, (double)(PI + 1e-6f), " radians"));
    TRY(check_range(call, "fade_end", (double)p->fade_end, (double)p->fade_start, (double)(PI + 1e-6f),
                    " radians (fade_start .. pi)"));
    TRY(check_count(call, "receivers", p->receivers, 0, 255));
    TRY(check_range(call, "cut", (double)p->cut, 0, 1, ""));
    return check_count(call, "slices", p->slices, 1, 4096);
}

static fnl_result check_all(const struct call *call, const fnl_scene *scene, const fnl_decal_params *p) {
    TRY(decal_check(call, p));
    TRY(scene_check_image(call, scene, "color_image", p->color_image, true));
    TRY(scene_check_image(call, scene, "normal_image", p->normal_image, true));
    TRY(scene_check_image(call, scene, "metallic_roughness_image", p->metallic_roughness_image, true));
    TRY(scene_check_image(call, scene, "emissive_image", p->emissive_image, true));
    bool nothing = p->instance.generation == 0 && p->instance.index == 0;
    return nothing && !needs_instance(p->kind) ? FNL_OK : scene_check_instance(call, scene, p->instance);
}

/* ---- where they are ---- */

bool decal_exists(const fnl_scene *scene, const struct scene_decal *decal) {
    if (decal->removed) return false;
    if (decal->node == SCENE_NONE) return true;
    const struct scene_node *node = &scene->nodes.data[decal->node];
    uint32_t wanted = decal->params.instance.generation; /* 0: of a file, whose nodes keep their places */
    return !node->removed && (wanted == 0 || node->generation == wanted);
}

/* What it is on or moves with, as the public interface says it: decals of files have only the node. */
static fnl_instance_id instance_of(const fnl_scene *scene, const struct scene_decal *decal) {
    if (decal->params.instance.generation || decal->node == SCENE_NONE || scene->nodes.data[decal->node].removed) return decal->params.instance;
    return (fnl_instance_id){decal->node, scene->nodes.data[decal->node].generation};
}

bool decal_shows(const fnl_scene *scene, const struct scene_decal *decal) {
    return decal_exists(scene, decal) && (decal->node == SCENE_NONE || scene->nodes.data[decal->node].active);
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

static void place_decal(const fnl_scene *scene, struct scene_decal *decal) {
    const float *m = decal->params.transform.m;
    place_from_vec3(vec3_make(m[12], m[13], m[14]), scene->origin, decal->place);
}

/* What changed besides the array of decals: pictures, draws, materials. */
static void touch(fnl_scene *scene) { scene->decal_version++; }

uint32_t scene_add_decal(fnl_scene *scene, const fnl_decal_params *params, uint32_t node) {
    if (++scene->next_generation == 0) scene->next_generation = 1;
    struct scene_decal decal = {.params = *params, .node = node, .generation = scene->next_generation};
    place_decal(scene, &decal);
    const uint32_t index = scene_take_place(scene, SCENE_DECALS, &scene->decals);
    if (index == SCENE_NONE) return SCENE_NONE;
    scene->decals.data[index] = decal;
    touch(scene);
    if (params->kind != FNL_DECAL_BAKED || decal_bake(scene, node) == FNL_OK) return index;
    scene_remove_decal(scene, index);
    return SCENE_NONE;
}

void scene_remove_decal(fnl_scene *scene, uint32_t index) {
    scene->decals.data[index].removed = true;
    scene_leave_hole(scene, SCENE_DECALS, index);
    touch(scene);
}

fnl_result fnl_scene_add_decal(fnl_scene *scene, const fnl_decal_params *params, fnl_decal_id *out) {
    TRY(check_handle(__func__, "scene", scene));
    TRY(check_pointer(CALL(&scene->host), "out", out));
    *out = (fnl_decal_id){0};
    TRY(check_all(CALL(&scene->host), scene, params));
    uint32_t index = scene_add_decal(scene, params, params->instance.generation ? params->instance.index : SCENE_NONE);
    if (index == SCENE_NONE) return FNL_ERROR_MEMORY;
    *out = (fnl_decal_id){index, scene->decals.data[index].generation};
    return FNL_OK;
}

static fnl_result check_decal_id(const struct call *call, const fnl_scene *scene, fnl_decal_id id) {
    const struct scene_decal *decal = id.index < scene->decals.count ? &scene->decals.data[id.index] : NULL;
    bool alive = decal && id.generation && decal->generation == id.generation && !decal->removed;
    return check_id(call, "decal", alive, id.index, id.generation, "a decal");
}

fnl_result fnl_scene_set_decal(fnl_scene *scene, fnl_decal_id id, const fnl_decal_params *params) {
    TRY(check_handle(__func__, "scene", scene));
    const struct call *call = CALL(&scene->host);
    TRY(check_decal_id(call, scene, id));
    TRY(check_all(call, scene, params));
    struct scene_decal *decal = &scene->decals.data[id.index];
    if (params->kind != decal->params.kind)
        return misuse(call, "kind is %s, must stay %s", fnl_value_name(FNL_ENUM_DECAL_KIND, params->kind),
                      fnl_value_name(FNL_ENUM_DECAL_KIND, decal->params.kind));
    const fnl_instance_id instance = instance_of(scene, decal);
    bool same = params->instance.index == instance.index && params->instance.generation == instance.generation;
    if (!same && needs_instance(params->kind)) return misuse(call, "instance is another, must stay the same");
    const bool placed = decal->node != SCENE_NONE || memcmp(params->transform.m + 12, decal->params.transform.m + 12, 3 * sizeof(float)) != 0;
    decal->params = *params;
    decal->node = params->instance.generation ? params->instance.index : SCENE_NONE;
    if (placed) place_decal(scene, decal);
    touch(scene);
    return params->kind == FNL_DECAL_BAKED ? decal_bake(scene, decal->node) : FNL_OK;
}

fnl_result fnl_scene_remove_decal(fnl_scene *scene, fnl_decal_id id) {
    TRY(check_handle(__func__, "scene", scene));
    TRY(check_decal_id(CALL(&scene->host), scene, id));
    const struct scene_decal *decal = &scene->decals.data[id.index];
    const bool baked = decal->params.kind == FNL_DECAL_BAKED && decal_exists(scene, decal);
    scene_remove_decal(scene, id.index);
    const fnl_result result = baked ? decal_bake(scene, decal->node) : FNL_OK;
    scene_drop_parts(scene);
    return result;
}

fnl_result fnl_scene_set_instance_receivers(fnl_scene *scene, fnl_instance_id instance, uint32_t receivers) {
    TRY(check_handle(__func__, "scene", scene));
    TRY(scene_check_instance(CALL(&scene->host), scene, instance));
    TRY(check_count(CALL(&scene->host), "receivers", receivers, 0, 255));
    scene_set_receivers(scene, instance.index, receivers);
    return FNL_OK;
}

fnl_result fnl_scene_query_decal(const fnl_scene *scene, uint32_t index, fnl_decal_params *out) {
    TRY(check_handle(__func__, "scene", scene));
    TRY(check_pointer(CALL(&scene->host), "out", out));
    TRY(check_index(CALL(&scene->host), "index", index, scene_entity_count(scene, FNL_ENTITY_DECAL), "decals"));
    const struct scene_decal *decal = &scene->decals.data[scene_entity_slot(scene, FNL_ENTITY_DECAL, index)];
    *out = decal->params;
    out->instance = instance_of(scene, decal);
    return FNL_OK;
}
