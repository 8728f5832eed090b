/* SPDX-License-Identifier: MIT */
/* The public calls of fanal/scene.h that fill and ask a scene, but for cameras (scene_camera.c) and time (animation.c). */
#include "image/image.h"
#include "scene/scene.h"

fnl_result fnl_scene_create(const fnl_host *host, fnl_scene **out) {
    fnl_host resolved = host_resolve(host);
    REQUIRE(&resolved, out != NULL);
    return scene_create(host, "scene", out);
}

fnl_result fnl_scene_load(const fnl_host *host, const char *source, fnl_scene **out) {
    static const char prefix[] = "builtin:";
    fnl_host resolved = host_resolve(host);
    REQUIRE(&resolved, out != NULL);
    *out = NULL;
    REQUIRE(&resolved, source != NULL);
    if (strncmp(source, prefix, sizeof prefix - 1) == 0) return builtin_load(&resolved, source + sizeof prefix - 1, out);
    return gltf_load(&resolved, source, out);
}

static bool all_finite(const float *values, uint64_t count) {
    for (uint64_t i = 0; i < count; i++)
        if (!isfinite(values[i])) return false;
    return true;
}

static bool all_in_range(const float *values, uint32_t count, float low, float high) {
    for (uint32_t i = 0; i < count; i++)
        if (!(values[i] >= low && values[i] <= high)) return false;
    return true;
}

/* ---- images and materials: never removed, so one generation marks them all ---- */

enum { FIXED_GENERATION = 1 };

fnl_result fnl_scene_add_image(fnl_scene *scene, const fnl_image *image, bool color, fnl_image_id *out) {
    if (!scene) return FNL_ERROR_INVALID;
    REQUIRE(&scene->host, out != NULL);
    *out = (fnl_image_id){0};
    REQUIRE(&scene->host, image != NULL);
    REQUIRE(&scene->host, image->format == FNL_PIXEL_FORMAT_RGBA8);
    REQUIRE(&scene->host, image->width > 0 && image->width <= IMAGE_SIDE_MAX);
    REQUIRE(&scene->host, image->height > 0 && image->height <= IMAGE_SIDE_MAX);
    REQUIRE(&scene->host, image->pixels != NULL);
    struct scene_image copy = {
        .name = arena_format(&scene->arena, "%s: image %u", scene->source, scene->images.count),
        .file_kind = "generated",
        .width = image->width,
        .height = image->height,
        .pixels = arena_copy(&scene->arena, image->pixels, (size_t)image->width * image->height * 4),
        .color = color,
    };
    if (!copy.name || !copy.pixels) return FNL_ERROR_MEMORY;
    uint32_t index = scene_add_image(scene, &copy);
    if (index == SCENE_NONE) return FNL_ERROR_MEMORY;
    *out = (fnl_image_id){index, FIXED_GENERATION};
    return FNL_OK;
}

fnl_material_params fnl_material_params_default(void) {
    return (fnl_material_params){
        .base_color = {1, 1, 1, 1},
        .metallic = 1,
        .roughness = 1,
        .normal_scale = 1,
        .occlusion_strength = 1,
        .ior = 1.5f,
        .specular = 1,
        .specular_color = {1, 1, 1},
        .alpha_mode = FNL_ALPHA_OPAQUE,
        .alpha_cutoff = 0.5f,
    };
}

/* Without textures or a name. */
static struct scene_material material_of(const fnl_material_params *p) {
    struct scene_material material = {0};
    for (int i = 0; i < SCENE_TEXTURE_SLOT_COUNT; i++) material.textures[i] = scene_texture_none();
    material.base_color = vec4_make(p->base_color[0], p->base_color[1], p->base_color[2], p->base_color[3]);
    material.metallic = p->metallic;
    material.roughness = p->roughness;
    material.normal_scale = p->normal_scale;
    material.occlusion_strength = p->occlusion_strength;
    material.emissive = vec3_make(p->emissive[0], p->emissive[1], p->emissive[2]);
    material.ior = p->ior;
    material.specular = p->specular;
    material.specular_color = vec3_make(p->specular_color[0], p->specular_color[1], p->specular_color[2]);
    material.alpha_mode = p->alpha_mode;
    material.alpha_cutoff = p->alpha_cutoff;
    material.double_sided = p->double_sided;
    material.unlit = p->unlit;
    return material;
}

