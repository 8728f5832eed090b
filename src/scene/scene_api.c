/* SPDX-License-Identifier: MIT */
/* The public calls that fill and ask a scene, but for loading (scene_load.c), cameras (scene_camera.c), lights (light.c), meshes (scene_mesh.c)
   and time (animation.c). */
#include "base/check.h"
#include "image/image.h"
#include "scene/layer_rows.h"

fnl_result fnl_scene_create(const fnl_host *host, fnl_scene **out) {
    fnl_host resolved = host_resolve(host);
    TRY(check_pointer(CALL(&resolved), "out", out));
    return scene_create(host, "scene", out);
}

/* ---- images and materials ---- */

fnl_result fnl_scene_add_image(fnl_scene *scene, const fnl_image *image, bool color, fnl_image_id *out) {
    TRY(check_handle(__func__, "scene", scene));
    TRY(check_pointer(CALL(&scene->host), "out", out));
    *out = (fnl_image_id){0};
    const struct call *call = CALL(&scene->host);
    TRY(check_pointer(call, "image", image));
    if (image->format != FNL_PIXEL_FORMAT_RGBA8)
        return misuse(call, "image.format is %d, must be FNL_PIXEL_FORMAT_RGBA8 (%d)", (int)image->format,
                      FNL_PIXEL_FORMAT_RGBA8);
    TRY(check_count(call, "image.width", image->width, 1, IMAGE_SIDE_MAX));
    TRY(check_count(call, "image.height", image->height, 1, IMAGE_SIDE_MAX));
    TRY(check_pointer(call, "image.pixels", image->pixels));
    struct scene_image copy;
    if (!scene_image_create(scene, "image", image->width, image->height, color, &copy)) return FNL_ERROR_MEMORY;
    memcpy(copy.pixels, image->pixels, (size_t)image->width * image->height * 4);
    const uint32_t index = scene_add_image(scene, &copy);
    if (index == SCENE_NONE) return FNL_ERROR_MEMORY;
    *out = scene_image_id(scene, index);
    return FNL_OK;
}

/* Without textures or a name. */
static struct scene_material material_of(const fnl_material_params *p) {
    struct scene_material material = {0};
    for (int i = 0; i < SCENE_TEXTURE_SLOT_COUNT; i++) {
        material.textures[i] = scene_texture_none();
        material.parts.turns[i] = (struct scene_texture_turn){.scale = {1, 1}};
    }
    material.base_color = vec4_make(p->base_color[0], p->base_color[1], p->base_color[2], p->base_color[3]);
    material.metallic = p->metallic;
    material.roughness = p->roughness;
    material.normal_scale = p->normal_scale;
    material.occlusion_strength = p->occlusion_strength;
    material.emissive = material.parts.emissive = vec3_make(p->emissive[0], p->emissive[1], p->emissive[2]);
    material.parts.emissive_strength = 1;
    material.ior = p->ior;
    material.specular = p->specular;
    material.specular_color = vec3_make(p->specular_color[0], p->specular_color[1], p->specular_color[2]);
    material.alpha_mode = p->alpha_mode;
    material.alpha_cutoff = p->alpha_cutoff;
    material.double_sided = p->double_sided;
    material.unlit = p->unlit;
    material.casts_shadows = p->casts_shadows;
    layers_from_params(&material, p);
    return material;
}

bool scene_material_transmissive(const struct scene_material *m) { return !m->unlit && m->transmission.strength > 0; }

bool scene_material_dark(const struct scene_material *m) {
    const float least = m->textures[SCENE_TEXTURE_TRANSMISSION].image == SCENE_NONE ? m->transmission.strength * (1 - m->metallic) : 0;
    return scene_material_transmissive(m) && least < 0.5f;
}

struct scene_material scene_material_default(void) {
    fnl_material_params params = fnl_material_params_default();
    return material_of(&params);
}

