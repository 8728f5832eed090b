/* SPDX-License-Identifier: MIT */
/* KHR_animation_pointer: what a JSON pointer names, by the glTF 2.0 Asset Object Model. */
#include "scene/gltf.h"

enum row_kind { NODE_ROW, WEIGHT_ROW, MESH_ROW, MESH_WEIGHT_ROW, PROPERTY_ROW, UNUSED_ROW };

struct row {
    const char *pattern; /* '#': an index; the first is that of the target */
    enum row_kind kind;
    uint32_t width; /* 0: as many as there are weights */
    enum scene_animation_path path;
    struct scene_property property;
};

#define MATERIAL(pointer, member, low, high, effect)                                                                        \
    {"/materials/#/" pointer, PROPERTY_ROW, sizeof((struct scene_material *)0)->member / sizeof(float), SCENE_PATH_PROPERTY,  \
     {SCENE_PROPERTY_MATERIAL, SCENE_EFFECT_##effect, 0, offsetof(struct scene_material, member), low, high}}
#define TURN(pointer, name, member, slot)                                                                                   \
    {"/materials/#/" pointer "/extensions/KHR_texture_transform/" name, PROPERTY_ROW,                                        \
     sizeof((struct scene_material *)0)->parts.turns[0].member / sizeof(float), SCENE_PATH_PROPERTY,                          \
     {SCENE_PROPERTY_MATERIAL, SCENE_EFFECT_TURN, SCENE_TEXTURE_##slot,                                                     \
      offsetof(struct scene_material, parts.turns[SCENE_TEXTURE_##slot].member), -FLT_MAX, FLT_MAX}}
#define TEXTURE(pointer, slot)                                                                                              \
    TURN(pointer, "offset", offset, slot), TURN(pointer, "scale", scale, slot), TURN(pointer, "rotation", rotation, slot)
#define LIGHT(pointer, member, low, high)                                                                                   \
    {"/extensions/KHR_lights_punctual/lights/#/" pointer, PROPERTY_ROW, sizeof((fnl_light_params *)0)->member / sizeof(float), \
     SCENE_PATH_PROPERTY, {SCENE_PROPERTY_LIGHT, SCENE_EFFECT_NONE, 0, offsetof(fnl_light_params, member), low, high}}
#define ENVIRONMENT(pointer, member, width, low, high, effect)                                                              \
    {"/extensions/EXT_lights_image_based/lights/#/" pointer, PROPERTY_ROW, width, SCENE_PATH_PROPERTY,                        \
     {SCENE_PROPERTY_ENVIRONMENT, SCENE_EFFECT_##effect, 0, offsetof(struct scene_environment_own, member), low, high}}
#define CAMERA(pointer, member, low, high, effect)                                                                          \
    {"/cameras/#/" pointer, PROPERTY_ROW, 1, SCENE_PATH_PROPERTY,                                                            \
     {SCENE_PROPERTY_CAMERA, SCENE_EFFECT_##effect, 0, offsetof(fnl_camera, member), low, high}}
#define EXTENSION(name) "extensions/KHR_materials_" name "/"
#define LAYER_NUMBER(id, member, extension, key, low, high, ...) MATERIAL("extensions/" extension "/" key, member, low, high, NONE),
#define LAYER_TEXTURE(slot, member, extension, key, ...) TEXTURE("extensions/" extension "/" key, slot),

static const struct row rows[] = {
    {.pattern = "/nodes/#/translation", .kind = NODE_ROW, .path = SCENE_PATH_TRANSLATION, .width = 3},
    {.pattern = "/nodes/#/rotation", .kind = NODE_ROW, .path = SCENE_PATH_ROTATION, .width = 4},
    {.pattern = "/nodes/#/scale", .kind = NODE_ROW, .path = SCENE_PATH_SCALE, .width = 3},
    {.pattern = "/nodes/#/weights", .kind = NODE_ROW, .path = SCENE_PATH_WEIGHTS},
    {.pattern = "/nodes/#/weights/#", .kind = WEIGHT_ROW, .path = SCENE_PATH_WEIGHTS, .width = 1},
    {.pattern = "/nodes/#/extensions/KHR_node_visibility/visible", .kind = NODE_ROW, .path = SCENE_PATH_VISIBLE, .width = 1},
    {.pattern = "/meshes/#/weights", .kind = MESH_ROW, .path = SCENE_PATH_WEIGHTS},
    {.pattern = "/meshes/#/weights/#", .kind = MESH_WEIGHT_ROW, .path = SCENE_PATH_WEIGHTS, .width = 1},
    MATERIAL("pbrMetallicRoughness/baseColorFactor", base_color, 0, 1, NONE),
    MATERIAL("pbrMetallicRoughness/metallicFactor", metallic, 0, 1, NONE),
    MATERIAL("pbrMetallicRoughness/roughnessFactor", roughness, 0, 1, NONE),
    MATERIAL("emissiveFactor", parts.emissive, 0, 1, EMISSIVE),
    MATERIAL(EXTENSION("emissive_strength") "emissiveStrength", parts.emissive_strength, 0, FLT_MAX, EMISSIVE),
    MATERIAL("alphaCutoff", alpha_cutoff, 0, FLT_MAX, NONE),
    MATERIAL("normalTexture/scale", normal_scale, -FLT_MAX, FLT_MAX, NONE),
    MATERIAL("occlusionTexture/strength", occlusion_strength, 0, 1, NONE),
    MATERIAL(EXTENSION("ior") "ior", ior, 0, FLT_MAX, IOR),
    MATERIAL(EXTENSION("specular") "specularFactor", specular, 0, 1, NONE),
    MATERIAL(EXTENSION("specular") "specularColorFactor", specular_color, 0, FLT_MAX, NONE),
    MATERIAL_LAYER_NUMBERS(LAYER_NUMBER, LAYER_NUMBER)
    TEXTURE("pbrMetallicRoughness/baseColorTexture", BASE_COLOR),
    TEXTURE("pbrMetallicRoughness/metallicRoughnessTexture", METALLIC_ROUGHNESS),
    TEXTURE("normalTexture", NORMAL),
    TEXTURE("occlusionTexture", OCCLUSION),
    TEXTURE("emissiveTexture", EMISSIVE),
    TEXTURE(EXTENSION("specular") "specularTexture", SPECULAR),
    TEXTURE(EXTENSION("specular") "specularColorTexture", SPECULAR_COLOR),
    MATERIAL_LAYER_TEXTURES(LAYER_TEXTURE)
    LIGHT("color", color, 0, FLT_MAX),
    LIGHT("intensity", intensity, 0, FLT_MAX),
    LIGHT("range", range, 1e-6f, FLT_MAX),
    LIGHT("spot/innerConeAngle", inner_cone_angle, 0, PI / 2),
    LIGHT("spot/outerConeAngle", outer_cone_angle, 0.001f, PI / 2),
    ENVIRONMENT("intensity", intensity, 1, 0, 1e6f, NONE),
    ENVIRONMENT("rotation", rotation, 4, -1, 1, ROTATION),
    CAMERA("perspective/yfov", vertical_fov, 1e-4f, PI - 1e-4f, NONE),
    CAMERA("perspective/znear", near_distance, 1e-6f, FLT_MAX, NONE),
    CAMERA("orthographic/ymag", vertical_extent, -1e30f, 1e30f, EXTENT),
    CAMERA("orthographic/znear", near_distance, 0, FLT_MAX, NONE),
    CAMERA("orthographic/zfar", far_distance, 1e-6f, FLT_MAX, NONE),
    /* What cameras take from the picture, or lack (gltf_light.c). */
    {.pattern = "/cameras/#/perspective/aspectRatio", .kind = UNUSED_ROW, .path = SCENE_PATH_PROPERTY, .width = 1},
    {.pattern = "/cameras/#/perspective/zfar", .kind = UNUSED_ROW, .path = SCENE_PATH_PROPERTY, .width = 1},
    {.pattern = "/cameras/#/orthographic/xmag", .kind = UNUSED_ROW, .path = SCENE_PATH_PROPERTY, .width = 1},
};

/* ---- pointers ---- */

/** An array index by RFC 6901: no sign, no zero before others. Its end, or NULL. */
static const char *read_index(const char *text, uint32_t *out) {
    uint64_t value = 0;
    const char *c = text;
    for (; *c >= '0' && *c <= '9'; c++) {
        value = value * 10 + (uint64_t)(*c - '0');
        if (value >= SCENE_NONE) return NULL;
    }
    *out = (uint32_t)value;
    return c == text || (*text == '0' && c > text + 1) ? NULL : c;
}

static bool matches(const char *pattern, const char *pointer, uint32_t indices[2]) {
    for (uint32_t count = 0; *pattern; pattern++) {
        if (*pattern == '#') {
            pointer = read_index(pointer, &indices[count++]);
            if (!pointer) return false;
        } else if (*pointer++ != *pattern) {
            return false;
        }
    }
    return !*pointer;
}

/** Whether the object that has the property is in the file. No name of a row needs escapes. */
static bool owner_exists(struct gltf *g, const char *pointer, enum row_kind kind) {
    json_t *value = g->root;
    for (const char *token = pointer + 1, *end; (end = strchr(token, '/')); token = end + 1) {
        uint32_t index;
        bool of_weight = kind == WEIGHT_ROW || kind == MESH_WEIGHT_ROW; /* weights have defaults: the array may be missing */
        if (of_weight && !strchr(end + 1, '/')) break;
        value = json_is_array(value) ? json_array_get(value, read_index(token, &index) == end ? index : SIZE_MAX)
                                     : json_object_getn(value, token, (size_t)(end - token));
    }
    return json_is_object(value);
}

static bool find_weights(struct gltf *g, const struct row *row, const struct at *at, struct gltf_target *target) {
    const bool of_node = row->kind == NODE_ROW || row->kind == WEIGHT_ROW, one = row->width == 1;
    const uint32_t element = target->first_weight,
                   mesh = of_node ? g->scene->nodes.data[target->index].mesh : target->index,
                   count = mesh >= g->scene->meshes.count ? 0 : g->scene->meshes.data[mesh].morph_target_count;
    if (count == 0)
        gltf_warn(g, at, "%s %u has no morph targets; the channel is left out", of_node ? "node" : "mesh", target->index);
    else if (one && element >= count)
        gltf_warn(g, at, "refers to weight %u, but there are %u; the channel is left out", element, count);
    target->one_weight = one;
    target->width = one ? 1 : count;
    return count > 0 && (!one || element < count);
}

bool gltf_find_target(struct gltf *g, const char *pointer, const struct at *at, struct gltf_target *target) {
    uint32_t indices[2] = {0, 0}, i = 0;
    while (i < COUNT_OF(rows) && !matches(rows[i].pattern, pointer, indices)) i++;
    if (i == COUNT_OF(rows) || !owner_exists(g, pointer, rows[i].kind)) {
        if (*pointer && *pointer != '/')
            gltf_warn(g, at, "'%.100s' is no JSON pointer; the channel is left out", pointer);
        else if (i == COUNT_OF(rows))
            gltf_warn(g, at, "'%.100s' names nothing that can be animated; the channel is left out", pointer);
        else
            gltf_warn(g, at, "'%.100s' names nothing that the file has; the channel is left out", pointer);
        return false;
    }
    const struct row *row = &rows[i];
    *target = (struct gltf_target){.path = row->path, .index = indices[0], .width = row->width, .first_weight = indices[1]};
    if (row->kind == MESH_ROW || row->kind == MESH_WEIGHT_ROW) target->kind = GLTF_TARGET_MESH;
    if (row->kind == UNUSED_ROW) target->kind = GLTF_TARGET_UNUSED;
    if (row->kind == PROPERTY_ROW) {
        static const enum gltf_target_kind kinds[] = {GLTF_TARGET_MATERIAL, GLTF_TARGET_LIGHT, GLTF_TARGET_CAMERA, GLTF_TARGET_ENVIRONMENT};
        target->kind = kinds[row->property.owner];
        target->property = &row->property;
    }
    return row->path != SCENE_PATH_WEIGHTS || find_weights(g, row, at, target);
}

bool gltf_query_property(uint32_t index, const char **pointer, uint32_t *width, const struct scene_property **out) {
    uint32_t row = 0;
    for (uint32_t seen = 0; row < COUNT_OF(rows) && (rows[row].kind != PROPERTY_ROW || seen++ < index); row++) {}
    if (row == COUNT_OF(rows)) return false;
    *pointer = rows[row].pattern;
    *width = rows[row].width;
    *out = &rows[row].property;
    return true;
}

/* ---- what shows a part of the file ---- */

/** The index in the document of the mesh, light or camera that something in the scene shows; SCENE_NONE: none. */
static uint32_t shown_by(const struct gltf *g, enum gltf_target_kind kind, uint32_t user) {
    const fnl_scene *scene = g->scene;
    if (kind == GLTF_TARGET_LIGHT) return g->node_lights[scene->lights.data[user].node];
    const bool mesh = kind == GLTF_TARGET_MESH;
    if (mesh && scene->nodes.data[user].morph_weights) return SCENE_NONE; /* its own */
    const uint32_t node = mesh ? user : scene->cameras.data[user].node;
    json_t *value = json_object_get(json_array_get(json_object_get(g->root, "nodes"), node), mesh ? "mesh" : "camera");
    const json_int_t index = json_is_integer(value) ? json_integer_value(value) : -1;
    return index < 0 || index > (json_int_t)SCENE_NONE ? SCENE_NONE : (uint32_t)index;
}

uint32_t gltf_first_user(struct gltf *g, enum gltf_target_kind kind, uint32_t index) {
    struct gltf_users *users = &g->users[kind];
    const uint32_t counts[] = {
        [GLTF_TARGET_MESH] = g->mesh_count, [GLTF_TARGET_LIGHT] = g->light_count, [GLTF_TARGET_CAMERA] = g->camera_count};
    const uint32_t user_counts[] = {[GLTF_TARGET_MESH] = g->node_count,
                                    [GLTF_TARGET_LIGHT] = g->scene->lights.count,
                                    [GLTF_TARGET_CAMERA] = g->scene->cameras.count};
    if (!users->first) {
        users->first = gltf_scratch(g, counts[kind], sizeof *users->first);
        users->next = gltf_scratch(g, user_counts[kind], sizeof *users->next);
        if (!users->first || !users->next) return SCENE_NONE;
        for (uint32_t i = 0; i < counts[kind]; i++) users->first[i] = SCENE_NONE;
        for (uint32_t user = user_counts[kind]; user-- > 0;) {
            const uint32_t shown = shown_by(g, kind, user);
            if (shown >= counts[kind]) continue;
            users->next[user] = users->first[shown];
            users->first[shown] = user;
        }
    }
    return index < counts[kind] ? users->first[index] : SCENE_NONE;
}
