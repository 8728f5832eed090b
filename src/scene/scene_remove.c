/* SPDX-License-Identifier: MIT */
/* Removing elements of a scene. Each leaves a hole in its array, which a later element may reuse. */
#include "scene/scene.h"

/* ---- holes ---- */

uint32_t scene_take_holes(fnl_scene *scene, enum scene_pool pool, uint32_t count) {
    const uint32_t first = count ? ranges_take(&scene->holes[pool], count) : RANGES_NONE;
    if (first == RANGES_NONE) return SCENE_NONE;
    scene->hole_counts[pool] -= count;
    return first;
}

uint32_t scene_take_element(fnl_scene *scene, enum scene_pool pool, void **data, uint32_t *count, uint32_t *capacity, size_t size) {
    const uint32_t hole = scene_take_holes(scene, pool, 1);
    if (hole != SCENE_NONE) return hole;
    if (*count == SCENE_NONE || !array_reserve_raw(&scene->host, data, capacity, (uint64_t)*count + 1, size)) return SCENE_NONE;
    memset((char *)*data + *count * size, 0, size);
    return (*count)++;
}

bool scene_is_reserved(const fnl_scene *scene, enum scene_pool pool, uint32_t index) {
    if (index < scene->document.counts[pool]) return true;
    for (uint32_t i = 0; i < scene->parts.count; i++) {
        const struct range *block = &scene->parts.data[i].blocks[pool];
        if (index - block->first < block->count) return true;
    }
    return false;
}

void scene_leave_hole(fnl_scene *scene, enum scene_pool pool, uint32_t index) {
    scene->hole_counts[pool]++;
    if (!scene_is_reserved(scene, pool, index)) ranges_give(&scene->host, &scene->holes[pool], index, 1);
}

/* ---- elements ---- */

void scene_remove_mesh(fnl_scene *scene, uint32_t index) {
    struct scene_mesh *mesh = &scene->meshes.data[index];
    for (uint32_t i = mesh->first_primitive; i < mesh->first_primitive + mesh->primitive_count; i++) {
        struct scene_primitive *p = &scene->primitives.data[i];
        arena_finish(&p->memory);
        *p = (struct scene_primitive){.material = SCENE_NONE,
                                      .standard_material = SCENE_NONE,
                                      .bounds = box_empty(),
                                      .version = p->version + 1,
                                      .shape_version = p->shape_version + 1};
        scene_leave_hole(scene, SCENE_PRIMITIVES, i);
    }
    *mesh = (struct scene_mesh){.name = "", .bounds = box_empty(), .generation = mesh->generation, .removed = true};
    scene_leave_hole(scene, SCENE_MESHES, index);
    scene_structure_changed(scene);
}

void scene_remove_material(fnl_scene *scene, uint32_t index) {
    struct scene_material *material = &scene->materials.data[index];
    const uint32_t generation = material->generation;
    *material = scene_material_default();
    material->name = "";
    material->generation = generation;
    material->removed = true;
    scene_leave_hole(scene, SCENE_MATERIALS, index);
    scene_materials_changed(scene);
}

void scene_remove_image(fnl_scene *scene, uint32_t index) {
    struct scene_image *image = &scene->images.data[index];
    host_free(&scene->host, image->memory, image->memory_size);
    *image = (struct scene_image){.name = "", .file_kind = "", .version = image->version + 1, .generation = image->generation, .removed = true};
    scene_leave_hole(scene, SCENE_IMAGES, index);
    scene_materials_changed(scene);
}

void scene_remove_profile(fnl_scene *scene, uint32_t index) {
    struct light_profile *profile = &scene->profiles.data[index];
    ranges_give(&scene->host, &scene->profile_floats, profile->offset, light_profile_floats(profile));
    arena_finish(&profile->memory);
    *profile = (struct light_profile){.name = ""};
    scene_leave_hole(scene, SCENE_PROFILES, index);
    scene->profile_version++;
}

void scene_remove_camera(fnl_scene *scene, uint32_t index) {
    struct scene_camera *camera = &scene->cameras.data[index];
    host_free(&scene->host, camera->own_name, camera->own_name ? strlen(camera->own_name) + 1 : 0);
    *camera = (struct scene_camera){.name = "", .node = SCENE_NONE, .removed = true};
    scene_leave_hole(scene, SCENE_CAMERAS, index);
}

void scene_remove_animation(fnl_scene *scene, uint32_t index) {
    scene->animations.data[index] = (struct scene_animation){.name = "", .removed = true};
    scene_leave_hole(scene, SCENE_ANIMATIONS, index);
}

/* ---- users ---- */

static uint32_t instances_of(const fnl_scene *scene, uint32_t mesh) {
    uint32_t count = 0;
    for (uint32_t i = 0; i < scene->nodes.count; i++) count += !scene->nodes.data[i].removed && scene->nodes.data[i].mesh == mesh;
    for (uint32_t i = 0; i < scene->painted.count; i++) { /* baked decals: the original mesh and its painted copy */
        const struct scene_painted *painted = &scene->painted.data[i];
        const uint32_t shown = scene->nodes.data[painted->node].mesh;
        count += (painted->mesh == mesh || painted->own_mesh == mesh) && shown != mesh;
    }
    return count;
}

