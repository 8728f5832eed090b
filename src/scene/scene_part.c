/* SPDX-License-Identifier: MIT */
/* Unloading files that were loaded into a scene, after their roots were removed. */
#include "scene/scene.h"

unsigned char *scene_keep_bytes(fnl_scene *scene, size_t size) {
    unsigned char *bytes = host_allocate(&scene->host, MAX(size, 1u));
    const struct file_view file = {.data = bytes, .size = MAX(size, 1u)};
    if (bytes && array_push(&scene->host, &scene->files, file)) return bytes;
    host_free(&scene->host, bytes, file.size);
    return NULL;
}

static bool is_in(const struct range *block, uint32_t index) { return index - block->first < block->count; }

/* ---- users outside the file ---- */

static bool primitive_uses(const struct scene_primitive *p, const struct range *materials) {
    for (uint32_t i = 0; i < p->mapping_count; i++)
        if (is_in(materials, p->mappings[i].material)) return true;
    return is_in(materials, p->material) || is_in(materials, p->standard_material);
}

static bool decal_uses(const fnl_decal_params *p, const struct range *images) {
    const fnl_image_id ids[] = {p->color_image, p->normal_image, p->metallic_roughness_image, p->emissive_image};
    for (uint32_t i = 0; i < COUNT_OF(ids); i++)
        if (is_in(images, decal_image(ids[i]))) return true;
    return false;
}

/* Called when all instances and lights of the part are gone. */
static bool is_used(const fnl_scene *scene, const struct scene_part *part) {
    const struct range *meshes = &part->blocks[SCENE_MESHES], *materials = &part->blocks[SCENE_MATERIALS], *images = &part->blocks[SCENE_IMAGES];
    for (uint32_t i = 0; i < scene->nodes.count; i++)
        if (!scene->nodes.data[i].removed && is_in(meshes, scene->nodes.data[i].mesh)) return true;
    for (uint32_t i = 0; i < scene->painted.count; i++)
        if (is_in(meshes, scene->painted.data[i].mesh)) return true;
    for (uint32_t i = 0; i < scene->primitives.count; i++)
        if (!is_in(&part->blocks[SCENE_PRIMITIVES], i) && primitive_uses(&scene->primitives.data[i], materials)) return true;
    for (uint32_t i = 0; i < scene->materials.count; i++)
        for (int slot = 0; slot < SCENE_TEXTURE_SLOT_COUNT && !is_in(materials, i); slot++)
            if (is_in(images, scene->materials.data[i].textures[slot].image)) return true;
    for (uint32_t i = 0; i < scene->decals.count; i++)
        if (decal_exists(scene, &scene->decals.data[i]) && decal_uses(&scene->decals.data[i].params, images)) return true;
    for (uint32_t i = 0; i < scene->lights.count; i++) {
        const struct scene_light *light = &scene->lights.data[i];
        if (!light->removed && light->params.profile.generation && is_in(&part->blocks[SCENE_PROFILES], light->params.profile.index)) return true;
    }
    return false;
}

/* ---- closing: removes what only the file itself uses ---- */

#define EACH(part, pool, i) (uint32_t i = (part)->blocks[pool].first; i < (part)->blocks[pool].first + (part)->blocks[pool].count; i++)

static void close_part(fnl_scene *scene, struct scene_part *part) {
    part->closed = true;
    for EACH(part, SCENE_CAMERAS, i)
        if (!scene->cameras.data[i].removed) scene_remove_camera(scene, i);
    for EACH(part, SCENE_ANIMATIONS, i)
        if (!scene->animations.data[i].removed) scene_remove_animation(scene, i);
    for EACH(part, SCENE_DECALS, i)
        if (!scene->decals.data[i].removed) scene_remove_decal(scene, i);
    for EACH(part, SCENE_PROBES, i)
        if (!scene->probes.data[i].removed) scene_remove_probe(scene, i);
    for EACH(part, SCENE_LIGHTS, i)
        if (!scene->lights.data[i].removed) scene_remove_light(scene, i);
    for EACH(part, SCENE_SKINS, i) {
        scene->skins.data[i] = (struct scene_skin){.name = ""};
        scene_leave_hole(scene, SCENE_SKINS, i);
    }
    uint32_t kept = 0;
    for (uint32_t i = 0; i < scene->levels.count; i++)
        if (!is_in(&part->blocks[SCENE_NODES], scene->levels.data[i].nodes[0])) scene->levels.data[kept++] = scene->levels.data[i];
    scene->levels.count = kept;
}

/* ---- freeing ---- */

/* Removes a run from an array and closes the gap. Only parts refer to these arrays by index. */
#define CUT(array, member)                                                                                                  \
    do {                                                                                                                    \
        const struct range cut = part.member;                                                                               \
        const uint32_t behind = scene->array.count - cut.first - cut.count;                                                 \
        if (behind) memmove(scene->array.data + cut.first, scene->array.data + cut.first + cut.count, behind * sizeof *scene->array.data); \
        scene->array.count -= cut.count;                                                                                    \
        for (uint32_t p = 0; p < scene->parts.count; p++)                                                                   \
            if (scene->parts.data[p].member.first > cut.first) scene->parts.data[p].member.first -= cut.count;              \
    } while (0)

