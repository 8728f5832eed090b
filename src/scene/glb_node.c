/* SPDX-License-Identifier: MIT */
/* Nodes of a file that is saved, with what stands on them but lights; skins and animations of what was added. */
#include "scene/glb.h"

/* ---- roots ---- */

json_t *glb_shown_scene(struct glb *g) {
    json_t *scenes = glb_array(g, g->root, "scenes"), *value = json_object_get(g->root, "scene");
    if (json_array_size(scenes) == 0) {
        glb_append(g, scenes, json_object());
        json_t *roots = g->file && g->node_count ? glb_array(g, json_array_get(scenes, 0), "nodes") : NULL;
        /* A file without scenes shows all that it has: now it has one. */
        for (uint32_t i = 0; roots && i < g->node_count; i++)
            if (g->file->nodes.data[i].parent == SCENE_NONE) glb_append(g, roots, json_integer((json_int_t)i));
    }
    const double number = json_is_number(value) ? json_number_value(value) : 0;
    const size_t shown = number >= 0 && number < (double)json_array_size(scenes) ? (size_t)number : 0;
    if (!value) glb_set(g, g->root, "scene", json_integer(0));
    if (!json_is_object(json_array_get(scenes, shown))) json_array_set_new(scenes, shown, json_object());
    return json_array_get(scenes, shown);
}

json_t *glb_roots(struct glb *g) { return glb_array(g, glb_shown_scene(g), "nodes"); }

static void remove_index(json_t *array, uint32_t index) {
    for (size_t i = json_array_size(array); i-- > 0;)
        if (json_is_number(json_array_get(array, i)) && json_number_value(json_array_get(array, i)) == (double)index) json_array_remove(array, i);
}

/* An empty array is no glTF. */
static void remove_if_empty(json_t *object, const char *key) {
    json_t *array = json_object_get(object, key);
    if (json_is_array(array) && json_array_size(array) == 0) json_object_del(object, key);
}

static bool is_identity(const mat4 *m) {
    const mat4 identity = mat4_identity();
    return memcmp(m, &identity, sizeof identity) == 0;
}

/* Writes nothing for the identity. */
static void add_matrix(struct glb *g, json_t *object, const struct affine *a) {
    const struct affine identity = affine_identity();
    double m[16] = {0};
    for (int i = 0; i < 12; i++) m[i / 3 * 4 + i % 3] = a->m[i];
    m[15] = 1;
    if (memcmp(a, &identity, sizeof identity) != 0) glb_set(g, object, "matrix", glb_doubles(m, 16));
}

void glb_add_root(struct glb *g, json_t *node, const mat4 *turn, const double place[3]) {
    json_t *roots = glb_roots(g); /* before there is another node */
    struct affine pose = affine_from_mat4(turn, no_origin);
    memcpy(pose.m + 9, place, 3 * sizeof *place);
    add_matrix(g, node, &pose);
    glb_append(g, roots, json_integer((json_int_t)glb_add(g, "nodes", node)));
}

/* ---- poses ---- */

static void set_trs(struct glb *g, json_t *object, const double translation[3], const double rotation[4], const double scale[3]) {
    json_object_del(object, "matrix");
    glb_set(g, object, "translation", glb_doubles(translation, 3));
    glb_set(g, object, "rotation", glb_doubles(rotation, 4));
    glb_set(g, object, "scale", glb_doubles(scale, 3));
}

static void set_matrix(struct glb *g, json_t *object, const struct affine *a) {
    json_object_del(object, "translation");
    json_object_del(object, "rotation");
    json_object_del(object, "scale");
    json_object_del(object, "matrix");
    add_matrix(g, object, a);
}

/* Rotation of a matrix whose columns are at right angles (Shepperd's method). */
static quat rotation_of(vec3 x, vec3 y, vec3 z) {
    const float trace = x.x + y.y + z.z;
    if (trace > 0) {
        const float s = 2 * sqrtf(trace + 1);
        return quat_normalize((quat){(y.z - z.y) / s, (z.x - x.z) / s, (x.y - y.x) / s, s / 4});
    }
    if (x.x > y.y && x.x > z.z) {
        const float s = 2 * sqrtf(1 + x.x - y.y - z.z);
        return quat_normalize((quat){s / 4, (y.x + x.y) / s, (z.x + x.z) / s, (y.z - z.y) / s});
    }
    if (y.y > z.z) {
        const float s = 2 * sqrtf(1 + y.y - x.x - z.z);
        return quat_normalize((quat){(y.x + x.y) / s, s / 4, (z.y + y.z) / s, (z.x - x.z) / s});
    }
    const float s = 2 * sqrtf(1 + z.z - x.x - y.y);
    return quat_normalize((quat){(z.x + x.z) / s, (z.y + y.z) / s, s / 4, (x.y - y.x) / s});
}

