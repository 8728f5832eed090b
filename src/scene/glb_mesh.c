/* SPDX-License-Identifier: MIT */
/* Meshes of a file that is saved: those that were added or replaced. */
#include "scene/glb.h"

static json_t *accessor_index(uint32_t index) { return json_integer((json_int_t)index); }

static void set_bounds(struct glb *g, uint32_t accessor, const vec3 *positions, uint32_t count) {
    struct box box = box_empty();
    for (uint32_t i = 0; i < count; i++) box_add_point(&box, positions[i]);
    json_t *object = json_array_get(json_object_get(g->root, "accessors"), accessor);
    glb_set(g, object, "min", glb_floats(&box.low.x, 3));
    glb_set(g, object, "max", glb_floats(&box.high.x, 3));
}

static void set_floats(struct glb *g, json_t *attributes, const char *name, const void *data, uint32_t count, enum gltf_type type) {
    if (!data || g->result != FNL_OK) return;
    const uint32_t accessor = glb_add_accessor(g, data, count, GLTF_FLOAT, type, GLB_VERTICES);
    if (strcmp(name, "POSITION") == 0) set_bounds(g, accessor, data, count);
    glb_set(g, attributes, name, accessor_index(accessor));
}

static void set_joints(struct glb *g, json_t *attributes, const struct scene_primitive *p) {
    for (uint32_t set = 0; set < p->joint_count / 4 && g->result == FNL_OK; set++) {
        char name[32];
        uint16_t *joints = glb_memory(g, p->vertex_count, 4 * sizeof *joints);
        float *weights = glb_memory(g, p->vertex_count, 4 * sizeof *weights);
        if (!joints || !weights) return;
        for (uint32_t i = 0; i < p->vertex_count; i++) {
            memcpy(joints + 4 * (size_t)i, p->joints + (size_t)i * p->joint_count + 4 * set, 4 * sizeof *joints);
            memcpy(weights + 4 * (size_t)i, p->weights + (size_t)i * p->joint_count + 4 * set, 4 * sizeof *weights);
        }
        snprintf(name, sizeof name, "JOINTS_%u", set);
        glb_set(g, attributes, name, accessor_index(glb_add_accessor(g, joints, p->vertex_count, GLTF_UNSIGNED_SHORT, GLTF_VEC4, GLB_VERTICES)));
        snprintf(name, sizeof name, "WEIGHTS_%u", set);
        glb_set(g, attributes, name, accessor_index(glb_add_accessor(g, weights, p->vertex_count, GLTF_FLOAT, GLTF_VEC4, GLB_VERTICES)));
    }
}

static json_t *targets_of(struct glb *g, const struct scene_primitive *p) {
    json_t *targets = json_array();
    for (uint32_t i = 0; i < p->morph_target_count && g->result == FNL_OK; i++) {
        const struct scene_morph_target *target = &p->morph_targets[i];
        json_t *object = json_object();
        /* A target must have something. */
        const void *positions = target->positions || target->normals || target->tangents ? (const void *)target->positions : glb_memory(g, p->vertex_count, sizeof(vec3));
        set_floats(g, object, "POSITION", positions, p->vertex_count, GLTF_VEC3);
        set_floats(g, object, "NORMAL", target->normals, p->vertex_count, GLTF_VEC3);
        set_floats(g, object, "TANGENT", target->tangents, p->vertex_count, GLTF_VEC3);
        glb_append(g, targets, object);
    }
    return targets;
}

/* 65535 ends strips in some programs, so it is no index of 16 bits. */
static uint32_t indices_of(struct glb *g, const struct scene_primitive *p) {
    if (p->vertex_count > UINT16_MAX) return glb_add_accessor(g, p->indices, p->index_count, GLTF_UNSIGNED_INT, GLTF_SCALAR, GLB_INDICES);
    uint16_t *narrow = glb_memory(g, p->index_count, sizeof *narrow);
    for (uint32_t i = 0; narrow && i < p->index_count; i++) narrow[i] = (uint16_t)p->indices[i];
    return narrow ? glb_add_accessor(g, narrow, p->index_count, GLTF_UNSIGNED_SHORT, GLTF_SCALAR, GLB_INDICES) : 0;
}

static void set_material(struct glb *g, json_t *object, uint32_t material) {
    const uint32_t index = glb_material(g, material);
    if (index == SCENE_NONE)
        json_object_del(object, "material");
    else
        glb_set(g, object, "material", accessor_index(index));
}

