/* SPDX-License-Identifier: MIT */
/*
 * The node extension FNL_decal (docs/techniques/decals.md): "decal" makes the node a decal whose box is the unit cube of the node's space, and
 * "receiverMask" says which decals the node's mesh receives.
 */
#include "scene/gltf.h"

static const char *kind_name(int i) { return fnl_value_name(FNL_ENUM_DECAL_KIND, (uint32_t)i); }
static const char *blend_name(int i) { return fnl_value_name(FNL_ENUM_DECAL_BLEND, (uint32_t)i); }
static const char *channel_name(int i) {
    static const char *const names[] = {"color", "normal", "roughness", "metallic", "emission"};
    return i < (int)COUNT_OF(names) ? names[i] : NULL;
}

/* The number of a name, or -1 with a warning that lists what there is. */
static int find_name(struct gltf *g, const struct at *at, const char *text, const char *(*name)(int)) {
    char known[160] = "";
    for (int i = 0; name(i); i++) {
        if (strcmp(name(i), text) == 0) return i;
        size_t used = strlen(known);
        snprintf(known + used, sizeof known - used, "%s%s", i ? ", " : "", name(i));
    }
    gltf_warn(g, at, "'%.40s' is none of %s; it is ignored", text, known);
    return -1;
}

static int member_name(struct gltf *g, json_t *object, const struct at *at, const char *key, const char *(*name)(int)) {
    const char *text = gltf_string(g, object, at, key, false);
    return text ? find_name(g, AT_KEY(at, key), text, name) : -1;
}

static json_t *load_picture(struct gltf *g, json_t *object, const struct at *at, const char *key, fnl_image_id *out) {
    json_t *reference = gltf_object(g, object, at, key, false);
    if (!reference) return NULL;
    const struct at *here = AT_KEY(at, key);
    uint32_t index = gltf_index(g, reference, here, "index", true, g->texture_count);
    if (index == SCENE_NONE) return reference;
    if (g->textures[index].image == SCENE_NONE)
        gltf_warn(g, AT_KEY(here, "index"), "texture %u has no image that can be read; it is left out", index);
    else
        *out = (fnl_image_id){g->textures[index].image, 1};
    return reference;
}

static void load_channels(struct gltf *g, json_t *object, const struct at *at, fnl_decal_params *p) {
    json_t *array = gltf_array(g, object, at, "channels", false);
    if (!array) return;
    const struct at *here = AT_KEY(at, "channels");
    p->channels = 0;
    for (uint32_t i = 0; i < gltf_count(array); i++) {
        const char *text = json_string_value(json_array_get(array, i));
        int channel = text ? find_name(g, AT_INDEX(here, i), text, channel_name) : -1;
        if (!text) gltf_warn(g, AT_INDEX(here, i), "is not a string; it is ignored");
        if (channel >= 0) p->channels |= 1u << channel;
    }
}

static void load_looks(struct gltf *g, json_t *object, const struct at *at, fnl_decal_params *p) {
    uint64_t number;
    gltf_floats(g, object, at, "baseColorFactor", 4, 0, 1, p->color);
    gltf_float(g, object, at, "metallicFactor", false, 0, 1, &p->metallic);
    gltf_float(g, object, at, "roughnessFactor", false, 0, 1, &p->roughness);
    gltf_floats(g, object, at, "emissiveFactor", 3, 0, FLT_MAX, p->emissive);
    load_picture(g, object, at, "baseColorTexture", &p->color_image);
    load_picture(g, object, at, "metallicRoughnessTexture", &p->metallic_roughness_image);
    load_picture(g, object, at, "emissiveTexture", &p->emissive_image);
    json_t *normal = load_picture(g, object, at, "normalTexture", &p->normal_image);
    if (normal) gltf_float(g, normal, AT_KEY(at, "normalTexture"), "scale", false, -FLT_MAX, FLT_MAX, &p->normal_scale);
    load_channels(g, object, at, p);
    int blend = member_name(g, object, at, "blend", blend_name);
    if (blend >= 0) p->blend = (fnl_decal_blend)blend;
    p->flatten = gltf_bool(g, object, at, "flatten", p->flatten);
    float key = 0;
    if (gltf_float(g, object, at, "sortKey", false, -2e9f, 2e9f, &key)) p->sort_key = (int32_t)key;
    gltf_float(g, object, at, "fadeStart", false, 0, PI, &p->fade_start);
    gltf_float(g, object, at, "fadeEnd", false, 0, PI, &p->fade_end);
    if (p->fade_end < p->fade_start) {
        gltf_warn(g, AT_KEY(at, "fadeEnd"), "is less than fadeStart; the fade is hard");
        p->fade_end = p->fade_start;
    }
    if (gltf_uint(g, object, at, "receivers", false, 0, 255, &number)) p->receivers = (uint32_t)number;
    p->distance_field = gltf_float(g, object, at, "cut", false, 0, 1, &p->cut);
    if (gltf_uint(g, object, at, "slices", false, 1, 4096, &number)) p->slices = (uint32_t)number;
}