/* glTF 2.0, 3.5.2: what is animated has no matrix. */
static void set_decomposed(struct glb *g, json_t *object, const struct affine *a, uint32_t node) {
    const mat4 m = mat4_from_affine(a, no_origin);
    vec3 axes[3];
    double scale[3];
    for (int i = 0; i < 3; i++) {
        axes[i] = vec3_make(m.m[4 * i], m.m[4 * i + 1], m.m[4 * i + 2]);
        scale[i] = (double)vec3_length(axes[i]);
        axes[i] = vec3_normalize(axes[i]);
    }
    if (mat4_determinant3(&m) < 0) {
        scale[0] = -scale[0];
        axes[0] = vec3_scale(axes[0], -1);
    }
    if (fabsf(vec3_dot(axes[0], axes[1])) > 1e-3f || fabsf(vec3_dot(axes[1], axes[2])) > 1e-3f || fabsf(vec3_dot(axes[2], axes[0])) > 1e-3f)
        glb_left_out(g, "the shear of node %u, which is animated", node);
    const quat q = rotation_of(axes[0], axes[1], axes[2]);
    set_trs(g, object, a->m + 9, (const double[4]){(double)q.x, (double)q.y, (double)q.z, (double)q.w}, scale);
}

/* ---- nodes of the document ---- */

static void patch_node(struct glb *g, json_t *object, uint32_t index) {
    const struct scene_node *now = &g->scene->nodes.data[index], *base = &g->file->nodes.data[index];
    const bool moves = glb_animates_node(g, index, SCENE_PATH_TRANSLATION) || glb_animates_node(g, index, SCENE_PATH_ROTATION) ||
                       glb_animates_node(g, index, SCENE_PATH_SCALE);
    if (now->removed) {
        if (base->parent != SCENE_NONE && g->scene->nodes.data[base->parent].removed) return; /* it goes with that one */
        glb_shown_scene(g);
        json_t *scenes = json_object_get(g->root, "scenes"), *nodes = json_object_get(g->root, "nodes");
        for (uint32_t i = 0; i < gltf_count(scenes); i++) {
            remove_index(json_object_get(json_array_get(scenes, i), "nodes"), index);
            remove_if_empty(json_array_get(scenes, i), "nodes");
        }
        if (base->parent != SCENE_NONE) {
            remove_index(json_object_get(json_array_get(nodes, base->parent), "children"), index);
            remove_if_empty(json_array_get(nodes, base->parent), "children");
        }
        return;
    }
    if (now->placed && memcmp(&now->local_exact, &base->local_exact, sizeof now->local_exact) != 0) {
        if (moves)
            set_decomposed(g, object, &now->local_exact, index);
        else
            set_matrix(g, object, &now->local_exact);
    }
    if (now->hidden != base->hidden && !glb_animates_node(g, index, SCENE_PATH_VISIBLE)) {
        if (!now->hidden && now->parent == SCENE_NONE && json_array_size(json_object_get(g->root, "scenes")) > 0) {
            json_t *roots = glb_roots(g); /* it was in none, or is hidden there */
            remove_index(roots, index);
            glb_append(g, roots, json_integer((json_int_t)index));
        }
        glb_set(g, glb_extension(g, object, "KHR_node_visibility"), "visible", json_boolean(!now->hidden));
    }
    const uint32_t targets = now->mesh == SCENE_NONE ? 0 : g->scene->meshes.data[now->mesh].morph_target_count;
    const float *weights = base->morph_weights ? base->morph_weights : targets ? g->file->meshes.data[base->mesh].morph_weights : NULL;
    bool other = false;
    for (uint32_t i = 0; i < targets && now->morph_weights; i++) other = other || now->morph_weights[i] != (weights ? weights[i] : 0);
    if (other && !glb_animates_node(g, index, SCENE_PATH_WEIGHTS)) glb_set(g, object, "weights", glb_floats(now->morph_weights, targets));
    if (now->unseen != base->unseen) glb_set_extra(g, object, "FNL_view_mask", now->unseen ? json_integer(255 & ~now->unseen) : NULL);
    if (now->unlit != base->unlit) glb_set_extra(g, object, "FNL_light_mask", now->unlit ? json_integer(255 & ~now->unlit) : NULL);
    if (now->refuses != base->refuses) glb_set(g, glb_extension(g, object, "FNL_decal"), "receiverMask", json_integer(255 & ~now->refuses));
}

