/* SPDX-License-Identifier: MIT */
/* Files that were loaded into a scene: when one goes, so do its images that nothing else uses. */
#include "scene/scene.h"

unsigned char *scene_keep_bytes(fnl_scene *scene, size_t size) {
    unsigned char *bytes = host_allocate(&scene->host, MAX(size, 1u));
    const struct file_view file = {.data = bytes, .size = MAX(size, 1u)};
    if (bytes && array_push(&scene->host, &scene->files, file)) return bytes;
    host_free(&scene->host, bytes, file.size);
    return NULL;
}

struct marks {
    bool *meshes, *materials, *images;
};

static bool marks_init(const fnl_scene *scene, struct marks *m) {
    *m = (struct marks){host_allocate_zero(&scene->host, MAX(scene->meshes.count, 1u)), host_allocate_zero(&scene->host, MAX(scene->materials.count, 1u)),
                        host_allocate_zero(&scene->host, MAX(scene->images.count, 1u))};
    return m->meshes && m->materials && m->images;
}

static void marks_finish(const fnl_scene *scene, struct marks *m) {
    host_free(&scene->host, m->meshes, MAX(scene->meshes.count, 1u));
    host_free(&scene->host, m->materials, MAX(scene->materials.count, 1u));
    host_free(&scene->host, m->images, MAX(scene->images.count, 1u));
}

static void mark_material(struct marks *m, uint32_t material) {
    if (material != SCENE_NONE) m->materials[material] = true;
}

/* What instances show, or would without paint or with another variant. */
static void mark_materials(const fnl_scene *scene, struct marks *m) {
    for (uint32_t i = 0; i < scene->nodes.count; i++)
        if (!scene->nodes.data[i].removed && scene->nodes.data[i].mesh != SCENE_NONE) m->meshes[scene->nodes.data[i].mesh] = true;
    for (uint32_t i = 0; i < scene->painted.count; i++)
        if (!scene->nodes.data[scene->painted.data[i].node].removed) m->meshes[scene->painted.data[i].mesh] = true;
    for (uint32_t i = 0; i < scene->meshes.count; i++) {
        const struct scene_mesh *mesh = &scene->meshes.data[i];
        for (uint32_t k = 0; k < mesh->primitive_count && m->meshes[i]; k++) {
            const struct scene_primitive *primitive = &scene->primitives.data[mesh->first_primitive + k];
            mark_material(m, primitive->material);
            mark_material(m, primitive->standard_material);
            for (uint32_t v = 0; v < primitive->mapping_count; v++) mark_material(m, primitive->mappings[v].material);
        }
    }
}

static void mark_images(const fnl_scene *scene, struct marks *m) {
    for (uint32_t i = 0; i < scene->materials.count; i++)
        for (int slot = 0; slot < SCENE_TEXTURE_SLOT_COUNT; slot++) {
            const uint32_t image = scene->materials.data[i].textures[slot].image;
            if (image != SCENE_NONE) m->images[image] = true;
        }
    for (uint32_t i = 0; i < scene->decals.count; i++) {
        const fnl_decal_params *p = &scene->decals.data[i].params;
        const fnl_image_id ids[] = {p->color_image, p->normal_image, p->metallic_roughness_image, p->emissive_image};
        for (uint32_t k = 0; k < COUNT_OF(ids) && decal_exists(scene, &scene->decals.data[i]); k++)
            if (decal_image(ids[k]) != SCENE_NONE) m->images[ids[k].index] = true;
    }
}

static bool is_in(const struct file_view *file, const unsigned char *at) { return at && at >= file->data && at < file->data + file->size; }

static bool holds_images(const fnl_scene *scene, const struct file_view *file) {
    for (uint32_t i = 0; i < scene->images.count; i++)
        if (is_in(file, scene->images.data[i].encoded)) return true;
    return false;
}

static void free_file(fnl_scene *scene, struct file_view *file) {
    for (uint32_t i = 0; i < scene->sources.count; i++)
        if (is_in(file, scene->sources.data[i].data)) scene->sources.data[i].data = NULL;
    file_free(&scene->host, file);
}

static void drop(fnl_scene *scene, const struct scene_part *part) {
    struct marks marks;
    if (marks_init(scene, &marks)) { /* otherwise they stay */
        mark_materials(scene, &marks);
        for (uint32_t i = part->first_material; i < part->first_material + part->material_count; i++)
            for (int slot = 0; slot < SCENE_TEXTURE_SLOT_COUNT && !marks.materials[i]; slot++) scene->materials.data[i].textures[slot] = scene_texture_none();
        mark_images(scene, &marks);
        for (uint32_t i = part->first_image; i < part->first_image + part->image_count; i++) {
            struct scene_image *image = &scene->images.data[i];
            if (marks.images[i]) continue;
            image->encoded = NULL;
            image->pixels = NULL;
            image->encoded_size = image->width = image->height = 0;
            image->version++;
        }
        /* What is being decoded in the background is read until then. */
        for (uint32_t i = part->first_file; i < part->first_file + part->file_count && atomic_load(&scene->readers) == 0; i++)
            if (!holds_images(scene, &scene->files.data[i])) free_file(scene, &scene->files.data[i]);
        scene_materials_changed(scene);
    }
    marks_finish(scene, &marks);
}

void scene_drop_parts(fnl_scene *scene) {
    for (uint32_t i = scene->parts.count; i > 0; i--) {
        const struct scene_part part = scene->parts.data[i - 1];
        const struct scene_node *root = &scene->nodes.data[part.root];
        if (!root->removed && root->generation == part.generation) continue;
        scene->parts.data[i - 1] = scene->parts.data[--scene->parts.count];
        drop(scene, &part);
    }
}
