/* SPDX-License-Identifier: MIT */
/* The public calls that go through what a scene has, by index and name, and those that change its instances. */
#include "scene/scene.h"

/* Removed elements leave holes, and elements of the stage count as holes. Public indices skip both. */
static bool is_hole(const fnl_scene *scene, fnl_entity kind, uint32_t slot) {
    switch (kind) {
    case FNL_ENTITY_INSTANCE: return scene->nodes.data[slot].removed;
    case FNL_ENTITY_LIGHT: return scene->lights.data[slot].removed;
    case FNL_ENTITY_DECAL: return scene->decals.data[slot].removed;
    case FNL_ENTITY_MESH: return scene->meshes.data[slot].removed || slot == scene->stage.mesh;
    case FNL_ENTITY_MATERIAL: return scene->materials.data[slot].removed || slot == scene->stage.material;
    case FNL_ENTITY_IMAGE: return scene->images.data[slot].removed;
    case FNL_ENTITY_CAMERA: return scene->cameras.data[slot].removed;
    case FNL_ENTITY_ANIMATION: return scene->animations.data[slot].removed;
    case FNL_ENTITY_PROBE: return scene->probes.data[slot].removed;
    case FNL_ENTITY_VARIANT: return scene->variants.data[slot].removed;
    case FNL_ENTITY_METADATA:
    case FNL_ENTITY_COUNT: break;
    }
    return false;
}

/* With holes. */
static uint32_t slot_count(const fnl_scene *scene, fnl_entity kind) {
    const uint32_t counts[FNL_ENTITY_COUNT] = {
        [FNL_ENTITY_INSTANCE] = scene->nodes.count,  [FNL_ENTITY_LIGHT] = scene->lights.count,
        [FNL_ENTITY_DECAL] = scene->decals.count,    [FNL_ENTITY_MESH] = scene->meshes.count,
        [FNL_ENTITY_MATERIAL] = scene->materials.count, [FNL_ENTITY_IMAGE] = scene->images.count,
        [FNL_ENTITY_CAMERA] = scene->cameras.count,  [FNL_ENTITY_ANIMATION] = scene->animations.count,
        [FNL_ENTITY_PROBE] = scene->probes.count,    [FNL_ENTITY_VARIANT] = scene->variants.count,
        [FNL_ENTITY_METADATA] = scene->packets.count};
    return counts[kind];
}

static uint32_t hole_count(const fnl_scene *scene, fnl_entity kind) {
    static const enum scene_pool pools[FNL_ENTITY_COUNT] = {
        [FNL_ENTITY_INSTANCE] = SCENE_NODES, [FNL_ENTITY_LIGHT] = SCENE_LIGHTS, [FNL_ENTITY_DECAL] = SCENE_DECALS,
        [FNL_ENTITY_MESH] = SCENE_MESHES, [FNL_ENTITY_MATERIAL] = SCENE_MATERIALS, [FNL_ENTITY_IMAGE] = SCENE_IMAGES,
        [FNL_ENTITY_CAMERA] = SCENE_CAMERAS, [FNL_ENTITY_ANIMATION] = SCENE_ANIMATIONS, [FNL_ENTITY_PROBE] = SCENE_PROBES,
        [FNL_ENTITY_VARIANT] = SCENE_VARIANTS};
    const uint32_t staged = kind == FNL_ENTITY_LIGHT      ? (scene->environment.staged ? scene->environment.source_count : 0)
                            : kind == FNL_ENTITY_MESH     ? scene->stage.mesh != SCENE_NONE
                            : kind == FNL_ENTITY_MATERIAL ? scene->stage.material != SCENE_NONE
                                                          : 0;
    return kind == FNL_ENTITY_METADATA ? 0 : scene->hole_counts[pools[kind]] + staged;
}

uint32_t scene_entity_count(const fnl_scene *scene, fnl_entity kind) { return slot_count(scene, kind) - hole_count(scene, kind); }

