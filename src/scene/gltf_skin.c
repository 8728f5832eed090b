/* SPDX-License-Identifier: MIT */
/* Joints and weights of vertices, and skins (glTF 2.0, 3.7.3). */
#include "scene/gltf.h"

/* ---- joints and weights of a primitive ---- */

/** What was wrong with one set, so that each fault is told once. */
struct set_faults {
    uint32_t negative, unnormalised, duplicate;
};

/** Copies the selected vertices of one set into the primitive's arrays, which have `width` joints per vertex. */
static bool copy_set(struct gltf *g, const struct at *at, const struct gltf_attributes *attributes, uint32_t set,
                     const struct gltf_selection *selection, uint32_t width, uint16_t *joints, float *weights) {
    uint32_t joint_accessor = attributes->accessor[GLTF_JOINTS][set],
             weight_accessor = attributes->accessor[GLTF_WEIGHTS][set];
    size_t total = (size_t)g->accessors[joint_accessor].count * 4;
    if (!gltf_spend(g, at, total * 8)) return false;
    uint32_t *all_joints = host_allocate(g->host, total * sizeof *all_joints);
    float *all_weights = host_allocate(g->host, total * sizeof *all_weights);
    if (!all_joints || !all_weights) gltf_fail_memory(g);
    bool good = all_joints && all_weights && gltf_read_uints(g, joint_accessor, at, all_joints) &&
                gltf_read_floats(g, weight_accessor, at, all_weights);
    for (uint32_t i = 0; good && i < selection->count; i++) {
        size_t from = (size_t)(selection->source ? selection->source[i] : i) * 4, to = (size_t)i * width + set * 4;
        for (uint32_t k = 0; k < 4; k++) {
            joints[to + k] = (uint16_t)all_joints[from + k];
            weights[to + k] = all_weights[from + k];
        }
    }
    host_free(g->host, all_joints, total * sizeof *all_joints);
    host_free(g->host, all_weights, total * sizeof *all_weights);
    return good;
}

/** Makes one vertex's weights sum up to 1 and notes what was wrong. */
static void mend_vertex(uint32_t width, uint16_t *joints, float *weights, struct set_faults *faults,
                        struct gltf_primitive_joints *used) {
    float sum = 0;
    for (uint32_t k = 0; k < width; k++) {
        uint32_t set = k / 4;
        for (uint32_t before = 0; before < k; before++)
            if (weights[k] != 0 && weights[before] != 0 && joints[k] == joints[before]) {
                faults[set].duplicate++;
                break;
            }
        used->highest[set] = MAX(used->highest[set], joints[k]);
        if (weights[k] != 0) used->highest_used[set] = MAX(used->highest_used[set], joints[k]);
    }
    for (uint32_t k = 0; k < width; k++) {
        if (!(weights[k] >= 0) || !isfinite(weights[k])) {
            faults[k / 4].negative++;
            weights[k] = 0;
        }
        if (weights[k] == 0) joints[k] = 0;
        sum += weights[k];
    }
    bool normalised = fabsf(sum - 1) < 0.005f * (float)width; /* each weight may be rounded to 1/255 */
    for (uint32_t set = 0; set < width / 4 && !normalised; set++) faults[set].unnormalised++;
    if (sum > 0 && isfinite(sum)) {
        for (uint32_t k = 0; k < width; k++) weights[k] /= sum;
    } else {
        for (uint32_t k = 0; k < width; k++) weights[k] = k == 0;
    }
}

static void report_faults(struct gltf *g, const struct at *at, uint32_t set, const struct set_faults *faults) {
    char joints[32], weights[32];
    snprintf(joints, sizeof joints, "JOINTS_%u", set);
    snprintf(weights, sizeof weights, "WEIGHTS_%u", set);
    if (faults->duplicate)
        gltf_warn(g, AT_KEY(at, joints), "%u times a vertex names a joint twice; the weights add up", faults->duplicate);
    if (faults->negative)
        gltf_warn(g, AT_KEY(at, weights), "%u weights are negative or not finite; 0 is used", faults->negative);
    if (faults->unnormalised)
        gltf_warn(g, AT_KEY(at, weights), "the weights of %u vertices do not add up to 1; they are normalised",
                  faults->unnormalised);
}