static void free_files(fnl_scene *scene, struct scene_part part) {
    for (uint32_t i = part.files.first; i < part.files.first + part.files.count; i++) file_free(&scene->host, &scene->files.data[i]);
    for (uint32_t i = part.resources.first; i < part.resources.first + part.resources.count; i++) {
        const fnl_resource *resource = &scene->resources.data[i];
        if (resource->release) resource->release(resource->user, resource->data, resource->size);
    }
    CUT(files, files);
    CUT(resources, resources);
    CUT(sources, sources);
    CUT(messages, messages);
    CUT(packets, packets);
}

/* Nothing outside the part uses it. */
static void free_part(fnl_scene *scene, uint32_t index) {
    struct scene_part part = scene->parts.data[index];
    for EACH(&part, SCENE_MESHES, i)
        if (!scene->meshes.data[i].removed) scene_remove_mesh(scene, i);
    for EACH(&part, SCENE_MATERIALS, i)
        if (!scene->materials.data[i].removed) scene_remove_material(scene, i);
    for EACH(&part, SCENE_IMAGES, i)
        if (!scene->images.data[i].removed) scene_remove_image(scene, i);
    for EACH(&part, SCENE_PROFILES, i)
        if (scene->profiles.data[i].generation) scene_remove_profile(scene, i);
    for EACH(&part, SCENE_VARIANTS, i) {
        scene->variants.data[i] = (struct scene_variant){.name = "", .removed = true};
        scene_leave_hole(scene, SCENE_VARIANTS, i);
    }
    for EACH(&part, SCENE_SAMPLERS, i) {
        scene->samplers.data[i] = scene->samplers.data[0];
        scene_leave_hole(scene, SCENE_SAMPLERS, i);
    }
    for EACH(&part, SCENE_NODES, i) {
        scene->nodes.data[i].name = "";
        scene->nodes.data[i].extras = NULL;
        scene->nodes.data[i].instances = NULL;
    }
    for EACH(&part, SCENE_LIGHTS, i) scene->lights.data[i].name = scene->lights.data[i].extras = NULL;
    scene->parts.data[index] = scene->parts.data[--scene->parts.count];
    for (uint32_t pool = 0; pool < SCENE_POOLS; pool++) ranges_give(&scene->host, &scene->holes[pool], part.blocks[pool].first, part.blocks[pool].count);
    free_files(scene, part);
    arena_finish(&part.arena);
}

/* Removes the images of a closed part that nothing uses, while the part itself is still in use. */
static void free_images(fnl_scene *scene, const struct scene_part *part) {
    bool *used = host_allocate_zero(&scene->host, MAX(scene->images.count, 1u)), *shown = host_allocate_zero(&scene->host, MAX(scene->meshes.count, 1u)),
         *worn = host_allocate_zero(&scene->host, MAX(scene->materials.count, 1u));
    for (uint32_t i = 0; i < scene->nodes.count && shown; i++)
        if (!scene->nodes.data[i].removed && scene->nodes.data[i].mesh != SCENE_NONE) shown[scene->nodes.data[i].mesh] = true;
    for (uint32_t i = 0; i < scene->painted.count && shown; i++) shown[scene->painted.data[i].mesh] = true;
    for (uint32_t i = 0; i < scene->meshes.count && shown && worn; i++)
        for (uint32_t k = 0; k < scene->meshes.data[i].primitive_count && (shown[i] || !is_in(&part->blocks[SCENE_MESHES], i)); k++) {
            const struct scene_primitive *p = &scene->primitives.data[scene->meshes.data[i].first_primitive + k];
            if (p->material != SCENE_NONE) worn[p->material] = true;
            if (p->standard_material != SCENE_NONE) worn[p->standard_material] = true;
            for (uint32_t m = 0; m < p->mapping_count; m++) worn[p->mappings[m].material] = true;
        }
    for (uint32_t i = 0; i < scene->materials.count && used && worn; i++)
        for (int slot = 0; slot < SCENE_TEXTURE_SLOT_COUNT && (worn[i] || !is_in(&part->blocks[SCENE_MATERIALS], i)); slot++)
            if (scene->materials.data[i].textures[slot].image != SCENE_NONE) used[scene->materials.data[i].textures[slot].image] = true;
    for EACH(part, SCENE_IMAGES, i)
        if (used && shown && worn && !used[i] && !scene->images.data[i].removed) {
            bool painted = false;
            for (uint32_t k = 0; k < scene->decals.count; k++)
                painted = painted || (decal_exists(scene, &scene->decals.data[k]) && decal_uses(&scene->decals.data[k].params, &(struct range){i, 1}));
            if (painted) continue;
            for EACH(part, SCENE_MATERIALS, m)
                for (int slot = 0; slot < SCENE_TEXTURE_SLOT_COUNT; slot++)
                    if (scene->materials.data[m].textures[slot].image == i) scene->materials.data[m].textures[slot] = scene_texture_none();
            scene_remove_image(scene, i);
        }
    host_free(&scene->host, used, MAX(scene->images.count, 1u));
    host_free(&scene->host, shown, MAX(scene->meshes.count, 1u));
    host_free(&scene->host, worn, MAX(scene->materials.count, 1u));
}

void scene_drop_parts(fnl_scene *scene) {
    for (uint32_t i = scene->parts.count; i > 0; i--) {
        struct scene_part *part = &scene->parts.data[i - 1];
        const struct scene_node *root = &scene->nodes.data[part->root];
        if (!root->removed && root->generation == part->generation) continue;
        if (!part->closed) close_part(scene, part);
        if (is_used(scene, part) || atomic_load(&scene->readers) > 0) /* images are still being decoded in the background */
            free_images(scene, part);
        else
            free_part(scene, i - 1);
    }
}
