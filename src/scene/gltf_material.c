/* SPDX-License-Identifier: MIT */
/* Materials and their texture references (glTF 2.0, 3.9, and the KHR_materials_* extensions that are shown in full). */
#include "image/texture.h"
#include "scene/gltf.h"
#include "scene/layer_rows.h"

/** The image for colour or for data: one that is used for both gets a twin that shares its bytes. */
static uint32_t image_for(struct gltf *g, const struct at *at, uint32_t index, bool color) {
    struct scene_image *image = &g->scene->images.data[index];
    const enum texture_transfer transfer = (enum texture_transfer)g->image_transfer[index];
    if (transfer == (color ? TEXTURE_LINEAR : TEXTURE_SRGB)) { /* KHR_texture_basisu, "MUST match the expected usage" */
        gltf_warn(g, at, "is a texture of %s, but the file of image %u says that it holds %s; it is taken as what the material needs",
                  color ? "colours" : "numbers", index, color ? "linear values" : "colours of sRGB");
        g->image_transfer[index] = TEXTURE_TRANSFER_UNKNOWN; /* once is enough */
    }
    if (!g->image_used[index]) {
        g->image_used[index] = true;
        image->color = color;
    }
    if (image->color == color) return index;
    if (g->image_twin[index] == SCENE_NONE) {
        if (!gltf_take_image(g, at, image->width, image->height)) return SCENE_NONE;
        struct scene_image twin = *image;
        twin.color = color;
        twin.normals = false;
        g->image_twin[index] = scene_add_image(g->scene, &twin);
        if (g->image_twin[index] == SCENE_NONE) gltf_fail_memory(g);
    }
    return g->image_twin[index];
}

static void load_transform(struct gltf *g, json_t *object, const struct at *at, enum scene_texture_slot slot, struct scene_material *material,
                           uint64_t *uv_set) {
    struct gltf_extension_place place;
    json_t *extension = gltf_extension(object, at, "KHR_texture_transform", &place);
    if (!extension) return;
    struct scene_texture_turn *turn = &material->parts.turns[slot];
    gltf_floats(g, extension, &place.extension, "offset", 2, -FLT_MAX, FLT_MAX, turn->offset);
    gltf_floats(g, extension, &place.extension, "scale", 2, -FLT_MAX, FLT_MAX, turn->scale);
    gltf_float(g, extension, &place.extension, "rotation", false, -FLT_MAX, FLT_MAX, &turn->rotation);
    gltf_uint(g, extension, &place.extension, "texCoord", false, 0, UINT32_MAX, uv_set);
    scene_turn_texture(&material->textures[slot], turn);
}

/** A texture reference; the returned object holds the slot's own numbers, NULL when there is none. */
static json_t *load_texture(struct gltf *g, json_t *object, const struct at *at, const char *key,
                            enum scene_texture_slot slot, struct scene_material *material) {
    json_t *reference = gltf_object(g, object, at, key, false);
    if (!reference) return NULL;
    const struct at *here = AT_KEY(at, key);
    uint32_t index = gltf_index(g, reference, here, "index", true, g->texture_count);
    uint64_t uv_set = 0;
    gltf_uint(g, reference, here, "texCoord", false, 0, UINT32_MAX, &uv_set);
    struct scene_texture *texture = &material->textures[slot];
    load_transform(g, reference, here, slot, material, &uv_set);
    if (index == SCENE_NONE || g->textures[index].image == SCENE_NONE) {
        if (index != SCENE_NONE)
            gltf_warn(g, AT_KEY(here, "index"), "texture %u has no image that can be read; it is left out", index);
        return reference;
    }
    if (uv_set > 1) {
        gltf_warn(g, AT_KEY(here, "texCoord"),
                  "is %llu; only TEXCOORD_0 and TEXCOORD_1 are read, so the texture is left out",
                  (unsigned long long)uv_set);
        return reference;
    }
    texture->uv_set = (uint32_t)uv_set;
    texture->sampler = g->textures[index].sampler;
    texture->image = image_for(g, here, g->textures[index].image, scene_texture_is_color(slot));
    if (texture->image != SCENE_NONE && scene_texture_is_normals(slot)) g->scene->images.data[texture->image].normals = true;
    return reference;
}