/* ---- cameras ---- */

static uint32_t camera_of(struct glb *g, const struct scene_camera *camera) {
    const fnl_camera *c = &camera->camera;
    json_t *object = json_object();
    const float half = c->vertical_extent / 2;
    if (c->pixel_aspect != 1) glb_left_out(g, "the pixel aspect of camera '%.60s'", camera->name);
    if (c->shift.x != 0 || c->shift.y != 0) glb_left_out(g, "the shift of camera '%.60s'", camera->name);
    if (c->view_mask != 255) glb_set_extra(g, object, "FNL_view_mask", json_integer((json_int_t)c->view_mask));
    glb_set(g, object, "type", json_string(c->orthographic ? "orthographic" : "perspective"));
    if (c->orthographic) {
        json_t *lens = glb_object(g, object, "orthographic");
        glb_set(g, lens, "xmag", glb_float(half));
        glb_set(g, lens, "ymag", glb_float(half));
        glb_set(g, lens, "znear", glb_float(c->near_distance));
        glb_set(g, lens, "zfar", glb_float(c->far_distance));
    } else {
        json_t *lens = glb_object(g, object, "perspective");
        glb_set(g, lens, "yfov", glb_float(c->vertical_fov));
        glb_set(g, lens, "znear", glb_float(c->near_distance));
    }
    glb_set_name(g, object, camera->name, camera->extras);
    return glb_add(g, "cameras", object);
}

/* Those that stand on no node. */
static void save_cameras(struct glb *g) {
    for (uint32_t i = 0; i < g->scene->cameras.count && g->result == FNL_OK; i++) {
        const struct scene_camera *camera = &g->scene->cameras.data[i];
        if (camera->removed || camera->node != SCENE_NONE) continue;
        const vec3 forward = vec3_normalize(vec3_sub(camera->camera.target, camera->camera.position));
        const mat4 pose = glb_turn(forward, light_up(forward, camera->camera.up));
        json_t *node = json_object();
        glb_set_name(g, node, camera->name, NULL);
        glb_set(g, node, "camera", json_integer((json_int_t)camera_of(g, camera)));
        glb_add_root(g, node, &pose, camera->place);
    }
}

/* ---- skins ---- */

static uint32_t skin_of(struct glb *g, uint32_t index) {
    const struct scene_skin *skin = &g->scene->skins.data[index];
    if (g->skins[index] != SCENE_NONE || skin->joint_count == 0) return g->skins[index];
    json_t *object = json_object(), *joints = glb_array(g, object, "joints");
    for (uint32_t i = 0; i < skin->joint_count; i++) {
        const uint32_t joint = g->nodes[skin->joints[i]];
        if (joint == SCENE_NONE) glb_left_out(g, "joint %u of skin %u, which was removed", i, index);
        glb_append(g, joints, json_integer(joint == SCENE_NONE ? 0 : (json_int_t)joint));
    }
    glb_set_name(g, object, skin->name, NULL);
    glb_set(g, object, "inverseBindMatrices", json_integer((json_int_t)glb_add_accessor(g, skin->inverse_bind, skin->joint_count, GLTF_FLOAT, GLTF_MAT4, 0)));
    return g->skins[index] = glb_add(g, "skins", object);
}

/* ---- nodes that were added ---- */

static bool is_added(const struct glb *g, uint32_t index) {
    return !g->scene->nodes.data[index].removed && (!g->file || index >= g->file->nodes.count);
}