struct scene_material scene_material_default(void) {
    fnl_material_params params = fnl_material_params_default();
    return material_of(&params);
}

static bool image_id_valid(const fnl_scene *scene, fnl_image_id id) {
    return (id.index == 0 && id.generation == 0) || (id.generation == FIXED_GENERATION && id.index < scene->images.count);
}

static void set_image(struct scene_material *material, enum scene_texture_slot slot, fnl_image_id id) {
    if (id.generation) material->textures[slot].image = id.index;
}

fnl_result fnl_scene_add_material(fnl_scene *scene, const fnl_material_params *params, fnl_material_id *out) {
    if (!scene) return FNL_ERROR_INVALID;
    const fnl_host *host = &scene->host;
    REQUIRE(host, out != NULL);
    *out = (fnl_material_id){0};
    fnl_material_params defaults = fnl_material_params_default();
    const fnl_material_params *p = params ? params : &defaults;
    REQUIRE(host, all_in_range(p->base_color, 4, 0, 1));
    REQUIRE(host, p->metallic >= 0 && p->metallic <= 1);
    REQUIRE(host, p->roughness >= 0 && p->roughness <= 1);
    REQUIRE(host, all_in_range(p->emissive, 3, 0, FLT_MAX));
    REQUIRE(host, isfinite(p->normal_scale));
    REQUIRE(host, p->occlusion_strength >= 0 && p->occlusion_strength <= 1);
    REQUIRE(host, p->ior == 0 || (p->ior >= 1 && isfinite(p->ior)));
    REQUIRE(host, p->specular >= 0 && p->specular <= 1);
    REQUIRE(host, all_in_range(p->specular_color, 3, 0, FLT_MAX));
    REQUIRE(host, p->alpha_mode >= FNL_ALPHA_OPAQUE && p->alpha_mode <= FNL_ALPHA_BLEND);
    REQUIRE(host, p->alpha_cutoff >= 0 && isfinite(p->alpha_cutoff));
    REQUIRE(host, image_id_valid(scene, p->base_color_image));
    REQUIRE(host, image_id_valid(scene, p->metallic_roughness_image));
    REQUIRE(host, image_id_valid(scene, p->normal_image));
    REQUIRE(host, image_id_valid(scene, p->occlusion_image));
    REQUIRE(host, image_id_valid(scene, p->emissive_image));

    struct scene_material material = material_of(p);
    material.name = "";
    set_image(&material, SCENE_TEXTURE_BASE_COLOR, p->base_color_image);
    set_image(&material, SCENE_TEXTURE_METALLIC_ROUGHNESS, p->metallic_roughness_image);
    set_image(&material, SCENE_TEXTURE_NORMAL, p->normal_image);
    set_image(&material, SCENE_TEXTURE_OCCLUSION, p->occlusion_image);
    set_image(&material, SCENE_TEXTURE_EMISSIVE, p->emissive_image);
    uint32_t index = scene_add_material(scene, &material);
    if (index == SCENE_NONE) return FNL_ERROR_MEMORY;
    *out = (fnl_material_id){index, FIXED_GENERATION};
    return FNL_OK;
}

/* ---- meshes and instances ---- */

static bool indices_below(const uint32_t *indices, uint32_t count, uint32_t limit) {
    for (uint32_t i = 0; i < count; i++)
        if (indices[i] >= limit) return false;
    return true;
}

/** A copy of an optional array; `failed` is set when memory ran out. */
static const void *copy_optional(struct arena *arena, const void *data, uint64_t size, bool *failed) {
    if (!data) return NULL;
    void *copy = arena_copy(arena, data, (size_t)size);
    if (!copy) *failed = true;
    return copy;
}

