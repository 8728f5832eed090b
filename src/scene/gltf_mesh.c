/* SPDX-License-Identifier: MIT */
/* Meshes and their primitives (glTF 2.0, 3.7). */
#include "scene/gltf.h"

static void warn_unread_uv(struct gltf *g, const struct at *at, const struct scene_primitive *primitive, uint32_t index) {
    if (index == SCENE_NONE) return;
    const struct scene_material *material = &g->scene->materials.data[index];
    bool missing[2] = {false, false};
    for (uint32_t i = 0; i < SCENE_TEXTURE_SLOT_COUNT; i++) {
        const struct scene_texture *texture = &material->textures[i];
        if (texture->image != SCENE_NONE && !primitive->uv[texture->uv_set]) missing[texture->uv_set] = true;
    }
    for (uint32_t set = 0; set < 2; set++)
        if (missing[set])
            gltf_warn(g, at, "the textures of material %u want TEXCOORD_%u, which the primitive lacks; 0, 0 is used", index, set);
}

/* The texture of a material whose coordinates tangents follow, if the primitive has those; NULL: none. */
static const struct scene_texture *tangent_texture(const struct gltf *g, const struct scene_primitive *primitive, uint32_t material) {
    const struct scene_texture *texture = material == SCENE_NONE ? NULL : scene_tangent_texture(&g->scene->materials.data[material]);
    return texture && primitive->uv[texture->uv_set] ? texture : NULL;
}

/* The primitive's own material decides what tangents are made for, and where it has no such texture, the first variant with one. */
static uint32_t tangent_material(const struct gltf *g, const struct scene_primitive *primitive) {
    if (tangent_texture(g, primitive, primitive->material)) return primitive->material;
    for (uint32_t i = 0; i < primitive->mapping_count; i++)
        if (tangent_texture(g, primitive, primitive->mappings[i].material)) return primitive->mappings[i].material;
    return SCENE_NONE;
}

/* Tangents follow the coordinates of the normal texture (glTF 2.0, 3.7.2.1), as KHR_texture_transform makes them. */
static fnl_result complete_by_texture(struct gltf *g, struct scene_primitive *primitive) {
    const uint32_t material = tangent_material(g, primitive);
    const struct scene_texture *texture = tangent_texture(g, primitive, material);
    return mesh_complete_by(&g->scene->arena, primitive, texture ? texture->uv_set : 0, texture ? g->scene->materials.data[material].tangent_frame : NULL);
}

/** Counts the most that it may need beforehand, and gives back what it did not keep. */
static bool complete(struct gltf *g, const struct at *at, struct scene_primitive *primitive) {
    uint64_t most = mesh_complete_bytes(primitive), vertex_bytes = mesh_vertex_bytes(primitive), kept = mesh_made_target_bytes(primitive);
    const vec4 *given = primitive->tangents;
    bool flat = primitive->topology == SCENE_TOPOLOGY_TRIANGLES && !primitive->normals;
    uint64_t corners = primitive->index_count, vertices = flat ? corners : primitive->vertex_count;
    if (!gltf_spend(g, at, most)) return false;
    fnl_result result = complete_by_texture(g, primitive);
    if (result == FNL_ERROR_MEMORY) gltf_fail_memory(g);
    if (flat) kept += corners * (vertex_bytes + sizeof(vec3) + sizeof(uint32_t));
    if (primitive->tangents && primitive->tangents != given) {
        kept += corners * sizeof(uint32_t) + primitive->vertex_count * sizeof(vec4);
        if (primitive->vertex_count > vertices) /* split: all attributes once more */
            kept += primitive->vertex_count * (mesh_vertex_bytes(primitive) - sizeof(vec4));
    }
    gltf_refund(g, most - MIN(most, kept));
    return result == FNL_OK;
}

/* What the vertices lack for the materials of variants. */
static void check_variants(struct gltf *g, const struct at *at, const struct scene_primitive *primitive, bool tangents_given) {
    const struct at *extensions_at = AT_KEY(at, "extensions"), *extension_at = AT_KEY(extensions_at, "KHR_materials_variants"),
                    *here = AT_KEY(extension_at, "mappings");
    for (uint32_t i = 0; i < primitive->mapping_count; i++) {
        const uint32_t material = primitive->mappings[i].material;
        if (i > 0 && material == primitive->mappings[i - 1].material) continue; /* said already */
        warn_unread_uv(g, here, primitive, material);
        const uint32_t own = tangent_material(g, primitive);
        const struct scene_texture *texture = tangent_texture(g, primitive, material), *made = tangent_texture(g, primitive, own);
        if (tangents_given || !texture || texture == made) continue;
        const struct scene_material *materials = g->scene->materials.data;
        if (texture->uv_set != made->uv_set)
            gltf_warn(g, here, "the normal texture of material %u wants tangents by TEXCOORD_%u; those by TEXCOORD_%u are used", material, texture->uv_set, made->uv_set);
        else if (memcmp(materials[material].tangent_frame, materials[own].tangent_frame, sizeof materials->tangent_frame) != 0)
            gltf_warn(g, here, "the normal texture of material %u is transformed in another way than that of material %u, whose tangents are used", material, own);
    }
}