/* In place of what the node's extras said. */
static void write_masks(struct glb *g, json_t *object, const struct scene_node *node) {
    glb_set_extra(g, object, "FNL_view_mask", node->unseen ? json_integer(255 & ~node->unseen) : NULL);
    glb_set_extra(g, object, "FNL_light_mask", node->unlit ? json_integer(255 & ~node->unlit) : NULL);
    if (node->refuses) glb_set(g, glb_extension(g, object, "FNL_decal"), "receiverMask", json_integer(255 & ~node->refuses));
}

/* Instances as nodes of their own: decomposed they would not be the same to the bit. */
static void add_instances(struct glb *g, json_t *object, const struct scene_node *node) {
    json_t *children = glb_array(g, object, "children");
    for (uint32_t i = 0; i < node->instance_count && g->result == FNL_OK; i++) {
        json_t *instance = json_object();
        glb_set(g, instance, "mesh", json_integer((json_int_t)glb_mesh(g, node->mesh)));
        if (!is_identity(&node->instances[i])) glb_set(g, instance, "matrix", glb_floats(node->instances[i].m, 16));
        write_masks(g, instance, node);
        glb_append(g, children, json_integer((json_int_t)glb_add(g, "nodes", instance)));
    }
}

static uint32_t shown_mesh(const struct glb *g, uint32_t index) {
    for (uint32_t i = 0; i < g->scene->painted.count; i++)
        if (g->scene->painted.data[i].node == index) return g->scene->painted.data[i].mesh;
    return g->scene->nodes.data[index].mesh;
}

static void write_node(struct glb *g, json_t *object, uint32_t index) {
    const struct scene_node *node = &g->scene->nodes.data[index];
    const uint32_t mesh = shown_mesh(g, index);
    glb_set_name(g, object, node->name, node->extras);
    if (node->has_matrix || node->placed) {
        add_matrix(g, object, &node->local_exact);
    } else {
        set_trs(g, object, node->translation, node->rotation, node->scale);
    }
    if (mesh != SCENE_NONE && !node->instances) {
        const uint32_t targets = g->scene->meshes.data[mesh].morph_target_count, skin = node->skin == SCENE_NONE ? SCENE_NONE : skin_of(g, node->skin);
        glb_set(g, object, "mesh", json_integer((json_int_t)glb_mesh(g, mesh)));
        if (skin != SCENE_NONE) glb_set(g, object, "skin", json_integer((json_int_t)skin));
        if (node->morph_weights && targets) glb_set(g, object, "weights", glb_floats(node->morph_weights, targets));
    }
    for (uint32_t i = 0; i < g->scene->cameras.count; i++)
        if (g->scene->cameras.data[i].node == index) glb_set(g, object, "camera", json_integer((json_int_t)camera_of(g, &g->scene->cameras.data[i])));
    if (node->hidden) glb_set(g, glb_extension(g, object, "KHR_node_visibility"), "visible", json_false());
    write_masks(g, object, node);
}

static void link_children(struct glb *g, uint32_t index) {
    const struct scene_node *nodes = g->scene->nodes.data;
    json_t *object = json_array_get(json_object_get(g->root, "nodes"), g->nodes[index]), *children = NULL;
    for (uint32_t child = nodes[index].first_child; child != SCENE_NONE; child = nodes[child].next_sibling) {
        if (!is_added(g, child)) continue;
        if (!children) children = glb_array(g, object, "children");
        glb_append(g, children, json_integer((json_int_t)g->nodes[child]));
    }
}

static void add_nodes(struct glb *g) {
    const struct scene_node *nodes = g->scene->nodes.data;
    const uint32_t count = g->scene->nodes.count;
    bool any = false;
    for (uint32_t i = 0; i < count; i++) {
        if (!is_added(g, i)) continue;
        any = true;
        g->nodes[i] = glb_add(g, "nodes", json_object());
        if (nodes[i].parent == SCENE_NONE && g->result == FNL_OK) glb_append(g, glb_roots(g), json_integer((json_int_t)g->nodes[i]));
    }
    if (!any) return;
    json_t *array = json_object_get(g->root, "nodes");
    for (uint32_t i = 0; i < count && g->result == FNL_OK; i++)
        if (is_added(g, i)) write_node(g, json_array_get(array, g->nodes[i]), i);
    for (uint32_t i = 0; i < count && g->result == FNL_OK; i++)
        if (!nodes[i].removed && g->nodes[i] != SCENE_NONE) link_children(g, i);
    for (uint32_t i = 0; i < count && g->result == FNL_OK; i++) /* behind all nodes, so that those keep their order */
        if (is_added(g, i) && nodes[i].instances && nodes[i].mesh != SCENE_NONE) add_instances(g, json_array_get(array, g->nodes[i]), &nodes[i]);
}

