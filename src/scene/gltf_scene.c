/* SPDX-License-Identifier: MIT */
/* Which nodes are shown (glTF 2.0, 3.5.1; KHR_node_visibility), and EXT_mesh_gpu_instancing. */
#include "scene/gltf.h"

/* ---- scenes ---- */

/** Marks the tree below a root, without recursion: the parent links lead back up. */
static void show_tree(struct gltf *g, uint32_t root) {
    struct scene_node *nodes = g->scene->nodes.data;
    uint32_t i = root;
    for (;;) {
        g->in_scene[i] = true;
        nodes[i].hidden = g->hidden[i];
        nodes[i].active = !g->hidden[i] && !nodes[i].unchosen && (i == root || nodes[nodes[i].parent].active);
        if (nodes[i].first_child != SCENE_NONE) {
            i = nodes[i].first_child;
            continue;
        }
        while (i != root && nodes[i].next_sibling == SCENE_NONE) i = nodes[i].parent;
        if (i == root) return;
        i = nodes[i].next_sibling;
    }
}

/** What is in no shown scene is hidden, each tree by its topmost node; showing that brings it in. */
static void hide_the_rest(struct gltf *g) {
    struct scene_node *nodes = g->scene->nodes.data;
    for (uint32_t i = 0; i < g->node_count; i++)
        if (!g->in_scene[i]) nodes[i].hidden = g->hidden[i] || nodes[i].parent == SCENE_NONE;
}

void gltf_load_scenes(struct gltf *g) {
    json_t *array = gltf_array(g, g->root, &g->top, "scenes", false);
    const struct at *at = AT_KEY(&g->top, "scenes");
    uint32_t count = gltf_count(array), shown = gltf_index(g, g->root, &g->top, "scene", false, count);
    g->in_scene = gltf_scratch(g, g->node_count, sizeof *g->in_scene);
    if (g->result != FNL_OK) return;
    if (count == 0) { /* a library of parts: all of it is shown */
        for (uint32_t i = 0; i < g->node_count; i++)
            if (g->scene->nodes.data[i].parent == SCENE_NONE) show_tree(g, i);
        return;
    }
    if (shown == SCENE_NONE) shown = 0;
    for (uint32_t i = 0; i < count; i++) {
        json_t *object = gltf_element(g, array, at, i);
        if (!object) continue;
        const struct at *scene_at = AT_INDEX(at, i), *here = AT_KEY(scene_at, "nodes");
        json_t *roots = gltf_array(g, object, scene_at, "nodes", false);
        for (uint32_t k = 0; k < gltf_count(roots); k++) {
            uint32_t root = gltf_index_value(g, json_array_get(roots, k), AT_INDEX(here, k), g->node_count);
            if (root == SCENE_NONE) continue;
            if (g->scene->nodes.data[root].parent != SCENE_NONE)
                gltf_warn(g, AT_INDEX(here, k), "node %u is not a root; it is shown with its parents' transforms", root);
            if (i == shown && !g->in_scene[root]) show_tree(g, root);
        }
    }
    for (uint32_t i = 0; i < g->scene->levels.count; i++) { /* levels of roots stand in no list */
        const struct scene_levels *levels = &g->scene->levels.data[i];
        for (uint32_t k = 1; k < levels->count; k++)
            if (g->in_scene[levels->nodes[0]] && !g->in_scene[levels->nodes[k]] && g->scene->nodes.data[levels->nodes[k]].parent == SCENE_NONE)
                show_tree(g, levels->nodes[k]);
    }
    hide_the_rest(g);
}

/* ---- instances ---- */

/** One attribute of the instances. False: it is broken (warned), and the instances cannot be placed. */
static bool load_attribute(struct gltf *g, json_t *attributes, const struct at *at, const char *key, enum gltf_type type,
                           uint32_t *count, float **out) {
    *out = NULL;
    if (!json_object_get(attributes, key)) return true;
    const struct at *here = AT_KEY(at, key);
    uint32_t index = gltf_index(g, attributes, at, key, true, g->accessor_count);
    if (index == SCENE_NONE) return false;
    const struct gltf_accessor *accessor = &g->accessors[index];
    if (!gltf_accessor_readable(g, index, here)) return false;
    if (accessor->type != type || (*count && accessor->count != *count)) {
        gltf_warn(g, here, "does not have the type or number of elements that instances need; they are left out");
        return false;
    }
    *count = accessor->count;
    uint32_t components = gltf_type_components(type);
    if (!gltf_spend(g, here, (uint64_t)accessor->count * (components * sizeof(float) + sizeof(mat4)))) return false;
    *out = gltf_scratch(g, (uint64_t)accessor->count * components, sizeof(float));
    return *out && gltf_read_floats(g, index, here, *out);
}

static bool all_finite(const mat4 *matrix) {
    for (int i = 0; i < 16; i++)
        if (!isfinite(matrix->m[i])) return false;
    return true;
}

void gltf_load_instances(struct gltf *g, json_t *extension, const struct at *at, struct scene_node *node) {
    json_t *attributes = gltf_object(g, extension, at, "attributes", true);
    const struct at *here = AT_KEY(at, "attributes");
    if (!attributes) return;
    uint32_t count = 0;
    float *translations, *rotations, *scales;
    if (!load_attribute(g, attributes, here, "TRANSLATION", GLTF_VEC3, &count, &translations) ||
        !load_attribute(g, attributes, here, "ROTATION", GLTF_VEC4, &count, &rotations) ||
        !load_attribute(g, attributes, here, "SCALE", GLTF_VEC3, &count, &scales))
        return;
    if (count == 0) {
        gltf_warn(g, here, "has neither TRANSLATION, ROTATION nor SCALE; the mesh is shown once");
        return;
    }
    if (node->mesh == SCENE_NONE) {
        gltf_warn(g, at, "there is no mesh to repeat; it is ignored");
        return;
    }
    mat4 *instances = gltf_keep(g, count, sizeof *instances);
    uint32_t broken = 0;
    for (uint32_t i = 0; instances && i < count; i++) {
        const float *t = translations ? translations + (size_t)i * 3 : (const float[]){0, 0, 0};
        const float *r = rotations ? rotations + (size_t)i * 4 : (const float[]){0, 0, 0, 1};
        const float *s = scales ? scales + (size_t)i * 3 : (const float[]){1, 1, 1};
        instances[i] = mat4_from_trs(vec3_make(t[0], t[1], t[2]), quat_normalize((quat){r[0], r[1], r[2], r[3]}),
                                     vec3_make(s[0], s[1], s[2]));
        if (all_finite(&instances[i])) continue;
        instances[i] = mat4_scaling(vec3_make(0, 0, 0));
        broken++;
    }
    if (broken) gltf_warn(g, here, "%u instances have NaN or infinite values; they are not shown", broken);
    node->instances = instances;
    node->instance_count = instances ? count : 1;
}