/* With few holes: a slot is its index and the holes before it, which the search comes to from below. */
static uint32_t slot_among(const uint32_t *holes, uint32_t count, uint32_t index) {
    uint32_t slot = index, before, last;
    do {
        last = slot;
        before = 0;
        for (uint32_t i = 0; i < count; i++) before += holes[i] <= slot;
        slot = index + before;
    } while (slot != last);
    return slot;
}

uint32_t scene_entity_slot(const fnl_scene *scene, fnl_entity kind, uint32_t index) {
    const uint32_t slots = slot_count(scene, kind), holes = hole_count(scene, kind);
    if (holes == 0) return index;
    if (holes == 1 && kind == FNL_ENTITY_MESH && scene->stage.mesh != SCENE_NONE) return index + (index >= scene->stage.mesh);
    if (holes == 1 && kind == FNL_ENTITY_MATERIAL && scene->stage.material != SCENE_NONE) return index + (index >= scene->stage.material);
    if (kind == FNL_ENTITY_LIGHT && holes < slots / 8 && holes == scene->free_lights.count) return slot_among(scene->free_lights.data, holes, index);
    uint32_t slot = 0;
    for (uint32_t left = index; left > 0 || is_hole(scene, kind, slot); slot++) left -= !is_hole(scene, kind, slot);
    return slot;
}

uint32_t scene_entity_index(const fnl_scene *scene, fnl_entity kind, uint32_t slot) {
    const uint32_t holes = hole_count(scene, kind);
    uint32_t before = 0;
    if (kind == FNL_ENTITY_LIGHT && holes == scene->free_lights.count)
        for (uint32_t i = 0; i < holes; i++) before += scene->free_lights.data[i] < slot;
    else
        for (uint32_t i = 0; i < slot && holes; i++) before += is_hole(scene, kind, i);
    return slot - before;
}

static const char *const plurals[] = {"instances", "lights", "decals", "meshes", "materials", "images", "cameras", "animations", "probes",
                                       "variants",  "packets of metadata"};
_Static_assert(COUNT_OF(plurals) == FNL_ENTITY_COUNT, "each kind of entity has its name");

static fnl_entity_info describe(const fnl_scene *scene, fnl_entity kind, uint32_t slot) {
    fnl_entity_info info = {.name = ""};
    switch (kind) {
    case FNL_ENTITY_INSTANCE:
        info.name = scene->nodes.data[slot].name;
        info.extras = scene->nodes.data[slot].extras;
        info.id.instance = (fnl_instance_id){slot, scene->nodes.data[slot].generation};
        break;
    case FNL_ENTITY_LIGHT:
        info.name = scene->lights.data[slot].name;
        info.extras = scene->lights.data[slot].extras;
        info.id.light = (fnl_light_id){slot, scene->lights.data[slot].generation};
        break;
    case FNL_ENTITY_DECAL:
        info.id.decal = (fnl_decal_id){slot, scene->decals.data[slot].generation};
        break;
    case FNL_ENTITY_MESH:
        info.name = scene->meshes.data[slot].name;
        info.extras = scene->meshes.data[slot].extras;
        info.id.mesh = (fnl_mesh_id){slot, scene->meshes.data[slot].generation};
        break;
    case FNL_ENTITY_MATERIAL:
        info.name = scene->materials.data[slot].name;
        info.extras = scene->materials.data[slot].extras;
        info.id.material = scene_material_id(scene, slot);
        break;
    case FNL_ENTITY_IMAGE:
        info.name = scene->images.data[slot].name;
        info.id.image = scene_image_id(scene, slot);
        break;
    case FNL_ENTITY_CAMERA:
        info.name = scene->cameras.data[slot].name;
        info.extras = scene->cameras.data[slot].extras;
        break;
    case FNL_ENTITY_ANIMATION:
        info.name = scene->animations.data[slot].name;
        info.extras = scene->animations.data[slot].extras;
        break;
    case FNL_ENTITY_PROBE:
        info.id.probe = (fnl_probe_id){slot, scene->probes.data[slot].generation};
        break;
    case FNL_ENTITY_VARIANT:
        info.name = scene->variants.data[slot].name;
        info.extras = scene->variants.data[slot].extras;
        break;
    case FNL_ENTITY_METADATA:
        info.name = scene->packets.data[slot].about;
        info.extras = scene->packets.data[slot].text;
        break;
    case FNL_ENTITY_COUNT:
        break;
    }
    if (!info.name) info.name = "";
    return info;
}