bool gltf_load_joints(struct gltf *g, const struct at *at, const struct gltf_attributes *attributes,
                      const struct gltf_selection *selection, struct scene_primitive *out,
                      struct gltf_primitive_joints *joints_used) {
    uint32_t sets = 0;
    while (sets < GLTF_SET_MAX && attributes->accessor[GLTF_JOINTS][sets] != SCENE_NONE &&
           attributes->accessor[GLTF_WEIGHTS][sets] != SCENE_NONE)
        sets++;
    for (uint32_t set = sets; set < GLTF_SET_MAX; set++)
        if ((attributes->accessor[GLTF_JOINTS][set] == SCENE_NONE) !=
            (attributes->accessor[GLTF_WEIGHTS][set] == SCENE_NONE))
            gltf_warn(g, at, "of JOINTS_%u and WEIGHTS_%u only one can be used; it is left out", set, set);
    if (sets == 0) return true;
    uint32_t width = sets * 4;
    if (!gltf_spend(g, at, (uint64_t)selection->count * width * 6)) return false;
    uint16_t *joints = gltf_keep(g, (uint64_t)selection->count * width, sizeof *joints);
    float *weights = joints ? gltf_keep(g, (uint64_t)selection->count * width, sizeof *weights) : NULL;
    for (uint32_t set = 0; set < sets && weights; set++)
        if (!copy_set(g, at, attributes, set, selection, width, joints, weights)) weights = NULL;
    if (!weights) return false;
    struct set_faults faults[GLTF_SET_MAX] = {{0}};
    joints_used->set_count = sets;
    for (uint32_t i = 0; i < selection->count; i++)
        mend_vertex(width, joints + (size_t)i * width, weights + (size_t)i * width, faults, joints_used);
    for (uint32_t set = 0; set < sets; set++) report_faults(g, at, set, &faults[set]);
    out->joints = joints;
    out->weights = weights;
    out->joint_count = width;
    return true;
}

/* ---- skins ---- */

static void load_inverse_bind(struct gltf *g, json_t *object, const struct at *at, uint32_t count, mat4 *matrices) {
    const struct at *here = AT_KEY(at, "inverseBindMatrices");
    uint32_t index = gltf_index(g, object, at, "inverseBindMatrices", false, g->accessor_count);
    if (index == SCENE_NONE || !gltf_accessor_readable(g, index, here)) return;
    const struct gltf_accessor *accessor = &g->accessors[index];
    if (accessor->view != SCENE_NONE && g->views[accessor->view].stride)
        gltf_warn(g, here, "the buffer view of these matrices must not have a byteStride; it is used all the same");
    if (accessor->type != GLTF_MAT4 || accessor->component != GLTF_FLOAT || accessor->count < count) {
        gltf_warn(g, here, "is not MAT4 of FLOAT with at least %u elements; identity matrices are used", count);
        return;
    }
    if (!gltf_spend(g, here, (uint64_t)accessor->count * sizeof(mat4))) return;
    mat4 *values = gltf_scratch(g, accessor->count, sizeof *values);
    if (!values || !gltf_read_floats(g, index, here, values->m)) return;
    uint32_t broken = 0, projective = 0;
    for (uint32_t i = 0; i < count; i++) {
        bool finite = true;
        for (int k = 0; k < 16; k++) finite &= isfinite(values[i].m[k]) != 0;
        if (!finite) {
            broken++;
            continue;
        }
        matrices[i] = values[i];
        float *m = matrices[i].m;
        projective += m[3] != 0 || m[7] != 0 || m[11] != 0 || m[15] != 1;
        m[3] = m[7] = m[11] = 0;
        m[15] = 1;
    }
    if (projective)
        gltf_warn(g, here, "%u matrices have a fourth row other than 0, 0, 0, 1; their affine part is used", projective);
    if (broken) gltf_warn(g, here, "%u matrices have NaN or infinite values; identity matrices are used", broken);
}