static void load_color(struct gltf *g, json_t *object, const struct at *at, const char *key, float high, vec3 *out) {
    float values[3];
    if (gltf_floats(g, object, at, key, 3, 0, high, values)) *out = vec3_make(values[0], values[1], values[2]);
}

static void load_metallic_roughness(struct gltf *g, json_t *object, const struct at *at, struct scene_material *material) {
    float color[4];
    if (gltf_floats(g, object, at, "baseColorFactor", 4, 0, 1, color))
        material->base_color = vec4_make(color[0], color[1], color[2], color[3]);
    gltf_float(g, object, at, "metallicFactor", false, 0, 1, &material->metallic);
    gltf_float(g, object, at, "roughnessFactor", false, 0, 1, &material->roughness);
    load_texture(g, object, at, "baseColorTexture", SCENE_TEXTURE_BASE_COLOR, material);
    load_texture(g, object, at, "metallicRoughnessTexture", SCENE_TEXTURE_METALLIC_ROUGHNESS, material);
}

static void load_alpha(struct gltf *g, json_t *object, const struct at *at, struct scene_material *material) {
    const char *mode = gltf_string(g, object, at, "alphaMode", false);
    if (mode && strcmp(mode, "MASK") == 0)
        material->alpha_mode = FNL_ALPHA_MASK;
    else if (mode && strcmp(mode, "BLEND") == 0)
        material->alpha_mode = FNL_ALPHA_BLEND;
    else if (mode && strcmp(mode, "OPAQUE") != 0)
        gltf_warn(g, AT_KEY(at, "alphaMode"), "is unknown; it is taken as OPAQUE");
    gltf_float(g, object, at, "alphaCutoff", false, 0, FLT_MAX, &material->alpha_cutoff);
}

static void load_layer_number(struct gltf *g, json_t *object, const struct at *at, const char *key, const struct layer_number *number,
                              struct scene_material *material) {
    float *value = layer_value(material, number);
    if (number->count == 1)
        gltf_float(g, object, at, key, false, number->low, number->high, value);
    else
        gltf_floats(g, object, at, key, number->count, number->low, number->high, value);
}

/** A texture of a layer, with the numbers in its JSON object. */
static void load_layer_texture(struct gltf *g, json_t *extension, const struct at *at, const struct layer_texture *texture, struct scene_material *material) {
    json_t *object = load_texture(g, extension, at, texture->key, texture->slot, material);
    const size_t length = strlen(texture->key);
    for (uint32_t i = 0; object && i < LAYER_NUMBER_COUNT; i++) {
        const struct layer_number *number = &layer_numbers[i];
        if (strcmp(number->extension, texture->extension) == 0 && strncmp(number->key, texture->key, length) == 0 && number->key[length] == '/')
            load_layer_number(g, object, AT_KEY(at, texture->key), number->key + length + 1, number, material);
    }
}

static void load_layer(struct gltf *g, json_t *extension, const struct at *at, const char *name, struct scene_material *material) {
    for (uint32_t i = 0; i < LAYER_NUMBER_COUNT; i++) {
        const struct layer_number *number = &layer_numbers[i];
        if (strcmp(number->extension, name) != 0) continue;
        for (uint32_t k = 0; k < number->count && number->unsaid > 0; k++) layer_value(material, number)[k] = number->unsaid;
        if (!strchr(number->key, '/')) load_layer_number(g, extension, at, number->key, number, material);
    }
    for (uint32_t i = 0; i < LAYER_TEXTURE_COUNT; i++)
        if (strcmp(layer_textures[i].extension, name) == 0) load_layer_texture(g, extension, at, &layer_textures[i], material);
}

static void load_layers(struct gltf *g, json_t *object, const struct at *at, struct scene_material *material) {
    struct gltf_extension_place place;
    for (uint32_t i = 0; i < LAYER_COUNT; i++) {
        json_t *extension = gltf_extension(object, at, layer_extensions[i], &place);
        if (extension) load_layer(g, extension, &place.extension, layer_extensions[i], material);
    }
}