fnl_result fnl_scene_add_mesh(fnl_scene *scene, const fnl_mesh_params *params, fnl_mesh_id *out) {
    if (!scene) return FNL_ERROR_INVALID;
    const fnl_host *host = &scene->host;
    REQUIRE(host, out != NULL);
    *out = (fnl_mesh_id){0};
    REQUIRE(host, params != NULL);
    const fnl_mesh_params *p = params;
    uint64_t count = p->vertex_count;
    REQUIRE(host, p->vertex_count > 0 && p->vertex_count < UINT32_MAX);
    REQUIRE(host, p->positions != NULL);
    REQUIRE(host, (p->indices != NULL) == (p->index_count > 0));
    REQUIRE(host, (p->indices ? p->index_count : p->vertex_count) % 3 == 0);
    REQUIRE(host, !p->indices || indices_below(p->indices, p->index_count, p->vertex_count));
    REQUIRE(host, all_finite(p->positions, count * 3));
    REQUIRE(host, !p->normals || all_finite(p->normals, count * 3));
    REQUIRE(host, !p->tangents || all_finite(p->tangents, count * 4));
    REQUIRE(host, !p->uv || all_finite(p->uv, count * 2));
    REQUIRE(host, !p->colors || all_finite(p->colors, count * 4));
    REQUIRE(host, p->material.generation == 0
                      ? p->material.index == 0
                      : p->material.generation == FIXED_GENERATION && p->material.index < scene->materials.count);
    bool failed = false;
    struct arena *arena = &scene->arena;
    struct scene_primitive primitive = {
        .material = p->material.generation ? p->material.index : SCENE_NONE,
        .topology = SCENE_TOPOLOGY_TRIANGLES,
        .vertex_count = p->vertex_count,
        .index_count = p->index_count,
        .indices = copy_optional(arena, p->indices, (uint64_t)p->index_count * 4, &failed),
        .positions = copy_optional(arena, p->positions, count * sizeof(vec3), &failed),
        .normals = copy_optional(arena, p->normals, count * sizeof(vec3), &failed),
        .tangents = copy_optional(arena, p->tangents, count * sizeof(vec4), &failed),
        .uv = {copy_optional(arena, p->uv, count * sizeof(vec2), &failed)},
        .colors = copy_optional(arena, p->colors, count * sizeof(vec4), &failed),
    };
    if (failed) return FNL_ERROR_MEMORY;
    TRY(mesh_complete(arena, &primitive));
    uint32_t index = scene_add_mesh(scene, "", &primitive, 1);
    if (index == SCENE_NONE) return FNL_ERROR_MEMORY;
    *out = (fnl_mesh_id){index, FIXED_GENERATION};
    return FNL_OK;
}

static bool is_affine(const fnl_mat4 *m) {
    return m && all_finite(m->m, 16) && m->m[3] == 0 && m->m[7] == 0 && m->m[11] == 0 && m->m[15] == 1;
}

static bool instance_alive(const fnl_scene *scene, fnl_instance_id id) {
    if (id.generation == 0 || id.index >= scene->nodes.count) return false;
    const struct scene_node *node = &scene->nodes.data[id.index];
    return node->generation == id.generation && !node->removed;
}

fnl_result fnl_scene_add_instance(fnl_scene *scene, fnl_mesh_id mesh, const fnl_mat4 *transform, fnl_instance_id *out) {
    if (!scene) return FNL_ERROR_INVALID;
    REQUIRE(&scene->host, out != NULL);
    *out = (fnl_instance_id){0};
    REQUIRE(&scene->host, mesh.generation == FIXED_GENERATION && mesh.index < scene->meshes.count);
    REQUIRE(&scene->host, is_affine(transform));
    uint32_t index = scene_add_node(scene, "", SCENE_NONE, transform, mesh.index);
    if (index == SCENE_NONE) return FNL_ERROR_MEMORY;
    *out = (fnl_instance_id){index, scene->nodes.data[index].generation};
    return FNL_OK;
}

fnl_result fnl_scene_set_instance_transform(fnl_scene *scene, fnl_instance_id instance, const fnl_mat4 *transform) {
    if (!scene) return FNL_ERROR_INVALID;
    REQUIRE(&scene->host, instance_alive(scene, instance));
    REQUIRE(&scene->host, is_affine(transform));
    scene_move_node(scene, instance.index, transform);
    return FNL_OK;
}

fnl_result fnl_scene_remove_instance(fnl_scene *scene, fnl_instance_id instance) {
    if (!scene) return FNL_ERROR_INVALID;
    REQUIRE(&scene->host, instance_alive(scene, instance));
    if (!array_push(&scene->host, &scene->free_nodes, instance.index)) return FNL_ERROR_MEMORY;
    struct scene_node *node = &scene->nodes.data[instance.index];
    node->removed = true;
    node->active = false;
    node->mesh = SCENE_NONE;
    scene->structure_version++;
    return FNL_OK;
}