static bool primitive_uses(const struct scene_primitive *p, uint32_t material) {
    for (uint32_t i = 0; i < p->mapping_count; i++)
        if (p->mappings[i].material == material) return true;
    return p->material == material || (p->mapping_count && p->standard_material == material);
}

static uint32_t meshes_of(const fnl_scene *scene, uint32_t material) {
    uint32_t count = 0;
    for (uint32_t i = 0; i < scene->meshes.count; i++) {
        const struct scene_mesh *mesh = &scene->meshes.data[i];
        bool uses = false;
        for (uint32_t k = 0; k < mesh->primitive_count; k++) uses = uses || primitive_uses(&scene->primitives.data[mesh->first_primitive + k], material);
        count += uses;
    }
    return count;
}

static bool material_uses(const struct scene_material *material, uint32_t image) {
    for (int slot = 0; slot < SCENE_TEXTURE_SLOT_COUNT; slot++)
        if (material->textures[slot].image == image) return true;
    return false;
}

static bool decal_uses(const fnl_decal_params *p, uint32_t image) {
    return decal_image(p->color_image) == image || decal_image(p->normal_image) == image || decal_image(p->metallic_roughness_image) == image ||
           decal_image(p->emissive_image) == image;
}

static uint32_t users_of_image(const fnl_scene *scene, uint32_t image) {
    uint32_t count = 0;
    for (uint32_t i = 0; i < scene->materials.count; i++) count += material_uses(&scene->materials.data[i], image);
    for (uint32_t i = 0; i < scene->decals.count; i++) count += decal_exists(scene, &scene->decals.data[i]) && decal_uses(&scene->decals.data[i].params, image);
    return count;
}

static uint32_t lights_of(const fnl_scene *scene, uint32_t profile) {
    uint32_t count = 0;
    for (uint32_t i = 0; i < scene->lights.count; i++) {
        const struct scene_light *light = &scene->lights.data[i];
        count += !light->removed && light->params.profile.generation && light->params.profile.index == profile;
    }
    return count;
}

static fnl_result check_unused(const struct call *call, const char *what, uint32_t index, uint32_t count, const char *one, const char *many) {
    return count ? misuse(call, "%s (index %u) is still used by %u %s", what, index, count, count == 1 ? one : many) : FNL_OK;
}

/* ---- calls ---- */

fnl_result fnl_scene_remove_mesh(fnl_scene *scene, fnl_mesh_id mesh) {
    TRY(check_handle(__func__, "scene", scene));
    const struct call *call = CALL(&scene->host);
    TRY(scene_check_mesh(call, scene, mesh));
    TRY(check_unused(call, "mesh", mesh.index, instances_of(scene, mesh.index), "instance", "instances"));
    scene_remove_mesh(scene, mesh.index);
    scene_drop_parts(scene);
    return FNL_OK;
}

fnl_result fnl_scene_remove_material(fnl_scene *scene, fnl_material_id material) {
    TRY(check_handle(__func__, "scene", scene));
    const struct call *call = CALL(&scene->host);
    TRY(scene_check_material(call, scene, material, false));
    TRY(check_unused(call, "material", material.index, meshes_of(scene, material.index), "mesh", "meshes"));
    scene_remove_material(scene, material.index);
    scene_drop_parts(scene);
    return FNL_OK;
}

fnl_result fnl_scene_remove_image(fnl_scene *scene, fnl_image_id image) {
    TRY(check_handle(__func__, "scene", scene));
    const struct call *call = CALL(&scene->host);
    TRY(scene_check_image(call, scene, "image", image, false));
    TRY(check_unused(call, "image", image.index, users_of_image(scene, image.index), "material or decal", "materials and decals"));
    scene_remove_image(scene, image.index);
    scene_drop_parts(scene);
    return FNL_OK;
}

fnl_result fnl_scene_remove_light_profile(fnl_scene *scene, fnl_light_profile_id profile) {
    TRY(check_handle(__func__, "scene", scene));
    const struct call *call = CALL(&scene->host);
    const bool known = profile.generation && profile.index < scene->profiles.count && scene->profiles.data[profile.index].generation == profile.generation;
    TRY(check_id(call, "profile", known, profile.index, profile.generation, "a light profile"));
    TRY(check_unused(call, "profile", profile.index, lights_of(scene, profile.index), "light", "lights"));
    scene_remove_profile(scene, profile.index);
    scene_drop_parts(scene);
    return FNL_OK;
}

fnl_result fnl_scene_remove_camera(fnl_scene *scene, uint32_t index) {
    TRY(check_handle(__func__, "scene", scene));
    TRY(check_index(CALL(&scene->host), "index", index, scene_entity_count(scene, FNL_ENTITY_CAMERA), "cameras"));
    scene_remove_camera(scene, scene_entity_slot(scene, FNL_ENTITY_CAMERA, index));
    return FNL_OK;
}

fnl_result fnl_scene_remove_animation(fnl_scene *scene, uint32_t index) {
    TRY(check_handle(__func__, "scene", scene));
    TRY(check_index(CALL(&scene->host), "index", index, scene_entity_count(scene, FNL_ENTITY_ANIMATION), "animations"));
    scene_remove_animation(scene, scene_entity_slot(scene, FNL_ENTITY_ANIMATION, index));
    return FNL_OK;
}