/* The images of a material, by their slots. */
static const struct image_row {
    enum scene_texture_slot slot;
    const char *name;
    size_t offset;
} image_rows[] = {
#define ROW(slot, member) {SCENE_TEXTURE_##slot, #member, offsetof(fnl_material_params, member)}
    ROW(BASE_COLOR, base_color_image),
    ROW(METALLIC_ROUGHNESS, metallic_roughness_image),
    ROW(NORMAL, normal_image),
    ROW(OCCLUSION, occlusion_image),
    ROW(EMISSIVE, emissive_image),
#define LAYER_ROW(slot, member, ...) ROW(slot, member),
    MATERIAL_LAYER_TEXTURES(LAYER_ROW)
#undef LAYER_ROW
#undef ROW
};

static fnl_image_id image_of_row(const fnl_material_params *p, const struct image_row *row) {
    return *(const fnl_image_id *)(const void *)((const char *)p + row->offset);
}

static fnl_result check_material(const struct call *call, const fnl_scene *scene, const fnl_material_params *p) {
    const double infinite = (double)FLT_MAX;
    TRY(check_floats(call, "base_color", p->base_color, 4, 0, 1, ""));
    TRY(check_range(call, "metallic", (double)p->metallic, 0, 1, ""));
    TRY(check_range(call, "roughness", (double)p->roughness, 0, 1, ""));
    TRY(check_floats(call, "emissive", p->emissive, 3, 0, infinite, " cd/m^2"));
    TRY(check_range(call, "normal_scale", (double)p->normal_scale, -infinite, infinite, ""));
    TRY(check_range(call, "occlusion_strength", (double)p->occlusion_strength, 0, 1, ""));
    if (p->ior != 0 && !(p->ior >= 1 && isfinite(p->ior)))
        return misuse(call, "ior is %g, must be 0, or at least 1 and finite", (double)p->ior);
    TRY(check_range(call, "specular", (double)p->specular, 0, 1, ""));
    TRY(check_floats(call, "specular_color", p->specular_color, 3, 0, infinite, ""));
    TRY(check_enum(call, "alpha_mode", (int)p->alpha_mode, FNL_ALPHA_BLEND + 1, "fnl_alpha_mode"));
    TRY(check_range(call, "alpha_cutoff", (double)p->alpha_cutoff, 0, infinite, ""));
    for (size_t i = 0; i < COUNT_OF(image_rows); i++) TRY(scene_check_image(call, scene, image_rows[i].name, image_of_row(p, &image_rows[i]), true));
    return layers_check(call, p);
}

/* The texture of another image starts anew; of the same one its coordinates and filters stay. */
static void change_image(struct scene_texture *texture, fnl_image_id id) {
    uint32_t image = id.generation ? id.index : SCENE_NONE;
    if (texture->image == image) return;
    *texture = scene_texture_none();
    texture->image = image;
}

fnl_result fnl_scene_add_material(fnl_scene *scene, const fnl_material_params *params, fnl_material_id *out) {
    TRY(check_handle(__func__, "scene", scene));
    const struct call *call = CALL(&scene->host);
    TRY(check_pointer(call, "out", out));
    *out = (fnl_material_id){0};
    fnl_material_params defaults = fnl_material_params_default();
    const fnl_material_params *p = params ? params : &defaults;
    TRY(check_material(call, scene, p));
    struct scene_material material = material_of(p);
    material.name = "";
    for (size_t i = 0; i < COUNT_OF(image_rows); i++) change_image(&material.textures[image_rows[i].slot], image_of_row(p, &image_rows[i]));
    uint32_t index = scene_add_material(scene, &material);
    if (index == SCENE_NONE) return FNL_ERROR_MEMORY;
    *out = scene_material_id(scene, index);
    return FNL_OK;
}

/* But for the painted textures. */
fnl_result scene_repaint(fnl_scene *scene, uint32_t material, const struct scene_material *before) {
    for (uint32_t i = 0; i < scene->painted.count; i++) {
        const struct scene_painted *painted = &scene->painted.data[i];
        const struct scene_mesh *source = &scene->meshes.data[painted->mesh], *own = &scene->meshes.data[painted->own_mesh];
        bool uses = false;
        for (uint32_t k = 0; k < source->primitive_count; k++) {
            if (scene->primitives.data[source->first_primitive + k].material != material) continue;
            struct scene_material *copy =
                &scene->materials.data[scene->primitives.data[own->first_primitive + k].material];
            struct scene_material fresh = scene->materials.data[material];
            for (int slot = 0; slot < SCENE_TEXTURE_SLOT_COUNT; slot++) /* what was painted on is still the same */
                if (fresh.textures[slot].image == before->textures[slot].image) fresh.textures[slot].image = copy->textures[slot].image;
            fresh.generation = copy->generation;
            *copy = fresh;
            uses = true;
        }
        if (uses && !scene->nodes.data[painted->node].removed) TRY(decal_bake(scene, painted->node));
    }
    return FNL_OK;
}