/* ---- lights ---- */

fnl_light_params fnl_light_params_default(void) {
    return (fnl_light_params){
        .kind = FNL_LIGHT_POINT,
        .direction = {0, 0, -1},
        .color = {1, 1, 1},
        .intensity = 1,
        .range = INFINITY,
        .inner_cone_angle = 0,
        .outer_cone_angle = PI / 4,
        .up = {0, 1, 0},
        .length = 1,
        .wedge_angles = {PI / 4, PI / 6},
        .box_size = {1, 1, 1},
        .inner_fraction = 0.7f,
    };
}

/** Checks a light's parameters and makes direction and up unit vectors at right angles. */
static fnl_result check_light(const fnl_host *host, const fnl_light_params *params, fnl_light_params *out) {
    REQUIRE(host, params != NULL);
    REQUIRE(host, params->kind >= FNL_LIGHT_DIRECTIONAL && params->kind < FNL_LIGHT_KIND_COUNT);
    REQUIRE(host, vec3_finite(params->position));
    REQUIRE(host, vec3_finite(params->direction));
    REQUIRE(host, params->kind == FNL_LIGHT_POINT || vec3_length(params->direction) > 0);
    REQUIRE(host, all_in_range(params->color, 3, 0, FLT_MAX));
    REQUIRE(host, params->intensity >= 0 && isfinite(params->intensity));
    REQUIRE(host, params->kind == FNL_LIGHT_DIRECTIONAL || params->kind == FNL_LIGHT_BOX || params->range > 0);
    if (params->kind == FNL_LIGHT_SPOT) {
        REQUIRE(host, params->outer_cone_angle > 0 && params->outer_cone_angle <= PI / 2 + 1e-6f);
        REQUIRE(host, params->inner_cone_angle >= 0 && params->inner_cone_angle <= params->outer_cone_angle);
    }
    if (params->kind == FNL_LIGHT_CAPSULE) REQUIRE(host, params->length >= 0 && isfinite(params->length));
    if (params->kind == FNL_LIGHT_WEDGE) {
        REQUIRE(host, params->wedge_angles[0] > 0 && params->wedge_angles[0] <= 1.5f);
        REQUIRE(host, params->wedge_angles[1] > 0 && params->wedge_angles[1] <= 1.5f);
    }
    if (params->kind == FNL_LIGHT_BOX)
        REQUIRE(host, all_in_range(&params->box_size.x, 3, FLT_MIN, 1e18f)); /* the square of the diagonal stays finite */
    if (params->kind == FNL_LIGHT_WEDGE || params->kind == FNL_LIGHT_BOX) {
        REQUIRE(host, vec3_finite(params->up));
        REQUIRE(host, params->inner_fraction >= 0 && params->inner_fraction <= 1);
    }
    *out = *params;
    out->direction = vec3_normalize(params->direction);
    out->up = light_up(out->direction, params->up);
    return FNL_OK;
}

fnl_result fnl_scene_add_light(fnl_scene *scene, const fnl_light_params *params, fnl_light_id *out) {
    if (!scene) return FNL_ERROR_INVALID;
    REQUIRE(&scene->host, out != NULL);
    *out = (fnl_light_id){0};
    fnl_light_params checked;
    TRY(check_light(&scene->host, params, &checked));
    uint32_t index = scene_add_light(scene, &checked, SCENE_NONE);
    if (index == SCENE_NONE) return FNL_ERROR_MEMORY;
    *out = (fnl_light_id){index, scene->lights.data[index].generation};
    return FNL_OK;
}

static bool light_alive(const fnl_scene *scene, fnl_light_id id) {
    if (id.generation == 0 || id.index >= scene->lights.count) return false;
    const struct scene_light *light = &scene->lights.data[id.index];
    return light->generation == id.generation && !light->removed;
}

