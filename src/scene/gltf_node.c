/* SPDX-License-Identifier: MIT */
/* Nodes: their transforms, what they carry, and the hierarchy (glTF 2.0, 3.5). */
#include "scene/gltf.h"

/* ---- transforms ---- */

/** Whether a matrix is a product of translation, rotation and scale: affine, with columns at right angles. */
static bool is_decomposable(const double matrix[16]) {
    float m[16];
    for (int i = 0; i < 16; i++) m[i] = (float)matrix[i];
    if (m[3] != 0 || m[7] != 0 || m[11] != 0 || fabsf(m[15] - 1) > 1e-5f) return false;
    vec3 x = vec3_make(m[0], m[1], m[2]), y = vec3_make(m[4], m[5], m[6]), z = vec3_make(m[8], m[9], m[10]);
    if (vec3_length(x) == 0 || vec3_length(y) == 0 || vec3_length(z) == 0) return false;
    x = vec3_normalize(x);
    y = vec3_normalize(y);
    z = vec3_normalize(z);
    return fabsf(vec3_dot(x, y)) < 1e-3f && fabsf(vec3_dot(y, z)) < 1e-3f && fabsf(vec3_dot(z, x)) < 1e-3f;
}

static void load_transform(struct gltf *g, json_t *object, const struct at *at, struct scene_node *node) {
    double values[16];
    gltf_doubles(g, object, at, "translation", 3, -FLT_MAX, FLT_MAX, node->translation);
    gltf_doubles(g, object, at, "scale", 3, -FLT_MAX, FLT_MAX, node->scale);
    gltf_exact_rotation(g, object, at, "rotation", node->rotation);
    scene_pose_node(node);
    if (!gltf_doubles(g, object, at, "matrix", 16, -FLT_MAX, FLT_MAX, values)) return;
    const struct at *here = AT_KEY(at, "matrix");
    if (json_object_get(object, "translation") || json_object_get(object, "rotation") || json_object_get(object, "scale"))
        gltf_warn(g, here, "stands beside translation, rotation or scale; the matrix is used");
    node->has_matrix = true;
    if (!is_decomposable(values))
        gltf_warn(g, here, "is no product of translation, rotation and scale; its affine part is used as it is");
    for (int i = 0; i < 12; i++) node->local_exact.m[i] = values[i / 3 * 4 + i % 3];
}

/* ---- what a node carries ---- */

static void load_weights(struct gltf *g, json_t *object, const struct at *at, struct scene_node *node) {
    json_t *weights = gltf_array(g, object, at, "weights", false);
    uint32_t count = gltf_count(weights);
    if (count == 0) return;
    const struct at *here = AT_KEY(at, "weights");
    if (node->mesh == SCENE_NONE) {
        gltf_warn(g, here, "there is no mesh that could have weights; they are ignored");
        return;
    }
    uint32_t targets = g->scene->meshes.data[node->mesh].morph_target_count;
    if (count != targets) {
        gltf_warn(g, here, "has %u weights for %u morph targets; they are ignored", count, targets);
        return;
    }
    float *values = gltf_keep(g, count, sizeof *values);
    for (uint32_t i = 0; values && i < count; i++) {
        json_t *value = json_array_get(weights, i);
        values[i] = json_is_number(value) ? (float)json_number_value(value) : NAN;
        if (isfinite(values[i])) continue;
        gltf_warn(g, AT_INDEX(here, i), "is not a finite number; 0 is used");
        values[i] = 0;
    }
    node->morph_weights = values;
}

static void load_node_extensions(struct gltf *g, json_t *object, const struct at *at, uint32_t index,
                                 struct scene_node *node) {
    struct gltf_extension_place place;
    json_t *extension = gltf_extension(object, at, "KHR_lights_punctual", &place);
    g->node_lights[index] = SCENE_NONE;
    if (extension) {
        if (!json_object_get(json_object_get(g->root, "extensions"), "KHR_lights_punctual"))
            gltf_warn(g, &place.extension, "the file has no /extensions/KHR_lights_punctual; it is ignored");
        g->node_lights[index] = gltf_index(g, extension, &place.extension, "light", true, g->light_count);
    }
    extension = gltf_extension(object, at, "KHR_node_visibility", &place);
    if (extension) g->hidden[index] = !gltf_bool(g, extension, &place.extension, "visible", true);
    extension = gltf_extension(object, at, "EXT_mesh_gpu_instancing", &place);
    if (extension) gltf_load_instances(g, extension, &place.extension, node);
}