fnl_result fnl_scene_set_material(fnl_scene *scene, fnl_material_id id, const fnl_material_params *p) {
    TRY(check_handle(__func__, "scene", scene));
    const struct call *call = CALL(&scene->host);
    TRY(scene_check_material(call, scene, id, false));
    TRY(check_pointer(call, "params", p));
    TRY(check_material(call, scene, p));
    const struct scene_material before = scene->materials.data[id.index];
    struct scene_material changed = material_of(p);
    changed.name = before.name;
    changed.extras = before.extras;
    changed.generation = before.generation;
    memcpy(changed.textures, before.textures, sizeof changed.textures);
    changed.parts = before.parts;
    memcpy(changed.tangent_frame, before.tangent_frame, sizeof changed.tangent_frame);
    for (size_t i = 0; i < COUNT_OF(image_rows); i++) change_image(&changed.textures[image_rows[i].slot], image_of_row(p, &image_rows[i]));
    scene->materials.data[id.index] = changed;
    scene_materials_changed(scene);
    return scene_repaint(scene, id.index, &before);
}

fnl_result fnl_scene_query_material(const fnl_scene *scene, uint32_t index, fnl_material_params *out) {
    TRY(check_handle(__func__, "scene", scene));
    TRY(check_pointer(CALL(&scene->host), "out", out));
    TRY(check_index(CALL(&scene->host), "index", index, scene_entity_count(scene, FNL_ENTITY_MATERIAL), "materials"));
    const struct scene_material *m = &scene->materials.data[scene_entity_slot(scene, FNL_ENTITY_MATERIAL, index)];
    *out = (fnl_material_params){.base_color = {m->base_color.x, m->base_color.y, m->base_color.z, m->base_color.w},
                                 .metallic = m->metallic,
                                 .roughness = m->roughness,
                                 .emissive = {m->emissive.x, m->emissive.y, m->emissive.z},
                                 .normal_scale = m->normal_scale,
                                 .occlusion_strength = m->occlusion_strength,
                                 .ior = m->ior,
                                 .specular = m->specular,
                                 .specular_color = {m->specular_color.x, m->specular_color.y, m->specular_color.z},
                                 .alpha_mode = m->alpha_mode,
                                 .alpha_cutoff = m->alpha_cutoff,
                                 .double_sided = m->double_sided,
                                 .unlit = m->unlit,
                                 .casts_shadows = m->casts_shadows};
    layers_to_params(m, out);
    for (size_t i = 0; i < COUNT_OF(image_rows); i++)
        *(fnl_image_id *)(void *)((char *)out + image_rows[i].offset) = scene_image_id(scene, m->textures[image_rows[i].slot].image);
    return FNL_OK;
}

/* ---- instances ---- */

fnl_result scene_check_affine(const struct call *call, const fnl_mat4 *m) {
    TRY(check_pointer(call, "transform", m));
    TRY(check_floats(call, "transform.m", m->m, 16, -(double)FLT_MAX, (double)FLT_MAX, ""));
    if (m->m[3] != 0 || m->m[7] != 0 || m->m[11] != 0 || m->m[15] != 1)
        return misuse(call, "the last row of transform is %g, %g, %g, %g, must be 0, 0, 0, 1", (double)m->m[3], (double)m->m[7],
                      (double)m->m[11], (double)m->m[15]);
    return FNL_OK;
}