static void write_shape(struct glb *g, json_t *object, const struct scene_primitive *p) {
    static const int modes[] = {[SCENE_TOPOLOGY_TRIANGLES] = 4, [SCENE_TOPOLOGY_LINES] = 1, [SCENE_TOPOLOGY_POINTS] = 0};
    json_t *attributes = json_object();
    set_floats(g, attributes, "POSITION", p->positions, p->vertex_count, GLTF_VEC3);
    set_floats(g, attributes, "NORMAL", p->normals, p->vertex_count, GLTF_VEC3);
    set_floats(g, attributes, "TANGENT", p->tangents, p->vertex_count, GLTF_VEC4);
    set_floats(g, attributes, "TEXCOORD_0", p->uv[0], p->vertex_count, GLTF_VEC2);
    set_floats(g, attributes, "TEXCOORD_1", p->uv[1], p->vertex_count, GLTF_VEC2);
    set_floats(g, attributes, "COLOR_0", p->colors, p->vertex_count, GLTF_VEC4);
    set_joints(g, attributes, p);
    glb_set(g, object, "attributes", attributes);
    if (p->topology != SCENE_TOPOLOGY_TRIANGLES || json_object_get(object, "mode")) glb_set(g, object, "mode", json_integer(modes[p->topology]));
    glb_set(g, object, "indices", accessor_index(indices_of(g, p)));
    if (p->morph_target_count) glb_set(g, object, "targets", targets_of(g, p));
}

uint32_t glb_mesh(struct glb *g, uint32_t index) {
    if (g->meshes[index] != SCENE_NONE) return g->meshes[index];
    const struct scene_mesh *mesh = &g->scene->meshes.data[index];
    json_t *primitives = json_array(), *object = json_object();
    for (uint32_t i = 0; i < mesh->primitive_count && g->result == FNL_OK; i++) {
        const struct scene_primitive *p = &g->scene->primitives.data[mesh->first_primitive + i];
        json_t *primitive = json_object();
        write_shape(g, primitive, p);
        set_material(g, primitive, p->material);
        glb_append(g, primitives, primitive);
    }
    glb_set_name(g, object, mesh->name, mesh->extras);
    glb_set(g, object, "primitives", primitives);
    if (mesh->morph_weights) glb_set(g, object, "weights", glb_floats(mesh->morph_weights, mesh->morph_target_count));
    return g->meshes[index] = glb_add(g, "meshes", object);
}

/* A variant that is shown is no change. */
static bool has_own_material(const struct scene_primitive *now, const struct scene_primitive *base) {
    if (now->material == base->material || (now->mapping_count && now->material == now->standard_material)) return false;
    for (uint32_t i = 0; i < now->mapping_count; i++)
        if (now->mappings[i].material == now->material) return false;
    return true;
}

static void patch_primitive(struct glb *g, json_t *object, uint32_t mesh, const struct scene_primitive *now, const struct scene_primitive *base) {
    if (has_own_material(now, base)) set_material(g, object, now->material);
    if (now->version == base->version) return;
    const char *name;
    json_t *value;
    json_object_foreach(json_object_get(object, "attributes"), name, value)
        if (*name == '_') glb_left_out(g, "the attribute %.60s of mesh %u, whose vertices were replaced", name, mesh);
    glb_remove_extension(object, "KHR_draco_mesh_compression");
    write_shape(g, object, now);
}

void glb_save_meshes(struct glb *g) {
    json_t *array = json_object_get(g->root, "meshes");
    for (uint32_t i = 0; i < g->mesh_count; i++) {
        const struct scene_mesh *mesh = &g->scene->meshes.data[i];
        json_t *primitives = json_object_get(json_array_get(array, i), "primitives");
        for (uint32_t k = 0; k < mesh->primitive_count && g->result == FNL_OK; k++) {
            const struct scene_primitive *now = &g->scene->primitives.data[mesh->first_primitive + k],
                                         *base = &g->file->primitives.data[g->file->meshes.data[i].first_primitive + k];
            json_t *object = json_array_get(primitives, now->source);
            if (json_is_object(object)) patch_primitive(g, object, i, now, base);
        }
    }
    for (uint32_t i = g->file ? g->file->meshes.count : 0; i < g->scene->meshes.count && g->result == FNL_OK; i++) {
        bool copy = g->scene->meshes.data[i].removed || i == g->scene->stage.mesh; /* or that baked decals are painted on */
        for (uint32_t k = 0; k < g->scene->painted.count; k++) copy = copy || g->scene->painted.data[k].own_mesh == i;
        if (!copy) glb_mesh(g, i);
        if (!copy && g->scene->meshes.data[i].primitive_count) {
            const struct scene_primitive *first = &g->scene->primitives.data[g->scene->meshes.data[i].first_primitive];
            if (first->mapping_count) glb_left_out(g, "the variants of materials of mesh %u", i);
        }
    }
}