uint32_t fnl_scene_count(const fnl_scene *scene, fnl_entity kind) {
    if (check_handle(__func__, "scene", scene) != FNL_OK) return 0;
    if (check_enum(CALL(&scene->host), "kind", (int)kind, FNL_ENTITY_COUNT, "fnl_entity") != FNL_OK) return 0;
    return scene_entity_count(scene, kind);
}

fnl_result fnl_scene_query_entity(const fnl_scene *scene, fnl_entity kind, uint32_t index, fnl_entity_info *out) {
    TRY(check_handle(__func__, "scene", scene));
    const struct call *call = CALL(&scene->host);
    TRY(check_pointer(call, "out", out));
    TRY(check_enum(call, "kind", (int)kind, FNL_ENTITY_COUNT, "fnl_entity"));
    TRY(check_index(call, "index", index, scene_entity_count(scene, kind), plurals[kind]));
    *out = describe(scene, kind, scene_entity_slot(scene, kind, index));
    return FNL_OK;
}

fnl_result fnl_scene_find(const fnl_scene *scene, fnl_entity kind, const char *name, uint32_t *out_index) {
    TRY(check_handle(__func__, "scene", scene));
    const struct call *call = CALL(&scene->host);
    TRY(check_pointer(call, "name", name));
    TRY(check_pointer(call, "out_index", out_index));
    TRY(check_enum(call, "kind", (int)kind, FNL_ENTITY_COUNT, "fnl_entity"));
    char names[1024] = "";
    size_t length = 0;
    uint32_t index = 0;
    for (uint32_t slot = 0; slot < slot_count(scene, kind); slot++) {
        if (is_hole(scene, kind, slot)) continue;
        const char *known = describe(scene, kind, slot).name;
        if (strcmp(known, name) == 0) {
            *out_index = index;
            return FNL_OK;
        }
        if (*known && length < sizeof names)
            length += (size_t)snprintf(names + length, sizeof names - length, "%s'%s'", length ? ", " : "", known);
        index++;
    }
    return misuse(call, "%s: there is no '%s' among the %u %s%s%s", scene->source, name, index, plurals[kind],
                  length ? ": " : "", names);
}

/* ---- ids ---- */

fnl_image_id scene_image_id(const fnl_scene *scene, uint32_t image) {
    return image == SCENE_NONE ? (fnl_image_id){0} : (fnl_image_id){image, scene->images.data[image].generation};
}

fnl_material_id scene_material_id(const fnl_scene *scene, uint32_t material) {
    return material == SCENE_NONE ? (fnl_material_id){0} : (fnl_material_id){material, scene->materials.data[material].generation};
}

fnl_result scene_check_image(const struct call *call, const fnl_scene *scene, const char *name, fnl_image_id id, bool or_none) {
    const struct scene_image *image = id.index < scene->images.count ? &scene->images.data[id.index] : NULL;
    const bool known = image && id.generation && image->generation == id.generation && !image->removed;
    return check_id(call, name, known || (or_none && id.index == 0 && id.generation == 0), id.index, id.generation, "an image");
}

fnl_result scene_check_material(const struct call *call, const fnl_scene *scene, fnl_material_id id, bool or_none) {
    const struct scene_material *material = id.index < scene->materials.count ? &scene->materials.data[id.index] : NULL;
    const bool known = material && id.generation && material->generation == id.generation && !material->removed;
    return check_id(call, "material", known || (or_none && id.index == 0 && id.generation == 0), id.index, id.generation, "a material");
}

fnl_result scene_check_mesh(const struct call *call, const fnl_scene *scene, fnl_mesh_id id) {
    const struct scene_mesh *mesh = id.index < scene->meshes.count ? &scene->meshes.data[id.index] : NULL;
    const bool known = mesh && id.generation && mesh->generation == id.generation && !mesh->removed;
    return check_id(call, "mesh", known, id.index, id.generation, "a mesh");
}

/* ---- instances ---- */