static void load_material_extensions(struct gltf *g, json_t *object, const struct at *at, struct scene_material *material) {
    struct gltf_extension_place place;
    material->unlit = gltf_extension(object, at, "KHR_materials_unlit", &place) != NULL;
    json_t *extension = gltf_extension(object, at, "KHR_materials_emissive_strength", &place);
    if (extension)
        gltf_float(g, extension, &place.extension, "emissiveStrength", false, 0, FLT_MAX, &material->parts.emissive_strength);
    material->emissive = vec3_scale(material->parts.emissive, material->parts.emissive_strength);
    extension = gltf_extension(object, at, "KHR_materials_ior", &place);
    if (extension && gltf_float(g, extension, &place.extension, "ior", false, 0, FLT_MAX, &material->ior) &&
        material->ior > 0 && material->ior < 1) {
        gltf_warn(g, AT_KEY(&place.extension, "ior"), "is %g, neither 0 nor at least 1; 1.5 is used", (double)material->ior);
        material->ior = 1.5f;
    }
    extension = gltf_extension(object, at, "KHR_materials_specular", &place);
    if (extension) {
        gltf_float(g, extension, &place.extension, "specularFactor", false, 0, 1, &material->specular);
        load_color(g, extension, &place.extension, "specularColorFactor", FLT_MAX, &material->specular_color);
        load_texture(g, extension, &place.extension, "specularTexture", SCENE_TEXTURE_SPECULAR, material);
        load_texture(g, extension, &place.extension, "specularColorTexture", SCENE_TEXTURE_SPECULAR_COLOR, material);
    }
}

/** Whether it casts shadows, which no extension says (docs/techniques/shadows.md). */
static bool loads_shadows(struct gltf *g, json_t *material, const struct at *material_at) {
    json_t *extras = json_object_get(material, "extras");
    if (!json_is_object(extras)) return true;
    const struct at *extras_at = AT_KEY(material_at, "extras"), *at = AT_KEY(extras_at, "FNL_material_shadows");
    json_t *object = gltf_object(g, extras, extras_at, "FNL_material_shadows", false);
    return !object || gltf_bool(g, object, at, "castsShadows", true);
}

static void load_material(struct gltf *g, json_t *object, const struct at *at, struct scene_material *material) {
    material->name = gltf_name(g, object, at);
    material->extras = gltf_extras(g, object);
    json_t *metallic_roughness = gltf_object(g, object, at, "pbrMetallicRoughness", false);
    if (metallic_roughness) load_metallic_roughness(g, metallic_roughness, AT_KEY(at, "pbrMetallicRoughness"), material);
    json_t *normal = load_texture(g, object, at, "normalTexture", SCENE_TEXTURE_NORMAL, material);
    if (normal)
        gltf_float(g, normal, AT_KEY(at, "normalTexture"), "scale", false, -FLT_MAX, FLT_MAX, &material->normal_scale);
    json_t *occlusion = load_texture(g, object, at, "occlusionTexture", SCENE_TEXTURE_OCCLUSION, material);
    if (occlusion)
        gltf_float(g, occlusion, AT_KEY(at, "occlusionTexture"), "strength", false, 0, 1, &material->occlusion_strength);
    load_texture(g, object, at, "emissiveTexture", SCENE_TEXTURE_EMISSIVE, material);
    load_color(g, object, at, "emissiveFactor", 1, &material->parts.emissive);
    load_alpha(g, object, at, material);
    material->double_sided = gltf_bool(g, object, at, "doubleSided", false);
    material->casts_shadows = loads_shadows(g, object, at);
    load_material_extensions(g, object, at, material);
    load_layers(g, object, at, material);
    const struct scene_texture *tangents = scene_tangent_texture(material);
    const float *t = tangents ? tangents->transform : NULL;
    if (t && (double)t[0] * (double)t[4] != (double)t[1] * (double)t[3])
        memcpy(material->tangent_frame, (float[4]){t[0], t[1], t[3], t[4]}, sizeof material->tangent_frame);
}

void gltf_load_materials(struct gltf *g) {
    json_t *array = gltf_array(g, g->root, &g->top, "materials", false);
    const struct at *at = AT_KEY(&g->top, "materials");
    g->material_count = gltf_count(array);
    for (uint32_t i = 0; i < g->material_count && g->result == FNL_OK; i++) {
        struct scene_material material = scene_material_default();
        material.name = "";
        json_t *object = gltf_element(g, array, at, i);
        if (object) load_material(g, object, AT_INDEX(at, i), &material);
        if (scene_add_material(g->scene, &material) == SCENE_NONE) gltf_fail_memory(g);
    }
}