fnl_result fnl_scene_set_light(fnl_scene *scene, fnl_light_id light, const fnl_light_params *params) {
    if (!scene) return FNL_ERROR_INVALID;
    REQUIRE(&scene->host, light_alive(scene, light));
    fnl_light_params checked;
    TRY(check_light(&scene->host, params, &checked));
    fnl_light_params *changed = &scene->lights.data[light.index].params;
    bool stays = (changed->kind == FNL_LIGHT_DIRECTIONAL) == (checked.kind == FNL_LIGHT_DIRECTIONAL);
    *changed = checked;
    if (stays)
        scene_light_changed(scene, light.index);
    else
        scene_lights_changed(scene);
    return FNL_OK;
}

fnl_result fnl_scene_remove_light(fnl_scene *scene, fnl_light_id light) {
    if (!scene) return FNL_ERROR_INVALID;
    REQUIRE(&scene->host, light_alive(scene, light));
    if (!array_push(&scene->host, &scene->free_lights, light.index)) return FNL_ERROR_MEMORY;
    light_hull_free(scene, &scene->lights.data[light.index]);
    scene->lights.data[light.index].removed = true;
    scene_lights_changed(scene);
    return FNL_OK;
}

fnl_result fnl_scene_set_light_hull(fnl_scene *scene, fnl_light_id light, const fnl_vec3 *points, uint32_t count) {
    if (!scene) return FNL_ERROR_INVALID;
    REQUIRE(&scene->host, light_alive(scene, light));
    REQUIRE(&scene->host, (points != NULL) == (count > 0));
    struct scene_light *target = &scene->lights.data[light.index];
    if (!points) {
        light_hull_free(scene, target);
        scene_lights_changed(scene);
        return FNL_OK;
    }
    REQUIRE(&scene->host, count >= 4 && count <= LIGHT_HULL_POINTS_MAX);
    REQUIRE(&scene->host, all_finite(&points->x, count * 3ull));
    struct light_hull *hull;
    TRY(light_hull_create(&scene->host, points, count, &hull));
    light_hull_free(scene, target);
    target->hull = hull;
    scene->hull_plane_count += hull->plane_count;
    scene_lights_changed(scene);
    return FNL_OK;
}

fnl_result fnl_scene_set_light_cutoff(fnl_scene *scene, float min_roughness, float threshold) {
    if (!scene) return FNL_ERROR_INVALID;
    REQUIRE(&scene->host, min_roughness >= 0 && min_roughness <= 1);
    REQUIRE(&scene->host, threshold > 0 && isfinite(threshold));
    scene->cutoff_roughness = min_roughness;
    scene->cutoff_illuminance = threshold;
    scene_lights_changed(scene);
    return FNL_OK;
}

fnl_result fnl_scene_set_ambient(fnl_scene *scene, fnl_vec3 sky, fnl_vec3 ground) {
    if (!scene) return FNL_ERROR_INVALID;
    REQUIRE(&scene->host, all_in_range(&sky.x, 3, 0, FLT_MAX));
    REQUIRE(&scene->host, all_in_range(&ground.x, 3, 0, FLT_MAX));
    scene->ambient_sky = sky;
    scene->ambient_ground = ground;
    scene->light_version++;
    return FNL_OK;
}

fnl_result fnl_scene_set_background(fnl_scene *scene, fnl_vec3 radiance) {
    if (!scene) return FNL_ERROR_INVALID;
    REQUIRE(&scene->host, all_in_range(&radiance.x, 3, 0, FLT_MAX));
    scene->background = radiance;
    return FNL_OK;
}