fnl_result scene_check_instance(const struct call *call, const fnl_scene *scene, fnl_instance_id id) {
    const struct scene_node *node = id.index < scene->nodes.count ? &scene->nodes.data[id.index] : NULL;
    bool alive = node && id.generation && node->generation == id.generation && !node->removed;
    return check_id(call, "instance", alive, id.index, id.generation, "an instance");
}

fnl_result fnl_scene_query_instance(const fnl_scene *scene, uint32_t index, fnl_instance_info *out) {
    TRY(check_handle(__func__, "scene", scene));
    const struct call *call = CALL(&scene->host);
    TRY(check_pointer(call, "out", out));
    TRY(check_index(call, "index", index, scene_entity_count(scene, FNL_ENTITY_INSTANCE), "instances"));
    const struct scene_node *node = &scene->nodes.data[scene_entity_slot(scene, FNL_ENTITY_INSTANCE, index)];
    *out = (fnl_instance_info){
        .transform = scene_node_local(scene, node), .world = node->world, .visible = !node->hidden, .shown = node->active, .receivers = 255u & ~node->refuses, .light_mask = 255u & ~node->unlit, .view_mask = 255u & ~node->unseen};
    if (node->parent != SCENE_NONE)
        out->parent = (fnl_instance_id){node->parent, scene->nodes.data[node->parent].generation};
    if (node->skin != SCENE_NONE) out->joint_count = scene->skins.data[node->skin].joint_count;
    if (node->mesh == SCENE_NONE) return FNL_OK;
    const struct scene_mesh *mesh = &scene->meshes.data[node->mesh];
    out->mesh = (fnl_mesh_id){node->mesh, mesh->generation};
    out->morph_target_count = mesh->morph_target_count;
    out->morph_weights = node->morph_weights ? node->morph_weights : mesh->morph_weights;
    return FNL_OK;
}

fnl_result fnl_scene_set_instance_light_mask(fnl_scene *scene, fnl_instance_id instance, uint32_t mask) {
    TRY(check_handle(__func__, "scene", scene));
    TRY(scene_check_instance(CALL(&scene->host), scene, instance));
    TRY(check_count(CALL(&scene->host), "mask", mask, 0, 255));
    scene_set_light_mask(scene, instance.index, mask);
    return FNL_OK;
}

fnl_result fnl_scene_set_instance_view_mask(fnl_scene *scene, fnl_instance_id instance, uint32_t mask) {
    TRY(check_handle(__func__, "scene", scene));
    TRY(scene_check_instance(CALL(&scene->host), scene, instance));
    TRY(check_count(CALL(&scene->host), "mask", mask, 0, 255));
    scene_set_view_mask(scene, instance.index, mask);
    return FNL_OK;
}

fnl_result fnl_scene_set_instance_transforms(fnl_scene *scene, const fnl_instance_id *instances, const fnl_mat4 *transforms,
                                             uint32_t count) {
    TRY(check_handle(__func__, "scene", scene));
    if (count == 0) return FNL_OK;
    TRY(check_pointer(CALL(&scene->host), "instances", instances));
    TRY(check_pointer(CALL(&scene->host), "transforms", transforms));
    for (uint32_t i = 0; i < count; i++) {
        TRY(scene_check_instance(CALL_ELEMENT(&scene->host, i, count), scene, instances[i]));
        TRY(scene_check_affine(CALL_ELEMENT(&scene->host, i, count), &transforms[i]));
    }
    scene_move_nodes(scene, instances, transforms, count);
    return FNL_OK;
}

fnl_result fnl_scene_set_instance_visible(fnl_scene *scene, fnl_instance_id instance, bool visible) {
    TRY(check_handle(__func__, "scene", scene));
    TRY(scene_check_instance(CALL(&scene->host), scene, instance));
    scene_show_node(scene, instance.index, visible);
    return FNL_OK;
}

fnl_result fnl_scene_remove_instance(fnl_scene *scene, fnl_instance_id instance) {
    TRY(check_handle(__func__, "scene", scene));
    TRY(scene_check_instance(CALL(&scene->host), scene, instance));
    return scene_remove_node(scene, instance.index);
}