fnl_result fnl_scene_add_instance(fnl_scene *scene, fnl_mesh_id mesh, const fnl_mat4 *transform, fnl_instance_id *out) {
    TRY(check_handle(__func__, "scene", scene));
    TRY(check_pointer(CALL(&scene->host), "out", out));
    *out = (fnl_instance_id){0};
    const struct call *call = CALL(&scene->host);
    TRY(scene_check_mesh(call, scene, mesh));
    TRY(scene_check_affine(call, transform));
    uint32_t index = scene_add_node(scene, "", SCENE_NONE, transform, mesh.index);
    if (index == SCENE_NONE) return FNL_ERROR_MEMORY;
    *out = (fnl_instance_id){index, scene->nodes.data[index].generation};
    return FNL_OK;
}

/* ---- surroundings ---- */

fnl_result fnl_scene_set_ambient(fnl_scene *scene, fnl_vec3 sky, fnl_vec3 ground) {
    TRY(check_handle(__func__, "scene", scene));
    TRY(check_vector(CALL(&scene->host), "sky", sky, 0, (double)FLT_MAX, " cd/m^2"));
    TRY(check_vector(CALL(&scene->host), "ground", ground, 0, (double)FLT_MAX, " cd/m^2"));
    scene->ambient_sky = sky;
    scene->ambient_ground = ground;
    scene->light_version++;
    return FNL_OK;
}

fnl_result fnl_scene_set_background(fnl_scene *scene, fnl_vec3 radiance) {
    TRY(check_handle(__func__, "scene", scene));
    TRY(check_vector(CALL(&scene->host), "radiance", radiance, 0, (double)FLT_MAX, " cd/m^2"));
    scene->background = radiance;
    return FNL_OK;
}

fnl_result fnl_scene_set_anisotropy(fnl_scene *scene, float anisotropy) {
    TRY(check_handle(__func__, "scene", scene));
    TRY(check_range(CALL(&scene->host), "anisotropy", (double)anisotropy, 1, 16, ""));
    if (scene->anisotropy != anisotropy) scene_materials_changed(scene);
    scene->anisotropy = anisotropy;
    return FNL_OK;
}

fnl_result fnl_scene_set_texture_bias(fnl_scene *scene, float levels) {
    TRY(check_handle(__func__, "scene", scene));
    TRY(check_range(CALL(&scene->host), "levels", (double)levels, -16, 16, " levels of detail"));
    if (scene->texture_bias == levels) return FNL_OK;
    scene->texture_bias = levels;
    scene->decal_version++;
    scene_materials_changed(scene);
    return FNL_OK;
}

/* ---- what is in it ---- */

static uint64_t mesh_triangles(const fnl_scene *scene, const struct scene_mesh *mesh) {
    uint64_t count = 0;
    for (uint32_t i = 0; i < mesh->primitive_count; i++) {
        const struct scene_primitive *primitive = &scene->primitives.data[mesh->first_primitive + i];
        if (primitive->topology == SCENE_TOPOLOGY_TRIANGLES) count += primitive->index_count / 3;
    }
    return count;
}