fnl_result fnl_scene_set_anisotropy(fnl_scene *scene, float anisotropy) {
    if (!scene) return FNL_ERROR_INVALID;
    REQUIRE(&scene->host, anisotropy >= 1 && anisotropy <= 16);
    if (scene->anisotropy != anisotropy) scene->structure_version++;
    scene->anisotropy = anisotropy;
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
    if (!scene) return FNL_ERROR_INVALID;
    REQUIRE(&scene->host, out != NULL);
    struct box bounds = scene_bounds(scene);
    *out = (fnl_scene_info){
        .mesh_count = scene->meshes.count,
        .primitive_count = scene->primitives.count,
        .material_count = scene->materials.count,
        .image_count = scene->images.count,
        .node_count = scene->nodes.count - scene->free_nodes.count,
        .light_count = scene->lights.count - scene->free_lights.count,
        .decal_count = scene->decals.count - scene->free_decals.count,
        .camera_count = scene->cameras.count,
        .animation_count = scene->animations.count,
        .skin_count = scene->skins.count,
        .extension_count = scene->extensions.count,
        .message_count = scene->messages.count,
        .bounds_low = bounds.low,
        .bounds_high = bounds.high,
    };
    for (uint32_t i = 0; i < scene->meshes.count; i++)
        out->unique_triangle_count += mesh_triangles(scene, &scene->meshes.data[i]);
    for (uint32_t i = 0; i < scene->primitives.count; i++)
        out->unique_vertex_count += scene->primitives.data[i].vertex_count;
    for (uint32_t i = 0; i < scene->nodes.count; i++) {
        const struct scene_node *node = &scene->nodes.data[i];
        if (!node->active || node->mesh == SCENE_NONE) continue;
        out->instance_count += node->instance_count;
        out->triangle_count += node->instance_count * mesh_triangles(scene, &scene->meshes.data[node->mesh]);
    }
    for (uint32_t i = 0; i < scene->decals.count; i++)
        if (!scene->decals.data[i].removed) out->decal_kind_counts[scene->decals.data[i].params.kind]++;
    for (uint32_t i = 0; i < scene->lights.count; i++) {
        if (scene->lights.data[i].removed) continue;
        switch (scene->lights.data[i].params.kind) {
        case FNL_LIGHT_DIRECTIONAL:
            out->directional_count++;
            break;
        case FNL_LIGHT_POINT:
            out->point_count++;
            break;
        case FNL_LIGHT_SPOT:
            out->spot_count++;
            break;
        case FNL_LIGHT_CAPSULE:
            out->capsule_count++;
            break;
        case FNL_LIGHT_WEDGE:
            out->wedge_count++;
            break;
        case FNL_LIGHT_BOX:
            out->box_count++;
            break;
        case FNL_LIGHT_KIND_COUNT:
            break;
        }
    }
    return FNL_OK;
}

fnl_result fnl_scene_query_image(const fnl_scene *scene, uint32_t index, fnl_image_info *out) {
    if (!scene) return FNL_ERROR_INVALID;
    REQUIRE(&scene->host, out != NULL);
    REQUIRE(&scene->host, index < scene->images.count);
    const struct scene_image *image = &scene->images.data[index];
    *out = (fnl_image_info){image->name, image->file_kind, image->width, image->height};
    return FNL_OK;
}

fnl_result fnl_scene_query_animation(const fnl_scene *scene, uint32_t index, fnl_animation_info *out) {
    if (!scene) return FNL_ERROR_INVALID;
    REQUIRE(&scene->host, out != NULL);
    REQUIRE(&scene->host, index < scene->animations.count);
    const struct scene_animation *animation = &scene->animations.data[index];
    *out = (fnl_animation_info){animation->name, (double)animation->duration, animation->channel_count};
    return FNL_OK;
}

fnl_result fnl_scene_query_extension(const fnl_scene *scene, uint32_t index, fnl_extension_info *out) {
    if (!scene) return FNL_ERROR_INVALID;
    REQUIRE(&scene->host, out != NULL);
    REQUIRE(&scene->host, index < scene->extensions.count);
    const struct scene_extension *extension = &scene->extensions.data[index];
    *out = (fnl_extension_info){extension->name, extension->required, extension->treatment};
    return FNL_OK;
}

const char *fnl_scene_message(const fnl_scene *scene, uint32_t index) {
    return scene && index < scene->messages.count ? scene->messages.data[index] : NULL;
}

fnl_result fnl_scene_query_light(const fnl_scene *scene, uint32_t index, fnl_light_params *out) {
    if (!scene) return FNL_ERROR_INVALID;
    REQUIRE(&scene->host, out != NULL);
    REQUIRE(&scene->host, index < scene->lights.count - scene->free_lights.count);
    if (scene->free_lights.count > 0) { /* count past the holes */
        uint32_t alive = index;
        for (index = 0; alive > 0 || scene->lights.data[index].removed; index++)
            if (!scene->lights.data[index].removed) alive--;
    }
    *out = scene->lights.data[index].params;
    return FNL_OK;
}