static void load_node(struct gltf *g, json_t *object, const struct at *at, uint32_t index, struct scene_node *node) {
    node->name = gltf_name(g, object, at);
    node->extras = gltf_extras(g, object);
    load_transform(g, object, at, node);
    node->mesh = gltf_index(g, object, at, "mesh", false, g->mesh_count);
    node->camera = gltf_index(g, object, at, "camera", false, g->camera_count);
    node->skin = gltf_index(g, object, at, "skin", false, gltf_count(json_object_get(g->root, "skins")));
    if (json_object_get(object, "skin") && !json_object_get(object, "mesh"))
        gltf_warn(g, AT_KEY(at, "skin"), "there is no mesh that could have a skin; it is ignored");
    if (node->mesh == SCENE_NONE) node->skin = SCENE_NONE;
    load_weights(g, object, at, node);
    load_node_extensions(g, object, at, index, node);
    uint32_t lights = 255, views = 255;
    gltf_mask(g, object, at, "FNL_light_mask", &lights);
    gltf_mask(g, object, at, "FNL_view_mask", &views);
    node->unlit = (uint8_t)~lights;
    scene_use_light_masks(g->scene, lights == 0);
    node->unseen = (uint8_t)~views;
}

/* ---- hierarchy ---- */

/** Links children to their first parent. Backwards, because each child goes to the head of its parent's list. */
static void link_children(struct gltf *g, json_t *object, const struct at *at, uint32_t index) {
    struct scene_node *nodes = g->scene->nodes.data;
    json_t *children = gltf_array(g, object, at, "children", false);
    const struct at *here = AT_KEY(at, "children");
    for (uint32_t i = gltf_count(children); i-- > 0;) {
        uint32_t child = gltf_index_value(g, json_array_get(children, i), AT_INDEX(here, i), g->node_count);
        if (child == SCENE_NONE) continue;
        if (nodes[child].parent != SCENE_NONE) {
            gltf_warn(g, AT_INDEX(here, i), "node %u is already a child of node %u; it stays there", child,
                      nodes[child].parent);
            continue;
        }
        nodes[child].parent = index;
        nodes[child].next_sibling = nodes[index].first_child;
        nodes[index].first_child = child;
    }
}

static void unlink_node(struct scene_node *nodes, uint32_t index) {
    uint32_t *link = &nodes[nodes[index].parent].first_child;
    while (*link != index) link = &nodes[*link].next_sibling;
    *link = nodes[index].next_sibling;
    nodes[index].next_sibling = nodes[index].parent = SCENE_NONE;
}

/** Follows the parents of each node once; coming back to where the same walk was is a loop. It is cut at one node. */
static void cut_loops(struct gltf *g) {
    struct scene_node *nodes = g->scene->nodes.data;
    uint32_t *walk = gltf_scratch(g, g->node_count, sizeof *walk); /* number of the walk that saw a node; 0: none */
    for (uint32_t i = 0; walk && i < g->node_count; i++) {
        uint32_t at = i;
        while (at != SCENE_NONE && walk[at] == 0) {
            walk[at] = i + 1;
            at = nodes[at].parent;
        }
        if (at == SCENE_NONE || walk[at] != i + 1) continue;
        uint32_t member = at;
        do {
            const struct at *nodes_at = AT_KEY(&g->top, "nodes");
            gltf_warn(g, AT_INDEX(nodes_at, member), "is part of a loop of nodes; node %u is made a root", at);
            member = nodes[member].parent;
        } while (member != at);
        unlink_node(nodes, at);
    }
}

void gltf_load_nodes(struct gltf *g) {
    json_t *array = gltf_array(g, g->root, &g->top, "nodes", false);
    const struct at *at = AT_KEY(&g->top, "nodes");
    g->node_count = gltf_count(array);
    g->node_lights = gltf_scratch(g, g->node_count, sizeof *g->node_lights);
    g->hidden = gltf_scratch(g, g->node_count, sizeof *g->hidden);
    if (!array_reserve(g->host, &g->scene->nodes, g->node_count)) gltf_fail_memory(g);
    if (g->result != FNL_OK) return;
    for (uint32_t i = 0; i < g->node_count; i++) {
        g->node_lights[i] = SCENE_NONE;
        g->scene->nodes.data[i] = (struct scene_node){
            .name = "",
            .parent = SCENE_NONE,
            .first_child = SCENE_NONE,
            .next_sibling = SCENE_NONE,
            .rotation = {0, 0, 0, 1},
            .scale = {1, 1, 1},
            .local_exact = affine_identity(),
            .mesh = SCENE_NONE,
            .skin = SCENE_NONE,
            .camera = SCENE_NONE,
            .instance_count = 1,
            .linked = true,
            .generation = scene_take_generation(g->scene),
        };
    }
    g->scene->nodes.count = g->node_count;
    scene_structure_changed(g->scene);
    for (uint32_t i = 0; i < g->node_count && g->result == FNL_OK; i++) {
        json_t *object = gltf_element(g, array, at, i);
        if (!object) continue;
        load_node(g, object, AT_INDEX(at, i), i, &g->scene->nodes.data[i]);
        link_children(g, object, AT_INDEX(at, i), i);
    }
    if (g->result == FNL_OK) cut_loops(g);
}