fnl_result fnl_scene_query_info(const fnl_scene *scene, fnl_scene_info *out) {
    TRY(check_handle(__func__, "scene", scene));
    TRY(check_pointer(CALL(&scene->host), "out", out));
    struct box bounds = scene_bounds(scene);
    *out = (fnl_scene_info){
        .mesh_count = scene_entity_count(scene, FNL_ENTITY_MESH),
        .primitive_count = scene->primitives.count - scene->hole_counts[SCENE_PRIMITIVES] - (scene->stage.mesh != SCENE_NONE), /* the floor has one */
        .material_count = scene_entity_count(scene, FNL_ENTITY_MATERIAL),
        .image_count = scene_entity_count(scene, FNL_ENTITY_IMAGE),
        .node_count = scene_entity_count(scene, FNL_ENTITY_INSTANCE),
        .light_count = scene_entity_count(scene, FNL_ENTITY_LIGHT),
        .unlimited_light_count = scene->unlimited.count,
        .light_threshold = scene->unlimited.count ? scene_light_threshold(scene, &bounds) : 0,
        .decal_count = scene_entity_count(scene, FNL_ENTITY_DECAL),
        .probe_count = scene_entity_count(scene, FNL_ENTITY_PROBE),
        .camera_count = scene_entity_count(scene, FNL_ENTITY_CAMERA),
        .animation_count = scene_entity_count(scene, FNL_ENTITY_ANIMATION),
        .skin_count = scene->skins.count - scene->hole_counts[SCENE_SKINS],
        .extension_count = scene->extensions.count,
        .message_count = scene->messages.count,
        .variant_count = scene_entity_count(scene, FNL_ENTITY_VARIANT),
        .has_ambient = scene_has_ambient(scene),
        .has_environment = scene->environment.panorama.width > 0 && !scene->environment.staged,
        .bounds_low = bounds.low,
        .bounds_high = bounds.high,
    };
    for (uint32_t i = 0; i < scene->meshes.count; i++) {
        if (i == scene->stage.mesh) continue;
        const struct scene_mesh *mesh = &scene->meshes.data[i];
        out->unique_triangle_count += mesh_triangles(scene, mesh);
        for (uint32_t k = 0; k < mesh->primitive_count; k++) out->unique_vertex_count += scene->primitives.data[mesh->first_primitive + k].vertex_count;
    }
    for (uint32_t i = 0; i < scene->nodes.count; i++) {
        const struct scene_node *node = &scene->nodes.data[i];
        if (!scene_node_draws(node) || node->staged) continue;
        out->instance_count += node->instance_count;
        out->triangle_count += node->instance_count * mesh_triangles(scene, &scene->meshes.data[node->mesh]);
    }
    for (uint32_t i = 0; i < scene->decals.count; i++)
        if (!scene->decals.data[i].removed) out->decal_kind_counts[scene->decals.data[i].params.kind]++;
    for (uint32_t i = 0; i < scene->lights.count; i++)
        if (!scene->lights.data[i].removed) out->light_kind_counts[scene->lights.data[i].params.kind]++;
    return FNL_OK;
}

fnl_result fnl_scene_query_image(const fnl_scene *scene, uint32_t index, fnl_image_info *out) {
    TRY(check_handle(__func__, "scene", scene));
    TRY(check_pointer(CALL(&scene->host), "out", out));
    TRY(check_index(CALL(&scene->host), "index", index, scene_entity_count(scene, FNL_ENTITY_IMAGE), "images"));
    const struct scene_image *image = &scene->images.data[scene_entity_slot(scene, FNL_ENTITY_IMAGE, index)];
    *out = (fnl_image_info){image->name, image->file_kind, image->width, image->height};
    return FNL_OK;
}

fnl_result fnl_scene_query_animation(const fnl_scene *scene, uint32_t index, fnl_animation_info *out) {
    TRY(check_handle(__func__, "scene", scene));
    TRY(check_pointer(CALL(&scene->host), "out", out));
    TRY(check_index(CALL(&scene->host), "index", index, scene_entity_count(scene, FNL_ENTITY_ANIMATION), "animations"));
    const struct scene_animation *animation = &scene->animations.data[scene_entity_slot(scene, FNL_ENTITY_ANIMATION, index)];
    *out = (fnl_animation_info){animation->name, (double)animation->duration, animation->channel_count};
    return FNL_OK;
}

fnl_result fnl_scene_query_extension(const fnl_scene *scene, uint32_t index, fnl_extension_info *out) {
    TRY(check_handle(__func__, "scene", scene));
    TRY(check_pointer(CALL(&scene->host), "out", out));
    TRY(check_index(CALL(&scene->host), "index", index, scene->extensions.count, "extensions"));
    const struct scene_extension *extension = &scene->extensions.data[index];
    *out = (fnl_extension_info){extension->name, extension->required, extension->treatment};
    return FNL_OK;
}

const char *fnl_scene_message(const fnl_scene *scene, uint32_t index) {
    if (check_handle(__func__, "scene", scene) != FNL_OK) return NULL;
    return index < scene->messages.count ? scene->messages.data[index] : NULL;
}

fnl_result fnl_scene_query_light(const fnl_scene *scene, uint32_t index, fnl_light_params *out) {
    TRY(check_handle(__func__, "scene", scene));
    TRY(check_pointer(CALL(&scene->host), "out", out));
    TRY(check_index(CALL(&scene->host), "index", index, scene_entity_count(scene, FNL_ENTITY_LIGHT), "lights"));
    *out = scene->lights.data[scene_entity_slot(scene, FNL_ENTITY_LIGHT, index)].params;
    return FNL_OK;
}
