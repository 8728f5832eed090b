/* SPDX-License-Identifier: MIT */
/* MSFT_lod, with MSFT_screencoverage: levels of detail of nodes and materials. */
#include "scene/gltf.h"

enum { LEVELS_MOST = 16, IDS_MOST = 4 * LEVELS_MOST };

/** Level 0 is `first`. The number of levels, 1 if there is but the one. */
static uint32_t read_ids(struct gltf *g, json_t *object, const struct at *at, uint32_t first, uint32_t count, uint32_t out[LEVELS_MOST]) {
    struct gltf_extension_place place;
    json_t *extension = gltf_extension(object, at, "MSFT_lod", &place);
    uint32_t found = 1;
    out[0] = first;
    if (!extension) return 1;
    json_t *ids = gltf_array(g, extension, &place.extension, "ids", true);
    const struct at *here = AT_KEY(&place.extension, "ids");
    for (uint32_t i = 0; i < gltf_count(ids); i++) {
        if (found == LEVELS_MOST || i == IDS_MOST) {
            gltf_warn(g, AT_INDEX(here, i), "more than %d levels are not read; the others are left out", LEVELS_MOST);
            break;
        }
        const uint32_t id = gltf_index_value(g, json_array_get(ids, i), AT_INDEX(here, i), count);
        bool twice = false;
        for (uint32_t k = 0; k < found; k++) twice |= out[k] == id;
        if (twice) gltf_warn(g, AT_INDEX(here, i), "%u is a level already; it is ignored", id);
        if (id != SCENE_NONE && !twice) out[found++] = id;
    }
    return found;
}

/** Where each level ends, as a part of the screen's height: what the file says, then half of the one before, and the last level never. */
static void read_coverage(struct gltf *g, json_t *object, const struct at *at, uint32_t count, float out[LEVELS_MOST]) {
    const struct at *extras_at = AT_KEY(at, "extras"), *here = AT_KEY(extras_at, "MSFT_screencoverage");
    json_t *given = json_object_get(json_object_get(object, "extras"), "MSFT_screencoverage");
    uint32_t used = 0;
    for (; used < count && used < json_array_size(given); used++) {
        json_t *value = json_array_get(given, used);
        const double coverage = json_is_number(value) ? json_number_value(value) : -1;
        if (!(coverage >= 0 && coverage <= 1) || (used > 0 && coverage > (double)out[used - 1])) {
            gltf_warn(g, AT_INDEX(here, used), "is not a number from 0 to the one before; it and those that follow are ignored");
            break;
        }
        out[used] = (float)coverage;
    }
    for (uint32_t k = used; k < count; k++) out[k] = k + 1 == count ? 0 : k == 0 ? 0.5f : 0.5f * out[k - 1];
}

/* ---- nodes ---- */

/** Puts a level beside the first one. False (warned): it cannot be one. */
static bool place_level(struct gltf *g, uint32_t first, uint32_t level, const bool *is_level, const struct at *at) {
    struct scene_node *nodes = g->scene->nodes.data;
    if (is_level[level]) {
        gltf_warn(g, at, "node %u is a level of another node already; it is left out", level);
        return false;
    }
    for (uint32_t i = first; i != SCENE_NONE; i = nodes[i].parent)
        if (i == level) {
            gltf_warn(g, at, "node %u is above the node that it is a level of; it is left out", level);
            return false;
        }
    if (nodes[level].parent != SCENE_NONE) return true; /* it stands somewhere */
    nodes[level].parent = nodes[first].parent;
    if (nodes[first].parent == SCENE_NONE) return true;
    nodes[level].next_sibling = nodes[first].next_sibling;
    nodes[first].next_sibling = level;
    return true;
}

void gltf_load_levels(struct gltf *g) {
    json_t *array = json_object_get(g->root, "nodes");
    const struct at *nodes_at = AT_KEY(&g->top, "nodes");
    if (!gltf_uses(g, "MSFT_lod")) return;
    bool *is_level = gltf_scratch(g, g->node_count, sizeof *is_level);
    for (uint32_t i = 0; is_level && i < g->node_count && g->result == FNL_OK; i++) {
        json_t *object = json_array_get(array, i);
        const struct at *at = AT_INDEX(nodes_at, i);
        uint32_t ids[LEVELS_MOST], kept = 1;
        float coverage[LEVELS_MOST];
        if (!json_is_object(object)) continue;
        const uint32_t count = read_ids(g, object, at, i, g->node_count, ids);
        for (uint32_t k = 1; k < count; k++)
            if (place_level(g, i, ids[k], is_level, at)) {
                ids[kept++] = ids[k];
                is_level[ids[k]] = true;
            }
        if (kept == 1) continue;
        read_coverage(g, object, at, kept, coverage);
        if (!scene_add_levels(g->scene, ids, coverage, kept, false)) gltf_fail_memory(g);
    }
}