static void load_skin(struct gltf *g, json_t *object, const struct at *at, struct scene_skin *skin) {
    skin->name = gltf_name(g, object, at);
    gltf_index(g, object, at, "skeleton", false, g->node_count); /* only a hint, but it must exist */
    json_t *array = gltf_array(g, object, at, "joints", true);
    uint32_t count = gltf_count(array);
    uint32_t *joints = gltf_keep(g, count, sizeof *joints);
    mat4 *inverse_bind = joints ? gltf_keep(g, count, sizeof *inverse_bind) : NULL;
    if (!inverse_bind) return;
    const struct at *here = AT_KEY(at, "joints");
    for (uint32_t i = 0; i < count; i++) {
        joints[i] = gltf_index_value(g, json_array_get(array, i), AT_INDEX(here, i), g->node_count);
        inverse_bind[i] = mat4_identity();
        if (joints[i] == SCENE_NONE) return; /* joint_count stays 0: nobody can use the skin */
    }
    load_inverse_bind(g, object, at, count, inverse_bind);
    skin->joints = joints;
    skin->inverse_bind = inverse_bind;
    skin->joint_count = count;
}

/** Whether a node's mesh fits its skin; complains about joints that the skin does not have. */
static bool skin_fits(struct gltf *g, const struct scene_node *node, const struct at *node_at) {
    const struct scene_skin *skin = &g->scene->skins.data[node->skin];
    const struct scene_mesh *mesh = &g->scene->meshes.data[node->mesh];
    bool fits = skin->joint_count > 0;
    if (!fits) gltf_warn(g, AT_KEY(node_at, "skin"), "skin %u is broken; the mesh is shown without it", node->skin);
    for (uint32_t i = 0; i < mesh->primitive_count && skin->joint_count > 0; i++) {
        const struct gltf_primitive_joints *used = &g->primitive_joints.data[mesh->first_primitive + i];
        for (uint32_t set = 0; set < used->set_count; set++) {
            if (used->highest[set] < skin->joint_count) continue;
            char name[32];
            snprintf(name, sizeof name, "JOINTS_%u", set);
            bool matters = used->highest_used[set] >= skin->joint_count;
            const struct at *meshes_at = AT_KEY(&g->top, "meshes"), *mesh_at = AT_INDEX(meshes_at, node->mesh);
            const struct at *primitives_at = AT_KEY(mesh_at, "primitives"),
                            *primitive_at = AT_INDEX(primitives_at, used->source);
            const struct at *attributes_at = AT_KEY(primitive_at, "attributes");
            gltf_warn(g, AT_KEY(attributes_at, name), "names joint %u, but skin %u has %u joints; %s", used->highest[set],
                      node->skin, skin->joint_count, matters ? "the mesh is shown without it there" : "its weight is 0");
            fits &= !matters;
        }
    }
    return fits;
}

void gltf_load_skins(struct gltf *g) {
    json_t *array = gltf_array(g, g->root, &g->top, "skins", false);
    const struct at *at = AT_KEY(&g->top, "skins"), *nodes_at = AT_KEY(&g->top, "nodes");
    g->skin_count = gltf_count(array);
    for (uint32_t i = 0; i < g->skin_count && g->result == FNL_OK; i++) {
        struct scene_skin skin = {.name = ""};
        json_t *object = gltf_element(g, array, at, i);
        if (object) load_skin(g, object, AT_INDEX(at, i), &skin);
        if (!array_push(g->host, &g->scene->skins, skin)) gltf_fail_memory(g);
    }
    for (uint32_t i = 0; i < g->node_count && g->result == FNL_OK; i++) {
        struct scene_node *node = &g->scene->nodes.data[i];
        if (node->skin == SCENE_NONE) continue;
        const struct at *here = AT_INDEX(nodes_at, i);
        if (!skin_fits(g, node, here)) {
            node->skin = SCENE_NONE;
            continue;
        }
        const struct scene_skin *skin = &g->scene->skins.data[node->skin];
        uint32_t outside = 0;
        for (uint32_t k = 0; k < skin->joint_count; k++) outside += !g->in_scene[skin->joints[k]];
        if (outside && g->in_scene[i])
            gltf_warn(g, here, "%u joints of its skin are not part of the scene; they move it all the same", outside);
    }
}