static bool load_primitive(struct gltf *g, json_t *object, const struct at *at, struct scene_primitive *out,
                           struct gltf_primitive_joints *joints) {
    *out = (struct scene_primitive){.material = gltf_index(g, object, at, "material", false, g->material_count)};
    if (!gltf_load_mappings(g, object, at, out)) return false;
    json_t *attribute_object = gltf_object(g, object, at, "attributes", true);
    if (!attribute_object) return false;
    const struct at *attributes_at = AT_KEY(at, "attributes");
    struct gltf_attributes attributes;
    gltf_find_attributes(g, attribute_object, attributes_at, NULL, &attributes);
    uint32_t position = attributes.accessor[GLTF_POSITION][0];
    if (position == SCENE_NONE) {
        if (json_object_get(object, "indices")) gltf_index(g, object, at, "indices", true, g->accessor_count);
        gltf_warn(g, attributes_at, "has no POSITION that can be used; the primitive is left out");
        return false;
    }
    struct gltf_selection selection;
    if (!gltf_load_indices(g, object, at, g->accessors[position].count, out, &selection)) return false;
    if (!gltf_load_vertices(g, object, at, &attributes, &selection, out)) return false;
    gltf_load_joints(g, attributes_at, &attributes, &selection, out, joints);
    const bool tangents_given = out->tangents != NULL;
    if (g->result != FNL_OK || !complete(g, at, out)) return false;
    warn_unread_uv(g, AT_KEY(at, "material"), out, out->material);
    check_variants(g, at, out, tangents_given);
    return true;
}

static void load_weights(struct gltf *g, json_t *object, const struct at *at, struct scene_mesh *mesh) {
    json_t *weights = gltf_array(g, object, at, "weights", false);
    uint32_t count = gltf_count(weights);
    if (count == 0) return;
    const struct at *here = AT_KEY(at, "weights");
    if (count != mesh->morph_target_count) {
        gltf_warn(g, here, "has %u weights for %u morph targets; they are ignored", count, mesh->morph_target_count);
        return;
    }
    float *values = gltf_keep(g, count, sizeof *values);
    for (uint32_t i = 0; values && i < count; i++) {
        json_t *value = json_array_get(weights, i);
        if (json_is_number(value)) values[i] = (float)json_number_value(value);
        if (json_is_number(value) && isfinite(values[i])) continue;
        gltf_warn(g, AT_INDEX(here, i), "is not a finite number; 0 is used");
        values[i] = 0;
    }
    mesh->morph_weights = values;
}

static void load_mesh(struct gltf *g, json_t *object, const struct at *at) {
    json_t *array = gltf_array(g, object, at, "primitives", true);
    uint32_t count = gltf_count(array), kept = 0;
    struct scene_primitive *primitives = host_allocate_zero(g->host, sizeof *primitives * MAX((size_t)count, 1));
    if (!primitives) gltf_fail_memory(g);
    for (uint32_t i = 0; primitives && i < count && g->result == FNL_OK; i++) {
        const struct at *primitives_at = AT_KEY(at, "primitives");
        json_t *primitive = gltf_element(g, array, primitives_at, i);
        struct gltf_primitive_joints joints = {.source = i};
        if (!primitive || !load_primitive(g, primitive, AT_INDEX(primitives_at, i), &primitives[kept], &joints)) continue;
        if (!array_push(g->host, &g->primitive_joints, joints)) gltf_fail_memory(g);
        primitives[kept++].source = i;
    }
    const char *name = gltf_name(g, object, at);
    uint32_t index = SCENE_NONE;
    if (g->result == FNL_OK) index = scene_add_mesh(g->scene, name, primitives, kept);
    if (g->result == FNL_OK && index == SCENE_NONE) gltf_fail_memory(g);
    if (index != SCENE_NONE) {
        struct scene_mesh *mesh = &g->scene->meshes.data[index];
        mesh->extras = gltf_extras(g, object);
        for (uint32_t i = 0; i < kept; i++)
            if (primitives[i].morph_target_count != mesh->morph_target_count) {
                gltf_warn(g, AT_KEY(at, "primitives"), "the primitives have different numbers of morph targets");
                break;
            }
        load_weights(g, object, at, mesh);
    }
    host_free(g->host, primitives, sizeof *primitives * MAX((size_t)count, 1));
}

void gltf_load_meshes(struct gltf *g) {
    json_t *array = gltf_array(g, g->root, &g->top, "meshes", false);
    const struct at *at = AT_KEY(&g->top, "meshes");
    g->mesh_count = gltf_count(array);
    for (uint32_t i = 0; i < g->mesh_count && g->result == FNL_OK; i++) {
        json_t *object = gltf_element(g, array, at, i);
        if (object)
            load_mesh(g, object, AT_INDEX(at, i));
        else if (scene_add_mesh(g->scene, "", NULL, 0) == SCENE_NONE)
            gltf_fail_memory(g);
        gltf_step(g);
    }
}