/* ---- materials: as levels of the nodes that show them ---- */

/** The first primitive whose material has the most levels says where they end. */
static uint32_t material_levels(struct gltf *g, const struct scene_mesh *mesh, float coverage[LEVELS_MOST]) {
    json_t *array = json_object_get(g->root, "materials");
    const struct at *materials_at = AT_KEY(&g->top, "materials");
    uint32_t most = 1;
    for (uint32_t i = 0; i < mesh->primitive_count; i++) {
        const uint32_t material = g->scene->primitives.data[mesh->first_primitive + i].material;
        uint32_t ids[LEVELS_MOST];
        if (material == SCENE_NONE || material >= g->material_count) continue;
        json_t *object = json_array_get(array, material);
        const struct at *at = AT_INDEX(materials_at, material);
        const uint32_t count = read_ids(g, object, at, material, g->material_count, ids);
        if (count <= most) continue;
        most = count;
        read_coverage(g, object, at, count, coverage);
    }
    return most;
}

/** A mesh of the same vertices with the materials of a level. */
static uint32_t level_mesh(struct gltf *g, uint32_t mesh, uint32_t level) {
    const struct scene_mesh source = g->scene->meshes.data[mesh];
    json_t *array = json_object_get(g->root, "materials");
    const struct at *materials_at = AT_KEY(&g->top, "materials");
    struct scene_primitive *primitives = gltf_scratch(g, source.primitive_count, sizeof *primitives);
    if (!primitives) return SCENE_NONE;
    memcpy(primitives, g->scene->primitives.data + source.first_primitive, sizeof *primitives * source.primitive_count);
    for (uint32_t i = 0; i < source.primitive_count; i++) {
        const uint32_t material = primitives[i].material;
        uint32_t ids[LEVELS_MOST];
        if (material == SCENE_NONE || material >= g->material_count) continue;
        const uint32_t count = read_ids(g, json_array_get(array, material), AT_INDEX(materials_at, material), material, g->material_count, ids);
        primitives[i].material = primitives[i].standard_material = ids[MIN(level, count - 1)];
    }
    const uint32_t made = scene_add_mesh(g->scene, source.name, primitives, source.primitive_count);
    if (made == SCENE_NONE) gltf_fail_memory(g);
    return made;
}

static void add_material_levels(struct gltf *g, uint32_t node, const uint32_t *meshes, uint32_t count, const float *coverage) {
    const mat4 identity = mat4_identity();
    uint32_t ids[LEVELS_MOST] = {node};
    for (uint32_t k = 1; k < count; k++) {
        ids[k] = scene_add_node(g->scene, g->scene->nodes.data[node].name, node, &identity, meshes[k]);
        if (ids[k] == SCENE_NONE) {
            gltf_fail_memory(g);
            return;
        }
        const struct scene_node *above = &g->scene->nodes.data[node];
        struct scene_node *made = &g->scene->nodes.data[ids[k]];
        made->skin = above->skin;
        made->instances = above->instances;
        made->instance_count = above->instance_count;
        made->linked = true;
    }
    if (!scene_add_levels(g->scene, ids, coverage, count, true)) gltf_fail_memory(g);
}

void gltf_load_material_levels(struct gltf *g) {
    const struct at *nodes_at = AT_KEY(&g->top, "nodes");
    const uint32_t node_count = g->node_count, mesh_count = g->scene->meshes.count;
    if (!gltf_uses(g, "MSFT_lod")) return;
    struct made { uint32_t count, meshes[LEVELS_MOST]; float coverage[LEVELS_MOST]; } *made = gltf_scratch(g, mesh_count, sizeof *made);
    for (uint32_t i = 0; made && i < node_count && g->result == FNL_OK; i++) {
        const uint32_t mesh = g->scene->nodes.data[i].mesh;
        if (mesh == SCENE_NONE) continue;
        struct made *m = &made[mesh];
        if (m->count == 0) m->count = material_levels(g, &g->scene->meshes.data[mesh], m->coverage);
        if (m->count == 1) continue;
        if (g->scene->meshes.data[mesh].morph_target_count) {
            gltf_warn(g, AT_INDEX(nodes_at, i), "the mesh has morph targets: of its materials' levels only the finest is shown");
            continue;
        }
        for (uint32_t k = 1; k < m->count && !m->meshes[k] && g->result == FNL_OK; k++) m->meshes[k] = level_mesh(g, mesh, k);
        if (g->result == FNL_OK) add_material_levels(g, i, m->meshes, m->count, m->coverage);
    }
}