static bool needs_target(fnl_decal_kind kind) { return kind != FNL_DECAL_BOX && kind != FNL_DECAL_VOLUME; }

/* From the decal's box to the mesh of `target`: as the file poses both; skinned meshes stand in the scene's space as they were bound. */
static bool to_mesh(const struct scene_node *decal, const struct scene_node *target, mat4 *out) {
    mat4 inverse;
    if (target->skin != SCENE_NONE) {
        *out = mat4_from_affine(&decal->world_exact, no_origin);
        return true;
    }
    if (!mat4_inverse(&target->world, &inverse)) return false;
    *out = mat4_mul(inverse, decal->world);
    return true;
}

static void place_decal(struct gltf *g, json_t *object, const struct at *at, uint32_t index) {
    fnl_decal_params p = fnl_decal_params_default();
    int kind = member_name(g, object, at, "kind", kind_name);
    if (kind >= 0) p.kind = (fnl_decal_kind)kind;
    load_looks(g, object, at, &p);
    const struct scene_node *nodes = g->scene->nodes.data;
    uint32_t node = index;
    if (needs_target(p.kind)) {
        node = gltf_index(g, object, at, "target", true, g->node_count);
        if (node == SCENE_NONE) return;
        if (nodes[node].mesh == SCENE_NONE) {
            gltf_warn(g, AT_KEY(at, "target"), "node %u has no mesh that a %s decal could be on; the decal is left out",
                      node, fnl_value_name(FNL_ENUM_DECAL_KIND, p.kind));
            return;
        }
        if (!to_mesh(&nodes[index], &nodes[node], &p.transform)) {
            gltf_warn(g, AT_KEY(at, "target"), "node %u has no size; the decal is left out", node);
            return;
        }
    }
    struct gltf_quiet_host quiet;
    gltf_quiet_host_init(&quiet, g->host);
    mat4 world = p.transform;
    if (!needs_target(p.kind)) p.transform = nodes[index].world; /* only to see whether it can be inverted */
    fnl_result result = decal_check(CALL(&quiet.host), &p);
    p.transform = needs_target(p.kind) ? world : mat4_identity();
    if (result != FNL_OK) {
        gltf_warn(g, at, "its node has no size in some direction; the decal is left out");
        return;
    }
    if (scene_add_decal(g->scene, &p, node) == SCENE_NONE) gltf_fail_memory(g);
}

void gltf_load_decals(struct gltf *g) {
    json_t *array = gltf_array(g, g->root, &g->top, "nodes", false);
    const struct at *nodes_at = AT_KEY(&g->top, "nodes");
    for (uint32_t i = 0; i < g->node_count && g->result == FNL_OK; i++) {
        json_t *node = json_array_get(array, i);
        if (!json_is_object(node)) continue;
        const struct at *at = AT_INDEX(nodes_at, i);
        struct gltf_extension_place place;
        json_t *extension = gltf_extension(node, at, "FNL_decal", &place);
        if (!extension) continue;
        uint64_t mask;
        if (gltf_uint(g, extension, &place.extension, "receiverMask", false, 0, 255, &mask))
            g->scene->nodes.data[i].refuses = (uint8_t)~mask;
        json_t *decal = gltf_object(g, extension, &place.extension, "decal", false);
        if (decal && g->in_scene[i]) place_decal(g, decal, AT_KEY(&place.extension, "decal"), i);
    }
}