/* ---- animations that were added ---- */

static bool write_channel(struct glb *g, const struct scene_channel *c, json_t *samplers, json_t *channels) {
    static const char *const paths[] = {"translation", "rotation", "scale", "weights"}, *const ways[] = {"STEP", "LINEAR", "CUBICSPLINE"};
    const uint32_t node = c->path <= SCENE_PATH_WEIGHTS ? g->nodes[c->node] : SCENE_NONE;
    if (node == SCENE_NONE || c->first_weight || c->key_count == 0) return false;
    const enum gltf_type type = c->path == SCENE_PATH_ROTATION ? GLTF_VEC4 : c->path == SCENE_PATH_WEIGHTS ? GLTF_SCALAR : GLTF_VEC3;
    const uint32_t elements = c->key_count * (c->interpolation == SCENE_INTERPOLATION_CUBIC ? 3 : 1) * (c->path == SCENE_PATH_WEIGHTS ? c->width : 1);
    const uint32_t input = glb_add_accessor(g, c->times, c->key_count, GLTF_FLOAT, GLTF_SCALAR, 0);
    json_t *times = json_array_get(json_object_get(g->root, "accessors"), input);
    glb_set(g, times, "min", glb_floats(&c->times[0], 1));
    glb_set(g, times, "max", glb_floats(&c->times[c->key_count - 1], 1));
    const uint32_t output = glb_add_accessor(g, c->values, elements, GLTF_FLOAT, type, 0);
    const uint32_t sampler = glb_append(g, samplers, json_pack("{s:i,s:i,s:s}", "input", (int)input, "output", (int)output, "interpolation", ways[c->interpolation]));
    glb_append(g, channels, json_pack("{s:i,s:{s:i,s:s}}", "sampler", (int)sampler, "target", "node", (int)node, "path", paths[c->path]));
    return true;
}

/* Removes animations of the document, last first; nothing refers to them by index. */
static void drop_animations(struct glb *g) {
    json_t *array = json_object_get(g->root, "animations");
    for (uint32_t i = g->file ? g->file->animations.count : 0; i > 0; i--)
        if (g->scene->animations.data[i - 1].removed) json_array_remove(array, i - 1);
    if (array && json_array_size(array) == 0) json_object_del(g->root, "animations");
}

static void drop_cameras(struct glb *g) {
    for (uint32_t i = 0; g->file && i < g->file->cameras.count; i++)
        if (g->scene->cameras.data[i].removed) json_object_del(json_array_get(json_object_get(g->root, "nodes"), g->file->cameras.data[i].node), "camera");
}

static void save_animations(struct glb *g) {
    for (uint32_t i = g->file ? g->file->animations.count : 0; i < g->scene->animations.count && g->result == FNL_OK; i++) {
        const struct scene_animation *animation = &g->scene->animations.data[i];
        if (animation->removed) continue;
        json_t *object = json_object(), *samplers = glb_array(g, object, "samplers"), *channels = glb_array(g, object, "channels");
        uint32_t missing = 0;
        glb_set_name(g, object, animation->name, animation->extras);
        for (uint32_t k = 0; k < animation->channel_count && g->result == FNL_OK; k++) missing += !write_channel(g, &animation->channels[k], samplers, channels);
        if (missing) glb_left_out(g, "%u channels of animation %u, which set no pose", missing, i);
        if (json_array_size(channels) > 0)
            glb_add(g, "animations", object);
        else
            json_decref(object);
    }
}

void glb_save_nodes(struct glb *g) {
    json_t *array = json_object_get(g->root, "nodes");
    for (uint32_t i = 0; i < g->node_count && g->result == FNL_OK; i++)
        if (json_is_object(json_array_get(array, i))) patch_node(g, json_array_get(array, i), i);
    drop_cameras(g);
    add_nodes(g);
    if (g->result == FNL_OK) drop_animations(g);
    if (g->result == FNL_OK) save_animations(g);
    if (g->result == FNL_OK) save_cameras(g);
}
